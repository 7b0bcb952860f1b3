# %% [markdown] order=140 axes="time (s)|speed (m/s)"
# # Who is the fastest in the turn?
# In the turn inside a circle 9 m wide the head keeps a steady speed. Nobody may exceed 2 m/s.

# %%
import matplotlib.pyplot as plt
import numpy as np

from pymunk_dragon import March
from pymunk_dragon.studies import max_speed

found = max_speed(limit=2.0, ratio=2.0)
print(f"{found.limit:g} m/s / {found.ratio:.4f} = {found.speed:.4f} m/s  head's largest speed")
print(f"t = {found.time:.4f} s  handles {found.handles} at {found.limit:g} m/s")
march = March(found.dragon, found.curve, speed=found.speed)

# %%
# At that moment: the angles from a bench to the velocities of its front and rear handles.
state = march.at(found.time)
product = 1.0
for i in range(found.handle):
    bench = state.positions[0, i] - state.positions[0, i + 1]
    front, rear = (
        np.arccos(v @ bench / np.hypot(*v) / np.hypot(*bench))
        for v in state.velocities[0, i : i + 2]
    )
    ratio = np.cos(front) / np.cos(rear)
    product *= ratio
    print(f"bench {i}: {np.degrees(front):7.4f} and {np.degrees(rear):7.4f} degrees  ", end="")
    print(f"cos / cos = {ratio:.4f}")
print(f"product {product:.4f}")

# Where the head enters the circle, changes arcs and leaves, the curvature of the path jumps.
plt.figure(figsize=(5, 3.5))
for s in found.curve.joints:
    plt.axvline(s / found.speed, color="silver")
t = np.linspace(-1, 19, 2001)
speeds = march.at(t, 4).speeds
for handle in (0, 1, 3):
    plt.plot(t, speeds[:, handle], label=f"handle {handle}")
plt.xlabel("time since the head entered (s)")
plt.ylabel("speed (m/s)")
plt.legend()
plt.savefig("speed-limit.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# Handles 3 to 7 get 1.605 times as fast as the head, so 1.246 m/s is all that it may go. Then it
# has just left the narrow arc while handle 1 is still on it: the path crosses the head bench at 46
# degrees in front and at 63 degrees behind. Both handles are equally fast along the rigid bench, so
# the rear one has to be 1.55 times as fast.
#
# Who has to run fastest?
# - The head: it leads, but the angles of the benches make those behind faster.
# - **Somebody close behind it**: handles 3 to 7.
# - The tail: it is 1.58 times as fast as the head, as a little is lost from bench to bench.
# ## Check
# The ratio of 1.605: type $\cos 46.0060^\circ / \cos 63.4555^\circ$ times
# $\cos 4.7067^\circ / \cos 15.1517^\circ$ into a calculator that reckons in degrees. Bench 1 adds
# nothing: it is a chord of one arc, which meets it at equal angles.
# ## Try
# Move the head to where a handle is fastest: on which arcs are they then? Slow the head until
# nobody exceeds 2 m/s.
# ## Change
# Set `ratio` to 1.0, two equal arcs: how fast may the head go now, and where is it when the speed
# is largest?
# ## Teacher
# - From grade 12; the lesson velocity, tangents of a circle. 50 minutes: 10 to guess, 20 on the
#   stage, 20 to compare.
# - Goal: the speeds of the two ends of a bench have the ratio $\cos a / \cos b$ of its angles to
#   the path. Where the curvature jumps, the angles differ most, and the ratios of several benches
#   multiply.
# - Try: the head has just left the narrow arc, and handles 3 to 7 are on the wide one. 1.246 m/s.
# - Mistakes: a steady head is taken to mean a steady dragon; the longest lever is sought at the
#   tail.
# - Ask next: how fast may the head go? Not 2 m/s, which it could if all went as fast as the head,
#   and not 1.6 m/s, which is the ratio of the speeds, but about 1.25 m/s. Bench 2, which lies
#   across the point where both arcs meet, adds another 3 percent to the ratio.
