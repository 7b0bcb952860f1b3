"""Options that several commands share, and what they mean."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pymunk_dragon.cli.completion import files
from pymunk_dragon.cli.hints import unit_hint
from pymunk_dragon.cli.output import note
from pymunk_dragon.errors import FileFormatError, ParameterError

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March
    from pymunk_dragon.model.run import Run

Command = TypeVar("Command", bound=Callable[..., Any])

PROGRAM = "pymunk-dragon"
# Numbers in one list: more would fill the memory, and come from a typing error.
MAX_LIST = 1_000_000


def speed_or_file(value: str) -> float | str:
    """A number, or the name of a CSV file, which the scenario reads."""
    try:
        return float(value)
    except ValueError:
        if value.lower().endswith(".csv"):
            return value
        raise click.BadParameter(f"{value!r} is neither a number nor a file of a table, which ends in .csv") from None


# Headings of the options of a scenario in the help.
DRAGON, CURVE = "Dragon", "Curve and speed"
# Type, placeholder and help of each option of a scenario but those of curves; its flag is the name with hyphens.
SCENARIO_OPTIONS: dict[str, tuple[Any, str, str]] = {
    "benches": (int, "N", "Number of benches.  [223]"),
    "head_spacing": (float, "M", "Distance between the head's holes, m.  [2.86]"),
    "body_spacing": (float, "M", "Distance between any other bench's holes, m.  [1.65]"),
    "overhang": (float, "M", "From a hole to the end of the bench, m.  [0.275]"),
    "width": (float, "M", "Width of the benches, m.  [0.3]"),
    "turns": (float, "X", "Turn of the spiral on which the head starts.  [16]"),
    "speed": (speed_or_file, "M/S|FILE.csv", "Speed of the head, m/s, or a file with times and speeds t,v.  [1]"),
}


class Headed(click.Option):
    """An option under a heading of its own in the help."""

    def __init__(self, *arguments: Any, heading: str, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.heading = heading


def _scenario_option(name: str, heading: str, **settings: Any) -> Headed:
    """An option of a scenario, whose value `chosen` has."""

    def collect(context: click.Context, parameter: click.Parameter, value: Any) -> None:
        if value is not None:
            context.meta.setdefault("scenario", {})[parameter.name] = value

    flag = "--" + name.replace("_", "-")
    return Headed([flag, name], heading=heading, callback=collect, expose_value=False, **settings)


def curve_options() -> list[Headed]:
    """The options --curve and those of the registered curves."""
    from pymunk_dragon.model.curves import Curve
    from pymunk_dragon.model.scenario import named_curves

    named = named_curves()
    default = named[0]
    text = f"{', '.join(named)}, or a file with points x,y of a path, m.  [{default}]"
    complete = files(".csv", words=named)
    options = [_scenario_option("curve", CURVE, metavar="NAME|FILE.csv", help=text, shell_complete=complete)]
    flags: dict[str, list[str]] = {}
    # The default curve first.
    for kind in sorted(Curve.kinds, key=lambda kind: kind != default):
        for name in Curve.kinds[kind].flags:
            flags.setdefault(name, []).append(kind)
    for name, kinds in flags.items():
        metavar, _ = Curve.kinds[kinds[0]].flags[name]
        text = " ".join(dict.fromkeys(Curve.kinds[kind].flags[name][1] for kind in kinds))
        defaults = {kind: getattr(Curve.kinds[kind], name, None) for kind in kinds}
        known = [f"{value:g}" + f" of a {kind}" * (kind != kinds[0]) for kind, value in defaults.items() if value]
        text += f"  [{', or '.join(known)}]" if known else ""
        options.append(_scenario_option(name, CURVE, type=float, metavar=metavar, help=text))
    return options


def scenario_options(command: Command) -> Command:
    """Add the options of a scenario to a command, which gets `scenario_file`; `chosen` has the others."""
    for name, (kind, metavar, text) in reversed(SCENARIO_OPTIONS.items()):
        heading = CURVE if name in ("turns", "speed") else DRAGON
        complete = files(".csv") if name == "speed" else None
        option = _scenario_option(name, heading, type=kind, metavar=metavar, help=text, shell_complete=complete)
        _add(command, option)
    text = "Read the dragon, curve and speed from a file; options win."
    flags = ["--scenario", "scenario_file"]
    _add(command, Headed(flags, heading=DRAGON, metavar="FILE.toml", help=text, shell_complete=files(".toml")))
    return command


def _add(command: Any, option: click.Option) -> None:
    """Add an option above those that a command has, as decorators of Click do."""
    command.__click_params__ = [*getattr(command, "__click_params__", ()), option]


json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
start_option = click.option("--from", "start", type=float, default=0.0, metavar="T", help="First time, s.  [0]")


def output_option(endings: str, default: str | None = None) -> Callable[[Command], Command]:
    """The option -o; the ending of its file chooses the format."""
    text = f"File to write: {endings}." + (f"  [{default}]" if default else "")
    return click.option("-o", "--output", metavar="FILE", help=text, shell_complete=files())


def chosen() -> dict[str, Any]:
    """The scenario options that were given as flags, by name."""
    found: dict[str, Any] = click.get_current_context().meta.get("scenario", {})
    return found


def named_by_flag(error: ParameterError | FileFormatError) -> Exception:
    """The error with the name of a flag, if a flag has the parameter's name or, failing that, its number."""
    context = click.get_current_context()
    given = context.params | chosen()
    # Options of a scenario that are not given have their values from a file or by default: they keep their names.
    flags = {
        str(option.name): (option.opts[0], option.is_flag)
        for option in context.command.get_params(context)
        if isinstance(option, click.Option)
        and (getattr(option, "heading", "") not in (DRAGON, CURVE) or option.name in given)
    }
    if isinstance(error, FileFormatError):
        for name, (flag, _) in flags.items():
            if given.get(name) == str(error.path):
                return FileFormatError(f"{flag} {error.path}", error.reason)
        return error
    for name, (flag, is_flag) in flags.items():
        if error.name.removeprefix("curve.") in (name, flag.lstrip("-").replace("-", "_")):
            return ParameterError(flag, error.value, error.bound)
        if is_flag and isinstance(error.value, str) and error.value == name:
            return click.UsageError(f"{flag} must be {error.bound}")
    # Such as a time that a function deeper down calls t.
    number = error.value if isinstance(error.value, float) else None
    same = [flag for name, (flag, _) in flags.items() if number is not None and given.get(name) == number]
    return ParameterError(same[0], error.value, error.bound) if len(same) == 1 else error


