"""A car on hills.

Drive with the arrow keys; the car has springs and a motor at each wheel.
"""

import itertools
import math

import pymunk

from pymunk_dragon import Key, Slider, live

keys = {"speed": 0}


def build(stiffness=400.0, grip=1.5):
    space = pymunk.Space()
    space.gravity = 0, -9.81
    heights = [0.7 * math.sin(0.45 * x) * min(1, abs(x) / 8) for x in range(-10, 31)]
    for i, (left, right) in enumerate(itertools.pairwise(heights)):
        ground = pymunk.Segment(space.static_body, (i - 10, left), (i - 9, right), 0.1)
        ground.friction = 1.0
        space.add(ground)

    car = pymunk.ShapeFilter(group=1)
    chassis = pymunk.Body(10, pymunk.moment_for_box(10, (2.4, 0.5)))
    chassis.position = 0, 1.4
    body = pymunk.Poly.create_box(chassis, (2.4, 0.5))
    body.filter = car
    space.add(chassis, body)
    space.chassis = chassis
    for x in (-0.9, 0.9):
        wheel = pymunk.Body(1, pymunk.moment_for_circle(1, 0, 0.4))
        wheel.position = x, 0.75
        tyre = pymunk.Circle(wheel, 0.4)
        tyre.friction, tyre.filter = grip, car
        groove = pymunk.GrooveJoint(chassis, wheel, (x, -0.3), (x, -0.9), (0, 0))
        spring = pymunk.DampedSpring(chassis, wheel, (x, 0), (0, 0), 0.8, stiffness, 20)
        motor = pymunk.SimpleMotor(chassis, wheel, 0)
        motor.max_force = 30
        space.add(wheel, tyre, groove, spring, motor)
    return space


def drive(space, time):
    for joint in space.constraints:
        if isinstance(joint, pymunk.SimpleMotor):
            joint.rate = keys["speed"]


def faster(space):
    keys["speed"] = 15


def back(space):
    keys["speed"] = -15


def roll(space):
    keys["speed"] = 0


controls = [
    Key("ArrowRight", faster, up=roll),
    Key("ArrowLeft", back, up=roll),
    Slider("stiffness", 150, 1000, rebuilds=True, unit="N/m"),
]
with live(
    build,
    title="A car on hills",
    view=(0, 0.5, 16, 7),
    follow=lambda space: space.chassis,
    step=1 / 240,
    on_step=drive,
    controls=controls,
) as session:
    session.wait()
