"""Recordings of the lessons, each made once for all tests."""

from __future__ import annotations

import re
from functools import cache

from study_answers import answer

from pymunk_dragon.lessons import LESSONS, Recording, record


@cache
def played(name: str) -> Recording:
    """The recording of a lesson."""
    found: Recording = answer(f"lesson {name}", lambda: record(LESSONS[name]))
    return found


def numbers(text: str) -> list[float]:
    """All numbers in a text, in the order in which they stand there."""
    return [
        float(found) for found in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w])", text)
    ]
