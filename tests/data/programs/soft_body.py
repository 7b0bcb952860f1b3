"""Soft bodies.

Rings of balls with springs and a pressure inside fall onto steps.
"""

import math

import pymunk

from pymunk_dragon import Button, Slider, live

COUNT = 16
RADIUS = 60


def build(rings=3, pressure=40.0, stiffness=300.0):
    space = pymunk.Space()
    space.gravity = 0, 500
    space.damping = 0.8
    space.pressure = pressure
    space.rings = []
    for a, b in (((0, 450), (700, 450)), ((0, 0), (0, 450)), ((700, 0), (700, 450))):
        space.add(pymunk.Segment(space.static_body, a, b, 8))
    space.add(pymunk.Segment(space.static_body, (0, 250), (300, 380), 8))
    for shape in space.static_body.shapes:
        shape.friction = 0.7
    for i in range(rings):
        add_ring(space, (150 + 170 * i, 80), stiffness)
    return space


def add_ring(space, centre, stiffness=300.0):
    ring = []
    for i in range(COUNT):
        angle = 2 * math.pi * i / COUNT
        ball = pymunk.Body(0.2, 10)
        ball.position = centre + RADIUS * pymunk.Vec2d(math.cos(angle), math.sin(angle))
        circle = pymunk.Circle(ball, 9)
        circle.friction = 0.7
        space.add(ball, circle)
        ring.append(ball)
    for i in range(COUNT):
        for skip in (1, 3):
            a, b = ring[i], ring[(i + skip) % COUNT]
            rest = a.position.get_distance(b.position)
            space.add(pymunk.DampedSpring(a, b, (0, 0), (0, 0), rest, stiffness, 3))
    space.rings.append(ring)


def blow(space, time):
    for ring in space.rings:
        middle = sum((ball.position for ball in ring), pymunk.Vec2d.zero()) / COUNT
        for ball in ring:
            force = space.pressure * (ball.position - middle).normalized()
            ball.apply_force_at_world_point(force, ball.position)


def set_pressure(space, pressure):
    space.pressure = pressure


controls = [
    Slider("pressure", 0, 150, 40, action=set_pressure),
    Button("One more", lambda space: add_ring(space, (500, 60))),
]
with live(
    build,
    title="Soft bodies",
    view=(350, 225, 720, 470),
    step=1 / 240,
    on_step=blow,
    controls=controls,
    y_down=True,
    units="px",
) as session:
    session.wait()
