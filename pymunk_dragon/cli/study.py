"""`pymunk-dragon study`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pymunk_dragon.cli.options import chosen, destination_of, json_option, output_option, scenario_options
from pymunk_dragon.cli.output import print_json, progress, write_json

__all__ = ["study"]


@click.command()
@click.argument("name", required=False)
@scenario_options
@click.option("--limit", type=float, metavar="M/S", help="Of max-speed: no handle shall be faster, m/s.  [2]")
@click.option("--fastest", type=float, metavar="X", help="Of u-turn: times as fast as the head that anybody may be.")
@click.option("--search/--no-search", default=None, help="Of u-turn: search for a shorter turn on more arcs.  [search]")
@click.option("--arcs", type=int, metavar="N", help="Of u-turn: largest number of arcs in the search, odd.  [7]")
@click.option("--min-radius", type=float, metavar="M", help="Of u-turn: least radius in the search, m.  [0.5]")
@json_option
@output_option(".json, .png or .svg for a picture of the answer, or .xlsx for the contest's sheets of the u-turn")
def study(
    name: str | None,
    scenario_file: str | None,
    limit: float | None,
    fastest: float | None,
    search: bool | None,
    arcs: int | None,
    min_radius: float | None,
    as_json: bool,
    output: str | None,
) -> None:
    """Run a study of many marches; without a name, list the studies.

    A study uses the values of a scenario file that are its parameters, and ignores the others, as the pitch where it is
    the result. The radius is that of the circle to which the head marches.
    """
    from pymunk_dragon.studies import STUDIES
    from pymunk_dragon.studies import study as run_study
    from pymunk_dragon.study_words import study_answer, study_in_words

    if name is None:
        summaries = {known: kind.summary for known, kind in STUDIES.items()}
        if as_json:
            print_json({"studies": summaries})
        else:
            click.echo("\n".join(f"{known:<11}  {summary}" for known, summary in summaries.items()))
        return
    values = _of_file(scenario_file, STUDIES[name].parameters if name in STUDIES else ()) | chosen()
    if isinstance(values.get("speed"), str | tuple):
        values["speed"] = _speed(values["speed"])
    own = {"limit": limit, "fastest": fastest, "search": search, "arcs": arcs, "min_radius": min_radius}
    values |= {given: value for given, value in own.items() if value is not None}
    destination = destination_of(output, (".json", ".png", ".svg", *((".xlsx",) if name == "u-turn" else ())))
    if destination is not None:
        _check_libraries(destination)
    with progress(name) as show:
        found = run_study(name, values, lambda done, total: show(done, total, name))
    answer = study_answer(found)
    if destination is not None:
        _write(found, answer, destination)
    if as_json:
        print_json(answer)
    else:
        click.echo(study_in_words(found))


def _of_file(scenario_file: str | None, takes: tuple[str, ...]) -> dict[str, Any]:
    """What a scenario's file says of the numbers that a study takes."""
    if scenario_file is None:
        return {}
    from pymunk_dragon.model.scenario import Scenario

    # Checked as a whole: a slip in what is left aside is a slip all the same.
    scenario = Scenario.from_dict(Scenario.read(scenario_file))
    values = {option: getattr(scenario, option, None) for option in takes}
    return {option: value for option, value in values.items() if value is not None}


def _speed(table: Any) -> Any:
    """A speed that is a table of numbers or a file, as studies take it."""
    from pymunk_dragon.model.scenario import Scenario

    return Scenario(speed=table).march().speed


def _check_libraries(destination: Path) -> None:
    """Refuse what cannot be written before the study runs."""
    from pymunk_dragon._extras import library

    needed = {".png": "matplotlib", ".svg": "matplotlib", ".xlsx": "xlsxwriter"}
    if (name := needed.get(destination.suffix.lower())) is not None:
        library(name)


def _write(found: Any, answer: dict[str, Any], destination: Path) -> None:
    if destination.suffix.lower() == ".json":
        write_json(destination, answer)
    elif destination.suffix.lower() == ".xlsx":
        from pymunk_dragon.reports import write_tables

        write_tables(found.march, found.times, destination)
    else:
        from pymunk_dragon.drawing.figures import write_answer

        write_answer(found, destination)
