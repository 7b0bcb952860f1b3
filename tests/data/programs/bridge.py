"""A bridge that breaks.

Planks hang together by joints. A joint that carries too much breaks.
"""

import math

import pymunk

from pymunk_dragon import Button, Slider, live

PLANK = 0.8
SLOPE = 0.3  # rad, at the start


def build(planks=12, strength=2000.0):
    space = pymunk.Space()
    space.gravity = 0, -9.81
    space.iterations = 30
    space.damping = 0.5
    half = planks * PLANK / 2 * math.cos(SLOPE)
    for side in (-1, 1):
        bank = pymunk.Segment(space.static_body, (side * half, 0), (side * (half + 3), 0), 0.1)
        bank.friction = 0.8
        space.add(bank)

    before, hole = space.static_body, (-half, 0)
    for i in range(planks):
        plank = pymunk.Body(2, pymunk.moment_for_box(2, (PLANK, 0.2)))
        middle = i + 0.5 - planks / 2
        plank.angle = math.copysign(SLOPE, middle)
        low = (abs(middle) - planks / 2) * PLANK * math.sin(SLOPE)
        plank.position = middle * PLANK * math.cos(SLOPE), low
        shape = pymunk.Poly.create_box(plank, (PLANK, 0.2))
        shape.friction, shape.filter = 0.8, pymunk.ShapeFilter(group=1)
        space.add(plank, shape)
        join(space, before, plank, hole, (-PLANK / 2, 0))
        before, hole = plank, (PLANK / 2, 0)
    join(space, before, space.static_body, hole, (half, 0))
    space.strength = strength
    return space


def join(space, a, b, hole_a, hole_b):
    joint = pymunk.PivotJoint(a, b, hole_a, hole_b)
    joint.collide_bodies = False
    space.add(joint)


def break_joints(space, time):
    dt = space.current_time_step
    for joint in list(space.constraints):
        if dt and joint.impulse / dt > space.strength:
            space.remove(joint)


def drop(space):
    load = pymunk.Body(8, pymunk.moment_for_circle(8, 0, 0.4))
    load.position = 0, 3
    ball = pymunk.Circle(load, 0.4)
    ball.friction = 0.8
    space.add(load, ball)


def largest(space):
    dt = space.current_time_step or 1
    return max((joint.impulse / dt for joint in space.constraints), default=0)


controls = [
    Slider("planks", 6, 24, rebuilds=True, whole=True),
    Slider("strength", 500, 6000, rebuilds=True, unit="N"),
    Button("Drop a ball", drop),
]
plots = {"largest force (N)": largest}
with live(
    build,
    title="A bridge that breaks",
    view=(0, -1.5, 16, 7),
    step=1 / 240,
    on_step=break_joints,
    controls=controls,
    plots=plots,
) as session:
    session.wait()
