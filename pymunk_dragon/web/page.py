"""What player and live page share: the document around their own parts, texts and colours."""

from __future__ import annotations

import tomllib
from dataclasses import asdict
from html import escape

from pymunk_dragon.drawing.palette import COLOURS, Palette
from pymunk_dragon.web.html import asset, policy, substituted

# Scripts of both pages; each uses only those before it.
_SCRIPTS = (
    "common",
    "texts",
    "geometry",
    "pane",
    "view",
    "format",
    "marks",
    "paint",
    "pointer",
    "stage",
)
# Parts of pages' HTML that stand in the place of {{name}}.
_PARTS = ("zoom", "help_tools", "help")
# What `<svg>` in the pages' HTML stands for: an icon of a control, which has a name.
_ICON = '<svg viewBox="0 0 20 20" aria-hidden="true">'
# Counterparts of the films' colours on a dark ground: bright benches with dark outlines have the
# same contrast there.
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


def document(
    body: str,
    style: str,
    script: str,
    connections: str = "",
    **values: str,
) -> tuple[str, str]:
    """HTML of a page around its own parts, and its content security policy.

    Parameters
    ----------
    body : str
        The page's own HTML.
    style : str
        Style of the page's own parts.
    script : str
        The page's own script, which follows the common ones.
    connections : str
        Directives that are added to the policy.
    **values : str
        What stands in the place of {{name}} in the HTML.
    """
    parts = {name: _shared(f"{name}.html").replace("<svg>", _ICON) for name in _PARTS}
    page = _shared("head.html") + body + _shared("tail.html")
    page = page.replace("<svg>", _ICON)

    style = colour_variables() + _shared("page.css") + style
    script = "".join(_shared(f"{name}.js") for name in _SCRIPTS) + script
    rules = policy(style, script) + connections

    values |= {"policy": escape(rules), "style": style, "script": script}
    return substituted(page, **parts, **values), rules


def catalogue(*packages: str) -> dict[str, str]:
    """Chinese texts of these packages' pages, by the English text."""
    found: dict[str, str] = {}
    for package in packages:
        found |= tomllib.loads(asset(package, "zh.toml"))["texts"]
    return found


def colour_variables() -> str:
    """Style with the colours of all pages; those of pictures are `--canvas-...`, light and dark."""
    colours = ""
    dark = asdict(DARK)
    for name, light in asdict(COLOURS).items():
        colours += f" --canvas-{name}: light-dark({light}, {dark[name]});"
    return _shared("colours.css") + f":root {{{colours} }}\n"


def _shared(name: str) -> str:
    """Text of a file that several pages use."""
    return asset(__package__, f"assets/{name}")
