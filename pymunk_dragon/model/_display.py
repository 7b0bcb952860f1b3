"""How results are shown as text: in tables, and in notebooks."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any


class TextResult:
    """Base class of results that notebooks show as the text that `str` returns."""

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self), quote=False)}</pre>"


def table(heads: Sequence[str], formats: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    """Lines of a table with one format specification for each column; None is a dash."""
    lines = ("  ".join(map(_cell, row, formats)) for row in (heads, *rows))
    return [line.rstrip() for line in lines]


def _cell(value: Any, specification: str) -> str:
    if value is not None and not isinstance(value, str):
        return format(value, specification)
    shown = value or "-"
    least = re.search(r"\d+", specification)
    padding = " " * (int(least[0]) - width(shown)) if least else ""
    return shown + padding if specification.startswith("<") else padding + shown


def width(text: str) -> int:
    """Columns that a text has in a terminal, where a Chinese character has two."""
    return sum(2 if unicodedata.east_asian_width(character) in "WF" else 1 for character in text)
