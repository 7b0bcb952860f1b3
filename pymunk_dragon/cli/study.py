"""`pymunk-dragon study`."""

from __future__ import annotations

from typing import Any

import click

from pymunk_dragon._checks import word
from pymunk_dragon._extras import library
from pymunk_dragon._language import text
from pymunk_dragon.cli.options import (
    DragonCommand,
    F,
    chosen,
    destination_of,
    ending_of,
    json_option,
    named,
    output_option,
    scenario_options,
)
from pymunk_dragon.cli.output import answer, progress, write_json, wrote
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.studies import STUDIES
from pymunk_dragon.studies import study as run_study


def study_options(function: F) -> F:
    """Add the options of single studies to a command."""
    known = [(study.name, name, option) for study in STUDIES.values() for name, option in study.options.items()]
    for of, name, option in reversed(known):
        flag = name.replace("_", "-")
        flags = f"--{flag}/--no-{flag}" if option.kind is bool else f"--{flag}"
        about = f"Options of {of}: {option.text[:1].upper()}{option.text[1:]}"
        click.option(flags, name, type=option.kind, metavar=option.metavar, default=None, help=about)(function)
    return function


@click.command(
    cls=DragonCommand,
    examples=("", "min-pitch", "u-turn -o turn.png", "max-speed --limit 1.5"),
)
@click.argument("name", required=False, shell_complete=named(lambda: STUDIES))
@scenario_options
@study_options
@json_option
@output_option(".json, .png, .svg or .pdf for a picture of the answer, or .xlsx for sheets of the contest")
def study(
    name: str | None, scenario_file: str | None, as_json: bool, output: str | None, **options: float | bool | None
) -> None:
    """Run a study of many marches.

    Without a name, list the studies. A study uses the values of a scenario file that are its parameters, and ignores
    the others, as the pitch where it is the result. The radius is that of the circle to which the head marches.
    """
    if name is None:
        known = {each.name: each.summary for each in STUDIES.values()}
        listed = "\n".join(f"{name:<11}  {text(summary)}" for name, summary in known.items())
        return answer(as_json, {"studies": known}, listed)
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
    ending = ending_of(destination)
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
    return answer(as_json, found.to_dict(), found)
