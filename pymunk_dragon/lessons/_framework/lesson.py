"""What a lesson's file calls."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Protocol

from pymunk_dragon._extras import library
from pymunk_dragon._files import written_in_place
from pymunk_dragon.lessons._framework.notebook import InNotebook
from pymunk_dragon.lessons._framework.stage import Stage, stage
from pymunk_dragon.lessons._framework.terminal import Terminal

__all__ = ["Lesson"]

# Inches of a picture with axes: so small that its type can be read on a phone.
WIDTH, HEIGHT = 5.2, 3.7


class Drawing(Protocol):
    """A picture that can be written, as matplotlib's figures can."""

    def savefig(self, fname: Path, /) -> None:
        """Write it to a file."""
        ...


class Lesson:
    """A lesson that is being told: its file says one part after the other, and does in between what it talks about.

    Run by itself, as `python near_miss.py --save pictures --lang zh`, it is told in the terminal; in a notebook, its
    pictures appear there.

    Parameters
    ----------
    name : str
        The lesson's name in the program and in the catalogues of translations.
    title : str
        Its title.

    Notes
    -----
    What is said is written as one text, not put together, so that it can be read, and translated, without playing it.
    """

    def __init__(self, name: str, title: str) -> None:
        self.name = name
        self._stage = stage() or _own_stage()
        self._style = ExitStack()
        self._stage.say(name, "title", title)

    def question(self, text: str) -> None:
        """Say what it is about."""
        self._stage.say(self.name, "question", text)

    def predict(self, text: str) -> None:
        """Say what the class shall guess before it sees what happens."""
        self._stage.say(self.name, "predict", text)

    def answer(self, text: str) -> None:
        """Say what the answer is, in two sentences."""
        self._stage.say(self.name, "answer", text)

    def check(self, text: str) -> None:
        """Say which of the printed numbers the student can check, and how."""
        self._stage.say(self.name, "check", text)

    def change(self, text: str) -> None:
        """Say what to change in the file, and to try; the lesson's last words."""
        self._stage.say(self.name, "change", text)
        self._stage.end(self.name)

    def file(self, ending: str) -> Path:
        """Where to write the lesson's picture or film: named after the lesson, with this ending, as ".gif"."""
        return self._stage.folder / f"{self.name}{ending}"

    def subplots(self, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Any, Any]:
        """An empty picture with axes, as `matplotlib.pyplot.subplots` gives it, in the house's colours and type.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        from pymunk_dragon.drawing.figures.style import chart, styled

        self._style.enter_context(styled())
        # The house's face has no minus sign for powers of ten, which a student's axes may well have.
        library("matplotlib").rcParams["axes.unicode_minus"] = False
        figure = chart(*options.pop("figsize", (WIDTH, HEIGHT)))
        return figure, figure.subplots(rows, columns, **options)

    def show(self, picture: Path | Drawing, text: str) -> None:
        """Show a film that was written to `file`, or a picture with axes, and say what it shows."""
        # A film of axes was written in the house's style too: whatever is drawn next, has its own.
        with self._style:
            if not isinstance(picture, Path):
                with written_in_place(path := self.file(".png")) as draft:
                    picture.savefig(draft)
                picture = path
        self._stage.show(self.name, picture, text)


def _own_stage() -> Stage:
    """Where a lesson is told that is run by itself."""
    if "ipykernel" in sys.modules:
        return InNotebook()
    return Terminal.of_program(sys.argv)
