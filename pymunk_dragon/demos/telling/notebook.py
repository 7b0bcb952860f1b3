"""A lesson as a notebook."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

__all__ = ["InNotebook"]


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
