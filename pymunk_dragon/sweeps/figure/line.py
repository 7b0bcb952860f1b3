"""The page of values over one axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.drawing.figures.room import Room
from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, RULE, page, panel
from pymunk_dragon.sweeps.figure.pages import (
    LABELS,
    LEFT,
    TOP,
    WIDTH,
    Content,
    heading,
    legend,
    legend_height,
    tint_entries,
    words,
)
from pymunk_dragon.sweeps.figure.panels import TINTS, draw_reference, put_name, put_reference

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

# Inches: sides of the panel.
ACROSS, UP = 6.85, 3.4
# Shares of the range of values: free space below and above the line; names are above.
BELOW, ABOVE = 0.06, 0.16
# Largest number of points that are drawn as dots.
MAX_DOTS = 150
# Positions of a name in its run, as shares of the run's width.
NAME_SHARES = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8)
# Share of the panel's height between its ends and names.
NAME_GAP = 0.03


@dataclass(frozen=True)
class _Run:
    """Successive points of one class, from `start` to before `stop`, which extend halfway to their neighbours."""

    number: int
    start: int
    stop: int
    left: float
    right: float


def line_page(content: Content) -> Figure:
    """Draw values over one axis, with a line that is broken where the label changes."""
    x, samples, bottom = content.points[:, 0], content.samples, legend_height(len(content.tints))
    figure = page(WIDTH, TOP + UP + bottom, content.title, content.subtitle)
    axes = panel(figure, LEFT, bottom, ACROSS, UP)
    heading(axes, words(content.column))
    low, high = content.range
    low, high = low - BELOW * (high - low), high + ABOVE * (high - low)
    axes.set(xlabel=words(content.names[0]), xlim=content.limits[0], ylim=(low, high))
    if not samples.coloured.any():
        axes.set_yticks([])
    runs, room = _runs(content), Room(axes)
    for run in runs:
        part = slice(run.start, run.stop)
        if samples.tints[run.number] is None:
            dots = "o" if len(x) <= MAX_DOTS or run.stop - run.start == 1 else ""
            axes.plot(x[part], samples.values[part], color=BLUE, lw=2.0, marker=dots, ms=3, clip_on=False, gid="line")
            room.take_path(np.stack([x[part], samples.values[part]], axis=1))
    if (at := content.reference_at(0)) is not None:
        _mark(axes, at[0], _value_at(content, runs, at[0]), room)
    bounds = np.array([run.left for run in runs[1:]])
    axes.vlines(bounds, low, high, color=RULE, lw=0.9, zorder=0.8, gid="jumps")
    room.take(_verticals(bounds, low, high))
    named = set()
    for run in runs:
        if (tint := samples.tints[run.number]) is not None:
            axes.axvspan(run.left, run.right, **TINTS[tint].region, zorder=0.5, gid=tint or "none")
        for end in (1, 0):
            if put_name(axes, samples, run.number, room, partial(_at_end, axes, run, end)):
                named.add(run.number)
                break
    legend(figure, tint_entries(content, named), top=bottom - LABELS)
    return figure


def _runs(content: Content) -> list[_Run]:
    x, classes = content.points[:, 0], content.samples.classes
    starts = np.flatnonzero(np.diff(classes, prepend=-1))
    if not len(starts):
        return []
    bounds = np.concatenate([content.limits[0][:1], (x[starts[1:]] + x[starts[1:] - 1]) / 2, content.limits[0][1:]])
    stops = [*starts[1:].tolist(), len(x)]
    return [
        _Run(int(classes[start]), start, stop, left, right)
        for start, stop, left, right in zip(
            starts.tolist(), stops, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True
        )
    ]


def _value_at(content: Content, runs: list[_Run], at: float) -> float | None:
    """The value of the line at a coordinate; None where there is no line."""
    x = content.points[:, 0]
    for run in runs:
        if content.samples.tints[run.number] is None and x[run.start] <= at <= x[run.stop - 1]:
            part = slice(run.start, run.stop)
            return float(np.interp(at, x[part], content.samples.values[part]))
    return None


def _mark(axes: Axes, x: float, y: float | None, room: Room) -> None:
    """Mark the reference dragon by a vertical line, and a dot on the line or at the lower end of the panel."""
    low, high = axes.get_ylim()
    dashed: Any = (0, (5, 3))
    axes.axvline(x, color=COLOURS.contact, lw=1.0, ls=dashed, zorder=1.5)
    draw_reference(axes, x, low if y is None else y)
    room.take(_verticals(np.array([x]), low, high))
    put_reference(axes, x, low if y is None else y, room)


def _verticals(x: Array, low: float, high: float) -> Array:
    """Vertical lines as segments, (S, 2, 2)."""
    return np.stack([np.stack([x, np.full_like(x, y)], axis=1) for y in (low, high)], axis=1)


def _at_end(axes: Axes, run: _Run, end: int, text: Text) -> Array:
    """Middles of a text in a run, just above the lower end (0) or just below the upper end (1) of the panel, (K, 2)."""
    box = axes.get_window_extent()
    edge = text.get_window_extent().height / 2 + NAME_GAP * box.height
    _, y = axes.transData.inverted().transform((box.x0, (box.y0 + edge, box.y1 - edge)[end]))
    x = run.left + np.array(NAME_SHARES) * (run.right - run.left)
    return np.stack([x, np.full_like(x, y)], axis=1)
