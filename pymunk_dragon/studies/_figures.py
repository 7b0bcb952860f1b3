"""Parts of several studies' figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon.drawing.figures.style import COLOURS, LINE_SPACING, QUIET, RULE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Points of a circle or a path: enough to appear smooth.
POINTS = 1200


def heading(axes: Axes, text: str, pad: float = 10) -> None:
    """Write the heading of a panel above its left end."""
    axes.set_title(text, loc="left", size=11.5, color=QUIET, pad=pad, linespacing=LINE_SPACING)


def square(axes: Axes, half: float, x: float = 0.0, y: float = 0.0) -> None:
    """Set up a plan view, in a frame and without a scale, of `half` m to each side of (`x`, `y`)."""
    axes.set_aspect("equal")
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(visible=True, color=RULE)


def circle(axes: Axes, radius: float, lw: float = 1.2, points: int = POINTS) -> None:
    """Draw the turning circle, dashed."""
    turn = np.linspace(0, 2 * np.pi, points)
    dashed: Any = (0, (5, 3))
    axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=COLOURS.motion, lw=lw, ls=dashed, gid="circle")
