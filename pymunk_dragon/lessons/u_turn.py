# %% [markdown] order=130 axes="ratio of the radii|length of the turn (m)"
# # Which turn is shorter?
# Two dragons turn in a circle, each on two arcs: one on a wide and a narrow arc, one on equal arcs.
# Both enter at once.

# %%
import matplotlib.pyplot as plt
import numpy as np

from pymunk_dragon import UTurn

# The length is measured: 100,000 small steps from where the circle is entered to where it is left.
plt.figure(figsize=(5, 5))
for ratio in (0.5, 1.0, 1.5, 2.0, 4.0):
    turn = UTurn(pitch=1.7, radius=4.5, ratio=ratio)
    points = turn.point(np.linspace(0, turn.joints[-1], 100_001))
    length = np.hypot(*np.diff(points, axis=0).T).sum()
    first, second = turn.radii
    angles = np.degrees(np.abs(turn.sweeps))
    print(f"radii {first:.3f} and {second:.3f} m  ", end="")
    print(f"angles {angles[0]:.1f} and {angles[1]:.1f} degrees  length {length:.4f} m")
    plt.plot(*points.T, label=f"{ratio:g} to 1")
plt.axis("equal")
plt.legend()
plt.savefig("u-turn.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# Each head leaves opposite to where it came in, and in the same direction, so the one arc turns it
# by as much as the other turns it back, 173.1 degrees. Arcs of the same angle have the same shape,
# so both are the same number of times as long as their chords, and these share out the diameter.
#
# Which one leaves first?
# - Unequal arcs: the second arc is a short cut, but the first one is longer by as much.
# - Equal arcs: what is even is often shortest, as a square among rectangles, but not here.
# - **Both at once**: after 13.62 m each.
# ## Check
# The length, 13.62 m: the path enters at $a = \arctan(2 \pi \cdot 4.5 / 1.7) = 1.5107$ radians to
# the diameter, which is half the angle of an arc. So an arc is $a / \sin a$ times as long as its
# chord, both chords together are 9 m, and the length is $9 a / \sin a$.
# ## Try
# Let the time run until both heads are out of the circle: who was first, and how far did each walk
# on its arcs? Then drag the point at which your arcs meet: what becomes of the two lengths, and of
# the sum?
# ## Change
# Set `pitch` to 0.5 and to 5: does the length still not depend on the ratio?
# ## Teacher
# - From grade 11; arcs and chords, similar figures, tangents. 40 minutes: 5 to guess, 20 on the
#   stage, 15 to compare.
# - Goal: arcs of the same angle are similar, so their total length depends only on the sum of their
#   chords.
# - Try: both lengths change, but their sum stays 13.62 m.
# - Mistakes: a smaller radius is taken to mean a shorter path; the angles are taken to depend on
#   the radii.
# - In the contest the dragon comes in on a spiral of 1.7 m a turn, goes round within a circle 9 m
#   wide on two arcs that touch each other and both spirals, and out again; there the first arc has
#   twice the radius of the second.
