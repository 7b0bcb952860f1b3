"""Cloth.

A cloth hangs from two corners. Pull it, cut it with the tool Cut, and let the wind blow.
"""

import pymunk

from pymunk_dragon import Button, Slider, live

GAP = 20  # px between neighbours


def build(columns=16, rows=12, stiffness=800.0):
    space = pymunk.Space()
    space.gravity = 0, 500
    space.damping = 0.6
    space.iterations = 20
    grid = []
    for row in range(rows):
        grid.append([])
        for column in range(columns):
            knot = pymunk.Body(0.1, 10)
            knot.position = 150 + GAP * column, 60 + GAP * row
            circle = pymunk.Circle(knot, 4)
            circle.filter = pymunk.ShapeFilter(group=1)
            space.add(knot, circle)
            grid[row].append(knot)
            if column:
                space.add(thread(grid[row][column - 1], knot, stiffness))
            if row:
                space.add(thread(grid[row - 1][column], knot, stiffness))
    for corner in (grid[0][0], grid[0][-1]):
        space.add(pymunk.PivotJoint(space.static_body, corner, corner.position))
    return space


def thread(a, b, stiffness):
    return pymunk.DampedSpring(a, b, (0, 0), (0, 0), GAP, stiffness, 2)


def wind(space, strength):
    space.gravity = strength, 500


def drop(space):
    for joint in list(space.constraints):
        if isinstance(joint, pymunk.PivotJoint):
            space.remove(joint)


controls = [
    Slider("rows", 4, 20, rebuilds=True, whole=True),
    Slider("wind", -400, 400, 0, action=wind, unit="px/s²"),
    Button("Drop it", drop),
]
with live(
    build,
    title="Cloth",
    view=(300, 220, 520, 420),
    step=1 / 240,
    controls=controls,
    y_down=True,
    units="px",
) as session:
    session.wait()
