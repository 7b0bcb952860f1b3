"""Gaps between benches on a spiral, and how they change with the way and with every size: exact derivatives.

Forward along the chain, for any quantity q. The way that a hole takes is a vector D = dP/dq. Every hole stays on the
spiral, and the spiral with it if q is the pitch, which scales it:

- head:       D = tau by the way w that it has gone since the start, and (P - w tau) / pitch by the pitch, with the
              path's direction tau,
- next hole:  D' = E + a tau', where E = P' / pitch by the pitch and 0 else, and the rigid bench d = P - P', of the
              spacing L, has d (D - D') = L dL/dq; so a = (d (D - E) - L dL/dq) / (d tau').

Poses, corners and closest points follow from the holes. A gap g is the way along its normal n between the closest
points X and Y of two benches, so dg/dq = n (dY/dq - dX/dq): how these points slide along the edges does not matter. At
a moment at which a gap is smallest it does not change with time either, so its slope there is that of the smallest
gap (the envelope theorem).

Points and vectors of the plane are complex numbers inside this module.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.collision import separation
from pymunk_dragon.curves import Spiral
from pymunk_dragon.march import March

__all__ = ["PITCH", "QUANTITIES", "SIZES", "WAY", "Gaps", "gaps_of"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Indices = NDArray[np.intp]

# What a gap depends on beside the head's way: the columns of `Gaps.slopes`.
SIZES = ("width", "overhang", "head_spacing", "body_spacing", "pitch")
QUANTITIES = ("way", *SIZES)
WAY, WIDTH, OVERHANG, HEAD, BODY, PITCH = range(len(QUANTITIES))
# m. A closest point that is so close to a bench's end or side lies on it.
ON_EDGE = 1e-9


@dataclass(frozen=True)
class Gaps:
    """Gaps of P pairs of benches, each where the head has gone its own way.

    Attributes
    ----------
    ways : ndarray, shape (P,)
        From the head's start, m.
    pairs : ndarray, shape (P, 2)
        Numbers of the benches.
    gaps : ndarray, shape (P,)
        m, negative where they overlap.
    points : ndarray, shape (P, 2)
        Midway between the closest points, m.
    slopes : ndarray, shape (P, 6)
        Their derivatives by the `QUANTITIES`, in this order, m for each m. Where two pairs of closest points are
        equally close, one of both has been taken. Sizes that differ from bench to bench change by the same.
    features : ndarray of int, shape (P, 4)
        Where the closest points lie: of the first bench and then of the second, 1 at its front end, -1 at its rear end,
        and 1 at its left side, -1 at its right side; 0 in between. Neither is 0 at a corner.
    slopes_on_circle : ndarray, shape (P,)
        The derivative by the pitch while handle 0 stays on the same circle about the centre, instead of as far from
        the start, m for each m.
    """

    ways: Array
    pairs: Indices
    gaps: Array
    points: Array
    slopes: Array
    features: Indices
    slopes_on_circle: Array


def gaps_of(march: March, ways: ArrayLike, pairs: ArrayLike) -> Gaps:
    """Gaps of `pairs` (P, 2) of benches once the head has gone the `ways` (P,), and their slopes.

    Parameters
    ----------
    march : March
        On a `Spiral`, inward from one of its turns, at 1 m/s.

    Raises
    ------
    UnreachableError
        If a bench has no place there.
    """
    at, wanted = np.asarray(ways, dtype=float).ravel(), np.asarray(pairs, dtype=np.intp).reshape(-1, 2)
    moments, row = np.unique(at, return_inverse=True)
    states = march.at(moments, int(wanted.max()) + 2)
    holes = states.positions.view(complex)[..., 0]
    tangents = march.curve.tangent(states.places).view(complex)[..., 0]
    changes = _hole_slopes(march, moments, holes, tangents)
    corners = march.dragon.outlines(states.poses)
    first, second = wanted.T
    found = separation(corners[row, first], corners[row, second])
    normal, point = (array.view(complex)[..., 0] for array in (found.normal, found.point))
    half = found.distance / 2 * normal
    own, own_feature = _point_slopes(march, holes, changes, row, first, point - half)
    other, other_feature = _point_slopes(march, holes, changes, row, second, point + half)
    slopes = other - own
    by_quantity = (normal.conj()[:, None] * slopes).real
    # The head's way along the spiral for which the pitch leaves it on its circle.
    head = holes[row, 0].conj()
    back = -(head * changes[row, 0, PITCH]).real / (head * changes[row, 0, WAY]).real
    on_circle = by_quantity[:, PITCH] + back * by_quantity[:, WAY]
    features = np.concatenate([own_feature, other_feature], axis=-1)
    return Gaps(at, wanted, found.distance, found.point, by_quantity, features, on_circle)


def _hole_slopes(march: March, ways: Array, holes: Complex, tangents: Complex) -> Complex:
    """Derivatives (T, H, 6) of the places of the holes (T, H)."""
    assert isinstance(march.curve, Spiral)
    pitch, spacings = march.curve.pitch, march.dragon.spacings
    slopes = np.zeros((*holes.shape, len(QUANTITIES)), dtype=complex)
    slopes[:, 0, WAY] = tangents[:, 0]
    slopes[:, 0, PITCH] = (holes[:, 0] - ways * tangents[:, 0]) / pitch
    scaled = np.zeros((len(holes), len(QUANTITIES)), dtype=complex)
    for bench, spacing in enumerate(spacings[: holes.shape[1] - 1].tolist()):
        along, tangent = holes[:, bench] - holes[:, bench + 1], tangents[:, bench + 1]
        scaled[:, PITCH] = holes[:, bench + 1] / pitch
        change = (along.conj()[:, None] * (slopes[:, bench] - scaled)).real
        change[:, HEAD if bench == 0 else BODY] -= spacing
        way = change / (along.conj() * tangent).real[:, None]
        slopes[:, bench + 1] = scaled + way * tangent[:, None]
    return slopes


def _point_slopes(
    march: March, holes: Complex, changes: Complex, rows: Indices, benches: Indices, points: Complex
) -> tuple[Complex, Indices]:
    """Derivatives (P, 6) of `points` (P,) that lie on the outlines of `benches` in the `rows` of `holes`.

    A point on an edge keeps its place along it; one at an end or a side moves with it. Also which of them do (P, 2).
    """
    front, rear = holes[rows, benches], holes[rows, benches + 1]
    front_change, rear_change = changes[rows, benches], changes[rows, benches + 1]
    spacing = march.dragon.spacings[benches]
    stretch = np.zeros((len(points), len(QUANTITIES)))
    stretch[np.arange(len(points)), np.where(benches == 0, HEAD, BODY)] = 1.0
    heading = (front - rear) / spacing
    turn = (front_change - rear_change - stretch * heading[:, None]) / spacing[:, None]
    place = (points - (front + rear) / 2) * heading.conj()
    ahead, aside = place.real, place.imag
    at_end = np.sign(ahead) * (np.abs(ahead) > march.dragon.lengths[benches] / 2 - ON_EDGE)
    at_side = np.sign(aside) * (np.abs(aside) > march.dragon.widths[benches] / 2 - ON_EDGE)
    growth = at_end[:, None] * stretch / 2 + 0j
    growth[:, OVERHANG] += at_end
    growth[:, WIDTH] += 0.5j * at_side
    slopes = (front_change + rear_change) / 2 + place[:, None] * turn + growth * heading[:, None]
    return slopes, np.stack([at_end, at_side], axis=-1).astype(np.intp)
