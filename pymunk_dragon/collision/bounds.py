"""Bounds on the motion of benches within a time interval, from their state at its midpoint.

On a given path, the pose of a bench is a function of the arc-length coordinate s of its front
handle; `model/chain.py` has the notation, the velocity ratio rho, the angular rate omega and their
derivatives.

Bounds on the angles and curvatures give bounds on these quantities, and on the second derivative of
every corner at a distance q from the front handle: kappa + q (domega/ds + omega^2). Taylor's
theorem then bounds the displacement. The bounds hold for either direction of motion:
`Continuation.ranges` bounds the range of s also if the handle reverses.

Rounding. The error of a point of the curve is at most 8 last digits u of the largest coordinate, in
space, along the path or along one of its pieces. The tests measure this for the package's curves;
`Curve.point` requires it of others. So the computed coordinates satisfy |F| <= h, where F = (|P(s)
- P(r)|^2 - L^2) / (2 L) and h is the largest |F| of the computed points plus 18 u: 8 u for each
point, and 2 u for the distance.

The exact coordinates are reached if F goes to 0 in proportion to 1 - tau, with tau from 0 to 1.
While each coordinate stays within E of its computed value, cos alpha and cos beta stay within (2 /
L + kappa) E of theirs; half as much again covers the rounded length of the bench. Where this is at
most `_SLACK`, the rates of the front and rear handle satisfy

    |dr/dtau| <= ((|cos alpha| + _SLACK) |ds/dtau| + h) / (|cos beta| - _SLACK).

E is the largest bound that this recursion gives along the chain, beginning with h for the head. So
the coordinates never leave their range of E. Where E is too large for `_SLACK`, the error is
unknown. A corner at the distance q from its front handle has an error of at most (1 + 2 q / L) E. A
gap depends on two benches, and each bound on the displacement of a bench on two coordinates with an
error of 2 E: the sum is 6 (1 + 2 q / L) E.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Complex, Flags, Indices, as_complex, as_vectors
from pymunk_dragon.collision.grid import CELLS, Grid
from pymunk_dragon.collision.sat import Separation, separation
from pymunk_dragon.model import chain
from pymunk_dragon.model.chain import ChainMotion, RateBounds
from pymunk_dragon.model.march import March

# Error of a bench's equation in last digits of the largest coordinate: 8 for each point, 2 for the
# distance.
_ROUNDED = 18
# Change of the cosines of a bench's angles that rounding may cause; checked against the bound on
# rounding.
_SLACK = 1e-5
# m. Rounding error of gaps where the proof does not hold.
UNPROVEN_ROUNDING = 1e-4
# Largest sine of the angle from a bench to its path up to which the simpler bounds hold tightly.
_SHALLOW = 0.7
# Benches up to which all pairs of circles are compared: the grid takes longer.
_FEW_BENCHES = 150
# Corners of a square of side 2, counter-clockwise.
_SQUARE = np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])


class Intervals(NamedTuple):
    """Time intervals (T,) with the foremost handles: coordinates (T, H) at both ends, and motion at the midpoint."""

    begins: Array
    ends: Array
    first_s: Array
    middle: ChainMotion
    last_s: Array

    @classmethod
    def between(cls, march: March, times: Array) -> Intervals:
        """Intervals between consecutive `times`, up to the first time at which a handle has no coordinate."""
        all_times = np.empty(2 * times.size - 1)
        all_times[::2], all_times[1::2] = times, (times[:-1] + times[1:]) / 2
        motion = march.motion_or_nan(all_times)
        # If a handle has no coordinate, the last one has none.
        lost = np.isnan(motion.handles_s[:, -1])
        count = (int(lost.argmax()) - 1) // 2 if lost.any() else times.size - 1
        edges = motion.handles_s[: 2 * count + 1 : 2]
        middle = motion.each(lambda part: part[1 : 2 * count : 2])
        return cls(times[:count], times[1 : count + 1], edges[:-1], middle, edges[1:])

    def divided(self, march: March, chosen: Indices, parts: int, handles: int) -> Intervals:
        """Equal parts of the `chosen` intervals, one after the other, with the foremost `handles`."""
        index = np.arange(2 * parts + 1)
        shares = index / (2 * parts)
        times = (1 - shares) * self.begins[chosen, None] + shares * self.ends[chosen, None]
        # The ends of the parts have even numbers; those at the ends and the midpoint of the
        # interval are known.
        new = index[(index % parts > 0) | (index % 2 > 0)]
        shape = len(chosen), new.size, handles
        motion = march.motion(times[:, new], handles).each(lambda part: part.reshape(shape))
        handles_s = np.empty((*times.shape, handles))
        for k, states in (
            (0, self.first_s),
            (parts, self.middle.handles_s),
            (2 * parts, self.last_s),
        ):
            handles_s[:, k] = states[chosen, :handles]
        handles_s[:, new] = motion.handles_s
        first, last = (handles_s[:, k : k + 2 * parts : 2].reshape(-1, handles) for k in (0, 2))
        middle = motion.each(lambda part: part[:, new % 2 > 0].reshape(-1, handles))
        return Intervals(times[:, :-1:2].ravel(), times[:, 2::2].ravel(), first, middle, last)


class MotionBounds:
    """Poses of the foremost benches at the midpoints of T intervals, and bounds on their motion within them.

    `travel` (T, H) bounds the handles' distance along the path from their coordinates at the
    midpoint, m. `rounding` (T,) bounds the rounding error of gaps and of the bounds on them, m;
    where `proven` (T,) is false it is `UNPROVEN_ROUNDING`.
    """

    def __init__(self, march: March, intervals: Intervals) -> None:
        middle = intervals.middle
        self._points, self._tangents, self._ratios = middle.points, middle.tangents, middle.ratios
        self._spacings = march.dragon.spacings[: middle.points.shape[1] - 1]
        self._corner_points = march.dragon.outlines_between(self._points)
        self._front_angles, self._rear_angles = chain.angles(
            as_vectors(self._points), as_vectors(self._tangents), self._spacings
        )
        # Angular rates (T, N) at the midpoint, rad/m.
        self._omega = chain.angular_rates(self._front_angles, self._rear_angles, self._spacings)
        # Coordinates near zero are differences of larger ones: the head's at the start, and the
        # distance travelled.
        coordinates = (
            intervals.first_s[:, [0, -1]],
            march.head_start,
            self._points,
            (0.0, *march.curve.inner_ends),
        )
        largest = max(float(np.abs(part).max()) for part in coordinates)
        squares = np.abs(self._points[:, :-1] - self._points[:, 1:]) ** 2
        residual = float(np.max(np.abs(squares - self._spacings**2) / (2 * self._spacings)))
        errors = self._errors(residual + _ROUNDED * float(np.spacing(largest)))
        # Distances (N, 4) of the corners from the front handles.
        self._arms = np.abs(self._corner_points[0] - self._points[0, :-1, None])
        self._lows, highs = march.continuation.ranges(intervals.first_s, intervals.last_s)
        # Rounding may put the midpoint outside its range.
        self.travel = np.maximum(
            np.maximum(middle.handles_s - self._lows, highs - middle.handles_s), 0
        )
        self._curvature = march.curve.max_curvature(
            self._lows[:, 1:] - errors[:, 1:], highs[:, :-1] + errors[:, :-1]
        )
        worst = errors.max(axis=1)
        change = 1.5 * (2 / self._spacings.min() + self._curvature.max(axis=1)) * worst
        # m of a corner's displacement for each m of the displacement of both handles.
        self._leverage = 1 + 2 * float(np.max(self._arms / self._spacings[:, None]))
        self.proven = change <= _SLACK
        self.rounding = np.where(self.proven, 6 * self._leverage * worst, UNPROVEN_ROUNDING)
        self._known, self._rates = self._bounds(
            middle.handles_s, self.travel[:, :-1] + 2 * errors[:, :-1]
        )

    def _errors(self, residual: float) -> Array:
        """Bounds (T, H) on the errors of the coordinates, m, if the benches' equations have this residual, m."""
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            cosines = np.maximum(np.abs(self._rear_angles.real) - _SLACK, 0.0)
            ratios = chain.velocity_ratios(np.abs(self._front_angles.real) + _SLACK, cosines)
            errors = np.zeros(ratios.shape)
            np.cumsum(residual / cosines / ratios[:, 1:], axis=1, out=errors[:, 1:])
            errors *= ratios
            errors += residual
        return np.where(np.isnan(errors), np.inf, errors)

    def _bounds(self, middle_s: Array, travel: Array) -> tuple[Flags, RateBounds]:
        """Where bounds are known, and the bounds, (T, N), while front handles move by at most `travel` to either side.

        If the path is less curved than a circle with the bench as its diameter, and the rear handle
        is less than half that circle back, both angles are at most those on a circle of the path's
        largest curvature with the bench as its chord. Near that limit these bounds are too wide,
        and the angles are bounded from their midpoint values.
        """
        curvature, spacing = self._curvature, self._spacings
        sine = curvature * spacing / 2
        shallow = (sine < _SHALLOW) & (middle_s[:, :-1] - middle_s[:, 1:] < np.pi / 2 * spacing)
        sine = np.where(shallow, sine, 0.0)
        cosine = np.sqrt(1 - sine**2)
        rates = chain.rate_bounds((sine, sine), 1 / cosine, cosine, curvature, spacing)
        if shallow.all():
            return shallow, rates
        known, followed = _followed_rates(
            self._front_angles, self._rear_angles, travel, curvature, spacing
        )
        merged = (np.where(shallow, *both) for both in zip(rates, followed, strict=True))
        return shallow | known, RateBounds(*merged)

    def separations(self, rows: Indices, pairs: Indices) -> Separation:
        """Separations of `pairs` (P, 2) of benches at the midpoints of the intervals `rows` (P,)."""
        return separation(*(as_vectors(self._corner_points[rows, benches]) for benches in pairs.T))

    def smallest_gaps(self, rows: Indices, pairs: Indices, normals: Array) -> Array:
        """Lower bounds (P,) in m on the gaps of `pairs` anywhere in the intervals `rows`, along `normals` (P, 2).

        The benches are treated as independent: the bound is the distance along the normal between
        the foremost corner of the first bench and the rearmost of the second, less both
        displacement bounds.
        """
        farthest = []
        with np.errstate(over="ignore", invalid="ignore"):
            for benches, outward in zip(
                pairs.T, (as_complex(normals), -as_complex(normals)), strict=True
            ):
                heights, speeds, _, second = self._corners(rows, benches, outward)
                travel = self.travel[rows, benches][:, None]
                farthest.append(
                    np.max(heights + (np.abs(speeds) * travel + second * travel**2 / 2), axis=1)
                )
        known = self._known[rows[:, None], pairs].all(axis=1)
        return np.where(known, -farthest[1] - farthest[0] - self.rounding[rows], -np.inf)

    def smallest_gaps_together(self, rows: Indices, pairs: Indices, normals: Array) -> Array:
        """The same from the relative motion of the two benches; tighter where they move and rotate alike.

        The normal rotates with the bench `own`, the one whose edge is perpendicular to it. So the
        corners of that bench have constant projections, and only those of the other bench move.
        """
        first, second = pairs.T
        directions = as_complex(normals)
        swapped = self._squareness(rows, second, directions) > self._squareness(
            rows, first, directions
        )
        own, other = np.where(swapped, second, first), np.where(swapped, first, second)
        directions = np.where(swapped, -directions, directions)
        travel = self.travel[rows, first][:, None]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            heights, speeds, fastest, second = self._corners(rows, other, directions)
            # All derivatives are by the coordinate of the first bench's front handle, which drives
            # both.
            ratio, most, change = self._velocity_ratios(rows, first, own)
            other_ratio, other_most, other_change = self._velocity_ratios(rows, first, other)
            omega, omega_change = (
                self._rates.omega[rows, own][:, None],
                self._rates.omega_change[rows, own][:, None],
            )
            facing = directions.conj()[:, None]
            arms = self._corner_points[rows, other] - self._points[rows, own][:, None]
            ahead = (self._tangents[rows, own][:, None] * facing).real
            aside = self._omega[rows, own][:, None] * (arms * facing).imag
            speeds = other_ratio * speeds + ratio * (aside - ahead)
            second = other_most**2 * second + other_change * fastest
            fastest = other_most * fastest + most
            second += (
                most**2 * self._curvature[rows, own][:, None] + change + 2 * omega * most * fastest
            )
            second += (most**2 * (omega_change + omega**2) + change * omega) * (
                np.abs(arms) + travel * fastest
            )
            gaps = heights - (self._corner_points[rows, own] * facing).real.max(
                axis=1, keepdims=True
            )
            gaps = (gaps - np.abs(speeds) * travel - second * travel**2 / 2).min(
                axis=1
            ) - self.rounding[rows]
        known = self._known[rows[:, None], pairs].all(axis=1)
        # Velocity ratios over thousands of benches may overflow, and one between may be unknown.
        return np.where(known & np.isfinite(gaps), gaps, -np.inf)

    def gaps_by_travel(self, rows: Indices, pairs: Indices, gaps: Array) -> Array:
        """The same from the gaps at the midpoint and the handles' travel, which also hold where rates have no bound."""
        travel = np.maximum(self.travel[:, :-1], self.travel[:, 1:])
        both = travel[rows, pairs[:, 0]] + travel[rows, pairs[:, 1]]
        return np.asarray(gaps - self._leverage * both - self.rounding[rows])

    def _squareness(self, rows: Indices, benches: Indices, directions: Complex) -> Array:
        """Largest squared cosine (P,) of the angles from `directions` (P,) to the edges' normals of `benches` (P,)."""
        along = self._points[rows, benches] - self._points[rows, benches + 1]
        square: Array = ((along * directions.conj()).real / self._spacings[benches]) ** 2
        return np.maximum(square, 1 - square)

    def _velocity_ratios(
        self, rows: Indices, first: Indices, benches: Indices
    ) -> tuple[Array, Array, Array]:
        """Velocity ratio of the front handles of `benches` to those of `first`: value, bound, bound on its derivative.

        Each (P, 1); the value at the midpoint, the derivative in 1/m.
        """
        most, change = self._most_ratios
        begin, end = (rows, first), (rows, benches)
        changes = (change[end] - change[begin]) * most[end] / most[begin] ** 2
        ratios = self._ratios[end] / self._ratios[begin]
        return ratios[:, None], (most[end] / most[begin])[:, None], changes[:, None]

    @cached_property
    def _most_ratios(self) -> tuple[Array, Array]:
        """Bounds (T, H) on the velocity ratios, and the sums of the relative bounds on their derivatives, 1/m."""
        most = chain.velocity_ratios(self._rates.ratio, np.ones(1))
        change = np.zeros(most.shape)
        np.cumsum(
            self._rates.ratio_change * most[:, :-1] / self._rates.ratio, axis=1, out=change[:, 1:]
        )
        return most, change

    def _corners(
        self, rows: Indices, benches: Indices, directions: Complex
    ) -> tuple[Array, Array, Array, Array]:
        """Projections of the corners of `benches` (P,) on `directions` (P,), by the coordinate s of the front handle.

        At the midpoint the projections, m, and their derivatives; in the whole interval bounds on
        the derivative in any direction and on the second derivative, 1/m; each (P, 4).
        """
        facing = directions.conj()[:, None]
        front = self._points[rows, benches][:, None]
        # Ahead and to the left, seen along the direction.
        arms = (self._corner_points[rows, benches] - front) * facing
        omega, omega_change = (
            rate[rows, benches][:, None] for rate in (self._rates.omega, self._rates.omega_change)
        )
        lengths = self._arms[benches]
        heights = (front * facing).real + arms.real
        # Rotation moves a corner by omega J arm, whose projection on n is -omega (J n) arm.
        rotation = -self._omega[rows, benches][:, None] * arms.imag
        speeds = (self._tangents[rows, benches][:, None] * facing).real + rotation
        second = self._curvature[rows, benches][:, None] + lengths * (omega_change + omega**2)
        return heights, speeds, 1 + lengths * omega, second

    def candidates(self, near: float, start_s: Array) -> tuple[Indices, Indices]:
        """Intervals (P,) and pairs (P, 2) of benches that may come within `near` m in them, without neighbours.

        Circles about the benches that contain all their motion rule the others out. Of the pairs
        without the benches 0 and 1 only those with s_i < s_{i-1}(start), the coordinates `start_s`
        (H,); see `first_contact.py`.
        """
        middles = (self._points[:, :-1] + self._points[:, 1:]) / 2
        own = np.abs(self._corner_points[0, :, 0] - middles[0])
        margin = self.rounding[:, None]
        radii = own + (self.travel[:, :-1] + self.travel[:, 1:] + near + margin) / 2
        tested: Flags = np.ones(radii.shape, dtype=bool)
        tested[:, 2:] = self._lows[:, 2:-1] - margin < start_s[1 : tested.shape[1] - 1] + margin
        many = np.asarray(tested[:, 2:].any(axis=1))
        within: Flags = (
            np.abs(middles[:, :2, None] - middles[:, None]) <= radii[:, :2, None] + radii[:, None]
        )
        rows, first, second = np.nonzero(within & ~many[:, None, None])
        apart = second - first >= 2
        found = [(rows[apart], np.stack([first, second], axis=-1)[apart])]
        for row in np.flatnonzero(many).tolist():
            pairs = near_pairs(middles[row], radii[row])
            pairs = pairs[tested[row, pairs[:, 0]]]
            found.append((np.full(len(pairs), row), pairs))
        return np.concatenate([rows for rows, _ in found]), np.concatenate(
            [pairs for _, pairs in found]
        )


