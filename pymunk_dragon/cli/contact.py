"""`pymunk-dragon contact`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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
from pymunk_dragon.cli.output import print_json, progress, write_json, wrote
from pymunk_dragon.errors import DragonError

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March

# The method that each setting belongs to.
SETTINGS_OF = {"step": "grid", "tolerance": "grid", "fine": "engine"}


@click.command(cls=DragonCommand, examples=("", "--pitch 0.5 --json", "--from 400 --method engine"))
@scenario_options
@click.option("--method", type=click.Choice(["exact", "grid", "engine"]), default="exact", help="Method.  [exact]")
@start_option
@until_option
@click.option("--step", type=float, metavar="T", help="Of the grid: s between samples.  [1]")
@click.option("--tolerance", type=float, metavar="T", help="Of the grid: how far it bisects, s.  [1e-6]")
@click.option("--fine", is_flag=True, default=None, help="Of the engine: short substeps and many iterations.")
@json_option
@output_option(".json, or .xlsx for the contest's sheet of that moment")
def contact(
    scenario_file: str | None,
    method: str,
    start: float,
    until: float | None,
    as_json: bool,
    output: str | None,
    **choices: Any,
) -> None:
    """When benches that are not neighbours first touch, and where.

    The exact method certifies that no benches touched before, however briefly. The grid is the method of the paper:
    samples at equal time steps, and bisection. The engine is Pymunk.
    """
    settings = {name: value for name, value in choices.items() if value is not None}
    for name in settings:
        if SETTINGS_OF[name] != method:
            raise click.UsageError(f"--{name} is of the {SETTINGS_OF[name]}: add --method {SETTINGS_OF[name]}")
    march = march_of(scenario_file)
    destination = destination_of(output, (".json", ".xlsx"))
    sheet = destination is not None and destination.suffix.lower() == ".xlsx"
    if sheet:
        from pymunk_dragon._extras import library

        library("xlsxwriter")
    search = _play if method == "engine" else _search
    values, shown = search(march, method, start=start, until=until, **settings)
    result = {"status": values["status"], "method": method} | values
    if destination is not None and sheet:
        from pymunk_dragon.reports import write_contact_table

        if result["time"] is None:
            raise DragonError(f"no contact until t = {result['until']:.6g} s, so {destination} was not written")
        write_contact_table(march, result["time"], destination)
    elif destination is not None:
        write_json(destination, result)
    if destination is not None:
        wrote(destination)
    if as_json:
        print_json(result)
    else:
        click.echo(shown)


def _search(march: March, method: str, *, start: float, **settings: Any) -> tuple[dict[str, Any], str]:
    """Values and text of the result of the exact search or the grid."""
    from pymunk_dragon.collision import first_contact, scan

    with progress("t") as show:

        def report(time: float, last: float) -> None:
            show(time - start, last - start, text("t = {time:.1f} s").format(time=time))

        find = first_contact if method == "exact" else scan
        found = find(march, start=start, progress=report, **settings)
    return found.to_dict(), str(found)


def _play(march: March, method: str, *, fine: bool = False, **times: Any) -> tuple[dict[str, Any], str]:
    """The same of the engine, which reports contacts only, not gaps."""
    from pymunk_dragon.cli.simulate import played

    run = played(march, fine=fine, **times)
    touch = {name: getattr(run.first_contact, name, None) for name in ("time", "benches", "point", "normal")}
    values = {"status": run.outcome, **touch, "near_misses": None, "until": float(run.times[-1]), "resolution": None}
    return values | {"samples": run.substeps, "tests": None}, str(run).partition("\n")[0]
