"""Running the file of a lesson: where its texts and its picture go, and what it printed."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack, redirect_stdout
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from pymunk_dragon._extras import optional_imports
from pymunk_dragon._language import in_language
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.lessons._framework.guess import Guess
from pymunk_dragon.lessons._framework.lesson_file import LessonFile

MEDIA_TYPES = {".gif": "image/gif", ".png": "image/png", ".py": "text/x-python", ".ipynb": "application/x-ipynb+json"}


class Output:
    """Receives the texts and the picture of a lesson while its program runs. The methods of this class do nothing."""

    def folder(self) -> Path:
        """Folder in which the lesson writes its picture; by default the current one."""
        return Path()

    def say(self, lesson: str, part: str, text: str, guesses: Sequence[Guess] = ()) -> None:
        """Take a text of the lesson named `lesson`; `part` is "title", "question", ...

        A prediction has guesses, and an answer has them with their results.
        """

    def show(self, lesson: str, picture: Path) -> None:
        """Take the file of the picture."""


# Output of the lesson that `play` runs in this context; None for a lesson that is run as a program of its own.
current_output: ContextVar[Output | None] = ContextVar("current_output", default=None)


def play(lesson: LessonFile, output: Output) -> None:
    """Run the program of a lesson, with its texts and its picture given to `output`.

    What the program prints and draws is English; `output` has the texts in its own language.

    Raises
    ------
    MissingExtraError
        If a library that the lesson uses is not installed.
    """
    token = current_output.set(output)
    try:
        with optional_imports(), in_language("en"):
            code = compile(lesson.source, str(lesson.path), "exec")
            exec(code, {"__name__": "__main__", "__file__": str(lesson.path)})
    finally:
        current_output.reset(token)


@dataclass(frozen=True)
class Recording:
    """A lesson that was run: what its code printed, and its picture.

    Attributes
    ----------
    lesson : LessonFile
        The lesson.
    printed : str
        What its code printed, without its texts.
    picture : bytes
        Content of the file of its picture or film.
    file : Path
        That file, which `record` removes unless it is given a folder.
    """

    lesson: LessonFile
    printed: str
    picture: bytes
    file: Path


def record(lesson: LessonFile, save: str | Path | None = None) -> Recording:
    """Run a lesson without printing anything, and return what its code printed and its picture.

    Parameters
    ----------
    lesson : LessonFile
        The lesson.
    save : path, optional
        Folder for the picture, made if it does not exist. By default the picture's file is removed.

    Returns
    -------
    Recording
        The printed lines and the picture.

    Raises
    ------
    ParameterError
        If the folder cannot be made or written.
    MissingExtraError
        If a library that the lesson uses is not installed.
    DragonError
        If the lesson shows no picture.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS, record
    >>> recording = record(LESSONS["spiral"])
    >>> recording.printed.splitlines()[0]
    't =   0 s  r = 8.800 m  walking 1.0000 m/s  turning 0.1136 rad/s, a round in 55.3 s'
    """
    printed = io.StringIO()
    with ExitStack() as stack:
        if save is None:
            save = stack.enter_context(tempfile.TemporaryDirectory(prefix="pymunk-dragon-"))
        recorder = _Recorder(make_folder(save))
        with redirect_stdout(printed):
            play(lesson, recorder)
        if recorder.file is None:
            raise DragonError(f"the lesson {lesson.name!r} shows no picture")
        return Recording(lesson, printed.getvalue(), recorder.file.read_bytes(), recorder.file)


class _Recorder(Output):
    """Output that keeps the picture; the texts are known from the lesson's file."""

    def __init__(self, folder: Path) -> None:
        self.file: Path | None = None
        self._folder = folder

    def folder(self) -> Path:
        return self._folder

    def show(self, lesson: str, picture: Path) -> None:
        self.file = picture


def make_folder(path: str | Path) -> Path:
    """The folder `path`, made if it does not exist; a ParameterError if it cannot be made or written."""
    bound = "a folder that can be written"
    if not str(path):
        raise ParameterError("save", path, bound)
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=path).close()
    except OSError as error:
        raise ParameterError("save", str(path), f"{bound} ({error.strerror})") from error
    return Path(path)
