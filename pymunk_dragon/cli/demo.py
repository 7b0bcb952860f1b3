"""`pymunk-dragon demo`."""

from pathlib import Path
from typing import Any

import click

from pymunk_dragon._extras import library
from pymunk_dragon._language import language
from pymunk_dragon.cli.options import address_options, command, flags_given, output_option
from pymunk_dragon.cli.output import (
    print_file_result,
    print_list,
    print_result,
    progress,
    wants_json,
)
from pymunk_dragon.lessons import LESSONS, Lesson, play, write_lessons
from pymunk_dragon.lessons._framework.page import run_page
from pymunk_dragon.lessons._framework.recording import record


@command("", "spiral", "chain --lang zh", "-o lessons.html", "--live")
@click.argument("name", metavar="[LESSON]", required=False, type=click.Choice(list(LESSONS)))
@click.option("--save", type=click.Path(), help="Folder for the picture.  [a temporary one]")
@click.option(
    "--live",
    is_flag=True,
    help="Show the lessons on a page whose experiments with Pymunk are live.",
)
@address_options
@output_option(".html, a page of the lesson, or of all; .ipynb, its notebook; .py, its program")
def demo(
    name: str | None, save: str | None, output: str | None, live: bool, **address: Any
) -> None:
    """Play a lesson.

    Without a name, list them. Each has a question, a guess, an experiment, the answer and a number
    to check.
    """
    lessons = list(LESSONS.values()) if name is None else [LESSONS[name]]
    _refuse_combinations(name, {*flags_given("save", "output", "live", "json", *address)})
    if live:
        _serve(lessons, address)
    elif output is not None:
        with progress("demo") as show:
            write_lessons(lessons, output, language=language(), progress=show)
        print_file_result(Path(output))
    elif name is None:
        titles = {each.name: each.sections(language())["Title"] for each in lessons}
        print_list("lessons", titles)
    elif wants_json():
        print_result({"printed": record(LESSONS[name]).printed})
    else:
        play(LESSONS[name], save, language=language())


def _refuse_combinations(name: str | None, flags: set[str]) -> None:
    """Raise a usage error for flags that exclude each other, or are for another way to play."""
    if "--save" in flags and (name is None or flags & {"-o", "--live", "--json"}):
        bound = "give its name, and no -o, --live or --json"
        raise click.UsageError(f"--save is for a lesson that is played: {bound}")
    # What remains are the options of a server.
    of_server = flags - {"-o", "--save", "--json", "--live"}
    is_live = "--live" in flags
    if (is_live and "-o" in flags) or (of_server and not is_live):
        raise click.UsageError("--live needs no -o, and the options of a server need --live")


def _serve(lessons: list[Lesson], address: dict[str, Any]) -> None:
    """Run the lessons, and show their page on a live server until it is stopped."""
    library("aiohttp")
    from pymunk_dragon.cli.live import serve
    from pymunk_dragon.sessions.scenes import add, named_scene
    from pymunk_dragon.sessions.session import Session

    with progress("demo") as show:
        page = run_page(lessons, language(), show, site=True)
    for each in lessons:
        if each.builds_scene:
            add(**each.scene())
    scenes = [each.options["scene"] for each in lessons if "scene" in each.options]
    session = Session(named_scene(scenes[0] if scenes else "dragon"))
    serve(session, None, None, front=page, **address)
