"""The program of a user's that is published: what it needs, and the first picture of its scene."""

import ast
import runpy
import sys
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from pymunk_dragon._checks import instance, instances
from pymunk_dragon._files import read_text
from pymunk_dragon.errors import FileFormatError, ParameterError
from pymunk_dragon.sessions.live import Live
from pymunk_dragon.sessions.scene import Scene
from pymunk_dragon.sessions.session import Session, described

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
    path = Path(instance("program", path, str | Path, "a path"))
    files = {path.name: path}
    for each in instances("include", include, str | Path, "a sequence of paths"):
        file = Path(each)
        inside = file.is_relative_to(path.parent)
        files[file.relative_to(path.parent).as_posix() if inside else file.name] = file

    own = {name.partition("/")[0].removesuffix(".py") for name in files}
    tree = _parsed(path)
    for file in files.values():
        missing = missing_import(_parsed(file), own) if file.suffix == ".py" else None
        if missing:
            line, name = missing
            reason = f"line {line} imports {name}, which the page does not have"
            raise FileFormatError(file, reason)
    names = {getattr(node, "id", getattr(node, "attr", "")) for node in ast.walk(tree)}
    if "live" not in names:
        raise FileFormatError(path, "has no call of live, which shows a space on a page")

    try:
        contents = {name: file.read_bytes() for name, file in files.items()}
    except OSError as error:
        raise ParameterError("include", error.filename, f"a file ({error.strerror})") from error
    scene = _scene(path)
    title, _, text = (ast.get_docstring(tree) or path.stem).partition("\n")
    title = scene.settings.title or title.rstrip(".")
    text = " ".join(text.split()) or "A space that Pymunk plays in this page."
    return Program(path.name, contents, title, text, scene.picture())


def _parsed(path: Path) -> ast.Module:
    """The syntax tree of a program."""
    source = read_text(path, "program")
    try:
        return ast.parse(source, "program")
    except (SyntaxError, ValueError) as error:
        raise FileFormatError(path, f"no program of Python: {error}") from error


def _imports(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Lines and names of the modules that a program imports; names from modules may be modules."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom) and not getattr(node, "level", 0):
            module = getattr(node, "module", None)
            for each in node.names:
                yield node.lineno, f"{module}.{each.name}" if module else each.name


def missing_import(tree: ast.Module, own: Set[str] = frozenset()) -> tuple[int, str] | None:
    """Line and name of the first import of a module that neither the page has nor `own` names."""
    known = own | _LIBRARIES | (sys.stdlib_module_names - set(_MISSING.split()))
    for line, name in _imports(tree):
        if name.partition(".")[0] not in known or name.startswith(_OF_WINDOWS):
            return line, name
    return None


class _Shown(BaseException):
    """The program has called `live`, and is not run any further."""

    def __init__(self, session: Session) -> None:
        self.session = session


def _scene(path: Path) -> Scene:
    """The scene of a program, which is run until it calls `live`."""

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
        failure = described(error)
        place = failure.get("place", "fails").removeprefix(f"{path.name}, ")
        reason = f"{place}: {failure['text']}"
        raise FileFormatError(path, reason) from error
    else:
        raise FileFormatError(path, "ends without a call of live")
    finally:
        Live.made_by = None
        sys.path[:] = before

    if scene.manual:
        rule = "makes its steps itself (step=None), which a page cannot do: give live a step"
        raise FileFormatError(path, rule)
    return scene
