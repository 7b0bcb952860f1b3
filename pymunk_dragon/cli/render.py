"""`pymunk-dragon render`."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

from pymunk_dragon.cli.options import (
    Command,
    chosen,
    destination_of,
    json_option,
    march_of,
    output_option,
    scenario_options,
)
from pymunk_dragon.cli.output import print_json, progress
from pymunk_dragon.errors import ParameterError

if TYPE_CHECKING:
    from pymunk_dragon.march import March
    from pymunk_dragon.run import Run

__all__ = ["render"]

# s: how much of a march is filmed when it is not told.
MARCH_FILM = 60.0

MARKS = {
    "velocities": "Arrows to where the handles would be in half a second.",
    "grid": "The cells of the broad phase, darker where a bench is filed.",
    "contacts": "Where benches touch.",
    "normals": "In which direction they push.",
    "impulses": "Impulses in the joints, as discs.",
}


def mark_options(command: Command) -> Command:
    """Give a command a flag for each mark; `marks` gives the chosen ones."""

    def collect(context: click.Context, parameter: click.Parameter, value: bool) -> None:
        if value:
            context.meta.setdefault("marks", []).append(parameter.name)

    for name, text in reversed(MARKS.items()):
        add = click.option(f"--{name}", is_flag=True, help=text, callback=collect, expose_value=False)
        command = add(command)
    return command


def marks() -> tuple[Any, ...]:
    """The marks whose flags were given."""
    return tuple(click.get_current_context().meta.get("marks", ()))


@click.command()
@click.argument("run_files", metavar="[RUN.npz]...", nargs=-1)
@scenario_options
@click.option("--exact", is_flag=True, help="Show the exact model beside the run.")
@click.option("--from", "since", type=float, metavar="T", help="First time, s.  [the run's, or 0]")
@click.option("--until", type=float, metavar="T", help=f"Last time, s.  [the run's, or {MARCH_FILM:g} s of a march]")
@click.option("--speedup", type=float, metavar="X", help="Simulated seconds in a second of film.  [20]")
@click.option("--fps", type=int, metavar="N", help="Frames in a second, at most 60, and 50 in a GIF.  [10]")
@click.option("--size", metavar="PIXELS", help="Width and height: 440, or 640x360.  [440]")
@click.option("--camera", default="field", metavar="NAME", help="field: stand still; head: follow it.  [field]")
@click.option("--span", type=float, metavar="M", help="Width of the ground in view, m.")
@click.option("--hold", type=float, metavar="T", help="How long the last frame stays, s.  [1]")
@mark_options
@click.option("--title", metavar="TEXT", help="A line above the picture.")
@click.option("--caption", metavar="TEXT", help="Lines below the picture.")
@click.option("--workers", type=int, metavar="N", help="Processes that draw a long film.  [one a core]")
@json_option
@output_option(".gif, .mp4, .apng or .webp for a film, .png for a picture at --until", required=True)
def render(
    run_files: tuple[str, ...],
    scenario_file: str | None,
    exact: bool,
    camera: str,
    span: float | None,
    size: str | None,
    workers: int | None,
    as_json: bool,
    output: str,
    **choices: Any,
) -> None:
    """Film a run, several side by side, or the exact march where no run is named."""
    from pymunk_dragon.render import FILM_ENDINGS, STILL_ENDINGS, Camera, Film, write_film, write_still

    destination = destination_of(output, (*FILM_ENDINGS, *STILL_ENDINGS))
    assert destination is not None
    given = {name: value for name, value in choices.items() if value is not None}
    if size is not None:
        given["size"] = _size(size)
    sources = _sources(run_files, scenario_file, exact)
    given.setdefault("until", _last(sources, given.get("since", 0.0)))
    camera_ = Camera(follow=camera, span=span)  # type: ignore[arg-type]  # Camera checks the word.
    film = Film(camera=camera_, show=marks(), **given)
    if destination.suffix.lower() in STILL_ENDINGS:
        write_still(sources, given["until"], destination, film)
    else:
        with progress("frame") as show:

            def tell(done: int, total: int) -> None:
                show(done, total, f"frame {done}")

            write_film(sources, destination, film, tell, workers if workers is not None else os.cpu_count() or 1)
    if as_json:
        print_json({"output": str(destination), "bytes": destination.stat().st_size})


def _sources(run_files: tuple[str, ...], scenario_file: str | None, exact: bool) -> list[Run | March]:
    """What is filmed: the runs, and the exact model of the first if it is asked for; or the march of a scenario."""
    from pymunk_dragon.run import Run

    if not run_files:
        if exact:
            raise click.UsageError("--exact stands beside a run: name one, or leave it out")
        return [march_of(scenario_file)]
    if chosen() or scenario_file:
        raise click.UsageError("a run brings its own scenario: leave out the options of the dragon and its curve")
    runs = [Run.load(file) for file in run_files]
    return [*runs, runs[0].march] if exact else [*runs]


def _last(sources: list[Run | March], since: float) -> float:
    """When the last run is over, s; a march ends a minute after `since`, or where its curve does."""
    from pymunk_dragon.run import Run

    ends = [float(source.times[-1]) if isinstance(source, Run) else source.end for source in sources]
    runs = [end for source, end in zip(sources, ends, strict=True) if isinstance(source, Run)]
    return max(runs) if runs else min(since + MARCH_FILM, ends[0])


def _size(text: str) -> int | tuple[int, int]:
    try:
        lengths = [int(length) for length in text.lower().split("x")]
    except ValueError:
        lengths = []
    if len(lengths) not in (1, 2):
        raise ParameterError("size", text, "pixels such as 480, or 640x360")
    return lengths[0] if len(lengths) == 1 else (lengths[0], lengths[1])
