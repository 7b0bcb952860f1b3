"""Joints as Pymunk's debug drawing draws them, with one line for a spring in place of fourteen."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pymunk
from pymunk.space_debug_draw_options import SpaceDebugColor

from pymunk_dragon._arrays import Array
from pymunk_dragon.drawing.debug_draw import DrawCall
from pymunk_dragon.physics.readings import sleeps

# That of Pymunk's constraints, which differs from the ground of light and dark pages.
COLOUR = SpaceDebugColor(142, 68, 173, 255)
# Points of a spring of Chipmunk's along its length.
_ALONG = np.array([0, 0.2, *np.linspace(0.25, 0.75, 11), 0.8, 1])
# Their distances from it, in units of the space.
_ACROSS = np.array([0, 0, 3, -6, 6, -6, 6, -6, 6, -6, 6, -3, 6, 0, 0])
# Length of a spring, pixels, as wide as those in metres are in proportion.
_COILED = 40.0
# Radius of the ends of joints, pixels.
_DOT = 5.0


def joint_calls(space: pymunk.Space, rows: Array, units: str) -> Iterator[DrawCall]:
    """Dots and lines of the joints of a space that are awake; their ends begin the `rows` (J, 4+).

    Chipmunk's coils are made for pixels: a spring in metres has coils in proportion to its length.
    """
    begin, end = rows[:, :2], rows[:, 2:4]
    along = end - begin
    length = np.hypot(*along.T)[:, None]
    # A spring without a length has no direction, and no line.
    width = np.where(length > 0, length, np.nan) if units == "px" else _COILED
    across = along[:, ::-1] * (-1, 1) / width
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
            yield DrawCall("dot", (dot,), _DOT, COLOUR)
        if line:
            yield DrawCall("line", tuple(line), 0.0, COLOUR)
