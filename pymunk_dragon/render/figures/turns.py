"""The turn of question 4 and the shortest one that was found: both paths with the dragon on them, and its speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon.march import March
from pymunk_dragon.render.figures.lines import label
from pymunk_dragon.render.figures.style import AMBER, BLUE, COLOURS, FAINT, QUIET, RULE, page, panel
from pymunk_dragon.studies import TurnAnswer

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["turns"]

# m: how far the head is beyond the turn where the dragon is drawn, and what is seen around the circle.
BEYOND, AROUND = 3.0, 1.5
# m of the head's way over which speeds are drawn: before the circle and after its entry.
BEFORE, AFTER = 5.0, 35.0
# Points of a line.
POINTS = 1200


def turns(found: TurnAnswer) -> Figure:
    """The answer of `u_turn`."""
    panels = [(0.3, found.march, found.turn.joints, f"two arcs, {found.turn.length:.4f} m", BLUE)]
    title = f"The turn is {found.turn.length:.4f} m long on any two arcs"
    note = f"no handle goes more than {found.allowed:.4g} times as fast as the head"
    if found.shortest is not None and found.short_march is not None:
        short = found.shortest.turn
        saved = 100 * (1 - short.length / found.turn.length)
        name = f"{len(short.lengths)} arcs, {short.length:.4f} m"
        panels.append((4.1, found.short_march, short.path.joints, name, AMBER))
        title += f"; {len(short.lengths)} can do with {saved:.0f} % less"
        note = "the best found on which " + note
    figure = page(8.0, 8.0, title, note)
    for left, march, joints, title, colour in panels:
        axes = panel(figure, left, 3.2, 3.6, 3.6)
        axes.set_title(title, loc="left", size=11.5, color=colour, pad=6)
        _ground(axes, found, march, joints, colour)
    _speeds(panel(figure, 0.85, 0.65, 6.85, 1.9), found)
    return figure


def _ground(axes: Axes, found: TurnAnswer, march: March, joints: tuple[float, ...], colour: str) -> None:
    """A turn between both spirals inside the circle, and the dragon as it leaves."""
    half = found.turn.radius + AROUND
    axes.set_aspect("equal")
    axes.set(xlim=(-half, half), ylim=(-half, half), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(visible=True, color=RULE)
    turn = np.linspace(0, 2 * np.pi, POINTS)
    axes.plot(
        found.turn.radius * np.cos(turn),
        found.turn.radius * np.sin(turn),
        color=COLOURS.motion,
        lw=1.0,
        ls=(0, (5, 3)),
        gid="circle",
    )
    dragon, head = march.dragon, joints[-1] + BEYOND
    for bench, outline in enumerate(dragon.outlines(march.at(march.time(head)).poses[0])):
        if np.abs(outline).max(axis=1).min() < half:
            fill = COLOURS.head if bench == 0 else FAINT
            axes.fill(*outline.T, fc=fill, ec=QUIET, lw=0.8, zorder=2, gid=f"bench-{bench}")
    for since, until, line in ((-60.0, 0.0, RULE), (joints[-1], joints[-1] + 60.0, RULE), (0.0, joints[-1], colour)):
        path = march.curve.point(np.linspace(since, until, POINTS))
        axes.plot(*path.T, color=line, lw=2.4 if line == colour else 1.2, zorder=3 if line == colour else 1)
    axes.plot(*march.curve.point(joints).T, "o", color=colour, ms=5, zorder=4, gid="joints")
    # Beside entry and exit, on the side where no bench is.
    for name, place, side in (("enters", 0, 1), ("leaves", -1, -1)):
        point = march.curve.point(joints[place])
        note: dict[str, Any] = {"ha": "left" if side > 0 else "right", "va": "center", "color": QUIET}
        label(axes, point[0], point[1], name, (13 * side, 12 * side), zorder=5, **note)


def _speeds(axes: Axes, found: TurnAnswer) -> None:
    """The highest speed of any handle over that of the head, by the head's way."""
    axes.set_title("fastest handle, times the head's speed", loc="left", size=11.5, color=QUIET, pad=8)
    ways = np.linspace(-BEFORE, AFTER, POINTS)
    for march, colour, gid in ((found.march, BLUE, "speeds"), (found.short_march, AMBER, "short-speeds")):
        if march is None:
            continue
        speeds = march.at(march.time(ways)).speeds
        axes.plot(ways, (speeds / speeds[:, :1]).max(axis=1), color=colour, lw=1.8, gid=gid)
    axes.axhline(found.allowed, color=COLOURS.contact, lw=1.0, ls=(0, (5, 3)), gid="allowed")
    label(axes, AFTER, found.allowed, f"{found.allowed:.4g}", (0, 4), ha="right", color=COLOURS.contact)
    axes.set_xlim(-BEFORE, AFTER)
    axes.set_ylim(0.98, None)
    axes.set_xlabel("the head's way since it entered the circle (m)")
