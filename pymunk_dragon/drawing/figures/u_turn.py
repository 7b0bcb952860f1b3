"""Figure of the turn of question 4 and the shortest turn found: both paths with the dragon, and handle speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon.drawing.figures.lines import label
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS, FAINT, QUIET, RULE, page, panel
from pymunk_dragon.model.march import March
from pymunk_dragon.studies import TurnAnswer

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["u_turn"]

# m: distance of the head beyond the end of the turn at the time that is drawn.
EXIT_DISTANCE = 3.0
# m: ground shown around the circle.
BORDER = 1.5
# m: head travel before it enters the circle for which speeds are drawn.
DISTANCE_BEFORE = 5.0
# m: head travel after it enters the circle for which speeds are drawn.
DISTANCE_AFTER = 35.0
# Points of a line: enough for smooth curves.
LINE_POINTS = 1200


def u_turn(found: TurnAnswer) -> Figure:
    """Draw the result of the study `u_turn`."""
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
        _draw_plan_view(axes, found, march, joints, colour)
    _draw_speeds(panel(figure, 0.85, 0.65, 6.85, 1.9), found)
    return figure


def _draw_plan_view(axes: Axes, found: TurnAnswer, march: March, joints: tuple[float, ...], colour: str) -> None:
    """Draw a turn between both spirals, and the dragon as it leaves the turn."""
    half = found.turn.radius + BORDER
    axes.set_aspect("equal")
    axes.set(xlim=(-half, half), ylim=(-half, half), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(visible=True, color=RULE)
    turn = np.linspace(0, 2 * np.pi, LINE_POINTS)
    axes.plot(
        found.turn.radius * np.cos(turn),
        found.turn.radius * np.sin(turn),
        color=COLOURS.motion,
        lw=1.0,
        ls=(0, (5, 3)),
        gid="circle",
    )
    dragon, head = march.dragon, joints[-1] + EXIT_DISTANCE
    for bench, outline in enumerate(dragon.outlines(march.at(march.time(head)).poses[0])):
        if np.abs(outline).max(axis=1).min() < half:
            fill = COLOURS.head if bench == 0 else FAINT
            axes.fill(*outline.T, fc=fill, ec=QUIET, lw=0.8, zorder=2, gid=f"bench-{bench}")
    for since, until, line in ((-60.0, 0.0, RULE), (joints[-1], joints[-1] + 60.0, RULE), (0.0, joints[-1], colour)):
        path = march.curve.point(np.linspace(since, until, LINE_POINTS))
        axes.plot(*path.T, color=line, lw=2.4 if line == colour else 1.2, zorder=3 if line == colour else 1)
    axes.plot(*march.curve.point(joints).T, "o", color=colour, ms=5, zorder=4, gid="joints")
    # Labels of entry and exit are on the side without benches.
    for name, joint, side in (("enters", 0, 1), ("leaves", -1, -1)):
        point = march.curve.point(joints[joint])
        note: dict[str, Any] = {"ha": "left" if side > 0 else "right", "va": "center", "color": QUIET}
        label(axes, point[0], point[1], name, (13 * side, 12 * side), zorder=5, **note)


def _draw_speeds(axes: Axes, found: TurnAnswer) -> None:
    """Draw the largest ratio of handle speed to head speed over the head's distance travelled."""
    axes.set_title("fastest handle, times the head's speed", loc="left", size=11.5, color=QUIET, pad=8)
    distances = np.linspace(-DISTANCE_BEFORE, DISTANCE_AFTER, LINE_POINTS)
    for march, colour, gid in ((found.march, BLUE, "speeds"), (found.short_march, AMBER, "short-speeds")):
        if march is None:
            continue
        speeds = march.at(march.time(distances)).speeds
        axes.plot(distances, (speeds / speeds[:, :1]).max(axis=1), color=colour, lw=1.8, gid=gid)
    axes.axhline(found.allowed, color=COLOURS.contact, lw=1.0, ls=(0, (5, 3)), gid="allowed")
    label(axes, DISTANCE_AFTER, found.allowed, f"{found.allowed:.4g}", (0, 4), ha="right", color=COLOURS.contact)
    axes.set_xlim(-DISTANCE_BEFORE, DISTANCE_AFTER)
    axes.set_ylim(0.98, None)
    axes.set_xlabel("the head's way since it entered the circle (m)")
