"""How fast one turns at the centre to watch the head."""

import numpy as np

from pymunk_dragon import Spiral
from pymunk_dragon.drawing.figures.style import AMBER, BLUE
from pymunk_dragon.lessons import Lesson

lesson = Lesson("spiral", "How fast do you turn to watch the head?", order=10)

lesson.question(
    "In the bench dragon, a folk dance, some 200 benches hinged end to end coil inward on a spiral. The head walks at "
    "1 m/s all the time, and you stand in the centre and turn so that you always face it. Do you turn at a steady "
    "speed too?"
)
lesson.predict(
    "At the start you turn so slowly that a whole round would take 55 s. After 400 s the head is only a third as far "
    "away.",
    ("How long would a round take then?", "still 55 s", "about 17 s", "about 6 s"),
)

# The spiral is r = k theta, and each turn is 0.55 m further out. The head starts on turn 16, 8.8 m from the centre.
spiral = Spiral(pitch=0.55)
speed, until = 1.0, 400
t = np.linspace(0, until, 100 * until + 1)
s = spiral.at_turn(16) + speed * t  # metres along the curve
theta, points = spiral.angle(s), spiral.point(s)

# Both speeds, measured as with a stopwatch: what has changed within 0.01 s, over that time.
rate = -np.gradient(theta, t)  # rad/s about the centre
walking = np.hypot(*np.gradient(points, t, axis=0).T)  # m/s along the curve
for i in np.linspace(0, len(t) - 1, 5, dtype=int):
    print(f"t = {t[i]:3.0f} s  r = {np.hypot(*points[i]):.3f} m  walking {walking[i]:.4f} m/s  ", end="")
    print(f"turning {rate[i]:.4f} rad/s, a round in {2 * np.pi / rate[i]:.1f} s")

# Two pieces of the path, each walked in 5 s, as seen from the centre.
figure, (ground, chart) = lesson.subplots(1, 2, figsize=(5.8, 3.2), width_ratios=(1.2, 1))
ground.plot(*points.T, color=BLUE, lw=0.8)
for piece in (points[:501], points[-501:]):
    ground.fill(*np.vstack([piece, (0, 0)]).T, color=AMBER, alpha=0.3, lw=0)
    ground.plot(*piece.T, color=BLUE, lw=4)
ground.set_aspect("equal")
ground.set_axis_off()
chart.plot(t, walking, color=BLUE)
chart.text(0, 0.92, "walking, m/s", color=BLUE)
chart.plot(t, rate, "--", color=AMBER)
chart.text(0, 0.17, "turning, rad/s", color=AMBER)
chart.set(xlabel="time (s)", ylim=(0, None))
lesson.show(figure)

lesson.picture(
    "Left: the first and the last 5 s of the walk, both bold, and how wide they look from the centre. Right: the walk "
    "is steady, the turning is not."
)
lesson.answer(
    "At the distance $r$ you turn by 1 radian while the head walks about $r$ metres, so the closer it is, the "
    "further the same metre turns you: 0.1136 rad/s at the start, but 0.3669 rad/s after 400 s. Along the curve "
    r"nothing changes: on the spiral $r = k \theta$, where $\theta$ is the angle about the centre, a step is "
    r"$\mathrm{d}s = k \sqrt{\theta^2 + 1}\,\mathrm{d}\theta$, and $\mathrm{d}\theta$ grows just as fast as the root "
    "shrinks.",
    ("about 17 s", "17.1 s"),
)
lesson.check(
    r"The last rate, 0.3669 rad/s: divide 1 m/s by $k \sqrt{\theta^2 + 1}$, which is $\sqrt{r^2 + k^2}$, with $r = "
    r"2.724$ m and $k = 0.55 / (2 \pi) = 0.0875$ m. Or roughly with a protractor: the inner bold piece spans 102 "
    "degrees, or 1.78 radians, in 5 s."
)
lesson.change(
    "Set `until` to 440: then the head comes within 70 cm of the centre. How fast do you turn, and is the walk still "
    "steady? With `speed` = 0.5 and `until` = 800 it walks the same distance: which of the numbers are halved?"
)
