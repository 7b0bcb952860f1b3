"""Joints as Pymunk's debug drawing draws them, with one line for a spring in place of fourteen."""

from __future__ import annotations

import math

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array, as_complex, as_vectors
from pymunk_dragon.physics.readings import sleeps
from pymunk_dragon.web.frames import KINDS

# Points of a spring of Chipmunk's along its length.
_ALONG = np.array([0, 0.2, *np.linspace(0.25, 0.75, 11), 0.8, 1])
# Their distances from it, in units of the space.
_ACROSS = np.array([0, 0, 3, -6, 6, -6, 6, -6, 6, -6, 6, -3, 6, 0, 0])
# Length of a spring in pixels that is as wide, in proportion, as springs in other units.
_COILED = 40.0
# Radius of the ends of joints, pixels.
_DOT = 5.0


# Kind and radius of calls, and the points (n, K, 2) of each.
_Calls = tuple[str, float, Array]


def joint_calls(space: pymunk.Space, ends: Array, units: str) -> list[_Calls]:
    """Dots and lines of the joints of a space that are awake.

    The `ends` (J, 4) are in the world. All have one colour: their order does not matter. Chipmunk's
    coils are made for pixels: in other units, a spring has coils in proportion to its length.
    """
    can_sleep = math.isfinite(space.sleep_time_threshold)
    dots: list[list[float]] = []
    lines: list[list[float]] = []
    springs: list[list[float]] = []
    for joint, both in zip(space.constraints, ends.tolist(), strict=True):
        if can_sleep and sleeps(joint):
            continue
        a, b = both[:2], both[2:]
        match joint:
            case pymunk.DampedSpring():
                # Without a length it has no direction, and no line.
                if a != b:
                    springs.append(both)
            case pymunk.PinJoint() | pymunk.SlideJoint():
                lines.append(both)
            case pymunk.GrooveJoint():
                lines.append([*a, *joint.a.local_to_world(joint.groove_b)])
                dots.append(b)
                continue
            case pymunk.PivotJoint():
                pass
            case _:
                continue
        dots += [a, b]

    begin, end = as_complex(np.reshape(springs, (-1, 2, 2))).T
    along = (end - begin)[:, None]
    width = abs(along) if units == "px" else _COILED
    coils = begin[:, None] + along * (_ALONG + 1j * _ACROSS / width)
    return [
        ("dot", _DOT, np.reshape(dots, (-1, 1, 2))),
        ("line", 0.0, np.reshape(lines, (-1, 2, 2))),
        ("line", 0.0, as_vectors(coils)),
    ]


def joint_numbers(calls: list[_Calls]) -> Array:
    """Calls as `packed` has them, in the colour with the number 0."""
    found = []
    for kind, radius, points in calls:
        count, corners, _ = points.shape
        head = np.tile([KINDS[kind], corners, radius, 0, 0, -1, 0], (count, 1))
        found.append(np.hstack([head, points.reshape(count, 2 * corners)]).ravel())
    return np.concatenate(found)
