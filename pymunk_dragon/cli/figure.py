"""`pymunk-dragon figure`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.options import (
    DragonCommand,
    chosen,
    destination_of,
    json_option,
    march_of,
    named,
    output_option,
    run_of,
    scenario_options,
)
from pymunk_dragon.cli.output import print_json, progress, wrote
from pymunk_dragon.errors import OutputError, ParameterError, UnreachableError

if TYPE_CHECKING:
    from pymunk_dragon.drawing.snapshots import Source

# Name of all figures, and the folder that they are written to by default.
ALL, FOLDER = "all", "figures"


def _figures() -> dict[str, str]:
    """Names of the figures, and what they show."""
    from pymunk_dragon.drawing.figures import FIGURES

    return {name: kind.shows for name, kind in FIGURES.items()}


def _names() -> dict[str, str]:
    """What may be given as the name of a figure."""
    return _figures() | {ALL: "all figures, in a folder"}


@click.command(cls=DragonCommand, examples=("", "gap --pitch 0.5", "drift run.npz -o drift.pdf", "all run.npz -o DIR"))
@click.argument("name", required=False, shell_complete=named(_names))
@click.argument("run_file", metavar="[RUN.npz]", required=False, type=click.Path())
@scenario_options
@json_option
@output_option(".png or .pdf, or .svg where the figure has axes; of all figures a folder", "NAME.png")
def figure(
    name: str | None, run_file: str | None, scenario_file: str | None, as_json: bool, output: str | None
) -> None:
    """Draw one of the paper's figures, or one beyond it, or all.

    Without a name, list them. Drift and impulses are drawn from a run of the engine, the others from a run's march or
    from the options.
    """
    from pymunk_dragon.drawing.figures import FIGURE_ENDINGS, FIGURES, write_figure

    if name is None:
        shown = _figures()
        if as_json:
            print_json({"figures": shown})
        else:
            click.echo("\n".join(f"{known:<13} {text(shows)}" for known, shows in shown.items()))
        return
    source = _source(run_file, scenario_file)
    if name == ALL:
        _write_all(Path(output or FOLDER), source, run_file, as_json)
        return
    endings = FIGURES[name].endings if name in FIGURES else FIGURE_ENDINGS
    destination = destination_of(output or f"{name}.png", endings)
    assert destination is not None  # There is a name in any case.
    write_figure(name, destination, source)
    wrote(destination)
    if as_json:
        print_json({"output": str(destination), "bytes": destination.stat().st_size})


def _source(run_file: str | None, scenario_file: str | None) -> Source | None:
    """Return the run or the march to draw; None for the figure's default."""
    if run_file is not None:
        return run_of(run_file, scenario_file)
    return march_of(scenario_file) if chosen() or scenario_file else None


def _write_all(folder: Path, source: Source | None, run_file: str | None, as_json: bool) -> None:
    """Write all figures that can be drawn from a source as PNG to a folder, and say which cannot and why."""
    from pymunk_dragon.drawing.figures import FIGURES, write_figure

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ParameterError("output", str(folder), "a folder that can be written") from error
    written: list[Path] = []
    left_out: dict[str, str] = {}
    with progress(ALL) as show:
        for done, (name, kind) in enumerate(FIGURES.items()):
            show(done, len(FIGURES), name)
            destination = folder / f"{name}.png"
            if kind.needs_run and run_file is None:
                left_out[name] = "it is drawn from a run of the engine: give RUN.npz"
                continue
            try:
                write_figure(name, destination, source)
                written.append(destination)
            except (ParameterError, UnreachableError) as error:
                if isinstance(error, ParameterError) and error.name == "output":
                    raise
                left_out[name] = str(error)
    for destination in written:
        wrote(destination)
    for name, reason in left_out.items():
        click.echo(text("left out {name}: {reason}").format(name=name, reason=reason), err=True)
    if as_json:
        files = [{"output": str(path), "bytes": path.stat().st_size} for path in written]
        print_json({"outputs": files, "left_out": left_out})
    if not written:
        raise OutputError(str(folder), "no figure can be drawn")
