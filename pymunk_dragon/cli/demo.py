"""`pymunk-dragon demo`."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import click

from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination
from pymunk_dragon._language import language
from pymunk_dragon.cli import common
from pymunk_dragon.lessons import LESSONS, Lesson, play, write_lessons
from pymunk_dragon.lessons._framework import endings, make_folder, picture, run, run_page

# Instead of a lesson's name.
_ALL = "all"
_NUMBERS = {str(number): name for number, name in enumerate(LESSONS, start=1)}


EXAMPLES = ("", "spiral", "3 --lang zh", "all -o lessons.html", "--live")
# A lesson's number stands for its name.
_SETTINGS = {"token_normalize_func": lambda token: _NUMBERS.get(token, token)}


@click.command(cls=common.DragonCommand, examples=EXAMPLES, context_settings=_SETTINGS)
@click.argument("name", metavar="[LESSON]", required=False, type=click.Choice([*LESSONS, _ALL]))
@click.option("--save", metavar="DIR", type=click.Path(), help="Folder for the picture.  [a temporary one]")
@click.option("--pause", is_flag=True, help="Wait for Enter once the class has made its guess.")
@click.option("--live", is_flag=True, help="Show the lessons on a page whose experiments with Pymunk are live.")
@common.address_options
@common.output_option(".html, a page of the lesson, or of all; .ipynb, its notebook; .py, its program")
def demo(name: str | None, save: str | None, pause: bool, output: str | None, live: bool, **address: Any) -> None:
    """Play a lesson by its name or number, or all lessons.

    Without a name, list them. Each has a question, a guess, a run, the answer, a number to check and something to
    change.
    """
    lessons = list(LESSONS.values()) if name in (None, _ALL) else [LESSONS[str(name)]]
    if (save is not None or pause) and (name is None or output is not None):
        raise click.UsageError("--save and --pause are for a lesson that is played: give its name, and no -o")
    if common.flags_given(*address) and not live:
        raise click.UsageError("the options of a server need --live")
    if live:
        if save is not None or pause or output is not None:
            raise click.UsageError("--live shows the lessons: leave out --save, --pause and -o")
        _serve(lessons, address)
    elif output is not None:
        _write(lessons, output)
    elif name is None:
        _list(lessons)
    elif common.wants_json():
        _print_recording(lessons, save)
    else:
        for lesson in lessons:
            play(lesson, save, pause=pause, language=language())


def _serve(lessons: list[Lesson], address: dict[str, Any]) -> None:
    """Run the lessons, and show their page on a live server until it is stopped."""
    library("aiohttp")
    from pymunk_dragon.cli.live import serve
    from pymunk_dragon.sessions.ready import ready
    from pymunk_dragon.sessions.session import Session

    with common.progress("demo") as show:
        page = run_page(lessons, language(), show, live=True)
    session = Session(ready(next((each.options["scene"] for each in lessons if "scene" in each.options), "dragon")))
    serve(session, None, None, front=page, **address)


def _write(lessons: list[Lesson], output: str) -> None:
    """Write a page, a notebook or a program."""
    destination = check_destination(output, endings(lessons))
    with common.progress("demo") as show:
        write_lessons(lessons, destination, language=language(), progress=show)
    common.answer_with_file(destination)


def _list(lessons: list[Lesson]) -> None:
    """Print the names and titles of the lessons."""
    titles = {lesson.name: lesson.sections(language())["Title"] for lesson in lessons}
    rows = (f"{number:>2}  {name:<14} {title}" for number, (name, title) in enumerate(titles.items(), start=1))
    common.answer({"lessons": titles}, "\n".join(rows))


def _print_recording(lessons: list[Lesson], save: str | None) -> None:
    """Run a lesson, and print its texts and what it printed."""
    if len(lessons) > 1:
        raise click.UsageError("--json is for one lesson: give its name")
    [lesson] = lessons
    with tempfile.TemporaryDirectory(prefix="pymunk-dragon-") as folder:
        target = Path(folder) if save is None else make_folder(save)
        printed = "".join(run(lesson, target))
        file = None if save is None else str(picture(lesson, target))
    guesses = [
        {"question": each.text, "choices": each.choices, "right": each.right, "outcomes": each.items}
        for each in lesson.guesses(language())
    ]
    said = dict(lesson.sections(language()))
    common.answer({"lesson": lesson.name, "said": said, "guesses": guesses, "printed": printed, "picture": file})
