"""Joints as Pymunk's debug drawing draws them, with one line for a spring in place of fourteen."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pymunk
from pymunk.space_debug_draw_options import SpaceDebugColor

from pymunk_dragon._arrays import Array
from pymunk_dragon.physics.draw_calls import DrawCall
from pymunk_dragon.physics.readings import sleeps

# Points of a spring of Chipmunk's along its length.
_ALONG = np.array([0, 0.2, *np.linspace(0.25, 0.75, 11), 0.8, 1])
# Their distances from it, in units of the space.
_ACROSS = np.array([0, 0, 3, -6, 6, -6, 6, -6, 6, -6, 6, -3, 6, 0, 0])
# Radius of the ends of joints, pixels.
_DOT = 5.0


def joint_calls(space: pymunk.Space, ends: Array, colour: SpaceDebugColor) -> Iterator[DrawCall]:
    """Dots and lines of the joints of a space that are awake; `ends` (J, 4) are in the world."""
    begin, end = ends[:, :2], ends[:, 2:]
    along = end - begin
    length = np.hypot(*along.T)[:, None]
    # A spring without a length has no direction, and no line.
    across = along[:, ::-1] * (-1, 1) / np.where(length > 0, length, np.nan)
    coils = begin[:, None] + along[:, None] * _ALONG[:, None] + across[:, None] * _ACROSS[:, None]

    can_sleep = math.isfinite(space.sleep_time_threshold)
    found = zip(space.constraints, begin.tolist(), end.tolist(), coils.tolist(), strict=True)
    for joint, a, b, coil in found:
        if can_sleep and sleeps(joint):
            continue
        dots = [a, b]
        line: list[Any] = []
        match joint:
            case pymunk.DampedSpring():
                line = coil if a != b else []
            case pymunk.PinJoint() | pymunk.SlideJoint():
                line = dots
            case pymunk.GrooveJoint():
                line = [a, joint.a.local_to_world(joint.groove_b)]
                dots = [b]
            case pymunk.PivotJoint():
                pass
            case _:
                continue
        for dot in dots:
            yield DrawCall("dot", (dot,), _DOT, colour)
        if line:
            yield DrawCall("line", tuple(line), 0.0, colour)
