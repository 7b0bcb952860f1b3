"""`pymunk-dragon contact`."""

from pathlib import Path
from typing import Any

import click

from pymunk_dragon.cli.options import (
    chosen_march,
    command,
    output_option,
    scenario_options,
    start_option,
    until_option,
)
from pymunk_dragon.cli.output import destination_of, print_result, progress, write_result
from pymunk_dragon.collision import first_contact, scan
from pymunk_dragon.errors import DragonError
from pymunk_dragon.model.march import March


@command("", "--pitch 0.5 --json", "--from 400 --method engine")
@scenario_options
@click.option(
    "--method",
    type=click.Choice(["exact", "grid", "engine"]),
    default="exact",
    help="Search.  [exact]",
)
@start_option
@until_option
@click.option("--step", type=float, help="Of the grid: s between samples.  [1]")
@output_option(".json, or .xlsx for the contest's sheet of that moment")
def contact(method: str, output: str | None, **choices: Any) -> None:
    """When benches that are not neighbours first touch, and where.

    The exact method certifies that no benches touched before, however briefly. The grid is the
    method of the paper: samples at equal time steps, and bisection. The engine is Pymunk.
    """
    settings = {name: value for name, value in choices.items() if value is not None}
    if "step" in settings and method != "grid":
        raise click.UsageError("--step is of the grid: add --method grid")
    march = chosen_march()
    path = destination_of(output, (".json", ".xlsx"))
    answer = _simulated if method == "engine" else _searched
    values, shown = answer(march, method, **settings)
    result = {"status": values["status"], "method": method} | values
    write_result(path, result, lambda path: _write_sheet(path, march, result))
    print_result(result, shown)


def _searched(
    march: March, method: str, *, start: float, **settings: Any
) -> tuple[dict[str, Any], str]:
    """Values and text of the result of the exact search or the grid."""
    search = first_contact if method == "exact" else scan
    with progress("contact", start) as show:
        found = search(march, start=start, progress=show, **settings)
    return found.to_dict(), str(found)


def _simulated(march: March, method: str, **interval: Any) -> tuple[dict[str, Any], str]:
    """Values and text of the result of the engine, which reports contacts, but no gaps."""
    from pymunk_dragon.cli.simulate import simulate_with_progress

    run = simulate_with_progress(march, **interval)
    names = ("time", "benches", "point", "normal")
    touch = {name: getattr(run.first_contact, name, None) for name in names}
    values = {
        "status": run.outcome,
        **touch,
        "near_misses": None,
        "until": run.interval[1],
        "resolution": None,
        "samples": run.substeps,
        "tests": None,
    }
    return values, str(run).partition("\n")[0]


def _write_sheet(path: Path, march: March, result: dict[str, Any]) -> None:
    """Write the contest's sheet of the moment of the contact."""
    from pymunk_dragon.reports import write_contact_table

    if result["time"] is None:
        until = result["until"]
        raise DragonError(f"no contact until t = {until:.6g} s, so {path} was not written")
    write_contact_table(march, result["time"], path)
