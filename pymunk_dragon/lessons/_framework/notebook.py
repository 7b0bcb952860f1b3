"""A lesson as a notebook."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from pymunk_dragon._extras import library
from pymunk_dragon.lessons._framework.catalogue import with_code, word
from pymunk_dragon.lessons._framework.demo import CODE, Demo
from pymunk_dragon.lessons._framework.order import after

__all__ = ["InNotebook", "notebook"]

# Where a cell ends: before a paragraph of code that begins with a comment.
PARAGRAPH = re.compile(r"\n{2,}(?=# )")
# What stands above the code, and what stands below it and folded, so that nobody reads it too early.
ABOVE, BELOW = ("question", "predict"), ("answer", "check", "change")


def notebook(demo: Demo, language: str = "en") -> str:
    """A lesson as the text of a Jupyter notebook, in `language`, made from the lesson's file.

    Raises
    ------
    MissingExtraError
        If nbformat is not installed.
    """
    nbformat = library("nbformat")
    make = {"markdown": nbformat.v4.new_markdown_cell, CODE: nbformat.v4.new_code_cell}
    cells = [make[kind](text, id=f"{demo.name}-{number}") for number, (kind, text) in enumerate(_cells(demo, language))]
    metadata = {
        "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
        "language_info": {"name": "python"},
    }
    made = nbformat.v4.new_notebook(cells=cells, metadata=metadata)
    nbformat.validate(made)
    return str(nbformat.writes(made)) + "\n"


def _cells(demo: Demo, language: str) -> Iterator[tuple[str, str]]:
    """Kinds and texts of the cells."""

    def told(part: str) -> str:
        return f"**{word(part, language)}**\n\n{_plain(demo.said(part, language))}"

    yield "markdown", "\n\n".join([f"# {_plain(demo.said('title', language))}", *map(told, ABOVE)])
    for block in demo.blocks:
        if block.kind == CODE:
            yield from ((CODE, cell) for cell in PARAGRAPH.split(block.text))
    yield "markdown", told("picture")
    answer = "\n\n".join(map(told, BELOW))
    yield "markdown", f"<details><summary>{word('answer', language)}</summary>\n\n{answer}\n\n</details>"
    if (following := after(demo.name)) is not None:
        yield "markdown", f"**{word('next', language)}**\n\n`pymunk-dragon demo {following} -o {following}.ipynb`"


def _plain(text: str) -> str:
    """A text in which Markdown finds nothing to act upon but code between backticks."""
    return "`".join(
        part if is_code else re.sub(r"([\\*_{}\[\]<>#$|~&])", r"\\\1", part) for part, is_code in with_code(text)
    )


class InNotebook:
    """Shows what a lesson shows in the notebook in which it runs; what it says stands there already."""

    @property
    def folder(self) -> Path:
        """Where the lesson's picture is written: beside the notebook."""
        return Path()

    def say(self, lesson: str, part: str, english: str) -> None:
        """Leave it to the notebook's own text."""

    def show(self, lesson: str, picture: Path, english: str) -> None:
        """Show a picture or film below the cell."""
        shown = import_module("IPython.display")
        shown.display(shown.Image(filename=str(picture)))

    def end(self, lesson: str) -> None:
        """Leave it to the notebook's own text."""
