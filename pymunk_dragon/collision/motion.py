"""How far benches move within a stretch of time, at most: bounds that clear the moments at which nobody looked.

On a path a bench's pose is a function of one number, the arc length s of its front hole. With the angles alpha and beta
from the bench to the path's directions at its front and its rear hole, spacing L and the path's curvatures kappa_f and
kappa_r there, the rigid bench has

- rear hole:  dr/ds = rho = cos alpha / cos beta,
- turning:    dphi/ds = omega = (sin alpha - rho sin beta) / L,
- and so      drho/ds = (rho^2 kappa_r sin beta - kappa_f sin alpha + omega^2 L) / cos beta,
              domega/ds = (kappa_f cos alpha - rho^2 kappa_r cos beta - drho/ds sin beta) / L.

With bounds on the angles and on the curvature, each of these is bounded too, and so is the second derivative of every
corner q from the front hole: kappa + |q| (domega/ds + omega^2). Taylor's theorem does the rest. None of this depends on
the direction in which the front hole moves: `Continuation.ranges` bounds its way also where it reverses.

Rounding. A point of the curve is right to 8 last digits u of the largest coordinate, in space or along the path or one
of its pieces; the tests measure this for the package's curves, and `Curve.point` asks it of others. So with F = (|P(s)
- P(r)|^2 - L^2) / (2 L), the computed coordinates have |F| <= h = 18 u: 8 u for each point, and 2 u for the distance;
Newton's last step is the square of 1e-10 and does not count. Let F go from there to 0 in proportion to 1 - tau, and the
coordinates with it. While each of them stays within E of where it was, cos alpha and cos beta stay within (2 / L +
kappa) E of their values, and by half as much again for the rounded length of the bench. Where this is at most `SLACK`,
d|s|/dtau of the front hole and d|r|/dtau of the rear hole satisfy

    d|r|/dtau <= ((|cos alpha| + SLACK) d|s|/dtau + h) / (|cos beta| - SLACK).

E is the largest of what this gives along the chain, from h for the head. So the coordinates never leave that range, and
the exact ones, at tau = 1, are in it. Where E is too large for `SLACK`, nothing is known. With arms of length q, a
corner is at most (1 + 2 q / L) E wrong. The gap depends on two benches, and each of them on a way between two
coordinates, with an error of 2 E, as well: 6 (1 + 2 q / L) E in all.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision.grid import MAX_CELL, MIN_CELL, Grid
from pymunk_dragon.collision.sat import Separation, separation
from pymunk_dragon.curves.base import Curve, frame, sharpest
from pymunk_dragon.curves.composite import Composite
from pymunk_dragon.curves.spiral import Spiral
from pymunk_dragon.dragon import bench_poses
from pymunk_dragon.march import March

__all__ = ["Motion", "Stretches", "handles_in_reach", "near_pairs"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]

# Last digits of the largest coordinate that a bench's equation may be wrong by: 8 for each point, 2 for the distance.
ROUNDED = 18
QUARTER = np.pi / 2
# Change of the cosines of a bench's angles to its path that rounding may make.
SLACK = 1e-5
# Sine of the angle from a bench to its path, at most, up to which it is not followed.
SHALLOW = 0.7
# Corners of a square with half its side as the unit, counter-clockwise.
SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


@dataclass(frozen=True)
class Stretches:
    """Stretches of time (T,) with the places (T, H) of the foremost handles when each begins, at its middle and end."""

    begins: Array
    ends: Array
    first_places: Array
    places: Array
    last_places: Array

    @classmethod
    def between(cls, march: March, times: Array, handles: int | None = None) -> Stretches:
        """Those from each of `times` to the next, with all or the foremost `handles`, while these have places."""
        all_times = np.empty(2 * times.size - 1)
        all_times[::2], all_times[1::2] = times, (times[:-1] + times[1:]) / 2
        places = march.places(all_times, handles)
        # A handle that has no place leaves none to the last one.
        lost = np.isnan(places[:, -1])
        count = (int(lost.argmax()) - 1) // 2 if lost.any() else times.size - 1
        places = places[: 2 * count + 1]
        return cls(times[:count], times[1 : count + 1], places[:-1:2], places[1::2], places[2::2])

    def halved(self, march: March, chosen: Indices, handles: int) -> Stretches:
        """The first halves of the `chosen` stretches and then their second halves, with the foremost `handles`."""
        begins, middles, ends = self.begins[chosen], self.middles[chosen], self.ends[chosen]
        first, middle, last = (
            places[chosen, :handles] for places in (self.first_places, self.places, self.last_places)
        )
        begins, ends = np.concatenate([begins, middles]), np.concatenate([middles, ends])
        first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
        return Stretches(begins, ends, first, march.parameters((begins + ends) / 2, handles), last)

    @property
    def middles(self) -> Array:
        """(T,), s."""
        return (self.begins + self.ends) / 2

    @property
    def lengths(self) -> Array:
        """(T,), s."""
        return self.ends - self.begins


@dataclass(frozen=True)
class _Rates:
    """Bounds on benches over stretches, arrays of one shape.

    Attributes
    ----------
    known : ndarray of bool
        Whether the other bounds hold; they are infinite or meaningless where not.
    lag : ndarray
        Way of the rear hole for each metre of the front hole's, in either direction, at most; inf where unknown.
    lag_change : ndarray
        Change of that, 1/m, at most.
    turn : ndarray
        Turning, rad per metre of the front hole's way, at most.
    turn_change : ndarray
        Change of the turning, rad per square metre, at most.
    """

    known: Flags
    lag: Array
    lag_change: Array
    turn: Array
    turn_change: Array


@dataclass(frozen=True)
class _Corners:
    """Corners (P, 4) of P benches along a direction, over the way s of the bench's front hole.

    Attributes
    ----------
    known : ndarray of bool, shape (P,)
        Whether the bounds hold.
    heights, speeds : ndarray, shape (P, 4)
        Place in m, and its derivative by s, in the middle of the stretch.
    fastest, bends : ndarray, shape (P, 4)
        Bounds on the derivative, in any direction, and in 1/m on the second derivative.
    """

    known: Flags
    heights: Array
    speeds: Array
    fastest: Array
    bends: Array

    def swing(self, ways: Array) -> Array:
        """How far each corner comes at most, to either side, m."""
        way = np.where(self.known, ways, 0.0)[:, None]
        swing: Array = np.abs(self.speeds) * way + self.bends * way**2 / 2
        return swing


class Motion:
    """A dragon's foremost benches in T stretches of time: as they are in the middle, and how far they may move from it.

    Attributes
    ----------
    outlines : ndarray, shape (T, N, 4, 2)
        Corners of the benches in the middle, m.
    rounding : ndarray, shape (T,)
        What gaps, and bounds on them, may be wrong by, m.
    lows : ndarray, shape (T, H)
        Lowest places of the handles within the stretch, m.
    ways : ndarray, shape (T, H)
        How far each handle goes from the middle within the stretch, to either side and at most, m along the path.
    """

    def __init__(self, march: March, stretches: Stretches) -> None:
        self._march = march
        handles = stretches.places.shape[1]
        self._spacings = march.dragon.spacings[: handles - 1]
        self._points, self._tangents = frame(march.curve, stretches.places)
        self.outlines = march.dragon.outlines(bench_poses(self._points))
        self._front_turns, self._rear_turns = self._turns()
        # However near zero, places come from that of the head at the start and its way.
        coordinates = stretches.first_places[:, [0, -1]], march.head_start, self._points, _of_pieces(march.curve)
        largest = max(float(np.abs(part).max()) for part in coordinates)
        errors = self._errors(ROUNDED * float(np.spacing(largest)))
        arms = np.hypot(*(self.outlines[0] - self._points[0, :-1, None]).T).max(axis=0)
        self.lows, highs = march.continuation.ranges(stretches.first_places, stretches.last_places)
        # Rounding may put the middle beside its range.
        self.ways = np.maximum(np.maximum(stretches.places - self.lows, highs - stretches.places), 0)
        self._bends = sharpest(march.curve, self.lows[:, 1:] - errors[:, 1:], highs[:, :-1] + errors[:, :-1])
        worst = errors.max(axis=1)
        change = 1.5 * (2 / self._spacings.min() + self._bends.max(axis=1)) * worst
        rounding = 6 * (1 + 2 * float(np.max(arms / self._spacings))) * worst
        self.rounding = np.where(change <= SLACK, rounding, np.inf)
        self._rates = self._bounds(stretches.places, self.ways[:, :-1] + 2 * errors[:, :-1])

    def _errors(self, residual: float) -> Array:
        """Errors (T, H) of the places, m, where benches' equations hold but for a `residual`."""
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            cosines = np.maximum(np.abs(self._rear_turns.real) - SLACK, 0.0)
            lags = _products((np.abs(self._front_turns.real) + SLACK) / cosines)
            errors = residual + np.pad(
                lags[:, 1:] * np.cumsum(residual / cosines / lags[:, 1:], axis=1), ((0, 0), (1, 0))
            )
        return np.where(np.isnan(errors), np.inf, errors)

    def _turns(self) -> tuple[Complex, Complex]:
        """Turns (T, N), e^(i angle), from each bench to the path at its front and its rear hole."""
        points, tangents = (array.view(complex)[..., 0] for array in (self._points, self._tangents))
        heading = (points[:, :-1] - points[:, 1:]) / self._spacings
        return tangents[:, :-1] * heading.conj(), tangents[:, 1:] * heading.conj()

    def _bounds(self, places: Array, ways: Array) -> _Rates:
        """Bounds (T, N) on the benches as their front holes go `ways` (T, N) to either side of the middle.

        On a path that bends less than a circle with the bench as its diameter, and where the rear hole is no further
        back than half that circle, neither angle is ever larger than on the circle that bends as much as the path does,
        with the bench as its chord. Close to that limit these bounds are far too wide.
        """
        bend, spacing = self._bends, self._spacings
        sine = bend * spacing / 2
        shallow = (sine < SHALLOW) & (places[:, :-1] - places[:, 1:] < np.pi / 2 * spacing)
        sine = np.where(shallow, sine, 0.0)
        cosine = np.sqrt(1 - sine**2)
        rates = _rates_within(shallow, (sine, sine), 1 / cosine, cosine, bend, spacing)
        if shallow.all():
            return rates
        followed = _followed_rates(self._front_turns, self._rear_turns, ways, bend, spacing)
        merged = zip(astuple(rates), astuple(followed), strict=True)
        return _Rates(*(np.where(shallow, one, other) for one, other in merged))

    def breaking_new_ground(self, start: Array) -> Flags:
        """Benches (T, N) that may be where no bench before them has been since all were at the places `start` (H,)."""
        benches = self.lows.shape[1] - 1
        new: Flags = np.ones((len(self.lows), benches), dtype=bool)
        margin = self.rounding[:, None]
        new[:, 2:] = self.lows[:, 2:-1] - margin < start[1 : benches - 1] + margin
        return new

    def separations(self, rows: Indices, pairs: Indices) -> Separation:
        """Separations of `pairs` (P, 2) of benches in the middles of the stretches `rows` (P,)."""
        return separation(self.outlines[rows, pairs[:, 0]], self.outlines[rows, pairs[:, 1]])

    def smallest_gaps(self, rows: Indices, pairs: Indices, normals: Array) -> Array:
        """Lower bounds (P,) in m on the gaps of `pairs` anywhere in the stretches `rows`, along `normals` (P, 2).

        As if each bench moved on its own: what is left between the first one's foremost corner along the normal and
        the second one's rearmost, each as far as it may come. Quick, and good enough where gaps are wide.
        """
        first, second = pairs.T
        one, other = self._corners(rows, first, normals), self._corners(rows, second, normals)
        farthest = np.max(one.heights + one.swing(self.ways[rows, first]), axis=1)
        nearest = np.min(other.heights - other.swing(self.ways[rows, second]), axis=1)
        return np.where(one.known & other.known, nearest - farthest - self.rounding[rows], -np.inf)

    def smallest_gaps_together(self, rows: Indices, pairs: Indices, normals: Array) -> Array:
        """The same from the motion of one bench as the other sees it.

        Benches that pass each other go about as fast and turn about as fast, so this sees how a gap that nearly stands
        still does. The normal turns with the bench that has an edge along it, whose foremost corners then stay where
        they are, and only those of the other one move.
        """
        first, second = pairs.T
        swapped = self._squareness(rows, second, normals) > self._squareness(rows, first, normals)
        own, other = np.where(swapped, second, first), np.where(swapped, first, second)
        normals = np.where(swapped[:, None], -normals, normals)
        seen = self._corners(rows, other, normals)
        known = seen.known & self._rates.known[rows, own]
        way = np.where(known, self.ways[rows, first], 0.0)[:, None]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            # All by the way of the first bench's front hole, which drives both.
            lag, most, change = self._lags(rows, first, own)
            other_lag, other_most, other_change = self._lags(rows, first, other)
            turn, turn_change = self._rates.turn[rows, own][:, None], self._rates.turn_change[rows, own][:, None]
            front = self._points[rows, own][:, None]
            arms = self.outlines[rows, other] - front
            ahead = _dot(self._tangents[rows, own][:, None], normals)
            aside = self._turning[rows, own][:, None] * _dot(arms, _left_of(normals))
            speeds = other_lag * seen.speeds + lag * (aside - ahead)
            fastest = other_most * seen.fastest + most
            bends = other_most**2 * seen.bends + other_change * seen.fastest
            bends += most**2 * self._bends[rows, own][:, None] + change + 2 * turn * most * fastest
            bends += (most**2 * (turn_change + turn**2) + change * turn) * (np.hypot(*arms.T).T + way * fastest)
            gaps = seen.heights - _dot(self.outlines[rows, own], normals).max(axis=1, keepdims=True)
            gaps = (gaps - np.abs(speeds) * way - bends * way**2 / 2).min(axis=1) - self.rounding[rows]
        # Where the lags of very many benches do not fit into a double, or one between is unknown, nothing is known.
        return np.where(known & np.isfinite(gaps), gaps, -np.inf)

    def _squareness(self, rows: Indices, benches: Indices, normals: Array) -> Array:
        """How square `normals` (P, 2) stand on a side of `benches` (P,): 1 where they do, and less elsewhere."""
        rear, front = self._points[rows, benches + 1], self._points[rows, benches]
        along = (_dot((front - rear)[:, None], normals)[:, 0] / self._spacings[benches]) ** 2
        return np.maximum(along, 1 - along)

    def _lags(self, rows: Indices, first: Indices, benches: Indices) -> tuple[Array, Array, Array]:
        """Way of the front holes of `benches` for each metre of that of `first`, each (P, 1).

        In the middle; at most; and how much it changes in a metre at most, 1/m.
        """
        lags = _products(self._front_turns.real / self._rear_turns.real)
        most = _products(self._rates.lag)
        change = np.cumsum(self._rates.lag_change * most[:, :-1] / self._rates.lag, axis=1)
        change = np.concatenate([np.zeros((len(change), 1)), change], axis=1)
        begin, end = (rows, first), (rows, benches)
        changes = (change[end] - change[begin]) * most[end] / most[begin] ** 2
        return (lags[end] / lags[begin])[:, None], (most[end] / most[begin])[:, None], changes[:, None]

    def _corners(self, rows: Indices, benches: Indices, normals: Array) -> _Corners:
        """The corners of `benches` (P,) in the stretches `rows`, seen along `normals` (P, 2)."""
        rates = self._rates
        corners = self.outlines[rows, benches]
        arms = corners - self._points[rows, benches][:, None]
        lengths = np.hypot(arms[..., 0], arms[..., 1])
        # Turning moves a corner square to its arm: by omega J arm, whose part along n is -omega (J n) arm.
        turning = -self._turning[rows, benches][:, None] * _dot(arms, _left_of(normals))
        turn, turn_change = rates.turn[rows, benches][:, None], rates.turn_change[rows, benches][:, None]
        return _Corners(
            known=rates.known[rows, benches],
            heights=_dot(corners, normals),
            speeds=_dot(self._tangents[rows, benches][:, None], normals) + turning,
            fastest=1 + lengths * turn,
            bends=self._bends[rows, benches][:, None] + lengths * (turn_change + turn**2),
        )

    @cached_property
    def _turning(self) -> Array:
        """Turning (T, N) of the benches in the middle, rad per metre of the front hole's way."""
        front, rear = self._front_turns, self._rear_turns
        turning: Array = (front.imag - front.real / rear.real * rear.imag) / self._spacings
        return turning

    def candidates(self, near: float, watched: Flags) -> tuple[Indices, Indices]:
        """Stretches (P,) and pairs (P, 2) of benches, without neighbours, that may come within `near` m in them.

        Only pairs whose first bench is `watched` (T, N) in the stretch. Circles about the benches, wide enough for all
        their motion, rule the others out.
        """
        centres = self.outlines.mean(axis=2)
        own = np.hypot(*(self.outlines[0, :, 0] - centres[0]).T)
        radii = own + (self.ways[:, :-1] + self.ways[:, 1:] + near + self.rounding[:, None]) / 2
        leaders = centres[:, :2, None], radii[:, :2, None]
        many = watched[:, 2:].any(axis=1)
        few = np.flatnonzero(~many)
        rows, first, second = np.nonzero(_meet(leaders[0][few], leaders[1][few], centres[few, None], radii[few, None]))
        chosen = second - first >= 2
        found = [few[rows[chosen]]], [np.stack([first, second], axis=-1)[chosen]]
        for row in np.flatnonzero(many).tolist():
            pairs = near_pairs(centres[row], radii[row])
            pairs = pairs[watched[row, pairs[:, 0]]]
            found[0].append(np.full(len(pairs), row))
            found[1].append(pairs)
        return np.concatenate(found[0]), np.concatenate(found[1])


