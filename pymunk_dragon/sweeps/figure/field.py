"""The page of a map over two axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pymunk_dragon.drawing.figures.room import Room
from pymunk_dragon.drawing.figures.style import COLOURS, page, panel
from pymunk_dragon.sweeps.figure.pages import (
    LABELS,
    LEFT,
    TOP,
    WIDTH,
    Content,
    colour_bar,
    heading,
    jump_entry,
    legend,
    legend_height,
    levels,
    tint_entries,
    words,
)
from pymunk_dragon.sweeps.figure.panels import (
    MAX_DOTS,
    draw_contours,
    draw_field,
    draw_jumps,
    draw_names,
    draw_reference,
    label_contours,
    put_reference,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Inches: sides of the panel.
ACROSS, UP = 5.65, 4.5
# Inches: from the panel to the colour bar, and width of the bar.
BAR_GAP, BAR_WIDTH = 0.25, 0.2


def field_page(content: Content) -> Figure:
    """Draw values over two axes."""
    bottom = legend_height(1 + len(content.tints))
    figure = page(WIDTH, TOP + UP + bottom, content.title, content.subtitle)
    axes = panel(figure, LEFT, bottom, ACROSS, UP)
    axes.set(xlim=content.limits[0], ylim=content.limits[1], xlabel=words(content.names[0]))
    heading(axes, words(content.names[1]))
    samples, norm, room = content.samples, content.norm, Room(axes)
    if samples.coloured.any():
        colour_bar(figure, content, (LEFT + ACROSS + BAR_GAP, bottom, BAR_WIDTH, UP), "vertical")
    found = draw_field(axes, content.points, samples, norm)
    if found is not None:
        draw_jumps(axes, found.jumps)
        room.take(found.jumps)
        room.take(found.border)
    if (at := content.reference_at(0, 1)) is not None:
        draw_reference(axes, at[0], at[1])
        put_reference(axes, at[0], at[1], room)
    if found is None:
        legend(figure, tint_entries(content, set(), points=True), top=bottom - LABELS)
        return figure
    contours = draw_contours(axes, found, samples, levels(*content.range), room)
    named = draw_names(axes, content.points, found, samples, norm, room)
    label_contours(axes, contours, norm, room)
    if len(content.points) <= MAX_DOTS:
        dots: dict[str, Any] = {"color": COLOURS.ink, "ms": 1.6, "mew": 0.0, "alpha": 0.6}
        axes.plot(*content.points.T, "o", **dots, clip_on=False, zorder=2.5, gid="points")
    jumps = [jump_entry(content)] if len(found.jumps) else []
    legend(figure, jumps + tint_entries(content, named), top=bottom - LABELS)
    return figure
