"""The speed limit in the turn: who is how fast when, and where everybody is at the fastest moment."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymunk_dragon.march import March
from pymunk_dragon.render.figures.lines import label
from pymunk_dragon.render.figures.style import BLUE, COLOURS, FAINT, QUIET, RULE, halo, page, panel
from pymunk_dragon.studies import MaxSpeed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["speed_limit"]

# m of the head's way before and after the fastest moment that are shown, and moments looked at.
BEFORE, AFTER, MOMENTS = 14.0, 26.0, 1600
# Handles whose speeds are drawn by themselves, and those behind them that are in the turn as well.
SHOWN, REST = 12, 28
# Radii of the circle that the ground shows, and points of the path.
BORDER, POINTS = 1.16, 1500


def speed_limit(found: MaxSpeed) -> Figure:
    """The answer of `max_speed`."""
    first, last = found.handles[0], found.handles[-1]
    who = f"handle {first} is" if first == last else f"handles {first} to {last} are"
    figure = page(
        8.0,
        9.4,
        f"At {found.speed:.6f} m/s of the head, {who} at the limit of {found.limit:g} m/s once",
        f"head {found.way:.2f} m into the circle, {found.time:.2f} s after it entered; no handle is faster at any time",
    )
    _over_time(panel(figure, 0.85, 5.35, 6.85, 2.75), found)
    _ground(panel(figure, 2.0, 0.45, 4.1, 4.1), found)
    return figure


def _over_time(axes: Axes, found: MaxSpeed) -> None:
    """Speeds of the foremost handles, and the fastest of all."""
    title = "speeds of the foremost handles, m/s; the blue line is the fastest of all"
    axes.set_title(title, loc="left", size=11.5, color=QUIET, pad=10)
    ways = np.sort(np.append(np.linspace(found.way - BEFORE, found.way + AFTER, MOMENTS), found.way))
    handles = min(REST, found.dragon.handles)
    speeds = found.speed * March(found.dragon, found.curve).at(ways, handles).speeds
    times = ways / found.speed
    axes.plot(times, speeds[:, 1:SHOWN], color=RULE, lw=0.9)
    axes.plot(times, speeds.max(axis=1), color=BLUE, lw=2.0, gid="fastest")
    axes.axhline(found.limit, color=COLOURS.contact, lw=1.0, ls=(0, (4, 3)))
    axes.plot(found.time, found.limit, "o", color=COLOURS.contact, ms=7, zorder=4, gid="limit")
    label(axes, found.time, found.limit, f"{found.time:.3f} s", (10, -4), ha="left", va="top", color=COLOURS.contact)
    axes.set_xlim(times[0], times[-1])
    axes.margins(y=0.12)
    axes.set_xlabel("time since the head entered the circle (s)")


def _ground(axes: Axes, found: MaxSpeed) -> None:
    """Where the benches in the turn are at that moment, and how fast the handles."""
    curve, turn = found.curve, np.linspace(0, 2 * np.pi, POINTS)
    states = March(found.dragon, curve).at(found.way)
    half = BORDER * curve.radius
    axes.set_aspect("equal")
    axes.set_xlim(-half, half)
    axes.set_ylim(-half, half)
    axes.set_axis_off()
    axes.plot(curve.radius * np.cos(turn), curve.radius * np.sin(turn), color=COLOURS.motion, lw=1.0, ls=(0, (5, 3)))
    path = curve.point(np.linspace(-half, curve.joints[-1] + half, POINTS))
    axes.plot(*path.T, color=RULE, lw=1.2, gid="path")
    for bench, outline in enumerate(found.dragon.outlines(states.poses[0])):
        if np.abs(outline).max(axis=1).min() < half:
            axes.fill(*outline.T, fc=FAINT, ec=COLOURS.ink, lw=0.8, gid=f"bench-{bench}")
    speeds = found.speed * states.speeds[0]
    for handle, place in enumerate(states.positions[0]):
        if np.abs(place).max() > 0.93 * half:
            continue
        fastest = handle in found.handles
        colour = COLOURS.contact if fastest else COLOURS.ink
        axes.plot(*place, "o", color=colour, ms=6 if fastest else 4, zorder=4)
        axes.annotate(
            f"{speeds[handle]:.2f}",
            place.tolist(),
            (7, 5),
            textcoords="offset points",
            size=10,
            color=colour,
            zorder=5,
            path_effects=halo(),
        )
