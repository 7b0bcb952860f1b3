"""The page of a live session: one HTML document with its style and script."""

from __future__ import annotations

from functools import cache
from html import escape

from pymunk_dragon import player
from pymunk_dragon._html import asset, embedded_json, policy, substituted
from pymunk_dragon.player.page import catalogue, colour_variables, parts

# Parts of the script: those of the player, and those of this page; each uses only those before it.
_PLAYER_SCRIPTS = ("common", "texts", "geometry", "view", "format", "marks", "paint", "ghost", "pointer", "stage")
SCRIPTS = (
    *("frame", "connection", "nearest", "model", "shades", "force_scale", "shapes", "overlays", "legend", "live_paint"),
    *("charts", "parameters", "live_charts", "tools", "recorder", "live_show", "live", "live_controls", "live_main"),
)


@cache
def live_page(title: str, language: str) -> tuple[str, str]:
    """The page, which opens in a language, and its content security policy."""
    style = colour_variables() + asset(player.__name__, "assets/player.css") + asset(__package__, "assets/live.css")
    script = "".join(asset(player.__name__, f"assets/{name}.js") for name in _PLAYER_SCRIPTS)
    script += "".join(asset(__package__, f"assets/{name}.js") for name in SCRIPTS)
    rules = policy(style, script) + "; connect-src 'self'"
    head, tail = (asset(player.__name__, f"assets/{name}.html") for name in ("head", "tail"))
    page = substituted(
        head + asset(__package__, "assets/live.html") + tail,
        policy=escape(rules),
        language=language,
        title=escape(title),
        style=style,
        script=script,
        texts=embedded_json({"zh": catalogue(player.__name__, __package__)}),
        **parts(),
    )
    return page, rules
