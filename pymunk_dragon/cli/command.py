"""The class of the commands: what all have in common."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import click

from pymunk_dragon._language import LANGUAGES
from pymunk_dragon.cli.completion import words
from pymunk_dragon.cli.options import CURVE, DRAGON, PROGRAM, curve_options, named_by_flag, with_hint
from pymunk_dragon.errors import FileFormatError, ParameterError

# Default of --lang.
LANGUAGE_VARIABLE = "PYMUNK_DRAGON_LANG"


class DragonCommand(click.Command):
    """A command with the option --lang, whose errors name flags instead of the parameters that get their values.

    Its help has its own options first, those of a scenario under headings, and `examples`: arguments of the command.

    What comes from a registry is imported when the command is run, not when it is listed: the options that the
    functions in `registered` make, each before the option of its key, and the `names` that stand for {names} in the
    help.
    """

    def __init__(
        self,
        *arguments: Any,
        examples: tuple[str, ...],
        registered: Mapping[str, Callable[[], Iterable[click.Option]]] | None = None,
        names: Callable[[], Iterable[str]] | None = None,
        **settings: Any,
    ) -> None:
        super().__init__(*arguments, **settings)
        self.examples = examples
        self.registered = dict(registered or {})
        self.names = names
        self.params.append(language_option())
        if any(option.name == "turns" for option in self.params):
            self.registered["turns"] = curve_options

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """The options with those from registries, which are the same objects in all calls with a context."""
        key = f"{__name__}.{self.name}"
        if key not in ctx.meta:
            found = super().get_params(ctx).copy()
            for before, make in self.registered.items():
                place = [option.name for option in found].index(before)
                found[place:place] = make()
            ctx.meta[key] = found
        options: list[click.Parameter] = ctx.meta[key]
        return options

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the text of the help, with the names of a registry."""
        if self.names is not None:
            self.help = str(self.help).replace("{names}", ", ".join(self.names()))
        super().format_help_text(ctx, formatter)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, those of a scenario last."""
        groups: dict[str, list[tuple[str, str]]] = {"Options": []}
        for option in self.get_params(ctx):
            record = option.get_help_record(ctx)
            if record is not None and isinstance(option, click.Option):
                groups.setdefault(getattr(option, "heading", "Options"), []).append(record)
        for heading, records in sorted(groups.items(), key=lambda group: group[0] in (DRAGON, CURVE)):
            with formatter.section(heading):
                formatter.write_dl(records)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples."""
        write_examples(formatter, [f"{self.name} {example}" for example in self.examples])

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except (ParameterError, FileFormatError) as error:
            raise with_hint(named_by_flag(error)) from error
        except click.UsageError as error:
            raise with_hint(error) from error


def write_examples(formatter: click.HelpFormatter, examples: Iterable[str]) -> None:
    """Write examples, each a command with its arguments, in a help."""
    with formatter.section("Examples"):
        for example in examples:
            formatter.write(f"{'':{formatter.current_indent}}{PROGRAM} {example}".rstrip() + "\n")


def language_option() -> click.Option:
    """The option --lang, whose value `language_of` finds before Click does."""
    return click.Option(
        ["--lang", "language"],
        default="en",
        envvar=LANGUAGE_VARIABLE,
        expose_value=False,
        callback=_check_language,
        metavar="LANG",
        help=f"Language of results: en or zh.  [{LANGUAGE_VARIABLE} of the environment, or en]",
        shell_complete=words(*LANGUAGES),
    )


def language_of(arguments: Sequence[str]) -> str:
    """The language that is chosen by the last --lang among the arguments, or by the environment."""
    given = re.findall(r"^--lang[=\n](.*)$", "\n".join(arguments), re.MULTILINE)
    last = [os.environ.get(LANGUAGE_VARIABLE), *given][-1]
    return last if last in LANGUAGES else "en"


def _check_language(context: click.Context, parameter: click.Parameter, value: str) -> None:
    """Check that there is such a language."""
    if value not in LANGUAGES:
        given = context.get_parameter_source("language")
        name = LANGUAGE_VARIABLE if given is click.core.ParameterSource.ENVIRONMENT else "--lang"
        raise ParameterError(name, value, "one of " + ", ".join(LANGUAGES))
