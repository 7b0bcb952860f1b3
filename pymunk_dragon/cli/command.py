"""The class of the commands: what all have in common."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from typing import Any

import click

from pymunk_dragon._language import LANGUAGES
from pymunk_dragon.cli.completion import words
from pymunk_dragon.cli.options import PROGRAM, SCENARIO_HEADINGS, named_by_flag, with_hint
from pymunk_dragon.errors import FileFormatError, ParameterError

# Default of --lang.
LANGUAGE_VARIABLE = "PYMUNK_DRAGON_LANG"


class DragonCommand(click.Command):
    """A command with the option --lang, whose errors name flags instead of the parameters that get their values.

    Its help has its own options first, those of a scenario under headings, and `examples`: arguments of the command.
    """

    def __init__(self, *arguments: Any, examples: tuple[str, ...], **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.examples = examples
        self.params.append(language_option())

    def heading(self, option: click.Parameter) -> str:
        """Heading of an option in the help."""
        return SCENARIO_HEADINGS.get(str(option.name), "Options")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, those of a scenario last."""
        groups: dict[str, list[tuple[str, str]]] = {"Options": []}
        for option in self.get_params(ctx):
            record = option.get_help_record(ctx)
            if record is not None and isinstance(option, click.Option):
                groups.setdefault(self.heading(option), []).append(record)
        for heading, records in sorted(groups.items(), key=lambda group: group[0] in SCENARIO_HEADINGS.values()):
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
