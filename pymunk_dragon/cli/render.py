"""`pymunk-dragon render`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click
import numpy as np

from pymunk_dragon._files import check_destination
from pymunk_dragon._language import text
from pymunk_dragon.cli import options
from pymunk_dragon.cli.output import print_file, progress, wrote
from pymunk_dragon.drawing import FILM_ENDINGS, OVERLAYS, STILL_ENDINGS, Camera, Film, write_film, write_still
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player import PLAYER_ENDINGS, write_player

# s: default length of a film of a march without contact.
MARCH_FILM = 60.0
# m: distance that the head travels between the frames of a march in a player.
PLAYER_STRIDE = 0.1
# Options that only films have, and those that only films and pictures have.
OF_FILMS = ("speedup", "fps", "hold")
OF_PICTURES = ("exact", "size", "follow", "span", "caption", "legend", "font", *OVERLAYS)


def pixels(given: str) -> int | tuple[int, ...]:
    """One length, or two with an x between them; `Film` checks them."""
    try:
        width, *height = map(int, given.lower().split("x"))
    except ValueError:
        raise click.BadParameter(f"{given!r} is neither a size as 640x360 nor a width as 480") from None
    return (width, *height) if height else width


def overlay_options(function: options.F) -> options.F:
    """Add a flag for each overlay to a command."""
    for name, overlay in reversed(list(OVERLAYS.items())):
        click.option(f"--{name}", is_flag=True, help=overlay.shows)(function)
    return function


@click.command(
    cls=options.DragonCommand,
    examples=("run.npz", "run.npz --exact --camera head -o both.mp4", "--until 60 -o march.gif"),
    names=FILM_ENDINGS,
)
@click.argument("run_files", metavar="[RUN.npz]...", nargs=-1, type=click.Path())
@options.scenario_options
@click.option("--exact", is_flag=True, help="Show the exact model beside the run.")
@click.option("--from", "start", type=float, metavar="T", help="First time, s.  [such that a film takes 11 s]")
@click.option("--until", type=float, metavar="T", help="Last time, s.  [the run's, or a march's first contact]")
@click.option("--speedup", type=float, metavar="X", help="Simulated s in 1 s of film.  [slower towards contacts]")
@click.option("--fps", type=int, metavar="N", help="Frames in a second, at most 60, and 50 in a GIF.  [20]")
@click.option("--size", type=pixels, metavar="PIXELS", help="Width and height: 440, or 640x360.  [440]")
@click.option(
    "--camera", "follow", type=click.Choice(["field", "head"]), default="field", help="What is in view.  [field]"
)
@click.option("--span", type=float, metavar="M", help="Width of the ground in view, m.")
@click.option("--hold", type=float, metavar="T", help="How long the last frame stays, s.  [2.5]")
@overlay_options
@click.option("--title", metavar="TEXT", help="A line above the picture.")
@click.option("--caption", metavar="TEXT", help="Lines below the picture.")
@click.option("--legend/--no-legend", default=None, help="Legend and scale bar below the picture.  [shown]")
@click.option("--font", metavar="FILE", type=click.Path(), help="Face of the type, for what the usual one lacks.")
@options.json_option
@options.output_option("a film; .png, a picture at --until; or .html, a page that plays the run", "RUN.gif")
def render(
    run_files: tuple[str, ...], scenario_file: str | None, as_json: bool, output: str | None, **choices: Any
) -> None:
    """Film a run, several side by side, or an exact march.

    Without a run, the exact march of the options is filmed. The ending of the file chooses the format. Those of films
    are {names}.
    """
    name = Path(run_files[0]).stem if run_files else "march"
    destination = check_destination(output or f"{name}.gif", (*FILM_ENDINGS, *STILL_ENDINGS, *PLAYER_ENDINGS))
    ending, facts = options.ending_of(destination), list[str]()
    overlays = tuple(name for name in OVERLAYS if choices.pop(name))
    camera = Camera(follow=choices.pop("follow"), span=choices.pop("span"))
    sources = _sources(run_files, scenario_file, choices.pop("exact"))
    given = {name: value for name, value in choices.items() if value is not None}
    if isinstance(sources[0], March):
        given.setdefault("until", _end(sources[0], given.get("start", 0.0), film=ending in FILM_ENDINGS))
    film = Film(camera=camera, show=overlays, **given)
    if ending in PLAYER_ENDINGS:
        _refuse("a page", *OF_FILMS, *OF_PICTURES)
        _write_player(sources, destination, given)
    elif ending in STILL_ENDINGS:
        _refuse("a picture", "start", *OF_FILMS)
        write_still(sources, film.window(sources)[1], destination, film)
    else:
        facts = _write_film(sources, destination, film)
    wrote(destination, *facts)
    if as_json:
        print_file(destination)


def _write_film(sources: list[Run | March], path: Path, film: Film) -> list[str]:
    """Write a film, and return how long it is."""
    with progress("frame", "frame {done}") as show:
        timing = write_film(sources, path, film, show)
    count, start = text("{count} frames"), text("from t = {time:g} s")
    return [count.format(count=len(timing.times)), f"{timing.ends[-1]:.1f} s", start.format(time=timing.times[0])]


def _write_player(sources: list[Run | March], path: Path, given: dict[str, Any]) -> None:
    """Write a page that plays a run, or the exact run of a march."""
    if len(sources) > 1:
        raise click.UsageError("a page plays one run: name one, or write a film")
    [source] = sources
    if isinstance(source, Run):
        _refuse("a page that plays a whole run", "start", "until")
        run = source
    else:
        start, until = given.get("start", 0.0), given["until"]
        times = np.arange(start, until, PLAYER_STRIDE / float(source.speed_profile.fastest(start, until)))
        run = Run.exact(source, np.append(times, until))
    with progress("page", "page") as show:
        write_player(run, path, title=given.get("title"), progress=show)


def _sources(run_files: tuple[str, ...], scenario_file: str | None, exact: bool) -> list[Run | March]:
    """Return the runs, and with --exact the march of the first one; without runs, the march of the scenario."""
    if not run_files:
        if exact:
            raise click.UsageError("--exact needs a run: name one, or leave it out")
        return [options.march_of(scenario_file)]
    runs = [options.run_of(file, scenario_file) for file in run_files]
    return [*runs, runs[0].march] if exact else [*runs]


def _end(march: March, start: float, *, film: bool) -> float:
    """Default last time of a march, s: of a film, the first contact on a curve with an end."""
    from pymunk_dragon.collision import first_contact

    if film and start < march.end < math.inf:
        found = first_contact(march, start=start)
        if found.status == "contact":
            return found.time
    return min(start + MARCH_FILM, march.end)


def _refuse(what: str, *names: str) -> None:
    """Raise a usage error if an option was given that `what` does not have."""
    context = click.get_current_context()
    for option in context.command.params:
        if option.name in names and options.is_given(context, option.name):
            raise click.UsageError(f"{what} has no {option.opts[0]}: leave it out, or write a film")
