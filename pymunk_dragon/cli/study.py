"""`pymunk-dragon study`."""

from collections.abc import Callable, Iterator
from inspect import signature
from pathlib import Path
from typing import Any

import click

from pymunk_dragon.cli.options import (
    F,
    command,
    file_values,
    option_group,
    option_values,
    output_option,
    scenario_options,
)
from pymunk_dragon.cli.output import (
    destination_of,
    print_list,
    print_result,
    progress,
    write_result,
)
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.studies import STUDIES


def _options() -> Iterator[Callable[[F], F]]:
    """The options of single studies."""
    for study in STUDIES.values():
        for name, words in study.flags.items():
            kind = type(signature(study.run).parameters[name].default)
            flag = name.replace("_", "-")
            flags = f"--{flag}/--no-{flag}" if kind is bool else f"--{flag}"
            about = f"Options of {study.name}: {words[:1].upper()}{words[1:]}"
            yield click.option(flags, name, type=kind, default=None, help=about)


@command("", "min-pitch", "u-turn -o turn.png", "max-speed --limit 1.5", "paper -o answers.html")
@click.argument("name", metavar="[STUDY]", required=False, type=click.Choice(list(STUDIES)))
@scenario_options
@option_group(*_options())
@output_option(
    ".json, .png, .svg or .pdf for a picture of the answer, .xlsx for sheets of the contest, or "
    ".html for a page"
)
def study(name: str | None, output: str | None, **options: float | bool | None) -> None:
    """Run a study of many marches.

    Without a name, list the studies. A study uses the values of a scenario file that are its
    parameters, and ignores the others, as the pitch where it is the result. The radius is that of
    the circle to which the head marches.
    """
    if name is None:
        return print_list("studies", {each.name: each.summary for each in STUDIES.values()})
    values = _values(name, options)
    path = destination_of(output, STUDIES[name].formats)
    with progress("study") as show:
        found = STUDIES[name].answer(values, show)
    result = found.to_dict()
    write_result(path, result, lambda path: _write(found, path))
    return print_result(result, found)


def _values(name: str, options: dict[str, Any]) -> dict[str, Any]:
    """Values of a study's parameters: those of a scenario file, and of options, which win."""
    values: dict[str, Any] = {}
    if in_file := file_values():
        # The whole file is checked, also the values that the study does not take.
        known = Scenario.from_dict(in_file).values()
        values = {given: known.get(given) for given in STUDIES[name].parameters}
    values |= option_values() | options
    if isinstance(values.get("speed"), str | tuple):
        values["speed"] = Scenario(speed=values["speed"]).march().speed
    return {given: value for given, value in values.items() if value is not None}


def _write(found: Any, path: Path) -> None:
    """Write sheets of the contest, a page, or the figure."""
    ending = path.suffix.lower()
    if ending == ".html":
        from pymunk_dragon.reports.paper import write_paper

        write_paper(found, path)
    elif ending == ".xlsx":
        from pymunk_dragon.reports import write_tables

        write_tables(found.march, found.times, path)
    else:
        found.write_figure(path)
