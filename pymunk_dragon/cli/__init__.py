"""The command line: one module for each command.

Every command but `report`, which reads a run, and `demo` takes the same dragon and curve, as flags or as a file
(`pymunk_dragon.model.scenario`). Lists are `0,60,120` or `0:300:1`, with both ends. `-o FILE` writes a file, whose
ending chooses the format. `--json` prints one JSON object on stdout and nothing else there; progress and messages go
to stderr. `--lang zh`, or `PYMUNK_DRAGON_LANG=zh` in the environment, chooses Chinese for results, pictures, pages and
lessons; help and errors are English.

| exit code | meaning |
| --- | --- |
| 0 | done |
| 1 | failed while running |
| 2 | bad input: one line names the flag, the value and what is allowed |
| 130, 143, 129 | interrupted by Ctrl-C, SIGTERM or SIGHUP |

## Completion in the shell

The shell completes commands and flags after one of these lines, for bash, zsh or fish. Put it into the file that your
shell reads at its start (`~/.bashrc`, `~/.zshrc`, `~/.config/fish/completions/pymunk-dragon.fish`):

```sh
eval "$(_PYMUNK_DRAGON_COMPLETE=bash_source pymunk-dragon)"
eval "$(_PYMUNK_DRAGON_COMPLETE=zsh_source pymunk-dragon)"
_PYMUNK_DRAGON_COMPLETE=fish_source pymunk-dragon | source
```

## How it works

A command is imported when it is named, and imports NumPy, Pymunk and the like in its function. So every command loads
only what it uses, and `pymunk-dragon --help` none of these libraries.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cache
from importlib import import_module
from io import TextIOWrapper

import click

from pymunk_dragon import __version__
from pymunk_dragon._language import in_language
from pymunk_dragon.cli.command import language_of, language_option, write_examples
from pymunk_dragon.cli.hints import option_hint
from pymunk_dragon.cli.options import PROGRAM
from pymunk_dragon.errors import (
    DragonError,
    FileFormatError,
    MissingExtraError,
    ParameterError,
    UnreachableError,
    one_line,
)

# The commands. Each is a function in the module of its name.
COMMANDS = ("positions", "contact", "simulate", "render", "figure", "report", "study", "sweep", "demo", "live")
# Environment variable with which a shell demands completions, as Click names it.
COMPLETE_VARIABLE = "_PYMUNK_DRAGON_COMPLETE"
# Commands for the start, in the help of the program.
EXAMPLES = ("demo spiral", "contact", "simulate --from 400 -o run.npz", "render run.npz", "report run.npz")
# Exit codes.
DONE = 0
FAILED = 1
BAD_INPUT = 2
INTERRUPTED = 130


def main(arguments: list[str] | None = None) -> None:
    """Run the program and exit: 0 done, 1 failed while running, 2 bad input, 130 interrupted."""
    sys.exit(status(arguments))


def status(arguments: list[str] | None = None) -> int:
    """Run the program and return its exit code."""
    _open_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    with in_language(language_of(given)):
        return _status(given)


def _status(arguments: list[str]) -> int:
    """Run the program in the present language and return its exit code."""
    try:
        if COMPLETE_VARIABLE in os.environ:
            from click.shell_completion import shell_complete

            return shell_complete(cli, {}, PROGRAM, COMPLETE_VARIABLE, os.environ[COMPLETE_VARIABLE])
        # Not `cli.main`, which prints an empty line when it is interrupted.
        with cli.make_context(PROGRAM, arguments) as context:
            cli.invoke(context)
        sys.stdout.flush()
        return DONE
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        with suppress(OSError):
            click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.NoSuchOption as error:
        return _complain(option_hint(error), BAD_INPUT)
    except click.ClickException as error:
        return _complain(error.format_message(), BAD_INPUT)
    except (ParameterError, UnreachableError, FileFormatError, MissingExtraError) as error:
        return _complain(str(error), BAD_INPUT)
    except DragonError as error:
        return _complain(str(error), FAILED)
    except KeyboardInterrupt as end:
        # With what is left to be resumed, if there is something.
        return _complain(": ".join(("interrupted", *map(str, end.args))), INTERRUPTED)
    except BrokenPipeError:
        # The reader of stdout has closed it, as `head` does.
        _drop_output()
        return FAILED
    except OSError as error:
        # Nearly always stdout: functions that read and write files raise errors of the package.
        _drop_output()
        what = f"{error.filename}: " if error.filename else ""
        return _complain(f"cannot read or write: {what}{error.strerror or error}", FAILED)
    except MemoryError:
        return _complain("not enough memory for a dragon of this size", FAILED)


def _open_streams() -> None:
    """Replace missing standard streams by the null device, and have stdout escape what it cannot encode."""
    for name, mode in (("stdout", "r"), ("stderr", "w")):
        if getattr(sys, name) is None:
            # stdout is opened for reading, so that writing to it still fails; errors on stderr are ignored.
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115  # Open until the end.
    if isinstance(sys.stdout, TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Discard what stdout could not write, or Python would report it again when it flushes at exit."""
    with suppress(OSError):  # A test may have replaced the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _complain(message: str, code: int) -> int:
    """Print an error message in one line, and return the exit code."""
    with suppress(OSError):
        click.echo(f"{PROGRAM}: {one_line(message)}", err=True)
    return code


@cache
def _command(name: str) -> click.Command:
    """Import a command, a module of this package; importing all of them would take longer than most commands."""
    command: click.Command = getattr(import_module(f"{__name__}.{name}"), name)
    return command


class _Commands(Mapping[str, click.Command]):
    """The commands by their names, each of which is imported when it is looked up."""

    def __getitem__(self, name: str) -> click.Command:
        if name not in COMMANDS:
            raise KeyError(name)
        return _command(name)

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)


class _Group(click.Group):
    """The program: a name that no command has gets the most similar one as a hint."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of the commands in the order in which one uses them."""
        return list(COMMANDS)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples."""
        write_examples(formatter, EXAMPLES)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not (args[0].startswith("-") or ctx.resilient_parsing):
            from difflib import get_close_matches

            similar = get_close_matches(args[0], COMMANDS, n=1)
            hint = f"did you mean {similar[0]}?" if similar else f"the commands are {', '.join(COMMANDS)}"
            ctx.fail(f"there is no command {args[0]!r}: {hint}")
        return super().resolve_command(ctx, args)


@click.group(cls=_Group, commands=_Commands(), context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", prog_name=PROGRAM)
def cli() -> None:
    """A bench dragon on its spiral: positions, speeds, and the first contact with itself."""


cli.params.append(language_option())
