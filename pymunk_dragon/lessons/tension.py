"""The forces in the joints of a chain."""

from itertools import pairwise

import pymunk

from pymunk_dragon.drawing.figures.style import AMBER, BLUE, QUIET
from pymunk_dragon.lessons import Lesson

lesson = Lesson("tension", "Which joint breaks first?", order=110)

lesson.question(
    "A head pulls 24 benches along a straight line, always at 1 m/s, and the ground drags at each of them. Which joint "
    "has the most to carry? And if the ground were ice?"
)
lesson.predict(
    "Draw the force over the joints from head to tail: on the ground, on ice, and a third time where every second "
    "bench has a dancer, who pushes it as hard as the ground drags at it.",
    ("Which joint has the most to carry on the ground?", "the first, behind the head", "one in the middle", "the last"),
    ("And on ice?", "again the first", "all carry the same force", "none carries any"),
)

BENCHES, MASS, STEP = 24, 10.0, 0.01  # kg, s
# The ground leaves a bench half of its speed in a second. What it takes of 1 m/s in a step, as a force in N:
KEPT = 0.5
DRAG = MASS * (1 - KEPT**STEP) / STEP


def tensions(kept: float, dancers: list[int]) -> list[float]:
    """Force in each joint, N, on a ground that leaves so much of the speed, with dancers at some benches."""
    space = pymunk.Space()
    space.damping, space.iterations = kept, 60
    head = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    bodies = [head, *(pymunk.Body(MASS, moment=4.0) for _ in range(BENCHES))]
    for number, body in enumerate(bodies):
        body.position, body.velocity = (-2 * number, 0), (1, 0)
    joints = [pymunk.PivotJoint(before, body, (-1, 0), (1, 0)) for before, body in pairwise(bodies)]
    space.add(*bodies, *joints)
    for _ in range(1000):
        for bench in dancers:
            bodies[bench].force = (DRAG, 0)
        space.step(STEP)
    # Pymunk tells impulses, in N s, of a whole step.
    return [joint.impulse / STEP for joint in joints]


print(f"drag on one bench {DRAG:.4f} N, on {BENCHES} of them {BENCHES * DRAG:.3f} N")
figure, axes = lesson.subplots()
axes.plot([0, BENCHES], [BENCHES * DRAG, 0], color=QUIET, linewidth=1)
for name, kept, dancers, style in [
    ("on the ground", KEPT, [], "o"),
    ("with 12 dancers", KEPT, list(range(2, BENCHES + 1, 2)), "s"),
    ("on ice", 1.0, [], "^"),
]:
    force = tensions(kept, dancers)
    axes.plot(force, style, color=AMBER if dancers else BLUE, markersize=4)
    axes.text(1, force[0] + 4, name)
    print(f"{name:15}" + "".join(f"   joint {joint:2d}: {force[joint]:7.3f} N" for joint in (0, 1, 12, 23)))
axes.set(xlabel="joint, from head to tail", ylabel="force, N")
lesson.show(figure)

lesson.picture("The force in each joint of a chain that is pulled along. The line is the formula.")
lesson.answer(
    "The first joint, as each of them pulls all the benches behind it: the force falls evenly from head to tail, and "
    "in stairs where every second bench is pushed. On ice no one has to pull, because what moves goes on by itself.",
    ("the first, behind the head", "165.780 N"),
    ("none carries any", "0.000 N"),
)
lesson.check(
    "165.780 N in the first joint: in a step of 0.01 s a bench of 10 kg keeps $0.5^{0.01}$ of its 1 m/s. Work out how "
    "much momentum it loses, divide by the length of the step to get a force, and multiply by 24 benches."
)
lesson.change(
    "Give every bench a dancer, `list(range(1, BENCHES + 1))`. Then let the solver try 10 times in each step, not 60, "
    "and then 5 times: what it leaves undone grows from step to step."
)
