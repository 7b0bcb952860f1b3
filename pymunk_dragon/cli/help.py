"""The help in the present language, in lines that fit in the terminal."""

from __future__ import annotations

from collections.abc import Iterable

import click

from pymunk_dragon._language import text as translated
from pymunk_dragon._text import width, wrapped


class Formatter(click.HelpFormatter):
    """Writer of the help, which translates each text. Click counts characters; a Chinese one has two columns."""

    def write_usage(self, prog: str, args: str = "", prefix: str | None = None) -> None:
        """Write the name of the command and its arguments."""
        self._write(f"{translated('Usage: ')}{prog} ", " ".join(map(translated, args.split())))

    def write_heading(self, heading: str) -> None:
        """Write a heading."""
        self._write("", translated(f"{heading}:"))

    def write_text(self, text: str) -> None:
        """Write paragraphs, which empty lines separate."""
        for number, paragraph in enumerate(text.split("\n\n")):
            if number:
                self.write_paragraph()
            self._write(" " * self.current_indent, translated(" ".join(paragraph.split())))

    def write_dl(self, rows: Iterable[tuple[str, str]], col_max: int = 30, col_spacing: int = 2) -> None:
        """Write texts behind the terms that they explain."""
        listed = list(rows)
        column = max(len(term) for term, _ in listed) + col_spacing
        for term, explanation in listed:
            self._write(f"{'':{self.current_indent}}{term:{column}}", translated(explanation))

    def _write(self, begin: str, text: str) -> None:
        """Write a text behind its beginning; its further lines are indented as far."""
        for line in wrapped(text, self.width - width(begin)):
            self.write(f"{begin}{line}".rstrip() + "\n")
            begin = " " * width(begin)


class Context(click.Context):
    """A context whose help is written by `Formatter`."""

    formatter_class = Formatter
