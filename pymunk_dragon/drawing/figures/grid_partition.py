"""Figure of the grid partition: cells, their indices, and the benches in them (the paper's figure 6)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import Grid
from pymunk_dragon.drawing.figures.style import CANDIDATE, COLOURS, FAINT, RULE, SHARED, SMALL, halo, key, panel, slide
from pymunk_dragon.drawing.figures.times import TimeInterval, contact_or_end
from pymunk_dragon.model.march import March

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Cells = NDArray[np.int64]

# Inches: least distance between the indices of cells.
INDEX_SPACING = 0.24
# Inches: length of the shortest bench that is labelled with its number.
MIN_NUMBERED_LENGTH = 0.45


def grid(march: March, interval: TimeInterval) -> Figure:
    """Draw the grid partition at the first contact, and the benches in its cells (the paper's figure 6)."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    hit = contact_or_end(march, interval)
    dragon, cells = march.dragon, Grid.of(march)
    poses = march.at(hit.time).poses[0]
    corners = dragon.outlines(poses)
    pairs = cells.pairs(corners)
    origin = "({:g}, {:g})".format(*cells.origin).replace("-", "\u2212")
    touching = hit.benches or ()
    apart = (dragon.benches - 1) * (dragon.benches - 2) // 2
    title = text("Of {} pairs of benches\nthat share no hole,\n{} share a cell\nand are tested").format(
        apart, len(pairs)
    )
    subtitle = text("at the end, {2:.2f} s;\ncells of {3:g} m,\ncounted from {4} m")
    if hit.status == "contact":
        subtitle = text("at the first contact of {0} and {1},\n{2:.2f} s; cells of {3:g} m,\ncounted from {4} m")
    figure = slide(
        title.format(apart, len(pairs)), subtitle.format(*(hit.benches or (0, 0)), hit.time, cells.cell, origin)
    )
    axes = panel(figure, 3.95, 0.15, 3.75, 3.75)
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
                *(across, up, str(bench)),
                color=style["color"],
                size=SMALL,
                ha="center",
                va="center",
                zorder=5,
                path_effects=halo(),
            )
    shades = ((FAINT, text("one bench")), (SHARED, text("neighbours only")), (CANDIDATE, text("candidates")))
    key(figure, [Patch(fc=shade, ec=RULE, label=name) for shade, name in shades], 0.3, 1.0)
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
        axis.set_ticks(
            ((edges[:-1] + edges[1:]) / 2)[shown], [f"{number}".replace("-", "\u2212") for number in numbers[shown]]
        )
    axes.xaxis.set_label_position("top")
    axes.set_xlabel(text("column j →"))
    axes.set_ylabel(text("← row i"))
    return scale
