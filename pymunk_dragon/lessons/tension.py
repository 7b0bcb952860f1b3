# %% [markdown] order=110 scene="tension" view=[-24,0,54,10] axes="joint, head to tail|force (N)"
# # Which joint breaks first?
# A head pulls 24 equal benches straight ahead at 1 m/s, and the ground drags at each of them.

# %%
from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pymunk

from pymunk_dragon import Slider

BENCHES = 24
MASS = 10.0  # kg
STEP = 0.01  # s
KEPT = 0.5  # of the speed, in a second
# A speed that falls to a half in a second falls at the rate ln 2. Pymunk lets it fall in a step,
# and the joints bring it back at its end: in between a bench is slower than 1 m/s, and the drag on
# it smaller.
CONTINUOUS = MASS * np.log(1 / KEPT)  # N, at 1 m/s
DRAG = MASS * (1 - KEPT**STEP) / STEP


def build(benches: int = BENCHES, dancers: int = 0) -> pymunk.Space:
    """The head pulls at 1 m/s, and the ground drags at the benches. Pull, and cut a joint."""
    space = pymunk.Space()
    space.damping = KEPT
    space.iterations = 60
    head = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    bodies = [head]
    for _ in range(benches):
        bodies.append(pymunk.Body(MASS, moment=4.0))

    for number, body in enumerate(bodies):
        body.position = (-2 * number, 0)
        body.velocity = (1, 0)
        shape = pymunk.Poly.create_box(body, (2, 0.3))
        shape.filter = pymunk.ShapeFilter(group=1)
        space.add(body, shape)
        if number * dancers % benches < dancers:
            body.velocity_func = pushed

    for before, body in pairwise(bodies):
        joint = pymunk.PivotJoint(before, body, (-1, 0), (1, 0))
        space.add(joint)
    return space


def pushed(body: pymunk.Body, gravity: Any, damping: float, dt: float) -> None:
    """A step of a bench that a dancer pushes as hard as the ground drags at it at 1 m/s."""
    body.force += (MASS * (1 - damping) / dt, 0)
    pymunk.Body.update_velocity(body, gravity, damping, dt)


def first(space: pymunk.Space) -> float:
    """Live, the force in the joint at the head, N."""
    head, *_ = space.bodies
    impulse = sum(joint.impulse for joint in space.constraints if joint.a is head)
    return impulse / (space.current_time_step or STEP)


def pull(space: pymunk.Space, force: float) -> None:
    """Live, from now on a hand pulls the last bench back with a force, N."""
    vars(space)["pull"] = force


def follow(space: pymunk.Space, time: float) -> None:
    """Live, the hand pulls, and the benches are seen by somebody who walks beside the head."""
    *_, last = space.bodies
    last.force -= (vars(space).get("pull", 0), 0)
    for body in space.bodies:
        body.position -= (space.current_time_step, 0)


sliders = [
    Slider("benches", 2, 24, label="Benches", rebuilds=True),
    Slider("dancers", 0, 24, label="Dancers", rebuilds=True),
    Slider("pull", 0, 200, 0, label="Pull at the last bench", unit="N", action=pull),
]
# With longer steps, the engine tears the chain apart.
sliders.append(Slider("step", 1, 50, label="Time step", unit="ms", logarithmic=True))
plots = {"Force in the first joint (N)": first}
LIVE: dict[str, Any] = {"step": STEP, "on_step": follow, "controls": sliders, "plots": plots}

# %%
print(f"drag on a bench at 1 m/s: {CONTINUOUS:.3f} N, with steps of {STEP} s {DRAG:.3f} N")
plt.figure(figsize=(5, 3.5))
for name, kept, dancers in [
    ("on the ground", KEPT, 0),
    ("with 12 dancers", KEPT, 12),
    ("on ice", 1.0, 0),
]:
    space = build(dancers=dancers)
    space.damping = kept
    for _ in range(1000):
        space.step(STEP)
    # Pymunk gives impulses, in N s, of a whole step.
    force = [joint.impulse / STEP for joint in space.constraints]
    plt.plot(force, "o", label=name)
    print(f"{name:15}", end="")
    for joint in (0, 1, 12, 23):
        print(f"   joint {joint:2d}: {force[joint]:5.1f} N", end="")
    print()
plt.xlabel("joint, head to tail")
plt.ylabel("force (N)")
plt.legend()
plt.savefig("tension.png", bbox_inches="tight")

# %% [markdown]
# ## Answer
# Each joint pulls all the benches behind it, so the force falls evenly from head to tail, and in
# stairs where every second bench is pushed. On ice no one has to pull, because what moves goes on
# by itself.
#
# Which joint has the most to carry?
# - **The first, behind the head**: 166 N, the drag on all 24 benches.
# - One in the middle: a rope seems to tear where it is longest on both sides, but what is ahead of
#   a joint pulls it.
# - The last: it is the farthest from the head, but only one bench hangs on it.
# ## Check
# The drag on a bench at 1 m/s is $10 \ln 2 = 6.93$ N, so 24 of them take 166.4 N. The engine has
# 6.91 N and 165.8 N: in a step of 0.01 s it takes a part $1 - 0.5^{0.01}$ of 1 m/s, a little less
# than $0.01 \ln 2$, as the speed falls in it. (A bench of 10 kg alone would lose half of its speed
# in a second.)
# ## Try
# Read the force in the first joint in all three cases: on the ground, with 12 dancers, and on ice,
# where all of the speed is kept. Pull at the tail. Which joint would you cut to relieve most of the
# others?
# ## Change
# Set `STEP` to 0.04 and to 0.001: how does the engine's drag come near to the continuous one? Then
# give every bench a dancer: 24 in place of 12.
# ## Teacher
# - From grade 10; Newton's second law, drag that grows with speed. 40 minutes: 10 to draw, 15 on
#   the stage, 15.
# - Goal: cut the chain in mind at a joint: the force there moves all that is behind the cut.
# - Try: 166 N in the first joint, 83 N with 12 dancers, none on ice. A cut of the first joint
#   relieves all of them.
# - Mistakes: a force is taken to be needed for motion, also on ice; the tension is taken to be the
#   same everywhere.
# - Ask next: and if the ground were ice? No joint carries any force. Most expect the first one
#   again, but nothing drags at the benches behind it; all would carry the same force with a
#   massless rope and a load that drags at its end.
# - Have the class draw the force over the joints: on the ground, on ice, and where every second
#   bench has a dancer, who pushes it as hard as the ground drags at it.
