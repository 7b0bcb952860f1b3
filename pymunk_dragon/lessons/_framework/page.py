"""A page of lessons: one HTML file with their texts in all languages, films and code, which loads nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pymunk_dragon._extras import library, optional_imports
from pymunk_dragon._html import asset, data_address, filled, policy
from pymunk_dragon.drawing.film.stills import last_frame, picture_size
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.play import Recording
from pymunk_dragon.lessons._framework.translations import LANGUAGES, PARTS, heading, unbroken, with_code

# Texts of the page itself in the files of translations.
PAGE_WORDS = ("live", "page_title", "page_subtitle", "contents", "run", "code", "top")
MEDIA_TYPES = {".gif": "image/gif", ".png": "image/png", ".py": "text/x-python", ".ipynb": "application/x-ipynb+json"}


def check_libraries() -> None:
    """Check that the libraries of `make_page` are installed, before lessons are run for it."""
    # Those of the extra [demos] first: it brings all three.
    for name in ("pygments", "nbformat", "jinja2"):
        library(name)


def make_page(recordings: Sequence[Recording], language: str = "en") -> str:
    """Lessons that were run as the text of one HTML page in all languages.

    Parameters
    ----------
    recordings : sequence of Recording
        The lessons with their printed lines and pictures.
    language : str
        The language in which the page opens.

    Returns
    -------
    str
        The page.

    Raises
    ------
    MissingExtraError
        If Jinja2, Pygments or nbformat is not installed.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS, record
    >>> text = make_page([record(LESSONS["spiral"])], "zh")  # doctest: +SKIP
    """
    style, script = asset(__package__, "assets/lessons.css"), asset(__package__, "assets/lessons.js")
    return filled(
        __package__,
        "assets/lessons.html.j2",
        language=language,
        languages={each: heading("language", each) for each in LANGUAGES},
        words={name: {each: heading(name, each) for each in LANGUAGES} for name in (*PAGE_WORDS, *PARTS[1:])},
        lessons=[_values(recording) for recording in recordings],
        policy=policy(style, script, pictures="data: blob:"),
        style=style,
        script=script,
    )


def _values(recording: Recording) -> dict[str, Any]:
    """Values of a lesson in the template."""
    lesson, picture, ending = recording.lesson, recording.picture, recording.file.suffix
    return {
        "name": lesson.name,
        "live": lesson.live,
        "texts": {part: {each: with_code(unbroken(lesson.text(part, each))) for each in LANGUAGES} for part in PARTS},
        "printed": recording.printed.strip("\n"),
        "picture": _address(picture, ending),
        "size": picture_size(picture),
        "last_frame": _address(last_frame(picture), ".png") if ending == ".gif" else None,
        "code": _highlighted(lesson.code),
        "program": {"file": lesson.path.name, "data": _address(lesson.source.encode(), ".py")},
        "notebooks": {
            each: {"file": f"{lesson.name}.ipynb", "data": _address(make_notebook(lesson, each).encode(), ".ipynb")}
            for each in LANGUAGES
        },
    }


def _highlighted(code: str) -> str:
    """Python code as HTML with a class for each kind of token."""
    with optional_imports():
        from pygments import highlight
        from pygments.formatters import HtmlFormatter
        from pygments.lexers import PythonLexer
    return str(highlight(code, PythonLexer(), HtmlFormatter(nowrap=True)))


def _address(content: bytes, ending: str) -> str:
    return data_address(content, MEDIA_TYPES[ending])
