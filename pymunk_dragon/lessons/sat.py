# %% [markdown] order=40 axes="angle (degrees)|gap between the shadows (m)"
# # From how many sides must one look?
# Two benches are rectangles at any angle. A lamp far away throws their shadows on a wall: light
# between the shadows proves that they are apart.

# %%
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from pymunk_dragon import outlines, separation

length = 2.20  # m
width = 0.30  # m
# The other bench, B, turns so far aside and ahead of bench A, m.
aside = 1.60
ahead = 0.90
names = ["along A", "across A", "along B", "across B"]


def benches(degrees: float) -> NDArray[np.float64]:
    """Corners of both benches, of which B is turned: (2 benches, 4 corners, x and y)."""
    b = (aside, ahead, np.radians(degrees))
    return outlines([(0, 0, 0), b], [length, length], width)


def gaps(degrees: float) -> NDArray[np.float64]:
    """Gaps of the shadows on the axes along all edges, m; below zero the shadows overlap."""
    corners = benches(degrees)
    edges = corners[:, [1, 3]] - corners[:, [0]]
    axes = (edges / [[length], [width]]).reshape(4, 2)
    seen = corners @ axes.T  # how far each corner is along each axis
    begins = seen.min(axis=1)
    ends = seen.max(axis=1)
    return np.array(np.maximum(begins[1] - ends[0], begins[0] - ends[1]))


# %%
# The widest of the four gaps, and what the library says of the same benches.
for turn in range(30, 180, 30):
    found = gaps(turn)
    apart = separation(*benches(turn)).distance
    print(f"{turn:3} deg  widest gap {found.max():7.4f} m  ", end="")
    print(f"{names[found.argmax()]:8}  separation {apart:7.4f} m")

turns = range(181)
plt.figure(figsize=(5, 3.5))
curves = [gaps(turn) for turn in turns]
plt.plot(turns, curves, label=names[: len(gaps(0))])
plt.axhline(0, color="black", lw=0.8)
plt.xlabel("angle of B (degrees)")
plt.ylabel("gap (m)")
plt.legend()
plt.savefig("sat.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# Where two rectangles are apart, a straight line fits between them, which can be shifted and turned
# until it runs along an edge of one of them; and the edges of both run in only four directions. It
# may be just one of the four that shows a gap, as at 120 degrees; at 60 none is left.
#
# How many walls are always enough?
# - 2: so it is for upright rectangles, as windows on a screen.
# - **4**: along and across each bench.
# - 8: both have eight edges, but opposite edges are parallel.
# - All around: it seems that to find a gap you must search all directions.
# ## Check
# The gap at 30 degrees, 0.0701 m: the middle of B is 0.90 m above that of A; take off half the
# width of A, 0.15 m, and half the shadow of B, $1.10 \sin 30^\circ + 0.15 \cos 30^\circ$. Both
# benches are 2.20 m long and 0.30 m wide.
# ## Try
# Drag and turn the benches, and add walls. With how many walls can the benches be apart without
# light on any of them? With enough of them: how many have light just before the benches touch, and
# does a fifth wall ever show more?
# ## Change
# Let `gaps` return `np.maximum(...)[:2]`, without the axes of B: at which angle is the verdict
# wrong?
# ## Teacher
# - From grade 9; rectangles, sine and cosine. 40 minutes: 5 to guess, 20 on the stage, 15 to
#   compare.
# - Goal: two convex polygons are disjoint exactly if their projections on the normal of one of
#   their edges are.
# - Try: with three or fewer. Just before they touch, one of four walls has light, at 0° or 90° two.
#   A fifth is useless.
# - Mistakes: an overlap of the shadows in one direction is taken for a contact; x and y are taken
#   to be enough.
