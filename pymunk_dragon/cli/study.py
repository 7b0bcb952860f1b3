"""`pymunk-dragon study`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pymunk_dragon._language import text
from pymunk_dragon.cli.options import (
    DragonCommand,
    Headed,
    chosen,
    destination_of,
    json_option,
    named,
    output_option,
    scenario_options,
)
from pymunk_dragon.cli.output import print_json, progress, write_json, wrote

# Library that is needed to write each format.
LIBRARIES = {".png": "matplotlib", ".svg": "matplotlib", ".pdf": "matplotlib", ".xlsx": "xlsxwriter"}


def _study_options() -> list[click.Option]:
    """Options of single studies."""
    from pymunk_dragon.studies import STUDIES

    options: list[click.Option] = []
    for study in STUDIES.values():
        for name, option in study.options.items():
            flag, heading = name.replace("_", "-"), f"Options of {study.name}"
            text, kind = f"{option.text[:1].upper()}{option.text[1:]}", option.kind
            if kind is bool:
                flags = [f"--{flag}/--no-{flag}", name]
                options.append(Headed(flags, heading=heading, default=None, help=text))
            else:
                options.append(
                    Headed([f"--{flag}", name], heading=heading, type=kind, metavar=option.metavar, help=text)
                )
    return options


def _studies() -> dict[str, str]:
    """Names of the studies, and what they are."""
    from pymunk_dragon.studies import STUDIES

    return {name: kind.summary for name, kind in STUDIES.items()}


@click.command(
    cls=DragonCommand,
    examples=("", "min-pitch", "u-turn -o turn.png", "max-speed --limit 1.5"),
    registered={"as_json": _study_options},
)
@click.argument("name", required=False, shell_complete=named(_studies))
@scenario_options
@json_option
@output_option(".json, .png, .svg or .pdf for a picture of the answer, or .xlsx for sheets of the contest")
def study(
    name: str | None, scenario_file: str | None, as_json: bool, output: str | None, **options: float | bool | None
) -> None:
    """Run a study of many marches.

    Without a name, list the studies. A study uses the values of a scenario file that are its parameters, and ignores
    the others, as the pitch where it is the result. The radius is that of the circle to which the head marches.
    """
    from pymunk_dragon.studies import STUDIES
    from pymunk_dragon.studies import study as run_study

    if name is None:
        summaries = _studies()
        if as_json:
            print_json({"studies": summaries})
        else:
            click.echo("\n".join(f"{known:<11}  {text(summary)}" for known, summary in summaries.items()))
        return
    takes = STUDIES[name].parameters if scenario_file is not None and name in STUDIES else ()
    values = _of_file(scenario_file, takes) | chosen()
    if isinstance(values.get("speed"), str | tuple):
        values["speed"] = _speed(values["speed"])
    values |= {given: value for given, value in options.items() if value is not None}
    sheets = (".xlsx",) if name in STUDIES and STUDIES[name].has_sheets else ()
    destination = destination_of(output, (".json", ".png", ".svg", ".pdf", *sheets))
    if destination is not None and destination.suffix.lower() in LIBRARIES:
        from pymunk_dragon._extras import library

        # A missing library is named before the study runs.
        library(LIBRARIES[destination.suffix.lower()])
    with progress(name) as show:
        found = run_study(name, values, lambda done, total: show(done, total, name))
    if destination is not None:
        _write(found, destination)
        wrote(destination)
    if as_json:
        print_json(found.to_dict())
    else:
        click.echo(found)


def _of_file(scenario_file: str | None, takes: tuple[str, ...]) -> dict[str, Any]:
    """Values of a scenario file that are parameters of the study."""
    if scenario_file is None:
        return {}
    from pymunk_dragon.model.scenario import Scenario

    # The whole file is checked, also the values that the study does not take.
    scenario = Scenario.from_dict(Scenario.read(scenario_file))
    values = {option: getattr(scenario, option, None) for option in takes}
    return {option: value for option, value in values.items() if value is not None}


def _speed(table: Any) -> Any:
    """A speed that is a table of numbers or a file, as studies take it."""
    from pymunk_dragon.model.scenario import Scenario

    return Scenario(speed=table).march().speed


def _write(found: Any, destination: Path) -> None:
    if destination.suffix.lower() == ".json":
        write_json(destination, found.to_dict())
    elif destination.suffix.lower() == ".xlsx":
        from pymunk_dragon.reports import write_tables

        write_tables(found.march, found.times, destination)
    else:
        found.write_figure(destination)
