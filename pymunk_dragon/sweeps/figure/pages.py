"""What the pages of all maps share: names with units, scales, the colour bar and the legend."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.style import COLOURS, MARGIN, QUIET, panel
from pymunk_dragon.sweeps.figure.panels import JUMP, SMALL, TINTS, Samples, colour_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

# Units of quantities, by the last words of their names.
UNITS = {
    "m": {"pitch", "width", "overhang", "spacing", "radius", "length", "gap", "distance", "start", "x", "y"},
    "m/s": {"speed"},
    "rad": {"rotation"},
    "s": {"time"},
}
# Inches: width of pages.
WIDTH = 8.0
# Inches: from a page's left edge to the panels.
LEFT = 0.85
# Inches: from a page's top to the panels.
TOP = 1.25
# Inches: height of the numbers and of the name below a panel.
LABELS = 0.65
# Inches: free space at a page's bottom.
BOTTOM = 0.15
# Inches: height of a row of the legend.
ROW = 0.3
# Entries in a row of the legend.
COLUMNS = 3
# Points: size of headings.
HEADING = 11.5
# Values of the colour bar and of contour lines: at most so many.
LEVELS = 8
# The same for a horizontal colour bar.
FEW_LEVELS = 5
# Share of a number by which a scale extends beyond it if all values are this number; at least this for small numbers.
SINGLE_VALUE = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class Content:
    """What a page shows: a map with distinct points (P, A)."""

    names: tuple[str, ...]
    column: str
    points: Array
    samples: Samples
    reference: Mapping[str, float]
    title: str
    subtitle: str

    @cached_property
    def tints(self) -> list[str]:
        """Keys of the tints that occur, in the order of `TINTS`."""
        shown = {self.samples.tints[number] for number in self.samples.classes.tolist()}
        return [key for key in TINTS if key in shown]

    @cached_property
    def limits(self) -> list[tuple[float, float]]:
        """Ends of all axes."""
        return [interval(coordinates) for coordinates in self.points.T]

    @cached_property
    def range(self) -> tuple[float, float]:
        """Ends of the scale of values."""
        return interval(self.samples.values[self.samples.coloured])

    @cached_property
    def norm(self) -> Normalize:
        """Scale of the colours."""
        from matplotlib.colors import Normalize

        return Normalize(*self.range)

    def reference_at(self, *axes: int) -> tuple[float, ...] | None:
        """The reference dragon's coordinates on some axes; None if one is absent or outside."""
        found = tuple(float(self.reference.get(self.names[axis], np.nan)) for axis in axes)
        inside = [self.limits[axis][0] <= x <= self.limits[axis][1] for axis, x in zip(axes, found, strict=True)]
        return found if all(inside) else None


def interval(values: Array) -> tuple[float, float]:
    """Least and largest value; if they are the same, numbers on both sides; 0 and 1 if there is none."""
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    border = SINGLE_VALUE * max(abs(low), 1.0) if low == high else 0.0
    return low - border, high + border


def words(name: str, value: float | None = None) -> str:
    """The name of an axis or a column in words, with its unit if it has one, or with a value and the unit.

    Names of the package are translated.

    Examples
    --------
    >>> words("head_spacing"), words("benches"), words("start_s", 3.5)
    ('head spacing, m', 'benches', 'start 3.5 m')
    """
    parts = re.findall(r"[0-9A-Za-z]+", name.rpartition(".")[2].removesuffix("_s"))
    unit = next((unit for unit, known in UNITS.items() if parts and parts[-1] in known), "")
    joined = " ".join(parts)
    name = text(joined)
    if value is not None:
        return " ".join([name, f"{value:g}", unit]).strip()
    return text("{}, {}").format(name, unit) if unit else name


def heading(axes: Axes, name: str) -> None:
    """Write the name of a panel's ordinates above its left end."""
    axes.set_title(name, loc="left", size=HEADING, color=QUIET, pad=10)


def levels(low: float, high: float, count: int = LEVELS) -> Array:
    """Round values from `low` to `high`, about so many."""
    from matplotlib.ticker import MaxNLocator

    ticks = np.asarray(MaxNLocator(count).tick_values(low, high))
    return ticks[(ticks >= low) & (ticks <= high)]


def colour_bar(
    figure: Figure,
    content: Content,
    box: tuple[float, float, float, float],
    orientation: Literal["vertical", "horizontal"],
) -> None:
    """Draw the scale of the colours and its name above; left, bottom, width and height of the box in inches."""
    from matplotlib.cm import ScalarMappable

    left, bottom, width, height = box
    axes = panel(figure, left, bottom, width, height)
    bar = figure.colorbar(ScalarMappable(content.norm, colour_map()), cax=axes, orientation=orientation)
    if bar.solids is not None:
        bar.solids.set(edgecolor="face", rasterized=True)
    bar.outline.set_visible(False)
    bar.set_ticks(levels(*content.range, LEVELS if orientation == "vertical" else FEW_LEVELS).tolist())
    bar.ax.tick_params(labelsize=SMALL)
    across, up = figure.get_size_inches()
    # A name that is longer than the space at the right ends at the page's margin.
    name = figure.text((across - MARGIN) / across, (bottom + height + 0.14) / up, words(content.column), ha="right")
    name.set(size=HEADING, color=QUIET, gid="quantity")


def jump_entry(content: Content) -> Any:
    """Entry of the legend for the lines between classes."""
    from matplotlib.lines import Line2D

    # Names with two numbers are pairs of benches.
    pairs = any(
        re.search(r"\d\D+\d", content.samples.names[number])
        for number in content.samples.classes[content.samples.coloured]
    )
    return Line2D(
        [], [], color=COLOURS.ink, lw=JUMP, label=text("other benches touch first") if pairs else text("jump")
    )


def tint_entries(content: Content, named: set[int], *, points: bool = False) -> list[Any]:
    """Entries of the legend for tints that are not named in a panel; `points` if the panels show single points."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    written = {content.samples.tints[number] for number in named}
    entries: list[Any] = []
    for tint in (TINTS[key] for key in content.tints if key not in written):
        if points:
            style: dict[str, Any] = {"marker": tint.marker, "mfc": tint.colour, "mec": QUIET, "ms": 6, "ls": ""}
            entries.append(Line2D([], [], **style, label=text(tint.text)))
        else:
            entries.append(Patch(**tint.region | {"lw": 0.8}, label=text(tint.text)))
    return entries


def legend_height(entries: int) -> float:
    """Inches from a page's bottom to the lower edge of a panel above a legend with so many entries."""
    return BOTTOM + LABELS + ROW * -(-entries // COLUMNS)


def legend(figure: Figure, entries: list[Any], left: float = LEFT, *, top: float, columns: int = COLUMNS) -> None:
    """Write the legend; `left` and `top` in inches from the page's lower left corner."""
    if not entries:
        return
    across, up = figure.get_size_inches()
    found = figure.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(left / across, top / up),
        ncols=columns,
        frameon=False,
        fontsize=SMALL,
        borderpad=0.0,
        borderaxespad=0.0,
        handletextpad=0.7,
        columnspacing=1.8,
    )
    for written in found.get_texts():
        written.set_color(QUIET)
