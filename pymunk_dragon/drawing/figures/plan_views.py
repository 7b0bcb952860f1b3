"""Figures seen from above: the spiral, trajectories and velocities of handles, and pictures of the dragon."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.drawing.figures.lines import label
from pymunk_dragon.drawing.figures.style import (
    BLUE,
    COLOURS,
    HALO,
    QUIET,
    RULE,
    WIDE_HALO,
    halo,
    page,
    panel,
)
from pymunk_dragon.drawing.figures.times import (
    TimeInterval,
    closing_time,
    contact_or_end,
    describe,
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
# Free border as a fraction of half the view: for short labels at the right.
BORDER = 0.12
# Free border as a fraction of half the view: for labels on all sides.
WIDE_BORDER = 0.3
# Free border as a fraction of half the view: for dots.
DOT_BORDER = 0.04
# Length of the head's velocity arrow, as a fraction of half the view.
ARROW_FRACTION = 0.26
# Distance of a label from the centre, as a fraction of the distance of its point.
LABEL_FRACTION = 0.3
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
    curve, turns = march.curve, march.curve.turns(march.head_start)
    if not curve.inward or turns is None:
        raise ParameterError("curve", type(curve).__name__, "a Spiral inward, for this figure")
    hit = contact_or_end(march, interval)
    step = MINUTE * max(1.0, np.ceil(hit.time / MINUTE / MAX_DOTS))
    length, gone = curve.end_s - march.head_start, float(march.distance(hit.time))
    figure = page(
        8.0,
        8.6,
        f"Handle 0 has {length:.1f} m of spiral ahead of it, and gets {gone:.1f} m far",
        f"{turns:.4g} turns inward and {_rotation(march)}, {curve.turn_width:g} m apart; a dot every {step:g} s",
    )
    axes = panel(figure, 0.8, 0.65, 6.9, 6.9)
    axes.plot(*_path_from_start(march, gone, length).T, color=QUIET, lw=1.0, ls=(0, (3, 2)), gid="ahead")
    axes.plot(*_path_from_start(march, 0.0, gone).T, color=BLUE, lw=1.8, gid="walked")
    minutes = np.arange(0.0, hit.time, step)
    dots = march.curve.point(march.head_start + march.distance(minutes))
    axes.plot(*dots.T, "o", color=COLOURS.ink, ms=5, gid="minutes")
    for time, dot in zip(minutes, dots, strict=True):
        label(axes, dot[0], dot[1], f"{time:g} s", (6, 0), va="center_baseline", size=10.5, border=HALO)
    last = march.curve.point(march.head_start + gone)
    axes.plot(*last, "o", color=COLOURS.contact, ms=7, gid="last")
    # Near the centre, which the spiral leaves free.
    x, y = (LABEL_FRACTION * last).tolist()
    text = f"{describe(hit)}\n{hit.time:.2f} s"
    axes.text(x, y, text, color=COLOURS.contact, ha="center", va="center", path_effects=halo(WIDE_HALO))
    _set_limits(axes, ORIGIN, float(np.hypot(*dots[0])), BORDER)
    return figure


def trajectories(march: March, interval: TimeInterval) -> Figure:
    """Draw the trajectories of the paper's seven handles until the first contact (its figure 7)."""
    hit = contact_or_end(march, interval)
    handles = march.dragon.representatives
    begin, end = march.handles_s([interval[0], hit.time])
    # Four panels per row, including the key.
    height = 1.0 + 2.3 * np.ceil((len(handles) + 1) / 4)
    figure = page(
        8.0,
        height,
        f"All handles walk the same {'spiral' if spirals_in(march) else 'path'}, one behind the other",
        f"from where they start, at {interval[0]:g} s, to where they are at {describe(hit)}, {hit.time:.2f} s",
    )
    whole = _path(march, begin[-1], end[0], SMALL_PATH_POINTS)
    centre, reach = _extent(march, whole)
    for number, handle in enumerate([*handles, None]):
        row, column = divmod(number, 4)
        axes = panel(figure, 0.25 + 1.9 * column, height - 3.15 - 2.3 * row, 1.8, 1.8)
        _set_limits(axes, centre, reach, DOT_BORDER)
        axes.set_axis_off()
        if handle is None:
            _draw_key(axes, centre, reach)
            continue
        path = _path(march, begin[handle], end[handle], SMALL_PATH_POINTS)
        axes.plot(*whole.T, color=RULE, lw=0.5)
        axes.plot(*path.T, color=BLUE, lw=0.8, gid=f"path-{handle}")
        axes.plot(*path[0], "o", color=COLOURS.ink, mfc=COLOURS.background, ms=6, mew=1.4)
        axes.plot(*path[-1], "o", color=COLOURS.ink, ms=6)
        axes.set_title(f"handle {handle}", size=11.5, pad=3)
    return figure


