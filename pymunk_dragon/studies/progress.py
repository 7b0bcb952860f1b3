"""How studies report their progress."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "silent"]

# Called with how much is done, and how much there is.
Progress = Callable[[float, float], None]


def silent(done: float, total: float) -> None:
    """Report nothing."""
