"""The page of a live session: one HTML document with its style and script."""

from __future__ import annotations

import re
from functools import cache
from html import escape

from pymunk_dragon import player
from pymunk_dragon._html import asset, policy
from pymunk_dragon.player.page import colour_variables

PLACEHOLDER = re.compile(r"\{\{(\w+)\}\}")
# Parts of the script: those of the player, and those of this page; each uses only those before it.
PLAYER_SCRIPTS = ("common", "geometry", "view", "format", "marks", "paint", "pointer")
SCRIPTS = (
    *("frame", "connection", "nearest", "model", "shades", "force_scale", "shapes", "overlays", "legend", "live_paint"),
    *("charts", "parameters", "live_charts", "tools", "recorder", "live_show", "live", "live_controls", "live_main"),
)


@cache
def live_page(title: str) -> tuple[str, str]:
    """The page, and its content security policy."""
    style = colour_variables() + asset(player.__name__, "assets/player.css") + asset(__package__, "assets/live.css")
    script = "".join(asset(player.__name__, f"assets/{name}.js") for name in PLAYER_SCRIPTS)
    script += "".join(asset(__package__, f"assets/{name}.js") for name in SCRIPTS)
    rules = policy(style, script) + "; connect-src 'self'"
    values = {"policy": escape(rules), "title": escape(title), "style": style, "script": script}
    return PLACEHOLDER.sub(lambda match: values[match[1]], asset(__package__, "assets/live.html")), rules
