"""What makes an engine exact: the length of its steps, its iterations, and its joints."""

import pymunk

from pymunk_dragon import Dragon, March, simulate
from pymunk_dragon.drawing.figures.style import AMBER, BLUE
from pymunk_dragon.lessons import Lesson

lesson = Lesson("engine", "What makes an engine exact?", order=90, live="sloppy-engine")

lesson.question(
    "A physics engine goes in short steps of time (`substep`), and in each of them it goes over all joints several "
    "times (`iterations`), as it cannot make all of them hold at once. What brings the dragon nearer to the truth, "
    "shorter steps or more tries? And is every joint to be trusted?"
)
lesson.predict(
    "Forty benches march for five seconds, with steps of three lengths and four numbers of iterations. Then a body "
    "slides along a groove, just as the joint that keeps it there demands.",
    ("What does halving the steps leave of the error?", "all of it", "about a half", "about a quarter"),
    ("What does the joint do to that body?", "nothing", "it slows the body down", "it pushes sideways"),
)

# Forty benches for five seconds: how far the worst of them is from where the exact model has it.
march = March(Dragon(benches=40))
substeps = [0.02, 0.01, 0.005]  # s
figure, (left, right) = lesson.subplots(1, 2)
for iterations, line in [(5, ":o"), (15, "--o"), (60, "-o"), (240, "-o")]:
    runs = [simulate(march, start=400, until=405, substep=h, iterations=iterations) for h in substeps]
    errors = [1e6 * run.max_drift for run in runs]
    print(f"{iterations:3d} tries" + "".join(f"   {h} s: {d:6.3f} µm" for h, d in zip(substeps, errors, strict=True)))
    left.loglog(substeps, errors, line, color=BLUE, markersize=4)
    left.text(0.0225, errors[0], f"{iterations} tries" if iterations < 240 else "", va="center")

# One body of 1 kg and 1 kg m² slides along at 1 m/s, and a hole in it along a line: its joint has nothing to do.
hole = (1.0, 1.0)  # m
for name, line, above in [("GrooveJoint", "-", -14), ("PinJoint", "--", 4)]:
    space = pymunk.Space()
    body, anchor = pymunk.Body(1, 1), pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    body.velocity = anchor.velocity = (1, 0)
    # The groove is that line; the pin, 1 m long, hangs from an anchor that goes along above the hole.
    anchor.position = (hole[0], hole[1] + 1)
    if name == "GrooveJoint":
        space.add(pymunk.GrooveJoint(space.static_body, body, (0, hole[1]), (9, hole[1]), hole))
    else:
        space.add(pymunk.PinJoint(anchor, body, (0, 0), hole))
    space.add(body, anchor)
    space.step(0.01)
    print(f"{name:11}   after one step: {body.velocity.y:6.3f} m/s sideways", end="")
    off = []  # mm
    for _ in range(99):
        space.step(0.01)
        off.append(1000 * (body.local_to_world(hole).y - hole[1]))
    print(f"   after 1 s: {off[-1]:7.3f} mm off the line")
    right.plot(off, line, color=AMBER)
    right.text(98, off[-1] + above, name, ha="right")
left.set(xlabel="substep, s", ylabel="drift, µm", yticks=[1, 10], yticklabels=[1, 10])
left.set_xticks(substeps, substeps)
left.minorticks_off()
right.set(xlabel="step", ylabel="off the line, mm", ylim=(-100, 100))
lesson.show(figure)

lesson.picture(
    "Left, the error of the dragon; the lines for 60 and 240 tries begin together. Right, a body that two kinds of "
    "joint shall keep on a line."
)
lesson.answer(
    "More tries help until the joints hold: up to some 60, four times as many leave less than half of the error, but "
    "each halving of the steps leaves about a quarter. A `GrooveJoint` even pushes a body that slides just as it "
    "should, because it works out what would stop the hole and keeps the part across the groove; a `PinJoint` minds "
    "that one direction only, so the dancers of this project hold their benches with pins.",
    ("about a quarter", "1.211 µm, 0.348 µm, 0.095 µm"),
    ("it pushes sideways", "-0.333 m/s"),
)
lesson.check(
    "The push to the side of -0.333 m/s: an impulse $(p, q)$ on a hole 1 m ahead of the centre and 1 m beside it "
    "changes the hole's velocity by $(2 p - q, 2 q - p)$. It shall be $(-1, 0)$, to stop the hole; the groove keeps "
    "$q$."
)
lesson.change(
    "Put the hole level with the centre, `hole = (1.0, 0.0)`: does the groove still push? For which holes does it?"
)
