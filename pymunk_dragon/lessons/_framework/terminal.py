"""A lesson in a terminal."""

import os
import sys
import tempfile
import textwrap
from itertools import pairwise
from pathlib import Path

from pymunk_dragon._checks import instance, word
from pymunk_dragon._extras import is_installed
from pymunk_dragon._language import LANGUAGES, in_language, text
from pymunk_dragon.errors import MissingExtraError
from pymunk_dragon.lessons._framework.lesson import Lesson, blocks, lessons
from pymunk_dragon.lessons._framework.recording import make_folder, picture, run
from pymunk_dragon.web.markup import plain

# Columns of English text; a terminal breaks lines of Chinese, which has no spaces.
COLUMNS = 88


def play(lesson: Lesson, save: str | Path | None = None, *, language: str = "en") -> None:
    """Print the texts of a lesson on stdout, and what its program prints.

    Parameters
    ----------
    lesson : Lesson
        The lesson.
    save : path, optional
        Folder for the picture, made if it does not exist; by default a new one for temporary files.
    language : str
        Language of the texts, "en" or "zh".

    Raises
    ------
    ParameterError
        If the folder cannot be made, or the language is unknown.
    MissingExtraError
        If a library that the lesson uses is not installed.

    Examples
    --------
    >>> import io
    >>> from contextlib import redirect_stdout
    >>> from pymunk_dragon.lessons import LESSONS, play
    >>> with redirect_stdout(io.StringIO()) as printed:
    ...     play(LESSONS["spiral"], save="pictures", language="zh")
    >>> Path("pictures/spiral.png").exists()
    True
    """
    instance("lesson", lesson, Lesson, "a Lesson")
    word("language", language, LANGUAGES)
    if "matplotlib" in lesson.source and not is_installed("matplotlib"):
        raise MissingExtraError("a lesson", "demos")
    folder = Path(tempfile.mkdtemp(prefix="pymunk-dragon-")) if save is None else make_folder(save)
    texts = lesson.sections(language)
    option = "" if language == "en" else f" --lang {language}"
    with in_language(language):
        _print_section(texts["Title"], texts["Question"])
        _print_section(text("Guess"), lesson.guess(language))

        for line in run(lesson, folder):
            print(line, end="", flush=True)
        _print_section(f"\n{text('Picture')}", str(picture(lesson, folder)))

        for name in ("Answer", "Check", "Change"):
            _print_section(text(name), texts.get(name, ""))

        if scene := lesson.options.get("scene"):
            command = f"demo {lesson.name} --live" if lesson.builds_scene else f"live {scene}"
            _print_section(text("Touch it in a browser"), f"pymunk-dragon {command}{option}")
        if following := dict(pairwise(lessons())).get(lesson.name):
            _print_section(text("Next"), f"pymunk-dragon demo {following}{option}")


def _print_section(heading: str, markdown: str) -> None:
    """Print a text below its heading, in bold on a terminal unless NO_COLOR is set."""
    bold = sys.stdout.isatty() and "NO_COLOR" not in os.environ
    print(f"\x1b[1m{heading}\x1b[0m" if bold else heading)
    for paragraph, items in blocks(markdown):
        for line in [paragraph, *(f"- {item}" for item in items)]:
            long = COLUMNS if max(line, default="") < "\u2e80" else len(line) + 2
            print(textwrap.fill(plain(line), long, initial_indent="  ", subsequent_indent="  "))
        print()
