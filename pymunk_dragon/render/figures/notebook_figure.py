"""A figure that shows itself in a notebook. Loads matplotlib, so it is imported by what is about to draw."""

from __future__ import annotations

from io import BytesIO

from matplotlib.figure import Figure

__all__ = ["NotebookFigure"]

# Pixels to the inch, as notebooks have it.
NOTEBOOK_DPI = 100


class NotebookFigure(Figure):
    """A matplotlib figure that needs no pyplot to be seen."""

    def _repr_png_(self) -> bytes:
        file = BytesIO()
        self.savefig(file, format="png", dpi=NOTEBOOK_DPI)
        return file.getvalue()
