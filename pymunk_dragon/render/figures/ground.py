"""Figures that are seen from above: the spiral, the ways and the velocities of handles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.curves import Spiral
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.render.figures.style import (
    BLUE,
    COLOURS,
    QUIET,
    RULE,
    WIDE_HALO,
    halo,
    page,
    panel,
)
from pymunk_dragon.render.figures.times import Stretch, ending, in_words, last_look, spirals_in

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["spiral", "trajectories", "velocities"]

Array = NDArray[np.float64]

# Points of a way, spread over its angle: some 150 on each of the seed's turns, between which a line looks round.
WAY_POINTS = 2400
# A panel of seven is a quarter as wide.
SMALL_WAY_POINTS = 900
# s; and dots at whole minutes on a way, at most.
MINUTE, MOST_DOTS = 60.0, 10
# Free borders of a ground, as shares of its half: for short type at the right, for type all round, for a dot.
BORDER, WIDE_BORDER, DOT_BORDER = 0.12, 0.3, 0.04
# Metres of an arrow for each metre per second, as a share of the ground's half.
ARROW = 0.26
# How far from the centre type in the middle is, as a share of the way to what it names.
CENTRAL = 0.3
# Lengths of a scale bar, in powers of ten: the longest that is no longer than half of a ground.
SCALE_BARS = (1.0, 2.0, 5.0)
# Room for dots around points that fill a square.
MARGIN = 1.08
CENTRE = np.zeros(2)


def spiral(march: March, look: Stretch) -> Figure:
    """The spiral that handle 0 walks (the paper's figure 2)."""
    curve = march.curve
    if not isinstance(curve, Spiral) or curve.outward:
        raise ParameterError("curve", type(curve).__name__, "a Spiral inward, for this figure")
    hit = ending(march, look)
    step = MINUTE * max(1.0, np.ceil(hit.time / MINUTE / MOST_DOTS))
    turns = float(curve.angle(march.head_start)) / (2 * np.pi)
    length, gone = curve.end - march.head_start, float(march.distance(hit.time))
    figure = page(
        8.0,
        8.6,
        f"Handle 0 has {length:.1f} m of spiral ahead of it, and gets {gone:.1f} m far",
        f"{turns:.4g} turns inward and {_rotation(march)}, {curve.pitch:g} m apart; a dot every {step:g} s",
    )
    axes = panel(figure, 0.8, 0.65, 6.9, 6.9)
    axes.plot(*_way(march, gone, length).T, color=QUIET, lw=1.0, ls=(0, (3, 2)), gid="ahead")
    axes.plot(*_way(march, 0.0, gone).T, color=BLUE, lw=1.8, gid="walked")
    minutes = np.arange(0.0, hit.time, step)
    dots = march.curve.point(march.head_start + march.distance(minutes))
    axes.plot(*dots.T, "o", color=COLOURS.ink, ms=5, gid="minutes")
    for time, dot in zip(minutes, dots, strict=True):
        _note(axes, dot, f"{time:g} s")
    last = march.curve.point(march.head_start + gone)
    axes.plot(*last, "o", color=COLOURS.contact, ms=7, gid="last")
    # In the middle, where the spiral leaves room.
    x, y = (CENTRAL * last).tolist()
    text = f"{in_words(hit)}\n{hit.time:.2f} s"
    axes.text(x, y, text, color=COLOURS.contact, ha="center", va="center", path_effects=halo(WIDE_HALO))
    _frame(axes, CENTRE, float(np.hypot(*dots[0])), BORDER)
    return figure


def trajectories(march: March, look: Stretch) -> Figure:
    """The ways of the paper's seven handles until the first contact (its figure 7)."""
    hit = ending(march, look)
    handles = march.dragon.representatives
    begin, end = march.parameters([look[0], hit.time])
    # Four in a row, the key among them.
    height = 1.0 + 2.3 * np.ceil((len(handles) + 1) / 4)
    figure = page(
        8.0,
        height,
        f"All handles walk the same {'spiral' if spirals_in(march) else 'path'}, one behind the other",
        f"from where they start, at {look[0]:g} s, to where they are at {in_words(hit)}, {hit.time:.2f} s",
    )
    whole = _between(march, begin[-1], end[0], SMALL_WAY_POINTS)
    centre, reach = _ground(march, whole)
    for place, handle in enumerate([*handles, None]):
        row, column = divmod(place, 4)
        axes = panel(figure, 0.25 + 1.9 * column, height - 3.15 - 2.3 * row, 1.8, 1.8)
        _frame(axes, centre, reach, DOT_BORDER)
        axes.set_axis_off()
        if handle is None:
            _way_key(axes, centre, reach)
            continue
        way = _between(march, begin[handle], end[handle], SMALL_WAY_POINTS)
        axes.plot(*whole.T, color=RULE, lw=0.5)
        axes.plot(*way.T, color=BLUE, lw=0.8, gid=f"way-{handle}")
        axes.plot(*way[0], "o", color=COLOURS.ink, mfc=COLOURS.background, ms=6, mew=1.4)
        axes.plot(*way[-1], "o", color=COLOURS.ink, ms=6)
        axes.set_title(f"handle {handle}", size=11.5, pad=3)
    return figure


def velocities(march: March, look: Stretch) -> Figure:
    """Velocity vectors of the paper's seven handles at the first contact (its figure 8)."""
    time, when = last_look(ending(march, look), look[0])
    handles = march.dragon.representatives
    states = march.at(time)
    places, speeds = states.positions[0], states.speeds[0, handles]
    way = f"along the spiral, inward and {_rotation(march)}" if spirals_in(march) else "along the curve"
    figure = page(
        8.0,
        8.6,
        f"The handles walk at {speeds.min():.3f} to {speeds.max():.3f} m/s {when}",
        f"{len(handles)} handles at {time:.2f} s; each one walks {way}",
    )
    axes = panel(figure, 0.8, 0.65, 6.9, 6.9)
    centre, reach = _ground(march, places)
    first, last = states.places[0, [-1, 0]]
    axes.plot(*_between(march, first, last, WAY_POINTS).T, color=RULE, lw=1.4)
    arrows = ARROW * reach / states.speeds[0, 0] * states.velocities[0, handles]
    axes.quiver(
        *places[handles].T,
        *arrows.T,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        width=0.006,
        color=COLOURS.motion,
        zorder=3,
        gid="velocities",
    )
    axes.plot(*places[handles].T, "o", color=COLOURS.ink, ms=6, zorder=4, gid="handles")
    _frame(axes, centre, reach, WIDE_BORDER)
    shares = np.linspace(0, 1, 12)[:, None, None]
    taken = axes.transData.transform((places[handles] + shares * arrows).reshape(-1, 2))
    boxes: list[Any] = []
    for handle, speed, place in zip(handles, speeds, places[handles], strict=True):
        boxes.append(_beside(axes, place, centre, f"handle {handle}\n{speed:.3f} m/s", taken, boxes))
    return figure


def _way(march: March, begin: float, end: float) -> Array:
    """Points (P, 2) in m of the curve from `begin` to `end` m from the start of handle 0."""
    return _between(march, march.head_start + begin, march.head_start + end, WAY_POINTS)


def _between(march: March, first: float, last: float, points: int) -> Array:
    """Points (P, 2) in m of the curve between two places."""
    return march.curve.point(np.linspace(first, last, points))


def _rotation(march: March) -> str:
    """Which way round a spiral is walked inward."""
    return "counter-clockwise" if isinstance(march.curve, Spiral) and march.curve.mirrored else "clockwise"


def _ground(march: March, points: Array) -> tuple[Array, float]:
    """Centre (2,) and half the width, m, of the ground that holds `points` (P, 2); a spiral has its own centre."""
    if spirals_in(march):
        return CENTRE, float(np.hypot(*points.T).max())
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, MARGIN * float((high - low).max()) / 2


def _frame(axes: Axes, centre: Array, reach: float, border: float) -> None:
    """Show the ground as far as `reach` m from `centre` (2,), and a border."""
    from matplotlib.ticker import MaxNLocator

    half = (1 + border) * reach
    x, y = centre.tolist()
    axes.set_aspect("equal")
    axes.set_xlim(x - half, x + half)
    axes.set_ylim(y - half, y + half)
    for axis, name in ((axes.xaxis, "x (m)"), (axes.yaxis, "y (m)")):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 4, 5, 10]))
        axis.set_label_text(name)


