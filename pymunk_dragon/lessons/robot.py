# %% [markdown] order=150 scene="robot-arm" axes="x (m)|y (m)"
# # Does the arm reach the end of its path?
# The 16 links of a snake arm go where the tip went before. The path bends to both sides, and ends
# in a narrow loop.

# %%
import matplotlib.pyplot as plt
import numpy as np

from pymunk_dragon import Dragon, March, first_contact, simulate
from pymunk_dragon.model.curves import Sampled

# Links from the tip to the base, in m: slender and short in front, wide and long behind.
arm = Dragon(
    head_spacing=0.14,
    body_spacing=[0.10] * 6 + [0.13] * 5 + [0.16] * 4,
    overhang=0.02,
    width=[0.05] * 7 + [0.06] * 5 + [0.07] * 4,
)
# The path, as points that were tapped on a screen; the smooth curve through them is what the tip
# follows.
points = [
    (-1.9, 0),
    (-1.6, 0),
    (-1.3, 0),
    (-1, 0),
    (-0.75, 0.08),
    (-0.5, 0.25),
    (-0.25, 0.3),
    (-0.03, 0.15),
    (0.1, -0.1),
    (0.32, -0.25),
    (0.55, -0.15),
    (0.6, 0.1),
    (0.42, 0.28),
    (0.2, 0.22),
    (0.05, 0.05),
    (-0.1, -0.1),
]
march = March(arm, Sampled(np.array(points)), speed=0.2)

# %%
# As for the dragon: does it run into itself, exactly and in Pymunk, ...
hit = first_contact(march)
run = simulate(march, frame_interval=0.1)
print(
    f"exact    t = {hit.time:.3f} s   "
    + (f"contact   links {hit.benches}" if hit.benches else "clear")
)
touch = run.first_contact
print(
    f"engine   t = {run.times[-1]:.3f} s   "
    + (f"contact   links {touch.benches}" if touch else "clear")
)

# ... and where is each joint, and how fast?
states = march.at(np.arange(0.1, hit.time - 0.1, 0.1))
speeds = states.speeds
for word, found in [("fastest", speeds.argmax()), ("slowest", speeds.argmin())]:
    now, joint = np.unravel_index(found, speeds.shape)
    print(f"{word}  joint {joint:2d}   t = {states.times[now]:.1f} s   ", end="")
    print(f"{speeds[now, joint]:.3f} m/s")
# Where the slowest one was before, and after.
for time in (states.times[now] - 0.1, states.times[now] + 0.1):
    x, y = march.at(time).positions[0, joint]
    print(f"         joint {joint:2d}   t = {time:.1f} s   at ({x:.4f}, {y:.4f}) m")

plt.figure(figsize=(5, 3))
s = np.linspace(march.curve.begin_s, march.curve.end_s, 500)
plt.plot(*march.curve.point(s).T, color="silver")
for link in arm.outlines(run.poses_at(hit.time)):
    plt.fill(*link.T, alpha=0.7)
plt.axis("equal")
plt.savefig("robot.png", bbox_inches="tight")
run

# %% [markdown]
# ## Answer
# The tip runs into link 13 after 8.67 s: this arm cannot follow this path. Until then no joint is
# more than some 3 % faster or slower than the tip: both ends of a link go equally fast along it, so
# the faster one goes more across it.
#
# Does the tip reach the end?
# - Yes: a point would get past the links that are still coming in, but links have a width.
# - **No**: it meets link 13 after 8.67 s.
# ## Check
# The slowest speed, 0.194 m/s: see where that joint was 0.1 s before and after, and divide the
# distance by 0.2 s.
# ## Try
# Let the time run, then draw a path on which the arm gets to the end, and one that it blocks. How
# narrow may a bend be?
# ## Change
# Let `points` end in (0.1, 0.05), (0.2, 0), and the tip slips past. The documentation of scenario
# files (`make docs`) describes the file that holds a dragon and its curve, for a path of your own.
# ## Teacher
# - From grade 11; Python, the lesson velocity. 60 minutes: 10 to guess, 25 on the stage, 25 to
#   compare.
# - Goal: a model that is not tied to its first example serves others: any chain on any smooth
#   curve.
# - Try: a path that keeps away from itself is free; no link can lie in a bend of a radius below
#   half of its length. While the tip turns in a narrow bend, joints are slow: down to 0.104 m/s on
#   the path of "Change".
# - Mistakes: the joints of an arm are taken to turn only, and not to move along; a path is checked
#   for its tip only.
# - Ask next: how fast is a joint compared with the tip, which goes at 0.2 m/s? As fast to 3 %, from
#   0.194 m/s to 0.204 m/s. Half as fast, as on the inside of a bend, it cannot be: all joints go
#   the same way. In the dragon's turn one handle is 1.6 times as fast, but there the curvature
#   jumps.
# - Such arms get into engines where no hand can reach.
