"""Platformer.

Left and right arrows walk, the space bar jumps; one platform moves, and boxes can be pushed.
"""

import math

import pymunk

from pymunk_dragon import Key, Slider, live

held = set()


def build(jump=420.0):
    space = pymunk.Space()
    space.gravity = 0, 900
    for a, b in (((0, 400), (700, 400)), ((0, 0), (0, 400)), ((700, 0), (700, 400))):
        floor = pymunk.Segment(space.static_body, a, b, 5)
        floor.friction = 1.0
        space.add(floor)
    for x, y in ((150, 320), (550, 250)):
        ledge = pymunk.Segment(space.static_body, (x - 60, y), (x + 60, y), 5)
        ledge.friction = 1.0
        space.add(ledge)

    space.lift = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    space.lift.position = 350, 300
    plank = pymunk.Segment(space.lift, (-50, 0), (50, 0), 5)
    plank.friction = 1.0
    space.add(space.lift, plank)
    for i in range(3):
        box = pymunk.Body(1, pymunk.moment_for_box(1, (30, 30)))
        box.position = 450 + 50 * i, 370
        shape = pymunk.Poly.create_box(box, (30, 30))
        shape.friction = 0.6
        space.add(box, shape)

    space.player = pymunk.Body(5, math.inf)
    space.player.position = 60, 360
    space.feet = pymunk.Circle(space.player, 14, (0, 14))
    space.add(space.player, space.feet, pymunk.Circle(space.player, 14, (0, -10)))
    space.jump = jump
    return space


def on_step(space, time):
    space.lift.velocity = 80 * math.cos(time), 0
    walk = ("right" in held) - ("left" in held)
    space.feet.friction = 0.2 if walk else 2.0
    if walk:
        space.player.velocity = 180 * walk, space.player.velocity.y


def on_ground(player):
    found = []
    player.each_arbiter(lambda arbiter: found.append(abs(arbiter.normal.y) > 0.5))
    return any(found)


def jump(space):
    if on_ground(space.player):
        space.player.velocity = space.player.velocity.x, -space.jump


controls = [
    Key("ArrowLeft", lambda space: held.add("left"), up=lambda space: held.discard("left")),
    Key("ArrowRight", lambda space: held.add("right"), up=lambda space: held.discard("right")),
    Key(" ", jump),
    Slider("jump", 200, 700, rebuilds=True, unit="px/s"),
]
settings = {"step": 1 / 240, "y_down": True, "units": "px"}
with live(
    build,
    title="Platformer",
    view=(350, 200, 500, 400),
    follow=lambda space: space.player,
    on_step=on_step,
    controls=controls,
    **settings,
) as session:
    session.wait()
