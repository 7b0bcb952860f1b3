"""Galton board.

Balls fall through rows of pins, and their heaps are a binomial distribution.
"""

import random

import pymunk

from pymunk_dragon import Button, Slider, live

PITCH = 30  # px between pins


def build(rows=8, balls=150, elasticity=0.3):
    space = pymunk.Space()
    space.gravity = 0, 600
    top, middle = 100, 300
    for row in range(rows):
        for i in range(row + 1):
            x = middle + PITCH * (i - row / 2)
            add_static(space, pymunk.Circle(space.static_body, 4, (x, top + PITCH * row)))
    end = top + PITCH * rows
    for i in range(rows + 2):
        x = middle + PITCH * (i - (rows + 1) / 2)
        wall(space, (x, end), (x, end + 250))
    width = PITCH * (rows + 1) / 2
    wall(space, (middle - width, end + 250), (middle + width, end + 250))
    wall(space, (middle - width, end), (middle - 12, top - 30))
    wall(space, (middle + width, end), (middle + 12, top - 30))
    wall(space, (middle - 12, top - 30), (middle - 160, -200))
    wall(space, (middle + 12, top - 30), (middle + 160, -200))

    chance = random.Random(4)
    for i in range(balls):
        ball = pymunk.Body(1, 20)
        ball.position = middle + chance.uniform(-60, 60), top - 120 - 12 * (i // 8)
        shape = pymunk.Circle(ball, 5)
        shape.elasticity = elasticity
        space.add(ball, shape)
    return space


def wall(space, a, b):
    add_static(space, pymunk.Segment(space.static_body, a, b, 2))


def add_static(space, shape):
    shape.elasticity = 0.3
    shape.friction = 0.1
    space.add(shape)


def shake(space):
    for ball in space.bodies:
        ball.velocity += 0, -150


controls = [
    Slider("rows", 4, 12, rebuilds=True, whole=True),
    Slider("balls", 20, 300, rebuilds=True, whole=True),
    Button("Shake", shake),
]
session = live(
    build,
    title="Galton board",
    view=(300, 175, 340, 840),
    step=1 / 240,
    controls=controls,
    y_down=True,
    units="px",
)
session.wait()
session.stop()
