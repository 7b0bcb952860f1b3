#!/usr/bin/env bash
# Pymunk: a body whose `center_of_gravity` is set after its `position` jumps by it in the next step.
#
# Expected: `center_of_gravity` is a property in the body's own coordinates, so setting it leaves
# the body where it is, whatever the order of the two assignments.
# Seen: `position` reads as before until the next step, and then differs by the centre of gravity,
# turned with the body: a body at (3, 0) with the centre (1, 0) is at (2, 0). With the position set
# last, it stays. No error and no warning is given.
# Versions: pymunk 7.3.1, cffi 2.1.1, CPython 3.11.7, Linux on x86-64.
# Source: measurement; Munk2D stores the position of the centre of gravity, and the setter of the
# centre does not change it, but the transformation of the body, from which `position` is read, is
# only computed again in the step.
# Why it matters: bodies are teleported by a distance of their own size in the first step, joints
# are torn, and potential energies change by m g times the offset.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pymunk==7.3.1 cffi==2.1.1

"$folder/venv/bin/python" - <<'PROGRAM'
import sys

import pymunk


def positions(order):
    """Positions of a body before and after a step without gravity; its properties are set in an order."""
    space, body = pymunk.Space(), pymunk.Body(1, 1)
    values = {"position": (3, 0), "center_of_gravity": (1, 0)}
    for name in order:
        setattr(body, name, values[name])
    space.add(body)
    before = tuple(body.position)
    space.step(0.01)
    return before, tuple(body.position)


last = positions(["position", "center_of_gravity"])
first = positions(["center_of_gravity", "position"])
print("centre set last: ", *last)
print("centre set first:", *first)
same = last == ((3.0, 0.0), (2.0, 0.0)) and first == ((3.0, 0.0), (3.0, 0.0))
sys.exit(0 if same else "this is no longer what was found")
PROGRAM
