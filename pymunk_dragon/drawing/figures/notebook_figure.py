"""A matplotlib figure for notebooks and files. Imports matplotlib, so it is imported only when a figure is drawn."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.figures.style import FIGURE_ENDINGS, styled

# Pixels per inch: the default of notebooks.
NOTEBOOK_DPI = 100
# Colours of a PNG: with 256 no pixel changes by more than two levels, and the file is a third as large.
PNG_COLOURS = 256


class NotebookFigure(Figure):
    """A matplotlib figure that notebooks display without pyplot, and whose files are the same each time."""

    def write(self, path: str | Path) -> None:
        """Write the figure as PNG, with at most 256 colours, or as SVG.

        Raises
        ------
        ParameterError
            If the ending is neither .png nor .svg, or the file cannot be created.
        OutputError
            If writing fails.
        """
        destination = check_destination(path, FIGURE_ENDINGS)
        with styled(), written_in_place(destination) as draft:
            if destination.suffix.lower() == ".svg":
                self.savefig(draft, format="svg", metadata={"Date": None})
                return
            with Image.open(BytesIO(self._png())) as picture:
                flat = picture.convert("RGB")
            few = flat.quantize(PNG_COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            few.save(draft, format="PNG", optimize=True)

    def _png(self, dpi: float | None = None) -> bytes:
        """The figure as the bytes of a PNG; `dpi` are pixels per inch, by default the figure's own."""
        file = BytesIO()
        self.savefig(file, format="png", dpi=dpi or "figure")
        return file.getvalue()

    def _repr_png_(self) -> bytes:
        return self._png(NOTEBOOK_DPI)
