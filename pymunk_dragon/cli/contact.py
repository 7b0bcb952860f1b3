"""`pymunk-dragon contact`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pymunk_dragon._extras import library
from pymunk_dragon.cli import common
from pymunk_dragon.errors import DragonError

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March

# The method that each setting belongs to.
_SETTINGS_OF = {"step": "grid", "tolerance": "grid", "fine": "engine"}


@click.command(cls=common.DragonCommand, examples=("", "--pitch 0.5 --json", "--from 400 --method engine"))
@common.scenario_options
@click.option("--method", type=click.Choice(["exact", "grid", "engine"]), default="exact", help="Search.  [exact]")
@common.start_option
@common.until_option
@click.option("--step", type=float, metavar="T", help="Of the grid: s between samples.  [1]")
@click.option("--tolerance", type=float, metavar="T", help="Of the grid: how far it bisects, s.  [1e-6]")
@click.option("--fine", is_flag=True, default=None, help="Of the engine: short substeps and many iterations.")
@common.output_option(".json, or .xlsx for the contest's sheet of that moment")
def contact(method: str, output: str | None, **choices: Any) -> None:
    """When benches that are not neighbours first touch, and where.

    The exact method certifies that no benches touched before, however briefly. The grid is the method of the paper:
    samples at equal time steps, and bisection. The engine is Pymunk.
    """
    settings = {name: value for name, value in choices.items() if value is not None}
    _check_settings(method, settings)
    march = common.march()
    path, ending = common.destination_of(output, (".json", ".xlsx"))
    if ending == ".xlsx":
        library("xlsxwriter")  # Before the search.
    values, shown = (_played if method == "engine" else _found)(march, method, **settings)
    result = {"status": values["status"], "method": method} | values
    if path is not None:
        _write(path, march, result)
    common.answer(result, shown)


def _check_settings(method: str, settings: dict[str, Any]) -> None:
    for name in settings:
        if _SETTINGS_OF.get(name, method) != method:
            raise click.UsageError(f"--{name} is of the {_SETTINGS_OF[name]}: add --method {_SETTINGS_OF[name]}")


def _found(march: March, method: str, *, start: float, **settings: Any) -> tuple[dict[str, Any], str]:
    """Values and text of the result of the exact search or the grid."""
    from pymunk_dragon.collision import first_contact, scan

    search = first_contact if method == "exact" else scan
    with common.progress("t", "t = {done:.1f} s", start) as show:
        found = search(march, start=start, progress=show, **settings)
    return found.to_dict(), str(found)


def _played(march: March, method: str, *, until: float | None = None, **settings: Any) -> tuple[dict[str, Any], str]:
    """The same of the engine, which reports contacts only, not gaps."""
    from pymunk_dragon.cli.simulate import played
    from pymunk_dragon.model.settings import EngineSettings

    run = played(march, EngineSettings(), until=until, **{"fine": False} | settings)
    touch = {name: getattr(run.first_contact, name, None) for name in ("time", "benches", "point", "normal")}
    values = {"status": run.outcome, **touch, "near_misses": None, "until": float(run.times[-1]), "resolution": None}
    return values | {"samples": run.substeps, "tests": None}, str(run).partition("\n")[0]


def _write(path: Path, march: March, result: dict[str, Any]) -> None:
    """Write the result, or a sheet of the moment of the contact."""
    from pymunk_dragon.reports import write_contact_table

    if path.suffix.lower() == ".json":
        common.write_json(path, result)
    elif result["time"] is not None:
        write_contact_table(march, result["time"], path)
    else:
        raise DragonError(f"no contact until t = {result['until']:.6g} s, so {path} was not written")
    common.wrote(path)
