# %% [markdown] order=60 scene="near-miss" axes="time (s)|gap (mm)"
# # A hit or a near miss?
# The head passes close to benches of the next turn: bench 9 at 406.8 s, bench 11 at 409.8 s, and
# bench 8 at 412.5 s.

# %%
import matplotlib.pyplot as plt
import numpy as np

from pymunk_dragon import March, first_contact, scan, separation, simulate
from pymunk_dragon.model.dragon import bench_poses

# The exact model: the near misses, and the first contact. Then checks every 10 s, and bisection
# where benches overlap.
march = March()
hit = first_contact(march)
sampled = scan(march, until=420, step=10)
for miss in hit.near_misses:
    print(f"{'exact':15}{miss.time:.3f} s  benches {miss.benches}  gap {1000 * miss.gap:.3f} mm")
print(f"{'exact':15}{hit.time:.3f} s  benches {hit.benches}  contact")
print(f"{'every 10 s':15}{sampled.time:.3f} s  benches {sampled.benches}  contact")

# %%
# The same march, but x and y of all handles are cut after three decimals, as in the paper's tables.
times = np.arange(405, 413, 0.001)
handles = np.trunc(1000 * march.at(times, handles=13).positions) / 1000
benches = march.dragon.outlines(bench_poses(handles))
overlaps = separation(benches[:, 0], benches[:, 11]).distance < 0
for time in times[overlaps][:1]:  # the first one, if there is any
    print(f"{'cut to 1 mm':15}{time:.3f} s  benches (0, 11)  contact")

# %%
# Pymunk: by default it takes 50 steps a second, and in each of them the solver goes over all joints
# 10 times. The coarse one takes 10 steps, and goes over them once.
careful = simulate(march, start=398)
coarse = simulate(march, start=398, until=413, substep=0.1, iterations=1)
for name, run in (("careful engine", careful), ("coarse engine", coarse)):
    touch = run.first_contact
    print(f"{name:15}{touch.time:.3f} s  benches {touch.benches}  contact  ", end="")
    print(f"off by up to {1000 * run.max_drift:.4g} mm")

# %%
# For the check: where the head's rear left corner and two handles are at the last near miss.
state = march.at(miss.time)
corner = march.dragon.outlines(state.poses)[0, 0, 3]
points = (corner, *state.positions[0, 11:13])
names = ("C, corner of the head", "A, handle 11", "B, handle 12")
for name, (x, y) in zip(names, points, strict=True):
    print(f"{name:22}({x:.6f}, {y:.6f}) m")

outlines = march.dragon.outlines(march.at(times, handles=17).poses)
distance = separation(outlines[:, :1], outlines[:, 2:]).distance
gaps = distance.min(axis=1)
plt.figure(figsize=(5, 3))
plt.plot(times, 1000 * gaps)
plt.xlabel("time (s)")
plt.ylabel("gap of the head (mm)")
plt.axis((405, 413, 0, 30))
plt.savefig("near-miss.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# The head passes bench 9 with 3.0 mm and bench 11 with 0.9 mm to spare, hardly more than a bank
# card is thick, and runs into bench 8 at 412.474 s. So a millimetre decides: coordinates that are
# cut to 1 mm let the head hit bench 11 at 409.712 s, a collision that never happens.
#
# Which one does it touch first?
# - Bench 9: it comes first, and in a film a gap of 3 mm cannot be seen.
# - Bench 11: it is so close that a millimetre more or less decides.
# - **Bench 8**: at 412.474 s.
# ## Check
# The gap to bench 11 is 0.865 mm: $C$ is the head's rear left corner then, $A$ and $B$ are handles
# 11 and 12, on the middle line of bench 11. Subtract $(y_B - y_A)(x_C - x_A)$ from
# $(x_B - x_A)(y_C - y_A)$, and divide by 1.65 m: but for its sign, this is the distance of $C$ from
# that line. Take off half a width, 0.15 m.
# ## Try
# Go to each of the three times, zoom in and read the gap; the chart has it every 10 ms, up to where
# you have been. What does a check at 410 s see, and what has touched before the next one? Then cut
# the coordinates, to hundredths of a millimetre at first: from where on does a false contact
# appear, and at which bench?
# ## Change
# Set the coarse engine's `iterations` to 2, 5 or 60, or its `substep` to 0.05: how little work
# finds the right benches?
# ## Teacher
# - From grade 10; distance of a point from a line. 45 minutes: 5 to guess, 25 on the stage, 15 to
#   compare.
# - Goal: less than a millimetre decides between a contact and none, so a result needs a bound on
#   its error.
# - Try: cut to 0.1 mm, the head still hits bench 8 first; cut to 1 mm bench 11, and cut to 10 mm
#   bench 9. The chart skips overlaps of less than 10 ms, and shows 409.79 s, not 409.712 s.
# - Mistakes: rounding is taken for harmless because it is small against the benches, not against
#   the gap.
# - Ask next: one program checks at 400 s, 410 s and so on whether benches overlap, and traces an
#   overlap back to its beginning; another one cuts the coordinates of all handles to whole
#   millimetres. Which one finds bench 8? Only the first: at 410 s there is a gap, and what it finds
#   at 420 s began at 412.474 s; a coarse step does harm only if it skips a whole contact. A
#   millimetre seems little on benches of two metres, but the gap is smaller.
# - The program also lets Pymunk march: with care it finds bench 8, but with one iteration in steps
#   of 0.1 s its joints come loose, and benches 200 and 203 meet at 401.6 s.
