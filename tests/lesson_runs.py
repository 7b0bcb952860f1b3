"""Recordings of the lessons, each made once for all tests."""

from __future__ import annotations

import os
import pickle
import re
from functools import cache
from pathlib import Path

from pymunk_dragon.lessons import LESSONS, Recording, record

# Environment variable that names a folder in which parallel test processes share what they have played.
SHARED = "PYMUNK_DRAGON_TESTS_SHARED"


@cache
def played(name: str) -> Recording:
    """The recording of a lesson."""
    if SHARED not in os.environ:
        return record(LESSONS[name])
    file = Path(os.environ[SHARED]) / f"{name}.pickle"
    if not file.exists():
        draft = file.with_suffix(f".{os.getpid()}")
        draft.write_bytes(pickle.dumps(record(LESSONS[name])))
        os.replace(draft, file)
    found: Recording = pickle.loads(file.read_bytes())
    return found


def numbers(text: str) -> list[float]:
    """All numbers in a text, in the order in which they stand there."""
    return [float(found) for found in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w])", text)]
