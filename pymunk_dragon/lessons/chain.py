# %% [markdown] order=20
# # Where does the next handle go?
# Both handles of the head bench are on the spiral, 2.86 m apart. Handle 0 is known; handle 1 is
# where a circle about it meets the spiral.

# %%
import matplotlib.pyplot as plt
import numpy as np

from pymunk_dragon import Dragon, March, Spiral

# The arc-length coordinate s is in metres from the centre. Handle 0 has walked from turn 16 for t
# s.
t, bench = 300, 2.86
spiral = Spiral(pitch=0.55)
here = spiral.at_turn(16) + 1.0 * t
handle = spiral.point(here)

# Go in along the whole spiral, and note wherever the distance from handle 0 passes the length of
# the bench.
s = np.linspace(spiral.at_turn(22), 0, 1_000_001)
path = spiral.point(s)
beyond = np.hypot(*(path - handle).T) - bench
i = np.flatnonzero(beyond[:-1] * beyond[1:] < 0)
step = s[i + 1] - s[i]
change = beyond[i + 1] - beyond[i]
found = s[i] - beyond[i] * step / change
points = spiral.point(found)

# %%
# The points nearest to handle 0 along the path.
back = int(np.searchsorted(found, here)) - 1
print(f"{len(found)} points at {bench} m from handle 0, whose r = {np.hypot(*handle):.3f} m")
for j in range(back - 2, back + 4):
    angle = spiral.angle(found[j]) - spiral.angle(here)
    turns = angle / (2 * np.pi)
    x, y = points[j]
    print(f"{turns:6.3f} turns back  arc {here - found[j]:7.3f} m  ", end="")
    print(f"r = {np.hypot(x, y):.3f} m  ({x:.4f}, {y:7.4f}) m")
march = March(Dragon(head_spacing=bench), spiral)
x, y = march.at(t).positions[0, 1]
print(f"March's handle 1                              ({x:.4f}, {y:7.4f}) m")

plt.figure(figsize=(5, 5))
plt.plot(*path[::100].T, "silver")
turn = np.linspace(0, 2 * np.pi, 361)
circle_x = handle[0] + bench * np.cos(turn)
circle_y = handle[1] + bench * np.sin(turn)
plt.plot(circle_x, circle_y, "black")
plt.plot(*points.T, "o")
for j, name in ((back, "next"), (back - 2, "out"), (back + 2, "in")):
    plt.plot(*np.transpose([handle, points[j]]), "o-", label=name)
plt.axis("equal")
plt.legend(loc="upper right")
plt.savefig("chain.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# The circle meets the spiral 22 times, always 2.86 m away in a straight line. The first one back
# along the path is meant, 2.900 m along it. The two beside it on the circle, less than 0.6 m off,
# are one turn further out or in: no walk takes the bench there, but a solver with a bad guess does.
#
# How often do they meet?
# - 2 times: so often a circle meets a straight line or another circle.
# - 6 times: as if only the turns next to handle 0 were near enough.
# - **22 times**: each of the turns that are less than 2.86 m further in or out is met twice.
# ## Check
# The arc, 2.900 m: the path is nearly a circle of the radius $R = (4.992 + 5.043) / 2$ m, and the
# arc over a chord of 2.86 m is $2 R \arcsin(2.86 / (2 R))$, with the arcsine in radians.
# ## Try
# Drag the next handle to where you expect it: how large is your error? Then drag it once round the
# circle: how many of its points lie on the spiral, and why is only one of them the next handle? Try
# again with handle 0 near the centre.
# ## Change
# Set `bench` to 1.65, as of all benches but the head: how many points are there, and how much
# longer is the arc? Then put it back and set `t` to 400: now the centre lies within the circle, and
# the number is odd. Why?
# ## Teacher
# - From grade 10; circle, chord and arc. 40 minutes: 10 to draw and guess, 15 on the stage, 15 to
#   compare.
# - Goal: an equation with many solutions needs a rule that selects one, and a solver needs a good
#   first guess.
# - Try: the second point lies a turn further in or out; no walk takes the bench there.
# - Mistakes: chord and arc are taken for the same; a solver's result is believed because it solves
#   the equation.
# - Ask next: is the path from one handle to the other 2.86 m as well, or 4 cm longer, or 40 cm? It
#   is 4 cm longer: the bench is a chord, and the path between its ends is bent. So much as 40 cm it
#   would be on a circle with a radius of 1.9 m; here it is 5 m.
