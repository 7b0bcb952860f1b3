"""Texts of the lessons in languages other than English, one TOML file for each language; and helpers to print them.

A lesson's file is English. `zh.toml` has a table for each lesson with its texts; what it lacks is shown in English. The
table `words` has the headings that all lessons share; `en.toml` has only that.
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


def option(language: str) -> str:
    """What follows a command that is printed in a language, so that its output is in this language too."""
    return "" if language == "en" else f" --lang {language}"


def heading(name: str, language: str) -> str:
    """A heading or another text that all lessons share, such as that of a part."""
    found: str = _texts(language)["words"].get(name) or _texts("en")["words"][name]
    return found


def translations(lesson: str, language: str) -> Mapping[str, Any]:
    """The texts of a lesson in `language`; none in English, and none of a lesson without translations."""
    return _texts(language).get(lesson, {}) if language != "en" else {}


def translated_guesses(lesson: str, guesses: Sequence[Guess], language: str) -> tuple[Guess, ...]:
    """The guesses of a lesson in `language`; one without a translation of the same number of choices stays English."""
    found = translations(lesson, language)
    texts, results = found.get("guesses", ()), found.get("measured", ())
    translated = list(guesses)
    for i, (guess, (question, *choices)) in enumerate(zip(guesses, texts, strict=False)):
        if len(choices) == len(guess.choices):
            measured = results[i] if guess.measured and i < len(results) else guess.measured
            translated[i] = replace(guess, question=question, choices=tuple(choices), measured=measured)
    return tuple(translated)


@cache
def _texts(language: str) -> Mapping[str, Mapping[str, Any]]:
    """Tables of a language's file."""
    return tomllib.loads(files(__package__).joinpath(f"{language}.toml").read_text(encoding="utf-8"))
