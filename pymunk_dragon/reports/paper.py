"""Tables 1 to 3 of the paper, for any march."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_DOWN, Decimal

import numpy as np

from pymunk_dragon.model.march import March
from pymunk_dragon.reports.summary import TABLE_TIMES

__all__ = ["paper_tables", "truncate"]

# m or m/s: added to magnitudes before truncation, so that 8.8 m or 1 m/s with a rounding error keep their digits.
ROUNDING_TOLERANCE = 1e-11
# Last decimal of the tables, mm or mm/s.
THOUSANDTH = Decimal("0.001")


def paper_tables(march: March, impact_time: float | None) -> str:
    """Positions and speeds of seven handles at six times, and at the first contact if there is one.

    Values are truncated to three decimals, not rounded, as in the paper.

    Parameters
    ----------
    march : March
        March with the handles.
    impact_time : float or None
        Time of the first contact, s; None for no contact.

    Raises
    ------
    UnreachableError
        If a handle would be beyond the end of the curve at one of the times.
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


def truncate(value: float) -> str:
    """`value` truncated to three decimals."""
    truncated = Decimal(value + math.copysign(ROUNDING_TOLERANCE, value)).quantize(THOUSANDTH, ROUND_DOWN)
    return str(abs(truncated) if truncated == 0 else truncated)


def _table(title: str, labels: Sequence[str], names: Sequence[object], rows: np.ndarray) -> list[str]:
    cells = [
        ["handle", *labels],
        *([str(name), *map(truncate, row)] for name, row in zip(names, rows.tolist(), strict=True)),
    ]
    return [title, *("".join(f"{cell:>12}" for cell in row) for row in cells), ""]
