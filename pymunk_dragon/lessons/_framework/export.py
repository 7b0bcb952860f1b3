"""Lessons as files: a page, a notebook, or the program itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.lessons._framework.lesson_file import LessonFile
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.page import check_libraries, make_page
from pymunk_dragon.lessons._framework.play import record
from pymunk_dragon.lessons._framework.translations import check_language

PAGE, NOTEBOOK, PROGRAM = ".html", ".ipynb", ".py"


def endings(lessons: Sequence[LessonFile]) -> tuple[str, ...]:
    """Endings of the files that `write_lessons` writes for these lessons: only a page holds several."""
    return (PAGE, NOTEBOOK, PROGRAM) if len(lessons) == 1 else (PAGE,)


def write_lessons(
    lessons: Sequence[LessonFile],
    path: str | Path,
    *,
    language: str = "en",
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write one lesson as a notebook or as its program, or any number of lessons as one page.

    Parameters
    ----------
    lessons : sequence of LessonFile
        The lessons; for a page each of them is run.
    path : path
        File to write, ending in .html, .ipynb or .py. An interrupted call leaves the old file or none.
    language : str
        One of `LANGUAGES`: that of the texts of a notebook, or in which a page opens. A program is English.
    progress : callable, optional
        Called with the number of lessons that were run, and of all, after each one.

    Raises
    ------
    ParameterError
        If the file cannot be written, or the language is unknown.
    MissingExtraError
        If a library for pages or notebooks, or one that a lesson uses, is not installed.
    DragonError
        If a lesson shows no picture.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS, write_lessons
    >>> write_lessons([LESSONS["spiral"]], "lessons.html", language="zh")
    """
    check_language(language)
    destination = check_destination(path, endings(lessons))
    ending = destination.suffix.lower()
    if ending == PROGRAM:
        text = lessons[0].source
    elif ending == NOTEBOOK:
        text = make_notebook(lessons[0].in_language(language))
    else:
        check_libraries()
        recordings = []
        for done, lesson in enumerate(lessons, start=1):
            recordings.append(record(lesson))
            if progress is not None:
                progress(done, len(lessons))
        text = make_page(recordings, language)
    with written_in_place(destination) as draft:
        draft.write_bytes(text.encode("utf-8"))
