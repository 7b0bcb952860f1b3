"""Gaps between benches on an inward spiral: samples of all gaps, and exact derivatives by distance and by pitch.

The derivatives are computed forward along the chain. For a quantity q, the displacement derivative of a hole at P is
D = dP/dq. Every hole stays on the spiral, which is scaled with its pitch.

- Head: D = tau for the distance w that the head has travelled, and D = (P - w tau) / pitch for the pitch. tau is the
  unit tangent of the path.
- Next hole, at P': D' = E + a tau', where E = P' / pitch for the pitch and 0 for the distance. With d = P - P', the
  rigid bench requires d (D - D') = 0, so a = d (D - E) / (d tau').

A gap is measured along the normal n between the closest points X and Y of two benches, so dg/dq = n (dY/dq - dX/dq).
Sliding of the closest points along the edges does not contribute.

Points and vectors of the plane are complex numbers inside this module.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, Indices, as_vectors
from pymunk_dragon.collision import separation
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March

# Columns of the derivatives: distance travelled by the head, and pitch.
TRAVELLED, PITCH = range(2)
# Samples per shortest spacing travelled by the head. A local minimum of a gap hardly changes between two samples.
SAMPLES_PER_SPACING = 6
# Positions of the head evaluated at once: 30 MB with a hundred handles.
BATCH = 4000
# Turns behind the head that contain all benches that it passes. Benches further back are further away.
TURNS_BACK = 1.25
# Points per bracket of a local minimum in each refinement pass, which narrows the bracket fourteenfold, and passes:
# half a metre becomes 3e-11 m.
POINTS, PASSES = 15, 9


@dataclass(frozen=True, kw_only=True)
class InwardMarch:
    """March at 1 m/s from a turn of a spiral of some `pitch`, m, inward to a circle of `radius` m about its centre."""

    dragon: Dragon
    pitch: float
    turns: float
    radius: float

    @cached_property
    def march(self) -> March:
        """The march, of which handle 0 is on the circle after `length` m."""
        return March(self.dragon, Spiral(pitch=self.pitch), turns=self.turns)

    @cached_property
    def length(self) -> float:
        """Distance along the spiral from the start of handle 0 to the circle, m."""
        return Spiral(pitch=self.pitch).at_radius(self.radius) - self.march.head_start


@dataclass(frozen=True)
class Gaps:
    """Gaps of P pairs of benches, each at its own position of the head."""

    # (P,) Distances travelled by the head from its start, m.
    travelled: Array
    # (P, 2) Numbers of the benches.
    pairs: Indices
    # (P,) Signed distances, m; negative where benches overlap.
    gaps: Array
    # (P, 2) Midpoints of the closest points, m.
    points: Array
    # (P, 2) Derivatives by the distance travelled and by the pitch, m per m.
    slopes: Array
    # (P,) Derivatives by the pitch at a fixed distance of handle 0 from the centre, not a fixed distance travelled.
    slopes_at_radius: Array

    @property
    def benches(self) -> tuple[int, int]:
        """The first pair."""
        first, second = self.pairs[0].tolist()
        return first, second


def gaps_of(inward: InwardMarch, travelled: ArrayLike, pairs: ArrayLike) -> Gaps:
    """Gaps of `pairs` (P, 2) of benches at distances `travelled` (P,) by the head, m, and their derivatives.

    Raises `UnreachableError` if a handle has no position on the spiral.
    """
    march = inward.march
    at, selected = np.asarray(travelled, dtype=float).ravel(), np.asarray(pairs, dtype=np.intp).reshape(-1, 2)
    moments, row = np.unique(at, return_inverse=True)
    states = march.at(moments, int(selected.max()) + 2)
    holes = states.positions.view(complex)[..., 0]
    changes = _hole_slopes(inward, moments, holes, march.curve.tangent(states.handles_s).view(complex)[..., 0])
    corners = march.dragon.outlines(states.poses)
    first, second = selected.T
    found = separation(corners[row, first], corners[row, second])
    normal, point = (array.view(complex)[..., 0] for array in (found.normal, found.point))
    half = found.distance / 2 * normal
    own = _point_slopes(march, holes[row], changes[row], first, point - half)
    other = _point_slopes(march, holes[row], changes[row], second, point + half)
    slopes = (normal.conj()[:, None] * (other - own)).real
    # Distance by which the head has to move per metre of pitch to remain at its distance from the centre.
    head = holes[row, 0].conj()
    back = -(head * changes[row, 0, PITCH]).real / (head * changes[row, 0, TRAVELLED]).real
    at_radius = slopes[:, PITCH] + back * slopes[:, TRAVELLED]
    return Gaps(at, selected, found.distance, found.point, slopes, at_radius)


def _hole_slopes(inward: InwardMarch, travelled: Array, holes: Complex, tangents: Complex) -> Complex:
    """Derivatives (T, H, 2) of the positions of the holes (T, H)."""
    slopes = np.zeros((*holes.shape, 2), dtype=complex)
    slopes[:, 0, TRAVELLED] = tangents[:, 0]
    slopes[:, 0, PITCH] = (holes[:, 0] - travelled * tangents[:, 0]) / inward.pitch
    scaled = np.zeros((len(holes), 2), dtype=complex)
    for bench in range(holes.shape[1] - 1):
        along, tangent = holes[:, bench] - holes[:, bench + 1], tangents[:, bench + 1]
        scaled[:, PITCH] = holes[:, bench + 1] / inward.pitch
        change = (along.conj()[:, None] * (slopes[:, bench] - scaled)).real
        moved = change / (along.conj() * tangent).real[:, None]
        slopes[:, bench + 1] = scaled + moved * tangent[:, None]
    return slopes


def _point_slopes(march: March, holes: Complex, changes: Complex, benches: Indices, points: Complex) -> Complex:
    """Derivatives (P, 2) of `points` (P,) that are fixed to `benches` (P,) of the holes (P, H)."""
    rows, spacing = np.arange(len(points)), march.dragon.spacings[benches]
    front, rear = holes[rows, benches], holes[rows, benches + 1]
    front_change, rear_change = changes[rows, benches], changes[rows, benches + 1]
    heading = (front - rear) / spacing
    turn = (front_change - rear_change) / spacing[:, None]
    local = (points - (front + rear) / 2) * heading.conj()
    return (front_change + rear_change) / 2 + local[:, None] * turn


class SampledGaps:
    """Gaps of benches 0 and 1 to the benches that they pass, at closely spaced positions of the head.

    Where all benches but the head are alike, every other bench repeats the motion of bench 1. Sampling is fast and
    proves nothing; `first_contact` certifies its results.

    `inward` is the march of the foremost benches, `travelled` (T,) the distance of the head from its start at each
    sample, m, and `gaps` (T, B, 2) are those of bench 0 and of bench 1 to each of the B benches, m; inf for distant
    benches and neighbours. The samples begin on the turn `further` times that of the start.
    """

    def __init__(self, inward: InwardMarch, further: float = 1.0) -> None:
        spiral, turns, shortest = Spiral(pitch=inward.pitch), inward.turns, float(inward.dragon.spacings.min())
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
        gaps = np.full((len(travelled), dragon.benches, 2), np.inf)
        centres = (handles[:, :-1] + handles[:, 1:]) / 2
        # Benches whose bounding circles are further apart than the largest width are skipped.
        reach = np.hypot(dragon.lengths, dragon.widths) / 2 + dragon.widths.max()
        for own in range(min(2, dragon.benches)):
            distances = np.abs(centres[:, own + 2 :] - centres[:, own, None])
            row, other = np.nonzero(distances < reach[own + 2 :] + reach[own])
            both = [
                as_vectors(dragon.corners(handles[row, numbers], handles[row, numbers + 1], numbers))
                for numbers in (np.full(row.shape, own), own + 2 + other)
            ]
            gaps[row, own + 2 + other, own] = separation(*both).distance
        return gaps

    def smallest(self) -> tuple[float, float]:
        """The smallest gap sampled from the start on, and that of all samples, m."""
        return float(self.gaps[self.travelled >= 0].min()), float(self.gaps.min())

    def growth(self, tolerance: float) -> Array:
        """Derivatives (K,) by the pitch at a fixed radius of gaps within `tolerance` m of zero, m per m.

        Samples with a deeper overlap are left out.
        """
        shallow = self.gaps.min(axis=(1, 2), keepdims=True) >= -tolerance
        row, other, own = np.nonzero(shallow & (np.abs(self.gaps) <= tolerance))
        if not row.size:
            return np.empty(0)
        return gaps_of(self.inward, self.travelled[row], np.stack([own, other], axis=-1)).slopes_at_radius

    def minimum(self) -> Gaps | None:
        """The smallest of all gaps, refined about its sample; None if the head passes no bench."""
        if not np.isfinite(self.gaps).any():
            return None
        row, other, own = map(int, np.unravel_index(int(self.gaps.argmin()), self.gaps.shape))
        low, high = self.travelled[max(row - 1, 0)], self.travelled[min(row + 1, len(self.travelled) - 1)]
        pair = np.array([[own, other]])
        for _ in range(PASSES):
            travelled = np.linspace(low, high, POINTS)
            falling = gaps_of(self.inward, travelled, np.repeat(pair, POINTS, axis=0)).slopes[:, TRAVELLED] < 0
            # First point at which the gap does not decrease.
            turning = POINTS if falling.all() else int(falling.argmin())
            low, high = (travelled[np.clip(turning - back, 0, POINTS - 1)] for back in (1, 0))
        return gaps_of(self.inward, (low + high) / 2, pair)


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
