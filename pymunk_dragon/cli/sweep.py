"""`pymunk-dragon sweep`."""

from __future__ import annotations

import os
import sys
from contextlib import redirect_stdout
from pathlib import Path
from time import perf_counter

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.options import (
    DragonCommand,
    chosen,
    json_option,
    named,
    number_list,
    scenario_options,
)
from pymunk_dragon.cli.output import print_json, progress, wrote
from pymunk_dragon.errors import DragonError, ParameterError

AXIS = "NAME=VALUES, such as pitch=0.4:0.8:0.01 or benches=50,100, or with --samples an interval, pitch=0.4:0.8"


def _quantities() -> dict[str, str]:
    """Names of the quantities, and what they are."""
    from pymunk_dragon.sweeps.quantities import QUANTITIES

    return {name: quantity.summary for name, quantity in QUANTITIES.items()}


def _parameters() -> dict[str, str]:
    """Parameters that can be axes, each with the sign before its values."""
    from pymunk_dragon.sweeps.quantities import QUANTITIES

    return {f"{name}=": "" for quantity in QUANTITIES.values() for name in quantity.parameters}


@click.command(
    cls=DragonCommand,
    examples=(
        "--axis pitch=0.42:0.46:0.01 --benches 60",
        "--axis pitch=0.4:0.6 --samples 32 -o map.png",
    ),
    names=_quantities,
)
@scenario_options
@click.option(
    "--axis",
    multiple=True,
    metavar="NAME=VALUES",
    help="Parameter and its values; one for each axis.",
    shell_complete=named(_parameters),
)
@click.option(
    "--quantity",
    metavar="NAME",
    default="contact-time",
    shell_complete=named(_quantities),
    help="What is computed, or module:function, a function of a march.  [contact-time]",
)
@click.option("--samples", type=int, metavar="N", help="Take N samples of the intervals, not all combinations.")
@click.option("--seed", type=int, metavar="N", default=0, help="Of the samples.  [0]")
@click.option(
    "--sampling",
    metavar="NAME",
    default="sobol",
    help="sobol or random.  [sobol]",
)
@click.option("--refine", type=int, metavar="N", default=0, help="Add up to N points where benches or status change.")
@click.option("--timeout", type=float, metavar="T", help="Time limit of a point, s.")
@click.option("--resume", is_flag=True, help="Go on from the journal of an interrupted sweep, if there is one.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Run on a Dask scheduler, tcp://HOST:PORT, or local.",
)
@click.option("--workers", type=int, metavar="N", help="Number of processes.  [one for each core]")
@json_option
@click.option(
    "-o",
    "--output",
    "output",
    multiple=True,
    metavar="FILE",
    help="File to write: .csv, .parquet, or .png, .svg or .pdf for a map. May be repeated.",
)
def sweep(
    scenario_file: str | None,
    axis: tuple[str, ...],
    quantity: str,
    samples: int | None,
    seed: int,
    sampling: str,
    refine: int,
    timeout: float | None,
    resume: bool,
    scheduler: str | None,
    workers: int | None,
    as_json: bool,
    output: tuple[str, ...],
) -> None:
    """Compute a quantity at many values of parameters, in parallel.

    Without -o the table is printed as CSV. Finished points are kept in a journal beside the first file, from which
    --resume goes on. The other options choose the reference dragon, which a map marks.

    The quantities are {names}.
    """
    from pymunk_dragon.model.scenario import Scenario
    from pymunk_dragon.sweeps import sweep as run_sweep

    # A module of the user's, which other programs would find as well.
    sys.path.append(os.getcwd())
    axes = _axes(axis, intervals=samples is not None)
    values = Scenario.read(scenario_file) if scenario_file is not None else {}
    begin = perf_counter()
    resumed: int | None = None
    # What a quantity prints is not part of a table on stdout.
    with progress("sweep") as show, redirect_stdout(sys.stderr):

        def report(done: int, total: int) -> None:
            nonlocal resumed
            resumed = done - 1 if resumed is None else resumed
            rate = (done - resumed) / (perf_counter() - begin)
            show(
                done,
                total,
                text("{done} of {total} points, {rate:.3g} a second").format(done=done, total=total, rate=rate),
            )

        found = run_sweep(
            values | chosen(),
            axes,
            quantity,
            out=output,
            samples=samples,
            seed=seed,
            sampling=sampling,  # type: ignore[arg-type]  # It is checked there.
            refine=refine,
            timeout=timeout,
            resume=resume,
            scheduler=scheduler,
            workers=workers,
            progress=report,
        )
    for file in output:
        wrote(Path(file))
    if as_json:
        print_json(found.to_dict())
    elif output:
        click.echo(found)
    else:
        for line in found.csv():
            click.echo(line)
    if found.failed:
        raise DragonError(f"{found.failed} of {found.points} points failed; the column error has the reasons")


def _axes(given: tuple[str, ...], *, intervals: bool) -> dict[str, list[float]]:
    """Values of each axis, by its name."""
    axes: dict[str, list[float]] = {}
    for each in given:
        name, equals, values = each.partition("=")
        name = name.strip().replace("-", "_")
        if not equals or name in axes:
            raise ParameterError("axis", each, AXIS if not equals else f"given once for {name}")
        # An interval, low:high, is a list of two numbers.
        listed = values.replace(":", ",") if intervals and values.count(":") == 1 and "," not in values else values
        try:
            axes[name] = number_list("axis", listed)
        except ParameterError as error:
            raise ParameterError("axis", each, AXIS) from error
    return axes
