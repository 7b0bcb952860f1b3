"""Narrow phase: whether two benches touch, and how far apart they are (paper, section 2.2).

The paper's test is the separating axis theorem: two convex shapes are apart exactly where a line fits between them. For
two rectangles, lines along their edges suffice. So the projections of both are compared on four axes: the length and
the width of each. If the projections leave a gap on any axis, the rectangles are apart. If they overlap on all four,
the rectangles overlap, and the shortest translation that separates them is along the axis of the smallest overlap
(S. Gottschalk et al., "OBBTree", SIGGRAPH 1996; C. Ericson, "Real-Time Collision Detection", 2005, section 4.4.1).

The widest gap is the distance only where an edge faces the other rectangle. Two rectangles that are nearest corner to
corner are further apart than any gap shows, so the distance comes from the corners: for convex shapes that are
apart, one of the two closest points is always a corner.

Points and vectors of the plane are complex numbers inside this module: turning by the angle of a unit vector ``u`` is
``z * u``, turning back is ``z * conj(u)``, and seen along ``u`` a vector has the real part ahead and the imaginary part
to the left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon._frozen import ArrayRecord, read_only
from pymunk_dragon.collision.outlines import checked_outlines
from pymunk_dragon.errors import ParameterError

__all__ = ["Separation", "axis_gaps", "overlap", "separation"]


# Pairs worked on at once: their temporaries, about 0.7 kB a pair, stay in a processor's second cache.
CHUNK = 2048


@dataclass(frozen=True, eq=False, repr=False)
class Separation(ArrayRecord):
    """How far two rectangles are apart, for pairs of any shape (...).

    Attributes
    ----------
    distance : ndarray, shape (...)
        Shortest distance between the two, m. Negative where they overlap: the shortest translation that parts them,
        along an edge normal. Zero where they touch. Its sign is that of the separating axis test, without tolerance.
    normal : ndarray, shape (..., 2)
        Unit vector from the first towards the second: between their closest points, or along the shortest separation.
        Moving the second along it by `-distance` makes overlapping ones touch.
    point : ndarray, shape (..., 2)
        Midway between the closest points, m. For overlapping ones: midway between where they touch once each has moved
        along the normal by half the depth, so a corner that overlaps an edge is half its depth ahead of this point.
        Where two parallel edges face each other, one of the points between them.

    Examples
    --------
    >>> from pymunk_dragon.model.dragon import outlines
    >>> square = outlines([[0, 0, 0]], [1.0], 1.0)[0]
    >>> separation(square, square + [3, 0]).point[0].item()
    1.5
    """

    distance: Array
    normal: Array
    point: Array

    def __post_init__(self) -> None:
        for array in (self.distance, self.normal, self.point):
            read_only(array)

    def __repr__(self) -> str:
        size = self.distance.size
        span = f", distance from {self.distance.min():g} m to {self.distance.max():g} m" if size else ""
        return f"Separation({size} pairs{span})"


def separation(first: ArrayLike, second: ArrayLike) -> Separation:
    """Signed distance, normal and contact point of pairs of rectangles.

    Parameters
    ----------
    first, second : array_like, shape (..., 4, 2)
        Corners in m, counter-clockwise, as `dragon.outlines` gives them; their leading shapes broadcast.

    Returns
    -------
    Separation
        Arrays of the broadcast leading shape, right to a few last digits of the largest coordinate.

    Raises
    ------
    ParameterError
        If an outline has another shape, a coordinate is not finite or beyond 1e9 m, a rectangle has no area or its
        corners run clockwise, or the shapes do not broadcast.

    Notes
    -----
    If two translations are equally short, or two pairs of points equally close, the result is one of them.

    Examples
    --------
    >>> from pymunk_dragon.model.dragon import outlines
    >>> square = outlines([[0, 0, 0]], [1.0], 1.0)[0]
    >>> apart = separation(square, square + [3, 0])
    >>> float(apart.distance), apart.normal.tolist()
    (2.0, [1.0, 0.0])
    """
    corners, shape = _paired(first, second)
    distance, normal, point = np.empty(shape), np.empty((*shape, 2)), np.empty((*shape, 2))
    for part in _parts(corners.shape[-1]):
        answer = _separate(corners[..., part])
        distance.reshape(-1)[part] = answer[0]
        normal.reshape(-1, 2).view(complex)[part, 0] = answer[1]
        point.reshape(-1, 2).view(complex)[part, 0] = answer[2]
    return Separation(distance, normal, point)


def axis_gaps(first: ArrayLike, second: ArrayLike) -> Array:
    """Gaps (..., 4) in m between the projections of two rectangles on the four axes, negative where they overlap.

    The axes are the first rectangle's length and width, then the second one's. The widest gap is at most the distance
    of the two, and equals it where an edge faces the other; where all four are negative it is minus the depth of the
    overlap.

    Parameters, and errors raised, are those of `separation`.
    """
    corners, shape = _paired(first, second)
    gaps = np.empty((*shape, 4))
    for part in _parts(corners.shape[-1]):
        gaps.reshape(-1, 4)[part] = _Pairs(corners[..., part]).gaps()[0].T
    return gaps


def overlap(first: ArrayLike, second: ArrayLike) -> NDArray[np.bool_]:
    """Whether two rectangles overlap or touch (...): the paper's test, and nothing else.

    Parameters, and errors raised, are those of `separation`; it is true exactly where `separation` is not positive.
    """
    return np.asarray((axis_gaps(first, second) <= 0).all(axis=-1))


class _Pairs:
    """P pairs of rectangles, each seen by both of its two: row 0 is the first rectangle's view, row 1 the second's."""

    def __init__(self, corners: Complex) -> None:
        rear_right, front_right, front_left, rear_left = corners.swapaxes(0, 1)
        along, left = (front_right - rear_right) / 2, (rear_left - rear_right) / 2
        wrong = ~((along.conj() * left).imag > 0)
        if wrong.any():
            side, pair = np.argwhere(wrong)[0]
            shown = corners[side, :, pair].view(float).tolist()
            raise ParameterError(("first", "second")[side], shown, "rectangles with an area, counter-clockwise")
        # Both summands point ahead, and the longer side, which rounding turns least, weighs most.
        ahead = along - 1j * left
        self.centre = (rear_right + front_left) / 2  # (2, P)
        self.heading = ahead / np.abs(ahead)  # (2, P), unit
        self.half = np.abs(along) + 1j * np.abs(left)  # (2, P): half the length ahead, half the width to the left

    def gaps(self) -> tuple[Array, Array]:
        """Gaps between the projections on the four axes, and offsets of the second centre there, each (4, P)."""
        facing = self.heading.conj()
        offset = (self.centre[1] - self.centre[0]) * facing
        turn = self.heading[1] * facing[0]
        other = self.half[::-1]
        # On the axes of the other rectangle, both the length and the width have a projection.
        projection = np.abs(turn.real) * other + np.abs(turn.imag) * (1j * other.conj())
        covered = _by_component(self.half + projection)
        offsets = _by_component(offset)
        return np.abs(offsets) - covered, offsets


def _by_component(z: Complex) -> Array:
    """Real and imaginary parts (4, P) of the two rows of `z` (2, P), in turn."""
    return np.array((z[0].real, z[0].imag, z[1].real, z[1].imag))


def _separate(corners: Complex) -> tuple[Array, Complex, Complex]:
    """Distance, normal and point of the pairs `corners` (2, 4, P), each (P,)."""
    pairs = _Pairs(corners)
    gaps, offsets = pairs.gaps()
    widest = gaps.argmax(axis=0)
    chosen = _flat_indices(widest)
    gap = gaps.take(chosen)
    normal = np.where(widest >= 2, pairs.heading[1], pairs.heading[0]) * np.copysign(1.0, offsets.take(chosen))
    normal = np.where(widest % 2, 1j * normal, normal)

    # Overlapping rectangles are separated first: the closest corner is then the one that was deepest inside.
    step = np.maximum(-gap, 0.0) * normal
    # The corners of each in the frame of the other one, and their offsets from it.
    others = np.array((corners[1] + step, corners[0]))
    centre = np.array((pairs.centre[0], pairs.centre[1] + step))
    seen = (others - centre[:, None]) * pairs.heading.conj()[:, None]
    out = np.maximum(np.abs(seen.view(float)) - pairs.half.view(float)[:, None], 0.0).view(complex)
    nearest = np.abs(out).reshape(8, -1).argmin(axis=0)
    by_second = nearest >= 4
    chosen = _flat_indices(nearest)
    between = np.copysign(out.take(chosen).view(float), seen.take(chosen).view(float)).view(complex)
    between *= np.where(by_second, pairs.heading[1], pairs.heading[0])
    point = others.take(chosen) - (between + step) / 2

    length = np.abs(between)
    apart = gap > 0
    distance = np.where(apart, np.maximum(gap, length), gap)
    # A gap may be positive by rounding with a corner at distance 0. The axis is then the only direction.
    np.divide(np.where(by_second, -between, between), length, out=normal, where=apart & (length > 0))
    return distance, normal, point


def _flat_indices(choice: NDArray[np.intp]) -> NDArray[np.intp]:
    """Where entry `choice[p]` of column p stands in a flattened array (..., P)."""
    return choice * choice.size + np.arange(choice.size)


def _paired(first: ArrayLike, second: ArrayLike) -> tuple[Complex, tuple[int, ...]]:
    """Corners (2, 4, P) of all pairs, and the leading shape of which P is the size."""
    sides = checked_outlines("first", first), checked_outlines("second", second)
    try:
        shape = np.broadcast_shapes(*(side.shape[:-2] for side in sides))
    except ValueError as error:
        raise ParameterError("second", f"of shape {sides[1].shape}", f"one that goes with {sides[0].shape}") from error
    corners = np.empty((2, 4, *shape), dtype=complex)
    for into, side in zip(corners, sides, strict=True):
        into.transpose(*range(1, into.ndim), 0)[...] = side.view(complex)[..., 0]
    return corners.reshape(2, 4, -1), shape


def _parts(pairs: int) -> list[slice]:
    return [slice(at, at + CHUNK) for at in range(0, pairs, CHUNK)]
