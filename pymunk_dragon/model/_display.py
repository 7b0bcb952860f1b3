"""How results are shown: tables of text, and pictures in notebooks."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from html import escape
from importlib import import_module
from typing import Any

# Pixels: the side of a picture, shown at half of it on screens with two pixels to the point.
_SIZE = 640


class Displayed:
    """Base class of runs and marches, which notebooks show as a picture."""

    # Packages are imported by their names, because they are above the classes of what they show.

    def plot(self) -> Any:
        """Paths of seven handles as a matplotlib figure, which notebooks display."""
        return import_module("pymunk_dragon.drawing.figures").figure("trajectories", self)

    def _repr_png_(self: Any) -> Any:
        """A run as it ended, or a march as it begins."""
        drawing, times = import_module("pymunk_dragon.drawing"), getattr(self, "times", (0.0,))
        return drawing.still_png(self, float(times[-1]), drawing.Film(size=_SIZE))


class Printed:
    """Base class of results that are represented by their text."""

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self), quote=False)}</pre>"


def table(heads: Sequence[str], formats: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    """Lines of a table: the heads, and the rows with one format specification for each column; None is a dash."""
    return ["  ".join(map(_cell, row, formats)).rstrip() for row in (heads, *rows)]


def _cell(value: Any, specification: str) -> str:
    if value is not None and not isinstance(value, str):
        return format(value, specification)
    shown, least = value or "-", re.search(r"\d+", specification)
    padding = " " * (int(least[0]) - width(shown)) if least else ""
    return shown + padding if specification.startswith("<") else padding + shown


def width(text: str) -> int:
    """Columns that a text has in a terminal, where a Chinese character has two."""
    return sum(2 if unicodedata.east_asian_width(character) in "WF" else 1 for character in text)