def _note(axes: Axes, place: Array, text: str) -> None:
    """Type to the right of a dot, readable on lines."""
    x, y = place.tolist()
    axes.annotate(
        text, (x, y), (6, 0), textcoords="offset points", va="center_baseline", size=10.5, path_effects=halo()
    )


def _beside(axes: Axes, place: Array, centre: Array, text: str, taken: Array, boxes: list[Any]) -> Any:
    """Set type beside a dot, where it covers none of the points `taken` (P, 2) and no other type; its box, in pixels.

    Away from `centre` (2,), or else towards it, or else to a side; where nothing is free, there all the same.
    """
    x, y = place.tolist()
    outward = (place - centre) / (np.hypot(*(place - centre)) or 1.0)
    aside = np.array([-outward[1], outward[0]])
    ways = [way.tolist() for way in (outward, -outward, aside, -aside)]
    for right, up in ways:
        note = axes.annotate(
            text,
            (x, y),
            (7 * right, 7 * up),
            textcoords="offset points",
            ha="left" if right > 0 else "right",
            va="bottom" if up > 0 else "top",
            zorder=5,
            path_effects=halo(),
        )
        box = note.get_window_extent()
        if not any(box.contains(*point) for point in taken) and not any(box.overlaps(other) for other in boxes):
            break
        if (right, up) != tuple(ways[-1]):
            note.remove()
    return box


def _way_key(axes: Axes, centre: Array, reach: float) -> None:
    """What the dots of the ways mean, and how large the ground is."""
    x, y = centre.tolist()
    for up, text, filling in ((0.62, "at the start", COLOURS.background), (0.22, "at the end", COLOURS.ink)):
        axes.plot(x - 0.7 * reach, y + up * reach, "o", color=COLOURS.ink, mfc=filling, ms=6, mew=1.4)
        axes.annotate(text, (x - 0.5 * reach, y + up * reach), va="center_baseline", color=QUIET)
    decade = 10.0 ** np.floor(np.log10(reach))
    bar = decade * max(step for step in SCALE_BARS if step * decade <= reach)
    left = x - 0.8 * reach
    axes.plot([left, left + bar], [y - 0.3 * reach] * 2, color=QUIET, lw=1.4)
    axes.annotate(f"{bar:g} m", (left + bar / 2, y - 0.42 * reach), ha="center", va="top", color=QUIET)
