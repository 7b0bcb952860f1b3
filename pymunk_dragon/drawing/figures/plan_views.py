"""Figures seen from above: the spiral, trajectories and velocities of handles, and pictures of the dragon."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.drawing.figures.lines import lead
from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, PALE, QUIET, SMALL, key, panel, slide
from pymunk_dragon.drawing.figures.times import (
    TimeInterval,
    closing_time,
    contact_or_end,
    last_regular_time,
    spirals_in,
)
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# A run of one frame, and the parameters of its picture.
Still = tuple[Run, Film]

# Points of a path: about 150 on each turn of the reference scenario, enough to appear round.
PATH_POINTS = 2400
# Points of a path in one of several small panels, which are a quarter as wide.
SMALL_PATH_POINTS = 900
# s: least time between dots on a path.
MINUTE = 60.0
# Largest number of dots on a path.
MAX_DOTS = 10
# Free border as a fraction of half the view: for dots, and for arrows.
DOT_BORDER, ARROW_BORDER = 0.05, 0.12
# Length of the head's velocity arrow, as a fraction of half the view.
ARROW_FRACTION = 0.3
# Cosine of the angle between an arrow and the horizontal below which the arrow is nearly horizontal.
ALONG = 0.9
# Lengths of a scale bar, times a power of ten: the longest that is at most half the view.
SCALE_BARS = (1.0, 2.0, 5.0)
# Ratio of the view to the extent of the points: leaves space for dots at the border.
MARGIN = 1.08
# Pixels: size of pictures of the dragon, twice the width at which two or three fit side by side.
STILL_SIZE = 880
# m: centre of a spiral.
ORIGIN = np.zeros(2)


def spiral(march: March, interval: TimeInterval) -> Figure:
    """Draw the spiral that handle 0 follows (the paper's figure 2)."""
    from matplotlib.lines import Line2D

    curve, turns = march.curve, march.curve.turns(march.head_start)
    if not curve.inward or turns is None:
        raise ParameterError("curve", type(curve).__name__, "a Spiral inward, for this figure")
    hit = contact_or_end(march, interval)
    step = MINUTE * max(1.0, np.ceil(hit.time / MINUTE / MAX_DOTS))
    length, gone = curve.end_s - march.head_start, float(march.distance(hit.time))
    title = text("Handle 0 has {:.1f} m\nof spiral ahead of it,\nand gets {:.1f} m far")
    subtitle = text("{:.4g} turns inward and counter-clockwise,\n{:g} m apart")
    if _clockwise(march):
        subtitle = text("{:.4g} turns inward and clockwise,\n{:g} m apart")
    figure = slide(title.format(length, gone), subtitle.format(turns, curve.turn_width))
    axes = panel(figure, 4.05, 0.55, 3.75, 3.75)
    [ahead] = axes.plot(*_path_from_start(march, gone, length).T, color=QUIET, lw=1.0, ls=(0, (3, 2)), gid="ahead")
    [walked] = axes.plot(*_path_from_start(march, 0.0, gone).T, color=BLUE, lw=1.8, gid="walked")
    minutes = np.arange(0.0, hit.time, step)
    dots = march.curve.point(march.head_start + march.distance(minutes))
    axes.plot(*dots.T, "o", color=COLOURS.ink, ms=5, gid="minutes")
    disc: dict[str, Any] = {"boxstyle": "round,pad=0.18,rounding_size=0.6", "fc": COLOURS.ink, "ec": "none"}
    for time, (x, y) in zip(minutes / MINUTE, dots.tolist(), strict=True):
        style: dict[str, Any] = {"ha": "center", "va": "center_baseline", "size": SMALL, "color": COLOURS.background}
        axes.text(x, y, f"{time:g}", bbox=disc, zorder=4, **style)
    last = march.curve.point(march.head_start + gone)
    [end] = axes.plot(*last, "o", color=COLOURS.contact, ms=8, mec=COLOURS.background, zorder=5, gid="last")
    walked.set_label(text("the march of handle 0"))
    dot = Line2D([], [], marker="o", ls="", color=COLOURS.ink, ms=10, label=text("numbers: minutes"))
    end.set_label(text("the end, {:.2f} s").format(hit.time))
    if hit.status == "contact":
        end.set_label(text("the first contact, {:.2f} s").format(hit.time))
    ahead.set_label(text("not reached"))
    key(figure, [walked, dot, end, ahead], 0.3, 1.75)
    _set_limits(axes, ORIGIN, float(np.hypot(*dots[0])), DOT_BORDER)
    return figure


def trajectories(march: March, interval: TimeInterval) -> Figure:
    """Draw the trajectories of the paper's seven handles until the first contact (its figure 7)."""
    hit = contact_or_end(march, interval)
    handles = march.dragon.representatives
    begin, end = march.handles_s([interval[0], hit.time])
    title = text("All handles walk the same path, one behind the other")
    if spirals_in(march):
        title = text("All handles walk the same spiral, one behind the other")
    subtitle = text("from where they start, at {:g} s, to where they are at the end, {:.2f} s")
    if hit.status == "contact":
        subtitle = text("from where they start, at {:g} s, to where they are at the first contact, {:.2f} s")
    figure = slide(title, subtitle.format(interval[0], hit.time))
    whole = _path(march, begin[-1], end[0], SMALL_PATH_POINTS)
    centre, reach = _extent(march, whole)
    for number, handle in enumerate([*handles, None]):
        # Four panels in a row, including the key.
        row, column = divmod(number, 4)
        axes = panel(figure, 0.3 + 1.9 * column, 1.9 - 1.8 * row, 1.7, 1.4)
        _set_limits(axes, centre, reach, DOT_BORDER)
        axes.set_axis_off()
        if handle is None:
            _draw_key(axes, centre, reach)
            continue
        path = _path(march, begin[handle], end[handle], SMALL_PATH_POINTS)
        axes.plot(*whole.T, color=PALE, lw=0.4)
        axes.plot(*path.T, color=BLUE, lw=1.0, gid=f"path-{handle}")
        axes.plot(*path[0], "o", color=COLOURS.ink, mfc=COLOURS.background, ms=6, mew=1.4)
        axes.plot(*path[-1], "o", color=COLOURS.ink, ms=6)
        axes.set_title(text("handle {}").format(handle), size=11.5, pad=3)
    return figure


def velocities(march: March, interval: TimeInterval) -> Figure:
    """Draw the velocities of the paper's seven handles at the first contact (its figure 8)."""
    time, touching = last_regular_time(contact_or_end(march, interval), interval[0])
    handles = np.asarray(march.dragon.representatives)
    states = march.at(time)
    positions, speeds = states.positions[0], states.speeds[0, handles]
    title = text("The handles walk at {:.3f} to {:.3f} m/s shortly before the end")
    if touching:
        title = text("The handles walk at {:.3f} to {:.3f} m/s at the first contact")
    subtitle = text("{} handles at {:.2f} s; each one walks along the curve")
    if spirals_in(march):
        subtitle = text("{} handles at {:.2f} s; each one walks along the spiral, inward and counter-clockwise")
        if _clockwise(march):
            subtitle = text("{} handles at {:.2f} s; each one walks along the spiral, inward and clockwise")
    figure = slide(title.format(speeds.min(), speeds.max()), subtitle.format(len(handles), time))
    axes = panel(figure, 0.75, 0.55, 6.95, 3.05)
    centre, reach = _extent(march, positions)
    first, last = states.handles_s[0, [-1, 0]]
    axes.plot(*_path(march, first, last, PATH_POINTS).T, color=PALE, lw=0.8)
    arrows = ARROW_FRACTION * reach / states.speeds[0, 0] * states.velocities[0, handles]
    axes.quiver(
        *positions[handles].T,
        *arrows.T,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        width=0.005,
        color=COLOURS.motion,
        zorder=3,
        gid="velocities",
    )
    axes.plot(*positions[handles].T, "o", color=COLOURS.ink, ms=6, zorder=4, gid="handles")
    # Arrows along a spiral hardly leave it.
    border = ARROW_BORDER if spirals_in(march) else ARROW_FRACTION + DOT_BORDER
    _set_limits(axes, centre, reach, border, wide=6.95 / 3.05)
    # Labels are in two columns, at the left and at the right of the curve.
    sides = np.where(positions[handles, 0] < centre[0], -1, 1)
    # A leader along an arrow would hide it.
    sides = np.where(sides * arrows[:, 0] > ALONG * np.hypot(*arrows.T), -sides, sides)
    for side in (-1, 1):
        rows = np.flatnonzero(sides == side)
        column = axes.transData.transform((centre[0] + side * (1 + border) * reach, centre[1]))[0]
        names = [text("handle {}: {:.3f} m/s").format(handles[row], speeds[row]) for row in rows]
        lead(axes, positions[handles[rows]], names, column, [QUIET] * len(rows))
    return figure


def outer_loop(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon on the outer loop, at its start."""
    title = text("{} benches on the outer loop") if spirals_in(march) else text("{} benches at the start")
    return _still(march, interval[0], title)


def inward(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon on the inward spiral, as it closes a full loop."""
    time = closing_time(march, interval[0], contact_or_end(march, interval).time)
    title = text("{} benches moving inward") if spirals_in(march) else text("{} benches on the path")
    return _still(march, time, title)


def collision(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon at its first contact."""
    hit = contact_or_end(march, interval, touching=True)
    run, film = _still(march, hit.time, text("{} benches at the first contact"))
    return replace(run, first_contact=hit.contact, outcome="contact"), film


def _still(march: March, time: float, title: str) -> Still:
    """Return the picture at `time`, s, with a title that has the number of benches."""
    return Run.exact(march, [time]), Film(size=STILL_SIZE, title=title.format(march.dragon.benches))


def _path_from_start(march: March, begin: float, end: float) -> Array:
    """Return points (P, 2), m, of the curve from `begin` to `end`, m from the start of handle 0."""
    return _path(march, march.head_start + begin, march.head_start + end, PATH_POINTS)


def _path(march: March, first: float, last: float, points: int) -> Array:
    """Return points (P, 2), m, of the curve between two arc-length coordinates, m."""
    return march.curve.point(np.linspace(first, last, points))


def _clockwise(march: March) -> bool:
    """Return whether handle 0 turns clockwise at its start."""
    return bool(march.curve.curvature(march.head_start) <= 0)


def _extent(march: March, points: Array) -> tuple[Array, float]:
    """Return the centre (2,) and half the width, m, of a square around `points` (P, 2), or around a whole spiral."""
    if spirals_in(march):
        return ORIGIN, float(np.hypot(*points.T).max())
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, MARGIN * float((high - low).max()) / 2


def _set_limits(axes: Axes, centre: Array, reach: float, border: float, *, wide: float = 1.0) -> None:
    """Set the axes' limits to `reach`, m, on each side of `centre` (2,), plus a border; across `wide` times as far."""
    from matplotlib.ticker import MaxNLocator

    half = (1 + border) * reach
    x, y = centre.tolist()
    axes.set_aspect("equal")
    axes.set_xlim(x - wide * half, x + wide * half)
    axes.set_ylim(y - half, y + half)
    for axis, middle, name in ((axes.xaxis, x, "x (m)"), (axes.yaxis, y, "y (m)")):
        ticks = np.asarray(MaxNLocator(5, steps=[1, 2, 4, 5, 10]).tick_values(middle - half, middle + half))
        axis.set_ticks(ticks[np.abs(ticks - middle) <= half].tolist())
        axis.set_label_text(name)


def _draw_key(axes: Axes, centre: Array, reach: float) -> None:
    """Draw the key of the dots, and a scale bar."""
    x, y = centre.tolist()
    for up, name, filling in (
        (0.62, text("at the start"), COLOURS.background),
        (0.12, text("at the end"), COLOURS.ink),
    ):
        axes.plot(x - 0.7 * reach, y + up * reach, "o", color=COLOURS.ink, mfc=filling, ms=6, mew=1.4)
        axes.annotate(name, (x - 0.5 * reach, y + up * reach), va="center_baseline", color=QUIET)
    decade = 10.0 ** np.floor(np.log10(reach))
    bar = decade * max(step for step in SCALE_BARS if step * decade <= reach)
    left = x - 0.8 * reach
    axes.plot([left, left + bar], [y - 0.35 * reach] * 2, color=QUIET, lw=1.4)
    axes.annotate(f"{bar:g} m", (left + bar / 2, y - 0.45 * reach), ha="center", va="top", color=QUIET)
