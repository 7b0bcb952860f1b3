# %% [markdown] order=50 axes="size of a cell (m)|pairs to test"
# # How many pairs have to be tested?
# Of 223 benches, 24,531 pairs could touch. Cut the floor into square cells of 0.55 m, and test only
# pairs that share a cell.

# %%
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from pymunk_dragon import Grid, March, first_contact, separation

# The dragon as its head runs into bench 8, and the edge of that bench that it hits, measured in
# cells.
march = March()
benches = march.dragon.outlines(march.at(first_contact(march).time).poses[0])
grid = Grid.of(march)  # cells as wide as the pitch, counted to the right and down


def in_cells(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """How many cells points (..., 2) are to the right of the grid's origin, and below it."""
    return (points - grid.origin) / (grid.cell, -grid.cell)


# %%
# The walk along the edge through the grid; a cell has a row and a column.
start, end = in_cells(benches[8, :2])
cells = list(grid.walk(*benches[8, :2]))
print(
    "from column {:.3f}, row {:.3f} to column {:.3f}, row {:.3f}:".format(*start, *end),
    len(cells),
    "cells",
)
print("rows and columns", *(f"({row}, {column})" for row, column in cells))

# %%
# What filing saves, and what it costs: entries of a bench in a cell.
for count in (16, 223):
    filed = grid.file(benches[:count])[0]
    pairs = grid.pairs(benches[:count])
    touching = separation(*benches[pairs.T]).distance < 1e-9
    print(
        f"{count:3} benches  {(count - 1) * (count - 2) // 2:5} pairs  {len(filed):4} entries",
        end="  ",
    )
    print(f"{len(pairs):3} pairs to test  {touching.sum()} touching")

plt.figure(figsize=(5, 4))
for bench in range(16):
    plt.fill(*in_cells(benches[bench]).T, fill=False)
for number, (row, column) in enumerate(cells, start=1):
    plt.fill_between([column, column + 1], row, row + 1, color="orange", alpha=0.5)
    plt.text(column + 0.1, row + 0.9, str(number))
plt.axis((14, 24, 17, 9))
plt.xlabel("column")
plt.ylabel("row")
plt.grid()
plt.savefig("grid.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# Only 546 of the 24,531 pairs share a cell, about 2 in 100, and nothing is missed, as two benches
# that touch share the cell where they do. The price is the filing: 223 benches have 1,997 entries.
# But ten times the benches have about ten times the entries, and a hundred times the pairs.
#
# How many pairs are left?
# - About 5: so few do nearly touch, but a cell has all that is within half a metre.
# - **About 500**: 546 pairs.
# - About 5,000: as if a bench came near to a fifth of all others; it meets only those of three
#   turns.
# ## Check
# The walk takes 6 cells: the first, and one more for each grid line that the edge crosses. Between
# columns 17.568 and 20.501 there are the lines 18, 19 and 20, and between rows 11.130 and 13.850
# the lines 12 and 13.
# ## Try
# Change the size of a cell, and note the pairs and the entries, one for each bench in each of its
# cells: which size leaves the fewest pairs, and which one the least work in all?
# ## Change
# Walk along another edge, as `benches[8, 2:]`: through how many cells does it lead?
# ## Teacher
# - From grade 9; coordinates, the number of pairs $n (n - 1) / 2$. 40 minutes: 10 to guess, 15 on
#   the stage, 15.
# - Goal: a broad phase leaves so few pairs that the work grows with the number of benches, not with
#   its square.
# - Try: the smallest cells leave the fewest pairs; pairs and entries together are fewest with cells
#   of about 1 m.
# - Mistakes: small cells are taken to be always better, though filing costs too; a shared cell is
#   taken for a contact.
# - Of 16 benches there are 105 pairs, as each bench is hinged to the one before it and any two
#   others could touch; 13 of them share a cell.
