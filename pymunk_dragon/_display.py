"""Base classes of objects that notebooks display."""

from __future__ import annotations

from html import escape
from importlib import import_module
from typing import Any


class Displayed:
    """Base class of objects that `pymunk_dragon.notebook` represents by a picture or a page."""

    def plot(self) -> Any:
        """Draw the object as a matplotlib figure, which notebooks display."""
        return _views().plot(self)

    def _repr_html_(self) -> Any:
        return _views().as_html(self)

    def _repr_png_(self) -> Any:
        return _views().as_png(self)


class Printed:
    """Base class of results that are represented by their text."""

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self), quote=False)}</pre>"


def _views() -> Any:
    """The module that represents objects. By its name, because the package is above the classes of all of them."""
    return import_module("pymunk_dragon.notebook")
