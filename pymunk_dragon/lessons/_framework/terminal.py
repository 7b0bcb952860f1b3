"""Output of a lesson in a terminal, as wrapped text."""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.lessons._framework.guess import Guess
from pymunk_dragon.lessons._framework.lesson_file import live_scene, next_lesson
from pymunk_dragon.lessons._framework.lines import wrapped
from pymunk_dragon.lessons._framework.markup import plain
from pymunk_dragon.lessons._framework.play import Output, make_folder
from pymunk_dragon.lessons._framework.translations import (
    LANGUAGES,
    check_language,
    heading,
    option,
    translated_guesses,
    translations,
)

# Columns of text also in a wider terminal: longer lines are hard to read.
MAX_COLUMNS = 88
INDENT = "  "
PROGRAM = "pymunk-dragon"


class Terminal(Output):
    """Prints the texts of a lesson, and the name of the file of its picture, on stdout.

    Parameters
    ----------
    save : path, optional
        Folder for the picture, made if it does not exist; by default a new one for temporary files.
    pause : bool
        Whether to wait for Enter after the prediction.
    language : str
        One of `LANGUAGES`, that of the texts; what the program of the lesson prints is English.

    Raises
    ------
    ParameterError
        If the folder cannot be made, or the language is unknown.

    Examples
    --------
    >>> import io
    >>> from contextlib import redirect_stdout
    >>> from pymunk_dragon.lessons import LESSONS, Terminal, play
    >>> with redirect_stdout(io.StringIO()) as printed:
    ...     play(LESSONS["spiral"], Terminal(save="pictures", language="zh"))
    >>> Path("pictures/spiral.png").exists()
    True
    """

    def __init__(self, save: str | Path | None = None, pause: bool = False, language: str = "en") -> None:
        self._save, self._pause, self._language = save, pause, check_language(language)
        # Now, because a lesson may change sys.argv.
        self._program = _program()
        if save is not None:
            make_folder(save)

    @classmethod
    def of_program(cls) -> Terminal:
        """The terminal of a lesson that is run as a program, from its arguments; exits with code 2 if they are bad."""
        parser = _Parser(prog=Path(sys.argv[0]).name, description="A lesson of the bench dragon.")
        parser.add_argument("--save", metavar="DIR", help="folder for the picture")
        parser.add_argument("--pause", action="store_true", help="wait for Enter before it shows what happens")
        parser.add_argument("--lang", choices=LANGUAGES, default="en", help="language of the texts: en or zh")
        arguments = parser.parse_args()
        try:
            check_output(arguments.lang)
            return cls(arguments.save, arguments.pause, arguments.lang)
        except ParameterError as error:
            parser.error(str(error))

    def folder(self) -> Path:
        """Folder in which the lesson writes its picture."""
        if self._save is None:
            self._save = tempfile.mkdtemp(prefix="pymunk-dragon-")
        return Path(self._save)

    def say(self, lesson: str, part: str, text: str, guesses: Sequence[Guess] = ()) -> None:
        """Print a text below its heading, and its guesses; after the last one, the command for the next lesson."""
        text = translations(lesson, self._language).get(part, text)
        if part == "title":
            print(_bold(text))
            return
        self._print(part, *self._wrapped(text))
        for guess in translated_guesses(lesson, guesses, self._language):
            self._guess(guess, answered=part == "answer")
        if part == "predict":
            print(flush=True)
            # Without a stdin, or at its end, Enter cannot be pressed.
            if self._pause and sys.stdin is not None:
                with suppress(EOFError):
                    input(heading("pause", self._language) + " ")
        if part == "change" and (scene := live_scene(lesson)):
            self._print("live", f"{self._program} live {scene}{option(self._language)}")
        if part == "change" and (after := next_lesson(lesson)) is not None:
            self._print("next", f"{self._program} demo {after}{option(self._language)}")

    def show(self, lesson: str, picture: Path) -> None:
        """Print the file of the picture."""
        self._print("file", str(picture))

    def _guess(self, guess: Guess, answered: bool) -> None:
        """Print a guess with its choices, or with its result."""
        print()
        for line in (guess.question, *([guess.result()] if answered else guess.lettered())):
            for wrapped_line in self._wrapped(line):
                print(INDENT + wrapped_line)

    def _wrapped(self, text: str) -> Iterator[str]:
        """Lines of `text` as wide as the terminal."""
        columns = min(shutil.get_terminal_size((MAX_COLUMNS, 0)).columns, MAX_COLUMNS) - len(INDENT)
        return wrapped(plain(text), columns)

    def _print(self, name: str, *lines: str) -> None:
        """Print indented lines below a heading."""
        print("\n" + _bold(heading(name, self._language)))
        for line in lines:
            print(INDENT + line)


def check_output(name: str) -> None:
    """Check that stdout can encode a language; a ParameterError if it cannot, as Chinese in ASCII."""
    encoding = sys.stdout.encoding or "utf-8"
    try:
        heading("pause", name).encode(encoding)
    except UnicodeEncodeError as error:
        bound = f"a language that {encoding} can write; PYTHONIOENCODING=utf-8 in the environment writes all"
        raise ParameterError("language", name, bound) from error


class _Parser(argparse.ArgumentParser):
    """Parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def _program() -> str:
    """Command that starts the program: its name if that is on the path, otherwise as it was called."""
    if shutil.which(PROGRAM):
        return PROGRAM
    called = sys.argv[0]
    return shlex.quote(called) if Path(called).stem == PROGRAM else f"{shlex.quote(sys.executable)} -m pymunk_dragon"


def _bold(text: str) -> str:
    """`text` in bold if stdout is a terminal, unless the environment has NO_COLOR."""
    return f"\x1b[1m{text}\x1b[0m" if sys.stdout.isatty() and "NO_COLOR" not in os.environ else text
