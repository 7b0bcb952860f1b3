"""The program of a user's that is published: what it needs, and the first picture of its scene."""

from __future__ import annotations

import ast
import runpy
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from pymunk_dragon._files import read_text
from pymunk_dragon.drawing.debug_draw import still
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.sessions.live import Live
from pymunk_dragon.sessions.scene import Scene
from pymunk_dragon.sessions.session import Session

# Modules of Python that Pyodide 314.0 does not have.
_MISSING = """
    curses dbm ensurepip grp idlelib msvcrt nt pwd readline resource syslog tkinter turtle
    turtledemo venv winreg winsound
"""
# Libraries that the page has.
_LIBRARIES = {"PIL", "numpy", "pymunk", "pymunk_dragon"}
# Modules of Pymunk that need libraries which the page does not have.
_OF_WINDOWS = ("pymunk.pygame_util", "pymunk.pyglet_util", "pymunk.matplotlib_util")


@dataclass(frozen=True)
class Program:
    """A program with its files by their paths on the page, and what its page says and shows."""

    name: str
    files: dict[str, bytes]
    title: str
    text: str
    picture: bytes


def read_program(path: str | Path, include: Sequence[str | Path] = ()) -> Program:
    """The program in a file, which is run until it calls `live`; errors name what it lacks."""
    path = Path(path)
    files = {path.name: path}
    for each in map(Path, include):
        inside = each.is_relative_to(path.parent)
        files[each.relative_to(path.parent).as_posix() if inside else each.name] = each
    contents = {}
    for name, file in files.items():
        try:
            contents[name] = file.read_bytes()
        except OSError as error:
            raise ParameterError("include", str(file), f"a readable file ({error})") from error

    own = {name.partition("/")[0].removesuffix(".py") for name in files}
    tree = _parsed(path)
    for file in files.values():
        if file.suffix == ".py":
            _check_imports(file, own)
    if not _calls_live(tree):
        raise DragonError(f"{path} does not call live, which shows its space on a page")

    title, _, text = (ast.get_docstring(tree) or path.stem).partition("\n")
    return Program(path.name, contents, title, " ".join(text.split()), _picture(path))


def _parsed(path: Path) -> ast.Module:
    """The syntax tree of a program."""
    try:
        return ast.parse(read_text(path, "program"), str(path))
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        raise FileFormatError(path, f"line {line}: {getattr(error, 'msg', error)}") from error


def _calls_live(tree: ast.Module) -> bool:
    """Whether a program has a call of `live`, also by the name of its module."""
    calls = (node.func for node in ast.walk(tree) if isinstance(node, ast.Call))
    return any("live" in (getattr(each, "id", ""), getattr(each, "attr", "")) for each in calls)


def _imports(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Lines and names of the modules that a program imports; names from modules may be modules."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for each in node.names:
                yield node.lineno, each.name
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for each in node.names:
                yield node.lineno, f"{node.module}.{each.name}"


def _check_imports(path: Path, own: set[str]) -> None:
    """Refuse imports of modules that the page will not have."""
    known = own | _LIBRARIES | (sys.stdlib_module_names - set(_MISSING.split()))
    for line, name in _imports(_parsed(path)):
        if name.partition(".")[0] not in known or name.startswith(_OF_WINDOWS):
            reason = f"line {line} imports {name}, which the page does not have"
            raise FileFormatError(path, reason)


class _Shown(BaseException):
    """The program has called `live`, and is not run any further."""

    def __init__(self, session: Session) -> None:
        self.session = session


def _picture(path: Path) -> bytes:
    """Picture of the first state of the scene of a program, which is run until it calls `live`."""

    def end(session: Session, **options: Any) -> NoReturn:
        raise _Shown(session)

    before = sys.path[:]
    Live.made_by = end
    try:
        sys.path.insert(0, str(path.parent))
        runpy.run_path(str(path), run_name="__main__")
    except _Shown as shown:
        scene = shown.session.scene
    except (Exception, SystemExit) as error:
        raise DragonError(f"{path} fails: {type(error).__name__}: {error}") from error
    else:
        raise DragonError(f"{path} does not call live")
    finally:
        Live.made_by = None
        sys.path[:] = before

    if scene.manual:
        rule = "makes its steps itself (step=None), which a page cannot do"
        raise DragonError(f"{path} {rule}: give live a step")
    return picture_of(scene)


def picture_of(scene: Scene) -> bytes:
    """Picture of the present state of a scene, as a PNG."""
    y_down = scene.settings.y_down
    return still(scene.space, scene.field, y_down=y_down, flags=scene.drawn)
