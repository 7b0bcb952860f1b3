"""When inside a substep two benches touched."""

from __future__ import annotations

import numpy as np
import pymunk
from numpy.typing import NDArray

from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.dragon import Dragon, interpolated
from pymunk_dragon.physics.callbacks import manifold
from pymunk_dragon.physics.world import bench_shape

__all__ = ["refined_contact"]

Array = NDArray[np.float64]

# Halvings of a substep: a hundredth of a second becomes 1e-11 s, far below what the engine's poses are worth.
BISECTIONS = 30


def refined_contact(
    dragon: Dragon, benches: tuple[int, int], before: Array, after: Array, times: tuple[float, float]
) -> Contact:
    """Contact of two benches that touch at the end of a substep, at the time within it when they began to.

    The benches move evenly from the poses `before` to the poses `after` (both (N, 3)); Pymunk's own shape test says
    whether they touch in between.

    Parameters
    ----------
    dragon : Dragon
        Whose benches they are.
    benches : tuple of int
        The two, the smaller number first.
    before, after : ndarray, shape (N, 3)
        Poses at the ends of the substep: m, m, rad.
    times : tuple of float
        Times at its ends, s.

    Returns
    -------
    Contact
        At the start of the substep if they touched there already.
    """
    pair = list(benches)
    begin, end = before[pair], after[pair]
    # Shape.shapes_collide fails an assertion of its own where shapes are apart (Pymunk 7.3.1); a query does not.
    space = pymunk.Space()
    bodies = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in pair]
    sizes = dragon.lengths[pair].tolist(), dragon.widths[pair].tolist()
    first, second = (bench_shape(body, *size) for body, size in zip(bodies, zip(*sizes, strict=True), strict=True))
    space.add(bodies[1], second)

    def touch(share: float) -> pymunk.ContactPointSet | None:
        for body, (x, y, angle) in zip(bodies, interpolated(begin, end, share).tolist(), strict=True):
            body.position = x, y
            body.angle = angle
        space.reindex_shapes_for_body(bodies[1])
        found = space.shape_query(first)
        return found[0].contact_point_set if found else None

    at_end = touch(1.0)
    assert at_end is not None, "the engine saw these shapes touch at these poses"
    apart, touching, at_touch = 0.0, 1.0, at_end
    if contact := touch(apart):
        touching, at_touch = apart, contact
    for _ in range(BISECTIONS):
        middle = (apart + touching) / 2
        if contact := touch(middle):
            touching, at_touch = middle, contact
        else:
            apart = middle
    points, normal, _ = manifold(at_touch, swapped=False)
    *_, depth = manifold(at_end, swapped=False)
    return Contact(
        time=times[0] + touching * (times[1] - times[0]),
        raw_time=times[1],
        benches=benches,
        point=points[0],
        normal=normal,
        depth=depth,
    )
