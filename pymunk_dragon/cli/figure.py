"""`pymunk-dragon figure`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli import options
from pymunk_dragon.cli.options import DragonCommand, named
from pymunk_dragon.cli.output import answer, print_file, wrote
from pymunk_dragon.drawing.figures import FIGURES, write_figure


@click.command(cls=DragonCommand, examples=("", "gap --pitch 0.5", "drift run.npz -o drift.pdf"))
@click.argument("name", required=False, shell_complete=named(lambda: FIGURES))
@click.argument("run_file", metavar="[RUN.npz]", required=False, type=click.Path())
@options.scenario_options
@options.json_option
@options.output_option(".png or .pdf, or .svg where the figure has axes", "NAME.png")
def figure(
    name: str | None, run_file: str | None, scenario_file: str | None, as_json: bool, output: str | None
) -> None:
    """Draw one of the paper's figures, or one beyond it.

    Without a name, list them. Drift and impulses are drawn from a run of the engine, the others from a run's march or
    from the options.
    """
    if name is None:
        shown = {known: kind.shows for known, kind in FIGURES.items()}
        answer(as_json, {"figures": shown}, "\n".join(f"{known:<13} {text(shows)}" for known, shows in shown.items()))
        return
    source: Any = None
    if run_file is not None:
        source = options.run_of(run_file, scenario_file)
    elif options.chosen() or scenario_file:
        source = options.march_of(scenario_file)
    path = Path(output or f"{name}.png")
    write_figure(name, path, source)
    wrote(path)
    if as_json:
        print_file(path)
