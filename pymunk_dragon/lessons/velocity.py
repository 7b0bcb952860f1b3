"""The speed of the tail, and how exactly two positions give it."""

import numpy as np

from pymunk_dragon import March
from pymunk_dragon.drawing.figures.style import AMBER, BLUE
from pymunk_dragon.lessons import Lesson

lesson = Lesson("velocity", "How fast is the tail?", order=30)

lesson.question(
    "All 223 benches are rigid and hang together, and the head walks at 1 m/s. Five minutes after the start the tail "
    "is a little slower: why? And can you find its speed from two positions, a moment apart?"
)
lesson.predict(
    "Two positions a time step apart give a speed: the distance between them over that time.",
    ("How much slower than the head is the tail?", "0.35 mm/s", "3.5 mm/s", "35 mm/s"),
    ("Which time step gives the smallest error?", "1 s", "10 microseconds", "the shorter, the better"),
)

# Handles are counted from 0, the head's; these are the ones in the paper's tables.
march, t = March(), 300
state = march.at(t)
for handle in march.dragon.representatives:
    print(f"handle {handle:3d}  {state.speeds[0, handle]:.6f} m/s")

# The head bench, and the angles between it and the velocities of its two handles.
bench = state.positions[0, 0] - state.positions[0, 1]
front, rear = (np.arccos(v @ bench / np.hypot(*v) / np.hypot(*bench)) for v in state.velocities[0, :2])
print(f"head bench: {np.degrees(front):.4f} and {np.degrees(rear):.4f} degrees  ", end="")
print(f"cos / cos = {np.cos(front) / np.cos(rear):.6f}")

# The paper's method (its eq. 15): the change of the angle theta in a time step, over that step.
steps = 10.0 ** np.arange(0, -11, -1)
errors = [np.abs(march.speeds_by_difference(t, step) - state.speeds).max() for step in steps]
for step, error in zip(steps[:5], errors, strict=False):
    print(f"step {step:<6g} s  error {error:.1e} m/s")

figure, (along, chart) = lesson.subplots(2, 1, figsize=(5.2, 5.4), height_ratios=(1, 1.5))
along.plot(state.speeds[0], color=BLUE)
along.set(xlabel="handle", ylabel="speed (m/s)")
chart.loglog(steps, errors, "o-", color=BLUE)
chart.loglog(steps[:7], errors[0] * steps[:7], "--", color=AMBER)
chart.text(0.4, 0.82, "a tenth of the step,\na tenth of the error", color=AMBER, transform=chart.transAxes)
chart.text(0.05, 0.25, "rounding", color=BLUE, transform=chart.transAxes)
chart.xaxis.set_major_formatter("{x:.0e}")
chart.yaxis.set_major_formatter("{x:.0e}")
chart.set(xlabel="step (s)", ylabel="error (m/s)", xlim=(3e-11, 10))
lesson.show(figure)

lesson.picture(
    "Above: the speed from the head to the tail. Below: how wrong the speed from two positions is, by the time "
    "between them."
)
lesson.answer(
    "A rigid bench keeps its length, so both its handles go equally fast along it; the front one goes at a slightly "
    "larger angle to it, because the spiral is more curved there, and so has to be faster: 223 such benches leave "
    "the tail with 0.996478 m/s. Two positions tell the same, with an error that shrinks with the step, until they "
    "are so close, at some 10 microseconds, that most of their digits are equal and the rounding of the last ones "
    "takes over.",
    ("3.5 mm/s", "0.996478 m/s"),
    ("10 microseconds", "with shorter steps rounding takes over"),
)
lesson.check(
    r"Handle 1's speed, 0.999709 m/s: type $\cos 16.5892^\circ / \cos 16.5332^\circ$ into a calculator that reckons "
    "in degrees. The paper's table 2 has 0.999, as it cuts off what follows."
)
lesson.change(
    "Set `t` to 412, just before the collision: how much slower is the tail now, and which bench loses most? Then put "
    "`[0, 0]` for `.max()`, the head's own error: why does rounding take over later than along the whole dragon?"
)
