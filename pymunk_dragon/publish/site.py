"""A folder for a web server: pages whose engine runs in the browser."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from pymunk_dragon._checks import function, instance
from pymunk_dragon._files import reason
from pymunk_dragon._language import language, text
from pymunk_dragon.errors import OutputError, ParameterError
from pymunk_dragon.lessons import LESSONS
from pymunk_dragon.lessons._framework.page import run_page
from pymunk_dragon.model.march import March
from pymunk_dragon.physics.simulation import simulate
from pymunk_dragon.player import write_player
from pymunk_dragon.publish.program import read_program
from pymunk_dragon.publish.runtime import CDN, PACKAGES, engine_files
from pymunk_dragon.sessions.page import live_page
from pymunk_dragon.sessions.scenes import named_scene
from pymunk_dragon.web.html import asset, data_address, embedded_json, substituted

__all__ = ["publish_program", "publish_site"]

# Pages of the site beside the lessons: titles and addresses.
_PAGES = {"Live scenes": "live.html", "A recorded run": "player.html"}
# Title and text of the page of scenes.
_SCENES = "Scenes that Pymunk plays in this page"
_ABOUT = "Pull, cut and change them; choose one in the list."
# Those of the page of lessons, which are also its heading.
_LESSONS = "The bench dragon in lessons"
_COURSE = "A folk dance of 223 benches, a spiral, and a physics engine: ask, guess, try, compare."
# Text of the page of the recorded run.
_RUN = "A dragon of 223 benches in Pymunk, up to its first contact."
# Addresses that a folder can have.
_ADDRESS = re.compile(r"https?://[^\s?#]+")
# Start of the recorded run, s: some seconds before its first contact.
_RUN_START = 400.0


def publish_site(
    folder: str | Path,
    *,
    runtime: str | Path | None = None,
    address: str | None = None,
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> None:
    """Write a folder with the lessons, all live scenes, and the player of a run.

    Parameters
    ----------
    folder : path
        A new folder, or an empty one. An error leaves it as it was.
    runtime : path, optional
        Folder with a copy of Pyodide, which is put into `folder`; by default pages load Pyodide
        from its CDN.
    address : str, optional
        Where the folder will be, as "https://example.org/dragon/". Without it, pages name neither
        their own address nor the whole one of their pictures, which some sites need that show
        links.
    progress : callable, optional
        Called with the number of lessons that were run, and of all, after each one.

    Raises
    ------
    ParameterError
        If a folder cannot be used, or there is no such address.
    DragonError
        If pip cannot download the wheel of Pymunk, or writing fails.
    MissingExtraError
        If a library that the lessons use is not installed.

    Examples
    --------
    >>> publish_site("site")  # doctest: +SKIP
    """
    function("progress", progress)
    base = _base(address)
    with _new_folder(folder) as draft:
        engine = write_engine(draft, runtime, {})
        site = engine | {"lessons": "index.html"}
        scene = named_scene("dragon").build({})
        _write_page(draft / "live.html", _SCENES, _ABOUT, site, scene.picture())
        write_player(simulate(March(), start=_RUN_START), draft / "player.html")
        lessons = list(LESSONS.values())
        page = run_page(lessons, language(), progress, site=engine, pages=_PAGES)
        (draft / "index.html").write_bytes(page.encode())
        said = {
            "index.html": (text(_LESSONS), text(_COURSE)),
            "live.html": (_SCENES, _ABOUT),
            "player.html": ("A recorded run", _RUN),
        }
        for name, words in said.items():
            _describe(draft / name, *words, "live.png", base)


def publish_program(
    program: str | Path,
    folder: str | Path,
    *,
    include: Sequence[str | Path] = (),
    runtime: str | Path | None = None,
    address: str | None = None,
) -> None:
    """Write a folder with a page on which a program runs that calls `live`.

    Parameters
    ----------
    program : path
        The program, which is run until it calls `live`. The first line of its docstring is the
        title of the page, unless it gives `live` a title.
    folder : path
        A new folder, or an empty one. An error leaves it as it was.
    include : sequence of path
        Files that the program reads or imports.
    runtime : path, optional
        Folder with a copy of Pyodide, which is put into `folder`; by default the page loads Pyodide
        from its CDN.
    address : str, optional
        Where the folder will be, as "https://example.org/dragon/". Without it, pages name neither
        their own address nor the whole one of their pictures, which some sites need that show
        links.

    Raises
    ------
    ParameterError
        If a file or a folder cannot be used, or there is no such address.
    FileFormatError
        If the program is no program, or imports what the page does not have.
    DragonError
        If the program fails or does not call `live`, or pip cannot download the wheel of Pymunk.

    Examples
    --------
    >>> publish_program("cradle.py", "site")  # doctest: +SKIP
    """
    base = _base(address)
    with _new_folder(folder) as draft:
        found = read_program(program, include)
        site = write_engine(draft, runtime, found.files) | {
            "program": found.name,
            "title": found.title,
            "text": found.text,
        }
        page = draft / "index.html"
        _write_page(page, found.title, found.text, site, found.picture)
        _describe(page, found.title, found.text, "index.png", base)


def _base(address: str | None) -> str:
    """The address of a folder, with a slash at its end; empty if it is not known."""
    if address is None:
        return ""
    bound = "an address as https://example.org/dragon/"
    if _ADDRESS.fullmatch(instance("address", address, str, bound)):
        return f"{address.rstrip('/')}/"
    raise ParameterError("address", address, bound)


@contextmanager
def _new_folder(path: str | Path) -> Iterator[Path]:
    """Yield a draft of a folder, whose files are moved into the folder at the end."""
    folder = Path(instance("folder", path, str | Path, "a path"))
    is_new = not folder.exists()
    try:
        folder.mkdir(exist_ok=True)
        draft = TemporaryDirectory(dir=folder)
    except (OSError, ValueError) as error:
        bound = f"a folder that can be written ({reason(error)})"
        raise ParameterError("folder", str(path), bound) from error
    try:
        with draft as name:
            if len([*folder.iterdir()]) > 1:
                raise ParameterError("folder", str(path), "a new folder, or an empty one")
            yield Path(name)
            for each in sorted(Path(name).iterdir()):
                each.rename(folder / each.name)
    except OSError as error:
        raise OutputError(folder, reason(error)) from error
    finally:
        # A new folder that has remained empty.
        if is_new:
            with suppress(OSError):
                folder.rmdir()


def write_engine(
    draft: Path, runtime: str | Path | None, files: Mapping[str, bytes]
) -> dict[str, Any]:
    """Write the worker and all files that it loads; what the page tells it."""
    local = None if runtime is None else Path(instance("offline", runtime, str | Path, "a path"))
    contents = dict(engine_files(local))
    site: dict[str, Any] = {"runtime": "pyodide/"}
    if local is None:
        site = {"runtime": CDN, "packages": PACKAGES}
    site |= {"wheels": [name for name in contents if name.endswith(".whl")], "files": list(files)}

    contents |= {f"files/{name}": content for name, content in files.items()}
    contents["worker.js"] = asset(__package__, "assets/worker.js").encode()
    for name, content in contents.items():
        (draft / name).parent.mkdir(parents=True, exist_ok=True)
        (draft / name).write_bytes(content)
    return site


def _write_page(path: Path, title: str, about: str, site: dict[str, Any], picture: bytes) -> None:
    """Write the page of a live session, and its picture beside it."""
    path.with_suffix(".png").write_bytes(picture)
    site = site | {"picture": data_address(picture, "image/png")}
    rules = "; worker-src 'self'"
    page, _ = live_page(title, language(), about, embedded_json(site), rules)
    path.write_bytes(page.encode())


def _describe(page: Path, title: str, about: str, picture: str, base: str) -> None:
    """Write what a page is into its head, for those who show links to it."""
    head = asset(__package__, "assets/about.html")
    if base:
        head += asset(__package__, "assets/address.html")
    words = {"title": title, "about": about, "image": base + picture, "url": base + page.name}
    escaped = {name: escape(word) for name, word in words.items()}
    head = f"{substituted(head, **escaped)}<title>"
    page.write_bytes(page.read_bytes().replace(b"<title>", head.encode(), 1))
