"""Output of commands: progress, results as text or JSON, files, and what was written."""

import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import text

# Libraries that write formats, by ending: a missing one is reported before the work.
_LIBRARIES: dict[str, Sequence[str]] = {
    ".xlsx": ("xlsxwriter",),
    ".tex": ("jinja2",),
    ".html": ("jinja2", "latex2mathml", "matplotlib"),
    **dict.fromkeys((".png", ".svg", ".pdf"), ("matplotlib",)),
}
# Steps of a progress bar.
_STEPS = 1000


def destination_of(output: str | None, endings: Iterable[str]) -> Path | None:
    """The file of the option -o, or None.

    To be called before the work: it raises an error if the file cannot be written.
    """
    if output is None:
        return None
    path = check_destination(output, endings)
    for needed in _LIBRARIES.get(path.suffix.lower(), ()):
        library(needed)
    return path


@contextmanager
def progress(label: str, begin: float = 0.0) -> Iterator[Callable[[float, float], None]]:
    """Progress bar on stderr if that is a terminal.

    Yields `show(done, total)`, of numbers that start with `begin`.
    """
    hidden = not sys.stderr.isatty()
    with click.progressbar(length=_STEPS, label=label, file=sys.stderr, hidden=hidden) as bar:

        def show(done: float, total: float) -> None:
            if not bar.pos:
                # The time left is estimated from the first step on, not from what comes before it.
                bar.start = bar.last_eta = time.time()
            bar.update(max(int(_STEPS * (done - begin) / (total - begin)) - bar.pos, 0))

        yield show


def print_written(path: Path) -> None:
    """Print on a terminal which file was written."""
    if sys.stderr.isatty() and path.is_file():  # Not a device or a FIFO.
        click.echo(text("wrote {path}", path=path), err=True)


def print_file_result(path: Path) -> None:
    """Print the result of a command that only writes a file: with --json its name and size."""
    print_written(path)
    if wants_json():
        print_result({"output": str(path), "bytes": path.stat().st_size})


def write_result(
    path: Path | None,
    result: Mapping[str, Any],
    write: Callable[[Path], object] | None = None,
) -> None:
    """Write a result to a file, if there is one: as JSON, or in another format by `write`."""
    if path is None:
        return
    if write is None or path.suffix.lower() == ".json":
        write_text(path, json.dumps(result) + "\n")
    else:
        write(path)
    print_written(path)


def print_list(what: str, summaries: Mapping[str, str]) -> None:
    """Print names, each with its summary; with --json an object with the key `what`."""
    wide = max(map(len, summaries))
    lines = [f"{name:<{wide}}  {text(summary)}" for name, summary in summaries.items()]
    print_result({what: summaries}, "\n".join(lines))


def wants_json() -> bool:
    """Whether a JSON object is to be printed."""
    return bool(click.get_current_context().meta["json"])


def print_result(result: dict[str, Any], shown: object = "") -> None:
    """Print a result, with --json as a JSON object."""
    click.echo(json.dumps(result) if wants_json() else shown)
