"""Text that several commands and results print."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any


def table(heads: str, formats: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    """Lines of a table: the heads, and the rows with one format specification for each column; None is a dash."""
    return [heads, *("  ".join(map(_cell, row, formats)) for row in rows)]


def _cell(value: Any, specification: str) -> str:
    if value is not None:
        return format(value, specification)
    width = re.search(r"\d+", specification)
    align = "<" if specification.startswith("<") else ">"
    return format("-", align + width[0] if width else "")


def contact_text(
    status: str, benches: tuple[int, int] | None, point: tuple[float, float] | None, time: float, decimals: int = 6
) -> str:
    """When and where two benches first touch, in one line, or until which time none do.

    `decimals` is the number of decimals of the time of a contact that are certain.
    """
    if benches is None or point is None:
        reason = ", after which a handle has no position on the curve" if status == "unreachable" else ""
        return f"no contact until t = {time:.6g} s{reason}"
    (i, j), (x, y) = benches, point
    if status == "overlapping":
        return f"benches {i} and {j} overlap at the start, t = {time:.{decimals}f} s"
    return f"first contact at t = {time:.{decimals}f} s: benches {i} and {j} at ({x:.6f}, {y:.6f}) m"
