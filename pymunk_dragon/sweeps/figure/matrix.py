"""The page of a map over more than two axes: a map for each pair of axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Indices
from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, MARGIN, QUIET, page, panel
from pymunk_dragon.sweeps.figure.pages import (
    LEFT,
    TOP,
    WIDTH,
    Content,
    colour_bar,
    jump_entry,
    legend,
    tint_entries,
    words,
)
from pymunk_dragon.sweeps.figure.panels import (
    SMALL,
    draw_field,
    draw_jumps,
    draw_points,
    draw_reference,
    reference_style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Inches: between panels, from the page's bottom to the lowest panel, and from the page's right edge to the last one.
GAP, BOTTOM, RIGHT = 0.16, 1.1, 0.75
# Inches: width and height of the colour bar.
BAR_WIDTH, BAR_HEIGHT = 2.9, 0.16
# Inches: from the upper edge of the first panel up to that of the colour bar.
RAISED = 0.15
# Inches: from the page's bottom to the note on slices.
NOTE = 0.25
# Ticks of an axis: at most so many for three axes, and for more.
TICKS = (4, 3)
# Share of an axis at both of its ends without ticks.
TICK_BORDER = 0.1
# Fewest points of a slice: points with fewer are samples without slices.
MIN_SLICE = 4
# Square points times the number of points, for one square inch of a panel: size of the markers of samples.
MARKERS = 2500.0
# Square points: smallest and largest marker.
MARKER_SIZES = (4.0, 26.0)


def matrix_page(content: Content) -> Figure:
    """Draw values over each pair of axes, and on the diagonal over each axis.

    Panels below the diagonal show slices of a grid, or all points if these are samples.
    """
    count = len(content.names)
    side = (WIDTH - LEFT - RIGHT + GAP) / count - GAP
    figure = page(WIDTH, TOP + count * (side + GAP) - GAP + BOTTOM, content.title, content.subtitle)
    size = float(np.clip(MARKERS * side**2 / max(len(content.points), 1), *MARKER_SIZES))
    slices: list[set[float]] = [set() for _ in content.names]
    has_points = has_jumps = False
    for row in range(count):
        for column in range(row + 1):
            axes = panel(figure, LEFT + column * (side + GAP), BOTTOM + (count - 1 - row) * (side + GAP), side, side)
            if row == column:
                _diagonal(axes, content, row)
                continue
            _ticks(axes, content, column, row)
            others = [axis for axis in range(count) if axis not in (row, column)]
            shown = _slice(content, others)
            found = None
            if shown is None:
                draw_points(axes, content.points[:, [column, row]], content.samples, content.norm, size)
            else:
                points = content.points[shown][:, [column, row]]
                found = draw_field(axes, points, content.samples.at(shown), content.norm)
                for axis in others:
                    slices[axis].add(float(content.points[shown[0], axis]))
            if found is None:
                has_points = True
            else:
                draw_jumps(axes, found.jumps, 0.6)
                has_jumps = has_jumps or len(found.jumps) > 0
            if (at := content.reference_at(column, row)) is not None:
                draw_reference(axes, at[0], at[1], size=5.5)
    _explain(figure, content, LEFT + side + GAP, slices, has_points, has_jumps)
    return figure


def _slice(content: Content, others: Sequence[int]) -> Indices | None:
    """The points of the slice in which the other axes are nearest to the reference or, without one, to their middles.

    Candidates are slices with at least half as many points as the fullest one. None if the points are samples.
    """
    slices, which, size = np.unique(content.points[:, others], axis=0, return_inverse=True, return_counts=True)
    if size.max(initial=0) < MIN_SLICE:
        return None
    low, high = np.array([content.limits[axis] for axis in others]).T
    aim = np.array([content.reference.get(content.names[axis], np.mean(content.limits[axis])) for axis in others])
    distance = np.hypot.reduce((slices - aim) / (high - low), axis=1)
    nearest = np.where(2 * size >= size.max(), distance, np.inf).argmin()
    return np.flatnonzero(which.ravel() == nearest)


def _ticks(axes: Axes, content: Content, column: int, row: int) -> None:
    """Set the limits and ticks of a panel; numbers and names are at the left and at the bottom."""
    from matplotlib.ticker import MaxNLocator

    last = len(content.names) - 1
    axes.set(xlim=content.limits[column], ylim=content.limits[row])
    for scale, (low, high) in ((axes.xaxis, content.limits[column]), (axes.yaxis, content.limits[row])):
        ticks = np.asarray(MaxNLocator(TICKS[len(content.names) > 3]).tick_values(low, high))
        # Numbers at the ends would overlap those of the next panel.
        border = TICK_BORDER * (high - low)
        scale.set_ticks(ticks[(ticks >= low + border) & (ticks <= high - border)].tolist())
    axes.tick_params(labelbottom=row == last, labelleft=column == 0)
    if row == last:
        axes.set_xlabel(words(content.names[column]))
    if column == 0:
        axes.set_ylabel(words(content.names[row]))


def _diagonal(axes: Axes, content: Content, axis: int) -> None:
    """Draw values over one axis, as points, with the scale of values at the right."""
    from matplotlib.ticker import MaxNLocator

    _ticks(axes, content, axis, axis)
    low, high = content.range
    border = 0.06 * (high - low)
    axes.set(ylim=(low - border, high + border), ylabel="")
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.yaxis.tick_right()
    axes.tick_params(labelleft=False, labelright=True)
    axes.spines["left"].set_visible(False)
    axes.spines["right"].set_visible(True)
    if axis == 0:
        axes.set_title(words(content.column), loc="right", size=SMALL, color=QUIET, pad=8)
    if (at := content.reference_at(axis)) is not None:
        dashed: Any = (0, (4, 2.5))
        axes.axvline(at[0], color=COLOURS.contact, lw=0.9, ls=dashed, zorder=1)
    shown = content.samples.coloured
    style: dict[str, Any] = {"color": BLUE, "ms": 2.4, "mew": 0.0, "clip_on": False, "rasterized": True}
    axes.plot(
        content.points[shown, axis], content.samples.values[shown], "o", **style, gid=f"over-{content.names[axis]}"
    )


def _explain(
    figure: Figure, content: Content, left: float, slices: list[set[float]], has_points: bool, has_jumps: bool
) -> None:
    """Draw the colour bar and the legend, and name the slices, in the upper right corner above the diagonal."""
    from matplotlib.lines import Line2D

    across, up = figure.get_size_inches()
    left = max(left + 0.6, across - MARGIN - BAR_WIDTH)
    top = up - TOP + RAISED
    if content.samples.coloured.any():
        colour_bar(figure, content, (left, top - BAR_HEIGHT, across - MARGIN - left, BAR_HEIGHT), "horizontal")
        top -= BAR_HEIGHT + 0.5
    entries = [jump_entry(content)] if has_jumps else []
    if any(content.reference_at(axis) is not None for axis in range(len(content.names))):
        entries.insert(0, Line2D([], [], **reference_style(5.5), label=text("reference")))
    entries += tint_entries(content, set(), points=has_points)
    legend(figure, entries, left, top=top, columns=1)
    near = [words(name, *found) for name, found in zip(content.names, slices, strict=True) if len(found) == 1]
    if any(slices):
        where = ", ".join(near) if all(len(found) <= 1 for found in slices) else text("the reference")
        note = figure.text(LEFT / across, NOTE / up, text("maps: slices near {}").format(where))
        note.set(size=SMALL, color=QUIET, gid="slices")
