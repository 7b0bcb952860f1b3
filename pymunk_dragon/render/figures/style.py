"""Type, colours and pages that all figures share; in which matplotlib may be used."""

from __future__ import annotations

import atexit
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import ImageFont

from pymunk_dragon.extras import library
from pymunk_dragon.files import written_in_place
from pymunk_dragon.render.palette import Palette

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

COLOURS = Palette()
# The palette's blue and amber are for areas with an outline. As lines and type on its light ground they need more
# contrast: these have 3 to 1 and more. Quiet type has 5 to 1.
BLUE, AMBER, QUIET = "#3f78aa", "#b87400", "#5d6675"
# Lines that only guide the eye, and fills behind everything.
RULE, FAINT = "#d9cfb9", "#efe9db"
# Cells that neighbours share, and cells with candidates for a contact: tints of the blue and of the amber, which differ
# in grey too.
SHARED, CANDIDATE = "#d3dfe8", "#efb037"
# Pixels to the inch. A page 8 inches wide is 1600 pixels, for pages that show it 800 wide.
DPI = 200
# Inches from a page's edges to its type, and from its top to the base lines of title and subtitle.
MARGIN, TITLE_DEPTH, SUBTITLE_DEPTH = 0.3, 0.48, 0.8
TITLE_SIZE = 16
# Points around type that stands on lines, and on several of them.
HALO, WIDE_HALO = 3.0, 5.0
# The face that matplotlib brings.
FALLBACK = "DejaVu Sans"

# Type no smaller than 10.5 points, 14 pixels of a picture that is shown 800 wide.
SETTINGS: dict[str, Any] = {
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
    # Without it the names of clip paths are drawn by lot.
    "svg.hashsalt": "pymunk_dragon",
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the house's type and colours; matplotlib's own settings are as before afterwards.

    Whatever draws is called in here, and may import matplotlib.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    OutputError
        If the fonts, or matplotlib's list of them, cannot be written to the disk.
    """
    matplotlib = library("matplotlib")
    # The films' face first; what it has no glyph for, as µ, comes from the one that matplotlib brings.
    family = {"font.family": [_face(), FALLBACK]}
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(SETTINGS | family)
        yield


@cache
def _face() -> str:
    """Name of the face that Pillow brings and the films are set in, made known to matplotlib."""
    fonts = library("matplotlib.font_manager").fontManager
    # Where Pillow was built without FreeType there is none, and the films are set in dots.
    font: Any = ImageFont.load_default(TITLE_SIZE)
    if not hasattr(font, "font_bytes"):
        return FALLBACK
    # matplotlib reads faces from files only, and may do so until the very end.
    folder = tempfile.TemporaryDirectory(prefix="pymunk-dragon-")
    atexit.register(folder.cleanup)
    file = Path(folder.name) / "face.ttf"
    with written_in_place(file) as draft:
        draft.write_bytes(font.font_bytes)
    fonts.addfont(file)
    return str(font.getname()[0])


def page(width: float, height: float, title: str, subtitle: str = "") -> Figure:
    """An empty page of so many inches, with what it tells in its upper left corner."""
    from pymunk_dragon.render.figures.notebook_figure import NotebookFigure

    figure = NotebookFigure(figsize=(width, height), dpi=DPI)
    x = MARGIN / width
    figure.text(x, 1 - TITLE_DEPTH / height, title, size=TITLE_SIZE)
    figure.text(x, 1 - SUBTITLE_DEPTH / height, subtitle, color=QUIET)
    return figure


def chart(width: float, height: float) -> Figure:
    """An empty picture of so many inches, in which axes find their places by themselves."""
    from pymunk_dragon.render.figures.notebook_figure import NotebookFigure

    return NotebookFigure(figsize=(width, height), dpi=DPI, layout="constrained")


def panel(figure: Figure, left: float, bottom: float, width: float, height: float, **options: Any) -> Axes:
    """Axes on a page, placed in inches from the page's lower left corner."""
    across, up = figure.get_size_inches()
    axes: Axes = figure.add_axes((left / across, bottom / up, width / across, height / up), **options)
    return axes


def halo(width: float = HALO) -> list[Any]:
    """Path effects that keep type readable on lines: a border of the ground's colour."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=width, foreground=COLOURS.background)]


def blend(first: str, second: str, share: float) -> str:
    """The colour a `share` of the way from `first` to `second`, all as #rrggbb."""
    one, other = bytes.fromhex(first[1:]), bytes.fromhex(second[1:])
    return "#" + bytes(round(a + share * (b - a)) for a, b in zip(one, other, strict=True)).hex()
