"""How results are shown: tables, and base classes of objects that notebooks display."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from html import escape
from importlib import import_module
from typing import Any


class Displayed:
    """Base class of objects that `pymunk_dragon.notebook` represents by a picture or a page."""

    def plot(self) -> Any:
        """Draw the object as a matplotlib figure, which notebooks display."""
        return _represented(self, "plot")

    def _repr_html_(self) -> Any:
        return _represented(self, "as_html")

    def _repr_png_(self) -> Any:
        return _represented(self, "as_png")


class Printed:
    """Base class of results that are represented by their text."""

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self), quote=False)}</pre>"


def _represented(shown: object, how: str) -> Any:
    # The module is imported by its name, because it is above the classes of what it represents.
    return getattr(import_module("pymunk_dragon.notebook"), how)(shown)


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
