"""Physics engines under one interface, for `engines.py`: each module has one engine, as `Engine`.

An engine is built from a `Scene`. The driver is the same in all of them: before each step, head and
anchors are sent to their next places, by their velocities where the engine has kinematic bodies
with one.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np

from pymunk_dragon import Dragon
from pymunk_dragon._arrays import Array

DRIVES = ("head", "rails", "pinned")

# kg/m^2: density of the planks, with which all engines find the masses that the dragon has.
DENSITY = 20.0


@dataclass(frozen=True)
class Scene:
    """What an engine is given: a dragon at its start, and what moves it.

    Attributes
    ----------
    dragon : Dragon
        The benches.
    begin : float
        Time of the start, s.
    step : float
        Length of a step, s.
    drag : float
        Rate at which the ground slows benches down, 1/s; 0 for none.
    rail : float
        Distance of a rear hole from its anchor, m; 0 if it is pinned there.
    start : ndarray, shape (2, N, 3)
        Poses and velocities of the benches at the start: m, m, rad and per s.
    head : ndarray, shape (T + 1, 3)
        Poses of the head at the start and after each step.
    anchors : ndarray, shape (T + 1, A, 2)
        Anchors, m: one for the rear hole of each bench but the head, or none.
    iterations : int
        Iterations, or substeps, of the engine in a step; 0 for those in its `settings`.
    """

    dragon: Dragon
    begin: float
    step: float
    drag: float
    rail: float
    start: Array
    head: Array
    anchors: Array
    iterations: int = 0

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.head) - 1

    def write(self, path: Path) -> None:
        """Write a line of JSON, and then all arrays as numbers of 64 bits, for other languages."""
        header = {
            "step": self.step,
            "steps": self.steps,
            "drag": self.drag,
            "rail": self.rail,
            "iterations": self.iterations,
            "anchors": self.anchors.shape[1],
            "density": DENSITY,
            "lengths": self.dragon.lengths.tolist(),
            "widths": self.dragon.widths.tolist(),
            "spacings": self.dragon.spacings.tolist(),
        }
        arrays = self.start, self.head, self.anchors
        numbers = np.concatenate([array.ravel() for array in arrays]).astype("<f8")
        path.write_bytes(json.dumps(header).encode() + b"\n" + numbers.tobytes())


class Adapter(Protocol):
    """One engine with a scene."""

    # Name and version of the engine, and settings other than the step.
    name: ClassVar[str]
    settings: ClassVar[str]
    # s: length of a step in each drive that the engine has joints for.
    substeps: ClassVar[dict[str, float]]
    # Pairs of benches that the engine reported as touching in the last step.
    touched: list[tuple[int, int]]

    def __init__(self, scene: Scene) -> None: ...

    def move(self, number: int) -> None:
        """Have the kinematic bodies move to the places of that number in the next step."""

    def step(self) -> None:
        """Make a step."""

    def poses(self) -> Array:
        """Poses (N, 3) of the benches: m, m, rad."""
