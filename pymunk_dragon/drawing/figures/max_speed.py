"""Figure of the largest head speed in the turn: handle speeds over time, and positions at the time of the limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymunk_dragon.drawing.figures.lines import label
from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, FAINT, QUIET, RULE, halo, page, panel
from pymunk_dragon.model.march import March
from pymunk_dragon.studies import MaxSpeed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["max_speed"]

# m: head travel shown before the time of the limit.
DISTANCE_BEFORE = 14.0
# m: head travel shown after the time of the limit.
DISTANCE_AFTER = 26.0
# Times at which speeds are sampled: more than the line is pixels wide.
TIME_SAMPLES = 1600
# Foremost handles whose speeds are drawn individually.
DRAWN_HANDLES = 12
# Foremost handles whose largest speed is drawn: all that are in the turn.
EVALUATED_HANDLES = 28
# Half the width of the plan view, in radii of the circle.
BORDER = 1.16
# Points of the path and of the circle: enough to appear round.
PATH_POINTS = 1500


def max_speed(found: MaxSpeed) -> Figure:
    """Draw the result of the study `max_speed`."""
    first, last = found.handles[0], found.handles[-1]
    subject = f"handle {first} is" if first == last else f"handles {first} to {last} are"
    figure = page(
        8.0,
        9.4,
        f"At {found.speed:.6f} m/s of the head, {subject} at the limit of {found.limit:g} m/s once",
        f"head {found.way:.2f} m into the circle, {found.time:.2f} s after it entered; no handle is faster at any time",
    )
    _draw_speeds(panel(figure, 0.85, 5.35, 6.85, 2.75), found)
    _draw_positions(panel(figure, 2.0, 0.45, 4.1, 4.1), found)
    return figure


def _draw_speeds(axes: Axes, found: MaxSpeed) -> None:
    """Draw the speeds of the foremost handles, and the largest speed, over time."""
    title = "speeds of the foremost handles, m/s; the blue line is the fastest of all"
    axes.set_title(title, loc="left", size=11.5, color=QUIET, pad=10)
    distances = np.sort(
        np.append(np.linspace(found.way - DISTANCE_BEFORE, found.way + DISTANCE_AFTER, TIME_SAMPLES), found.way)
    )
    handles = min(EVALUATED_HANDLES, found.dragon.handles)
    speeds = found.speed * March(found.dragon, found.curve).at(distances, handles).speeds
    times = distances / found.speed
    axes.plot(times, speeds[:, 1:DRAWN_HANDLES], color=RULE, lw=0.9)
    axes.plot(times, speeds.max(axis=1), color=BLUE, lw=2.0, gid="fastest")
    axes.axhline(found.limit, color=COLOURS.contact, lw=1.0, ls=(0, (4, 3)))
    axes.plot(found.time, found.limit, "o", color=COLOURS.contact, ms=7, zorder=4, gid="limit")
    label(axes, found.time, found.limit, f"{found.time:.3f} s", (10, -4), ha="left", va="top", color=COLOURS.contact)
    axes.set_xlim(times[0], times[-1])
    axes.margins(y=0.12)
    axes.set_xlabel("time since the head entered the circle (s)")


def _draw_positions(axes: Axes, found: MaxSpeed) -> None:
    """Draw the benches in the turn at the time of the limit, with the handles' speeds."""
    curve, turn = found.curve, np.linspace(0, 2 * np.pi, PATH_POINTS)
    states = March(found.dragon, curve).at(found.way)
    half = BORDER * curve.radius
    axes.set_aspect("equal")
    axes.set_xlim(-half, half)
    axes.set_ylim(-half, half)
    axes.set_axis_off()
    axes.plot(curve.radius * np.cos(turn), curve.radius * np.sin(turn), color=COLOURS.motion, lw=1.0, ls=(0, (5, 3)))
    path = curve.point(np.linspace(-half, curve.joints[-1] + half, PATH_POINTS))
    axes.plot(*path.T, color=RULE, lw=1.2, gid="path")
    for bench, outline in enumerate(found.dragon.outlines(states.poses[0])):
        if np.abs(outline).max(axis=1).min() < half:
            axes.fill(*outline.T, fc=FAINT, ec=COLOURS.ink, lw=0.8, gid=f"bench-{bench}")
    speeds = found.speed * states.speeds[0]
    for handle, position in enumerate(states.positions[0]):
        if np.abs(position).max() > 0.93 * half:
            continue
        fastest = handle in found.handles
        colour = COLOURS.contact if fastest else COLOURS.ink
        axes.plot(*position, "o", color=colour, ms=6 if fastest else 4, zorder=4)
        axes.annotate(
            f"{speeds[handle]:.2f}",
            position.tolist(),
            (7, 5),
            textcoords="offset points",
            size=10,
            color=colour,
            zorder=5,
            path_effects=halo(),
        )
