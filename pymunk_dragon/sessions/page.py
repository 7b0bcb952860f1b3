"""The page of a live session, which the server and the widget of notebooks show."""

from functools import cache
from html import escape

from pymunk_dragon.web.html import asset, embedded_json
from pymunk_dragon.web.page import catalogue, document


@cache
def live_page(
    title: str, language: str, text: str = "Connecting ...", site: str = "null", rules: str = ""
) -> tuple[str, str]:
    """The page, which opens in a language, and its content security policy.

    A page whose own worker has the session begins with a `text`, and has the JSON of a `site` and
    directives in addition.
    """
    body = asset(__package__, "assets/live.html")
    style = asset(__package__, "assets/live.css")
    texts = embedded_json({"zh": catalogue("pymunk_dragon.player", __package__)})
    rules = f"; connect-src 'self'{rules}"
    values = {"title": escape(title), "text": escape(text), "site": site, "texts": texts}
    return document("live", body, style, rules, language=language, **values)
