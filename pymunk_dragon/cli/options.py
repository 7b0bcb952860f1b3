"""What several commands take."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pymunk_dragon.errors import FileFormatError, ParameterError

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March
    from pymunk_dragon.model.run import Run

__all__ = [
    "PROGRAM",
    "SCENARIO_OPTIONS",
    "chosen",
    "destination_of",
    "json_option",
    "march_of",
    "named_flags",
    "number_list",
    "output_option",
    "run_of",
    "scenario_options",
    "start_option",
]

Command = TypeVar("Command", bound=Callable[..., Any])

PROGRAM = "pymunk-dragon"
# Numbers in one list: more fill the memory, and are a slip of the finger.
MAX_LIST = 1_000_000


def speed_text(value: str) -> float | str:
    """A number, or the name of a file; what may be in it is for the scenario to say."""
    try:
        return float(value)
    except ValueError:
        if value.lower().endswith(".csv"):
            return value
        raise click.BadParameter(f"{value!r} is neither a number nor a file of a table, which ends in .csv") from None


SCENARIO_OPTIONS: dict[str, tuple[Any, str, str]] = {
    "benches": (int, "N", "Number of benches.  [223]"),
    "head_spacing": (float, "M", "Distance between the head's holes, m.  [2.86]"),
    "body_spacing": (float, "M", "Distance between any other bench's holes, m.  [1.65]"),
    "overhang": (float, "M", "From a hole to the end of the bench, m.  [0.275]"),
    "width": (float, "M", "Width of the benches, m.  [0.3]"),
    "curve": (str, "NAME|FILE.csv", "spiral, u-turn, or a file with points x,y of a path, m.  [spiral]"),
    "pitch": (float, "M", "Distance between the turns of the spiral, m.  [0.55, or 1.7 of a u-turn]"),
    "turns": (float, "X", "Turn of the spiral on which the head starts.  [16]"),
    "radius": (float, "M", "Radius of the circle in which a u-turn is made, m.  [4.5]"),
    "ratio": (float, "X", "Radius of a u-turn's first arc over that of its second.  [2]"),
    "speed": (speed_text, "M/S|FILE.csv", "Speed of the head, m/s, or a file with times and speeds t,v.  [1]"),
}


def scenario_options(command: Command) -> Command:
    """Give a command the options of a scenario, as one argument `scenario`: the chosen names and values."""

    def collect(context: click.Context, parameter: click.Parameter, value: Any) -> None:
        if value is not None:
            context.meta.setdefault("scenario", {})[parameter.name] = value

    for name, (kind, metavar, text) in reversed(SCENARIO_OPTIONS.items()):
        flag = "--" + name.replace("_", "-")
        add = click.option(flag, name, type=kind, metavar=metavar, help=text, callback=collect, expose_value=False)
        command = add(command)
    file = click.option("--scenario", "scenario_file", metavar="FILE.toml", help="Read these from a file; flags win.")
    return file(command)


json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
start_option = click.option("--from", "start", type=float, default=0.0, metavar="T", help="First time, s.  [0]")


def output_option(endings: str, required: bool = False) -> Callable[[Command], Command]:
    """The option -o; its ending chooses the format."""
    return click.option("-o", "--output", metavar="FILE", required=required, help=f"File to write: {endings}.")


def chosen() -> dict[str, Any]:
    """The scenario options that were given as flags."""
    found: dict[str, Any] = click.get_current_context().meta.get("scenario", {})
    return found


def named_flags(command: Command) -> Command:
    """Let errors of a command name the flags of its options, where they name the parameters that these are given to."""

    @wraps(command)
    def called(*arguments: Any, **options: Any) -> Any:
        try:
            return command(*arguments, **options)
        except (ParameterError, FileFormatError) as error:
            raise _named_by_flag(error) from error

    return called  # type: ignore[return-value]  # It takes and returns the same.


def _named_by_flag(error: ParameterError | FileFormatError) -> Exception:
    context = click.get_current_context()
    values = context.params | chosen()
    for option in context.command.params:
        if not isinstance(option, click.Option):
            continue
        name, flag = str(option.name), option.opts[0]
        if isinstance(error, FileFormatError):
            if values.get(name) == str(error.path):
                return FileFormatError(f"{flag} {error.path}", error.reason)
        elif error.name in (name, flag.lstrip("-").replace("-", "_")):
            # Other values come from a scenario file, which has no flags.
            if name not in SCENARIO_OPTIONS or name in values:
                return ParameterError(flag, error.value, error.bound)
        elif option.is_flag and isinstance(error.value, str) and error.value == name:
            return click.UsageError(f"{flag} must be {error.bound}")
    return _named_by_value(error) if isinstance(error, ParameterError) else error


def _named_by_value(error: ParameterError) -> ParameterError:
    """The error with the name of the flag that was typed with its number, if there is one such flag."""
    if not isinstance(error.value, float):
        return error
    context = click.get_current_context()
    typed = [
        option.opts[0]
        for option in context.command.params
        if isinstance(option, click.Option) and context.params.get(str(option.name)) == error.value
    ]
    return ParameterError(typed[0], error.value, error.bound) if len(typed) == 1 else error


def march_of(scenario_file: str | None) -> March:
    """The march of a scenario file with the flags laid over it."""
    from pymunk_dragon.model.scenario import Scenario

    values = Scenario.read(scenario_file) if scenario_file is not None else {}
    return Scenario.from_dict({**values, **chosen()}).march()


def run_of(run_file: str, scenario_file: str | None) -> Run:
    """A run that was saved, which brings its own scenario."""
    from pymunk_dragon.model.run import Run

    if chosen() or scenario_file:
        raise click.UsageError("a run brings its own scenario: leave out the options of the dragon and its curve")
    return Run.load(run_file)


def destination_of(output: str | None, endings: tuple[str, ...]) -> Path | None:
    """Check where to write before the long work that makes what is written."""
    if output is None:
        return None
    from pymunk_dragon._files import check_destination

    return check_destination(output, endings)


def number_list(name: str, text: str) -> list[float]:
    """Numbers from `0,60,120` or `0:300:1`, both ends included, or a mixture."""
    bound = "numbers such as 0,60,120 or first:last:step such as 0:300:1"
    numbers: list[float] = []
    for part in text.split(","):
        try:
            values = [float(value) for value in part.split(":")]
        except ValueError:
            raise ParameterError(name, text, bound) from None
        if len(values) == 1:
            numbers += values
        elif len(values) == 3 and all(abs(value) < float("inf") for value in values) and values[2] > 0:
            first, last, step = values
            # A millionth of a step is rounding, as in 0:1:0.1.
            count = (last - first) / step + 1e-6
            if not 0 <= count < MAX_LIST:
                raise ParameterError(name, text, f"at least one and at most {MAX_LIST} numbers, first:last:step")
            numbers += [first + step * i for i in range(int(count) + 1)]
        else:
            raise ParameterError(name, text, bound)
    return numbers
