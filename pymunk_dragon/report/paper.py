"""The paper's tables 1 to 3, for any march."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_DOWN, Decimal

import numpy as np

from pymunk_dragon.march import March
from pymunk_dragon.report.summary import TABLE_TIMES

__all__ = ["cut", "paper_tables"]

# What is this close below a decimal number is that number: the error of 8.8 m, 1 m/s or 0 m as the model has them.
HAIR = 1e-11
THOUSANDTH = Decimal("0.001")


def paper_tables(march: March, impact_time: float | None) -> str:
    """Positions and speeds of seven handles at six times, and at the first contact if there is one.

    Every value is cut after its third decimal, not rounded, as in the paper's tables.

    Parameters
    ----------
    march : March
        Whose handles.
    impact_time : float or None
        s.

    Raises
    ------
    UnreachableError
        If a handle has no place at one of the times.
    """
    handles = march.dragon.representatives
    states = march.at(TABLE_TIMES)
    times = [f"{time:g} s" for time in TABLE_TIMES]
    coordinates = states.positions[:, handles].reshape(len(times), -1).T
    names = [f"{handle} {axis}" for handle in handles for axis in "xy"]
    lines = _table("Table 1: positions, m", times, names, coordinates)
    lines += _table("Table 2: speeds, m/s", times, handles, states.speeds[:, handles].T)
    if impact_time is not None:
        states = march.at([impact_time])
        values = np.column_stack([states.positions[0, handles], states.speeds[0, handles]])
        title = f"Table 3: at the first contact, {impact_time:.9f} s"
        lines += _table(title, ["x (m)", "y (m)", "speed (m/s)"], handles, values)
    return "\n".join(lines[:-1])


def cut(value: float) -> str:
    """A number without what follows its third decimal."""
    short = Decimal(value + math.copysign(HAIR, value)).quantize(THOUSANDTH, ROUND_DOWN)
    return str(abs(short) if short == 0 else short)


def _table(title: str, heads: Sequence[str], names: Sequence[object], rows: np.ndarray) -> list[str]:
    cells = [["handle", *heads], *([str(name), *map(cut, row)] for name, row in zip(names, rows.tolist(), strict=True))]
    return [title, *("".join(f"{cell:>12}" for cell in row) for row in cells), ""]
