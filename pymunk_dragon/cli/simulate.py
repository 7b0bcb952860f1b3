"""`pymunk-dragon simulate`."""

from typing import Any

import click

from pymunk_dragon import dynamics, physics
from pymunk_dragon.cli.options import (
    chosen_march,
    command,
    flags_given,
    options_of,
    output_option,
    scenario_options,
    start_option,
    until_option,
)
from pymunk_dragon.cli.output import destination_of, print_result, progress, write_result
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.settings import EngineSettings

# Options of the engine that are numbers.
_OPTIONS = {
    "head_force": (float, "Largest force at contacts, N.  [twice the ground drag]"),
    "substep": (
        float,
        "Substep, s.  [20 mm of the head; 25 mm without a guide; 5 mm to resolve]",
    ),
    "iterations": (
        int,
        "Solver iterations.  [10; 20 without a guide; 60 if contacts are resolved]",
    ),
    "frame_interval": (float, "Time between frames, s.  [until the head goes 0.1 m]"),
}
_CONTACTS = ("stop", "report", "resolve")
_RESPONSE = "At a contact end the run, only record it, or push the benches apart.  [stop]"
_GUIDE = "The guide, which keeps the benches on the path.  [rails]"


@command(
    "-o run.npz", "--from 400 --substep 0.0025 --iterations 60", "--guide none --exact --until 20"
)
@scenario_options
@start_option
@until_option
@click.option("--guide", type=click.Choice(list(physics.GUIDES)), default="rails", help=_GUIDE)
@click.option("--exact", is_flag=True, help="Solve the motion exactly, with --guide none.")
@click.option("--contacts", type=click.Choice(_CONTACTS), default="stop", help=_RESPONSE)
@options_of(_OPTIONS)
@output_option(".npz, which keeps the run")
def simulate(output: str | None, exact: bool, **choices: Any) -> None:
    """Play the march in Pymunk until the dragon runs into itself.

    With --exact a dragon without a guide is no engine's: its motion is solved to nanometres, and
    goes on through contacts.
    """
    interval = {name: choices.pop(name) for name in ("start", "until", "guide")}
    if exact:
        _check_exact(interval.pop("guide"))
    march = chosen_march()
    path = destination_of(output, (".npz",))
    if exact:
        run = dynamics.pull(march, **interval)
    else:
        run = simulate_with_progress(march, settings=EngineSettings(**choices), **interval)
    found = run.to_dict()
    write_result(path, found, run.save)
    print_result(found, run)


def _check_exact(guide: str) -> None:
    """Refuse options that do not go with --exact."""
    if guide != "none":
        raise click.UsageError("--exact needs --guide none: the dragon on its path is exact anyway")
    for flag in flags_given("contacts", *_OPTIONS):
        raise click.UsageError(f"{flag} is for the engine: leave it out, or --exact")


def simulate_with_progress(march: March, *, start: float, **how: Any) -> Run:
    """Play `march` in Pymunk, with progress."""
    with progress("simulate", start) as show:
        return physics.simulate(march, start=start, progress=show, **how)
