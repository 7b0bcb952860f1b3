"""A page of lessons: one HTML file with their texts in all languages, films and code, which loads nothing else."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

from pymunk_dragon._extras import library, optional_imports
from pymunk_dragon._html import asset, data_address, filled, policy
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing import Film, render
from pymunk_dragon.drawing.film import size_and_last_frame
from pymunk_dragon.lessons._framework.guess import Guess
from pymunk_dragon.lessons._framework.lines import closing, unbroken
from pymunk_dragon.lessons._framework.markup import in_mathml, pieces
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.notes import notes
from pymunk_dragon.lessons._framework.play import MEDIA_TYPES, Recording
from pymunk_dragon.lessons._framework.translations import LANGUAGES, PARTS, heading, option
from pymunk_dragon.model.march import March

# Texts of the page itself in the files of translations.
PAGE_WORDS = (
    *("live", "page_title", "page_subtitle", "dragon", "contents", "run", "code", "top", "glossary", "references"),
    *("check_guess", "right", "wrong", "because", "notes", "for_teacher", "level", "needs", "minutes", "unit", "idea"),
    *("print_class", "print_teacher", "print_class_all", "print_teacher_all"),
)
# Film at the top of the page: the last 52 s before the first contact. Its step of 0.6 m a frame is short against a
# bench, and its file has some 1.1 MB. No legend: the film has no words in any language.
FILM = Film(start=360, until=412.474, speedup=12, fps=20, size=330, hold=2.5, legend=False)


def check_libraries() -> None:
    """Check that the libraries of `make_page` are installed, before lessons are run for it."""
    # Those of the extra [demos] first: it brings all of them.
    for name in ("pygments", "nbformat", "latex2mathml", "jinja2"):
        library(name)


def make_page(recordings: Sequence[Recording], language: str = "en") -> str:
    """Lessons that were run as the text of one HTML page, with their texts in all languages.

    Parameters
    ----------
    recordings : sequence of Recording
        For each lesson its printed lines and picture.
    language : str
        The language in which the page opens.

    Returns
    -------
    str
        The page.

    Raises
    ------
    MissingExtraError
        If Jinja2, latex2mathml, nbformat or Pygments is not installed.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS, record
    >>> text = make_page([record(LESSONS["spiral"])], "zh")
    """
    style, script = asset(__package__, "assets/lessons.css"), asset(__package__, "assets/lessons.js")
    return filled(
        __package__,
        "assets/lessons.html.j2",
        language=language,
        languages={each: heading("language", each) for each in LANGUAGES},
        options={each: option(each) for each in LANGUAGES},
        words={name: {each: heading(name, each) for each in LANGUAGES} for name in (*PAGE_WORDS, *PARTS[1:])},
        lessons=[_values(recording) for recording in recordings],
        film=_film(_dragon(), ".gif"),
        glossary=[
            [{each: _pieces(notes(each).glossary[key][part]) for each in LANGUAGES} for part in range(2)]
            for key in notes("en").glossary
        ],
        references=[
            {each: _pieces(notes(each).references[key]) for each in LANGUAGES} for key in notes("en").references
        ],
        policy=policy(style, script, pictures="data: blob:"),
        style=style,
        script=script,
    )


def _values(recording: Recording) -> dict[str, Any]:
    """Values of a lesson in the template."""
    english = recording.lesson
    lessons = {each: english.in_language(each) for each in LANGUAGES}
    program = english.source.encode()
    return {
        "name": english.name,
        "live": english.live,
        "texts": {part: {each: _pieces(lesson.text(part)) for each, lesson in lessons.items()} for part in PARTS},
        "guesses": [
            _guess(dict(zip(LANGUAGES, versions, strict=True)))
            for versions in zip(*(lesson.guesses for lesson in lessons.values()), strict=True)
        ],
        "teacher": _teachers_notes(english.name),
        "printed": recording.printed.strip("\n"),
        "film": _film(recording.picture, recording.file.suffix),
        "code": _highlighted(english.code),
        "program": {"name": english.path.name, "address": _address(program, ".py")},
        "notebooks": {each: _address(make_notebook(lesson).encode(), ".ipynb") for each, lesson in lessons.items()},
    }


def _guess(versions: Mapping[str, Guess]) -> dict[str, Any]:
    """Values of a guess in the template, from the guess in each language."""
    return {
        "right": versions["en"].right,
        "question": {each: _pieces(guess.question) for each, guess in versions.items()},
        "choices": [
            {each: _pieces(choice) for each, choice in zip(versions, choices, strict=True)}
            for choices in zip(*(guess.lettered() for guess in versions.values()), strict=True)
        ],
        "result": {each: _pieces(guess.result()) for each, guess in versions.items()},
    }


def _teachers_notes(name: str) -> dict[str, Any] | None:
    """The notes on a lesson for teachers in all languages; None for one that is not of the package."""
    if name not in notes("en").lessons:
        return None
    found = {each: asdict(notes(each).lessons[name]) for each in LANGUAGES}
    return {part: {each: _pieces(str(found[each][part])) for each in LANGUAGES} for part in found["en"]}


def _pieces(text: str) -> list[tuple[str, str]]:
    """Kind and content of the parts of a text; formulas as MathML, each with the stops behind it."""
    written: dict[str, Callable[[str], str]] = {"text": unbroken, "code": str, "formula": in_mathml}
    found: list[tuple[str, str]] = []
    for kind, piece in pieces(text):
        # Browsers end a line between a formula and a stop.
        stops = closing(piece) if kind == "text" and found and found[-1][0] == "formula" else ""
        if stops:
            found[-1] = "formula", found[-1][1] + escape(stops)
        found.append((kind, written[kind](piece[len(stops) :])))
    return found


def _film(picture: bytes, ending: str) -> dict[str, Any]:
    """A film, with its last frame, or a picture, and its size."""
    size, last = size_and_last_frame(picture)
    last_frame = _address(last, ".png") if ending == ".gif" else None
    return {"picture": _address(picture, ending), "size": size, "last_frame": last_frame}


@cache
def _dragon() -> bytes:
    """The film at the top of the page: the march of the reference scenario into its first contact."""
    with tempfile.TemporaryDirectory(prefix="pymunk-dragon-") as folder, in_language("en"):
        file = Path(folder) / "march.gif"
        render(March(), file, FILM)
        return file.read_bytes()


def _highlighted(code: str) -> str:
    """Python code as HTML with a class for each kind of token."""
    with optional_imports():
        from pygments import highlight
        from pygments.formatters import HtmlFormatter
        from pygments.lexers import PythonLexer
    return str(highlight(code, PythonLexer(), HtmlFormatter(nowrap=True)))


def _address(content: bytes, ending: str) -> str:
    return data_address(content, MEDIA_TYPES[ending])
