"""What several commands print and write."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

__all__ = ["print_json", "progress", "write_json"]


@contextmanager
def progress(label: str) -> Iterator[Callable[[float, float, str], None]]:
    """A bar on stderr with the time left, where that is a terminal; gives `show(done, total, label)`."""
    parts = 1000
    with click.progressbar(length=parts, label=label, file=sys.stderr, hidden=not sys.stderr.isatty()) as bar:

        def show(done: float, total: float, now: str) -> None:
            bar.label = now
            step = int(parts * done / total) - bar.pos
            if step > 0:
                bar.update(step)

        yield show


def write_json(path: Path, result: dict[str, Any]) -> None:
    """One JSON object as a file."""
    from pymunk_dragon._files import written_in_place

    with written_in_place(path) as draft:
        draft.write_text(json.dumps(result) + "\n", encoding="utf-8")


def print_json(result: dict[str, Any]) -> None:
    """One JSON object on stdout."""
    click.echo(json.dumps(result))
