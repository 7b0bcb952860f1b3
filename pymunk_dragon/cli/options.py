"""The class of the commands, the options that several of them share, and what these mean."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pymunk_dragon._files import check_destination
from pymunk_dragon._language import in_language
from pymunk_dragon.errors import ParameterError

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March
    from pymunk_dragon.model.run import Run

F = TypeVar("F", bound=Callable[..., Any])

PROGRAM = "pymunk-dragon"
LANGUAGE_VARIABLE = "PYMUNK_DRAGON_LANG"
# Numbers in one list: more would come from a typing error.
MAX_LIST = 100_000


def speed_or_file(value: str) -> float | str:
    """A number, or the name of a file, which the scenario reads."""
    try:
        return float(value)
    except ValueError:
        return value


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


class DragonCommand(click.Command):
    """A command with the option --lang, whose errors name flags instead of the parameters that get their values.

    Its help has the options of a scenario last, and below them `examples`: arguments of the command. `names` stand for
    {names} in the help.
    """

    def __init__(self, *arguments: Any, examples: Iterable[str], names: Iterable[str] = (), **others: Any) -> None:
        super().__init__(*arguments, **others)
        self.epilog = epilog_of(f"{self.name} {example}" for example in examples)
        self.help = str(self.help).replace("{names}", ", ".join(names))
        text = f"Language of results: en or zh.  [{LANGUAGE_VARIABLE} of the environment, or en]"
        settings: dict[str, Any] = {"callback": _choose_language, "expose_value": False}
        lang = click.Option(
            ["--lang", "language"], metavar="LANG", default="en", envvar=LANGUAGE_VARIABLE, help=text, **settings
        )
        # The values of the options of a scenario are not arguments of the function.
        self.params = sorted([*self.params, lang], key=lambda option: not option.expose_value)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except ParameterError as error:
            name = error.name.removeprefix("curve.")
            for option in self.params:
                if option.name == name and is_given(ctx, name):
                    raise ParameterError(option.opts[0], error.value, error.bound) from error
            raise


def epilog_of(examples: Iterable[str]) -> str:
    """The end of a help: examples, each a command with its arguments."""
    return "\n".join(["\b", "Examples:", *(f"  {PROGRAM} {example}".rstrip() for example in examples)])


def is_given(context: click.Context, name: str) -> bool:
    """Whether an option was given as a flag."""
    return context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE


def _choose_language(context: click.Context, parameter: click.Parameter, value: str) -> None:
    context.with_resource(in_language(value))


json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
start_option = click.option("--from", "start", type=float, default=0.0, metavar="T", help="First time, s.  [0]")
until_option = click.option("--until", type=float, metavar="T", help="Last time, s.  [the end of the curve]")


def output_option(endings: str, default: str | None = None) -> Callable[[F], F]:
    """The option -o; the ending of its file chooses the format."""
    text = f"File to write: {endings}." + (f"  [{default}]" if default else "")
    return click.option("-o", "--output", metavar="FILE", type=click.Path(), help=text)


def named(load: Callable[[], Iterable[str]]) -> Callable[[click.Context, click.Parameter, str], Any]:
    """Completion of the names that `load` returns."""
    return lambda context, parameter, incomplete: [name for name in load() if name.startswith(incomplete)]


def scenario_options(function: F) -> F:
    """Add the options of a scenario to a command, which gets `scenario_file`; `chosen` has the others."""

    def collect(context: click.Context, parameter: click.Parameter, value: Any) -> None:
        if value is not None:
            context.meta.setdefault("scenario", {})[parameter.name] = value

    for name, (kind, metavar, text) in reversed((SCENARIO_OPTIONS | _curve_options()).items()):
        flag = "--" + name.replace("_", "-")
        add = click.option(flag, name, type=kind, metavar=metavar, help=text, callback=collect, expose_value=False)
        add(function)
    text = "Read the dragon, curve and speed from a file; options win."
    return click.option("--scenario", "scenario_file", metavar="FILE.toml", type=click.Path(), help=text)(function)


def _curve_options() -> dict[str, tuple[Any, str, str]]:
    """The options --curve and those of the registered curves."""
    from pymunk_dragon.model.curves import Curve
    from pymunk_dragon.model.scenario import named_curves

    default, *others = named_curves()
    text = f"{', '.join([default, *others])}, or a file with points x,y of a path, m.  [{default}]"
    options: dict[str, tuple[Any, str, str]] = {"curve": (str, "NAME|FILE.csv", text)}
    for kind in dict.fromkeys((default, *Curve.kinds)):
        for flag, (metavar, text) in Curve.kinds[kind].flags.items():
            value = getattr(Curve.kinds[kind], flag, None)
            shown = f"  [{value:g} of a {kind}]" if value else ""
            options[flag] = (float, metavar, options.get(flag, ("", "", text))[2] + shown)
    return options


def chosen() -> dict[str, Any]:
    """The scenario options that were given as flags, by name."""
    found: dict[str, Any] = click.get_current_context().meta.get("scenario", {})
    return found


def march_of(scenario_file: str | None) -> March:
    """The march of a scenario file, whose values are replaced by those of flags."""
    from pymunk_dragon.model.scenario import Scenario

    values = Scenario.read(scenario_file) if scenario_file is not None else {}
    try:
        return Scenario.from_dict(values | chosen()).march()
    except ParameterError as error:
        if error.name.removeprefix("curve.") in chosen():
            raise
        # A key of the file, which may have the name of another option: `start` is not --from.
        raise click.UsageError(str(error)) from error


def run_of(run_file: str, scenario_file: str | None) -> Run:
    """The run in a file, which has its own scenario."""
    from pymunk_dragon.model.run import Run

    if chosen() or scenario_file:
        raise click.UsageError("a run file contains its scenario: leave out the options of the dragon and its curve")
    return Run.load(run_file)


def destination_of(output: str | None, endings: Iterable[str]) -> Path | None:
    """The file to write, after `check_destination`; to be called before the long work."""
    return None if output is None else check_destination(output, endings)


def ending_of(path: Path | None) -> str:
    """The ending of a file, which chooses the format; empty without a file."""
    return "" if path is None else path.suffix.lower()


def number_list(name: str, text: str) -> list[float]:
    """Numbers from `0,60,120` or `0:300:1`, both ends included, or a mixture; `name` is that of the parameter."""
    numbers: list[float] = []
    try:
        for part in text.split(","):
            # Decimal numbers, as they are written: the second after 0.2 in steps of 0.1 is 0.4 and not 0.4 + 6e-17.
            first, *others = map(Decimal, part.split(":"))
            last, step = others or (first, Decimal(1))
            steps = (last - first) / step
            if not (step > 0 and 0 <= steps < MAX_LIST):
                raise ValueError
            numbers += [float(first + step * i) for i in range(int(steps) + 1)]
    except (ValueError, ArithmeticError):
        bound = f"numbers such as 0,60,120 or first:last:step such as 0:300:1, of which there are at most {MAX_LIST}"
        raise ParameterError(name, text, bound) from None
    return numbers
