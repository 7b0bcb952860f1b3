"""What player and live page share: the document around their own parts, texts and colours."""

import json
import tomllib
from dataclasses import asdict
from html import escape

from pymunk_dragon.drawing.palette import COLOURS
from pymunk_dragon.web.html import asset, policy, substituted

# Parts of pages' HTML that stand in the place of {{name}}.
_PARTS = ("zoom", "help_tools", "help")
# What `<svg>` in the pages' HTML stands for: an icon of a control, which has a name.
_ICON = '<svg viewBox="0 0 20 20" aria-hidden="true">'


def scripts(*groups: str) -> list[str]:
    """Texts of groups of scripts, in their order.

    A player has the groups "viewer" and "player", a live page "viewer" and "live"; a page of
    lessons has "lab" and "played", the stages of its lessons, and "lessons".
    """
    order = json.loads(_shared("scripts.json"))
    return [_shared(f"{name}.js") for group in groups for name in order[group]]


def document(
    page: str,
    body: str,
    style: str,
    connections: str = "",
    **values: str,
) -> tuple[str, str]:
    """HTML of a viewer around its own parts, and its content security policy.

    Parameters
    ----------
    page : str
        The group of its own scripts: "player" or "live".
    body : str
        The page's own HTML.
    style : str
        Style of the page's own parts.
    connections : str
        Directives that are added to the policy.
    **values : str
        What stands in the place of {{name}} in the HTML.
    """
    parts = {name: _shared(f"{name}.html").replace("<svg>", _ICON) for name in _PARTS}
    html = _shared("head.html") + body + _shared("tail.html")
    html = html.replace("<svg>", _ICON)

    style = colour_variables() + _shared("page.css") + style
    script = "".join(scripts("viewer", page))
    rules = policy(style, script) + connections

    values |= {"policy": escape(rules), "style": style, "script": script}
    return substituted(html, **parts, **values), rules


def catalogue(*packages: str) -> dict[str, str]:
    """Chinese texts of these packages' pages, by the English text."""
    found: dict[str, str] = {}
    for package in packages:
        found |= tomllib.loads(asset(package, "zh.toml"))["texts"]
    return found


def colour_variables() -> str:
    """Style with the colours of all pages; those of pictures are `--canvas-...`, light and dark."""
    colours = ""
    for name, light in asdict(COLOURS).items():
        colours += f" --canvas-{name}: light-dark({light}, var(--dark-{name}));"
    return _shared("colours.css") + f":root {{{colours} }}\n"


def _shared(name: str) -> str:
    """Text of a file that several pages use."""
    return asset(__package__, f"assets/{name}")
