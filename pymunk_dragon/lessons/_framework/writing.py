"""Lessons as files: a page, a notebook, or the program itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.lessons._framework.catalogue import check_language
from pymunk_dragon.lessons._framework.demo import Demo
from pymunk_dragon.lessons._framework.notebook import notebook
from pymunk_dragon.lessons._framework.page import check_libraries, page
from pymunk_dragon.lessons._framework.performance import Performance, perform

__all__ = ["PAGE", "endings", "write_lessons"]

PAGE, NOTEBOOK, PROGRAM = ".html", ".ipynb", ".py"


def endings(demos: Sequence[Demo]) -> tuple[str, ...]:
    """Endings of the files in which these lessons can be written: only a page holds several."""
    return (PAGE, NOTEBOOK, PROGRAM) if len(demos) == 1 else (PAGE,)


def write_lessons(
    demos: Sequence[Demo],
    path: str | Path,
    *,
    language: str = "en",
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write one lesson as a notebook or as its program, or any number of them as one page.

    Parameters
    ----------
    demos : sequence of Demo
        The lessons; for a page each of them is played.
    path : path
        File to write, ending in .html, .ipynb or .py. An interrupted one leaves the old file or none.
    language : str
        One of `LANGUAGES`: that of a notebook's text, or in which a page opens. A program is as it is.
    progress : callable, optional
        Told the number of lessons played, and of all of them, after each one.

    Raises
    ------
    ParameterError
        If the file cannot be made, or there is no such language.
    MissingExtraError
        If what makes pages or notebooks, or what a lesson draws with, is not installed.
    DragonError
        If a lesson shows no picture.
    OutputError
        If writing fails.

    Examples
    --------
    >>> write_lessons(list(DEMOS.values()), "lessons.html", language="zh")  # doctest: +SKIP
    """
    check_language(language)
    destination = check_destination(path, endings(demos))
    ending = destination.suffix.lower()
    if ending == PROGRAM:
        text = demos[0].source
    elif ending == NOTEBOOK:
        text = notebook(demos[0], language)
    else:
        text = page(list(_played(demos, progress or (lambda done, total: None))), language)
    with written_in_place(destination) as draft:
        draft.write_bytes(text.encode("utf-8"))


def _played(demos: Sequence[Demo], tell: Callable[[int, int], None]) -> Iterator[Performance]:
    check_libraries()
    for done, demo in enumerate(demos, start=1):
        yield perform(demo)
        tell(done, len(demos))
