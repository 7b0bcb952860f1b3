"""Output that several commands share: progress bars and JSON."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import click

# Steps of a progress bar.
STEPS = 1000


@contextmanager
def progress(label: str) -> Iterator[Callable[[float, float, str], None]]:
    """Progress bar on stderr if that is a terminal; yields `show(done, total, label)`.

    The bar begins with the first call: preparations would be taken for a slow first step.
    """
    with ExitStack() as stack:
        bars: list[Any] = []

        def show(done: float, total: float, text: str) -> None:
            if not bars:
                bar = click.progressbar(length=STEPS, label=label, file=sys.stderr, hidden=not sys.stderr.isatty())
                bars.append(stack.enter_context(bar))
            [bar] = bars
            bar.label = text
            step = int(STEPS * done / total) - bar.pos
            if step > 0:
                bar.update(step)

        yield show


def note(text: str) -> None:
    """Print a line on stderr if that is a terminal."""
    if sys.stderr.isatty():
        click.echo(text, err=True)


def wrote(path: Path, *facts: str) -> None:
    """Note which file was written, and its size."""
    size = path.stat().st_size
    unit, divisor = ("MB", 1e6) if size >= 1e6 else ("kB", 1e3)
    note(f"wrote {path}: {', '.join([*facts, f'{size / divisor:.2g} {unit}'])}")


def write_json(path: Path, result: dict[str, Any]) -> None:
    """Write one JSON object to a file."""
    import json

    from pymunk_dragon._files import written_in_place

    with written_in_place(path) as draft:
        draft.write_text(json.dumps(result) + "\n", encoding="utf-8")


def print_json(result: dict[str, Any]) -> None:
    """Print one JSON object on stdout."""
    import json

    click.echo(json.dumps(result))
