"""`pymunk-dragon report`."""

from __future__ import annotations

from pathlib import Path

import click

from pymunk_dragon.cli.options import DragonCommand, destination_of, json_option, output_option
from pymunk_dragon.cli.output import print_file, wrote
from pymunk_dragon.model.run import Run
from pymunk_dragon.reports import REPORT_ENDINGS
from pymunk_dragon.reports import report as write_report


@click.command(cls=DragonCommand, examples=("run.npz", "run.npz -o run.md"), names=REPORT_ENDINGS)
@click.argument("run_file", metavar="RUN.npz", type=click.Path())
@json_option
@output_option("a document or a table", "RUN.html")
def report(run_file: str, as_json: bool, output: str | None) -> None:
    """Report on a run, as a document or a table.

    The ending of the file chooses the format: {names}.
    """
    destination = destination_of(output or f"{Path(run_file).stem}.html", REPORT_ENDINGS)
    assert destination is not None  # There is a name in any case.
    write_report(Run.load(run_file), destination)
    wrote(destination)
    if as_json:
        print_file(destination)
