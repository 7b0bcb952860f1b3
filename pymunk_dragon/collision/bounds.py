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

Distances from the origin. If all normals of the path pass the origin at c or less
(`Curve.normal_offset`), then |d|P(s)|^2 / ds| = 2 |P . T| <= 2 c. So |P|^2 changes by at most 2 c m
while s moves by m: at most the computed travel and 2 E. Let a and b be the distances of a bench's
handles from the origin, m that of its middle, n that of the line through the handles, and x the
distance along that line from its point next to the origin to the middle. Then

    m^2 = (a^2 + b^2) / 2 - L^2 / 4,  x = |a^2 - b^2| / (2 L),  n^2 = m^2 - x^2.

So bounds on the changes of a^2 and b^2 bound those of m, x and n. All of a bench of the length 2 l
and the width w is at least n - w / 2 away from the origin. Its farthest point is a corner, at the
squared distance (x + l)^2 + (n + w / 2)^2, which is at most m^2 + 2 l x + l^2 + w m + w^2 / 4. If
one bench is nowhere as close to the origin as another one is anywhere, a circle about the origin
separates them, and their gap is at least the difference.

The computed m^2 has an error of up to L h / 2, as the handles are L apart to h only, and rounding
changes it, L x, and the sums and differences of squares by less than 100 u (m + 2 l). The bounds on
m^2 and L x are wider by (m + 2 l) times the rounding error of gaps, which is at least 18 E, and E
is at least h and 18 u.
"""

from __future__ import annotations

from functools import cached_property, partial
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
    """Time intervals (T,) with the foremost handles.

    The coordinates of the handles (T, H) at both ends, and their motion at the midpoint.
    """

    begins: Array
    ends: Array
    first_s: Array
    middle: ChainMotion
    last_s: Array

    @classmethod
    def between(cls, march: March, times: Array) -> Intervals:
        """Intervals between `times`, up to the first one at which a handle has no coordinate.

        The march is at 1 m/s.
        """
        states = 2 * times.size * march.dragon.handles
        compute = partial(cls._between, march, times)
        return march.continuation.keep(times.tobytes(), states, compute)

    @classmethod
    def _between(cls, march: March, times: Array) -> Intervals:
        """The same, computed."""
        all_times = np.empty(2 * times.size - 1)
        all_times[::2] = times
        all_times[1::2] = (times[:-1] + times[1:]) / 2
        motion = march.motion_or_nan(all_times)

        # If a handle has no coordinate, the last one has none.
        lost = np.isnan(motion.handles_s[:, -1])
        count = times.size - 1
        if lost.any():
            count = (int(lost.argmax()) - 1) // 2
        edges = motion.handles_s[: 2 * count + 1 : 2]
        middle = motion.each(lambda part: part[1 : 2 * count : 2])
        ends = times[1 : count + 1]
        return cls(times[:count], ends, edges[:-1], middle, edges[1:])

    def divided(self, march: March, chosen: Indices, parts: int, handles: int) -> Intervals:
        """Equal parts of the `chosen` intervals, in order, with the foremost `handles`."""
        index = np.arange(2 * parts + 1)
        shares = index / (2 * parts)
        times = (1 - shares) * self.begins[chosen, None] + shares * self.ends[chosen, None]

        # The ends of the parts have even numbers; those at the ends and the midpoint of the
        # interval are known.
        new = index[(index % parts > 0) | (index % 2 > 0)]
        shape = len(chosen), new.size, handles
        motion = march.motion(times[:, new], handles)
        motion = motion.each(lambda part: part.reshape(shape))
        handles_s = np.empty((*times.shape, handles))
        handles_s[:, 0] = self.first_s[chosen, :handles]
        handles_s[:, parts] = self.middle.handles_s[chosen, :handles]
        handles_s[:, -1] = self.last_s[chosen, :handles]
        handles_s[:, new] = motion.handles_s

        first = handles_s[:, :-1:2].reshape(-1, handles)
        last = handles_s[:, 2::2].reshape(-1, handles)
        midpoints = new % 2 > 0
        middle = motion.each(lambda part: part[:, midpoints].reshape(-1, handles))
        begins = times[:, :-1:2].ravel()
        return Intervals(begins, times[:, 2::2].ravel(), first, middle, last)


class MotionBounds:
    """Bounds on the motion of the foremost benches within T intervals, and poses at the midpoints.

    `travel` (T, H) bounds the handles' distance along the path from their coordinates at the
    midpoint, m. `rounding` (T,) bounds the rounding error of gaps and of the bounds on them, m;
    where `proven` (T,) is false it is `UNPROVEN_ROUNDING`.
    """

    def __init__(self, march: March, intervals: Intervals) -> None:
        middle = intervals.middle
        self._points = middle.points
        self._tangents = middle.tangents
        self._ratios = middle.ratios
        self._dragon = march.dragon
        self._normal_offset = march.curve.normal_offset
        self._spacings = spacings = march.dragon.spacings[: middle.points.shape[1] - 1]
        self._corner_points = march.dragon.outlines_between(self._points)
        # Distances (N, 4) of the corners from the front handles.
        front = self._points[0, :-1, None]
        self._arms = np.abs(self._corner_points[0] - front)
        self._front_angles, self._rear_angles = chain.angles(
            as_vectors(self._points), as_vectors(self._tangents), spacings
        )
        # Angular rates (T, N) at the midpoint, rad/m.
        self._omega = chain.angular_rates(self._front_angles, self._rear_angles, spacings)

        # Coordinates near zero are differences of larger ones: the head's at the start, and the
        # distance travelled.
        ends = march.head_start, *march.curve.inner_ends
        coordinates = intervals.first_s[:, [0, -1]], self._points, ends
        largest = max(float(np.abs(part).max()) for part in coordinates)
        along = self._points[:, :-1] - self._points[:, 1:]
        squares = np.abs(along) ** 2
        residuals = np.abs(squares - spacings**2) / (2 * spacings)
        rounded = _ROUNDED * float(np.spacing(largest))
        errors = self._errors(float(residuals.max()) + rounded)

        self._lows, highs = march.continuation.ranges(intervals.first_s, intervals.last_s)
        behind = middle.handles_s - self._lows
        ahead = highs - middle.handles_s
        # Rounding may put the midpoint outside its range.
        self.travel = np.maximum(np.maximum(behind, ahead), 0)
        lows = self._lows[:, 1:] - errors[:, 1:]
        highs = highs[:, :-1] + errors[:, :-1]
        self._curvature = march.curve.max_curvature(lows, highs)

        worst = errors.max(axis=1)
        change = 1.5 * (2 / spacings.min() + self._curvature.max(axis=1)) * worst
        # m of a corner's displacement for each m of the displacement of both handles.
        arms = self._arms / spacings[:, None]
        self._leverage = 1 + 2 * float(arms.max())
        self.proven = change <= _SLACK
        self.rounding = np.where(self.proven, 6 * self._leverage * worst, UNPROVEN_ROUNDING)
        travel = self.travel[:, :-1] + 2 * errors[:, :-1]
        self._known, self._rates = self._bounds(middle.handles_s, travel)

    def _errors(self, residual: float) -> Array:
        """Bounds (T, H) on the errors of the coordinates, m, from the benches' `residual`, m."""
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            cosines = np.maximum(np.abs(self._rear_angles.real) - _SLACK, 0.0)
            ratios = chain.velocity_ratios(np.abs(self._front_angles.real) + _SLACK, cosines)
            errors = np.zeros(ratios.shape)
            added = residual / cosines / ratios[:, 1:]
            np.cumsum(added, axis=1, out=errors[:, 1:])
            errors *= ratios
            errors += residual
        return np.where(np.isnan(errors), np.inf, errors)

    def _bounds(self, middle_s: Array, travel: Array) -> tuple[Flags, RateBounds]:
        """Bounds on the rates (T, N), and where they are known.

        Front handles move by at most `travel` to either side.

        If the path is less curved than a circle with the bench as its diameter, and the rear handle
        is less than half that circle back, both angles are at most those on a circle of the path's
        largest curvature with the bench as its chord. Near that limit these bounds are too wide,
        and the angles are bounded from their midpoint values.
        """
        curvature, spacing = self._curvature, self._spacings
        sine = curvature * spacing / 2
        back = middle_s[:, :-1] - middle_s[:, 1:]
        shallow = (sine < _SHALLOW) & (back < np.pi / 2 * spacing)
        sine = np.where(shallow, sine, 0.0)
        cosine = np.sqrt(1 - sine**2)
        rates = chain.rate_bounds((sine, sine), 1 / cosine, cosine, curvature, spacing)
        if shallow.all():
            return shallow, rates
        known, followed = _followed_rates(
            self._front_angles, self._rear_angles, travel, curvature, spacing
        )
        return shallow | known, RateBounds._make(map(partial(np.where, shallow), rates, followed))

    def may_meet(self, rows: Indices, pairs: Indices, near: float) -> Flags:
        """Whether no circle about the origin separates `pairs` (P, 2) by `near` m in `rows` (P,).

        The module's docstring has the bounds on the distances of benches from the origin.
        """
        front = rows[:, None], pairs
        rear = rows[:, None], pairs + 1
        length = self._dragon.lengths[pairs]
        width = self._dragon.widths[pairs]
        along = self._points[front] - self._points[rear]
        middle = self._points[front] - along / 2
        distance = np.abs(middle)

        rounding = self.rounding[rows, None]
        moved = self.travel[front] + self.travel[rear] + rounding
        change = self._normal_offset * moved + (distance + length) * rounding
        offset = np.abs((along.conj() * middle).real) + change
        offset /= self._spacings[pairs]
        nearest = np.sqrt(np.maximum(distance**2 - change - offset**2, 0)) - width / 2
        highest = distance**2 + change
        farthest = highest + length * (offset + length / 4)
        farthest += width * (np.sqrt(highest) + width / 4)
        gaps = (nearest - np.sqrt(farthest)[:, ::-1]).max(axis=1) - near
        return np.asarray(~(self.proven[rows] & (gaps > self.rounding[rows])))

    def separations(self, rows: Indices, pairs: Indices) -> Separation:
        """Separations of `pairs` (P, 2) of benches at the midpoints of intervals `rows` (P,)."""
        return separation(*(as_vectors(self._corner_points[rows, benches]) for benches in pairs.T))

    def smallest_gaps(self, rows: Indices, pairs: Indices, normals: Array) -> Array:
        """Lower bounds (P,) in m on the gaps of `pairs` anywhere in the intervals `rows`.

        The benches are treated as independent: the bound is the distance along the normal (P, 2)
        between the foremost corner of the first bench and the rearmost of the second, less both
        displacement bounds.
        """
        directions = as_complex(normals)
        farthest = []
        with np.errstate(over="ignore", invalid="ignore"):
            for benches, outward in zip(pairs.T, (directions, -directions), strict=True):
                heights, speeds, _, second = self._corners(rows, benches, outward)
                travel = self.travel[rows, benches][:, None]
                displacement = np.abs(speeds) * travel + second * travel**2 / 2
                farthest.append(np.max(heights + displacement, axis=1))
        front, rear = farthest
        known = self._known[rows[:, None], pairs].all(axis=1)
        return np.where(known, -rear - front - self.rounding[rows], -np.inf)

    def smallest_gaps_together(self, rows: Indices, pairs: Indices, normals: Array) -> Array:
        """Lower bounds (P,) in m on the gaps of `pairs`, from the relative motion of the benches.

        They are tighter than `smallest_gaps` where the benches move and rotate alike. The normal
        rotates with the bench `own`, the one whose edge is perpendicular to it. So the corners of
        that bench have constant projections, and only those of the other bench move.
        """
        first, second = pairs.T
        directions = as_complex(normals)
        first_square = self._squareness(rows, first, directions)
        swapped = self._squareness(rows, second, directions) > first_square
        own = np.where(swapped, second, first)
        other = np.where(swapped, first, second)
        directions = np.where(swapped, -directions, directions)
        facing = directions.conj()[:, None]

        column = rows[:, None]
        begin = column, first[:, None]
        at = column, own[:, None]
        travel = self.travel[begin]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            heights, speeds, fastest, second = self._corners(rows, other, directions)
            # All derivatives are by the coordinate of the first bench's front handle, which drives
            # both.
            ratio, most, change = self._velocity_ratios(begin, at)
            other_ratio, other_most, other_change = self._velocity_ratios(
                begin, (column, other[:, None])
            )
            omega = self._rates.omega[at]
            omega_change = self._rates.omega_change[at]

            # The frame of the projections moves and rotates with `own`.
            arms = self._corner_points[rows, other] - self._points[at]
            ahead = (self._tangents[at] * facing).real
            aside = self._omega[at] * (arms * facing).imag
            speeds = other_ratio * speeds + ratio * (aside - ahead)
            second = other_most**2 * second + other_change * fastest
            fastest = other_most * fastest + most
            second += most**2 * self._curvature[at] + change + 2 * omega * most * fastest
            rotation = most**2 * (omega_change + omega**2) + change * omega
            second += rotation * (np.abs(arms) + travel * fastest)

            edges = (self._corner_points[rows, own] * facing).real
            gaps = heights - edges.max(axis=1, keepdims=True)
            gaps = gaps - np.abs(speeds) * travel - second * travel**2 / 2
            gaps = gaps.min(axis=1) - self.rounding[rows]
        known = self._known[column, pairs].all(axis=1)
        # Velocity ratios over thousands of benches may overflow, and one between may be unknown.
        return np.where(known & np.isfinite(gaps), gaps, -np.inf)

    def gaps_by_travel(self, rows: Indices, pairs: Indices, gaps: Array) -> Array:
        """Lower bounds (P,) in m on the gaps, from those at the midpoint and the handles' travel.

        They hold where rates have no bound, too.
        """
        travel = np.maximum(self.travel[:, :-1], self.travel[:, 1:])
        both = travel[rows, pairs[:, 0]] + travel[rows, pairs[:, 1]]
        return gaps - self._leverage * both - self.rounding[rows]

    def _squareness(self, rows: Indices, benches: Indices, directions: Complex) -> Array:
        """Squared cosine (P,) of the angle from `directions` (P,) to the nearest edge normal."""
        along = self._points[rows, benches] - self._points[rows, benches + 1]
        square: Array = ((along * directions.conj()).real / self._spacings[benches]) ** 2
        return np.maximum(square, 1 - square)

    def _velocity_ratios(
        self, begin: tuple[Indices, Indices], end: tuple[Indices, Indices]
    ) -> tuple[Array, Array, Array]:
        """Velocity ratios of the front handles at the indices `end` to those at `begin`.

        The value at the midpoint, a bound on it in the interval, and one on its derivative, 1/m.
        """
        most, change = self._most_ratios
        most_begin, most_end = most[begin], most[end]
        changes = (change[end] - change[begin]) * most_end / most_begin**2
        return self._ratios[end] / self._ratios[begin], most_end / most_begin, changes

    @cached_property
    def _most_ratios(self) -> tuple[Array, Array]:
        """Bounds (T, H) on the velocity ratios, and the sums of relative ones on their derivatives.

        The sums are in 1/m.
        """
        ratio = self._rates.ratio
        most = chain.velocity_ratios(ratio, np.ones(1))
        relative = self._rates.ratio_change * most[:, :-1] / ratio
        change = np.zeros(most.shape)
        np.cumsum(relative, axis=1, out=change[:, 1:])
        return most, change

    def _corners(
        self, rows: Indices, benches: Indices, directions: Complex
    ) -> tuple[Array, Array, Array, Array]:
        """Projections of the corners of `benches` (P,) on `directions` (P,), and their derivatives.

        At the midpoint the projections, m, and their derivatives by the coordinate s of the front
        handle; in the whole interval bounds on the derivative in any direction and on the second
        derivative, 1/m; each (P, 4).
        """
        at = rows[:, None], benches[:, None]
        facing = directions.conj()[:, None]
        front = self._points[at]
        # Ahead and to the left, seen along the direction.
        arms = (self._corner_points[rows, benches] - front) * facing
        heights = (front * facing).real + arms.real
        # Rotation moves a corner by omega J arm, whose projection on n is -omega (J n) arm.
        rotation = -self._omega[at] * arms.imag
        speeds = (self._tangents[at] * facing).real + rotation

        lengths = self._arms[benches]
        omega = self._rates.omega[at]
        rotation_change = self._rates.omega_change[at] + omega**2
        second = self._curvature[at] + lengths * rotation_change
        return heights, speeds, 1 + lengths * omega, second

    def candidates(self, near: float, start_s: Array) -> tuple[Indices, Indices]:
        """Intervals (P,), and pairs (P, 2) of benches that may come within `near` m in them.

        Circles about the benches that contain all their motion rule the others out, or circles
        about the origin; neighbours are left out. Of the pairs without the benches 0 and 1 only
        those with s_i < s_{i-1}(start), the coordinates `start_s` (H,); see `first_contact.py`.
        """
        middles = (self._points[:, :-1] + self._points[:, 1:]) / 2
        own = np.abs(self._corner_points[0, :, 0] - middles[0])
        margin = self.rounding[:, None]
        both = self.travel[:, :-1] + self.travel[:, 1:]
        radii = own + (both + near + margin) / 2

        tested: Flags = np.ones(radii.shape, dtype=bool)
        before = start_s[1 : radii.shape[1] - 1]
        tested[:, 2:] = self._lows[:, 2:-1] - margin < before + margin
        many = np.asarray(tested[:, 2:].any(axis=1))

        # Where only pairs of the benches 0 and 1 are tested, these are compared with all others.
        distances = np.abs(middles[:, :2, None] - middles[:, None])
        within: Flags = distances <= radii[:, :2, None] + radii[:, None]
        within[many] = False
        rows, first, second = np.nonzero(within)
        apart = second - first >= 2
        found_rows = [rows[apart]]
        found_pairs = [np.stack([first, second], axis=-1)[apart]]

        for row in np.flatnonzero(many).tolist():
            pairs = near_pairs(middles[row], radii[row])
            pairs = pairs[tested[row, pairs[:, 0]]]
            found_rows.append(np.full(len(pairs), row))
            found_pairs.append(pairs)
        rows = np.concatenate(found_rows)
        pairs = np.concatenate(found_pairs)
        left = self.may_meet(rows, pairs, near)
        return rows[left], pairs[left]


