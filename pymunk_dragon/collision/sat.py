"""Narrow phase: whether two benches touch, and how far apart they are (paper, section 2.2).

By the separating axis theorem, two rectangles are apart exactly where their projections leave a gap
on one of four axes: the length and the width of each. Otherwise the shortest translation that
separates them is along the axis of the smallest overlap (S. Gottschalk et al., "OBBTree", SIGGRAPH
1996; C. Ericson, "Real-Time Collision Detection", 2005, section 4.4.1).

The widest gap is the distance only where an edge faces the other rectangle. Two rectangles that are
nearest corner to corner are further apart than any gap shows, so the distance comes from the
corners: for convex shapes that are apart, one of the two closest points is always a corner.

Points and vectors of the plane are complex numbers inside this module:
``z * conj(u)`` has the real part along the unit vector ``u``, and the imaginary part to its left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, Indices, as_complex, as_vectors, read_only
from pymunk_dragon._checks import MAX_COORDINATE, fitting, numbers
from pymunk_dragon.errors import ParameterError

# Pairs worked on at once: their temporaries, about 0.7 kB a pair, stay in a processor's second
# cache.
_CHUNK = 2048


@dataclass(frozen=True, eq=False, repr=False)
class Separation:
    """How far two rectangles are apart, for pairs of any shape (...).

    Attributes
    ----------
    distance : ndarray, shape (...)
        Shortest distance between the two, m. Negative where they overlap: the shortest translation
        that parts them, along an edge normal. Zero where they touch. Its sign is that of the
        separating axis test, without tolerance.
    normal : ndarray, shape (..., 2)
        Unit vector from the first towards the second: between their closest points, or along the
        shortest separation. Moving the second along it by `-distance` makes overlapping ones touch.
    point : ndarray, shape (..., 2)
        Midway between the closest points, m. For overlapping ones: midway between where they touch
        once each has moved along the normal by half the depth, so a corner that overlaps an edge is
        half its depth ahead of this point. Where two parallel edges face each other, one of the
        points between them.

    Examples
    --------
    >>> separation([(0, 0), (1, 0), (1, 1), (0, 1)], [(3, 0), (4, 0), (4, 1), (3, 1)])
    Separation(1 pairs)
    """

    distance: Array
    normal: Array
    point: Array

    def __repr__(self) -> str:
        return f"Separation({self.distance.size} pairs)"


def separation(first: ArrayLike, second: ArrayLike) -> Separation:
    """Signed distance, normal and contact point of pairs of rectangles.

    Parameters
    ----------
    first, second : array_like, shape (..., 4, 2)
        Corners in m, counter-clockwise, as `dragon.outlines` gives them; their leading shapes
        broadcast.

    Returns
    -------
    Separation
        Read-only arrays of the broadcast leading shape, right to a few last digits of the largest
        coordinate. If two translations are equally short, or two pairs of points equally close, the
        result is one of them.

    Examples
    --------
    >>> from pymunk_dragon.model.dragon import outlines
    >>> square = outlines([[0, 0, 0]], [1.0], 1.0)[0]
    >>> apart = separation(square, square + [3, 0])
    >>> float(apart.distance), apart.normal.tolist(), apart.point[0].item()
    (2.0, [1.0, 0.0], 1.5)
    """
    one = coordinates("first", first, 4, 2)
    two = coordinates("second", second, 4, 2)
    shape = fitting("first and second", one.shape, two.shape)[:-2]
    corners = np.empty((2, 4, *shape), dtype=complex)
    sides = np.moveaxis(corners, 1, -1)
    sides[0] = as_complex(one)
    sides[1] = as_complex(two)

    corners = corners.reshape(2, 4, -1)
    pairs = corners.shape[-1]
    distance = np.empty(pairs)
    normal = np.empty(pairs, complex)
    point = np.empty(pairs, complex)
    for begin in range(0, pairs, _CHUNK):
        part = slice(begin, begin + _CHUNK)
        distance[part], normal[part], point[part] = _separate(corners[..., part])
    vectors = (read_only(as_vectors(found.reshape(shape))) for found in (normal, point))
    return Separation(read_only(distance.reshape(shape)), *vectors)


def deepest_overlap(outlines: Array, pairs: Indices) -> tuple[int, int] | None:
    """The one of `pairs` (P, 2) of `outlines` (N, 4, 2) that overlaps most deeply, or None."""
    distances = separation(outlines[pairs[:, 0]], outlines[pairs[:, 1]]).distance
    if not np.any(distances <= 0):
        return None
    first, second = pairs[distances.argmin()].tolist()
    return first, second


def coordinates(name: str, value: ArrayLike, *tail: int, axes: int | None = None) -> Array:
    """`value` as a contiguous array (..., *tail) of coordinates in m, in all of so many `axes`."""
    array: Array = np.ascontiguousarray(numbers(name, value, *tail))
    if axes not in (None, array.ndim):
        raise ParameterError(name, f"of shape {array.shape}", f"coordinates in m with {axes} axes")
    inside = np.abs(array) <= MAX_COORDINATE
    if not inside.all():
        bound = f"finite and within {MAX_COORDINATE:g} m"
        raise ParameterError(name, array[~inside][0].item(), bound)
    return array


def _separate(corners: Complex) -> tuple[Array, Complex, Complex]:
    """Distance, normal and point of the pairs `corners` (2, 4, P), each (P,).

    Row 0 of the arrays below is the first rectangle's view, row 1 the second's.
    """
    centre, heading, half = _frames(corners)
    gaps, offsets = _projections(centre, heading, half)
    columns = np.arange(corners.shape[-1])
    widest = gaps.argmax(axis=0)
    chosen = widest * columns.size + columns
    gap = gaps.take(chosen)
    signs = np.copysign(1.0, offsets.take(chosen))
    normal = np.where(widest >= 2, heading[1], heading[0]) * signs
    normal = np.where(widest % 2, 1j * normal, normal)

    # Overlapping rectangles are separated first: the closest corner is then the one that was
    # deepest inside.
    step = np.maximum(-gap, 0.0) * normal
    # The corners of each in the frame of the other one, and their offsets from it.
    others = np.array((corners[1] + step, corners[0]))
    centre = np.array((centre[0], centre[1] + step))
    seen = (others - centre[:, None]) * heading.conj()[:, None]
    outside = np.abs(seen.view(float)) - half.view(float)[:, None]
    outside = np.maximum(outside, 0.0).view(complex)
    nearest = np.abs(outside).reshape(8, -1).argmin(axis=0)
    chosen = nearest * columns.size + columns
    by_second = nearest >= 4
    sizes = outside.take(chosen).view(float)
    between = np.copysign(sizes, seen.take(chosen).view(float)).view(complex)
    between *= np.where(by_second, heading[1], heading[0])
    point = others.take(chosen) - (between + step) / 2

    length = np.abs(between)
    apart = gap > 0
    distance = np.where(apart, np.maximum(gap, length), gap)
    # A gap may be positive by rounding with a corner at distance 0. The axis is then the only
    # direction.
    towards = np.where(by_second, -between, between)
    np.divide(towards, length, out=normal, where=apart & (length > 0))
    return distance, normal, point


def _frames(corners: Complex) -> tuple[Complex, Complex, Complex]:
    """Centres, unit headings, and half the lengths with half the widths, each (2, P).

    A length is along the heading, and a width to its left.
    """
    rear_right, front_right, front_left, rear_left = corners.swapaxes(0, 1)
    along = (front_right - rear_right) / 2
    left = (rear_left - rear_right) / 2
    wrong = ~((along.conj() * left).imag > 0)
    if wrong.any():
        side, pair = np.argwhere(wrong)[0]
        name = ("first", "second")[side]
        shown = as_vectors(corners[side, :, pair]).tolist()
        raise ParameterError(name, shown, "rectangles with an area, counter-clockwise")
    # Both summands point ahead, and the longer side, which rounding turns least, weighs most.
    ahead = along - 1j * left
    half = np.abs(along) + 1j * np.abs(left)
    return (rear_right + front_left) / 2, ahead / np.abs(ahead), half


def _projections(centre: Complex, heading: Complex, half: Complex) -> tuple[Array, Array]:
    """Gaps between the projections on the four axes, and offsets of the second centre, (4, P)."""
    facing = heading.conj()
    offset = (centre[1] - centre[0]) * facing
    turn = heading[1] * facing[0]
    other = half[::-1]
    # On the axes of the other rectangle, both the length and the width have a projection.
    across = np.abs(turn.imag) * (1j * other.conj())
    covered = half + (np.abs(turn.real) * other + across)
    # `np.stack` takes four times as long for few pairs.
    offsets = np.array((offset[0].real, offset[0].imag, offset[1].real, offset[1].imag))
    reach = np.array((covered[0].real, covered[0].imag, covered[1].real, covered[1].imag))
    return np.abs(offsets) - reach, offsets