def near_pairs(centres: Complex, radii: Array) -> Indices:
    """Pairs (P, 2) of benches whose circles intersect, without neighbours."""
    if len(centres) <= _FEW_BENCHES:
        first, second = np.triu_indices(len(centres), 2)
    else:
        # No bench is further away than the chain's length, even if its bound is infinite.
        half = np.minimum(radii, np.ptp(as_vectors(centres), axis=0).sum() + 1)
        squares = (centres - centres.mean())[:, None] + half[:, None] * _SQUARE
        cell = float(np.clip(2 * half.max(), *CELLS))
        first, second = Grid(cell=cell, origin=(0.0, 0.0)).pairs(as_vectors(squares)).T
    within = np.abs(centres[first] - centres[second]) <= radii[first] + radii[second]
    return np.stack([first, second], axis=-1)[within]


def _followed_rates(
    front_turn: Complex, rear_turn: Complex, travel: Array, curvature: Array, spacing: Array
) -> tuple[Flags, RateBounds]:
    """Where bounds are known, and the bounds, on any path from the angles at the midpoint.

    The angles are assumed to change by at most some slack. If the rates that follow change them by
    less over the whole travel, the assumption holds.
    """
    # A bench that is pushed back has the same sine, and the same cosine up to its sign, as one that
    # is pulled.
    front, rear = np.abs(np.angle(front_turn)), np.abs(np.angle(rear_turn))
    front = np.minimum(front, np.pi - front)
    ratio = np.cos(front) / np.cos(rear)
    slack = (
        2
        * travel
        * (curvature * np.maximum(1, ratio) + (np.sin(front) + ratio * np.sin(rear)) / spacing)
    )
    slack = np.minimum(slack, np.pi)
    widest_front, widest_rear = (
        np.minimum(front + slack, np.pi / 2),
        np.minimum(rear + slack, np.pi / 2),
    )
    cosine = np.cos(widest_rear)
    ratio = np.cos(np.maximum(front - slack, 0)) / cosine
    known = rear + slack < np.pi / 2
    sines = np.sin(widest_front), np.sin(widest_rear)
    rates = chain.rate_bounds(sines, ratio, cosine, curvature, spacing)
    known &= travel * (curvature * np.maximum(1, ratio) + rates.omega) <= slack
    return known, rates._replace(ratio=np.where(known, ratio, np.inf))
