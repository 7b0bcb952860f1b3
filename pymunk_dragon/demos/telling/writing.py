"""Lessons as files: a page, a notebook, or the program itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pymunk_dragon.demos.telling.catalogue import check_language
from pymunk_dragon.demos.telling.demo import Demo
from pymunk_dragon.demos.telling.notebook import notebook
from pymunk_dragon.demos.telling.page import check_libraries, page
from pymunk_dragon.demos.telling.performance import perform
from pymunk_dragon.files import check_destination, written_in_place

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
    OutputError
        If writing fails.

    Examples
    --------
    >>> write_lessons(list(DEMOS.values()), "lessons.html", language="zh")  # doctest: +SKIP
    """
    check_language(language)
    destination = check_destination(path, endings(demos))
    tell = progress or (lambda done, total: None)
    with written_in_place(destination) as draft:
        if destination.suffix.lower() == PROGRAM:
            text = demos[0].source
        elif destination.suffix.lower() == NOTEBOOK:
            text = notebook(demos[0], language)
        else:
            check_libraries()
            performances = []
            for demo in demos:
                performances.append(perform(demo))
                tell(len(performances), len(demos))
            text = page(performances, language)
        draft.write_bytes(text.encode("utf-8"))
