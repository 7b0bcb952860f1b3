"""A lesson as lines of text."""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import sys
import tempfile
import unicodedata
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import NoReturn

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.lessons._framework.catalogue import LANGUAGES, NO_BREAK, check_language, entry, unbroken, word
from pymunk_dragon.lessons._framework.order import after
from pymunk_dragon.lessons._framework.stage import made_folder

__all__ = ["Terminal", "check_output", "wrapped"]

# Columns of text: longer lines are hard to read, however wide the terminal.
MAX_COLUMNS = 88
INDENT = "  "
PROGRAM = "pymunk-dragon"
BOLD, PLAIN = "\x1b[1m", "\x1b[0m"
# Unicode categories of what belongs to the character before, as stops do, and to the one behind, as brackets that open.
CLOSING, OPENING = ("Pe", "Pf", "Po"), ("Ps", "Pi")


class Terminal:
    """Tells a lesson on stdout.

    Parameters
    ----------
    save : path, optional
        Folder for the picture, made if it does not exist; by default a new one among the system's temporary files.
    language : str
        One of `LANGUAGES`.
    pause : bool
        Whether to wait for Enter once the class has been asked to predict.

    Raises
    ------
    ParameterError
        If there is no such language, the output cannot write it, or no such folder can be made.
    """

    def __init__(self, save: str | Path | None = None, language: str = "en", pause: bool = False) -> None:
        self._save, self._language, self._pause = save, check_language(language), pause
        # While a lesson runs, its own file is called.
        self._program = _program()
        check_output(language)
        if save is not None:
            made_folder(save)

    @classmethod
    def of_program(cls, arguments: Sequence[str]) -> Terminal:
        """What the arguments of a lesson's own program say; wrong ones end it with one line and exit code 2."""
        parser = _Parser(prog=Path(arguments[0]).name, description="A lesson of the bench dragon.")
        parser.add_argument("--save", metavar="DIR", help="folder for the picture")
        parser.add_argument("--lang", default="en", help="language of the text: " + ", ".join(LANGUAGES))
        parser.add_argument("--pause", action="store_true", help="wait for Enter before it shows what happens")
        chosen = parser.parse_args(arguments[1:])
        try:
            return cls(chosen.save, chosen.lang, chosen.pause)
        except ParameterError as error:
            parser.error(str(error))

    @cached_property
    def folder(self) -> Path:
        """Where the lesson's picture is written."""
        return Path(self._save or tempfile.mkdtemp(prefix="pymunk-dragon-"))

    def say(self, lesson: str, part: str, english: str) -> None:
        """Tell a part of a lesson, below its name."""
        text = entry(lesson, part, self._language, english)
        if part == "title":
            print(_bold(text))
        else:
            self._paragraph(part, text)
        if part == "predict":
            print(flush=True)
            # Nobody presses Enter where the input is a file, or none: then the lesson goes on.
            if self._pause and sys.stdin is not None:
                with suppress(EOFError):
                    input(word("pause", self._language) + " ")

    def show(self, lesson: str, picture: Path, english: str) -> None:
        """Say where a picture is, and what it shows."""
        self._paragraph("picture", entry(lesson, "picture", self._language, english))
        print(INDENT + str(picture))

    def end(self, lesson: str) -> None:
        """Say which lesson is the next."""
        if (following := after(lesson)) is not None:
            print("\n" + _bold(word("next", self._language)))
            print(f"{INDENT}{self._program} demo {following}")

    def _paragraph(self, part: str, text: str) -> None:
        columns = min(shutil.get_terminal_size((MAX_COLUMNS, 0)).columns, MAX_COLUMNS) - len(INDENT)
        print("\n" + _bold(word(part, self._language)))
        for line in wrapped(text, columns):
            print(INDENT + line)


def check_output(language: str) -> None:
    """Make sure that the output can write a language.

    Raises
    ------
    ParameterError
        If it cannot, as Chinese where the output speaks ASCII.
    """
    encoding = sys.stdout.encoding or "utf-8"
    try:
        word("pause", language).encode(encoding)
    except UnicodeEncodeError as error:
        bound = f"a language that {encoding} can write; PYTHONIOENCODING=utf-8 in the environment writes all"
        raise ParameterError("lang", language, bound) from error


class _Parser(argparse.ArgumentParser):
    """Complains in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def wrapped(text: str, columns: int) -> Iterator[str]:
    """Lines of `text` at most so many columns wide, of which a Chinese character takes two."""
    line, used = "", 0
    for piece in _pieces(unbroken(" ".join(text.split()))):
        if used + _width(piece.rstrip(" ")) > columns and line:
            yield _ended(line)
            line, used = "", 0
        line, used = line + piece, used + _width(piece)
    yield _ended(line)


def _ended(line: str) -> str:
    return line.rstrip(" ").replace(NO_BREAK, " ")


def _pieces(text: str) -> Iterator[str]:
    """What may not be broken: words with the space behind them, wide characters with stops and brackets about them."""
    piece = ""
    for character in text:
        if piece and _may_break(piece[-1], character):
            yield piece
            piece = ""
        piece += character
    yield piece


def _may_break(before: str, behind: str) -> bool:
    if before == " ":
        return True
    if behind in (" ", NO_BREAK) or before == NO_BREAK:
        return False
    if unicodedata.category(behind) in CLOSING or unicodedata.category(before) in OPENING:
        return False
    return _wide(before) or _wide(behind)


def _width(text: str) -> int:
    return sum(1 + _wide(character) for character in text)


def _wide(character: str) -> bool:
    return unicodedata.east_asian_width(character) in "WF"


def _program() -> str:
    """What starts the program here: its name, or where it is not on the path, how it was called."""
    if shutil.which(PROGRAM):
        return PROGRAM
    called = sys.argv[0]
    return shlex.quote(called) if Path(called).stem == PROGRAM else f"{shlex.quote(sys.executable)} -m pymunk_dragon"


def _bold(text: str) -> str:
    return f"{BOLD}{text}{PLAIN}" if sys.stdout.isatty() and "NO_COLOR" not in os.environ else text
