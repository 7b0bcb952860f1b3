"""`pymunk-dragon simulate`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.options import (
    DragonCommand,
    destination_of,
    json_option,
    march_of,
    output_option,
    scenario_options,
    start_option,
    until_option,
)
from pymunk_dragon.cli.output import note, print_json, progress, wrote
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.settings import FINE_ITERATIONS, FINE_STRIDE, EngineSettings
from pymunk_dragon.physics import GUIDES
from pymunk_dragon.physics import simulate as play
from pymunk_dragon.physics.world import top_speed

STOP = "[the time in which the head goes 20 mm, or 5 mm where contacts are resolved]"


@click.command(
    cls=DragonCommand,
    examples=("-o run.npz", "--from 400 --until 415 --fine -o run.npz", "--guide none --until 20"),
)
@scenario_options
@start_option
@until_option
@click.option("--guide", type=click.Choice(list(GUIDES)), default="rails", help="What keeps it on the path.  [rails]")
@click.option(
    "--contacts",
    type=click.Choice(["stop", "report", "resolve"]),
    default="stop",
    help="What the engine does at a contact.  [stop]",
)
@click.option(
    "--head-force",
    type=float,
    metavar="F",
    help="Largest force on the head where contacts are resolved, N.  [twice the ground drag on what the head pulls]",
)
@click.option("--substep", type=float, metavar="T", help=f"Substep, s.  {STOP}")
@click.option("--iterations", type=int, metavar="N", help="Iterations in a substep.  [10, or 60 to resolve contacts]")
@click.option("--fine", is_flag=True, help="The substep in which the head goes 2.5 mm, and 60 iterations.")
@click.option("--frame-interval", type=float, metavar="T", help="Time between frames, s.  [until the head goes 0.1 m]")
@json_option
@output_option(".npz")
def simulate(
    scenario_file: str | None,
    start: float,
    until: float | None,
    guide: str,
    fine: bool,
    as_json: bool,
    output: str | None,
    **choices: Any,
) -> None:
    """Play the march in Pymunk until the dragon runs into itself."""
    march = march_of(scenario_file)
    destination_of(output, (".npz",))
    settings = EngineSettings(**choices)
    if fine and not (settings.substep is None and settings.iterations is None):
        raise click.UsageError("--fine chooses the substep and the iterations: leave out --substep and --iterations")
    run = played(march, fine=fine, start=start, until=until, guide=guide, settings=settings)
    if output is not None:
        run.save(output)
        wrote(Path(output), text("{count} frames").format(count=len(run.times)))
    else:
        note(text("the run is not kept: -o RUN.npz saves it"))
    if as_json:
        print_json(run.to_dict())
    else:
        click.echo(run)


def played(
    march: March,
    *,
    fine: bool,
    start: float,
    until: float | None,
    guide: str = "rails",
    settings: EngineSettings | None = None,
) -> Run:
    """Play `march` in Pymunk, with progress."""
    settings = settings or EngineSettings()
    if fine:
        substep = FINE_STRIDE / top_speed(march, start, until)
        settings = replace(settings, substep=substep, iterations=FINE_ITERATIONS)
    with progress("t") as show:

        def report(time: float, last: float) -> None:
            now = text("t = {time:.1f} s, {last:.0f} s at the latest").format(time=time, last=last)
            show(time - start, last - start, now)

        return play(march, guide=guide, start=start, until=until, settings=settings, progress=report)
