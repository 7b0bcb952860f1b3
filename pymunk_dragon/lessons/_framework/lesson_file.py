"""A lesson as its file describes it: name, order, texts and code, read without running the file."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

from pymunk_dragon.lessons._framework.guess import Guess
from pymunk_dragon.lessons._framework.translations import check_language, translated_guesses, translations

FOLDER = Path(__file__).parent.parent
# Methods of `Lesson` whose first argument is a text that ends a block of code.
TEXTS = ("question", "predict", "picture", "answer", "check", "change")
CODE = "code"
# Words in a program, and the library of an extra that they need.
NEEDED = {".subplots(": "matplotlib", "Sampled(": "scipy"}


@dataclass(frozen=True)
class LessonFile:
    """The file of a lesson.

    Attributes
    ----------
    path : Path
        The file, a Python program.
    name : str
        Name of the lesson on the command line and in the files of translations.
    title : str
        Title in English.
    order : float
        The lessons of the package are listed by increasing order; infinite if the file has none.
    live : str
        Name of the ready scene of `pymunk-dragon live` on it; empty if there is none.
    blocks : tuple of (str, str)
        Kind and text of each block of the file in its order: "code", or a part of the lesson such as "question" and
        its text in one line of English.
    guesses : tuple of Guess
        What the class guesses before the run, in English.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS
    >>> lesson = LESSONS["near-miss"]
    >>> lesson.path.name, lesson.order
    ('near_miss.py', 60)
    >>> lesson.text("title"), lesson.in_language("zh").text("title")
    ('A hit or a near miss?', '碰上了，还是擦肩而过？')
    >>> print(lesson.code.splitlines()[0])
    import numpy as np
    """

    path: Path
    name: str
    title: str
    order: float
    live: str
    blocks: tuple[tuple[str, str], ...]
    guesses: tuple[Guess, ...]
    language: str = "en"

    @classmethod
    def read(cls, path: Path) -> LessonFile:
        """The lesson in a file, which is parsed but not run."""
        source = path.read_text(encoding="utf-8")
        lines = source.splitlines()
        name, title, order, live = "", "", float("inf"), ""
        guesses: tuple[Guess, ...] = ()
        blocks: list[tuple[str, str]] = []
        begin = 0

        def add_code(end: int) -> None:
            if code := "\n".join(lines[begin:end]).strip("\n"):
                blocks.append((CODE, code))

        for statement in ast.parse(source).body:
            match statement:
                case ast.Assign(value=ast.Call(ast.Name("Lesson") | ast.Attribute(attr="Lesson"), arguments, keywords)):
                    name, title = map(ast.literal_eval, arguments)
                    values = {word.arg: ast.literal_eval(word.value) for word in keywords}
                    order, live = values.get("order", order), values.get("live", live)
                case ast.Expr(ast.Call(ast.Attribute(attr=part), [ast.Constant(str(text)), *more])) if part in TEXTS:
                    add_code(statement.lineno - 1)
                    blocks.append((part, _one_line(text)))
                    begin = statement.end_lineno or 0
                    tuples = [ast.literal_eval(each) for each in more]
                    if part == "predict":
                        guesses = Guess.of_texts(tuples)
                    elif part == "answer":
                        guesses = tuple(
                            guess.with_result(*result) for guess, result in zip(guesses, tuples, strict=True)
                        )
                case ast.Expr(ast.Constant()):  # The docstring; the title says the same.
                    add_code(statement.lineno - 1)
                    begin = statement.end_lineno or 0
        add_code(len(lines))
        return cls(path, name, title, order, live, tuple(blocks), guesses)

    @property
    def source(self) -> str:
        """The whole program, which is English in all languages."""
        return self.path.read_text(encoding="utf-8")

    @property
    def code(self) -> str:
        """The file without its docstring and the texts of the lesson."""
        return "\n\n".join(text for kind, text in self.blocks if kind == CODE)

    @property
    def libraries(self) -> list[str]:
        """Libraries of extras without which the lesson cannot run."""
        return [library for word, library in NEEDED.items() if word in self.code]

    def text(self, part: str) -> str:
        """One of `PARTS`; empty if the lesson has none."""
        return {"title": self.title, **dict(self.blocks)}.get(part, "")

    def in_language(self, language: str) -> LessonFile:
        """The lesson with its texts in another language; what has no translation stays English, as the program does.

        Raises
        ------
        ParameterError
            If the language is unknown.
        """
        found = translations(self.name, check_language(language))
        return replace(
            self,
            language=language,
            title=found.get("title", self.title),
            blocks=tuple((kind, text if kind == CODE else found.get(kind, text)) for kind, text in self.blocks),
            guesses=translated_guesses(self.name, self.guesses, language),
        )


def _one_line(text: str) -> str:
    return " ".join(text.split())


@cache
def lesson_files() -> Mapping[str, LessonFile]:
    """The lessons of the package by name, in their order."""
    found = sorted(map(LessonFile.read, FOLDER.glob("[!_]*.py")), key=lambda lesson: lesson.order)
    return MappingProxyType({lesson.name: lesson for lesson in found})


def live_scene(name: str) -> str:
    """Name of the live scene on the lesson `name`; empty if there is none, or it is not of the package."""
    return lesson_files()[name].live if name in lesson_files() else ""


def next_lesson(name: str) -> str | None:
    """Name of the lesson after `name`; None after the last one, and for a lesson that is not of the package."""
    return dict(pairwise(lesson_files())).get(name)
