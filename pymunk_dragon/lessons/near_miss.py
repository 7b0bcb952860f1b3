"""How closely the head passes two benches before it hits one."""

import numpy as np

from pymunk_dragon import Camera, Dragon, March, Spiral, first_contact, render, scan, separation, simulate
from pymunk_dragon.lessons import Lesson
from pymunk_dragon.model.dragon import bench_poses

lesson = Lesson("near-miss", "A hit or a near miss?", order=60, live="near-miss")

lesson.question(
    "As it marches inward, the head, bench 0, passes bench 9, then bench 11, and then runs into bench 8. A bench is "
    "300 mm wide. How much room is left when it passes?"
)
lesson.predict(
    "Beside the exact model, three other programs compute the march: one samples every 10 s, one cuts positions to "
    "whole millimetres, and one is a physics engine that takes long steps.",
    ("How wide is the gap to bench 11?", "a hand's width", "a finger's width", "a bank card's thickness"),
    ("Which of the three report a false collision?", "none", "only the engine", "the last two", "all of them"),
)

# The exact model: the near misses, and the first contact. Then samples every 10 s, and bisection where benches
# overlap.
march = March(Dragon(), Spiral(pitch=0.55), turns=16, speed=1.0)
hit, sampled = first_contact(march), scan(march, until=420, step=10)
for miss in hit.near_misses:
    print(f"{'exact':15}{miss.time:.3f} s  benches {miss.benches}  gap {1000 * miss.gap:.3f} mm")
print(f"{'exact':15}{hit.time:.3f} s  benches {hit.benches}  contact")
print(f"{'every 10 s':15}{sampled.time:.3f} s  benches {sampled.benches}  contact")

# The same march, but x and y of all handles are cut after three decimals, as in the paper's tables.
times = np.arange(405, 413, 0.001)
handles = np.trunc(1000 * march.at(times, handles=13).positions) / 1000
benches = march.dragon.outlines(bench_poses(handles))
overlaps = separation(benches[:, 0], benches[:, 11]).distance < 0
for time in times[overlaps][:1]:  # the first one, if there is any
    print(f"{'cut to 1 mm':15}{time:.3f} s  benches (0, 11)  contact")

# Pymunk: by default it takes 50 steps a second, and in each of them the solver goes over all joints 10 times. The
# sloppy one takes 10 steps, and goes over them once.
careful = simulate(march, start=398, frame_interval=0.02)
sloppy = simulate(march, start=398, until=413, substep=0.1, iterations=1)
for name, run in (("careful engine", careful), ("sloppy engine", sloppy)):
    contact, off = run.first_contact, 1000 * run.max_drift
    print(f"{name:15}{contact.time:.3f} s  benches {contact.benches}  contact, up to {off:.3f} mm off")

# For the check: where the head's rear left corner and two handles are at the last near miss.
state = march.at(miss.time)
for name, (x, y) in zip("CAB", (march.dragon.outlines(state.poses)[0, 0, 3], *state.positions[0, 11:13]), strict=True):
    print(f"{name} ({x:.6f}, {y:.6f}) m")

film = lesson.file(".gif")
render(careful, film, camera=Camera(follow="head", span=5), start=406, speedup=1.5, size=290)
lesson.show(film)

lesson.picture("The head slips past benches 9 and 11 and meets bench 8; the gap is written below.")
lesson.answer(
    "The head passes bench 9 with 2.957 mm and bench 11 with 0.865 mm to spare, hardly more than a bank card is "
    "thick, and runs into bench 8 at 412.474 s. Looking every 10 s does no harm here, but positions that are cut to "
    "1 mm let the head hit bench 11 at 409.712 s, and the sloppy engine, whose joints come loose, lets benches 200 "
    "and 203 meet at 401.591 s: collisions that never happen.",
    ("a bank card's thickness", "0.865 mm"),
    ("the last two", "at 409.712 s and 401.591 s"),
)
lesson.check(
    "The gap of 0.865 mm: $C$ is the head's rear left corner then, $A$ and $B$ are handles 11 and 12, on the middle "
    "line of bench 11. From that line $C$ is $|(x_B - x_A)(y_C - y_A) - (y_B - y_A)(x_C - x_A)| / 1.65$ m away; take "
    "off half a width, 0.15 m."
)
lesson.change(
    "Set `iterations` of the sloppy engine to 2, 5 or 60, or `substep` to 0.05: how little work is enough for the "
    "right benches, and for the right time? And cut positions to 0.1 mm: does the head still hit bench 11?"
)
