"""What the lessons say in other languages than their own, which is English: one file a language."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

__all__ = ["LANGUAGES", "PARTS", "entry", "word"]

LANGUAGES = ("en", "zh")
# What a lesson says, in the order in which it says it.
PARTS = ("title", "question", "predict", "picture", "answer", "check", "change")
# The table of what all lessons share.
WORDS = "words"


def word(name: str, language: str) -> str:
    """A word that all lessons share, as the name of a part."""
    return _catalogue(language)[WORDS][name]


def entry(lesson: str, part: str, language: str, english: str) -> str:
    """What a lesson says, in `language`: `english` itself, or its translation.

    A lesson that the catalogue does not know, as a student's own, says what it says in English.
    """
    return english if language == "en" else _catalogue(language).get(lesson, {}).get(part, english)


@cache
def _catalogue(language: str) -> Mapping[str, Mapping[str, str]]:
    return tomllib.loads(files(__package__).joinpath(f"{language}.toml").read_text(encoding="utf-8"))
