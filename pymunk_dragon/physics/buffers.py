"""Poses, velocities and forces of all bodies as arrays that `pymunk.batch` reads and writes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pymunk
from pymunk import batch
from pymunk.batch import BodyFields

from pymunk_dragon._arrays import Array

# Fields of all bodies that are read after a step or written before it. They are combined here, as
# that takes microseconds.
POSES = BodyFields.POSITION | BodyFields.ANGLE
VELOCITIES = BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
_POSES_AND_FORCES = POSES | BodyFields.FORCE | BodyFields.TORQUE


class Buffers:
    """Arrays over the memory that `pymunk.batch` reads and writes.

    Parameters
    ----------
    space : pymunk.Space
        The space of the benches, to which no body is added later.
    bodies : sequence of pymunk.Body
        Bodies of the benches.
    control : pymunk.Body
        Kinematic body with the exact poses of the head: the head's own, or another.
    anchors : sequence of pymunk.Body
        Anchors of the guide.

    Attributes
    ----------
    poses, forces : ndarray, shape (N, 3)
        Poses of the benches (m, m, rad) and forces on them (N, N, N m) that `write` writes.
    control : ndarray, shape (3,)
        Pose of the control body that `write` writes; a part of `poses` where that is the head's.
    anchors : ndarray, shape (A, 2)
        Positions of the anchors that `write` writes, m.
    """

    def __init__(
        self,
        space: pymunk.Space,
        bodies: Sequence[pymunk.Body],
        control: pymunk.Body,
        anchors: Sequence[pymunk.Body],
    ) -> None:
        self._space = space
        # A step takes time for every body of its space, and anchors need no steps: theirs is never
        # stepped.
        self._anchor_space = pymunk.Space()
        self._anchor_space.add(*anchors)
        # Pymunk adds its static body when it is first used, as for an obstacle; a row is written
        # for each body.
        moved = list(dict.fromkeys([*bodies, control, space.static_body]))
        _check_order(space, moved)
        _check_order(self._anchor_space, anchors)

        self._inbox = batch.Buffer()
        self._outbox = batch.Buffer()
        self._anchor_outbox = batch.Buffer()
        rows = np.zeros((len(moved), 6))
        self._outbox.set_float_buf(rows)
        self._benches = len(bodies)
        self.poses = rows[: self._benches, :3]
        self.forces = rows[: self._benches, 3:]
        self.control = rows[moved.index(control), :3]
        self.anchors = np.zeros((len(anchors), 2))
        self._anchor_outbox.set_float_buf(self.anchors)

    def read(self, fields: BodyFields) -> Array:
        """`POSES` or `VELOCITIES` (N, 3) of the benches in the space: m, m, rad and per s.

        More fields are read separately, as NumPy is slow on parts of rows.
        """
        self._inbox.clear()
        batch.get_space_bodies(self._space, fields, self._inbox)
        values = np.frombuffer(self._inbox.float_buf(), count=3 * self._benches)
        return values.reshape(-1, 3).copy()

    def write(self) -> None:
        """Write the arrays to the spaces."""
        batch.set_space_bodies(self._space, _POSES_AND_FORCES, self._outbox)
        batch.set_space_bodies(self._anchor_space, BodyFields.POSITION, self._anchor_outbox)


def _check_order(space: pymunk.Space, bodies: Sequence[pymunk.Body]) -> None:
    """Raise an error if `pymunk.batch` has other rows than those of `bodies`."""
    ids = batch.Buffer()
    batch.get_space_bodies(space, BodyFields.BODY_ID, ids)
    listed = memoryview(ids.int_buf()).cast("P").tolist()
    if listed != [body.id for body in bodies]:
        raise RuntimeError("pymunk.batch lists the bodies in another order than they were added")
