"""Parts of self-contained HTML pages, which load nothing from elsewhere."""

from __future__ import annotations

from base64 import b64encode
from hashlib import sha256
from importlib.resources import files
from typing import Any

from pymunk_dragon._extras import library

__all__ = ["asset", "data_address", "filled", "policy"]


def asset(package: str, name: str) -> str:
    """The text of a file among a package's, as `asset(__package__, "assets/page.css")`."""
    return files(package).joinpath(name).read_text(encoding="utf-8")


def filled(package: str, template: str, **values: Any) -> str:
    """A template among a package's files, with `values` in it, all of them escaped.

    Raises
    ------
    MissingExtraError
        If Jinja2 is not installed.
    """
    jinja2 = library("jinja2")
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: asset(package, name)),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text: str = environment.get_template(template).render(values)
    return text


def data_address(content: bytes, kind: str) -> str:
    """An address that holds the content of a file itself; `kind` is its media type, as "image/png"."""
    return f"data:{kind};base64,{b64encode(content).decode('ascii')}"


def policy(style: str, script: str, pictures: str = "data:") -> str:
    """What a browser lets a page do: run this style and this script, and show pictures from such addresses."""
    return (
        f"default-src 'none'; script-src {_hash(script)}; style-src {_hash(style)}; img-src {pictures}; "
        "base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    return f"'sha256-{b64encode(sha256(text.encode('utf-8')).digest()).decode('ascii')}'"
