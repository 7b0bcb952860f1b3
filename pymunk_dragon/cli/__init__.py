"""Words on the command line, exit codes, and nothing else.

Everything heavy is imported inside the command that needs it: `pymunk-dragon --help` shall answer at once.
"""

from __future__ import annotations

import os
import sys

import click

from pymunk_dragon.cli.contact import contact
from pymunk_dragon.cli.demo import demo
from pymunk_dragon.cli.figure import figure
from pymunk_dragon.cli.options import PROGRAM
from pymunk_dragon.cli.positions import positions
from pymunk_dragon.cli.render import render
from pymunk_dragon.cli.report import report
from pymunk_dragon.cli.simulate import simulate
from pymunk_dragon.cli.study import study
from pymunk_dragon.errors import DragonError, FileFormatError, MissingExtraError, ParameterError, UnreachableError

__all__ = ["cli", "main"]

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(arguments: list[str] | None = None) -> None:
    """Run the program and exit: 0 done, 1 failed while running, 2 bad input, 130 interrupted."""
    sys.exit(_status(arguments))


def _status(arguments: list[str] | None) -> int:
    try:
        cli.main(arguments, prog_name=PROGRAM, standalone_mode=False)
        sys.stdout.flush()
        return DONE
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as error:
        return _complain(error.format_message(), BAD_INPUT)
    except (ParameterError, UnreachableError, FileFormatError, MissingExtraError) as error:
        return _complain(str(error), BAD_INPUT)
    except DragonError as error:
        return _complain(str(error), FAILED)
    except (KeyboardInterrupt, click.Abort):
        return _complain("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # Whoever read our output has seen enough. Python would complain once more when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except MemoryError:
        return _complain("not enough memory for a dragon of this size", FAILED)


def _complain(message: str, status: int) -> int:
    click.echo(f"{PROGRAM}: " + " ".join(message.split()), err=True)
    return status


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="pymunk-dragon", prog_name=PROGRAM)
def cli() -> None:
    """A bench dragon on its spiral: where it is, how fast, and when it runs into itself."""


for command in (positions, contact, simulate, render, figure, report, study, demo):
    cli.add_command(command)