def velocities(march: March, interval: TimeInterval) -> Figure:
    """Draw the velocities of the paper's seven handles at the first contact (its figure 8)."""
    time, when = last_regular_time(contact_or_end(march, interval), interval[0])
    handles = march.dragon.representatives
    states = march.at(time)
    positions, speeds = states.positions[0], states.speeds[0, handles]
    direction = f"along the spiral, inward and {_rotation(march)}" if spirals_in(march) else "along the curve"
    figure = page(
        8.0,
        8.6,
        f"The handles walk at {speeds.min():.3f} to {speeds.max():.3f} m/s {when}",
        f"{len(handles)} handles at {time:.2f} s; each one walks {direction}",
    )
    axes = panel(figure, 0.8, 0.65, 6.9, 6.9)
    centre, reach = _extent(march, positions)
    first, last = states.handles_s[0, [-1, 0]]
    axes.plot(*_path(march, first, last, PATH_POINTS).T, color=RULE, lw=1.4)
    arrows = ARROW_FRACTION * reach / states.speeds[0, 0] * states.velocities[0, handles]
    axes.quiver(
        *positions[handles].T,
        *arrows.T,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        width=0.006,
        color=COLOURS.motion,
        zorder=3,
        gid="velocities",
    )
    axes.plot(*positions[handles].T, "o", color=COLOURS.ink, ms=6, zorder=4, gid="handles")
    _set_limits(axes, centre, reach, WIDE_BORDER)
    shares = np.linspace(0, 1, 12)[:, None, None]
    taken = axes.transData.transform((positions[handles] + shares * arrows).reshape(-1, 2))
    boxes: list[Any] = []
    for handle, speed, position in zip(handles, speeds, positions[handles], strict=True):
        boxes.append(_label_without_overlap(axes, position, centre, f"handle {handle}\n{speed:.3f} m/s", taken, boxes))
    return figure


def outer_loop(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon on the outer loop, at its start."""
    return _still(march, interval[0], "on the outer loop" if spirals_in(march) else "at the start")


def inward(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon on the inward spiral, as it closes a full loop."""
    time = closing_time(march, interval[0], contact_or_end(march, interval).time)
    return _still(march, time, "moving inward" if spirals_in(march) else "on the path")


def collision(march: March, interval: TimeInterval) -> Still:
    """Return the picture of the dragon at its first contact."""
    hit = contact_or_end(march, interval, touching=True)
    run, film = _still(march, hit.time, "at the first contact")
    return replace(run, first_contact=hit.contact, outcome="contact"), film


def _still(march: March, time: float, where: str) -> Still:
    """Return the picture at `time`, s, with a title that says where the dragon is."""
    return Run.exact(march, [time]), Film(size=STILL_SIZE, title=f"{march.dragon.benches} benches {where}")


def _path_from_start(march: March, begin: float, end: float) -> Array:
    """Return points (P, 2), m, of the curve from `begin` to `end`, m from the start of handle 0."""
    return _path(march, march.head_start + begin, march.head_start + end, PATH_POINTS)


def _path(march: March, first: float, last: float, points: int) -> Array:
    """Return points (P, 2), m, of the curve between two arc-length coordinates, m."""
    return march.curve.point(np.linspace(first, last, points))


def _rotation(march: March) -> str:
    """Return the direction of rotation of handle 0 at its start."""
    return "counter-clockwise" if march.curve.curvature(march.head_start) > 0 else "clockwise"


def _extent(march: March, points: Array) -> tuple[Array, float]:
    """Return the centre (2,) and half the width, m, of a square around `points` (P, 2), or around a whole spiral."""
    if spirals_in(march):
        return ORIGIN, float(np.hypot(*points.T).max())
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, MARGIN * float((high - low).max()) / 2


def _set_limits(axes: Axes, centre: Array, reach: float, border: float) -> None:
    """Set the axes' limits to `reach`, m, on each side of `centre` (2,), plus a border."""
    from matplotlib.ticker import MaxNLocator

    half = (1 + border) * reach
    x, y = centre.tolist()
    axes.set_aspect("equal")
    axes.set_xlim(x - half, x + half)
    axes.set_ylim(y - half, y + half)
    for axis, name in ((axes.xaxis, "x (m)"), (axes.yaxis, "y (m)")):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 4, 5, 10]))
        axis.set_label_text(name)


def _label_without_overlap(
    axes: Axes, position: Array, centre: Array, text: str, taken: Array, boxes: list[Any]
) -> Any:
    """Label a dot without covering the points `taken` (P, 2) or other labels; return the label's box in pixels.

    The label is placed away from `centre` (2,), else towards it, else to a side, and on the last side in any case.
    """
    x, y = position.tolist()
    outward = (position - centre) / (np.hypot(*(position - centre)) or 1.0)
    aside = np.array([-outward[1], outward[0]])
    directions = [direction.tolist() for direction in (outward, -outward, aside, -aside)]
    for right, up in directions:
        sides = "left" if right > 0 else "right", "bottom" if up > 0 else "top"
        note = label(axes, x, y, text, (7 * right, 7 * up), *sides, zorder=5, border=HALO)
        box = note.get_window_extent()
        if not any(box.contains(*point) for point in taken) and not any(box.overlaps(other) for other in boxes):
            break
        if (right, up) != tuple(directions[-1]):
            note.remove()
    return box


def _draw_key(axes: Axes, centre: Array, reach: float) -> None:
    """Draw the key of the dots, and a scale bar."""
    x, y = centre.tolist()
    for up, text, filling in ((0.62, "at the start", COLOURS.background), (0.22, "at the end", COLOURS.ink)):
        axes.plot(x - 0.7 * reach, y + up * reach, "o", color=COLOURS.ink, mfc=filling, ms=6, mew=1.4)
        axes.annotate(text, (x - 0.5 * reach, y + up * reach), va="center_baseline", color=QUIET)
    decade = 10.0 ** np.floor(np.log10(reach))
    bar = decade * max(step for step in SCALE_BARS if step * decade <= reach)
    left = x - 0.8 * reach
    axes.plot([left, left + bar], [y - 0.3 * reach] * 2, color=QUIET, lw=1.4)
    axes.annotate(f"{bar:g} m", (left + bar / 2, y - 0.42 * reach), ha="center", va="top", color=QUIET)
