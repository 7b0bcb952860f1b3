"""Parts of several studies' figures."""

from __future__ import annotations

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


def plan_view(axes: Axes, march: March, time: float, radius: float, half: float) -> None:
    """Draw the benches at a time and the turning circle, `half` m to each side of the origin."""
    turn = np.linspace(0, 2 * np.pi, POINTS)
    dashed: Any = (0, (5, 3))
    axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=COLOURS.motion, lw=1.2, ls=dashed, gid="circle")
    for bench, outline in enumerate(march.dragon.outlines(march.at(time).poses[0])):
        if np.abs(outline).max(axis=1).min() < half:
            face = SHARED if bench else COLOURS.head
            axes.fill(*outline.T, fc=face, ec=QUIET, lw=0.8, zorder=2, gid=f"bench-{bench}")
    axes.set_aspect("equal")
    axes.set(xlim=(-half, half), ylim=(-half, half), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(visible=True, color=RULE)
