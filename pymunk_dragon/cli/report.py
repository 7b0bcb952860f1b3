"""`pymunk-dragon report`."""

from __future__ import annotations

from pathlib import Path

import click

from pymunk_dragon.cli.options import DragonCommand, destination_of, json_option, output_option
from pymunk_dragon.cli.output import print_json, progress, wrote


def _endings() -> tuple[str, ...]:
    """Endings of reports."""
    from pymunk_dragon.reports import REPORT_ENDINGS

    return REPORT_ENDINGS


@click.command(cls=DragonCommand, examples=("run.npz", "run.npz -o run.xlsx"), names=_endings)
@click.argument("run_file", metavar="RUN.npz", type=click.Path())
@json_option
@output_option("a document or a table", "RUN.html")
def report(run_file: str, as_json: bool, output: str | None) -> None:
    """Report on a run, as a document or a table.

    The ending of the file chooses the format: {names}.
    """
    from pymunk_dragon.model.run import Run
    from pymunk_dragon.reports import REPORT_ENDINGS
    from pymunk_dragon.reports import report as write_report

    destination = destination_of(output or f"{Path(run_file).stem}.html", REPORT_ENDINGS)
    assert destination is not None  # There is a name in any case.
    with progress("report") as show:
        write_report(Run.load(run_file), destination, progress=lambda done, total: show(done, total, "report"))
    wrote(destination)
    if as_json:
        print_json({"output": str(destination), "bytes": destination.stat().st_size})
