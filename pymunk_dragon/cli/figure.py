"""`pymunk-dragon figure`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli import options
from pymunk_dragon.cli.options import DragonCommand, named
from pymunk_dragon.cli.output import print_json, progress, wrote
from pymunk_dragon.errors import OutputError, ParameterError, UnreachableError

# Name of all figures, and the folder that they are written to by default.
ALL, FOLDER = "all", "figures"


def _names() -> dict[str, str]:
    """What may be given as the name of a figure, and what it shows."""
    from pymunk_dragon.drawing.figures import FIGURES

    return {name: kind.shows for name, kind in FIGURES.items()} | {ALL: "all figures, in a folder"}


@click.command(cls=DragonCommand, examples=("", "gap --pitch 0.5", "drift run.npz -o drift.pdf", "all run.npz -o DIR"))
@click.argument("name", required=False, shell_complete=named(_names))
@click.argument("run_file", metavar="[RUN.npz]", required=False, type=click.Path())
@options.scenario_options
@options.json_option
@options.output_option(".png or .pdf, or .svg where the figure has axes; of all figures a folder", "NAME.png")
def figure(
    name: str | None, run_file: str | None, scenario_file: str | None, as_json: bool, output: str | None
) -> None:
    """Draw one of the paper's figures, or one beyond it, or all.

    Without a name, list them. Drift and impulses are drawn from a run of the engine, the others from a run's march or
    from the options.
    """
    from pymunk_dragon.drawing.figures import FIGURES

    if name is None:
        shown = {known: kind.shows for known, kind in FIGURES.items()}
        if as_json:
            print_json({"figures": shown})
        else:
            click.echo("\n".join(f"{known:<13} {text(shows)}" for known, shows in shown.items()))
        return
    source: Any = None
    if run_file is not None:
        source = options.run_of(run_file, scenario_file)
    elif options.chosen() or scenario_file:
        source = options.march_of(scenario_file)
    paths = {name: Path(output or f"{name}.png")}
    if name == ALL:
        paths = {known: Path(output or FOLDER) / f"{known}.png" for known in FIGURES}
        try:
            Path(output or FOLDER).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ParameterError("output", output, "a folder that can be written") from error
    left_out = _write(name, paths, source)
    written = [path for known, path in paths.items() if known not in left_out]
    for path in written:
        wrote(path)
    for known, reason in left_out.items():
        click.echo(text("left out {name}: {reason}").format(name=known, reason=reason), err=True)
    if as_json:
        sizes = [{"output": str(path), "bytes": path.stat().st_size} for path in written]
        print_json({"outputs": sizes, "left_out": left_out} if name == ALL else sizes[0])
    if not written:
        raise OutputError(output or FOLDER, "no figure can be drawn")


def _write(name: str, paths: dict[str, Path], source: Any) -> dict[str, str]:
    """Write the figures with these paths; return why some of all figures cannot be drawn."""
    from pymunk_dragon.drawing.figures import write_figure

    left_out: dict[str, str] = {}
    with progress(name) as show:
        for done, (known, path) in enumerate(paths.items()):
            show(done, len(paths), known)
            try:
                write_figure(known, path, source)
            except (ParameterError, UnreachableError) as error:
                if name != ALL or getattr(error, "name", "") == "output":
                    raise
                left_out[known] = str(error)
    return left_out
