"""The page: one HTML file with its style, its script and its run inside, which loads nothing else."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from html import escape
from pathlib import Path
from typing import Any

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._html import asset, policy
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run
from pymunk_dragon.player.colours import variables
from pymunk_dragon.player.contents import player_data
from pymunk_dragon.reports.exact import exact_first_contact, with_exact_contact
from pymunk_dragon.reports.sections import headline, sections, subtitle
from pymunk_dragon.reports.summary import summarize

__all__ = ["PLAYER_ENDINGS", "player_page", "write_player"]

Progress = Callable[[int, int], None]

PLAYER_ENDINGS = (".html",)
# The script's parts, from those that the others build on to the one that starts it all.
SCRIPTS = (
    *("decode", "motion", "geometry", "view", "words", "grid", "marks", "paint"),
    *("timeline", "link", "table", "player", "pointer", "controls", "main"),
)
# Steps of `write_player`: the page, and the file.
STEPS = 2
PLACEHOLDER = re.compile(r"\{\{(\w+)\}\}")


def write_player(run: Run, path: str | Path, *, title: str | None = None, progress: Progress | None = None) -> None:
    """Write a page that plays a run: one HTML file that needs no network.

    Parameters
    ----------
    run : Run
        The run to show. A run of the exact model has no contacts of its own; it gets the exact first contact.
    path : path
        File to write, ending in .html. An interrupted one leaves the old file or none.
    title : str, optional
        Heading of the page; by default what happened in the run.
    progress : callable, optional
        Called with the number of steps done, and of all steps, after each step.

    Raises
    ------
    ParameterError
        If the file cannot be made, or the title is no text.
    OutputError
        If writing fails.

    Examples
    --------
    >>> write_player(Run.load("run.npz"), "run.html")  # doctest: +SKIP
    """
    destination = check_destination(path, PLAYER_ENDINGS)
    report_progress = progress or (lambda done, total: None)
    page = player_page(run, title=title)
    report_progress(1, STEPS)
    with written_in_place(destination) as draft:
        # As bytes: a text file would get the line ends of the machine, and the hashes would not fit any more.
        draft.write_bytes(page.encode("utf-8"))
    report_progress(STEPS, STEPS)


def player_page(run: Run, *, title: str | None = None) -> str:
    """The page that `write_player` writes, as a text, for example to be put into a frame of a notebook.

    Raises
    ------
    ParameterError
        If the title is no text.

    Notes
    -----
    The page's `dragon` is a promise of what steers it, so that a lesson with the page in a frame that is not sandboxed
    may say `frame.contentWindow.dragon.then((player) => player.seek(409.8))`. A link does it too:
    `#t=409.8&follow=head`.
    """
    if not (title is None or isinstance(title, str)):
        raise ParameterError("title", title, "a text")
    impact = exact_first_contact(run)
    run = with_exact_contact(run, impact)
    found = summarize(run, impact)
    data = player_data(run, impact)
    # Halves of surrogate pairs are no text that a file could hold.
    heading = (title or headline(found)).encode("utf-8", "replace").decode("utf-8")
    style = variables() + asset(__package__, "assets/player.css")
    script = "".join(asset(__package__, f"assets/{name}.js") for name in SCRIPTS)
    return _filled(
        asset(__package__, "assets/player.html"),
        {
            "policy": policy(style, script),
            "title": escape(heading),
            "subtitle": escape(subtitle(found)),
            "origin": _origin(found),
            "last_bench": str(run.march.dragon.benches - 1),
            "style": style,
            "script": script,
            "payload": _json(data.payload),
            "handles": data.handles.text,
            "velocities": data.velocities.text if data.velocities else "",
            "curve": data.curve.text,
        },
    )


def _filled(template: str, values: Mapping[str, str]) -> str:
    """`template` with every {{name}} replaced at once, so that nothing within a value is taken for a name."""
    return PLACEHOLDER.sub(lambda match: values[match[1]], template)


def _json(value: Any) -> str:
    """JSON that no HTML parser sees an end of the script in."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _origin(contents: Mapping[str, Any]) -> str:
    """Provenance of the run, as in reports."""
    [origin] = (section for section in sections(contents) if section.key == "origin")
    parts = []
    for heading, facts in origin.facts.items():
        rows = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in facts)
        parts.append(f"<div><h3>{escape(heading)}</h3><dl>{rows}</dl></div>")
    return "".join(parts)
