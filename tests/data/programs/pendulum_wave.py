"""Pendulum wave.

Fifteen pendulums whose lengths differ so that all are together again after 30 s.
"""

import math

import pymunk

from pymunk_dragon import Slider, live

G = 9.81
TOGETHER = 30.0  # s
FIRST = 20  # swings of the longest in that time


def build(count=15, angle=0.35):
    space = pymunk.Space()
    space.gravity = 0, -G
    space.iterations = 30
    space.collision_slop = 0.001
    for i in range(count):
        period = TOGETHER / (FIRST + i)
        length = G * (period / (2 * math.pi)) ** 2
        x = 0.12 * i
        bob = pymunk.Body(1, pymunk.moment_for_circle(1, 0, 0.03))
        bob.position = x + length * math.sin(angle), -length * math.cos(angle)
        ball = pymunk.Circle(bob, 0.03)
        ball.filter = pymunk.ShapeFilter(mask=0b10)
        hue = 255 * i // max(count - 1, 1)
        ball.color = (hue, 90, 255 - hue, 255)
        space.add(bob, ball, pymunk.PinJoint(space.static_body, bob, (x, 0), (0, 0)))
    return space


def angle_of(number):
    def value(space):
        joints = list(space.constraints)
        joint = joints[min(number, len(joints) - 1)]
        x, y = joint.b.position - joint.anchor_a
        return math.degrees(math.atan2(x, -y))

    return value


controls = [
    Slider("count", 2, 30, rebuilds=True, whole=True),
    Slider("angle", 0.05, 1.0, rebuilds=True, unit="rad"),
]
plots = {"longest (°)": angle_of(0), "shortest (°)": angle_of(14)}
with live(
    build,
    title="Pendulum wave",
    view=(0.89, -0.35, 2.2, 1.2),
    step=1 / 480,
    controls=controls,
    plots=plots,
) as session:
    session.wait()
