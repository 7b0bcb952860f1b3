"""What the lessons say in other languages than their own, which is English: one file a language."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

from pymunk_dragon import _checks as checks

__all__ = ["LANGUAGES", "NO_BREAK", "PARTS", "check_language", "entry", "unbroken", "with_code", "word"]

LANGUAGES = ("en", "zh")
# What a lesson says, in the order in which it says it.
PARTS = ("title", "question", "predict", "picture", "answer", "check", "change")
# The space at which no line ends.
NO_BREAK = "\u00a0"
# The table of what all lessons share.
WORDS = "words"


def check_language(language: str) -> str:
    """`language`, after making sure that there is a catalogue of it.

    Raises
    ------
    ParameterError
        If there is none.
    """
    return checks.word("lang", language, LANGUAGES)


def word(name: str, language: str) -> str:
    """A word that all lessons share, as the name of a part."""
    return _catalogue(language)[WORDS][name]


def entry(lesson: str, part: str, language: str, english: str) -> str:
    """What a lesson says, in `language`: `english` itself, or its translation.

    A lesson that the catalogue does not know, as a student's own, says what it says in English.
    """
    return english if language == "en" else _catalogue(language).get(lesson, {}).get(part, english)


def unbroken(text: str) -> str:
    """A text with spaces where no line may end behind its numbers: 1 m/s belongs together."""
    return re.sub(r"(?<=\d) (?=\w)", NO_BREAK, text)


def with_code(text: str) -> list[tuple[str, bool]]:
    """Stretches of a text, and whether each stands between backticks, as names in the code do."""
    return [(part, number % 2 == 1) for number, part in enumerate(text.split("`"))]


@cache
def _catalogue(language: str) -> Mapping[str, Mapping[str, str]]:
    return tomllib.loads(files(__package__).joinpath(f"{language}.toml").read_text(encoding="utf-8"))
