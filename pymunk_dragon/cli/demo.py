"""`pymunk-dragon demo`."""

from __future__ import annotations

from dataclasses import asdict

import click

from pymunk_dragon._extras import library
from pymunk_dragon._language import language, text
from pymunk_dragon.cli.command import DragonCommand
from pymunk_dragon.cli.completion import named
from pymunk_dragon.cli.options import destination_of, json_option, output_option
from pymunk_dragon.cli.output import print_json, progress, wrote
from pymunk_dragon.errors import ParameterError

# Instead of a lesson's name.
ALL = "all"
LIST = "list"


def _lessons() -> dict[str, str]:
    """Names of the lessons, with their titles, and the words that stand for several."""
    from pymunk_dragon.lessons import LESSONS

    titles = {lesson.name: lesson.title for lesson in LESSONS.values()}
    return titles | {ALL: "all lessons", LIST: "their names and titles"}


@click.command(cls=DragonCommand, examples=("", "spiral", "3 --lang zh", "all -o lessons.html"))
@click.argument("name", required=False, shell_complete=named(_lessons))
@click.option("--save", metavar="DIR", type=click.Path(), help="Folder for the picture.  [a temporary one]")
@click.option("--pause", is_flag=True, help="Wait for Enter once the class has made its guess.")
@json_option
@output_option(".html, a page of the lesson, or of all; .ipynb, its notebook; .py, its program")
def demo(name: str | None, save: str | None, pause: bool, as_json: bool, output: str | None) -> None:
    """Play a lesson by its name or number, or all lessons.

    Without a name, list them. Each has a question, a prediction, a run, the answer, a number to check and something to
    try.
    """
    from pymunk_dragon.lessons import LESSONS, Terminal, play, record, write_lessons
    from pymunk_dragon.lessons._framework import PARTS, check_output, endings

    name = _lesson_of(name, list(LESSONS))
    lessons = list(LESSONS.values()) if name in (None, ALL) else [LESSONS[name]]
    if (save is not None or pause) and (name is None or output is not None):
        raise click.UsageError("--save and --pause are for a lesson that is played: give its name, and no -o")
    destination = destination_of(output, endings(lessons))
    lang = language()
    if destination is not None:
        now = text("lesson {done} of {total}")
        with progress("lessons") as show:
            write_lessons(
                lessons,
                destination,
                language=lang,
                progress=lambda done, total: show(done, total, now.format(done=done, total=total)),
            )
        wrote(destination)
        if as_json:
            print_json({"output": str(destination), "bytes": destination.stat().st_size})
    elif name is None:
        _list({lesson.name: lesson.in_language(lang).title for lesson in lessons}, as_json)
    elif as_json:
        if name == ALL:
            raise click.UsageError("--json is for one lesson: give its name")
        lesson = LESSONS[name].in_language(lang)
        recording = record(LESSONS[name], save)
        said = {part: lesson.text(part) for part in PARTS}
        guesses = [asdict(guess) for guess in lesson.guesses]
        result = {"lesson": name, "said": said, "guesses": guesses, "printed": recording.printed}
        print_json(result | {"picture": str(recording.file) if save else None})
    else:
        for each in lessons:
            for needed in each.libraries:
                library(needed)
        check_output(lang)
        for each in lessons:
            play(each, Terminal(save, pause, lang))


def _lesson_of(name: str | None, known: list[str]) -> str | None:
    """The name of a lesson that was given by name or number; None for `list`, which lists them as no name does."""
    if name in (None, LIST):
        return None
    if name.isdecimal() and 1 <= int(name) <= len(known):
        return known[int(name) - 1]
    if name not in (ALL, *known):
        from pymunk_dragon._checks import did_you_mean

        raise ParameterError(
            "lesson",
            name,
            f"a number from 1 to {len(known)}, {ALL}, {LIST}, or one of {', '.join(known)}{did_you_mean(name, known)}",
        )
    return name


def _list(titles: dict[str, str], as_json: bool) -> None:
    """Print the names and titles of the lessons."""
    from pymunk_dragon.lessons._framework import check_output

    if as_json:
        print_json({"lessons": titles})
    else:
        check_output(language())
        for number, (name, title) in enumerate(titles.items(), start=1):
            click.echo(f"{number:>2}  {name:<14} {title}")
