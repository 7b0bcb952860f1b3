"""The class of the commands: what all have in common."""

from __future__ import annotations

from typing import Any

import click

from pymunk_dragon._language import LANGUAGES, in_language
from pymunk_dragon.cli.options import named_by_flag
from pymunk_dragon.errors import FileFormatError, ParameterError

# Default of --lang.
LANGUAGE_VARIABLE = "PYMUNK_DRAGON_LANG"


class DragonCommand(click.Command):
    """A command with the option --lang, whose errors name flags instead of the parameters that get their values."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.params.append(
            click.Option(
                ["--lang", "language"],
                default="en",
                envvar=LANGUAGE_VARIABLE,
                expose_value=False,
                callback=_keep_language,
                metavar="LANG",
                help=f"Language: en or zh.  [{LANGUAGE_VARIABLE} of the environment, or en]",
            )
        )

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command in its language."""
        try:
            with in_language(ctx.meta["language"]):
                return super().invoke(ctx)
        except (ParameterError, FileFormatError) as error:
            raise named_by_flag(error) from error


def _keep_language(context: click.Context, parameter: click.Parameter, value: str) -> None:
    """Keep the language for `invoke`, if there is such a language."""
    if value not in LANGUAGES:
        given = context.get_parameter_source("language")
        name = LANGUAGE_VARIABLE if given is click.core.ParameterSource.ENVIRONMENT else "--lang"
        raise ParameterError(name, value, "one of " + ", ".join(LANGUAGES))
    context.meta["language"] = value