def _of_pieces(curve: Curve) -> list[float]:
    """Coordinates of the ends of a curve's pieces along these, m, and 0."""
    pieces = curve.pieces if isinstance(curve, Composite) else []
    return [0.0, *(end for piece in pieces for end in (piece.begin, piece.end) if np.isfinite(end))]


def handles_in_reach(march: March, first: float, last: float, near: float) -> int:
    """Number of the foremost handles whose benches may come within `near` m of benches 0 and 1 from `first` to `last`.

    All handles on a curve that is no inward spiral. There, handle j is at most at the head's coordinate less the sum of
    the spacings between, because an arc is no shorter than its chord, and the outline of its bench is no closer to the
    centre than sqrt(r^2 - q^2) less half the width, if r is the radius at that handle and q half the spacing, or the
    overhang if that is longer. Benches 0 and 1 are no further from the centre than handle 2 ever is, and the overhang
    and the width.
    """
    dragon, curve = march.dragon, march.curve
    if not isinstance(curve, Spiral) or curve.outward or not dragon.alike:
        return dragon.handles
    ends = march.places([first, last], 3)
    if np.isnan(ends).any():
        return dragon.handles
    lows, _ = march.continuation.ranges(ends[:1], ends[1:])
    widest = float(dragon.widths.max())
    outer = curve.k * curve.angle(lows[0, 2]) + dragon.overhangs.max() + widest + near
    highest = ends[1, 0] - np.concatenate([[0.0], np.cumsum(dragon.spacings)])
    radii = curve.k * curve.angle(highest[:-1])
    halves = np.maximum(dragon.spacings / 2, dragon.overhangs)
    inner = np.sqrt(np.maximum(radii**2 - halves**2, 0.0)) - widest / 2
    # Where the path bends less than a circle with the bench as its diameter, each handle behind goes forward as well.
    needed = (inner <= outer) | (sharpest(curve, highest[:-1], highest[:-1]) * dragon.spacings >= 2)
    needed[:3] = True
    return min(int(np.flatnonzero(needed)[-1]) + 2, dragon.handles)


