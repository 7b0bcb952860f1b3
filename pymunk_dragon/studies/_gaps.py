"""Gaps between benches on an inward spiral: exact derivatives by every size, and samples of all gaps.

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

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, Indices, as_vectors
from pymunk_dragon.collision import separation
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March

# Sizes by which a gap is differentiated.
SIZES = ("width", "overhang", "head_spacing", "body_spacing", "pitch")
# Columns of `Gaps.slopes`: distance travelled by the head, and the sizes.
QUANTITIES = ("travelled", *SIZES)
# Column numbers of the quantities.
TRAVELLED, WIDTH, OVERHANG, HEAD, BODY, PITCH = range(len(QUANTITIES))
# m. A closest point within this distance of a bench's end or side lies on that edge; far above rounding.
ON_EDGE = 1e-9
# Samples per shortest spacing travelled by the head. A local minimum of a gap hardly changes between two samples.
SAMPLES_PER_SPACING = 6
# Positions of the head evaluated at once: 30 MB with a hundred handles.
BATCH = 4000
# Turns behind the head that contain all benches that it passes. Benches further back are further away.
TURNS_BACK = 1.25
# Points per bracket of a local minimum in each refinement pass, which narrows the bracket fourteenfold.
POINTS = 15
# Refinement passes: half a metre becomes 3e-11 m.
PASSES = 9


@dataclass(frozen=True, kw_only=True)
class InwardMarch:
    """March at 1 m/s from a turn of a spiral of some `pitch`, m, inward to a circle of `radius` m about its centre."""

    dragon: Dragon
    pitch: float
    turns: float
    radius: float

    @cached_property
    def spiral(self) -> Spiral:
        """The path of the handles."""
        return Spiral(pitch=self.pitch)

    @cached_property
    def march(self) -> March:
        """The march, of which handle 0 is on the circle after `length` m."""
        return March(self.dragon, self.spiral, turns=self.turns)

    @cached_property
    def length(self) -> float:
        """Distance along the spiral from the start of handle 0 to the circle, m."""
        return self.spiral.at_radius(self.radius) - self.march.head_start

    def size(self, name: str) -> float:
        """One of the `SIZES`, m; the least one where the benches differ."""
        return self.pitch if name == "pitch" else float(np.min(getattr(self.dragon, name)))

    def changed(self, name: str, change: float) -> InwardMarch:
        """The same with one of the `SIZES` changed by `change` m, on all benches that have the size."""
        if name == "pitch":
            return replace(self, pitch=self.pitch + change)
        value = getattr(self.dragon, name)
        more: Any = value + change if isinstance(value, float) else tuple(each + change for each in value)
        return replace(self, dragon=replace(self.dragon, **{name: more}))


@dataclass(frozen=True)
class Gaps:
    """Gaps of P pairs of benches, each at its own position of the head.

    Where two pairs of closest points are equally close, derivatives are those of one pair. A size that differs between
    benches changes by the same amount on each bench.
    """

    # (P,) Distances travelled by the head from its start, m.
    travelled: Array
    # (P, 2) Numbers of the benches.
    pairs: Indices
    # (P,) Signed distances, m; negative where benches overlap.
    gaps: Array
    # (P, 2) Midpoints of the closest points, m.
    points: Array
    # (P, 6) Derivatives of the gaps by the `QUANTITIES`, m per m.
    slopes: Array
    # (P, 4) Edges on which the closest points lie, for the first bench and then for the second: 1 at the front end, -1
    # at the rear end, 0 between; and 1 at the left side, -1 at the right side, 0 between. Neither is 0 at a corner.
    features: Indices
    # (P,) Derivatives by the pitch at a fixed distance of handle 0 from the centre, not a fixed distance travelled.
    slopes_at_radius: Array


def gaps_of(inward: InwardMarch, travelled: ArrayLike, pairs: ArrayLike) -> Gaps:
    """Gaps of `pairs` (P, 2) of benches at distances `travelled` (P,) by the head, m, and their derivatives.

    Raises `UnreachableError` if a handle has no position on the spiral.
    """
    march = inward.march
    at, selected = np.asarray(travelled, dtype=float).ravel(), np.asarray(pairs, dtype=np.intp).reshape(-1, 2)
    moments, row = np.unique(at, return_inverse=True)
    states = march.at(moments, int(selected.max()) + 2)
    holes = states.positions.view(complex)[..., 0]
    tangents = march.curve.tangent(states.handles_s).view(complex)[..., 0]
    changes = _hole_slopes(inward, moments, holes, tangents)
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


def _hole_slopes(inward: InwardMarch, travelled: Array, holes: Complex, tangents: Complex) -> Complex:
    """Derivatives (T, H, 6) of the positions of the holes (T, H)."""
    pitch, spacings = inward.pitch, inward.dragon.spacings
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


class SampledGaps:
    """Gaps of benches 0 and 1 to the benches that they pass, at closely spaced positions of the head.

    Where all benches but the head are alike, every other bench repeats the motion of bench 1. Sampling is fast and
    proves nothing; `first_contact` certifies its results.

    `inward` is the march of the foremost benches, `travelled` (T,) the distance of the head from its start at each
    sample, m, and `gaps` (T, B, 2) are those of bench 0 and of bench 1 to each of the B benches, m; inf for distant
    benches and neighbours. The samples begin on the turn `further` times that of the start.
    """

    def __init__(self, inward: InwardMarch, further: float = 1.0) -> None:
        spiral, turns, shortest = inward.spiral, inward.turns, float(inward.dragon.spacings.min())
        start, outside = spiral.at_turn(turns), spiral.at_turn(further * turns)
        passed = outside - spiral.at_turn(further * turns + TURNS_BACK)
        self.inward = replace(inward, dragon=_front_part(inward.dragon, int(passed / shortest) + 2))
        step, length = shortest / SAMPLES_PER_SPACING, spiral.at_radius(inward.radius) - start
        before, after = (int(np.ceil(part / step)) for part in (start - outside, length))
        first, last = outside - start, max(0.0, length)
        self.travelled = np.concatenate([np.linspace(first, 0.0, before + 1)[:-1], np.linspace(0.0, last, after + 1)])
        parts = [self._gaps(self.travelled[at : at + BATCH]) for at in range(0, len(self.travelled), BATCH)]
        self.gaps = np.concatenate(parts)

    def _gaps(self, travelled: Array) -> Array:
        """Gaps (T, B, 2) at distances travelled (T,)."""
        dragon, handles = self.inward.dragon, self.inward.march.motion(travelled).points
        benches = dragon.benches
        gaps = np.full((len(travelled), benches, 2), np.inf)
        centres = (handles[:, :-1] + handles[:, 1:]) / 2
        # Benches whose bounding circles are further apart than the largest width are skipped.
        reach = np.hypot(dragon.lengths, dragon.widths) / 2 + dragon.widths.max()
        for own in range(min(2, benches)):
            row, other = np.nonzero(
                np.abs(centres[:, own + 2 :] - centres[:, own, None]) < reach[own + 2 :] + reach[own]
            )
            both = [
                as_vectors(dragon.corners(handles[row, numbers], handles[row, numbers + 1], numbers))
                for numbers in (np.full(row.shape, own), own + 2 + other)
            ]
            gaps[row, own + 2 + other, own] = separation(*both).distance
        return gaps

    def close_to_zero(self, tolerance: float) -> Gaps | None:
        """Gaps within `tolerance` m of zero, from samples without a deeper overlap; None if there are none."""
        shallow = self.gaps.min(axis=(1, 2), keepdims=True) >= -tolerance
        row, other, own = np.nonzero(shallow & (np.abs(self.gaps) <= tolerance))
        return gaps_of(self.inward, self.travelled[row], np.stack([own, other], axis=-1)) if row.size else None

    def minimum(self) -> Gaps | None:
        """The smallest of all gaps, refined about its sample; None if the head passes no bench."""
        if not np.isfinite(self.gaps).any():
            return None
        row, other, own = np.unravel_index(int(self.gaps.argmin()), self.gaps.shape)
        return self._refined(np.array([row]), np.array([[own, other]]))

    def local_minima(self, below: float) -> Gaps | None:
        """All local minima over the distance travelled whose samples are below `below` m; None if there are none.

        Minima at the first and the last sample are included.
        """
        padded = np.pad(self.gaps, ((1, 1), (0, 0), (0, 0)), constant_values=np.inf)
        row, other, own = np.nonzero((self.gaps <= padded[:-2]) & (self.gaps <= padded[2:]) & (self.gaps < below))
        return self._refined(row, np.stack([own, other], axis=-1)) if row.size else None

    def _refined(self, rows: Indices, pairs: Indices) -> Gaps:
        """Minimal gaps of `pairs` (P, 2) between the samples next to `rows` (P,)."""
        last = len(self.travelled) - 1
        low, high = self.travelled[np.maximum(rows - 1, 0)], self.travelled[np.minimum(rows + 1, last)]
        return minimal_gaps(self.inward, pairs, low, high)


def minimal_gaps(inward: InwardMarch, pairs: Indices, low: Array, high: Array) -> Gaps:
    """The minima of the gaps of `pairs` (P, 2) between distances travelled `low` and `high` (P,), m.

    Each gap has one local minimum in its bracket, or is smallest at an end.
    """
    chosen, many = np.arange(len(pairs)), np.repeat(pairs, POINTS, axis=0)
    for _ in range(PASSES):
        travelled = np.linspace(low, high, POINTS, axis=-1)
        falling = gaps_of(inward, travelled, many).slopes[:, TRAVELLED].reshape(travelled.shape) < 0
        # First point at which the gap does not decrease.
        turning = np.where(falling.all(axis=1), POINTS, falling.argmin(axis=1))
        low, high = (travelled[chosen, np.clip(turning - back, 0, POINTS - 1)] for back in (1, 0))
    return gaps_of(inward, (low + high) / 2, pairs)


def _front_part(dragon: Dragon, benches: int) -> Dragon:
    """The foremost `benches` benches of a dragon, or the whole dragon if it has no more."""
    if benches >= dragon.benches:
        return dragon
    return Dragon(
        head_spacing=dragon.head_spacing,
        body_spacing=dragon.spacings[1:benches].tolist(),
        overhang=dragon.overhangs[:benches].tolist(),
        width=dragon.widths[:benches].tolist(),
    )
