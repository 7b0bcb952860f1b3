"""`pymunk-dragon demo`."""

from __future__ import annotations

from dataclasses import asdict

import click

from pymunk_dragon._checks import did_you_mean
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination
from pymunk_dragon._language import language
from pymunk_dragon.cli import options
from pymunk_dragon.cli.output import print_file, print_json, progress, wrote
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.lessons import LESSONS, LessonFile, Terminal, play, record, write_lessons
from pymunk_dragon.lessons._framework import PARTS, check_output, endings

# Instead of a lesson's name.
ALL = "all"


@click.command(cls=options.DragonCommand, examples=("", "spiral", "3 --lang zh", "all -o lessons.html"))
@click.argument("name", required=False, shell_complete=options.named(lambda: [*LESSONS, ALL]))
@click.option("--save", metavar="DIR", type=click.Path(), help="Folder for the picture.  [a temporary one]")
@click.option("--pause", is_flag=True, help="Wait for Enter once the class has made its guess.")
@options.json_option
@options.output_option(".html, a page of the lesson, or of all; .ipynb, its notebook; .py, its program")
def demo(name: str | None, save: str | None, pause: bool, as_json: bool, output: str | None) -> None:
    """Play a lesson by its name or number, or all lessons.

    Without a name, list them. Each has a question, a prediction, a run, the answer, a number to check and something to
    try.
    """
    lessons = list(LESSONS.values()) if name is None or name == ALL else [_lesson_of(name)]
    if (save is not None or pause) and (name is None or output is not None):
        raise click.UsageError("--save and --pause are for a lesson that is played: give its name, and no -o")
    if output is not None:
        _write(lessons, output, as_json)
    elif name is None:
        _list(lessons, as_json)
    elif as_json:
        _print_recording(lessons, save)
    else:
        _play(lessons, Terminal(save, pause, language()))


def _lesson_of(name: str) -> LessonFile:
    """The lesson of a name or a number."""
    if name.isdecimal() and 1 <= int(name) <= len(LESSONS):
        return list(LESSONS.values())[int(name) - 1]
    if name not in LESSONS:
        bound = f"a number from 1 to {len(LESSONS)}, {ALL}, or one of {', '.join(LESSONS)}"
        raise ParameterError("lesson", name, bound + did_you_mean(name, LESSONS))
    return LESSONS[name]


def _write(lessons: list[LessonFile], output: str, as_json: bool) -> None:
    """Write a page, a notebook or a program."""
    destination = check_destination(output, endings(lessons))
    with progress("lessons", "lesson {done} of {total}") as show:
        write_lessons(lessons, destination, language=language(), progress=show)
    wrote(destination)
    if as_json:
        print_file(destination)


def _list(lessons: list[LessonFile], as_json: bool) -> None:
    """Print the names and titles of the lessons."""
    titles = {lesson.name: lesson.in_language(language()).title for lesson in lessons}
    if as_json:
        print_json({"lessons": titles})
        return
    check_output(language())
    for number, (name, title) in enumerate(titles.items(), start=1):
        click.echo(f"{number:>2}  {name:<14} {title}")


def _play(lessons: list[LessonFile], terminal: Terminal) -> None:
    """Play lessons, once it is sure that all of them can be played."""
    for needed in (needed for lesson in lessons for needed in lesson.libraries):
        library(needed)
    check_output(language())
    for lesson in lessons:
        play(lesson, terminal)


def _print_recording(lessons: list[LessonFile], save: str | None) -> None:
    """Run a lesson, and print its texts and what it printed."""
    if len(lessons) > 1:
        raise click.UsageError("--json is for one lesson: give its name")
    [lesson] = lessons
    recording, translated = record(lesson, save), lesson.in_language(language())
    said = {part: translated.text(part) for part in PARTS}
    guesses = [asdict(guess) for guess in translated.guesses]
    result = {"lesson": lesson.name, "said": said, "guesses": guesses, "printed": recording.printed}
    print_json(result | {"picture": str(recording.file) if save else None})
