"""What the page adds to the lessons, in files `notes.en.toml` and `notes.zh.toml`: for teachers, and at its end."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files


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
    """The notes in a language.

    Examples
    --------
    >>> notes("en").lessons["spiral"].minutes
    30
    """
    read = tomllib.loads(files(__package__).joinpath(f"notes.{language}.toml").read_text(encoding="utf-8"))
    return Notes(
        {name: TeachersNotes(**values) for name, values in read["lessons"].items()},
        {key: (term, meaning) for key, (term, meaning) in read["glossary"].items()},
        read["references"],
    )
