"""Options that commands share, and the dragons, marches, runs and numbers that they stand for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from decimal import Decimal
from functools import reduce
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pymunk_dragon._language import in_language
from pymunk_dragon.errors import ParameterError

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March
    from pymunk_dragon.model.run import Run

F = TypeVar("F", bound=Callable[..., Any])

PROGRAM = "pymunk-dragon"
# Numbers in one list: more would come from a typing error.
_MAX_LIST = 100_000


def number_or_file(value: str) -> float | str:
    """A number, or the name of a file, which the scenario reads."""
    try:
        return float(value)
    except ValueError:
        return value


# Type and help of each option of a scenario but those of curves; its flag is the name
# with hyphens.
SCENARIO_OPTIONS: dict[str, tuple[Any, str]] = {
    "benches": (int, "Number of benches.  [223]"),
    "head_spacing": (float, "Distance between the head's holes, m.  [2.86]"),
    "body_spacing": (float, "Distance between any other bench's holes, m.  [1.65]"),
    "overhang": (float, "From a hole to the end of the bench, m.  [0.275]"),
    "width": (float, "Width of the benches, m.  [0.3]"),
    "turns": (float, "Turn of the spiral on which the head starts.  [16]"),
    "speed": (
        number_or_file,
        "Speed of the head, m/s, or a file with times and speeds t,v.  [1]",
    ),
}


class _Command(click.Command):
    """A command with the option --lang, whose errors name flags in place of parameters.

    The help has the options of a scenario last, and below them `examples`: arguments of the
    command.
    """

    def __init__(self, *arguments: Any, examples: Sequence[str], **others: Any) -> None:
        super().__init__(*arguments, **others)
        self.epilog = epilog_of([f"{self.name} {example}" for example in examples])
        # The values of the options of a scenario are not arguments of the function.
        own = sorted(self.params, key=lambda option: not option.expose_value)
        self.params = [*own, _LANGUAGE]

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command in its language, without the values of options that others use."""
        ctx.meta["json"] = ctx.params.pop("json", None)
        ctx.meta["file"] = ctx.params.pop("scenario", None)
        try:
            with in_language(ctx.params.pop("lang")):
                return super().invoke(ctx)
        except ParameterError as error:
            name = _source_of(error)
            if error.value is None:
                raise click.UsageError(f"{name} is missing: it must be {error.bound}") from error
            raise ParameterError(name, error.value, error.bound) from error


def command(*examples: str) -> Callable[[Callable[..., Any]], click.Command]:
    """Make a function a command, with `examples` of its arguments in the help."""
    return click.command(cls=_Command, examples=examples)


def epilog_of(examples: Sequence[str]) -> str:
    """The end of a help: examples, each a command with its arguments."""
    lines = [f"  {PROGRAM} {example}".rstrip() for example in examples]
    return "\n".join(["\b", "Examples:", *lines])


def flags_given(*names: str) -> list[str]:
    """Flags of those of the options `names` that were given on the command line."""
    context = click.get_current_context()
    flags = []
    for option in context.command.params:
        source = context.get_parameter_source(str(option.name))
        if option.name in names and source is click.core.ParameterSource.COMMANDLINE:
            flags.append(option.opts[0])
    return flags


def _source_of(error: ParameterError) -> str:
    """Where a refused value comes from: a flag, an argument, or a scenario file."""
    from pymunk_dragon.model.scenario import parameters

    name = error.name.removeprefix("curve.")
    for flag in flags_given(name):
        return flag

    context = click.get_current_context()
    file = context.meta["file"]
    with suppress(ParameterError):  # The file may have a value where a table has to be.
        if name in file_values():
            return f"{error.name} in {file}"

    # A value of the environment, a default, or a value without an option.
    for each in context.command.params:
        if each.name == name:
            return str(each.envvar or each.opts[0])
        if isinstance(each, click.Argument) and str(each.name).startswith(name):
            return str(each.metavar).strip("[].")

    # The function that refuses the value may have another name for it.
    values = context.params | option_values()
    for flag in flags_given(*(each for each in values if values[each] == error.value)):
        return flag

    if file is not None:
        return f"{error.name} in {file}"
    of_scenario = error.value is None or name in parameters()
    return f"{error.name} of a file for --scenario" if of_scenario else error.name


def option_group(*declared: Callable[[F], F]) -> Callable[[F], F]:
    """Several options of a command as one decorator."""
    return lambda function: reduce(lambda done, option: option(done), reversed(declared), function)


def options_of(table: Mapping[str, tuple[Any, str]], **settings: Any) -> Callable[[F], F]:
    """Options with a type and a help each; the flag is the name with hyphens."""
    options = []
    for name, (kind, about) in table.items():
        flag = "--" + name.replace("_", "-")
        options.append(click.option(flag, type=kind, help=about, **settings))
    return option_group(*options)


