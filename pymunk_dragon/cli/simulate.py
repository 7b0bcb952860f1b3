"""`pymunk-dragon simulate`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from pymunk_dragon.cli.options import (
    destination_of,
    json_option,
    march_of,
    output_option,
    scenario_options,
    start_option,
)
from pymunk_dragon.cli.output import print_json, progress

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March
    from pymunk_dragon.model.run import Run

__all__ = ["played", "simulate"]


@click.command()
@scenario_options
@start_option
@click.option("--until", type=float, metavar="T", help="Last time, s.  [the end of the curve]")
@click.option("--guide", default="rails", metavar="NAME", help="What keeps it on the path: rails or none.  [rails]")
@click.option(
    "--contacts", default="stop", metavar="NAME", help="At the first contact: stop, report or resolve.  [stop]"
)
@click.option(
    "--head-force",
    type=float,
    metavar="F",
    help="Largest force on the head where contacts are resolved, N.  [twice the ground drag on what the head pulls]",
)
@click.option(
    "--substep",
    type=float,
    metavar="T",
    help="s.  [the time in which the head goes 10 mm, or 5 mm where contacts are resolved]",
)
@click.option("--iterations", type=int, metavar="N", help="Solver iterations in a substep.  [60]")
@click.option("--fine", is_flag=True, help="A quarter of the usual substep.")
@click.option("--frame-interval", type=float, metavar="T", help="s between frames.  [until the head goes 0.1 m]")
@json_option
@output_option(".npz")
def simulate(scenario_file: str | None, as_json: bool, output: str | None, fine: bool, **settings: Any) -> None:
    """Play the march in Pymunk until the dragon runs into itself."""
    from pymunk_dragon.cli._run_words import contact_in_words, quality_in_words, summary, windows_in_words

    march = march_of(scenario_file)
    destination_of(output, (".npz",))
    if fine and not (settings["substep"] is None and settings["iterations"] is None):
        raise click.UsageError("--fine chooses the substep and the iterations: leave out --substep and --iterations")
    run = played(march, fine=fine, **settings)
    if output is not None:
        run.save(output)
    if as_json:
        print_json(summary(run))
    else:
        click.echo(contact_in_words(run))
        click.echo(quality_in_words(run))
        if settings["contacts"] != "stop":
            click.echo(windows_in_words(run))


def played(march: March, *, fine: bool, **settings: Any) -> Run:
    """Play `march` in Pymunk, with progress."""
    from pymunk_dragon.physics import simulate as play
    from pymunk_dragon.physics.simulation import FINE_ITERATIONS, FINE_STRIDE, top_speed

    if fine:
        fastest = top_speed(march, settings["start"], settings["until"])
        settings |= {"substep": FINE_STRIDE / fastest, "iterations": FINE_ITERATIONS}
    given = {name: value for name, value in settings.items() if value is not None}
    start = given["start"]
    with progress("t") as show:

        def report(time: float, until: float) -> None:
            show(time - start, until - start, f"t = {time:.1f} s")

        return play(march, progress=report, **given)