def with_hint(error: Exception) -> Exception:
    """The error, with a hint if a length among the options is probably not in m."""
    hint = unit_hint(chosen())
    if not hint or isinstance(error, FileFormatError):
        return error
    if isinstance(error, ParameterError):
        return ParameterError(error.name, error.value, f"{error.bound}; {hint}")
    return click.UsageError(f"{error}; {hint}")


def march_of(scenario_file: str | None) -> March:
    """The march of a scenario file, whose values are replaced by those of flags."""
    from pymunk_dragon.model.scenario import Scenario

    values = Scenario.read(scenario_file) if scenario_file is not None else {}
    try:
        march = Scenario.from_dict(values | chosen()).march()
    except ParameterError as error:
        if error.name.removeprefix("curve.") in chosen():
            raise
        # A key of the file or a default. An option of this command may have its name: `start` is not --from.
        raise click.UsageError(str(error)) from error
    note_units()
    return march


def note_units() -> None:
    """Note lengths that are probably not in m. This is no error: a dragon of that size may be meant."""
    if hint := unit_hint(chosen()):
        note(f"note: {hint}")


def run_of(run_file: str, scenario_file: str | None) -> Run:
    """The run in a file, which has its own scenario."""
    from pymunk_dragon.model.run import Run

    if chosen() or scenario_file:
        raise click.UsageError("a run file contains its scenario: leave out the options of the dragon and its curve")
    return Run.load(run_file)


def destination_of(output: str | None, endings: tuple[str, ...]) -> Path | None:
    """The file to write, after `check_destination`; to be called before the long work."""
    if output is None:
        return None
    from pymunk_dragon._files import check_destination

    return check_destination(output, endings)


def number_list(name: str, text: str) -> list[float]:
    """Numbers from `0,60,120` or `0:300:1`, both ends included, or a mixture.

    A ParameterError names the parameter `name`.
    """
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
            if not 0 <= (values[1] - values[0]) / values[2] < MAX_LIST:
                raise ParameterError(name, text, f"at least one and at most {MAX_LIST} numbers, first:last:step")
            # Decimal numbers, as they are written: the second after 0.2 in steps of 0.1 is 0.4 and not 0.4 + 6e-17.
            first, last, step = map(Decimal, part.split(":"))
            numbers += [float(first + step * i) for i in range(int((last - first) / step) + 1)]
        else:
            raise ParameterError(name, text, bound)
    return numbers
