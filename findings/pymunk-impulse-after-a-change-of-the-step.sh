#!/usr/bin/env bash
# Pymunk: an impulse divided by the step is not the force once the length of the step has changed.
#
# Expected: a joint and a floor that carry 1 kg at 10 m/s² read 10 N (`impulse / step`,
# `total_impulse / step`) in every step, whatever its length, as they do while the step stays the
# same.
# Seen: with steps of 10 ms and 5 ms in turns both read 3.33 N in the long ones and 13.33 N in the
# short ones, for ever. After a single change from 10 to 5 ms the first step reads 20 N. The
# motion is right, as only what is stored is wrong.
# Versions: pymunk 7.3.1, cffi 2.1.1, CPython 3.11.7, Linux on x86-64.
# Source: measurement; and the code of Munk2D's cpSpaceStep, which applies the stored impulse
# times the ratio of the two steps, while the functions of joints and arbiters go on adding to the
# stored impulse of the old step. With J in a long step: J' = 0.1 - J, then J = J' / 2 + 0.05, so
# J is 0.0667 and J' 0.0333 N s. Pymunk's issue 282 recommends equal steps for the sake of
# stability; this consequence is not mentioned there or in the documentation.
# Why it matters: readings of forces, and everything that breaks or sounds above a force, are off
# by factors of 1/3 to 2 in programs that pass the time of a frame as the step.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pymunk==7.3.1 cffi==2.1.1

"$folder/venv/bin/python" - <<'PROGRAM'
import sys

import pymunk

STEPS = [0.01] * 5 + [0.005] * 3 + [0.01, 0.005] * 40  # s


def joint_forces():
    """Forces in a joint that holds 1 kg, N."""
    space, body = pymunk.Space(), pymunk.Body(1, 1)
    space.gravity = 0, -10
    joint = pymunk.PivotJoint(space.static_body, body, (0, 0), (0, 0))
    space.add(body, joint)
    forces = []
    for step in STEPS:
        space.step(step)
        forces.append(joint.impulse / step)
    return forces


def contact_forces():
    """Forces on a ball of 1 kg that lies on a floor, N."""
    space, body, forces = pymunk.Space(), pymunk.Body(1, 1), []
    space.gravity = 0, -10
    floor = pymunk.Segment(space.static_body, (-9, -1), (9, -1), 0.05)
    space.add(body, pymunk.Circle(body, 1), floor)

    def solved(arbiter, space, data):
        forces.append(arbiter.total_impulse.length / step)

    space.on_collision(post_solve=solved)
    for step in STEPS:
        space.step(step)
    return forces


same = True
for name, forces in (("joint", joint_forces()), ("contact", contact_forces())):
    chosen = *forces[4:7], *forces[-2:]
    seen = [round(force, 2) for force in chosen]
    print(f"{name}: {seen[0]} N in steps of 10 ms, {seen[1]} then {seen[2]} N in the next of 5 ms,")
    print(f"    {seen[3]} and {seen[4]} N where both come in turns")
    same = same and seen == [10.0, 20.0, 10.0, 3.33, 13.33]
sys.exit(0 if same else "this is no longer what was found")
PROGRAM
