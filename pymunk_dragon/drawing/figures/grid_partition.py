"""Figure of the grid partition: cells, their indices, and the benches in them (the paper's figure 6)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon.collision import Grid
from pymunk_dragon.drawing.figures.lines import label
from pymunk_dragon.drawing.figures.style import (
    CANDIDATE,
    COLOURS,
    FAINT,
    RULE,
    SHARED,
    WIDE_HALO,
    halo,
    page,
    panel,
)
from pymunk_dragon.drawing.figures.times import TimeInterval, contact_or_end, describe, spirals_in
from pymunk_dragon.model.march import March

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Cells = NDArray[np.int64]

# Distance between the lines of the key, as a fraction of the axes.
KEY_STEP = 0.065
# Inches: least distance between the indices of cells.
INDEX_SPACING = 0.28
# Inches: length of the shortest bench that is labelled with its number.
MIN_NUMBERED_LENGTH = 0.5
# Colour and content of the cells.
SHADES = ((FAINT, "one bench"), (SHARED, "neighbours only"), (CANDIDATE, "candidates"))


def grid(march: March, interval: TimeInterval) -> Figure:
    """Draw the grid partition at the first contact, and the benches in its cells (the paper's figure 6)."""
    from matplotlib.colors import ListedColormap

    hit = contact_or_end(march, interval)
    dragon, cells = march.dragon, Grid.of(march)
    poses = march.at(hit.time).poses[0]
    corners = dragon.outlines(poses)
    pairs = cells.pairs(corners)
    origin = "({:g}, {:g})".format(*cells.origin).replace("-", "\u2212")
    touching = hit.benches or ()
    touch = " of {} and {}".format(*touching) if touching else ""
    apart = (dragon.benches - 1) * (dragon.benches - 2) // 2
    # The title omits these words if the numbers are long.
    of_benches = "of benches " if apart < 10_000 else ""
    figure = page(
        8.0,
        8.3,
        f"Of {apart} pairs {of_benches}that share no hole, {len(pairs)} share a cell and are tested",
        f"at {describe(hit)}{touch}, {hit.time:.2f} s; cells of {cells.cell:g} m, counted from {origin} m",
    )
    hollow = spirals_in(march)
    axes = panel(figure, 0.75, 0.3, 6.95, 6.6) if hollow else panel(figure, 0.75, 0.75, 6.95, 6.15)
    kinds, (top, left) = _kinds(cells, corners)
    rows, columns = kinds.shape
    x = cells.origin[0] + cells.cell * np.arange(left, left + columns + 1)
    y = cells.origin[1] - cells.cell * np.arange(top, top + rows + 1)
    colours = ListedColormap([COLOURS.background, FAINT, SHARED, CANDIDATE])
    axes.pcolormesh(x, y, kinds, cmap=colours, vmin=-0.5, vmax=3.5, edgecolor=RULE, lw=0.6, gid="cells")
    scale = _indices(axes, x, y, top, left)
    for bench, outline in enumerate(corners):
        hits = bench in touching
        style: dict[str, Any] = {"color": COLOURS.contact, "lw": 2.2} if hits else {"color": COLOURS.ink, "lw": 1.1}
        axes.fill(*outline.T, fill=False, gid=f"bench-{bench}", zorder=4 if hits else 3, **style)
        if dragon.lengths[bench] * scale >= MIN_NUMBERED_LENGTH:
            across, up, _ = poses[bench].tolist()
            axes.text(
                across, up, str(bench), color=style["color"], ha="center", va="center", zorder=5, path_effects=halo()
            )
    if hollow:
        # At the centre of the spiral, which has no benches.
        left_edge, top_edge = (x[0] + x[-1]) / 2 - KEY_STEP * (x[-1] - x[0]), (y[0] + y[-1]) / 2
        points = [(left_edge, top_edge + (1 - row) * KEY_STEP * (y[0] - y[-1])) for row in range(len(SHADES))]
    else:
        # Below the grid.
        axes = panel(figure, 0.75, 0.2, 6.95, 0.4)
        axes.set_axis_off()
        axes.set_xlim(0, len(SHADES))
        axes.set_ylim(-1, 1)
        points = [(column + 0.1, 0.0) for column in range(len(SHADES))]
    for (across, up), (shade, text) in zip(points, SHADES, strict=True):
        axes.plot(across, up, "s", color=shade, ms=17, mec=RULE)
        label(axes, across, up, text, (14, 0), va="center_baseline", border=WIDE_HALO if hollow else 0.0)
    return figure


def _kinds(cells: Grid, corners: Array) -> tuple[Cells, tuple[int, int]]:
    """Return the content of the cells around the benches, and the index (i, j) of the first cell.

    0: empty; 1: one bench; 2: neighbours; 3: benches that are not neighbours.
    """
    filed, benches = cells.file(corners)
    first = filed.min(axis=0) - 1
    shape = tuple(filed.max(axis=0) - first + 2)
    least, most = np.full(shape, len(corners)), np.full(shape, -1)
    where = tuple((filed - first).T)
    np.minimum.at(least, where, benches)
    np.maximum.at(most, where, benches)
    kinds = np.clip(most - least + 1, 0, 3)
    return kinds, (int(first[0]), int(first[1]))


def _indices(axes: Axes, x: Array, y: Array, top: int, left: int) -> float:
    """Set the axes' limits to the cells, label rows and columns, and return the scale in inches per m."""
    axes.set_aspect("equal")
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[-1], y[0])
    axes.apply_aspect()
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.tick_params(length=0, labelbottom=False, labeltop=True)
    box = axes.get_window_extent()
    scale = float(box.width / axes.figure.dpi / (x[-1] - x[0]))
    every = int(np.ceil(INDEX_SPACING / scale / (x[1] - x[0])))
    for axis, edges, begin in ((axes.xaxis, x, left), (axes.yaxis, y, top)):
        numbers = np.arange(begin, begin + len(edges) - 1)
        shown = numbers % every == 0
        axis.set_ticks(((edges[:-1] + edges[1:]) / 2)[shown], [str(number) for number in numbers[shown]])
    axes.xaxis.set_label_position("top")
    axes.set_xlabel("column j →")
    axes.set_ylabel("← row i")
    return scale
