"""`pymunk-dragon simulate`."""

from __future__ import annotations

from typing import Any

import click

from pymunk_dragon.cli import common
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics import GUIDES
from pymunk_dragon.physics import simulate as play

_CONTACTS = ("stop", "report", "resolve")
_RESPONSE = "At a contact end the run, only record it, or push the benches apart.  [stop]"
_GUIDE = "What keeps the benches on the path: dancers, or nothing.  [rails]"


@common.command("-o run.npz", "--from 400 --substep 0.0025 --iterations 60", "--guide none --until 20")
@common.scenario_options
@common.start_option
@common.until_option
@click.option("--guide", type=click.Choice(list(GUIDES)), default="rails", help=_GUIDE)
@click.option("--contacts", type=click.Choice(_CONTACTS), default="stop", help=_RESPONSE)
@click.option("--head-force", type=float, metavar="F", help="Largest force at contacts, N.  [twice the ground drag]")
@click.option("--substep", type=float, metavar="T", help="Substep, s.  [20 mm of the head, or 5 mm to resolve]")
@click.option("--iterations", type=int, metavar="N", help="Solver iterations.  [10, or 60 if contacts are resolved]")
@click.option("--frame-interval", type=float, metavar="T", help="Time between frames, s.  [until the head goes 0.1 m]")
@common.output_option(".npz, which keeps the run")
def simulate(output: str | None, **choices: Any) -> None:
    """Play the march in Pymunk until the dragon runs into itself."""
    march = common.march()
    path = common.destination_of(output, (".npz",))
    interval = {name: choices.pop(name) for name in ("start", "until", "guide")}
    run = played(march, settings=EngineSettings(**choices), **interval)
    found = run.to_dict()
    common.save(path, found, run.save)
    common.answer(found, run)


def played(march: March, *, start: float, **how: Any) -> Run:
    """Play `march` in Pymunk, with progress."""
    with common.progress("simulate", start) as show:
        return play(march, start=start, progress=show, **how)
