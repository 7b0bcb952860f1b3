"""Figure of the sensitivity study: derivatives with respect to each size, and their range of validity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, QUIET, RULE, page, panel
from pymunk_dragon.studies import Reach, Sensitivity, Slope

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["sensitivity"]

# Inches: height of a row.
ROW_HEIGHT = 0.47
# Inches above the rows of a table, for its heading.
HEADING_HEIGHT = 0.45
# Inches below the rows of a table, for its axis.
FOOTER_HEIGHT = 0.8
# Inches from the page's top to the first table, for title and subtitle.
TITLE_HEIGHT = 0.95
# Ratio of an axis limit to the largest slope, and of the smallest slope to the other limit: leaves space for labels.
AXIS_MARGIN = 3.0


def sensitivity(found: Sensitivity) -> Figure:
    """Draw the result of the study `sensitivity`."""
    first, second = found.benches
    parts = [(f"first contact, {found.time:.4f} s, benches {first} and {second}", "s", 1e3, found.times)]
    if found.smallest.benches is not None:
        first, second = found.smallest.benches
        name = f"smallest pitch, {found.smallest.pitch:.6f} m, benches {first} and {second}"
        parts.append((name, "mm", 1.0, found.pitches))
    height = TITLE_HEIGHT + sum(HEADING_HEIGHT + FOOTER_HEIGHT + ROW_HEIGHT * len(rows) for *_, rows in parts)
    figure = page(
        8.0,
        height,
        "What a millimetre does to the first contact, and to the smallest pitch",
        "exact slopes; and how far each size may change until the two touch no more, or others first",
    )
    top = height - TITLE_HEIGHT
    for name, unit, per, rows in parts:
        top -= HEADING_HEIGHT
        tall = ROW_HEIGHT * len(rows)
        figure.text(0.3 / 8.0, (top + 0.12) / height, name, size=11.5)
        _draw_slopes(panel(figure, 1.5, top - tall, 2.75, tall), unit, per, rows)
        _draw_reaches(panel(figure, 4.6, top - tall, 3.0, tall), rows)
        top -= tall + FOOTER_HEIGHT
    return figure


def _draw_slopes(axes: Axes, unit: str, per: float, rows: Sequence[Slope]) -> None:
    """Draw the magnitude of each slope; markers of negative slopes are hollow."""
    from matplotlib.ticker import NullLocator

    values = np.array([row.slope / per for row in rows])
    sizes = np.abs(values)
    axes.set_xscale("log")
    axes.set_xlim(sizes.min() / AXIS_MARGIN, sizes.max() * AXIS_MARGIN)
    _label_rows(axes, [row.size.replace("_", " ") for row in rows])
    for row_index, (value, size) in enumerate(zip(values.tolist(), sizes.tolist(), strict=True)):
        axes.plot([axes.get_xlim()[0], size], [row_index, row_index], color=RULE, lw=1.4, zorder=1)
        face = BLUE if value > 0 else COLOURS.background
        axes.plot(size, row_index, "o", color=BLUE, mfc=face, ms=7, mew=1.8, gid=f"slope-{rows[row_index].size}")
        text = f"{value:+.5f}".replace("-", "\N{MINUS SIGN}")
        axes.annotate(text, (size, row_index), (0, 7), textcoords="offset points", ha="center", size=10.5)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel(f"{unit} for each mm more; hollow: less")


def _draw_reaches(axes: Axes, rows: Sequence[Slope]) -> None:
    """Draw the range in which each size may change without a change of the contact."""
    _label_rows(axes, [""] * len(rows))
    for row_index, row in enumerate(rows):
        if row.less is None or row.more is None:
            continue
        low, high = (100 * reach.unchanged / row.value for reach in (row.less, row.more))
        axes.plot([low, high], [row_index, row_index], color=BLUE, lw=5, solid_capstyle="butt", gid=f"reach-{row.size}")
        for end, reach, direction in ((low, row.less, -1), (high, row.more, 1)):
            axes.annotate(
                _describe_end(reach),
                (end, row_index),
                (5 * direction, 0),
                textcoords="offset points",
                ha="left" if direction > 0 else "right",
                va="center_baseline",
                size=10.5,
                color=COLOURS.ink if reach.changed is not None else QUIET,
            )
    axes.axvline(0, color=QUIET, lw=0.8, zorder=3)
    axes.set_xlim(-19, 19)
    axes.set_xticks([-10, -5, 0, 5, 10])
    axes.set_xlabel("change of the size, %; grey: looked no further")


def _describe_end(reach: Reach) -> str:
    change = f"{1e3 * reach.unchanged:+.3g} mm".replace("-", "\N{MINUS SIGN}")
    if reach.by == "another pair" and reach.benches is not None:
        return change + "\nthen {} and {}".format(*reach.benches)
    return change + {"no contact": "\nthen not", "another corner": "\nother corner"}.get(reach.by, "")


def _label_rows(axes: Axes, names: Sequence[str]) -> None:
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", length=0, labelcolor=COLOURS.ink)
    axes.spines["left"].set_visible(False)
