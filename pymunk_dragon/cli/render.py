"""`pymunk-dragon render`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from pymunk_dragon.cli.options import chosen, destination_of, json_option, march_of, output_option, scenario_options
from pymunk_dragon.cli.output import print_json, progress
from pymunk_dragon.errors import ParameterError

if TYPE_CHECKING:
    from pymunk_dragon.march import March
    from pymunk_dragon.run import Run

__all__ = ["render"]

# s: how much of a march is filmed when it is not told.
MARCH_FILM = 60.0


@click.command()
@click.argument("run_file", metavar="[RUN.npz]", required=False)
@scenario_options
@click.option("--from", "since", type=float, metavar="T", help="First time, s.  [the run's, or 0]")
@click.option("--until", type=float, metavar="T", help=f"Last time, s.  [the run's, or {MARCH_FILM:g} s of a march]")
@click.option("--speedup", type=float, metavar="X", help="Simulated seconds in a second of film.  [20]")
@click.option("--fps", type=int, metavar="N", help="Frames in a second: 10, 20, 25 or 50.  [10]")
@click.option("--size", metavar="PIXELS", help="Width and height: 440, or 640x360.  [440]")
@click.option("--camera", default="field", metavar="NAME", help="field: stand still; head: follow it.  [field]")
@click.option("--span", type=float, metavar="M", help="Width of the ground in view, m.")
@click.option("--hold", type=float, metavar="T", help="How long the last frame stays, s.  [1]")
@json_option
@output_option(".gif for a film, .png for a picture at --until", required=True)
def render(
    run_file: str | None,
    scenario_file: str | None,
    camera: str,
    span: float | None,
    size: str | None,
    as_json: bool,
    output: str,
    **choices: Any,
) -> None:
    """Film a run, or the exact march where no run is named."""
    from pymunk_dragon.render import FILM_ENDINGS, STILL_ENDINGS, Camera, Film, write_film, write_still
    from pymunk_dragon.run import Run

    destination = destination_of(output, (*FILM_ENDINGS, *STILL_ENDINGS))
    assert destination is not None
    given = {name: value for name, value in choices.items() if value is not None}
    if size is not None:
        given["size"] = _size(size)
    source: Run | March
    if run_file is not None:
        if chosen() or scenario_file:
            raise click.UsageError("a run brings its own scenario: leave out the options of the dragon and its curve")
        source = Run.load(run_file)
    else:
        source = march_of(scenario_file)
        given.setdefault("until", min(given.get("since", 0.0) + MARCH_FILM, source.end))
    film = Film(camera=Camera(follow=camera, span=span), **given)  # type: ignore[arg-type]  # Camera checks the word.
    if destination.suffix.lower() in STILL_ENDINGS:
        last = float(source.times[-1]) if isinstance(source, Run) else given["until"]
        write_still(source, last if film.until is None else film.until, destination, film)
    else:
        with progress("frame") as show:
            write_film(source, destination, film, lambda done, total: show(done, total, f"frame {done}"))
    if as_json:
        print_json({"output": str(destination), "bytes": destination.stat().st_size})


def _size(text: str) -> int | tuple[int, int]:
    try:
        lengths = [int(length) for length in text.lower().split("x")]
    except ValueError:
        lengths = []
    if len(lengths) not in (1, 2):
        raise ParameterError("size", text, "pixels such as 480, or 640x360")
    return lengths[0] if len(lengths) == 1 else (lengths[0], lengths[1])
