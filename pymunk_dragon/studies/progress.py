"""Progress callbacks of the studies."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "silent"]

# Called with the work that is done and the whole work, in the same unit.
Progress = Callable[[float, float], None]


def silent(done: float, total: float) -> None:
    """Report nothing."""
