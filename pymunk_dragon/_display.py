"""Base class of objects that notebooks display."""

from __future__ import annotations

from importlib import import_module

__all__ = ["Displayed"]


class Displayed:
    """Base class of objects with a representation in Jupyter.

    The representations are made by `notebook.py`, which imports the classes that it displays. Its name is resolved only
    when it is needed, so that no calculation imports the drawing libraries.
    """

    def _repr_html_(self) -> str | None:
        text: str | None = import_module("pymunk_dragon.notebook").as_html(self)
        return text

    def _repr_png_(self) -> bytes | None:
        picture: bytes | None = import_module("pymunk_dragon.notebook").as_png(self)
        return picture
