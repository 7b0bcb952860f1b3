"""Billiards.

Aim with the slider and strike with the key S; balls in a pocket leave the table.
"""

import math

import pymunk

from pymunk_dragon import Button, Key, Slider, live

RADIUS = 0.06
WIDTH, HEIGHT = 2.54, 1.27
POCKETS = [(x, y) for x in (0, WIDTH / 2, WIDTH) for y in (0, HEIGHT)]


def build(elasticity=0.93, rows=5):
    space = pymunk.Space()
    space.damping = 0.7
    space.aim = 0.0
    corners = [(0, 0), (WIDTH, 0), (WIDTH, HEIGHT), (0, HEIGHT)]
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        cushion = pymunk.Segment(space.static_body, a, b, 0.03)
        cushion.elasticity = elasticity
        space.add(cushion)
    space.white = add_ball(space, (0.5, HEIGHT / 2), elasticity, (245, 245, 245, 255))
    for row in range(rows):
        for i in range(row + 1):
            place = 1.7 + 1.8 * RADIUS * row, HEIGHT / 2 + 2.02 * RADIUS * (i - row / 2)
            color = (200, 60, 40, 255) if (row + i) % 2 else (230, 180, 40, 255)
            add_ball(space, place, elasticity, color)
    return space


def add_ball(space, place, elasticity, color):
    body = pymunk.Body(0.17, pymunk.moment_for_circle(0.17, 0, RADIUS))
    body.position = place
    ball = pymunk.Circle(body, RADIUS)
    ball.elasticity, ball.color = elasticity, color
    space.add(body, ball)
    return body


def pocket(space, time):
    for body in list(space.bodies):
        if any(body.position.get_distance(each) < 1.5 * RADIUS for each in POCKETS):
            if body is space.white:
                body.position, body.velocity = (0.5, HEIGHT / 2), (0, 0)
            else:
                space.remove(body, *body.shapes)


def aim(space, angle):
    space.aim = math.radians(angle)


def strike(space):
    impulse = 0.6 * pymunk.Vec2d.from_polar(1, space.aim)
    space.white.apply_impulse_at_world_point(impulse, space.white.position)


def on_draw(space, draw):
    for each in POCKETS:
        draw.circle(each, 1.2 * RADIUS, color="black", fill="black")
    white = space.white.position
    draw.arrow(white, white + 0.3 * pymunk.Vec2d.from_polar(1, space.aim), color="teal")
    draw.text((WIDTH / 4, HEIGHT + 0.09), f"{len(space.bodies) - 1} balls on the table")


controls = [
    Slider("rows", 1, 6, rebuilds=True, whole=True),
    Slider("aim", -180, 180, 0, action=aim, unit="°"),
    Button("Strike", strike),
    Key("s", strike),
]
plots = {"balls": lambda space: len(space.bodies)}
with live(
    build,
    title="Billiards",
    view=(1.27, 0.635, 2.8, 1.5),
    step=1 / 480,
    on_step=pocket,
    on_draw=on_draw,
    controls=controls,
    plots=plots,
) as session:
    session.wait()
