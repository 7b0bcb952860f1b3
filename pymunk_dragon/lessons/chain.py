"""The next handle among all points on the spiral at a bench's distance."""

import numpy as np

from pymunk_dragon import Dragon, March, Spiral
from pymunk_dragon.drawing.figures.style import AMBER, BLUE, RULE, halo
from pymunk_dragon.lessons import Lesson

lesson = Lesson("chain", "Where does the next handle go?", order=20)

lesson.question(
    "Two handles carry the head bench, both on the spiral, 2.86 m apart in a straight line. If the front one, handle "
    "0, is known, the next one is where the circle of radius 2.86 m round it meets the spiral. How often does it, and "
    "which point is meant?"
)
lesson.predict(
    "Draw the spiral with turns 0.55 m apart, and a circle of radius 2.86 m round a point on it.",
    ("How often does the circle meet the spiral?", "2 times", "6 times", "22 times"),
    ("How long is the path from one handle to the other?", "2.86 m as well", "4 cm longer", "40 cm longer"),
)

# The arc-length coordinate s is in metres from the centre. Handle 0 has walked from turn 16 for t s.
t, bench = 300, 2.86
spiral = Spiral(pitch=0.55)
here = spiral.at_turn(16) + 1.0 * t
handle = spiral.point(here)

# Go in along the whole spiral, and note wherever the distance from handle 0 passes the length of the bench.
s = np.linspace(spiral.at_turn(22), 0, 1_000_001)
path = spiral.point(s)
beyond = np.hypot(*(path - handle).T) - bench
i = np.flatnonzero(beyond[:-1] * beyond[1:] < 0)
found = s[i] - beyond[i] * (s[i + 1] - s[i]) / (beyond[i + 1] - beyond[i])
points = spiral.point(found)

# The points nearest to handle 0 along the path.
back = int(np.searchsorted(found, here)) - 1
print(f"{len(found)} points at {bench} m from handle 0, whose r = {np.hypot(*handle):.3f} m")
for j in range(back - 2, back + 4):
    turns = (spiral.angle(found[j]) - spiral.angle(here)) / (2 * np.pi)
    x, y = points[j]
    print(f"{turns:6.3f} turns back  arc {here - found[j]:7.3f} m  r = {np.hypot(x, y):.3f} m  ({x:.6f}, {y:9.6f}) m")
x, y = March(Dragon(head_spacing=bench), spiral).at(t).positions[0, 1]
print(f"March's handle 1                              ({x:.6f}, {y:9.6f}) m")

# The bench, the path between its handles, and two other points of the circle.
figure, axes = lesson.subplots(figsize=(5.2, 5.0))
axes.plot(*path.T, color=RULE, lw=1.2)
axes.plot(*path[(s > found[back]) & (s < here)].T, color=BLUE, lw=3)
turn = np.linspace(0, 2 * np.pi, 361)
axes.plot(handle[0] + bench * np.cos(turn), handle[1] + bench * np.sin(turn), color=BLUE, lw=1)
axes.plot(*points.T, "o", color=BLUE, ms=6)
for j, name, width in ((back, "next", 5), (back - 2, "out", 1), (back + 2, "in", 1)):
    axes.plot(*np.transpose([handle, points[j]]), "o-", color=AMBER, lw=width, ms=2 * width)
    axes.text(*(1.13 * points[j] - 0.13 * handle), name, ha="center", va="center", path_effects=halo())
axes.text(handle[0] + 0.2, handle[1], "handle 0", va="center", path_effects=halo())
reach = 1.2 * bench * np.array([-1, 1])
axes.set(xlim=handle[0] + reach, ylim=handle[1] + reach, aspect="equal")
axes.set_axis_off()
lesson.show(figure)

lesson.picture("The circle round handle 0, the next handle, and its doubles one turn further out and further in.")
lesson.answer(
    "The circle meets the spiral 22 times, always 2.86 m away in a straight line, and the next one back along the "
    "path is meant: 2.900 m along it, as the path is an arc and the bench is its chord. The two beside it on the "
    "circle, less than 0.6 m off, are one turn further out or in: no walk takes the bench there, but a solver with a "
    "bad guess does.",
    ("22 times", "22 points"),
    ("4 cm longer", "2.900 m"),
)
lesson.check(
    "The arc, 2.900 m: the path is nearly a circle of the radius $R = (4.992 + 5.043) / 2$ m, and the arc over a "
    r"chord of 2.86 m is $2 R \arcsin(2.86 / (2 R))$, with the arcsine in radians. And count the dots: 22."
)
lesson.change(
    "Set `bench` to 1.65, as long as all benches but the head: how many points are there, and how much longer is the "
    "arc now? Then put it back and set `t` to 400: now the centre lies within the circle, and the number is odd. Why?"
)
