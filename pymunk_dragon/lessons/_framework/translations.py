"""Texts of the lessons in languages other than English, one TOML file for each language; and helpers to print them.

A lesson's file has its texts in English. `zh.toml` has a table for each lesson, and the table `words` of the headings
that all lessons share; `en.toml` has only that.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any

from pymunk_dragon._checks import word
from pymunk_dragon.lessons._framework.guess import Guess

LANGUAGES = ("en", "zh")
# Texts of a lesson in the order in which they are printed.
PARTS = ("title", "question", "predict", "picture", "answer", "check", "change")


def check_language(language: str) -> str:
    """`language`, if it is one of `LANGUAGES`; otherwise a ParameterError."""
    return word("language", language, LANGUAGES)


def heading(name: str, language: str) -> str:
    """A heading or another text that all lessons share, such as that of a part."""
    word: str = _texts(language)["words"][name]
    return word


def translated(lesson: str, part: str, language: str, english: str) -> str:
    """A part of a lesson in `language`; `english` if there is no translation, as of a student's own lesson."""
    text: str = english if language == "en" else _texts(language).get(lesson, {}).get(part, english)
    return text


def translated_guesses(lesson: str, language: str, english: Sequence[Guess]) -> tuple[Guess, ...]:
    """The guesses of a lesson in `language`; `english` if there is no translation."""
    texts = {} if language == "en" else _texts(language).get(lesson, {})
    if not english or "guesses" not in texts:
        return tuple(english)
    return tuple(
        replace(guess, question=question, choices=tuple(choices), measured=measured)
        for guess, (question, *choices), measured in zip(english, texts["guesses"], texts["measured"], strict=True)
    )


@cache
def _texts(language: str) -> Mapping[str, Mapping[str, Any]]:
    """Tables of a language's file."""
    return tomllib.loads(files(__package__).joinpath(f"{language}.toml").read_text(encoding="utf-8"))
