"""Parts of several studies' figures."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon.drawing.figures.style import COLOURS, LINE_SPACING, QUIET, RULE, SHARED, slide
from pymunk_dragon.model.march import March

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Points of a line: enough to appear smooth.
POINTS = 1200
# Fractions of a slide below its title: left, bottom, width and height. And inches between panels.
BELOW_TITLE, PADDING = (0.025, 0.02, 0.95, 0.79), 0.08


def panels(title: str, subtitle: str, mosaic: list[Any], **options: Any) -> tuple[Figure, dict[str, Axes]]:
    """A slide with panels by name, laid out by matplotlib below its title."""
    figure = slide(title, subtitle)
    figure.set_layout_engine("constrained", rect=BELOW_TITLE, w_pad=PADDING, h_pad=PADDING)
    return figure, figure.subplot_mosaic(mosaic, **options)


def heading(axes: Axes, text: str, colour: str = QUIET) -> None:
    """Write the heading of a panel above its left end."""
    axes.set_title(text, loc="left", size=11.5, color=colour, linespacing=LINE_SPACING)


def plan_view(
    axes: Axes, march: March, time: float, radius: float, half: float, *, touching: Collection[int] = ()
) -> None:
    """Draw the benches at a time and the turning circle, `half` m to each side of the origin or of a touching bench."""
    poses = march.at(time).poses[0]
    x, y = poses[min(touching), :2].tolist() if touching else (0.0, 0.0)
    turn = np.linspace(0, 2 * np.pi, POINTS)
    dashed: Any = (0, (5, 3))
    axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=COLOURS.motion, lw=1.2, ls=dashed, gid="circle")
    for bench, outline in enumerate(march.dragon.outlines(poses)):
        touches = bench in touching
        if np.abs(outline - (x, y)).max(axis=1).min() < half:
            edge, face = COLOURS.contact if touches else QUIET, SHARED if bench else COLOURS.head
            style: dict[str, Any] = {"fc": face, "ec": edge, "lw": 2.0 if touches else 0.8, "zorder": 2 + touches}
            axes.fill(*outline.T, gid=f"bench-{bench}", **style)
        if touches:
            middle: Any = np.clip(poses[bench, :2], (x - 0.8 * half, y - 0.8 * half), (x + 0.8 * half, y + 0.8 * half))
            axes.text(middle[0], middle[1], str(bench), color=COLOURS.contact, ha="center", va="center", zorder=5)
    axes.set_aspect("equal")
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(visible=True, color=RULE)
