"""`pymunk-dragon figure`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from pymunk_dragon.cli.command import DragonCommand
from pymunk_dragon.cli.completion import files, named
from pymunk_dragon.cli.options import (
    chosen,
    destination_of,
    json_option,
    march_of,
    output_option,
    run_of,
    scenario_options,
)
from pymunk_dragon.cli.output import print_json, wrote

if TYPE_CHECKING:
    from pymunk_dragon.drawing.snapshots import Source


def _figures() -> dict[str, str]:
    """Names of the figures, and what they show."""
    from pymunk_dragon.drawing.figures import FIGURES

    return {name: kind.shows for name, kind in FIGURES.items()}


@click.command(cls=DragonCommand, examples=("", "gap --pitch 0.5", "drift run.npz -o drift.svg"))
@click.argument("name", required=False, shell_complete=named(_figures))
@click.argument("run_file", metavar="[RUN.npz]", required=False, shell_complete=files(".npz"))
@scenario_options
@json_option
@output_option(".png, or .svg or .pdf where the figure has axes", "NAME.png")
def figure(
    name: str | None, run_file: str | None, scenario_file: str | None, as_json: bool, output: str | None
) -> None:
    """Draw one of the paper's figures, or one beyond it.

    Without a name, list them. Drift and impulses are drawn from a run of the engine, the others from a run's march or
    from the options.
    """
    from pymunk_dragon.drawing.figures import FIGURE_ENDINGS, FIGURES, write_figure

    if name is None:
        shown = _figures()
        if as_json:
            print_json({"figures": shown})
        else:
            click.echo("\n".join(f"{known:<13} {shows}" for known, shows in shown.items()))
        return
    source = _source(run_file, scenario_file)
    endings = FIGURES[name].endings if name in FIGURES else FIGURE_ENDINGS
    destination = destination_of(output or f"{name}.png", endings)
    assert destination is not None
    write_figure(name, destination, source)
    wrote(destination)
    if as_json:
        print_json({"output": str(destination), "bytes": destination.stat().st_size})


def _source(run_file: str | None, scenario_file: str | None) -> Source | None:
    """Return the run or the march to draw; None for the figure's default."""
    if run_file is not None:
        return run_of(run_file, scenario_file)
    return march_of(scenario_file) if chosen() or scenario_file else None
