"""The language of pictures, pages and printed output: English, or a translation.

A text stands in the code in English, as `text("time (s)")`. A package's `zh.toml` has a table
`texts` from English to Chinese. A text without a translation is shown in English; `make lint` lists
it. Code, the programs of lessons, errors and help are English.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from pymunk_dragon._extras import missing_extra
from pymunk_dragon.errors import ParameterError

LANGUAGES = ("en", "zh")
_language: ContextVar[str] = ContextVar("language", default="en")

# The present language.
language = _language.get


@contextmanager
def in_language(name: str) -> Iterator[None]:
    """Context in which texts are in this language, one of `LANGUAGES`."""
    if name not in LANGUAGES:
        raise ParameterError("lang", name, f"one of {', '.join(LANGUAGES)}")
    token = _language.set(name)
    try:
        yield
    finally:
        _language.reset(token)


def text(english: str, /, *values: object, **named: object) -> str:
    """A text in the present language, with values in place of its fields if there are any."""
    found = english if language() == "en" else texts(language()).get(english, english)
    return found.format(*values, **named) if values or named else found


@cache
def texts(name: str) -> Mapping[str, str]:
    """All translations into a language."""
    import tomllib

    found: dict[str, str] = {}
    for file in Path(__file__).parent.glob(f"*/{name}.toml"):
        found |= tomllib.loads(file.read_text("utf-8"))["texts"]
    return found


def font() -> Path | None:
    """File of a font with the characters of the present language; None if every font has them."""
    if language() == "en":
        return None
    if (file := chinese_font()) is None:
        raise missing_extra("zhplot")
    return file


def chinese_font() -> Path | None:
    """File of the font with Chinese characters; None if its extra is not installed."""
    # Not imported: that would change matplotlib's settings.
    found = find_spec("zhplot")
    if found is None or found.origin is None:
        return None
    return Path(found.origin).with_name("fonts") / "NotoSansSC-Regular.ttf"
