"""`pymunk-dragon demo`."""

from __future__ import annotations

from typing import Any

import click

from pymunk_dragon.cli.options import destination_of, json_option, output_option
from pymunk_dragon.cli.output import print_json, progress
from pymunk_dragon.errors import ParameterError

__all__ = ["demo"]


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
    from pymunk_dragon.lessons import DEMOS, Terminal, write_lessons
    from pymunk_dragon.lessons._framework import check_language, endings

    check_language(language)
    if name is not None and name not in DEMOS:
        raise ParameterError("lesson", name, "one of " + ", ".join(DEMOS))
    lessons = list(DEMOS.values()) if name is None else [DEMOS[name]]
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
        _list(language, as_json)
    elif as_json:
        print_json(_played(name, save, language))
    else:
        DEMOS[name].play(Terminal(save, language, pause))


def _list(language: str, as_json: bool) -> None:
    from pymunk_dragon.lessons import DEMOS
    from pymunk_dragon.lessons._framework import check_output

    titles = {name: one.said("title", language) for name, one in DEMOS.items()}
    if as_json:
        print_json({"lessons": titles})
    else:
        check_output(language)
        rows = (f"{number:>2}  {name:<14} {title}" for number, (name, title) in enumerate(titles.items(), start=1))
        click.echo("\n".join(rows))


def _played(name: str, save: str | None, language: str) -> dict[str, Any]:
    """What a lesson says, what it printed, and where its picture is, if it was kept."""
    from pymunk_dragon.lessons import DEMOS, perform
    from pymunk_dragon.lessons._framework import PARTS

    found = perform(DEMOS[name], save)
    said = {part: found.demo.said(part, language) for part in PARTS}
    return {"lesson": name, "said": said, "printed": found.printed, "picture": str(found.file) if save else None}
