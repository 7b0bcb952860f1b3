"""Conveyor belts.

Boxes fall onto a belt, which carries them to a second one.
"""

import random

import pymunk

from pymunk_dragon import Button, Slider, live

EVERY = 120  # steps between boxes


def build(speed=1.5):
    space = pymunk.Space()
    space.gravity = 0, -9.81
    space.random = random.Random(1)
    space.count = 0
    for (a, b), sign in ((((-4, 2), (1, 2.4)), 1), (((4, 0), (-2, 0.2)), -1)):
        belt = pymunk.Segment(space.static_body, a, b, 0.1)
        belt.friction = 1.0
        belt.surface_velocity = sign * speed, 0
        space.add(belt)
    return space


def add_box(space):
    size = space.random.uniform(0.25, 0.5)
    box = pymunk.Body(size**2, pymunk.moment_for_box(size**2, (size, size)))
    box.position = -3.5 + space.random.uniform(-0.2, 0.2), 4
    shape = pymunk.Poly.create_box(box, (size, size), 0.02)
    shape.friction = 0.8
    shape.color = (230, 160, 60, 255)
    space.add(box, shape)


def on_step(space, time):
    space.count += 1
    if space.count % EVERY == 0:
        add_box(space)
    for body in list(space.bodies):
        if body.position.y < -4:
            space.remove(body, *body.shapes)


def set_speed(space, speed):
    for i, belt in enumerate(space.static_body.shapes):
        belt.surface_velocity = (-1) ** i * speed, 0


controls = [
    Slider("speed", -3, 3, 1.5, action=set_speed, unit="m/s"),
    Button("A box more", add_box),
]
plots = {"boxes": lambda space: len(space.bodies)}
with live(
    build,
    title="Conveyor belts",
    view=(0, 1, 9, 4.5),
    step=1 / 240,
    on_step=on_step,
    controls=controls,
    plots=plots,
) as session:
    session.wait()
