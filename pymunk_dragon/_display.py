"""Base classes of objects that notebooks display, and the hook with which they reach the modules that draw."""

from __future__ import annotations

# Only a type checker imports anything: the package's first lines import this module (see `__init__.py`).
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, ClassVar, Protocol

    class Views(Protocol):
        """Functions that represent a run or a march."""

        def as_html(self, shown: object) -> str | None:
            """HTML, if there is any for this object."""

        def as_png(self, shown: object) -> bytes | None:
            """Bytes of a PNG, if there is one for this object."""

        def plot(self, shown: object) -> Any:
            """A matplotlib figure."""


class Displayed:
    """Base class of objects that are represented by a picture or a page.

    `views` returns the module with the functions that do so. It imports the classes that it represents and the drawing
    libraries. The package sets `views`, so that no module below drawing names one above.
    """

    views: ClassVar[Callable[[], Views]]

    def plot(self) -> Any:
        """Draw the object as a matplotlib figure, which notebooks display.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return Displayed.views().plot(self)

    def _repr_html_(self) -> str | None:
        return Displayed.views().as_html(self)

    def _repr_png_(self) -> bytes | None:
        return Displayed.views().as_png(self)


class Printed:
    """Base class of results that are represented by their text."""

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(str(self), quote=False)}</pre>"
