"""`pymunk-dragon sweep`."""

import logging
import os
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import click

from pymunk_dragon import sweeps
from pymunk_dragon.cli.options import (
    command,
    file_values,
    json_option,
    number_list,
    option_values,
    scenario_options,
)
from pymunk_dragon.cli.output import print_result, print_written, progress
from pymunk_dragon.errors import DragonError, ParameterError

_AXIS = "NAME=VALUES, such as pitch=0.4:0.8:0.01 or benches=50,100"
_QUANTITY = (
    f"{', '.join(sweeps.QUANTITIES)}, or module:function, a function of a march.  [contact-time]"
)
_REFINE = "Halve N times the distance between neighbours whose first contacts are of other benches."
_OUTPUT = "File to write: .csv, or .png, .svg or .pdf for a picture. May be repeated."


@command(
    "--axis pitch=0.42:0.46:0.01 --benches 60",
    "--axis pitch=0.5:0.6:0.005 -o pitch.csv -o pitch.png",
)
@scenario_options
@click.option(
    "--axis", multiple=True, required=True, metavar="NAME=VALUES", help=f"{_AXIS}; repeatable."
)
@click.option("--quantity", default="contact-time", help=_QUANTITY)
@click.option("--refine", type=int, default=0, metavar="N", help=_REFINE)
@click.option(
    "--resume",
    is_flag=True,
    help="Go on from the partial table of an interrupted sweep, if there is one.",
)
@click.option("--scheduler", help="Run on a Dask scheduler, tcp://HOST:PORT.")
@click.option("--workers", type=int, help="Number of processes.  [one for each core]")
@json_option
@click.option("-o", "--output", multiple=True, type=click.Path(), help=_OUTPUT)
def sweep(axis: tuple[str, ...], output: tuple[str, ...], **settings: Any) -> None:
    """Compute a quantity at many values of parameters, in parallel.

    Without -o the table is printed as CSV. Finished points are kept beside the first file,
    FILE.partial, from which --resume goes on. The other options choose the reference dragon, which
    a picture marks.
    """
    # Dask would log a lost scheduler, beside the error, which is one line.
    logging.disable()
    # The quantity may be in a module of the user's in this folder.
    sys.path.append(os.getcwd())
    # What a quantity prints is not part of a table on stdout.
    with progress("sweep") as show, redirect_stdout(sys.stderr):
        scenario = file_values() | option_values()
        found = sweeps.sweep(scenario, _axes(axis), out=output, progress=show, **settings)
    for file in output:
        print_written(Path(file))
    print_result(found.to_dict(), found if output else "\n".join(found.csv()))
    if found.failed:
        count = f"{found.failed} of {found.points} points failed"
        raise DragonError(f"{count}; the column error has the reasons")


def _axes(given: tuple[str, ...]) -> dict[str, list[float]]:
    """Values of each axis by its name, of one that is given twice all of them."""
    axes: dict[str, list[float]] = {}
    for each in given:
        name, _, values = each.partition("=")
        name = name.strip().replace("-", "_")
        try:
            axes.setdefault(name, []).extend(number_list("axis", values))
        except ParameterError as error:
            raise ParameterError("axis", each, _AXIS) from error
    return axes
