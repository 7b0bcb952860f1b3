"""The page of a live session, which the server and the widget of notebooks show."""

from __future__ import annotations

from functools import cache
from html import escape

from pymunk_dragon.web.html import asset, embedded_json
from pymunk_dragon.web.page import catalogue, document

# Parts of the script of the page; each uses only those before it.
_SCRIPTS = (
    "connection",
    "model",
    "force_scale",
    "shapes",
    "overlays",
    "live_paint",
    "parameters",
    "live_charts",
    "tools",
    "recorder",
    "live_show",
    "live",
    "live_controls",
)


@cache
def live_page(title: str, language: str) -> tuple[str, str]:
    """The page, which opens in a language, and its content security policy."""
    body = asset(__package__, "assets/live.html")
    style = asset(__package__, "assets/live.css")
    script = "".join(asset(__package__, f"assets/{name}.js") for name in _SCRIPTS)
    texts = embedded_json({"zh": catalogue("pymunk_dragon.player", __package__)})
    rules = "; connect-src 'self'"
    title = escape(title)
    return document(body, style, script, rules, language=language, title=title, texts=texts)
