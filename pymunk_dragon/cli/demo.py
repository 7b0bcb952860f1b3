"""`pymunk-dragon demo`."""

from __future__ import annotations

from typing import Any

import click

from pymunk_dragon.cli.options import destination_of, json_option, output_option
from pymunk_dragon.cli.output import print_json, progress
from pymunk_dragon.errors import ParameterError


@click.command()
@click.argument("name", required=False)
@click.option("--save", metavar="DIR", help="Folder for the picture.  [a temporary one]")
@click.option("--lang", "language", default="en", metavar="LANG", help="Language of the text: en or zh.  [en]")
@click.option("--pause", is_flag=True, help="Wait for Enter once the class has made its guess.")
@json_option
@output_option(".html, a page of the lesson, or of all; .ipynb, its notebook; .py, its program")
def demo(name: str | None, save: str | None, language: str, pause: bool, as_json: bool, output: str | None) -> None:
    """Play a lesson; without a name, list them.

    Each has a question, a prediction, a run, the answer, a number to check and something to try.
    """
    from pymunk_dragon.lessons import LESSONS, Terminal, play, record, write_lessons
    from pymunk_dragon.lessons._framework import PARTS, check_language, endings

    check_language(language)
    if name is not None and name not in LESSONS:
        raise ParameterError("lesson", name, "one of " + ", ".join(LESSONS))
    lessons = list(LESSONS.values()) if name is None else [LESSONS[name]]
    if (save is not None or pause) and (name is None or output is not None):
        raise click.UsageError("--save and --pause are for a lesson that is played: give its name, and no -o")
    destination = destination_of(output, endings(lessons))
    if destination is not None:
        with progress("lessons") as show:
            write_lessons(
                lessons,
                destination,
                language=language,
                progress=lambda done, total: show(done, total, f"lesson {done} of {total}"),
            )
        if as_json:
            print_json({"output": str(destination), "bytes": destination.stat().st_size})
    elif name is None:
        _list({lesson.name: lesson.text("title", language) for lesson in lessons}, language, as_json)
    elif as_json:
        recording = record(LESSONS[name], save)
        result: dict[str, Any] = {"lesson": name, "said": {part: LESSONS[name].text(part, language) for part in PARTS}}
        print_json(result | {"printed": recording.printed, "picture": str(recording.file) if save else None})
    else:
        play(LESSONS[name], Terminal(save, language, pause))


def _list(titles: dict[str, str], language: str, as_json: bool) -> None:
    """Print the names and titles of the lessons."""
    from pymunk_dragon.lessons._framework import check_output

    if as_json:
        print_json({"lessons": titles})
    else:
        check_output(language)
        for number, (name, title) in enumerate(titles.items(), start=1):
            click.echo(f"{number:>2}  {name:<14} {title}")
