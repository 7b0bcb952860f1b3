"""The number of pairs of benches that have to be tested for contact."""

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon import Dragon, Grid, March, first_contact, separation
from pymunk_dragon.drawing.figures.style import BLUE, CANDIDATE, COLOURS, QUIET, RULE, halo
from pymunk_dragon.lessons import Lesson

lesson = Lesson("grid", "How many pairs have to be tested?", order=50)

lesson.question(
    "Each bench is hinged to the one before it; any two others could touch. Of 16 benches these are 105 pairs, of 223 "
    "benches 24531. Must all of them be tested at every moment, if most are metres apart?"
)
lesson.predict(
    "Cut the floor into square cells, file every bench in the cells that it touches, and test only benches that "
    "share a cell.",
    ("How many of the 24531 pairs are left?", "about 5", "about 500", "about 5000"),
)

# The dragon as its head runs into bench 8, and the edge of that bench that it hits, measured in cells.
march = March(Dragon(benches=223))
benches = march.dragon.outlines(march.at(first_contact(march).time).poses[0])
grid = Grid.of(march)  # cells as wide as the pitch, 0.55 m, counted to the right and down


def in_cells(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """How many cells points (..., 2) are to the right of the grid's origin, and below it."""
    return (points - grid.origin) / (grid.cell, -grid.cell)


# The walk: of the next upright and the next level grid line, cross the one that comes first on the edge.
start, end = in_cells(benches[8, :2])
cell, step = np.floor(start), np.sign(end - start)
share = (cell + (step > 0) - start) / (end - start)  # of the edge, up to either of these lines
cells = [cell.copy()]
for _ in range(int(abs(np.floor(end) - cell).sum())):
    crossed = share.argmin()
    cell[crossed] += step[crossed]
    share[crossed] += 1 / abs(end - start)[crossed]
    cells.append(cell.copy())
print("from column {:.3f}, row {:.3f} to column {:.3f}, row {:.3f}:".format(*start, *end), len(cells), "cells")
print("our walk ", *(f"({row:.0f}, {column:.0f})" for column, row in cells))
print("Grid.walk", *(f"({row}, {column})" for row, column in grid.walk(*benches[8, :2])))

# What filing saves, and what it costs: entries of a bench in a cell.
for count in (16, 223):
    filed, pairs = grid.file(benches[:count])[0], grid.pairs(benches[:count])
    touching = separation(*benches[pairs.T]).distance < 1e-9
    print(f"{count:3} benches  {(count - 1) * (count - 2) // 2:5} pairs  {len(filed):4} entries", end="  ")
    print(f"{len(pairs):3} pairs to test  {touching.sum()} touching")

figure, axes = lesson.subplots(figsize=(5.2, 4.1))
for number, (column, row) in enumerate(cells, start=1):
    axes.fill_between([column, column + 1], row, row + 1, color=CANDIDATE, alpha=0.6, lw=0)
    axes.text(column + 0.08, row + 0.92, str(number), path_effects=halo(), zorder=4)
for bench in range(16):
    axes.fill(*in_cells(benches[bench]).T, fill=False, color=COLOURS.ink if bench in (0, 8) else QUIET)
axes.annotate("", end, start, arrowprops={"color": BLUE, "width": 2, "headwidth": 9})
(left, top), (right, bottom) = np.min(cells, axis=0) - 1, np.max(cells, axis=0) + 2
axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="column", ylabel="row", aspect="equal")
axes.grid(color=RULE)
lesson.show(figure)

lesson.picture("The edge of bench 8 that the head hits, and its cells in the order of the walk.")
lesson.answer(
    "Only 13 of the 105 pairs share a cell, and 546 of the 24531, about 2 in 100: nothing is missed, as two benches "
    "that touch share the cell where they do. The price is the walk, which files 223 benches under 1997 entries, but "
    "ten times the benches have about ten times the entries, and a hundred times the pairs.",
    ("about 500", "546 pairs"),
)
lesson.check(
    "The walk takes 6 cells: the first, and one more for each grid line that the edge crosses. Between columns 17.568 "
    "and 20.501 there are the lines 18, 19 and 20, and between rows 11.130 and 13.850 the lines 12 and 13."
)
lesson.change(
    "Set `grid` to `Grid(cell=0.1)` and to `Grid(cell=2.2)`: which one leaves fewer pairs, and which one has fewer "
    "entries? Then walk along another edge, as `benches[8, 2:]`: does our walk go backward too?"
)
