"""`pymunk-dragon simulate`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli import options
from pymunk_dragon.cli.output import answer, note, progress, wrote
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.settings import FINE_ITERATIONS, FINE_STRIDE, EngineSettings
from pymunk_dragon.physics import GUIDES
from pymunk_dragon.physics import simulate as play
from pymunk_dragon.physics.world import top_speed

CONTACTS = click.Choice(["stop", "report", "resolve"])
# Defaults, for the help.
FORCE = "[twice the ground drag on what the head pulls]"
SUBSTEP = "[the time in which the head goes 20 mm, or 5 mm where contacts are resolved]"
ITERATIONS = "[10, or 60 where contacts are resolved]"


@click.command(
    cls=options.DragonCommand,
    examples=("-o run.npz", "--from 400 --until 415 --fine -o run.npz", "--guide none --until 20"),
)
@options.scenario_options
@options.start_option
@options.until_option
@click.option("--guide", type=click.Choice(list(GUIDES)), default="rails", help="What keeps it on the path.  [rails]")
@click.option("--contacts", type=CONTACTS, default="stop", help="What the first contact does.  [stop]")
@click.option("--head-force", type=float, metavar="F", help=f"Largest force on the head at contacts, N.  {FORCE}")
@click.option("--substep", type=float, metavar="T", help=f"Substep, s.  {SUBSTEP}")
@click.option("--iterations", type=int, metavar="N", help=f"Solver iterations in a substep.  {ITERATIONS}")
@click.option("--fine", is_flag=True, help="The substep in which the head goes 2.5 mm, and 60 iterations.")
@click.option("--frame-interval", type=float, metavar="T", help="Time between frames, s.  [until the head goes 0.1 m]")
@options.json_option
@options.output_option(".npz")
def simulate(scenario_file: str | None, fine: bool, as_json: bool, output: str | None, **choices: Any) -> None:
    """Play the march in Pymunk until the dragon runs into itself."""
    march = options.march_of(scenario_file)
    options.destination_of(output, (".npz",))
    if fine and not (choices["substep"] is None and choices["iterations"] is None):
        raise click.UsageError("--fine chooses the substep and the iterations: leave out --substep and --iterations")
    interval = {name: choices.pop(name) for name in ("start", "until", "guide")}
    run = played(march, EngineSettings(**choices), fine=fine, **interval)
    if output is not None:
        run.save(output)
        wrote(Path(output), text("{count} frames").format(count=len(run.times)))
    else:
        note(text("the run is not kept: -o RUN.npz saves it"))
    answer(as_json, run.to_dict(), run)


def played(march: March, settings: EngineSettings, *, fine: bool, start: float, until: float | None, **how: Any) -> Run:
    """Play `march` in Pymunk, with progress."""
    if fine:
        substep = FINE_STRIDE / top_speed(march, start, until)
        settings = replace(settings, substep=substep, iterations=FINE_ITERATIONS)
    with progress("t", "t = {done:.1f} s, {total:.0f} s at the latest", start) as show:
        return play(march, start=start, until=until, settings=settings, progress=show, **how)
