"""`pymunk-dragon render`, `figure` and `report`: what is made from a run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click
import numpy as np

from pymunk_dragon._files import check_destination
from pymunk_dragon._language import text
from pymunk_dragon.cli import common
from pymunk_dragon.drawing import FILM_ENDINGS, OVERLAYS, STILL_ENDINGS, Camera, Film
from pymunk_dragon.drawing import render as render_film
from pymunk_dragon.drawing.figures import FIGURES, write_figure
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player import PLAYER_ENDINGS, write_player
from pymunk_dragon.reports import REPORT_ENDINGS
from pymunk_dragon.reports import report as write_report

# s: default length of a film of a march without contact.
_MARCH_FILM = 60.0
# m: distance that the head travels between the frames of a march in a player.
_PLAYER_STRIDE = 0.1
# Options that only films have, and those that only films and pictures have.
_OF_FILMS = ("speedup", "fps", "hold")
_OF_PICTURES = ("exact", "size", "follow", "span", "caption", "legend", *OVERLAYS)
EXAMPLES = ("run.npz", "run.npz --exact --camera head -o both.mp4", "--until 60 -o march.gif")
FORMATS = f"a film, {', '.join(FILM_ENDINGS)}; .png, a picture at --until; or .html, a page that plays the run"


def pixels(given: str) -> int | tuple[int, ...]:
    """One length, or two with an x between them; `Film` checks them."""
    try:
        width, *height = map(int, given.lower().split("x"))
    except ValueError:
        raise click.BadParameter(f"{given!r} is neither a size as 640x360 nor a width as 480") from None
    return (width, *height) if height else width


def _overlay_options(function: common.F) -> common.F:
    """Add a flag for each overlay to a command."""
    for name, overlay in reversed(list(OVERLAYS.items())):
        click.option(f"--{name}", is_flag=True, help=overlay.shows)(function)
    return function


@click.command(cls=common.DragonCommand, examples=EXAMPLES)
@click.argument("run_files", metavar="[RUN.npz]...", nargs=-1, type=click.Path())
@common.scenario_options
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
@_overlay_options
@click.option("--title", metavar="TEXT", help="A line above the picture.")
@click.option("--caption", metavar="TEXT", help="Lines below the picture.")
@click.option("--legend/--no-legend", default=None, help="Legend and scale bar below the picture.  [shown]")
@common.output_option(FORMATS, "RUN.gif")
def render(run_files: tuple[str, ...], output: str | None, **choices: Any) -> None:
    """Film a run, several side by side, or an exact march.

    Without a run, the exact march of the options is filmed. The ending of the file chooses the format.
    """
    name = Path(run_files[0]).stem if run_files else "march"
    path = check_destination(output or f"{name}.gif", (*FILM_ENDINGS, *STILL_ENDINGS, *PLAYER_ENDINGS))
    overlays = tuple(name for name in OVERLAYS if choices.pop(name))
    camera = Camera(follow=choices.pop("follow"), span=choices.pop("span"))
    sources = _sources(run_files, choices.pop("exact"))
    if isinstance(sources[0], March) and choices["until"] is None:
        choices["until"] = _end(sources[0], choices["start"] or 0.0, film=path.suffix.lower() in FILM_ENDINGS)
    given = {name: value for name, value in choices.items() if value is not None}
    facts = _write(sources, path, Film(camera=camera, show=overlays, **given), choices)
    common.answer_with_file(path, *facts)


def _write(sources: list[Run | March], path: Path, film: Film, choices: dict[str, Any]) -> list[str]:
    """Write a page, a picture or a film, and return how long a film is."""
    if path.suffix.lower() in PLAYER_ENDINGS:
        _refuse("a page", *_OF_FILMS, *_OF_PICTURES)
        _write_player(sources, path, choices)
        return []
    if path.suffix.lower() in STILL_ENDINGS:
        _refuse("a picture", "start", *_OF_FILMS)
        render_film(sources, path, film)
        return []
    with common.progress("frame", "frame {done}") as show:
        timing = render_film(sources, path, film, show)
    count, start = text("{count} frames"), text("from t = {time:g} s")
    return [count.format(count=len(timing.times)), f"{timing.ends[-1]:.1f} s", start.format(time=timing.times[0])]


def _write_player(sources: list[Run | March], path: Path, choices: dict[str, Any]) -> None:
    """Write a page that plays a run, or the exact run of a march."""
    if len(sources) > 1:
        raise click.UsageError("a page plays one run: name one, or write a film")
    [source] = sources
    if isinstance(source, Run):
        _refuse("a page that plays a whole run", "start", "until")
        run = source
    else:
        start, until = choices["start"] or 0.0, choices["until"]
        times = np.arange(start, until, _PLAYER_STRIDE / source.speed_profile.fastest(start, until))
        run = Run.exact(source, np.append(times, until))
    with common.progress("page", "page") as show:
        write_player(run, path, title=choices["title"], progress=show)


def _sources(run_files: tuple[str, ...], exact: bool) -> list[Run | March]:
    """Return the runs, and with --exact the march of the first one; without runs, the march of the scenario."""
    if not run_files:
        if exact:
            raise click.UsageError("--exact needs a run: name one, or leave it out")
        return [common.march()]
    runs = [common.run_of(file) for file in run_files]
    return [*runs, runs[0].march] if exact else [*runs]


def _end(march: March, start: float, *, film: bool) -> float:
    """Default last time of a march, s: of a film, the first contact on a curve with an end."""
    from pymunk_dragon.collision import first_contact

    if film and start < march.end < math.inf:
        found = first_contact(march, start=start)
        if found.status == "contact":
            return found.time
    return min(start + _MARCH_FILM, march.end)


def _refuse(what: str, *names: str) -> None:
    """Raise a usage error if an option was given that `what` does not have."""
    for flag in common.flags_given(*names):
        raise click.UsageError(f"{what} has no {flag}: leave it out, or write a film")


@click.command(cls=common.DragonCommand, examples=("", "gap --pitch 0.5", "drift run.npz -o drift.pdf"))
@click.argument("name", metavar="[FIGURE]", required=False, type=click.Choice(list(FIGURES)))
@click.argument("run_file", metavar="[RUN.npz]", required=False, type=click.Path())
@common.scenario_options
@common.output_option(".png or .pdf, or .svg where the figure has axes", "NAME.png")
def figure(name: str | None, run_file: str | None, output: str | None) -> None:
    """Draw one of the paper's figures, or one beyond it.

    Without a name, list them. Drift and impulses are drawn from a run of the engine, the others from a run's march or
    from the options.
    """
    if name is None:
        shown = {known: kind.shows for known, kind in FIGURES.items()}
        listed = "\n".join(f"{known:<13} {text(shows)}" for known, shows in shown.items())
        return common.answer({"figures": shown}, listed)
    source: Any = None
    if run_file is not None:
        source = common.run_of(run_file)
    elif common.file_values() or common.chosen():
        source = common.march()
    path = Path(output or f"{name}.png")
    write_figure(name, path, source)
    return common.answer_with_file(path)


@click.command(cls=common.DragonCommand, examples=("run.npz", "run.npz -o run.md"))
@click.argument("run_file", metavar="RUN.npz", type=click.Path())
@common.output_option(", ".join(REPORT_ENDINGS), "RUN.html")
def report(run_file: str, output: str | None) -> None:
    """Report on a run, as a document or a table."""
    destination = check_destination(output or f"{Path(run_file).stem}.html", REPORT_ENDINGS)
    write_report(Run.load(run_file), destination)
    common.answer_with_file(destination)
