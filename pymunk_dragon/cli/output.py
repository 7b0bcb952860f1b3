"""Output that several commands share: progress bars and JSON."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

# Steps of a progress bar.
STEPS = 1000


@contextmanager
def progress(label: str) -> Iterator[Callable[[float, float, str], None]]:
    """Progress bar on stderr if that is a terminal; yields `show(done, total, label)`."""
    with click.progressbar(length=STEPS, label=label, file=sys.stderr, hidden=not sys.stderr.isatty()) as bar:

        def show(done: float, total: float, text: str) -> None:
            bar.label = text
            step = int(STEPS * done / total) - bar.pos
            if step > 0:
                bar.update(step)

        yield show


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
