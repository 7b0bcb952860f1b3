"""Where a lesson is told."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Protocol

from pymunk_dragon.errors import ParameterError

__all__ = ["Stage", "made_folder", "on_stage", "stage"]


class Stage(Protocol):
    """Where a lesson is told: a terminal, a page, a notebook."""

    @property
    def folder(self) -> Path:
        """Where the lesson's picture is written."""
        ...

    def say(self, lesson: str, part: str, english: str) -> None:
        """Tell a part of a lesson, as its question."""
        ...

    def show(self, lesson: str, picture: Path, english: str) -> None:
        """Show a picture or film, and say what it shows."""
        ...

    def end(self, lesson: str) -> None:
        """Be told that the lesson is over."""
        ...


_STAGE: ContextVar[Stage | None] = ContextVar("stage", default=None)


def stage() -> Stage | None:
    """Where the lessons that are played now are told; None where one is run by itself."""
    return _STAGE.get()


@contextmanager
def on_stage(chosen: Stage) -> Iterator[None]:
    """Have the lessons played in here told on `chosen`."""
    token = _STAGE.set(chosen)
    try:
        yield
    finally:
        _STAGE.reset(token)


def made_folder(path: str | Path) -> Path:
    """The folder for a lesson's picture, made if it does not exist.

    Raises
    ------
    ParameterError
        If it cannot be made, or written.
    """
    bound = "a folder that can be written"
    if not str(path):
        raise ParameterError("save", path, bound)
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise ParameterError("save", str(folder), f"{bound} ({error.strerror})") from error
    return folder
