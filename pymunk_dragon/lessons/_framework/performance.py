"""A lesson as it was played: what it printed, and its picture."""

from __future__ import annotations

import io
import tempfile
from contextlib import ExitStack, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from pymunk_dragon.errors import DragonError
from pymunk_dragon.lessons._framework.demo import Demo
from pymunk_dragon.lessons._framework.stage import made_folder

__all__ = ["Performance", "perform"]


@dataclass(frozen=True)
class Performance:
    """What came of playing a lesson.

    Attributes
    ----------
    demo : Demo
        The lesson.
    printed : str
        What its code printed.
    picture : bytes
        Its picture or film, as the file's content.
    file : Path
        Where that was written; it may be gone.
    """

    demo: Demo
    printed: str
    picture: bytes
    file: Path


def perform(demo: Demo, save: str | Path | None = None) -> Performance:
    """Play a lesson and keep what came of it, without a word in the terminal.

    Parameters
    ----------
    demo : Demo
        The lesson.
    save : path, optional
        Folder for the picture, made if it does not exist. By default it is not kept.

    Raises
    ------
    ParameterError
        If no such folder can be made.
    MissingExtraError
        If what the lesson draws with is not installed.
    DragonError
        If it shows no picture.
    """
    printed = io.StringIO()
    with ExitStack() as stack:
        if save is None:
            save = stack.enter_context(tempfile.TemporaryDirectory(prefix="pymunk-dragon-"))
        recorder = _Recorder(made_folder(save))
        with redirect_stdout(printed):
            demo.play(recorder)
        if recorder.picture is None:
            raise DragonError(f"the lesson {demo.name!r} shows no picture")
        return Performance(demo, printed.getvalue(), recorder.picture.read_bytes(), recorder.picture)


class _Recorder:
    """Keeps a lesson's picture; what it says is known without playing it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.picture: Path | None = None

    def say(self, lesson: str, part: str, english: str) -> None:
        pass

    def show(self, lesson: str, picture: Path, english: str) -> None:
        self.picture = picture

    def end(self, lesson: str) -> None:
        pass
