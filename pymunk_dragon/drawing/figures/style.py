"""What figures share: fonts and colours, page layout, labels, and the march that they show."""

from __future__ import annotations

import atexit
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, cached_property
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import ImageFont

from pymunk_dragon._arrays import Array
from pymunk_dragon._extras import library
from pymunk_dragon._language import font, language, text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.drawing.palette import COLOURS as COLOURS
from pymunk_dragon.errors import OutputError, ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Lines and text: darker than the palette's blue, for a contrast of at least 4.5 to 1 on the
# background.
BLUE = "#3a71a3"
# Lines and text beside blue ones, with a contrast of at least 4.5 to 1 too.
AMBER = "#9a5f00"
# Secondary text: a contrast of 5 to 1.
QUIET = "#5d6675"
# Lines of less importance: a contrast of 3 to 1.
PALE = "#8a8d96"
# Grid lines and frames.
RULE = "#d9cfb9"
# Fills behind all other elements.
FAINT = "#efe9db"
# Cells that only neighbours share: distinguishable from candidates in greyscale.
SHARED = "#d3dfe8"
# Cells with candidates for a contact.
CANDIDATE = "#efb037"
# Pixels per inch: a page of 8 inches has 1600 pixels, twice the 800 at which it is displayed.
_DPI = 200
# Inches: width of a figure that fills a slide.
_SLIDE_WIDTH = 8.0
# Inches: height of a figure that fills a slide.
_SLIDE_HEIGHT = 4.5
# Inches from the left edge of a slide to its text.
_MARGIN = 0.3
# Inches from a slide's top to its title.
_TITLE_TOP = 0.24
# Inches from a slide's top to its subtitle.
_SUBTITLE_TOP = 0.56
# Font sizes from one line to the next.
_LINE_SPACING = 1.25
# Points: size of a title.
_TITLE_SIZE = 16
# Points: smallest size of text.
SMALL = 10.5
# Points: width of the halo of text over a line.
_HALO = 3.0
# Area of a slide below its title, as left, bottom, width and height in fractions of the page.
_BELOW_TITLE = (0.02, 0.01, 0.96, 0.8)
# Inches between panels.
_PADDING = 0.1
# Options of a legend beside axes.
BESIDE: dict[str, Any] = {
    "loc": "upper left",
    "bbox_to_anchor": (1, 1),
}
# Fraction of a march without contact before its end that shows no speeds, which are unbounded where
# a spiral ends.
_IRREGULAR_FRACTION = 0.05

# matplotlib settings. Text has at least 10.5 points: a thirtieth of the height of a slide.
_RC_PARAMS: dict[str, Any] = {
    "font.size": 11.5,
    "text.color": COLOURS.ink,
    "axes.facecolor": "none",
    "figure.facecolor": COLOURS.background,
    "lines.solid_capstyle": "round",
    "lines.linewidth": 2.0,
    "grid.color": RULE,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.labelspacing": 0.8,
    # A fixed salt makes the names of clip paths reproducible.
    "svg.hashsalt": "pymunk_dragon",
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize"), SMALL),
    **dict.fromkeys(("axes.labelcolor", "xtick.color", "ytick.color", "axes.edgecolor"), QUIET),
    **dict.fromkeys(("axes.formatter.useoffset", "axes.spines.top", "axes.spines.right"), False),
}


@contextmanager
def styled() -> Iterator[None]:
    """Context with the fonts and colours of all figures.

    At its end it restores matplotlib's settings.
    """
    matplotlib = library("matplotlib")
    # The font of the language, or of the films; matplotlib's default font provides missing glyphs
    # such as µ.
    family = {"font.family": [_register_font(language()), "DejaVu Sans"]}
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_RC_PARAMS | family)
        yield


@cache
def _register_font(name: str) -> str:
    """Register the font of a language, the present one, with matplotlib, and return its name."""
    file = font()
    if file is None:
        # The font of Pillow and the films. matplotlib reads it from a file only, perhaps until the
        # program ends.
        default: Any = ImageFont.load_default(_TITLE_SIZE)
        folder = tempfile.TemporaryDirectory(prefix="pymunk-dragon-")
        atexit.register(folder.cleanup)
        file = Path(folder.name) / "face.ttf"
        try:
            file.write_bytes(default.font_bytes)
        except OSError as error:
            raise OutputError(file, error.strerror or str(error)) from error
    library("matplotlib.font_manager").fontManager.addfont(file)
    return str(ImageFont.truetype(file, _TITLE_SIZE).getname()[0])


