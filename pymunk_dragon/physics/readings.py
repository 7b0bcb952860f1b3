"""State of a Pymunk space as numbers, for pictures and charts: joints, contacts, energies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pymunk
from pymunk import batch
from pymunk.batch import ArbiterFields

from pymunk_dragon._arguments import Array, as_complex
from pymunk_dragon.errors import ParameterError

# Impulse in the row of a contact point that has no arrow: that of its pair is in another row.
NO_ARROW = -1.0
# What is read of each pair in contact.
_FLOATS = ArbiterFields.TOTAL_IMPULSE | ArbiterFields.NORMAL | ArbiterFields.POINT_A_1 | ArbiterFields.POINT_A_2
_INTS = ArbiterFields.BODY_A_ID | ArbiterFields.BODY_B_ID | ArbiterFields.IS_FIRST_CONTACT | ArbiterFields.CONTACT_COUNT


class Readings:
    """Readings of all bodies, or all contacts, of a space at once."""

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        # Kept, as Pymunk never frees the memory of a buffer.
        self._bodies, self._arbiters = batch.Buffer(), batch.Buffer()

    def are_finite(self) -> bool:
        """Whether all bodies have finite positions."""
        self._bodies.clear()
        batch.get_space_bodies(self._space, batch.BodyFields.POSITION, self._bodies)
        return bool(np.isfinite(np.frombuffer(self._bodies.float_buf())).all())

    def contact_begins(self) -> bool:
        """Whether a pair began to touch in the last step."""
        return bool(self._pairs()[1][:, 2].any())

    def contacts(self) -> Array:
        """Rows (C, 5) of point, normal and impulse of all contact points; the first one of a pair has its impulse."""
        pairs, flags = self._pairs()
        impulses, normals = np.hypot(pairs[:, 0], pairs[:, 1])[:, None], pairs[:, 2:4]
        first = np.hstack([pairs[:, 4:6], normals, impulses])[flags[:, 3] > 0]
        second = np.hstack([pairs[:, 6:8], normals, np.full_like(impulses, NO_ARROW)])[flags[:, 3] > 1]
        return np.vstack([first, second])

    def _pairs(self) -> tuple[Array, Any]:
        """Impulse, normal and two points of each pair; and its bodies, whether it is new, and its number of points."""
        buffer = self._arbiters
        buffer.clear()
        batch.get_space_arbiters(self._space, _FLOATS | _INTS, buffer)
        flags = np.frombuffer(buffer.int_buf(), np.uint64).reshape(-1, 4)
        pairs = np.frombuffer(buffer.float_buf()).reshape(-1, 8)
        if len(pairs) and math.isfinite(self._space.sleep_time_threshold):
            # Pymunk may list a pair that sleeps, and does not draw it.
            asleep = [body.id for body in self._space.bodies if body.is_sleeping]
            awake = ~np.isin(flags[:, :2], np.array(asleep, np.uint64)).any(axis=1)
            pairs, flags = pairs[awake], flags[awake]
        return pairs, flags


def arbiter_rows(arbiter: pymunk.Arbiter, solved: bool) -> list[tuple[float, ...]]:
    """The same rows of a pair in a callback, where its impulse is known if it is `solved`."""
    contact, impulses = arbiter.contact_point_set, (arbiter.total_impulse.length if solved else 0.0, NO_ARROW)
    points = zip(contact.points, impulses, strict=False)
    return [(*point.point_a, *contact.normal, impulse) for point, impulse in points]


def joint_rows(joints: Sequence[pymunk.Constraint], step: float) -> Array:
    """Rows (J, 5) of the two ends of joints and their forces in a step of so many s."""
    rows = [(*_end(joint, "a"), *_end(joint, "b"), joint.impulse / step) for joint in joints]
    return np.array(rows).reshape(-1, 5)


def joint_at(joints: Sequence[pymunk.Constraint], x: float, y: float, slip: float) -> pymunk.Constraint:
    """The joint whose line passes nearest to a point, if that is within `slip`."""
    rows, point = joint_rows(joints, 1.0), complex(x, y)
    begin, along = as_complex(rows[:, :2]), as_complex(rows[:, 2:4] - rows[:, :2])
    share = ((point - begin) / np.where(along == 0, 1, along)).real.clip(0, 1)
    distances = abs(begin + share * along - point)
    if not (distances <= slip).any():
        raise ParameterError("x, y", (x, y), "a point of a joint")
    return joints[int(np.nanargmin(distances))]


def grip(shape: pymunk.Shape) -> int:
    """How a hand holds a body by a shape: 2 if it can, 1 where it finds no other, 0 if it cannot.

    Only dynamic bodies are held. A sensor counts as empty ground, unless its body has only sensors.
    """
    body = shape.body
    if body is None or body.body_type != pymunk.Body.DYNAMIC:
        return 0
    if not shape.sensor:
        return 2
    return int(all(each.sensor for each in body.shapes))


def body_at(
    shapes: Sequence[pymunk.Shape],
    x: float,
    y: float,
    slip: float,
) -> tuple[pymunk.Body, pymunk.Vec2d]:
    """The body that a hand takes at a point, and its point that is nearest.

    Of `shapes`, in the order of drawing and with the best grip, that is the last that covers the
    point, or else the nearest within `slip`. What they collide with does not matter.
    """
    point = pymunk.Vec2d(x, y)
    near = []
    for shape in reversed(shapes):
        hold, body = grip(shape), shape.body
        if hold == 0 or body is None:
            continue
        found = shape.point_query(point)
        distance = max(found.distance, 0.0)
        if distance <= slip:
            # Pymunk (7.3.1) has NaN for a point on the edge of a polygon.
            nearest = found.point if distance > 0 else point
            near.append((-hold, distance, body, nearest))
    if not near:
        raise ParameterError("x, y", (x, y), "a point of a body that can be moved")
    best = min(near, key=lambda each: each[:2])
    return best[2], best[3]


def _end(joint: pymunk.Constraint, side: str) -> pymunk.Vec2d:
    """End of a joint on body "a" or "b" in the world: an anchor, or the position of the body."""
    body: pymunk.Body = getattr(joint, side)
    return body.local_to_world(getattr(joint, f"anchor_{side}", getattr(joint, f"groove_{side}", (0.0, 0.0))))


def energies(space: pymunk.Space) -> dict[str, float]:
    """Energy and momentum of all bodies that move, by their titles in charts."""
    moving = [body for body in space.bodies if body.body_type == pymunk.Body.DYNAMIC]
    # Pymunk leaves out the half.
    kinetic = sum(body.kinetic_energy for body in moving) / 2
    potential = -sum(body.mass * body.position.dot(space.gravity) for body in moving)
    momentum = sum((body.mass * body.velocity for body in moving), pymunk.Vec2d.zero()).length
    return {"Kinetic energy": kinetic, "Kinetic and potential energy": kinetic + potential, "Momentum": momentum}