def near_pairs(centres: Complex, radii: Array) -> Indices:
    """Pairs (P, 2) of benches whose circles intersect, without neighbours."""
    if len(centres) <= _FEW_BENCHES:
        first, second = np.triu_indices(len(centres), 2)
    else:
        # No bench is further away than the chain's length, even if its bound is infinite.
        length = np.ptp(as_vectors(centres), axis=0).sum()
        half = np.minimum(radii, length + 1)
        squares = (centres - centres.mean())[:, None] + half[:, None] * _SQUARE
        cell = float(np.clip(2 * half.max(), *CELLS))
        grid = Grid(cell=cell, origin=(0.0, 0.0))
        first, second = grid.pairs(as_vectors(squares)).T
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
    front = np.abs(np.angle(front_turn))
    front = np.minimum(front, np.pi - front)
    rear = np.abs(np.angle(rear_turn))
    ratio = np.cos(front) / np.cos(rear)
    rotation = (np.sin(front) + ratio * np.sin(rear)) / spacing
    slack = 2 * travel * (curvature * np.maximum(1, ratio) + rotation)
    slack = np.minimum(slack, np.pi)

    widest_front = np.minimum(front + slack, np.pi / 2)
    widest_rear = np.minimum(rear + slack, np.pi / 2)
    sines = np.sin(widest_front), np.sin(widest_rear)
    cosine = np.cos(widest_rear)
    ratio = np.cos(np.maximum(front - slack, 0)) / cosine
    known = rear + slack < np.pi / 2
    rates = chain.rate_bounds(sines, ratio, cosine, curvature, spacing)
    known &= travel * (curvature * np.maximum(1, ratio) + rates.omega) <= slack
    return known, rates._replace(ratio=np.where(known, ratio, np.inf))
