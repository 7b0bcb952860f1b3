"""The lessons in the order in which they are read."""

from __future__ import annotations

from itertools import pairwise

__all__ = ["LESSONS", "after"]

LESSONS = (
    "spiral",
    "chain",
    "velocity",
    "sat",
    "grid",
    "near-miss",
    "missed-window",
    "unguided",
    "engine",
    "callbacks",
    "tension",
    "pitch",
    "u-turn",
    "speed-limit",
    "robot",
)


def after(lesson: str) -> str | None:
    """Name of the lesson after `lesson`; None after the last one, and after one that is not among them."""
    return dict(pairwise(LESSONS)).get(lesson)
