#!/usr/bin/env bash
# Pymunk: `pymunk.batch.get_space_arbiters` lists pairs that do not touch any more.
#
# Expected: "data for all active arbiters in the space" are those of the pairs that touch after
# the step.
# Seen: a pair stays in the list for some steps after it has come apart, as many as
# `space.collision_persistence` less one, with a count of contact points of 0. The count does not
# tell it from a sensor, which is listed with a count of 0 while it touches.
# Versions: pymunk 7.3.1, cffi 2.1.1, CPython 3.11.7, Linux on x86-64.
# Source: measurement; and the code of Pymunk's extension of Munk2D, which goes over all cached
# arbiters, while Munk2D keeps those that are separated for `collision_persistence` steps.
# Why it matters: whoever counts the rows, or colours the bodies in them, shows contacts that are
# over.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pymunk==7.3.1 cffi==2.1.1

"$folder/venv/bin/python" - <<'PROGRAM'
import sys

import pymunk
from pymunk import batch


def listed(space):
    """Numbers of contact points of all pairs that are listed."""
    buffer = batch.Buffer()
    batch.get_space_arbiters(space, batch.ArbiterFields.CONTACT_COUNT, buffer)
    return list(memoryview(buffer.int_buf()).cast("P"))


def after_the_end(persistence, sensor=False):
    """What is listed while two balls touch, and in each of the six steps after that."""
    space, bodies, ended = pymunk.Space(), [], []
    space.collision_persistence = persistence
    for number in range(2):
        body = pymunk.Body(1, 1)
        body.position = 1.8 * number, 0
        shape = pymunk.Circle(body, 1)
        shape.sensor = sensor
        space.add(body, shape)
        bodies.append(body)
    space.on_collision(separate=lambda *_: ended.append(step))
    space.step(0.01)
    while_touching, later = listed(space), []
    bodies[1].position = 9, 0
    for step in range(6):
        space.step(0.01)
        later.append(listed(space))
    assert ended == [0], "the pair has not come apart in the first of these steps"
    return while_touching, later


same = True
for persistence in (3, 5):
    touching, later = after_the_end(persistence)
    print(f"collision_persistence {persistence}: {touching} while they touch, then {later}")
    stale = persistence - 1
    same = same and touching == [1] and later == [[0]] * stale + [[]] * (6 - stale)
touching, later = after_the_end(3, sensor=True)
print(f"sensors: {touching} while they touch, then {later}")
same = same and touching == [0] and later[0] == [0]
sys.exit(0 if same else "this is no longer what was found")
PROGRAM
