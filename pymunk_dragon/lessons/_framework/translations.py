"""Texts of the lessons in languages other than English, one TOML file for each language; and helpers to print them.

A lesson's file has its texts in English. `zh.toml` has a table for each lesson, and the table `words` of the headings
that all lessons share; `en.toml` has only that.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

from pymunk_dragon._checks import word

LANGUAGES = ("en", "zh")
# Texts of a lesson in the order in which they are printed.
PARTS = ("title", "question", "predict", "picture", "answer", "check", "change")
# A space at which no line is broken.
NO_BREAK = "\u00a0"


def check_language(language: str) -> str:
    """`language`, if it is one of `LANGUAGES`; otherwise a ParameterError."""
    return word("language", language, LANGUAGES)


def heading(name: str, language: str) -> str:
    """A heading or another text that all lessons share, such as that of a part."""
    return _texts(language)["words"][name]


def translated(lesson: str, part: str, language: str, english: str) -> str:
    """A part of a lesson in `language`; `english` if there is no translation, as of a student's own lesson."""
    return english if language == "en" else _texts(language).get(lesson, {}).get(part, english)


def unbroken(text: str) -> str:
    """`text` with a space that does not break behind each number, so that 1 m/s stays on one line."""
    return re.sub(r"(?<=\d) (?=\w)", NO_BREAK, text)


def with_code(text: str) -> list[tuple[str, bool]]:
    """Parts of a text, and whether each is code, which stands between backticks."""
    return [(part, number % 2 == 1) for number, part in enumerate(text.split("`"))]


@cache
def _texts(language: str) -> Mapping[str, Mapping[str, str]]:
    """Tables of a language's file."""
    return tomllib.loads(files(__package__).joinpath(f"{language}.toml").read_text(encoding="utf-8"))