def near_pairs(centres: Array, radii: Array) -> Indices:
    """Pairs whose circles meet, of all benches."""
    # Nothing is further away than the chain is long, however little is known of where a bench may go.
    half = np.minimum(radii, np.ptp(centres, axis=0).sum() + 1)
    squares = (centres - centres.mean(axis=0))[:, None] + half[:, None, None] * SQUARE
    cell = float(np.clip(2 * half.max(), MIN_CELL, MAX_CELL))
    pairs = Grid(cell=cell, origin=(0.0, 0.0)).pairs(squares)
    first, second = pairs.T
    return pairs[_meet(centres[first], radii[first], centres[second], radii[second])]


def _meet(one: Array, one_radius: Array, other: Array, other_radius: Array) -> Flags:
    """Whether circles about the points `one` and `other` meet."""
    between = one - other
    meeting: Flags = np.hypot(between[..., 0], between[..., 1]) <= one_radius + other_radius
    return meeting


def _followed_rates(front_turn: Complex, rear_turn: Complex, way: Array, bend: Array, spacing: Array) -> _Rates:
    """Bounds on any path: the angles are followed from their values in the middle.

    They are supposed to change by some slack, at most. If the rates that come out of that use up less than the slack
    over the whole way, the angles never leave it.
    """
    # A bench that is pushed back has the sine and, but for the sign, the cosine of one that goes forward.
    front, rear = np.abs(np.angle(front_turn)), np.abs(np.angle(rear_turn))
    front = np.minimum(front, np.pi - front)
    lag = np.cos(front) / np.cos(rear)
    slack = 2 * way * (bend * np.maximum(1, lag) + (np.sin(front) + lag * np.sin(rear)) / spacing)
    slack = np.minimum(slack, np.pi)
    widest_front, widest_rear = np.minimum(front + slack, QUARTER), np.minimum(rear + slack, QUARTER)
    cosine = np.cos(widest_rear)
    lag = np.cos(np.maximum(front - slack, 0)) / cosine
    known = rear + slack < QUARTER
    sines = np.sin(widest_front), np.sin(widest_rear)
    rates = _rates_within(known, sines, lag, cosine, bend, spacing)
    known = rates.known & (way * (bend * np.maximum(1, lag) + rates.turn) <= slack)
    return replace(rates, known=known, lag=np.where(known, rates.lag, np.inf))


def _rates_within(
    known: Flags,
    sines: tuple[Array, Array],
    lag: Array,
    rear_cosine: Array,
    bend: Array,
    spacing: Array,
) -> _Rates:
    """Bounds from those on sines, lag and cosine: the four equations of this module with every sign the worst."""
    front_sine, rear_sine = sines
    turn = (front_sine + lag * rear_sine) / spacing
    lag_change = (bend * (front_sine + lag**2 * rear_sine) + turn**2 * spacing) / rear_cosine
    turn_change = (bend * (1 + lag**2) + lag_change * rear_sine) / spacing
    return _Rates(known, lag, lag_change, turn, turn_change)


def _products(factors: Array) -> Array:
    """Products (T, N + 1) of the first 0, 1, ... of `factors` (T, N)."""
    return np.concatenate([np.ones((len(factors), 1)), np.cumprod(factors, axis=1)], axis=1)


def _left_of(directions: Array) -> Array:
    return np.stack([-directions[:, 1], directions[:, 0]], axis=-1)


def _dot(vectors: Array, directions: Array) -> Array:
    """Products (P, K) of vectors (P, K, 2) with directions (P, 2)."""
    return vectors[..., 0] * directions[:, None, 0] + vectors[..., 1] * directions[:, None, 1]
