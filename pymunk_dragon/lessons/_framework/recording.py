"""Running the program of a lesson: what it printed, and its picture."""

import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pymunk_dragon._checks import instance
from pymunk_dragon._extras import FEATURES, is_installed
from pymunk_dragon.errors import DragonError, MissingExtraError, OutputError, ParameterError
from pymunk_dragon.lessons._framework.lesson import Lesson
from pymunk_dragon.model.run import Run

MISSING = re.compile(r"ModuleNotFoundError: No module named '(\w+)")


@dataclass(frozen=True)
class Recording:
    """A lesson that was run, its output, and its picture with the ending, ".png" or ".gif".

    `runs` are those that it has saved, and `data` is what it has written as JSON, by its name.
    `chinese` is the picture with Chinese labels, if there is one.
    """

    lesson: Lesson
    printed: str
    picture: bytes
    ending: str
    runs: tuple[Run, ...] = ()
    data: Any = None
    chinese: bytes = b""


def run(lesson: Lesson, folder: Path) -> Iterator[str]:
    """Lines that the program of a lesson prints; it writes its picture in `folder`."""
    # Not by its folder on the path: a module of Python could have the name of a lesson.
    runner = "pymunk_dragon.lessons._framework.program"
    command = [sys.executable, "-P", "-u", "-m", runner, str(lesson.path)]
    environment = os.environ | {"MPLBACKEND": "agg", "PYTHONIOENCODING": "utf-8"}
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        encoding="utf-8",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        try:
            yield from process.stdout
            _, errors = process.communicate()
        finally:
            process.kill()

    if process.returncode:
        missing = MISSING.search(errors)
        if missing and missing[1] in FEATURES and not is_installed(missing[1]):
            raise MissingExtraError("a lesson", "demos")
        if unwritten := re.search(r"OSError: \[Errno \d+\] (.+)", errors):
            raise OutputError("the picture of the lesson", unwritten[1])
        reason = errors.strip().splitlines()[-1]
        raise DragonError(f"the program of the lesson {lesson.name!r} failed: {reason}")


def picture(lesson: Lesson, folder: Path) -> Path:
    """The picture that the program of a lesson wrote in a folder, by the lesson's name."""
    for ending in (".gif", ".png"):
        if (file := folder / f"{lesson.name}{ending}").exists():
            return file
    raise DragonError(f"the lesson {lesson.name!r} writes no picture {lesson.name}.gif or .png")


def record(lesson: Lesson) -> Recording:
    """What the program of a lesson prints, and its picture; the lesson is run.

    Raises
    ------
    MissingExtraError
        If a library that the lesson uses is not installed.
    DragonError
        If its program fails or writes no picture.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS, record
    >>> record(LESSONS["spiral"]).printed.splitlines()[0]
    't =   0 s  r = 8.800 m  walking 1.000 m/s  turning 0.114 rad/s, a round in 55.3 s'
    """
    instance("lesson", lesson, Lesson, "a Lesson")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        printed = "".join(run(lesson, folder))
        file = picture(lesson, folder)
        runs = tuple(map(Run.load, folder.glob("*.npz")))
        written = folder / f"{lesson.name}.json"
        data = json.loads(written.read_bytes()) if written.exists() else None
        translated = folder / f"{lesson.name}.zh.png"
        chinese = translated.read_bytes() if translated.exists() else b""
        return Recording(lesson, printed, file.read_bytes(), file.suffix, runs, data, chinese)


def make_folder(path: str | Path) -> Path:
    """The folder `path`, made if it does not exist; a ParameterError if it cannot be used."""
    instance("save", path, str | Path, "a path")
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=path).close()
    except OSError as error:
        raise ParameterError(
            "save", str(path), f"a folder that can be written ({error.strerror})"
        ) from error
    return Path(path)
