"""Fonts, colours and page layout shared by all figures, and the matplotlib settings."""

from __future__ import annotations

import atexit
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import ImageFont

from pymunk_dragon._extras import library
from pymunk_dragon._files import written_in_place
from pymunk_dragon.drawing.palette import Palette

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "AMBER",
    "BLUE",
    "CANDIDATE",
    "COLOURS",
    "DPI",
    "FAINT",
    "QUIET",
    "RULE",
    "SHARED",
    "WIDE_HALO",
    "blend",
    "chart",
    "halo",
    "page",
    "panel",
    "styled",
]

# Colours of the films.
COLOURS = Palette()
# Lines and text: darker than the palette's blue, for a contrast of at least 3 to 1 on the background.
BLUE = "#3f78aa"
# Lines and text: darker than the palette's amber, for a contrast of at least 3 to 1.
AMBER = "#b87400"
# Secondary text: a contrast of 5 to 1.
QUIET = "#5d6675"
# Grid lines and other reference lines.
RULE = "#d9cfb9"
# Fills behind all other elements.
FAINT = "#efe9db"
# Cells that only neighbours share: a tint of blue, distinguishable from CANDIDATE in greyscale.
SHARED = "#d3dfe8"
# Cells with candidates for a contact: a tint of amber.
CANDIDATE = "#efb037"
# Pixels per inch: a page of 8 inches has 1600 pixels, twice the 800 at which it is displayed.
DPI = 200
# Inches from a page's edges to its text.
MARGIN = 0.3
# Inches from a page's top to the baseline of the title.
TITLE_DEPTH = 0.48
# Inches from a page's top to the baseline of the subtitle.
SUBTITLE_DEPTH = 0.8
# Points: size of a title.
TITLE_SIZE = 16
# Points: width of the halo of text over a line.
HALO = 3.0
# Points: width of the halo of text over several lines.
WIDE_HALO = 5.0
# The default font of matplotlib.
FALLBACK_FONT = "DejaVu Sans"

# matplotlib settings. Text has at least 10.5 points, 14 pixels in a picture displayed 800 pixels wide.
RC_PARAMS: dict[str, Any] = {
    "font.size": 11.5,
    "axes.labelsize": 11.5,
    "xtick.labelsize": 10.5,
    "ytick.labelsize": 10.5,
    "text.color": COLOURS.ink,
    "axes.labelcolor": QUIET,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "axes.edgecolor": QUIET,
    "axes.facecolor": "none",
    "axes.linewidth": 0.8,
    "axes.formatter.useoffset": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.facecolor": COLOURS.background,
    "savefig.facecolor": COLOURS.background,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "svg.fonttype": "path",
    # A fixed salt makes the names of clip paths reproducible.
    "svg.hashsalt": "pymunk_dragon",
}


@contextmanager
def styled() -> Iterator[None]:
    """Context with the fonts and colours of all figures; restores matplotlib's settings at its end.

    Figures are drawn in this context, after it has checked that matplotlib can be imported.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    OutputError
        If the fonts, or matplotlib's list of them, cannot be written to the disk.
    """
    matplotlib = library("matplotlib")
    # The font of the films; matplotlib's default font provides missing glyphs such as µ.
    family = {"font.family": [_register_font(), FALLBACK_FONT]}
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(RC_PARAMS | family)
        yield


@cache
def _register_font() -> str:
    """Register the font of Pillow and the films with matplotlib, and return its name."""
    fonts = library("matplotlib.font_manager").fontManager
    # Without FreeType, Pillow has only a bitmap font, which matplotlib cannot use.
    font: Any = ImageFont.load_default(TITLE_SIZE)
    if not hasattr(font, "font_bytes"):
        return FALLBACK_FONT
    # matplotlib reads fonts from files only, and may do so until the program ends.
    folder = tempfile.TemporaryDirectory(prefix="pymunk-dragon-")
    atexit.register(folder.cleanup)
    file = Path(folder.name) / "face.ttf"
    with written_in_place(file) as draft:
        draft.write_bytes(font.font_bytes)
    fonts.addfont(file)
    return str(font.getname()[0])


def page(width: float, height: float, title: str, subtitle: str = "") -> Figure:
    """Create a page with a title and a subtitle in its upper left corner; sizes in inches."""
    from pymunk_dragon.drawing.figures.notebook_figure import NotebookFigure

    figure = NotebookFigure(figsize=(width, height), dpi=DPI)
    x = MARGIN / width
    figure.text(x, 1 - TITLE_DEPTH / height, title, size=TITLE_SIZE)
    figure.text(x, 1 - SUBTITLE_DEPTH / height, subtitle, color=QUIET)
    return figure


def chart(width: float, height: float) -> Figure:
    """Create an empty figure with matplotlib's constrained layout; sizes in inches."""
    from pymunk_dragon.drawing.figures.notebook_figure import NotebookFigure

    return NotebookFigure(figsize=(width, height), dpi=DPI, layout="constrained")


def panel(figure: Figure, left: float, bottom: float, width: float, height: float, **options: Any) -> Axes:
    """Add axes to a page; position and size in inches from the page's lower left corner."""
    across, up = figure.get_size_inches()
    axes: Axes = figure.add_axes((left / across, bottom / up, width / across, height / up), **options)
    return axes


def halo(width: float = HALO) -> list[Any]:
    """Return path effects that keep text readable on lines: a border in the background colour."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=width, foreground=COLOURS.background)]


def blend(first: str, second: str, share: float) -> str:
    """Interpolate between two colours, #rrggbb; `share` is 0 for `first` and 1 for `second`."""
    one, other = bytes.fromhex(first[1:]), bytes.fromhex(second[1:])
    return "#" + bytes(round(a + share * (b - a)) for a, b in zip(one, other, strict=True)).hex()
