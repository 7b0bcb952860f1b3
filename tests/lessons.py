"""Lessons as they were played, once for all the tests that look at them."""

from __future__ import annotations

import re
from functools import cache

from pymunk_dragon.demos import DEMOS
from pymunk_dragon.demos.telling import Performance, perform


@cache
def played(name: str) -> Performance:
    return perform(DEMOS[name])


def numbers(text: str) -> list[float]:
    """All numbers in a text, in the order in which they stand there."""
    return [float(found) for found in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w])", text)]
