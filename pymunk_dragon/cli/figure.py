"""`pymunk-dragon figure`."""

from pathlib import Path
from typing import Any

import click

from pymunk_dragon.cli.options import (
    chosen_march,
    command,
    file_values,
    load_run,
    option_values,
    output_option,
    scenario_options,
)
from pymunk_dragon.cli.output import print_file_result, print_list
from pymunk_dragon.drawing.figures import FIGURES, write_figure


@command("", "gap --pitch 0.5", "drift run.npz -o drift.pdf")
@click.argument("name", metavar="[FIGURE]", required=False, type=click.Choice(list(FIGURES)))
@click.argument("run_file", metavar="[RUN.npz]", required=False, type=click.Path())
@scenario_options
@output_option(".png, or .svg or .pdf where the figure has axes", "NAME.png")
def figure(name: str | None, run_file: str | None, output: str | None) -> None:
    """Draw one of the paper's figures, or one beyond it.

    Without a name, list them. Drift and forces are drawn from a run, the others
    from a run's march or from the options.
    """
    if name is None:
        return print_list("figures", {known: each.shows for known, each in FIGURES.items()})
    source: Any = None
    if run_file is not None:
        source = load_run(run_file)
    elif file_values() or option_values():
        source = chosen_march()
    path = Path(output or f"{name}.png")
    write_figure(name, path, source)
    return print_file_result(path)
