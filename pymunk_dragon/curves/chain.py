"""Where the handles of a chain stand on any curve, and which place on it is beside a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.curves.base import Array, Curve, frame, point, sharpest
from pymunk_dragon.curves.composite import Composite
from pymunk_dragon.curves.section import Section
from pymunk_dragon.curves.spiral import Spiral

__all__ = ["chain", "foot"]

Flags = NDArray[np.bool_]

# Newton needs 3 or 4 passes, and bisection, its fallback within a bracket, 53.
MAX_PASSES = 80
# Share of a chord: after so small a step of Newton's the next one would be below the last digit.
SETTLED = 1e-10
# A share of a chord that is no step any more: there the straight distance has its maximum.
SMALLEST_STEP = 1e-9
# Steps after which a path that bends too sharply to be followed any further has no place.
MAX_STEPS = 1_000
# Chords that are looked ahead for the sharpest bend when the growth of a distance is followed.
LOOK = 0.25
# m. So close to where a foot was supposed to be, the path leaves its tangent by a few 1e-11 m.
BESIDE = 1e-5
# Passes for a foot: each one leaves the share of the error that the distance from the path is of its radius.
FOOT_PASSES = 20


def chain(curve: Curve, s: ArrayLike, spacings: ArrayLike) -> Array:
    """Places of all handles of chains whose heads stand at `s`, each chain laid out along the path from its head.

    Each handle is at the first place back along the path whose straight distance from the handle before is the spacing,
    never at a later intersection. That distance has to grow all the way. Motion may take a chain to other states:
    `continuation.py` follows it.

    Parameters
    ----------
    curve : Curve
        What they stand on.
    s : array_like, shape (T,)
        Places of the heads, m.
    spacings : array_like, shape (N,)
        Straight distances between neighbouring handles, m.

    Returns
    -------
    ndarray, shape (T, N + 1)
        Places, m; nan for a handle that has none on the curve, and for all behind it.
    """
    if isinstance(curve, Spiral) and not curve.outward:
        return curve.chain(s, spacings)
    chords = np.asarray(spacings, dtype=float)
    places = np.full((np.size(s), chords.size + 1), np.nan)
    places[:, 0] = s
    fronts = np.array(point(curve, places[:, 0]), dtype=float)
    places[np.isnan(fronts[:, 0]), 0] = np.nan
    way_in = _WayIn(curve, places)
    for i, chord in enumerate(chords.tolist()):
        elsewhere = way_in.follow(i, chord)
        if elsewhere.size:
            places[elsewhere, i + 1], fronts[elsewhere] = _behind(curve, places[elsewhere, i], fronts[elsewhere], chord)
    way_in.place()
    return places


class _WayIn:
    """A spiral on which a curve comes in, if it does: the handles there are followed in its polar angle.

    That takes a quarter of the time, and most of a dragon in a turn is still on its way in.
    """

    def __init__(self, curve: Curve, places: Array) -> None:
        first = curve.pieces[0] if isinstance(curve, Composite) and curve.joints else None
        spiral = first.curve if isinstance(first, Section) else first
        self._spiral = spiral if isinstance(spiral, Spiral) and not spiral.outward else None
        self._places = places
        self._on = np.zeros(len(places), dtype=bool)
        if self._spiral is not None and isinstance(curve, Composite) and first is not None:
            self._begin, self._joint, self._shift = curve.begin, curve.joints[0], first.end - curve.joints[0]
            self._angles = np.full(places.shape, np.nan)

    def follow(self, i: int, chord: float) -> NDArray[np.intp]:
        """Go on from handle `i` to the next in the chains (T,) that are there; the others that go on."""
        here = self._places[:, i]
        if self._spiral is None:
            return np.flatnonzero(~np.isnan(here))
        fresh = ~self._on & (here <= self._joint)
        if fresh.any():
            self._angles[fresh, i] = self._spiral.angle(here[fresh] + self._shift)
            self._on |= fresh
        if self._on.any():
            self._angles[self._on, i + 1] = self._spiral.behind(self._angles[self._on, i], chord)
        return np.flatnonzero(~self._on & ~np.isnan(here))

    def place(self) -> None:
        """Put down the places of the handles that were followed."""
        if self._spiral is not None:
            missing = np.isnan(self._places)
            found = -self._spiral.arc(self._angles[missing]) - self._shift
            # A place at the very begin is one, rounding or not.
            self._places[missing] = np.where(found < self._begin - SETTLED, np.nan, np.maximum(found, self._begin))


def foot(curve: Curve, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
    """The place beside each of some points, near places that are known.

    Parameters
    ----------
    curve : Curve
        What the points lie close to.
    points : array_like, shape (..., 2)
        m.
    near : array_like, shape (...)
        Places from which to look, m: the foot is the one that lies nearest along the path.

    Returns
    -------
    places : ndarray, shape (...)
        m.
    feet, tangents : ndarray, shape (..., 2)
        The path's points there, and its directions.
    """
    if isinstance(curve, Spiral):
        return curve.foot(points, near)
    xy = np.asarray(points, dtype=float)
    places = np.clip(np.array(near, dtype=float), curve.begin, curve.end)
    for _ in range(FOOT_PASSES):
        feet, tangents = frame(curve, places)
        step = np.clip(places + _dot(xy - feet, tangents), curve.begin, curve.end) - places
        places += step
        if np.all(np.abs(step) <= BESIDE):
            break
    return places, feet + step[..., None] * tangents, tangents


def gentle_ways(curve: Curve, s: Array, chord: float) -> tuple[Array, Array, Flags]:
    """Ways back, each (T,), between which the distance from `s` comes to `chord`, where the path is gentle (T,).

    On a path that bends no more than a circle with the chord as its diameter, the distance grows until the way is that
    circle's half, and the way to the place is no longer than along the circle's arc.
    """
    sine = sharpest(curve, s - np.pi / 2 * chord, s) * chord / 2
    gentle = sine < 1
    # At least one last digit, so that a straight line has its place in it.
    longest = np.where(gentle, np.arcsin(np.where(gentle, sine, 0.0)) / np.where(sine > 0, sine, 1.0), 1.0)
    longest = np.where(sine > 0, longest, 1.0) * chord * (1 + SETTLED)
    return np.full(s.shape, chord * (1 - SETTLED)), longest, gentle


def _behind(curve: Curve, s: Array, fronts: Array, chord: float) -> tuple[Array, Array]:
    """Nearest places (T,) back along the curve from `s`, at distance `chord` from `fronts`, and their points."""
    shortest, longest, gentle = gentle_ways(curve, s, chord)
    sharp = np.flatnonzero(~gentle & ~np.isnan(s))
    if sharp.size:
        shortest[sharp], longest[sharp] = _bracket(curve, s[sharp], fronts[sharp], chord)
    return reached(curve, s, fronts, chord, shortest, longest)


def reached(curve: Curve, s: Array, fronts: Array, chord: float, low: Array, high: Array) -> tuple[Array, Array]:
    """Places (T,) back from `s` where the distance from `fronts` becomes `chord`, by Newton, and the points there.

    They are sought between the ways `low` and `high`, within which the distance grows; nan before the curve's begin.
    """
    first = s - curve.begin
    high = np.minimum(high, first)
    begins = point(curve, np.full(s.shape, curve.begin)) if np.isfinite(curve.begin) else fronts
    # A place at the very begin is one, rounding or not.
    lost = np.isnan(low) | (low > first) | ((high == first) & (_distance(fronts, begins) < chord * (1 - SETTLED)))
    low, high = np.where(lost, np.nan, low), np.where(lost, np.nan, high)
    way = high.copy()
    for _ in range(MAX_PASSES):
        place = np.maximum(s - way, curve.begin)
        points, tangents = frame(curve, place)
        between = fronts - points
        distance = np.hypot(between[..., 0], between[..., 1])
        short = distance < chord
        low, high = np.where(short, way, low), np.where(short, high, way)
        with np.errstate(divide="ignore", invalid="ignore"):
            better = way + (chord - distance) * distance / _dot(between, tangents)
        better = np.where((better >= low) & (better <= high), better, (low + high) / 2)
        step = np.abs(better - way)
        way = better
        if not np.any(step > SETTLED * chord):
            break
    place = np.maximum(s - way, curve.begin)
    return place, point(curve, place)


def _bracket(curve: Curve, s: Array, fronts: Array, chord: float) -> tuple[Array, Array]:
    """Ways back, each (T,), between which the distance from `fronts` comes to `chord`, growing all the way from `s` on.

    With the way h the growth g of half the square of the distance d changes by at least 1 - K (d + h) per metre, where
    the path bends by K at most. So it is safe to go on by h as long as g + h (1 - K (d + h)) is not negative.
    """
    before, way = np.zeros(s.shape), np.zeros(s.shape)
    distance, growth = np.zeros(s.shape), np.zeros(s.shape)
    rows, looks = np.arange(s.size), np.full(s.shape, LOOK * chord)
    for _ in range(MAX_STEPS):
        at, look = way[rows], looks[rows]
        bend = np.maximum(sharpest(curve, s[rows] - at, s[rows] - at - look), SMALLEST_STEP / chord)
        slope = 1 - bend * distance[rows]
        # The positive root, without cancellation.
        total = np.abs(slope) + np.sqrt(slope**2 + 4 * bend * growth[rows])
        step = np.minimum(np.where(slope > 0, total / (2 * bend), 2 * growth[rows] / total), look)
        before[rows], way[rows] = at, at + step
        # Where steps are short, a bound on what bends much further ahead would only shorten them.
        looks[rows] = np.minimum(4 * step, LOOK * chord)
        points, tangents = frame(curve, s[rows] - way[rows])
        between = fronts[rows] - points
        distance[rows], growth[rows] = np.hypot(between[..., 0], between[..., 1]), _dot(between, tangents)
        beyond = np.isnan(distance[rows]) | (distance[rows] >= chord)
        stuck = ~beyond & (step < SMALLEST_STEP * chord)
        before[rows[stuck]] = np.nan
        rows = rows[~(beyond | stuck)]
        if not rows.size:
            break
    before[rows] = np.nan
    return before, way


def _distance(points: Array, others: Array) -> Array:
    distance: Array = np.hypot(points[..., 0] - others[..., 0], points[..., 1] - others[..., 1])
    return distance


def _dot(vectors: Array, directions: Array) -> Array:
    product: Array = vectors[..., 0] * directions[..., 0] + vectors[..., 1] * directions[..., 1]
    return product
