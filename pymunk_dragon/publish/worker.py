"""The session of a published page, which Pyodide runs in a worker of the page."""

import builtins
import io
import os
import runpy
import sys
from collections.abc import Callable, Sequence
from contextlib import chdir, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

from pymunk_dragon.errors import DragonError
from pymunk_dragon.sessions.client import PostedClient
from pymunk_dragon.sessions.live import Live
from pymunk_dragon.sessions.scenes import SCENES, add, named_scene
from pymunk_dragon.sessions.session import Session, described

_Post = Callable[[dict[str, Any], bytes | None], object]


class _Page(PostedClient):
    """The page, to which the worker posts."""

    def __init__(self, session: Session, post: _Post) -> None:
        super().__init__(session)
        self._post = post

    def post(self, content: dict[str, Any], buffers: Sequence[bytes] = ()) -> None:
        """Post an object, and bytes beside it."""
        self._post(content, *buffers)


class _Handle(Live):
    """The handle of a program's session, which the page shows and ends."""

    def __init__(self, session: Session, **options: Any) -> None:
        self._session = session
        session.start()

    @property
    def address(self) -> str:
        """What a program prints as the address."""
        return "this page"

    watch_address = address

    def stop(self) -> None:
        """Do nothing: the session goes on when the program has ended."""


def begin(post: _Post, program: str, scene: str, texts: Sequence[str] = ()) -> PostedClient | None:
    """Begin the session of a program or of a named scene; post the error if that fails.

    `texts` are written to the file of the program before.
    """
    try:
        if texts:
            Path(program).write_text("\n".join(texts), "utf-8")
        session = _played(program) if program else _scene(scene or "dragon")
    except Exception as error:
        post({"failure": described(error)}, None)
        return None
    return _Page(session, post)


def _scene(name: str) -> Session:
    """The session of a scene of the package or of a lesson."""
    if name not in SCENES:
        from pymunk_dragon.lessons import LESSONS

        # The programs of lessons import it for their pictures, which the page does not draw.
        for library in ("matplotlib", "matplotlib.pyplot"):
            sys.modules.setdefault(library, ModuleType(library))
        for lesson in LESSONS.values():
            if lesson.builds_scene:
                add(**lesson.scene())
    session = Session(named_scene(name))
    session.start()
    return session


def _end(prompt: object = "") -> str:
    """End the program."""
    raise SystemExit


def _played(program: str) -> Session:
    """The session of the program in a file, which is run."""
    found: list[Session] = []

    def show(session: Session, **options: Any) -> Live:
        found.append(session)
        return _Handle(session)

    Live.made_by = show
    # The program need not wait: the session goes on.
    builtins.input = _end
    sys.path.insert(0, str(Path(program).parent))
    with suppress(SystemExit):
        runpy.run_path(program, run_name="__main__")
    if not found:
        raise DragonError("the program has ended without a call of live")
    return found[0]


class _Printed(io.TextIOBase):
    """What a program prints, which is posted at once."""

    def __init__(self, post: _Post) -> None:
        self._post = post

    def write(self, text: str) -> int:
        """Post a text."""
        self._post({"printed": text}, None)
        return len(text)


def run(post: _Post, texts: Sequence[str]) -> None:
    """Run the texts of a program one after the other, and post what they print and draw.

    The program has a folder of its own, whose pictures are posted at the end; an error has the line
    in its own text.
    """
    printed = _Printed(post)
    names: dict[str, Any] = {"__name__": "__main__"}
    with TemporaryDirectory() as folder, chdir(folder):
        try:
            with redirect_stdout(printed), redirect_stderr(printed), suppress(SystemExit):
                for number, text in enumerate(texts, 1):
                    path = Path(f"program_{number}.py")
                    path.write_text(text, "utf-8")
                    exec(compile(text, path, "exec"), names)
        except Exception as error:
            post({"failure": described(error)}, None)
        for name in sorted(os.listdir()):
            if name.endswith((".gif", ".png")):
                post({"picture": name}, Path(name).read_bytes())
    post({"ended": True}, None)
