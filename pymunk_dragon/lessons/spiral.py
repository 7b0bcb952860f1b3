# %% [markdown] order=10 axes="time (s)|turning (rad/s)"
# # How fast do you turn to watch the head?
# The head walks inward at 1 m/s. You stand in the centre and turn to face it: a round takes 55 s.

# %%
import matplotlib.pyplot as plt
import numpy as np

from pymunk_dragon import Spiral

# The spiral is r = k theta, and each turn is 0.55 m further out. The head starts on turn 16, 8.8 m
# from the centre.
spiral = Spiral(pitch=0.55)
speed = 1.0  # m/s
until = 400  # s
t = np.linspace(0, until, 100 * until + 1)
s = spiral.at_turn(16) + speed * t  # metres along the curve
theta = spiral.angle(s)
points = spiral.point(s)

# %%
# Both speeds, measured as with a stopwatch: what has changed within 0.01 s, over that time.
rate = -np.gradient(theta, t)  # rad/s about the centre
walking = np.hypot(*np.gradient(points, t, axis=0).T)  # m/s along the curve
for i in np.linspace(0, len(t) - 1, 5, dtype=int):
    print(f"t = {t[i]:3.0f} s  r = {np.hypot(*points[i]):.3f} m  ", end="")
    print(f"walking {walking[i]:.3f} m/s  ", end="")
    print(f"turning {rate[i]:.3f} rad/s, a round in {2 * np.pi / rate[i]:.1f} s")

plt.figure(figsize=(5, 3))
plt.plot(t, walking, label="walking, m/s")
plt.plot(t, rate, "--", label="turning, rad/s")
plt.xlabel("time (s)")
plt.legend()
plt.savefig("spiral.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# At the distance $r$ you turn by 1 radian while the head walks about $r$ metres. So the closer it
# is, the further the same metre turns you: 0.114 rad/s at the start, but 0.367 rad/s after 400 s.
#
# How long at a third of the distance?
# - Still 55 s: the head does walk steadily, but what is steady along the curve is not steady about
#   the centre.
# - **About 17 s**: 17.1 s, a third of 55 s.
# - About 6 s: as if the time fell with the square of the distance, as an area does.
# ## Check
# The last rate, 0.367 rad/s: divide 1 m/s by $k \sqrt{\theta^2 + 1}$, which is $\sqrt{r^2 + k^2}$,
# with $r = 2.724$ m and $k = 0.55 / (2 \pi) = 0.0875$ m. On the spiral $r = k \theta$ a step is
# $\mathrm{d}s = k \sqrt{\theta^2 + 1}\,\mathrm{d}\theta$, and $\mathrm{d}\theta$ grows just as fast
# as the root shrinks: along the curve nothing changes.
# ## Try
# The shaded angle is that of 5 s of walking. Drag the head, and note the time of a round at three
# distances: by which rule do they depend on each other? Change the pitch, the distance from turn to
# turn: does the rule stay?
# ## Change
# With `speed` = 0.5 and `until` = 800 the head walks the same distance: which of the numbers are
# halved?
# ## Teacher
# - From grade 10; radians, speed as distance over time. 30 minutes: 5 to guess, 15 on the stage, 10
#   to compare.
# - Goal: at the distance $r$ a speed $v$ across the line of sight is an angular rate $v / r$;
#   constant speed along a curve is not constant angular rate.
# - Try: the time of a round is proportional to the distance, at every pitch.
# - Mistakes: speed and angular rate are taken for the same; the rate is expected to fall, because
#   circles get shorter.
