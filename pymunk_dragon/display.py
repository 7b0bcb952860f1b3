"""Things that show themselves in a notebook."""

from __future__ import annotations

from importlib import import_module

__all__ = ["Displayed"]


class Displayed:
    """Base class of objects with a representation in Jupyter.

    How things look is known to the room `notebook`, far above the rooms of the things themselves. They know it by name
    only, so that no calculation loads what draws.
    """

    def _repr_html_(self) -> str | None:
        text: str | None = import_module("pymunk_dragon.notebook").as_html(self)
        return text

    def _repr_png_(self) -> bytes | None:
        picture: bytes | None = import_module("pymunk_dragon.notebook").as_png(self)
        return picture
