"""Lines over time and along the dragon: styles, scales and labels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.style import COLOURS, LINE_SPACING, POINTS_PER_INCH, RULE, WIDE_HALO, blend, halo

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

    from pymunk_dragon.drawing.figures.room import Room


# Fraction of a time interval: times closer than this are drawn only once.
MIN_TIME_DIFFERENCE = 0.02
# Colour of the first of several lines; the colours of later lines change gradually to ink.
FIRST_COLOUR = "#6391bb"
# Points: distance between the centres of two lines of text.
LINE_HEIGHT = 14.0
# Points: distance from a line's end, or a point, to its label, which a leader bridges.
LEADER = 15.0
# Points: width of leaders.
LEADER_WIDTH = 0.9
# Points: distances from a line to the middle of its label above or below.
LABEL_DISTANCES = (12.0, 16.0, 20.0, 26.0)
# Ratio of the ends of a logarithmic scale below which also numbers between powers of ten have ticks.
SHORT_SCALE = 30.0
# Largest number of ticks of a logarithmic scale.
MAX_TICKS = 12
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
    axes.yaxis.set_major_locator(log_locator(low, high))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color=RULE, lw=0.6)
    axes.set_axisbelow(True)


def log_locator(low: float, high: float) -> Any:
    """Return a locator of the powers of ten from `low` to `high` and, on a short scale, of numbers between them."""
    from matplotlib.ticker import LogLocator

    return LogLocator(subs=(1.0, 2.0, 3.0, 5.0) if high < SHORT_SCALE * low else (1.0,), numticks=MAX_TICKS)


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


def name(axes: Axes, lines: Sequence[Any], times: Array, side: Literal["left", "right"] = "right") -> None:
    """Label the lines at their left or right ends with their times; leaders connect ends and labels."""
    ends = [line.get_xydata()[-1 if side == "right" else 0] for line in lines]
    across = axes.transData.transform(ends)[0, 0]
    offset = LEADER / POINTS_PER_INCH * axes.figure.dpi
    lead(
        axes,
        np.array(ends),
        [time_name(time) for time in times.tolist()],
        across + (offset if side == "right" else -offset),
        [line.get_color() for line in lines],
    )


def lead(axes: Axes, points: Array, names: Sequence[str], across: float, colours: Sequence[str]) -> None:
    """Label points (K, 2) in a column at `across` pixels, with leaders from the points, without overlaps."""
    pixels = axes.transData.transform(points.reshape(-1, 2))
    scale = POINTS_PER_INCH / axes.figure.dpi
    heights = spread(pixels[:, 1].tolist(), LINE_HEIGHT / scale)
    for point, (x, y), height, shown, colour in zip(points, pixels, heights, names, colours, strict=True):
        right = across > x
        style = {"arrowstyle": "-", "color": colour, "lw": LEADER_WIDTH, "shrinkA": 2, "shrinkB": 0}
        note = axes.annotate(
            shown,
            (float(point[0]), float(point[1])),
            (scale * (across - x), scale * (height - y)),
            textcoords="offset points",
            ha="left" if right else "right",
            va="center",
            arrowprops=style | {"relpos": (0.0 if right else 1.0, 0.5)},
            annotation_clip=False,
        )
        note.set_zorder(4)


def name_line(axes: Axes, room: Room, points: Array, shown: str, colour: str) -> None:
    """Write the name of a line through `points` (K, 2) above or below the line, where there is room."""
    offsets = [(0.0, side * distance) for distance in LABEL_DISTANCES for side in (1, -1)]
    label_in_room(axes, room, points, shown, offsets, color=colour)


def label_in_room(
    axes: Axes, room: Room, points: Array, shown: str, offsets: Sequence[tuple[float, float]], **style: Any
) -> None:
    """Write text at one of the `offsets`, in points, from one of `points` (K, 2), where there is room in the panel."""
    x, y = points[0].tolist()
    note = axes.text(x, y, shown, ha="center", va="center", linespacing=LINE_SPACING, **style)
    note.set_path_effects(halo())
    moves = np.array(offsets) / POINTS_PER_INCH * axes.figure.dpi
    positions = (axes.transData.transform(points)[:, None] + moves).reshape(-1, 2)
    frame, half = axes.get_window_extent(), np.array(note.get_window_extent().size) / 2
    inside = ((positions - half >= frame.min) & (positions + half <= frame.max)).all(axis=1)
    room.put(note, axes.transData.inverted().transform(positions[inside] if inside.any() else positions), needed=True)


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
    return text("{} s").format(f"{time:.2f}".rstrip("0").rstrip(".").replace("-", "\u2212"))


def label(
    axes: Axes,
    x: float,
    y: float,
    shown: str,
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
        shown,
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