@cache
def _figure_type() -> type[Figure]:
    """Class of matplotlib figures that notebooks display without pyplot."""
    from matplotlib.figure import Figure

    class NotebookFigure(Figure):
        def _repr_png_(self) -> bytes:
            file = BytesIO()
            self.savefig(file, format="png", dpi=_DPI // 2)
            return file.getvalue()

    return NotebookFigure


def chart(width: float, height: float) -> Figure:
    """Create an empty figure with matplotlib's constrained layout; sides in inches."""
    return _figure_type()(figsize=(width, height), dpi=_DPI, layout="constrained")


def slide(title: str, subtitle: str, rows: int = 1, columns: int = 1) -> tuple[Figure, Any]:
    """Create a figure that fills a slide, with a title and a subtitle in its upper left.

    The axes below them, laid out by matplotlib, are returned too.
    """
    figure = chart(_SLIDE_WIDTH, _SLIDE_HEIGHT)
    left = _MARGIN / _SLIDE_WIDTH
    aligned: dict[str, Any] = {"x": left, "va": "top", "linespacing": _LINE_SPACING}
    figure.text(y=1 - _TITLE_TOP / _SLIDE_HEIGHT, s=title, size=_TITLE_SIZE, **aligned)
    figure.text(y=1 - _SUBTITLE_TOP / _SLIDE_HEIGHT, s=subtitle, color=QUIET, **aligned)
    figure.set_layout_engine("constrained", rect=_BELOW_TITLE, w_pad=_PADDING, h_pad=_PADDING)
    return figure, figure.subplots(rows, columns)


def halo() -> list[Any]:
    """Path effects that keep text readable on lines: a border in the background colour."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=_HALO, foreground=COLOURS.background)]


def plan(axes: Axes) -> None:
    """Give both directions one scale, with labels in m."""
    axes.set(xlabel="x (m)", ylabel="y (m)")
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=5, steps=[1, 2, 4, 5, 10])


def logarithmic(axes: Axes, low: float, high: float) -> None:
    """Set a logarithmic scale of lengths from `low` to `high`, m, with SI prefixes.

    It has thin grid lines.
    """
    from matplotlib.ticker import EngFormatter, NullFormatter

    axes.set(yscale="log", ylim=(low, high))
    axes.yaxis.set(major_formatter=EngFormatter("m"), minor_formatter=NullFormatter())
    axes.grid(axis="y")


@dataclass(frozen=True)
class FigureSource:
    """A march from `begin` to `until`, s, or to the end of its curve.

    `run` is the run that it was taken from, if any.
    """

    march: March
    begin: float = 0.0
    until: float | None = None
    run: Run | None = None

    @cached_property
    def hit(self) -> FirstContact:
        """The first contact, or the end."""
        hit = first_contact(self.march, start=self.begin, until=self.until)
        if hit.status == "overlapping":
            pair = "one whose benches {} and {} overlap at the start".format(*(hit.benches or ()))
            raise ParameterError("march", pair, "one whose benches are apart")
        return hit

    @property
    def end(self) -> str:
        """Name and time of the first contact, or of the end."""
        if self.hit.contact:
            return text("the first contact, {:.2f} s", self.hit.time)
        return text("the end, {:.2f} s", self.hit.time)

    @property
    def last_regular_time(self) -> float:
        """Time of the contact, or shortly before an end without contact, s."""
        time = self.hit.time
        return time if self.hit.contact else time - _IRREGULAR_FRACTION * (time - self.begin)

    def path(self, first: float, last: float, points: int = 2400) -> Array:
        """Points (P, 2), m, of the curve between two arc-length coordinates, m.

        By default about 150 of them are on a turn of the paper's spiral.
        """
        return self.march.curve.point(np.linspace(first, last, points))
