"""Lines over time and along the dragon: styles, scales and labels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.drawing.figures.style import COLOURS, RULE, WIDE_HALO, blend, halo

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation


# Fraction of a time interval: times closer than this are drawn only once.
MIN_TIME_DIFFERENCE = 0.02
# Colour of the first of several lines; the colours of later lines change gradually to ink.
FIRST_COLOUR = "#6391bb"
# Points: distance between the centres of two lines of text.
LINE_HEIGHT = 14.0
# Points: distance from a line's end to its label.
NAME_OFFSET = 7.0
# Largest number of handles or joints that all have a tick label.
MAX_NUMBERED = 10


def several_times(begin: float, end: float) -> Array:
    """Return a few round times, s, from `begin` on, and `end`."""
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(begin, end)
    # A tick close to the end is omitted.
    return np.array([*(tick for tick in ticks if begin <= tick < end - MIN_TIME_DIFFERENCE * (end - begin)), end])


def logarithmic(axes: Axes, low: float, high: float) -> None:
    """Set a logarithmic scale from `low` to `high` with plain numbers and thin grid lines."""
    from matplotlib.ticker import NullLocator

    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color=RULE, lw=0.6)
    axes.set_axisbelow(True)


def bundle(axes: Axes, values: Array, gid: str) -> list[Any]:
    """Draw lines of `values` (T, K) along the dragon; later lines are darker and thicker."""
    last = max(len(values) - 1, 1)
    lines: list[Any] = []
    for rank, line in enumerate(values):
        age = rank / last
        lines += axes.plot(line, color=blend(FIRST_COLOUR, COLOURS.ink, age), lw=1.2 + 1.2 * age, gid=f"{gid}-{rank}")
    axes.set_xlim(0, values.shape[1] - 1)
    if values.shape[1] <= MAX_NUMBERED:
        # One tick for each handle or joint.
        axes.set_xticks(range(values.shape[1]))
    return lines


def name(axes: Axes, lines: Sequence[Any], times: Array, at: int, offset: float, ha: str = "left") -> None:
    """Label the lines with their times at their points `at`, without overlaps."""
    to_pixels = axes.transData
    points = to_pixels.transform([line.get_xydata()[at] for line in lines])
    points[:, 1] = spread(points[:, 1].tolist(), LINE_HEIGHT / 72 * axes.figure.dpi)
    for (x, y), time in zip(to_pixels.inverted().transform(points).tolist(), times.tolist(), strict=True):
        note = label(axes, x, y, time_name(time), (offset, 0), ha=ha, va="center_baseline")
        note.set_annotation_clip(False)


def spread(positions: Sequence[float], spacing: float) -> list[float]:
    """Return the label positions closest to `positions` (least squares) that keep their order and a least `spacing`."""
    order = sorted(range(len(positions)), key=lambda i: positions[i])
    # Blocks of labels that touch: their indices, and the mean of their positions.
    blocks: list[tuple[list[int], float]] = []
    for i in order:
        block, middle = [i], float(positions[i])
        while blocks and middle - blocks[-1][1] < spacing * (len(block) + len(blocks[-1][0])) / 2:
            before, other = blocks.pop()
            middle = (middle * len(block) + other * len(before)) / (len(block) + len(before))
            block = before + block
        blocks.append((block, middle))
    result = [0.0] * len(positions)
    for block, middle in blocks:
        for rank, i in enumerate(block):
            result[i] = middle + spacing * (rank - (len(block) - 1) / 2)
    return result


def time_name(time: float) -> str:
    """Format a time to the hundredth of a second, without trailing zeros."""
    return f"{time:.2f}".rstrip("0").rstrip(".") + " s"


def label(
    axes: Axes,
    x: float,
    y: float,
    text: str,
    offset: tuple[float, float],
    ha: str = "left",
    va: str = "baseline",
    *,
    color: str = COLOURS.ink,
    zorder: float = 3.0,
    size: float | None = None,
    border: float = WIDE_HALO,
) -> Annotation:
    """Write text beside a point, at an offset in points, with a `border` that keeps it readable on lines."""
    return axes.annotate(
        text,
        (x, y),
        offset,
        textcoords="offset points",
        ha=ha,
        va=va,
        color=color,
        zorder=zorder,
        size=size,
        path_effects=halo(border) if border else None,
    )
