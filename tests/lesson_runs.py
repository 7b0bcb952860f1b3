"""Recordings of the lessons, each made once for all tests."""

from __future__ import annotations

import pickle
import re
from functools import cache

from sharing import shared

from pymunk_dragon.lessons import LESSONS, Recording, record


@cache
def played(name: str) -> Recording:
    """The recording of a lesson."""
    file = shared(f"lesson {name}.pickle", lambda path: path.write_bytes(pickle.dumps(record(LESSONS[name]))))
    found: Recording = pickle.loads(file.read_bytes())
    return found


def numbers(text: str) -> list[float]:
    """All numbers in a text, in the order in which they stand there."""
    return [float(found) for found in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w])", text)]
