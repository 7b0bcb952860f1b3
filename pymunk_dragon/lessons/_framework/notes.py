"""What the page adds to the lessons, in files `notes.en.toml` and `notes.zh.toml`: for teachers, and at its end."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any


@dataclass(frozen=True)
class TeachersNotes:
    """What a teacher wants to know of a lesson.

    Attributes
    ----------
    level : str
        For whom it is.
    needs : str
        What the class knows before.
    minutes : int
        Time that it takes.
    idea : str
        The idea behind it.
    """

    level: str
    needs: str
    minutes: int
    idea: str


@dataclass(frozen=True)
class Notes:
    """Notes in one language.

    Attributes
    ----------
    lessons : mapping of str to TeachersNotes
        By name of the lesson; a student's own lesson has none.
    glossary : mapping of str to (str, str)
        Terms and what they mean.
    references : mapping of str to str
        Literature.
    """

    lessons: Mapping[str, TeachersNotes]
    glossary: Mapping[str, tuple[str, str]]
    references: Mapping[str, str]


@cache
def notes(language: str) -> Notes:
    """The notes in a language; what has no translation is in English.

    Examples
    --------
    >>> notes("en").lessons["spiral"].minutes
    30
    """
    english, found = _read("en"), _read(language)
    return Notes(
        {name: TeachersNotes(**values | found["lessons"].get(name, {})) for name, values in english["lessons"].items()},
        {key: (term, meaning) for key, (term, meaning) in (english["glossary"] | found["glossary"]).items()},
        english["references"] | found["references"],
    )


def _read(language: str) -> Mapping[str, Any]:
    return tomllib.loads(files(__package__).joinpath(f"notes.{language}.toml").read_text(encoding="utf-8"))
