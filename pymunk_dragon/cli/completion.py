"""What a shell completes: words, names that are imported when they are needed, and names of files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import click
from click.shell_completion import CompletionItem

Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def words(*known: str) -> Complete:
    """Complete one of these words."""
    return named(lambda: dict.fromkeys(known, ""))


def named(load: Callable[[], Mapping[str, str]]) -> Complete:
    """Complete one of the names that `load` returns, each with its description."""

    def complete(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
        found = load().items()
        return [CompletionItem(name, help=shows or None) for name, shows in found if name.startswith(incomplete)]

    return complete


def files(*endings: str, words: Iterable[str] = ()) -> Complete:
    """Complete one of these words, or the name of a file with one of these endings.

    Where there is no such file, the shell completes any name, as that of a folder.
    """

    def complete(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
        folder, _, begin = incomplete.rpartition("/")
        try:
            names = sorted(path.name for path in Path(folder or ("/" if "/" in incomplete else ".")).iterdir())
        except OSError:
            names = []
        fitting = [name for name in names if name.startswith(begin) and name.lower().endswith(endings)]
        found = [word for word in words if word.startswith(incomplete)]
        found += [incomplete[: len(incomplete) - len(begin)] + name for name in fitting]
        return [CompletionItem(name) for name in found] or [CompletionItem(incomplete, type="file")]

    return complete
