"""Output that several commands share: progress bars, messages and JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from pymunk_dragon._files import written_in_place
from pymunk_dragon._language import text

# Steps of a progress bar.
STEPS = 1000
# Columns of a progress bar: with the longest label, that of a sweep, its line fits in 80.
BAR = 14


@contextmanager
def progress(label: str, now: str = "", begin: float = 0.0) -> Iterator[Callable[..., None]]:
    """Progress bar on stderr if that is a terminal.

    Yields `show(done, total, label)`, of numbers that start with `begin`; the label is by default the text `now` with
    {done} and {total}.
    """
    hidden = not sys.stderr.isatty()
    with click.progressbar(length=STEPS, width=BAR, label=label, file=sys.stderr, hidden=hidden) as bar:

        def show(done: float, total: float, label: str = "") -> None:
            bar.label = label or text(now).format(done=done, total=total)
            bar.update(max(int(STEPS * (done - begin) / (total - begin)) - bar.pos, 0))

        yield show


def note(line: str) -> None:
    """Print a line on stderr if that is a terminal."""
    if sys.stderr.isatty():
        click.echo(line, err=True)


def wrote(path: Path, *facts: str) -> None:
    """Note which file was written, and its size."""
    if path.is_file():  # Not a device or a FIFO, which has no size.
        count = path.stat().st_size
        size = f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.1f} kB"
        note(text("wrote {path}: {facts}").format(path=path, facts=", ".join([*facts, size])))


def write_json(path: Path, result: dict[str, Any]) -> None:
    """Write one JSON object to a file."""
    with written_in_place(path) as draft:
        draft.write_text(json.dumps(result) + "\n", encoding="utf-8")


def print_json(result: dict[str, Any]) -> None:
    """Print one JSON object on stdout."""
    click.echo(json.dumps(result))


def answer(as_json: bool, result: dict[str, Any], shown: object) -> None:
    """Print a result as a JSON object or as text."""
    if as_json:
        print_json(result)
    else:
        click.echo(shown)


def print_file(path: Path) -> None:
    """Print a JSON object with the name and the size of a file that was written."""
    print_json({"output": str(path), "bytes": path.stat().st_size})
