"""`pymunk-dragon report`."""

from pathlib import Path

import click

from pymunk_dragon import reports
from pymunk_dragon.cli.options import command, output_option
from pymunk_dragon.cli.output import print_file_result
from pymunk_dragon.model.run import Run


@command("run.npz", "run.npz -o run.md")
@click.argument("run_file", metavar="RUN.npz", type=click.Path())
@output_option(", ".join(reports.FORMATS), "RUN.html")
def report(run_file: str, output: str | None) -> None:
    """Report on a run, as a document or a table."""
    path = Path(output or f"{Path(run_file).stem}.html")
    reports.report(Run.load(run_file), path)
    print_file_result(path)
