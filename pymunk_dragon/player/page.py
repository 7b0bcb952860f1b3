"""The player page: one self-contained HTML file with its style, script and data."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import asdict
from html import escape
from pathlib import Path

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._html import asset, policy
from pymunk_dragon.drawing import Palette
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run
from pymunk_dragon.player.data import player_data
from pymunk_dragon.reports.document import headline, provenance, subtitle
from pymunk_dragon.reports.summary import Summary, summarize

PLAYER_ENDINGS = (".html",)
# Parts of the script; each uses only those before it.
SCRIPTS = (
    *("common", "decode", "motion", "geometry", "view", "format", "grid", "marks", "paint", "picture"),
    *("timeline", "link", "table", "player", "pointer", "controls", "main"),
)
# Steps of `write_player`: the page, and the file.
STEPS = 2
PLACEHOLDER = re.compile(r"\{\{(\w+)\}\}")
# The films' colours.
LIGHT = Palette()
# Their counterparts on a dark ground: bright benches with dark outlines have the same contrast there.
DARK = Palette(
    background="#171b22",
    curve="#4b5361",
    head="#f5b02e",
    body="#7ea9cf",
    tail="#3dbfae",
    contact="#ff6b7d",
    ink="#0e1217",
    motion="#a6e69a",
    force="#e3d0ff",
    grid="#cfd6e2",
)


def write_player(
    run: Run, path: str | Path, *, title: str | None = None, progress: Callable[[int, int], None] | None = None
) -> None:
    """Write a page that plays a run: one HTML file that needs no network.

    Parameters
    ----------
    run : Run
        The run to show. A run of the exact model has no contacts of its own; the exact first contact is added.
    path : path
        File to write, ending in .html. An interruption leaves the old file or none.
    title : str, optional
        Heading of the page; by default the result of the run.
    progress : callable, optional
        Called after each step with the number of completed steps and the total number of steps.

    Raises
    ------
    ParameterError
        If the file cannot be created, `run` is not a Run, or the title is not a string.
    OutputError
        If writing fails.

    Examples
    --------
    >>> write_player(Run.load("run.npz"), "run.html")  # doctest: +SKIP
    """
    destination = check_destination(path, PLAYER_ENDINGS)
    notify = progress or (lambda done, total: None)
    page = player_page(run, title=title)
    notify(1, STEPS)
    with written_in_place(destination) as draft:
        # Bytes, since text mode would convert line ends, and the hashes of script and style would no longer match.
        draft.write_bytes(page.encode("utf-8"))
    notify(STEPS, STEPS)


def player_page(run: Run, *, title: str | None = None) -> str:
    """Page that `write_player` writes, as a string, for example for a frame in a notebook.

    Parameters
    ----------
    run : Run
        The run to show.
    title : str, optional
        Heading of the page; by default the result of the run.

    Returns
    -------
    str
        HTML.

    Raises
    ------
    ParameterError
        If `run` is not a Run, or the title is not a string.

    Notes
    -----
    The page's `dragon` is a promise of an object that controls the player. A page that holds it in a frame without a
    sandbox may call `frame.contentWindow.dragon.then((player) => player.seek(409.8))`. A link has the same effect:
    `#t=409.8&follow=head`.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> player_page(Run.exact(March(), [0, 1]), title="Start")[:15]
    '<!doctype html>'
    """
    if not (title is None or isinstance(title, str)):
        raise ParameterError("title", title, "a text")
    summary = summarize(run)
    payload, packed = player_data(summary)
    # A file cannot hold halves of surrogate pairs.
    heading = (title or headline(summary)).encode("utf-8", "replace").decode("utf-8")
    style = colour_variables() + asset(__package__, "assets/player.css")
    script = "".join(asset(__package__, f"assets/{name}.js") for name in SCRIPTS)
    # "<" is escaped, since an HTML parser would take "</script>" or "<!--" for markup.
    payload_json = json.dumps(payload, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    values = {
        "policy": policy(style, script),
        "title": escape(heading),
        "subtitle": escape(subtitle(summary)),
        "provenance": _provenance(summary),
        "last_bench": str(run.march.dragon.benches - 1),
        "style": style,
        "script": script,
        "payload": payload_json,
        **packed,
    }
    # All at once, so that no {{name}} within a value is replaced.
    return PLACEHOLDER.sub(lambda match: values[match[1]], asset(__package__, "assets/player.html"))


def colour_variables() -> str:
    """Style that defines each colour as `--canvas-...`, by the scheme that the reader prefers."""
    light, dark = (
        "".join(f" --canvas-{name}: {colour};" for name, colour in asdict(palette).items()) for palette in (LIGHT, DARK)
    )
    return f":root {{{light} }}\n@media (prefers-color-scheme: dark) {{ :root {{{dark} }} }}\n"


def _provenance(summary: Summary) -> str:
    """Provenance of the run as HTML, as in reports."""
    parts = []
    for heading, facts in provenance(summary).facts.items():
        rows = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in facts)
        parts.append(f"<div><h3>{escape(heading)}</h3><dl>{rows}</dl></div>")
    return "".join(parts)
