"""Sweeps: a quantity of a dragon at many values of its parameters, in parallel.

The points come from `axes`, and what is computed at each of them from `quantities`. `computation` sends batches of
points to `workers`, which call `evaluation`, and writes what they return to a `journal`. A `table` or a `figure` is
made of the journal in the end. `refinement` adds points where what is discrete changes.
"""

from __future__ import annotations

from pymunk_dragon.sweeps.quantities import QUANTITIES
from pymunk_dragon.sweeps.result import Sweep
from pymunk_dragon.sweeps.sweep import sweep

__all__ = ["QUANTITIES", "Sweep", "sweep"]
