"""`pymunk-dragon contact`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.command import DragonCommand
from pymunk_dragon.cli.completion import words
from pymunk_dragon.cli.options import (
    destination_of,
    json_option,
    march_of,
    output_option,
    scenario_options,
    start_option,
)
from pymunk_dragon.cli.output import print_json, progress, write_json, wrote
from pymunk_dragon.errors import DragonError

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March
    from pymunk_dragon.model.run import Run

# Search methods, and the method that each setting belongs to.
METHODS = ("exact", "grid", "engine")
SETTINGS_OF = {"step": "grid", "tolerance": "grid", "fine": "engine"}


@click.command(cls=DragonCommand, examples=("", "--compare --from 400", "--pitch 0.5 --json"))
@scenario_options
@click.option(
    "--method", metavar="NAME", default="exact", help="exact, grid or engine.  [exact]", shell_complete=words(*METHODS)
)
@click.option("--compare", is_flag=True, help="Run all three, and print their results side by side.")
@start_option
@click.option("--until", type=float, metavar="T", help="Last time, s.  [the end of the curve]")
@click.option("--step", type=float, metavar="T", help="Of the grid: s between samples.  [1]")
@click.option("--tolerance", type=float, metavar="T", help="Of the grid: how far it bisects, s.  [1e-6]")
@click.option("--fine", is_flag=True, default=None, help="Of the engine: short substeps and many iterations.")
@json_option
@output_option(".json, or .xlsx for the contest's sheet of that moment")
def contact(
    scenario_file: str | None,
    method: str,
    compare: bool,
    start: float,
    until: float | None,
    as_json: bool,
    output: str | None,
    **settings: Any,
) -> None:
    """When benches that are not neighbours first touch, and where.

    The exact method certifies that no benches touched before, however briefly. The grid is the method of the paper:
    samples at equal time steps, and bisection. The engine is Pymunk.
    """
    from pymunk_dragon._checks import word

    word("method", method, METHODS)
    given = {name: value for name, value in settings.items() if value is not None}
    for name in given:
        if not compare and SETTINGS_OF[name] != method:
            raise click.UsageError(f"--{name} is of the {SETTINGS_OF[name]}: add --method {SETTINGS_OF[name]}")
    march = march_of(scenario_file)
    destination = destination_of(output, (".json", ".xlsx"))
    sheet = destination if destination is not None and destination.suffix.lower() == ".xlsx" else None
    if sheet is not None:
        from pymunk_dragon._extras import library

        library("xlsxwriter")
    methods = METHODS if compare else (method,)
    answers, printed = zip(*(_answer(march, name, given, start=start, until=until) for name in methods), strict=True)
    if compare:
        result: dict[str, Any] = {"methods": answers}
    else:
        # The wall time is left out, so that the same search has the same bytes.
        result = {name: value for name, value in answers[0].items() if name != "wall_seconds"}
    if sheet is not None:
        _write_contact_sheet(march, answers[0], sheet)
    elif destination is not None:
        write_json(destination, result)
    if destination is not None:
        wrote(destination)
    if as_json:
        print_json(result)
    else:
        click.echo(_comparison(answers) if compare else printed[0])


def _answer(
    march: March, method: str, settings: dict[str, Any], *, start: float, until: float | None
) -> tuple[dict[str, Any], str]:
    """Values and text of the result of one method, with its wall time among the values."""
    from time import perf_counter

    from pymunk_dragon.collision import first_contact, scan

    own = {name: value for name, value in settings.items() if SETTINGS_OF[name] == method}
    begin = perf_counter()
    if method == "engine":
        from pymunk_dragon.cli.simulate import played

        run = played(march, fine=own.get("fine", False), start=start, until=until)
        values, shown = _run_values(run), str(run).partition("\n")[0]
    else:
        search = first_contact if method == "exact" else scan
        with progress("t") as show:

            def report(time: float, last: float) -> None:
                show(time - start, last - start, text("t = {time:.1f} s").format(time=time))

            found = search(march, start=start, until=until, progress=report, **own)
        values, shown = found.to_dict(), str(found)
    wall = perf_counter() - begin
    return {"status": values["status"], "method": method} | values | {"wall_seconds": wall}, shown


def _run_values(run: Run) -> dict[str, Any]:
    """The values of `FirstContact.to_dict` for a run; the engine reports contacts only, not gaps."""
    touch = {name: getattr(run.first_contact, name, None) for name in ("time", "benches", "point", "normal")}
    counts = {"samples": run.substeps, "tests": None}
    ended = {"near_misses": None, "until": float(run.times[-1]), "resolution": None}
    return {"status": run.outcome, **touch, **ended, **counts}


def _comparison(answers: Sequence[dict[str, Any]]) -> str:
    """Table of the methods' results and costs; lateness is relative to the first method."""
    from pymunk_dragon._text import table, width

    first = answers[0]["time"]
    rows = (
        (
            answer["method"],
            text(answer["status"]),
            answer["time"],
            "{}, {}".format(*answer["benches"]) if answer["benches"] else None,
            None if None in (answer["time"], first) else 1e3 * (answer["time"] - first),
            *(answer[name] for name in ("samples", "tests", "wall_seconds")),
        )
        for answer in answers
    )
    heads = (
        text("method"),
        text("status"),
        text("time (s)"),
        text("benches"),
        text("late (ms)"),
        text("samples"),
        text("pairs"),
        text("seconds"),
    )
    listed = list(rows)
    status = max(width(row[1]) for row in (heads, *listed))
    formats = ("<6", f"<{status}", "13.9f", ">9", "+9.6f", "7d", "8d", "7.2f")
    return "\n".join(table(heads, formats, listed))


def _write_contact_sheet(march: March, answer: dict[str, Any], path: Path) -> None:
    from pymunk_dragon.reports import write_contact_table

    if answer["time"] is None:
        raise DragonError(f"no contact until t = {answer['until']:.6g} s, so {path} was not written")
    write_contact_table(march, answer["time"], path)
