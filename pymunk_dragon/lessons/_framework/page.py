"""Lessons on a page: one HTML file with its texts, films and code inside, which asks nobody for anything."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pymunk_dragon._extras import library
from pymunk_dragon._html import asset, data_address, filled, policy
from pymunk_dragon.drawing.film.stills import last_frame, picture_size
from pymunk_dragon.lessons._framework.catalogue import LANGUAGES, PARTS, unbroken, with_code, word
from pymunk_dragon.lessons._framework.demo import CODE, Demo
from pymunk_dragon.lessons._framework.notebook import notebook
from pymunk_dragon.lessons._framework.performance import Performance

__all__ = ["check_libraries", "page"]

# Words of the page that are in the catalogues.
WORDS = ("page_title", "page_subtitle", "contents", "run", "code", "top")
TYPES = {".gif": "image/gif", ".png": "image/png", ".py": "text/x-python", ".ipynb": "application/x-ipynb+json"}


def check_libraries() -> None:
    """Make sure that a page can be made, before the lessons are played.

    Raises
    ------
    MissingExtraError
        If Jinja2, Pygments or nbformat is not installed.
    """
    # Whoever has none of them is told of the extra that brings all.
    for name in ("pygments", "nbformat", "jinja2"):
        library(name)


def page(performances: Sequence[Performance], language: str = "en") -> str:
    """Lessons with all that came of playing them, in all languages; a button goes from one to the next.

    Parameters
    ----------
    performances : sequence of Performance
        The lessons.
    language : str
        The language in which the page opens.

    Raises
    ------
    MissingExtraError
        If Jinja2, Pygments or nbformat is not installed.
    """
    style, script = asset(__package__, "assets/lessons.css"), asset(__package__, "assets/lessons.js")
    return filled(
        __package__,
        "assets/lessons.html.j2",
        language=language,
        languages={each: word("language", each) for each in LANGUAGES},
        words={name: {each: word(name, each) for each in LANGUAGES} for name in (*WORDS, *PARTS[1:])},
        lessons=[_lesson(performance) for performance in performances],
        policy=policy(style, script, pictures="data: blob:"),
        style=style,
        script=script,
    )


def _lesson(performance: Performance) -> dict[str, Any]:
    demo = performance.demo
    ending = performance.file.suffix
    return {
        "name": demo.name,
        "texts": {part: _in_all_languages(demo, part) for part in PARTS},
        "printed": performance.printed.strip("\n"),
        "picture": _data(performance.picture, ending),
        "size": picture_size(performance.picture),
        "last_frame": _data(last_frame(performance.picture), ".png") if ending == ".gif" else None,
        "code": _coloured("\n\n".join(block.text for block in demo.blocks if block.kind == CODE)),
        "program": {"file": demo.path.name, "data": _data(demo.source.encode(), ".py")},
        "notebooks": {
            each: {"file": f"{demo.name}.ipynb", "data": _data(notebook(demo, each).encode(), ".ipynb")}
            for each in LANGUAGES
        },
    }


def _in_all_languages(demo: Demo, part: str) -> dict[str, list[tuple[str, bool]]]:
    return {each: with_code(unbroken(demo.said(part, each))) for each in LANGUAGES}


def _coloured(code: str) -> str:
    """Code as HTML with a class for each kind of word."""
    lexer, formatter = (
        library("pygments.lexers").PythonLexer(),
        library("pygments.formatters").HtmlFormatter(nowrap=True),
    )
    return str(library("pygments").highlight(code, lexer, formatter))


def _data(content: bytes, ending: str) -> str:
    return data_address(content, TYPES[ending])
