#!/usr/bin/env bash
# Pymunk: a copy of a space (`space.copy()`, or a pickle) does not go on as the original does.
#
# Expected: a copy has the state of the original, so both have the same velocities after one more
# step. Of what is not copied, the documentation names callbacks after a step only.
# Seen: three things are lost. Joints have no impulses, so a chain that hangs sags by a jolt.
# Pairs that a callback has switched off by `process_collision = False` collide, as `begin` is not
# called again. The corners of a box are numbered from another one on, so the contacts of boxes do
# not find their impulses of the step before, and a stack sinks; balls, whose contacts have no
# corners, go on as before.
# Versions: pymunk 7.3.1, cffi 2.1.1, CPython 3.11.7, Linux on x86-64.
# Source: measurement; Pymunk writes contacts with their impulses, but no impulses of joints and
# no `process_collision` of an arbiter, and Munk2D's convex hull begins at another corner when the
# corners of a hull are given to it again. Pymunk's issue 181 names impulses of springs that are 0
# in a pickle, and other causes, which are mended.
# Why it matters: a save that is loaded, or a copy for looking ahead, differs from the first step
# on. Where the same run is needed, build it again from its inputs.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pymunk==7.3.1 cffi==2.1.1

"$folder/venv/bin/python" - <<'PROGRAM'
import pickle
import sys

import pymunk


def refused(arbiter, space, data):
    arbiter.process_collision = False


def chain(space):
    before = space.static_body
    for number in range(5):
        link = pymunk.Body(1, 0.1)
        link.position = number, 0
        space.add(link, pymunk.PivotJoint(before, link, (number - 0.5, 0)))
        before = link


def ball_that_is_let_through(space):
    floor, body = pymunk.Segment(space.static_body, (-9, -1), (9, -1), 0.05), pymunk.Body(1, 1)
    space.add(floor, body, pymunk.Circle(body, 1))
    space.on_collision(begin=refused)


def stack(space, shape):
    space.add(pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0))
    for number in range(3):
        body = pymunk.Body(1, 1)
        body.position = 0, 0.98 * number + 0.49
        space.add(body, shape(body))


def boxes(space):
    stack(space, lambda body: pymunk.Poly.create_box(body, (2, 1)))


def balls(space):
    stack(space, lambda body: pymunk.Circle(body, 0.5))


COPIES = {"copy": pymunk.Space.copy, "pickle": lambda space: pickle.loads(pickle.dumps(space))}
DIFFERS = {chain: True, ball_that_is_let_through: True, boxes: True, balls: False}


def difference(build, copied):
    """Largest difference of a velocity after one step of the original and of its copy, m/s."""
    space = pymunk.Space()
    space.gravity, space.iterations = (0, -10), 1
    build(space)
    for _ in range(10):
        space.step(0.01)
    copy = copied(space)
    for each in (space, copy):
        each.step(0.01)
    pairs = zip(space.bodies, copy.bodies)
    return max((one.velocity - other.velocity).length for one, other in pairs)


same = True
for name, copied in COPIES.items():
    for build, differs in DIFFERS.items():
        found = difference(build, copied)
        print(f"{name:6} {build.__name__:24} {found:.6f} m/s off after one step")
        same = same and (found > 1e-3 if differs else found < 1e-9)
sys.exit(0 if same else "this is no longer what was found")
PROGRAM
