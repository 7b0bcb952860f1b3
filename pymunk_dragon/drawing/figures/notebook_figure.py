"""A matplotlib figure for notebooks. Imports matplotlib, so this module is imported only when a figure is drawn."""

from __future__ import annotations

from io import BytesIO

from matplotlib.figure import Figure

__all__ = ["NotebookFigure"]

# Pixels per inch: the default of notebooks.
NOTEBOOK_DPI = 100


class NotebookFigure(Figure):
    """A matplotlib figure that notebooks display without pyplot."""

    def _repr_png_(self) -> bytes:
        file = BytesIO()
        self.savefig(file, format="png", dpi=NOTEBOOK_DPI)
        return file.getvalue()
