"""The command line.

Every command but `report`, `demo` and `publish` takes the same dragon and curve, as flags or as a
file (`pymunk_dragon.model.scenario`). Lists are `0,60,120` or `0:300:1`, with both ends. `-o FILE`
writes a file, whose ending chooses the format. `--json` prints one JSON object on stdout and
nothing else there; progress and messages go to stderr. `--lang zh`, or `PYMUNK_DRAGON_LANG=zh` in
the environment, chooses Chinese for results, pictures, pages and lessons; help and errors are
English.

| exit code | meaning |
| --- | --- |
| 0 | done |
| 1 | failed while running |
| 2 | bad input: one line names the flag, the value and what is allowed |
| 130, 143, 129 | interrupted by Ctrl-C, SIGTERM or SIGHUP |

The shell completes commands and flags after
`eval "$(_PYMUNK_DRAGON_COMPLETE=bash_source pymunk-dragon)"` in `~/.bashrc`, the same with
`zsh_source` in `~/.zshrc`, or `_PYMUNK_DRAGON_COMPLETE=fish_source pymunk-dragon | source` in
`~/.config/fish/completions/pymunk-dragon.fish`.
"""

import os
import sys
from contextlib import suppress
from importlib import import_module
from io import TextIOWrapper

import click
from click.shell_completion import shell_complete

from pymunk_dragon import __version__, errors
from pymunk_dragon.cli.options import PROGRAM, epilog_of

# The commands, in the order in which one uses them.
COMMANDS = {
    "positions": "Where the handles are and how fast, exactly.",
    "contact": "When benches that are not neighbours first touch, and where.",
    "simulate": "Play the march in Pymunk until the dragon runs into itself.",
    "render": "Film a run, several side by side, or an exact march.",
    "figure": "Draw one of the paper's figures, or one beyond it.",
    "report": "Report on a run, as a document or a table.",
    "study": "Run a study of many marches.",
    "sweep": "Compute a quantity at many values of parameters, in parallel.",
    "demo": "Play a lesson.",
    "live": "Play the dragon in real time, and touch it in a browser.",
    "publish": "Write a folder for the web: lessons and scenes, or your program.",
}
# Environment variable by which a shell requests completions, as Click names it.
_COMPLETE_VARIABLE = "_PYMUNK_DRAGON_COMPLETE"
# Exit codes: those of Click, and that of a shell for a program that Ctrl-C ended.
_DONE = 0
_FAILED = 1
_BAD_INPUT = 2
_INTERRUPTED = 130
# Examples in the help of the program.
_EXAMPLES = (
    "demo spiral",
    "contact",
    "simulate --from 400 -o run.npz",
    "render run.npz",
    "report run.npz",
)
# Errors of the user's input, or of the installation; others of the package are failures.
_INPUT_ERRORS = (
    errors.ParameterError,
    errors.UnreachableError,
    errors.FileFormatError,
    errors.MissingExtraError,
)


def command(name: str) -> click.Command:
    """Import a command."""
    found: click.Command = getattr(import_module(f"{__name__}.{name}"), name)
    return found


class _LazyGroup(click.Group):
    """A group whose commands are imported when they are run.

    Lists of commands need only their names and summaries.
    """

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Import the command that the arguments name."""
        name, known, others = super().resolve_command(ctx, args)
        return name, command(name) if name and known else None, others

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of the commands in the order in which one uses them."""
        return list(self.commands)


@click.group(
    cls=_LazyGroup,
    commands={name: click.Command(name, short_help=summary) for name, summary in COMMANDS.items()},
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=epilog_of(_EXAMPLES),
)
@click.version_option(__version__, "-V", "--version", prog_name=PROGRAM)
def cli() -> None:
    """A bench dragon on its spiral: positions, speeds, and the first contact with itself."""


def status(arguments: list[str] | None = None) -> int:
    """Run the program, print its errors, and return its exit code."""
    _open_streams()
    try:
        return _run(sys.argv[1:] if arguments is None else arguments)
    except click.ClickException as error:
        return _print_error(error.format_message(), _BAD_INPUT)
    except KeyboardInterrupt as error:
        return _print_error("interrupted", _INTERRUPTED, error)
    except errors.DragonError as error:
        code = _BAD_INPUT if isinstance(error, _INPUT_ERRORS) else _FAILED
        return _print_error(str(error), code, error)
    except BrokenPipeError:
        # The reader of stdout has closed it, as `head` does.
        return _drop_output()
    except OSError as error:
        # Nearly always stdout: functions that read and write files raise errors of the package.
        _drop_output()
        return _print_error(f"cannot write the output: {error.strerror or error}", _FAILED)
    except MemoryError:
        return _print_error("not enough memory for a dragon of this size", _FAILED)


def _run(arguments: list[str]) -> int:
    """Run the program and return its exit code; errors are raised."""
    if instruction := os.environ.get(_COMPLETE_VARIABLE):
        return shell_complete(cli, {}, PROGRAM, _COMPLETE_VARIABLE, instruction)
    try:
        # Not `cli()`, which prints an empty line when it is interrupted.
        with cli.make_context(PROGRAM, list(arguments)) as context:
            cli.invoke(context)
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        return _BAD_INPUT
    sys.stdout.flush()
    return _DONE


def _open_streams() -> None:
    """Replace missing standard streams by the null device; stdout escapes what it cannot encode."""
    # stdout is opened for reading, so that writing to it still fails; errors on stderr are ignored.
    for name, mode in (("stdout", "r"), ("stderr", "w")):
        if getattr(sys, name) is None:
            stream = open(os.devnull, mode, encoding="utf-8")  # noqa: SIM115  # Open until the end.
            setattr(sys, name, stream)
    if isinstance(sys.stdout, TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")


def _drop_output() -> int:
    """Discard what stdout could not write: Python would report it again at exit."""
    with suppress(OSError):  # A test may have replaced the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return _FAILED


def _print_error(message: str, code: int, error: BaseException | None = None) -> int:
    """Print a message and the notes of an error in one line, and return the exit code."""
    parts = [message, *getattr(error, "__notes__", ())]
    with suppress(OSError):
        click.echo(f"{PROGRAM}: {errors.one_line('; '.join(parts))}", err=True)
    return code
