"""A lesson as it was played: what it printed, and its picture."""

from __future__ import annotations

import io
import tempfile
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from pymunk_dragon.demos.telling.demo import Demo

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
        The file of its picture or film.
    ending : str
        That file's ending: ".png" or ".gif".
    """

    demo: Demo
    printed: str
    picture: bytes
    ending: str


class _Recorder:
    """Keeps a lesson's picture; what it says is known without playing it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.picture = Path()

    def say(self, lesson: str, part: str, english: str) -> None:
        pass

    def show(self, lesson: str, picture: Path, english: str) -> None:
        self.picture = picture

    def end(self, lesson: str) -> None:
        pass


def perform(demo: Demo) -> Performance:
    """Play a lesson and keep what came of it."""
    printed = io.StringIO()
    with tempfile.TemporaryDirectory(prefix="pymunk-dragon-") as folder:
        recorder = _Recorder(Path(folder))
        with redirect_stdout(printed):
            demo.play(recorder)
        return Performance(demo, printed.getvalue(), recorder.picture.read_bytes(), recorder.picture.suffix)
