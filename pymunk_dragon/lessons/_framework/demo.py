"""What is known of a lesson without playing it."""

from __future__ import annotations

import ast
import runpy
from dataclasses import dataclass
from pathlib import Path

from pymunk_dragon._extras import extras_named
from pymunk_dragon.lessons._framework.catalogue import entry
from pymunk_dragon.lessons._framework.stage import Stage, on_stage

__all__ = ["CODE", "Block", "Demo"]

# The methods of a lesson whose whole statement is text.
SPOKEN = ("question", "predict", "answer", "check", "change")
CODE = "code"


@dataclass(frozen=True)
class Block:
    """A stretch of a lesson's file.

    Attributes
    ----------
    kind : str
        "code", or the part of the lesson that is said.
    text : str
        The code as it stands, or what is said, in one line of English.
    """

    kind: str
    text: str


@dataclass(frozen=True)
class Demo:
    """A lesson, as its file has it.

    Attributes
    ----------
    path : Path
        The file, a Python program.
    name, title : str
        The lesson's name in the program and in the catalogues, and what stands above it.
    picture : str
        What its picture shows.
    blocks : tuple of Block
        What the file says and does, in that order.
    """

    path: Path
    name: str
    title: str
    picture: str
    blocks: tuple[Block, ...]

    @classmethod
    def read(cls, path: Path) -> Demo:
        """The lesson in a file; nothing in it runs."""
        source = path.read_text(encoding="utf-8")
        lines = source.splitlines()
        named, shown, blocks, begin = ("", ""), "", [], 0
        for statement in ast.parse(source).body:
            called, texts = _call(statement)
            if called == "Lesson":
                named = texts[0], texts[1]
            elif called == "show" and texts:  # and not a student's own, as pyplot.show()
                shown = texts[0]
            elif called in SPOKEN or called == "":
                blocks += _code(lines[begin : statement.lineno - 1])
                begin = statement.end_lineno or 0
                if called:
                    blocks.append(Block(called, texts[0]))
        return cls(path, *named, shown, tuple(blocks + _code(lines[begin:])))

    @property
    def source(self) -> str:
        """The whole file."""
        return self.path.read_text(encoding="utf-8")

    def said(self, part: str, language: str = "en") -> str:
        """What it says: its title, question, ...; where the catalogue has no translation, in English."""
        if part in ("title", "picture"):
            english = self.title if part == "title" else self.picture
        else:
            english = next(block.text for block in self.blocks if block.kind == part)
        return entry(self.name, part, language, english)

    def play(self, stage: Stage) -> None:
        """Run the file, and have the lesson told on `stage`.

        Raises
        ------
        MissingExtraError
            If what it draws with is not installed.
        """
        with on_stage(stage), extras_named():
            runpy.run_path(str(self.path), run_name="__main__")


def _call(statement: ast.stmt) -> tuple[str | None, list[str]]:
    """What a statement calls, of the lesson's own, with the texts among its arguments.

    The file's docstring, which says the same as the lesson, counts as a call of "".
    """
    value = getattr(statement, "value", None)
    if isinstance(statement, ast.Expr) and isinstance(value, ast.Constant):
        return "", []
    if not isinstance(value, ast.Call):
        return None, []
    texts = [
        " ".join(one.value.split())
        for one in value.args
        if isinstance(one, ast.Constant) and isinstance(one.value, str)
    ]
    return getattr(value.func, "attr", getattr(value.func, "id", None)), texts


def _code(lines: list[str]) -> list[Block]:
    code = "\n".join(lines).strip("\n")
    return [Block(CODE, code)] if code.strip() else []
