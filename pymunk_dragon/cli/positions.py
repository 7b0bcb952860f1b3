"""`pymunk-dragon positions`."""

import csv
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import click

from pymunk_dragon._files import written_in_place
from pymunk_dragon.cli.options import (
    chosen_march,
    command,
    flags_given,
    number_list,
    output_option,
    scenario_options,
)
from pymunk_dragon.cli.output import destination_of, print_result, wants_json, write_result
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March, States

# The times of the paper's tables.
_TABLE_TIMES = "0:300:60"
# Positions in one table: more fill the memory, and are probably a typing error.
_MAX_TABLE = 20_000_000


@command(
    "",
    "--times 0,60,120 --handles 0,1,223",
    "--times 0:300:1 -o result1.xlsx",
    "-o table.tex",
)
@scenario_options
@click.option(
    "--times",
    default=_TABLE_TIMES,
    help=f"Times, s: 0,60,120 or 0:300:1.  [{_TABLE_TIMES}]",
)
@click.option("--handles", help="Handles.  [those of the paper's tables]")
@click.option(
    "--paper",
    is_flag=True,
    help="Print the paper's tables 1 to 3 instead, cut as the paper cuts them.",
)
@output_option(".csv, .json, .tex for LaTeX, or .xlsx for the contest's sheets with all handles")
def positions(times: str, handles: str | None, paper: bool, output: str | None) -> None:
    """Where the handles are and how fast, exactly."""
    march = chosen_march()
    if not paper:
        _answer(march, times, handles, output)
    elif flags_given("times", "handles", "json", "output"):
        rest = "leave out --times, --handles, --json and -o"
        raise click.UsageError(f"--paper prints all of its tables: {rest}")
    else:
        from pymunk_dragon.collision import first_contact
        from pymunk_dragon.reports import paper_tables

        # A curve without end has no last time for the search.
        hit = first_contact(march).contact if isfinite(march.end) else None
        click.echo(paper_tables(march, None if hit is None else hit.time))


def _answer(march: March, times: str, handles: str | None, output: str | None) -> None:
    """Print or write states of handles."""
    selected = march.dragon.representatives
    count = march.dragon.handles
    if handles is not None:
        selected = _handles(handles, count - 1)
    at = number_list("times", times)
    if len(at) * count > _MAX_TABLE:
        raise ParameterError("times", times, f"at most {_MAX_TABLE // count} for this dragon")

    path = destination_of(output, (".csv", ".json", ".tex", ".xlsx"))
    if handles is not None and path is not None and path.suffix.lower() == ".xlsx":
        rest = "leave out --handles, or write .csv or .json"
        raise click.UsageError(f"the contest's sheets have all handles: {rest}")

    states = march.at(at)
    result = states.to_dict(selected)
    write_result(path, result, lambda path: _write(path, march, states, selected))
    if path is None or wants_json():
        print_result(result, states.text(selected))


def _write(path: Path, march: March, states: States, handles: Sequence[int]) -> None:
    """Write the contest's sheets, tables for LaTeX, or a table as CSV."""
    ending = path.suffix.lower()
    if ending == ".xlsx":
        from pymunk_dragon.reports import write_tables

        write_tables(march, states.times, path)
    elif ending == ".tex":
        from pymunk_dragon.reports import write_latex

        write_latex(states, handles, path)
    else:
        head = ("time_s", "handle", "x_m", "y_m", "speed_m_s")
        with written_in_place(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([head, *states.rows(handles)])


def _handles(given: str, last: int) -> list[int]:
    numbers = number_list("handles", given)
    if not all(number.is_integer() and 0 <= number <= last for number in numbers):
        raise ParameterError("handles", given, f"whole numbers from 0 to {last}")
    return [int(number) for number in numbers]
