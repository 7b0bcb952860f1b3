"""Gaps between benches on a spiral, and their exact derivatives by distance travelled and by every size.

The derivatives are computed forward along the chain. For a quantity q, the displacement derivative of a hole at P is
D = dP/dq. Every hole stays on the spiral. If q is the pitch, the spiral itself is scaled.

- Head: D = tau for the distance w that the head has travelled, and D = (P - w tau) / pitch for the pitch. tau is the
  unit tangent of the path.
- Next hole, at P': D' = E + a tau', where E = P' / pitch for the pitch and 0 otherwise. With d = P - P' and spacing L,
  the rigid bench requires d (D - D') = L dL/dq, so a = (d (D - E) - L dL/dq) / (d tau').

Poses, corners and closest points follow from the holes. A gap g is measured along the normal n between the closest
points X and Y of two benches, so dg/dq = n (dY/dq - dX/dq). Sliding of the closest points along the edges does not
contribute. At a local minimum of a gap over time, the derivative by time is zero, so the derivative by q at fixed time
is also the derivative of the minimum (envelope theorem).

Points and vectors of the plane are complex numbers inside this module.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.collision import separation
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.march import March

__all__ = ["PITCH", "QUANTITIES", "SIZES", "TRAVELLED", "Gaps", "gaps_of"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Indices = NDArray[np.intp]

# Sizes by which a gap is differentiated.
SIZES = ("width", "overhang", "head_spacing", "body_spacing", "pitch")
# Columns of `Gaps.slopes`: distance travelled by the head, and the sizes.
QUANTITIES = ("travelled", *SIZES)
# Column numbers of the quantities.
TRAVELLED, WIDTH, OVERHANG, HEAD, BODY, PITCH = range(len(QUANTITIES))
# m. A closest point within this distance of a bench's end or side lies on that edge; far above rounding.
ON_EDGE = 1e-9


@dataclass(frozen=True)
class Gaps:
    """Gaps of P pairs of benches, each at its own position of the head.

    Attributes
    ----------
    travelled : ndarray, shape (P,)
        Distance travelled by the head from its start, m.
    pairs : ndarray, shape (P, 2)
        Numbers of the benches.
    gaps : ndarray, shape (P,)
        Signed distances, m; negative where benches overlap.
    points : ndarray, shape (P, 2)
        Midpoints of the closest points, m.
    slopes : ndarray, shape (P, 6)
        Derivatives of the gaps by the `QUANTITIES`, in this order, m per m. Where two pairs of closest points are
        equally close, the derivatives are those of one pair. A size that differs between benches changes by the same
        amount on each bench.
    features : ndarray of int, shape (P, 4)
        Edges on which the closest points lie, for the first bench and then for the second: 1 at the front end, -1 at
        the rear end, 0 between; and 1 at the left side, -1 at the right side, 0 between. Neither is 0 at a corner.
    slopes_at_radius : ndarray, shape (P,)
        Derivatives by the pitch at a fixed distance of handle 0 from the centre, instead of a fixed distance travelled,
        m per m.
    """

    travelled: Array
    pairs: Indices
    gaps: Array
    points: Array
    slopes: Array
    features: Indices
    slopes_at_radius: Array


def gaps_of(march: March, travelled: ArrayLike, pairs: ArrayLike) -> Gaps:
    """Gaps of `pairs` (P, 2) of benches at distances `travelled` (P,) by the head, m, and their derivatives.

    Parameters
    ----------
    march : March
        A march at 1 m/s, inward on a `Spiral` from one of its turns.

    Raises
    ------
    UnreachableError
        If a handle has no position on the curve.
    """
    at, selected = np.asarray(travelled, dtype=float).ravel(), np.asarray(pairs, dtype=np.intp).reshape(-1, 2)
    moments, row = np.unique(at, return_inverse=True)
    states = march.at(moments, int(selected.max()) + 2)
    holes = states.positions.view(complex)[..., 0]
    tangents = march.curve.tangent(states.handles_s).view(complex)[..., 0]
    changes = _hole_slopes(march, moments, holes, tangents)
    corners = march.dragon.outlines(states.poses)
    first, second = selected.T
    found = separation(corners[row, first], corners[row, second])
    normal, point = (array.view(complex)[..., 0] for array in (found.normal, found.point))
    half = found.distance / 2 * normal
    own, own_feature = _point_slopes(march, holes, changes, row, first, point - half)
    other, other_feature = _point_slopes(march, holes, changes, row, second, point + half)
    slopes = other - own
    by_quantity = (normal.conj()[:, None] * slopes).real
    # Distance by which the head has to move per metre of pitch to remain at its distance from the centre.
    head = holes[row, 0].conj()
    back = -(head * changes[row, 0, PITCH]).real / (head * changes[row, 0, TRAVELLED]).real
    at_radius = by_quantity[:, PITCH] + back * by_quantity[:, TRAVELLED]
    features = np.concatenate([own_feature, other_feature], axis=-1)
    return Gaps(at, selected, found.distance, found.point, by_quantity, features, at_radius)


def _hole_slopes(march: March, travelled: Array, holes: Complex, tangents: Complex) -> Complex:
    """Derivatives (T, H, 6) of the positions of the holes (T, H)."""
    assert isinstance(march.curve, Spiral)
    pitch, spacings = march.curve.pitch, march.dragon.spacings
    slopes = np.zeros((*holes.shape, len(QUANTITIES)), dtype=complex)
    slopes[:, 0, TRAVELLED] = tangents[:, 0]
    slopes[:, 0, PITCH] = (holes[:, 0] - travelled * tangents[:, 0]) / pitch
    scaled = np.zeros((len(holes), len(QUANTITIES)), dtype=complex)
    for bench, spacing in enumerate(spacings[: holes.shape[1] - 1].tolist()):
        along, tangent = holes[:, bench] - holes[:, bench + 1], tangents[:, bench + 1]
        scaled[:, PITCH] = holes[:, bench + 1] / pitch
        change = (along.conj()[:, None] * (slopes[:, bench] - scaled)).real
        change[:, HEAD if bench == 0 else BODY] -= spacing
        moved = change / (along.conj() * tangent).real[:, None]
        slopes[:, bench + 1] = scaled + moved * tangent[:, None]
    return slopes


def _point_slopes(
    march: March, holes: Complex, changes: Complex, rows: Indices, benches: Indices, points: Complex
) -> tuple[Complex, Indices]:
    """Derivatives (P, 6) of `points` (P,) on the outlines of `benches` in the `rows` of `holes`, and features (P, 2).

    A point on an edge keeps its position along the edge. A point at an end or a side moves with that end or side.
    """
    front, rear = holes[rows, benches], holes[rows, benches + 1]
    front_change, rear_change = changes[rows, benches], changes[rows, benches + 1]
    spacing = march.dragon.spacings[benches]
    elongation = np.zeros((len(points), len(QUANTITIES)))
    elongation[np.arange(len(points)), np.where(benches == 0, HEAD, BODY)] = 1.0
    heading = (front - rear) / spacing
    turn = (front_change - rear_change - elongation * heading[:, None]) / spacing[:, None]
    local = (points - (front + rear) / 2) * heading.conj()
    ahead, aside = local.real, local.imag
    at_end = np.sign(ahead) * (np.abs(ahead) > march.dragon.lengths[benches] / 2 - ON_EDGE)
    at_side = np.sign(aside) * (np.abs(aside) > march.dragon.widths[benches] / 2 - ON_EDGE)
    growth = at_end[:, None] * elongation / 2 + 0j
    growth[:, OVERHANG] += at_end
    growth[:, WIDTH] += 0.5j * at_side
    slopes = (front_change + rear_change) / 2 + local[:, None] * turn + growth * heading[:, None]
    return slopes, np.stack([at_end, at_side], axis=-1).astype(np.intp)
