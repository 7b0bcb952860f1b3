"""`pymunk-dragon study`."""

from __future__ import annotations

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


def _study_options() -> list[click.Option]:
    """Options of single studies."""
    from pymunk_dragon.studies import STUDIES

    options: list[click.Option] = []
    for study in STUDIES.values():
        for name, option in study.options.items():
            flag = "--" + name.replace("_", "-")
            flags = [f"{flag}/--no-{flag[2:]}" if option.kind is bool else flag, name]
            about = {"heading": f"Options of {study.name}", "help": option.text[:1].upper() + option.text[1:]}
            options.append(Headed(flags, type=option.kind, metavar=option.metavar, default=None, **about))
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
    from pymunk_dragon._checks import word
    from pymunk_dragon._extras import library
    from pymunk_dragon.model.scenario import Scenario
    from pymunk_dragon.studies import STUDIES
    from pymunk_dragon.studies import study as run_study

    if name is None:
        listed = [f"{known:<11}  {text(summary)}" for known, summary in _studies().items()]
        return print_json({"studies": _studies()}) if as_json else click.echo("\n".join(listed))
    kind = STUDIES[word("study", name, STUDIES)]
    values: dict[str, Any] = {}
    if scenario_file is not None:
        # The whole file is checked, also the values that the study does not take.
        scenario = Scenario.from_dict(Scenario.read(scenario_file))
        values = {given: getattr(scenario, given, None) for given in kind.parameters}
    values = {given: value for given, value in (values | chosen() | options).items() if value is not None}
    if isinstance(values.get("speed"), str | tuple):
        values["speed"] = Scenario(speed=values["speed"]).march().speed
    destination = destination_of(output, kind.formats)
    ending = "" if destination is None else destination.suffix.lower()
    if ending not in ("", ".json"):
        # A missing library is named before the study runs.
        library("xlsxwriter" if ending == ".xlsx" else "matplotlib")
    with progress(name) as show:
        found = run_study(name, values, lambda done, total: show(done, total, name))
    if destination is not None:
        if ending == ".json":
            write_json(destination, found.to_dict())
        elif ending == ".xlsx":
            from pymunk_dragon.reports import write_tables

            write_tables(found.march, found.times, destination)
        else:
            found.write_figure(destination)
        wrote(destination)
    return print_json(found.to_dict()) if as_json else click.echo(found)
