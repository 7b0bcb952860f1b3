"""Fonts, colours and page layout shared by all figures, and the matplotlib settings."""

from __future__ import annotations

import atexit
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import ImageFont

from pymunk_dragon._extras import library
from pymunk_dragon._files import written_in_place
from pymunk_dragon._language import font, language
from pymunk_dragon.drawing.palette import Palette

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Colours of the films.
COLOURS = Palette()
# Lines and text: darker than the palette's blue, for a contrast of at least 4.5 to 1 on the background.
BLUE = "#3a71a3"
# Lines and text: darker than the palette's amber, for a contrast of at least 4.5 to 1.
AMBER = "#9a5f00"
# Secondary text: a contrast of 5 to 1.
QUIET = "#5d6675"
# Lines of less importance: a contrast of 3 to 1.
PALE = "#8a8d96"
# Grid lines and frames.
RULE = "#d9cfb9"
# Fills behind all other elements.
FAINT = "#efe9db"
# Cells that only neighbours share: a tint of blue, distinguishable from CANDIDATE in greyscale.
SHARED = "#d3dfe8"
# Cells with candidates for a contact: a tint of amber.
CANDIDATE = "#efb037"
# Pixels per inch: a page of 8 inches has 1600 pixels, twice the 800 at which it is displayed.
DPI = 200
# Pixels per inch of a figure in a notebook: the default of notebooks.
NOTEBOOK_DPI = 100
# Inches from a page's edges to its text.
MARGIN = 0.3
# Inches: sides of a figure that fills a slide.
SLIDE_WIDTH, SLIDE_HEIGHT = 8.0, 4.5
# Inches from a page's top to the baseline of the title.
TITLE_DEPTH = 0.42
# Inches from the baseline of the title to that of the subtitle.
SUBTITLE_DEPTH = 0.29
# Spacing of lines, and the inches between the baselines of lines of titles and of subtitles that follow from it.
LINE_SPACING, TITLE_LINE, SUBTITLE_LINE = 1.25, 0.28, 0.2
# Points per inch.
POINTS_PER_INCH = 72.0
# Points: size of a title.
TITLE_SIZE = 16
# Points: smallest size of text.
SMALL = 10.5
# Points: width of the halo of text over a line.
HALO = 3.0
# Points: width of the halo of text over several lines.
WIDE_HALO = 5.0
# The default font of matplotlib.
FALLBACK_FONT = "DejaVu Sans"

# matplotlib settings. Text has at least 10.5 points: 14 pixels in a picture displayed 800 pixels wide, and a thirtieth
# of the height of a slide.
RC_PARAMS: dict[str, Any] = {
    "font.size": 11.5,
    "axes.labelsize": 11.5,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
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
    # The font of the language, or of the films; matplotlib's default font provides missing glyphs such as µ.
    family = {"font.family": [_register_font(language()), FALLBACK_FONT]}
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(RC_PARAMS | family)
        yield


@cache
def _register_font(name: str) -> str:
    """Register the font of a language, the present one, with matplotlib; return the name of the font."""
    fonts = library("matplotlib.font_manager").fontManager
    file = font()
    if file is not None:
        fonts.addfont(file)
        return str(ImageFont.truetype(file, TITLE_SIZE).getname()[0])
    # The font of Pillow and the films. Without FreeType it is a bitmap font, which matplotlib cannot use.
    default: Any = ImageFont.load_default(TITLE_SIZE)
    if not hasattr(default, "font_bytes"):
        return FALLBACK_FONT
    # matplotlib reads fonts from files only, and may do so until the program ends.
    folder = tempfile.TemporaryDirectory(prefix="pymunk-dragon-")
    atexit.register(folder.cleanup)
    file = Path(folder.name) / "face.ttf"
    with written_in_place(file) as draft:
        draft.write_bytes(default.font_bytes)
    fonts.addfont(file)
    return str(default.getname()[0])


@cache
def _figure_type() -> type[Figure]:
    """Return the class of matplotlib figures that notebooks display without pyplot."""
    from matplotlib.figure import Figure

    class NotebookFigure(Figure):
        def _repr_png_(self) -> bytes:
            file = BytesIO()
            self.savefig(file, format="png", dpi=NOTEBOOK_DPI)
            return file.getvalue()

    return NotebookFigure


def page(width: float, height: float, title: str, subtitle: str = "") -> Figure:
    """Create a page with a title and a subtitle, of any number of lines, in its upper left corner; sizes in inches."""
    figure = _figure_type()(figsize=(width, height), dpi=DPI)
    style: dict[str, Any] = {"x": MARGIN / width, "linespacing": LINE_SPACING}
    # The baselines of the last lines.
    last = TITLE_DEPTH + TITLE_LINE * title.count("\n")
    below = last + SUBTITLE_DEPTH + SUBTITLE_LINE * subtitle.count("\n")
    figure.text(**style, y=1 - last / height, s=title, size=TITLE_SIZE)
    figure.text(**style, y=1 - below / height, s=subtitle, color=QUIET)
    return figure


def slide(title: str, subtitle: str = "") -> Figure:
    """Create a page that fills a slide."""
    return page(SLIDE_WIDTH, SLIDE_HEIGHT, title, subtitle)


def chart(width: float, height: float) -> Figure:
    """Create an empty figure with matplotlib's constrained layout; sizes in inches."""
    return _figure_type()(figsize=(width, height), dpi=DPI, layout="constrained")


def panel(
    figure: Figure, left: float, bottom: float, width: float, height: float, *, sharey: Axes | None = None
) -> Axes:
    """Add axes to a page; position and size in inches from the page's lower left corner."""
    across, up = figure.get_size_inches()
    axes: Axes = figure.add_axes((left / across, bottom / up, width / across, height / up), sharey=sharey)
    return axes


def key(figure: Figure, entries: Sequence[Any], left: float, top: float) -> None:
    """Explain artists by their labels; `left` and `top` in inches from the page's lower left corner."""
    across, up = figure.get_size_inches()
    figure.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(left / across, top / up),
        frameon=False,
        borderpad=0.0,
        borderaxespad=0.0,
    )


def halo(width: float = HALO) -> list[Any]:
    """Return path effects that keep text readable on lines: a border in the background colour."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=width, foreground=COLOURS.background)]


def blend(first: str, second: str, share: float) -> str:
    """Interpolate between two colours, #rrggbb; `share` is 0 for `first` and 1 for `second`."""
    one, other = bytes.fromhex(first[1:]), bytes.fromhex(second[1:])
    return "#" + bytes(round(a + share * (b - a)) for a, b in zip(one, other, strict=True)).hex()
