"""The fastest handle in the turn of the contest's question 4, and the largest speed of the head."""

import numpy as np

from pymunk_dragon import March
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS, RULE
from pymunk_dragon.lessons import Lesson
from pymunk_dragon.studies import max_speed

lesson = Lesson("speed-limit", "Who is the fastest in the turn?", order=140)

lesson.question(
    "In the turn inside the circle 9 m wide the head keeps a steady speed, but not everybody behind it can. If 2 m/s "
    "is the limit for all, who reaches it first, and how fast may the head go?"
)
lesson.predict(
    "Imagine the turn from above, with the head at a steady speed on both arcs.",
    ("Who has to run fastest?", "the head", "somebody close behind it", "the tail"),
    ("How fast may the head go?", "2 m/s", "1.6 m/s", "about 1.25 m/s"),
)

found = max_speed(limit=2.0, ratio=2.0)
print(f"{found.limit:g} m/s / {found.ratio:.10f} = {found.speed:.10f} m/s  head's largest speed")
print(f"t = {found.time:.4f} s  handles {found.handles} at {found.limit:g} m/s")
march = March(found.dragon, found.curve, speed=found.speed)

# At that moment: the angles from a bench to the velocities of its front and rear handles.
state, product = march.at(found.time), 1.0
for i in range(found.handle):
    bench = state.positions[0, i] - state.positions[0, i + 1]
    front, rear = (np.arccos(v @ bench / np.hypot(*v) / np.hypot(*bench)) for v in state.velocities[0, i : i + 2])
    lever = np.cos(front) / np.cos(rear)
    product *= lever
    print(f"bench {i}: {np.degrees(front):7.4f} and {np.degrees(rear):7.4f} degrees  cos / cos = {lever:.6f}")
print(f"product {product:.4f}")

# Where the head enters the circle, changes arcs and leaves, the curvature of the path jumps.
figure, axes = lesson.subplots()
for s, name in zip(found.curve.joints, ("enters", "changes", "leaves"), strict=True):
    axes.axvline(s / found.speed, color=RULE)
    axes.text(s / found.speed + 0.15, 0.05, name, rotation=90, transform=axes.get_xaxis_transform())
t = np.linspace(-1, 19, 2001)
speeds = march.at(t, 4).speeds
for handle, line, colour in ((0, "-", BLUE), (1, ":", COLOURS.ink), (3, "--", AMBER)):
    axes.plot(t, speeds[:, handle], line, color=colour, label=f"handle {handle}")
axes.set(xlabel="time since the head entered (s)", ylabel="speed (m/s)", xlim=(-1, 19), xticks=range(0, 20, 5))
axes.legend(loc="upper right", frameon=False)
lesson.show(figure)

lesson.picture("The head is steady, the others are not: the lines mark where it enters, changes arcs, and leaves.")
lesson.answer(
    "Handles 3 to 7 are 1.6048 times as fast as the head, so 1.2462663582 m/s is all that it may go: it has just "
    "left the narrow arc while handle 1 is still on it, so the path crosses the head bench at 46 degrees in front "
    "and at 63 degrees behind. Both handles are equally fast along the rigid bench, so it moves the rear one like a "
    "lever, 1.55 times as fast, and bench 2, which lies across the point where both arcs meet, adds another 3 "
    "percent.",
    ("somebody close behind it", "handles 3 to 7, at 2 m/s"),
    ("about 1.25 m/s", "1.2462663582 m/s"),
)
lesson.check(
    r"The product, 1.6048: type $\cos 46.0060^\circ / \cos 63.4555^\circ \cdot \cos 4.7067^\circ / \cos "
    r"15.1517^\circ$ into a calculator that reckons in degrees. Bench 1 adds nothing: it is a chord of one arc, which "
    "meets it at equal angles."
)
lesson.change(
    "Set `ratio` to 1.0, two equal arcs: the turn is as long as before, but how fast may the head go now, who is the "
    "fastest, and at which of the three lines is the largest speed?"
)
