"""Smallest gap between the head bench and the other benches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.model.dragon import Dragon

__all__ = ["smallest_gap"]

Array = NDArray[np.float64]


def smallest_gap(dragon: Dragon, poses: Array) -> tuple[int, float] | None:
    """Return the bench closest to the head bench, its neighbour excluded, and the gap in m.

    Parameters
    ----------
    dragon : Dragon
        Sizes of the benches.
    poses : ndarray, shape (N, 3)
        Poses of the benches: centres in m, angles in rad.

    Returns
    -------
    tuple of int and float, or None
        Number of the bench, and the gap in m. The gap is 0 if a corner of one bench is inside the other. None if the
        dragon has fewer than 3 benches.
    """
    if dragon.benches < 3:
        return None
    corners = dragon.outlines(poses)
    # The distance between disjoint rectangles is always attained at a corner of one of them.
    to_head = _outside(corners[2:], poses[0], dragon.lengths[0], dragon.widths[0])
    from_head = _outside(corners[:1], poses[2:, None], dragon.lengths[2:, None], dragon.widths[2:, None])
    gaps = np.minimum(to_head.min(axis=1), from_head.min(axis=1))
    nearest = int(np.argmin(gaps))
    return nearest + 2, float(gaps[nearest])


def _outside(points: Array, poses: Array, lengths: Array, widths: Array) -> Array:
    """Return the distance of points (..., 2) to rectangles at `poses` (..., 3), m; 0 inside; leading axes broadcast."""
    offset = points - poses[..., :2]
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    along = np.abs(offset[..., 0] * cos + offset[..., 1] * sin) - lengths / 2
    across = np.abs(offset[..., 1] * cos - offset[..., 0] * sin) - widths / 2
    return np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
