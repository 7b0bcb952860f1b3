"""`pymunk-dragon render`."""

from pathlib import Path
from typing import Any

import click

from pymunk_dragon._files import check_destination
from pymunk_dragon._language import text
from pymunk_dragon.cli.options import (
    chosen_march,
    command,
    flags_given,
    load_run,
    option_group,
    options_of,
    output_option,
    scenario_options,
)
from pymunk_dragon.cli.output import print_file_result, progress
from pymunk_dragon.drawing import FILM_ENDINGS, OVERLAYS, STILL_ENDINGS, Camera, Film
from pymunk_dragon.drawing import render as render_film
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player import PLAYER_ENDINGS, write_player

# Options that only films have, and those that only films and pictures have.
_OF_FILMS = ("start", "speedup", "fps", "hold")
_OF_PICTURES = ("exact", "size", "follow", "span", "caption", "legend", *OVERLAYS)
_FORMATS = (
    f"a film, {', '.join(FILM_ENDINGS)}; .png, a picture at --until; or .html, a page that plays"
    " the run"
)


def pixels(given: str) -> int | tuple[int, ...]:
    """One length, or two with an x between them; `Film` checks them."""
    try:
        width, *height = map(int, given.lower().split("x"))
    except ValueError:
        message = f"{given!r} is neither a size as 640x360 nor a width as 480"
        raise click.BadParameter(message) from None
    return (width, *height) if height else width


_OPTIONS = {
    "until": (float, "Last time, s.  [the run's, or a march's first contact]"),
    "speedup": (float, "Simulated s in 1 s of film.  [slower towards contacts]"),
    "fps": (int, "Frames in a second, at most 60, and 50 in a GIF.  [20]"),
    "size": (pixels, "Width and height: 440, or 640x360; even in .mp4.  [440]"),
    "span": (float, "Width of the ground in view, m."),
    "hold": (float, "How long the last frame stays, s.  [2.5]"),
    "title": (str, "A line above the picture."),
    "caption": (str, "Lines below the picture."),
}


@command("run.npz", "run.npz --exact --camera head -o both.mp4", "--until 60 -o march.gif")
@click.argument("run_files", metavar="[RUN.npz]...", nargs=-1, type=click.Path())
@scenario_options
@click.option("--exact", is_flag=True, help="Show the exact model beside the run.")
@click.option("--from", "start", type=float, help="First time, s.  [such that a film takes 11 s]")
@options_of(_OPTIONS)
@click.option(
    "--camera",
    "follow",
    type=click.Choice(["field", "head", "cut"]),
    default="field",
    help="The view.  [field]",
)
@option_group(
    *(
        click.option(f"--{name}", name, is_flag=True, help=each.shows)
        for name, each in OVERLAYS.items()
    )
)
@click.option(
    "--legend/--no-legend", default=None, help="Legend and scale bar below the picture.  [shown]"
)
@output_option(_FORMATS, "RUN.gif")
def render(run_files: tuple[str, ...], output: str | None, exact: bool, **choices: Any) -> None:
    """Film a run, several side by side, or an exact march.

    Without a run, the exact march of the options is filmed. The ending of the file chooses the
    format.
    """
    name = Path(run_files[0]).stem if run_files else "march"
    endings = (*FILM_ENDINGS, *STILL_ENDINGS, *PLAYER_ENDINGS)
    path = check_destination(output or f"{name}.gif", endings)
    sources = _sources(run_files, exact)
    if path.suffix.lower() in PLAYER_ENDINGS:
        _write_page(sources, path, choices["title"])
    else:
        _write_film(sources, path, choices)
    print_file_result(path)


def _write_film(sources: list[Run | March], path: Path, choices: dict[str, Any]) -> None:
    """Write a film, or a picture of its last time."""
    if path.suffix.lower() in STILL_ENDINGS:
        _refuse("a picture", *_OF_FILMS)
    overlays = tuple(name for name in OVERLAYS if choices.pop(name))
    camera = Camera(follow=choices.pop("follow"), span=choices.pop("span"))
    given = {name: value for name, value in choices.items() if value is not None}

    with progress("render") as show:
        film = Film(camera=camera, show=overlays, **given)
        try:
            timing = render_film(sources, path, film, show)
        except ParameterError as error:
            if error.name == "show":
                raise click.UsageError(f"--{error.value} must be {error.bound}") from error
            raise

    if timing.is_cropped and timing.size is not None:
        width, height = timing.size
        note = text(
            "{path} has {width} x {height} pixels, as the width and height of an MP4 are even",
            path=path,
            width=width,
            height=height,
        )
        click.echo(note, err=True)


def _write_page(sources: list[Run | March], path: Path, title: str | None) -> None:
    """Write a page that plays a run."""
    _refuse("a page", "until", *_OF_FILMS, *_OF_PICTURES)
    run, *others = sources
    if others or not isinstance(run, Run):
        raise click.UsageError("a page plays one run: name one, or write a film")
    write_player(run, path, title=title)


def _sources(run_files: tuple[str, ...], exact: bool) -> list[Run | March]:
    """The runs, with --exact also the march of the first; without runs, the scenario's march."""
    if not run_files:
        if exact:
            raise click.UsageError("--exact needs a run: name one, or leave it out")
        return [chosen_march()]
    runs = [load_run(file) for file in run_files]
    return [*runs, runs[0].march] if exact else [*runs]


def _refuse(what: str, *names: str) -> None:
    """Raise a usage error if an option was given that `what` does not have."""
    for flag in flags_given(*names):
        raise click.UsageError(f"{what} has no {flag}: leave it out, or write a film")