# Options of commands that serve a page.
address_options = option_group(
    click.option("--port", default=0, help="Port.  [a free one]"),
    click.option(
        "--host",
        default="127.0.0.1",
        help="Address to listen on.  [this machine only]",
    ),
    click.option(
        "--allow-host",
        "allow_hosts",
        multiple=True,
        help="Name of a proxy; repeatable.",
    ),
    click.option(
        "--no-browser", "browser", flag_value=False, default=True, help="Do not open a browser."
    ),
)


_LANGUAGE = click.Option(
    ["--lang"],
    default="en",
    envvar="PYMUNK_DRAGON_LANG",
    help="Language of results: en or zh.  [PYMUNK_DRAGON_LANG of the environment, or en]",
)
json_option = click.option("--json", is_flag=True, help="Print one JSON object and nothing else.")
start_option = click.option("--from", "start", default=0.0, help="First time, s.  [0]")
until_option = click.option("--until", type=float, help="Last time, s.  [the end of the curve]")


def output_option(endings: str, default: str | None = None) -> Callable[[F], F]:
    """The options --json and -o; the ending of its file chooses the format."""
    about = f"File to write: {endings}."
    if default is not None:
        about += f"  [{default}]"
    output = click.option("-o", "--output", type=click.Path(), help=about)
    return option_group(json_option, output)


def scenario_options(function: F) -> F:
    """Add the options of a scenario to a command.

    `file_values`, `option_values` and `chosen_march` return what they choose.
    """

    def collect(context: click.Context, option: click.Parameter, value: Any) -> None:
        if value is not None:
            context.meta.setdefault("scenario", {})[option.name] = value

    options = SCENARIO_OPTIONS | _curve_options()
    function = options_of(options, callback=collect, expose_value=False)(function)
    about = "Read the dragon, curve and speed from a .toml file; options win."
    return click.option("--scenario", type=click.Path(), help=about)(function)


def _curve_options() -> dict[str, tuple[Any, str]]:
    """The options --curve and those of the registered curves."""
    from pymunk_dragon.model.curves import Curve
    from pymunk_dragon.model.scenario import named_curves

    default, *others = named_curves()
    about = f"{', '.join([default, *others])}, or a file with points x,y of a path, m.  [{default}]"
    options: dict[str, tuple[Any, str]] = {"curve": (str, about)}
    for name in dict.fromkeys((default, *Curve.kinds)):
        kind = Curve.kinds[name]
        for flag, about in kind.flags.items():
            # Curves that share an option share its help, behind which stand the defaults of each.
            if flag in options:
                about = options[flag][1]
            value = getattr(kind, flag, None)
            if value:
                about += f"  [{value:g} of a {name}]"
            options[flag] = (float, about)
    return options


def option_values() -> dict[str, Any]:
    """The options of the dragon and its curve that were given, by name."""
    return dict(click.get_current_context().meta.get("scenario", {}))


def file_values() -> dict[str, Any]:
    """The values in the scenario file, if one was given."""
    from pymunk_dragon.model.scenario import Scenario

    file = click.get_current_context().meta["file"]
    return {} if file is None else Scenario.read(file)


def chosen_march() -> March:
    """The march of the scenario file and the options."""
    from pymunk_dragon.model.scenario import Scenario

    return Scenario.from_dict(file_values() | option_values()).march()


def load_run(run_file: str) -> Run:
    """The run in a file, which has its own scenario."""
    from pymunk_dragon.model.run import Run

    if option_values() or flags_given("scenario"):
        rest = "leave out the options of the dragon and its curve"
        raise click.UsageError(f"a run file contains its scenario: {rest}")
    return Run.load(run_file)


def number_list(name: str, given: str) -> list[float]:
    """Numbers from `0,60,120` or `0:300:1`, both ends included, or a mixture.

    Errors name the parameter `name`.
    """
    numbers: list[float] = []
    try:
        for part in given.split(","):
            # Decimal numbers are exact: the second after 0.2 in steps of 0.1 is 0.4, and not
            # 0.4 + 6e-17.
            first, *others = map(Decimal, part.split(":"))
            last, step = others or (first, Decimal(1))
            steps = (last - first) / step
            if not (step > 0 and 0 <= steps < _MAX_LIST):
                raise ValueError
            numbers += [float(first + step * i) for i in range(int(steps) + 1)]
    except (ValueError, ArithmeticError):
        forms = "numbers such as 0,60,120 or first:last:step such as 0:300:1"
        bound = f"{forms}, of which there are at most {_MAX_LIST}"
        raise ParameterError(name, given, bound) from None
    return numbers
