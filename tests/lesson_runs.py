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
def played(name: str, language: str = "en") -> Recording:
    """The recording of a lesson in a language."""
    lesson = LESSONS[name].in_language(language)
    if SHARED not in os.environ:
        return record(lesson)
    file = Path(os.environ[SHARED]) / f"{name}.{language}.pickle"
    if not file.exists():
        draft = file.with_suffix(f".{os.getpid()}")
        draft.write_bytes(pickle.dumps(record(lesson)))
        os.replace(draft, file)
    found: Recording = pickle.loads(file.read_bytes())
    return found


def numbers(text: str) -> list[float]:
    """All numbers in a text, in the order in which they stand there."""
    return [float(found) for found in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w])", text)]
