"""Texts of the lessons in languages other than English, one TOML file for each language; and helpers to print them.

A lesson's file is English. `zh.toml` has a table for each lesson: its texts, and as `program` fragments of its code
with their translations. The table `words` has the headings that all lessons share; `en.toml` has only that.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from pymunk_dragon._checks import word

LANGUAGES = ("en", "zh")
# Texts of a lesson in the order in which they are printed.
PARTS = ("title", "question", "predict", "picture", "answer", "check", "change")


def check_language(language: str) -> str:
    """`language`, if it is one of `LANGUAGES`; otherwise a ParameterError."""
    return word("language", language, LANGUAGES)


def option(language: str) -> str:
    """What follows a command that is printed in a language, so that its output is in this language too."""
    return "" if language == "en" else f" --lang {language}"


def heading(name: str, language: str) -> str:
    """A heading or another text that all lessons share, such as that of a part."""
    word: str = _texts(language)["words"][name]
    return word


def translations(lesson: str, language: str) -> Mapping[str, Any]:
    """The texts of a lesson in `language`; none in English, and none of a student's own lesson."""
    return _texts(language).get(lesson, {}) if language != "en" else {}


@cache
def _texts(language: str) -> Mapping[str, Mapping[str, Any]]:
    """Tables of a language's file."""
    return tomllib.loads(files(__package__).joinpath(f"{language}.toml").read_text(encoding="utf-8"))
