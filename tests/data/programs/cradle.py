"""Newton's cradle.

As many balls leave on one side as arrive on the other.
"""

import pymunk

from pymunk_dragon import Button, Slider, live

RADIUS = 0.25
LENGTH = 2.0


def build(balls=5, raised=2, elasticity=1.0):
    space = pymunk.Space()
    space.gravity = 0, -9.81
    space.iterations = 30
    for i in range(balls):
        x = 2 * RADIUS * (i - (balls - 1) / 2)
        ball = pymunk.Body(1, pymunk.moment_for_circle(1, 0, RADIUS))
        ball.position = (x, 0) if i >= raised else (x - LENGTH, LENGTH)
        shape = pymunk.Circle(ball, RADIUS)
        shape.elasticity = elasticity
        rope = pymunk.PinJoint(space.static_body, ball, (x, LENGTH), (0, 0))
        space.add(ball, shape, rope)
    return space


def push(space):
    next(iter(space.bodies)).apply_impulse_at_local_point((-3, 0))


def energy(space):
    return sum(body.kinetic_energy + 9.81 * body.mass * body.position.y for body in space.bodies)


controls = [
    Slider("balls", 2, 9, rebuilds=True, whole=True),
    Slider("raised", 0, 4, rebuilds=True, whole=True),
    Button("Push", push),
]
with live(
    build,
    title="Newton's cradle",
    view=(0, 1, 8, 3.2),
    step=1 / 600,
    controls=controls,
    plots={"energy (J)": energy},
) as session:
    session.wait()
