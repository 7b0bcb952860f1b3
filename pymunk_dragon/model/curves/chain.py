"""Arc-length coordinates of a chain's handles on any curve, and the foot of a point beside a curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.model.curves.base import Array, Curve, frame, max_curvature, point
from pymunk_dragon.model.curves.composite import Composite
from pymunk_dragon.model.curves.section import Section
from pymunk_dragon.model.curves.spiral import Spiral

__all__ = ["chain", "foot"]

Flags = NDArray[np.bool_]

# Newton's method needs 3 or 4 passes, and bisection, its fallback within a bracket, 53.
MAX_PASSES = 80
# Share of a chord: after a Newton step as small as this, the next one is below the last digit.
SETTLED = 1e-10
# Share of a chord. Shorter steps mean that the straight distance has its maximum.
SMALLEST_STEP = 1e-9
# Steps after which the search on a strongly curved path ends without a result.
MAX_STEPS = 1_000
# Chords over which the largest curvature ahead is taken when the growth of a distance is followed.
LOOKAHEAD = 0.25
# m. So close to the estimate of a foot, the path differs from its tangent by a few 1e-11 m.
NEAR_FOOT = 1e-5
# Passes for a foot: each leaves a share of the error, the distance from the path over its radius of curvature.
FOOT_PASSES = 20


def chain(curve: Curve, s: ArrayLike, spacings: ArrayLike) -> Array:
    """Coordinates of all handles of chains with the heads at `s`, each chain laid out along the path from its head.

    Each handle is at the first point back along the path whose straight distance from the handle before is the spacing,
    never at a later intersection. That distance has to grow over the whole arc between. Motion may take a chain to
    other states: `continuation.py` follows it.

    Parameters
    ----------
    curve : Curve
        The path.
    s : array_like, shape (T,)
        Coordinates of the heads, m.
    spacings : array_like, shape (N,)
        Straight distances between neighbouring handles, m.

    Returns
    -------
    ndarray, shape (T, N + 1)
        Coordinates, m; nan for a handle that has none on the curve, and for all behind it.
    """
    if isinstance(curve, Spiral) and not curve.outward:
        return curve.chain(s, spacings)
    chords = np.asarray(spacings, dtype=float)
    handles_s = np.full((np.size(s), chords.size + 1), np.nan)
    handles_s[:, 0] = s
    fronts = np.array(point(curve, handles_s[:, 0]), dtype=float)
    handles_s[np.isnan(fronts[:, 0]), 0] = np.nan
    inward = _InwardPiece(curve, handles_s)
    for i, chord in enumerate(chords.tolist()):
        rest = inward.advance(i, chord)
        if rest.size:
            handles_s[rest, i + 1], fronts[rest] = _behind(curve, handles_s[rest, i], fronts[rest], chord)
    inward.convert()
    return handles_s


class _InwardPiece:
    """The inward spiral with which a composite curve may begin: its handles are computed in polar angles.

    This takes a quarter of the time, and most handles of a dragon in a turn are still on that spiral.
    """

    def __init__(self, curve: Curve, handles_s: Array) -> None:
        first = curve.pieces[0] if isinstance(curve, Composite) and curve.joints else None
        spiral = first.curve if isinstance(first, Section) else first
        self._spiral = spiral if isinstance(spiral, Spiral) and not spiral.outward else None
        self._handles_s = handles_s
        self._on = np.zeros(len(handles_s), dtype=bool)
        if self._spiral is not None and isinstance(curve, Composite) and first is not None:
            self._begin, self._joint, self._shift = curve.begin_s, curve.joints[0], first.end_s - curve.joints[0]
            self._angles = np.full(handles_s.shape, np.nan)

    def advance(self, i: int, chord: float) -> NDArray[np.intp]:
        """Advance the chains (T,) on the spiral from handle `i` to the next, and return the other chains."""
        here = self._handles_s[:, i]
        if self._spiral is None:
            return np.flatnonzero(~np.isnan(here))
        fresh = ~self._on & (here <= self._joint)
        if fresh.any():
            self._angles[fresh, i] = self._spiral.angle(here[fresh] + self._shift)
            self._on |= fresh
        if self._on.any():
            self._angles[self._on, i + 1] = self._spiral.behind(self._angles[self._on, i], chord)
        return np.flatnonzero(~self._on & ~np.isnan(here))

    def convert(self) -> None:
        """Set the coordinates of the handles that were computed in polar angles."""
        if self._spiral is not None:
            missing = np.isnan(self._handles_s)
            found = -self._spiral.arc(self._angles[missing]) - self._shift
            # Rounding may put a handle at the curve's begin before it.
            self._handles_s[missing] = np.where(found < self._begin - SETTLED, np.nan, np.maximum(found, self._begin))


def foot(curve: Curve, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
    """Feet of the perpendiculars from some points to a curve, near coordinates that are known.

    Parameters
    ----------
    curve : Curve
        The path.
    points : array_like, shape (..., 2)
        Points close to the path, m.
    near : array_like, shape (...)
        Estimates of the coordinates, m: the foot is the one nearest to them along the path.

    Returns
    -------
    s : ndarray, shape (...)
        Coordinates of the feet, m.
    feet, tangents : ndarray, shape (..., 2)
        The path's points and unit tangents there.
    """
    if isinstance(curve, Spiral):
        return curve.foot(points, near)
    xy = np.asarray(points, dtype=float)
    s = np.clip(np.array(near, dtype=float), curve.begin_s, curve.end_s)
    for _ in range(FOOT_PASSES):
        feet, tangents = frame(curve, s)
        step = np.clip(s + _dot(xy - feet, tangents), curve.begin_s, curve.end_s) - s
        s += step
        if np.all(np.abs(step) <= NEAR_FOOT):
            break
    return s, feet + step[..., None] * tangents, tangents


def gentle_offsets(curve: Curve, s: Array, chord: float) -> tuple[Array, Array, Flags]:
    """Offsets back from `s` (T,) that bracket the handle behind, and whether the path is gentle there (T,).

    Where the path is no more curved than a circle with the chord as its diameter, the straight distance grows over half
    that circle's circumference, and the arc to the handle is no longer than the circle's arc.
    """
    sine = max_curvature(curve, s - np.pi / 2 * chord, s) * chord / 2
    gentle = sine < 1
    # Longer by at least one last digit, so that the bracket on a straight line is not empty.
    longest = np.where(gentle, np.arcsin(np.where(gentle, sine, 0.0)) / np.where(sine > 0, sine, 1.0), 1.0)
    longest = np.where(sine > 0, longest, 1.0) * chord * (1 + SETTLED)
    return np.full(s.shape, chord * (1 - SETTLED)), longest, gentle


def _behind(curve: Curve, s: Array, fronts: Array, chord: float) -> tuple[Array, Array]:
    """Nearest coordinates (T,) back along the curve from `s` at distance `chord` from `fronts`, and their points."""
    shortest, longest, gentle = gentle_offsets(curve, s, chord)
    sharp = np.flatnonzero(~gentle & ~np.isnan(s))
    if sharp.size:
        shortest[sharp], longest[sharp] = _bracket(curve, s[sharp], fronts[sharp], chord)
    return reached(curve, s, fronts, chord, shortest, longest)


def reached(curve: Curve, s: Array, fronts: Array, chord: float, low: Array, high: Array) -> tuple[Array, Array]:
    """Coordinates (T,) back from `s` at which the distance from `fronts` is `chord`, and the points there.

    Newton's method, bracketed by the offsets `low` and `high`, between which the distance grows; nan before the curve's
    begin.
    """
    first = s - curve.begin_s
    high = np.minimum(high, first)
    begins = point(curve, np.full(s.shape, curve.begin_s)) if np.isfinite(curve.begin_s) else fronts
    # Rounding may put a handle at the curve's begin before it.
    lost = np.isnan(low) | (low > first) | ((high == first) & (_distance(fronts, begins) < chord * (1 - SETTLED)))
    low, high = np.where(lost, np.nan, low), np.where(lost, np.nan, high)
    offset = high.copy()
    for _ in range(MAX_PASSES):
        points, tangents = frame(curve, np.maximum(s - offset, curve.begin_s))
        between = fronts - points
        distance = np.hypot(between[..., 0], between[..., 1])
        short = distance < chord
        low, high = np.where(short, offset, low), np.where(short, high, offset)
        with np.errstate(divide="ignore", invalid="ignore"):
            better = offset + (chord - distance) * distance / _dot(between, tangents)
        better = np.where((better >= low) & (better <= high), better, (low + high) / 2)
        step = np.abs(better - offset)
        offset = better
        if not np.any(step > SETTLED * chord):
            break
    rears = np.maximum(s - offset, curve.begin_s)
    return rears, point(curve, rears)


def _bracket(curve: Curve, s: Array, fronts: Array, chord: float) -> tuple[Array, Array]:
    """Offsets back from `s`, each (T,), that bracket the first point at distance `chord`, growing from `s` on.

    Let d be the distance at the offset h, and g the derivative of d^2 / 2. The derivative of g is at least
    1 - K (d + h) where the curvature is at most K. So a step of h is safe while g + h (1 - K (d + h)) is not negative.
    """
    before, offset = np.zeros(s.shape), np.zeros(s.shape)
    distance, growth = np.zeros(s.shape), np.zeros(s.shape)
    rows, ahead = np.arange(s.size), np.full(s.shape, LOOKAHEAD * chord)
    for _ in range(MAX_STEPS):
        here, reach = offset[rows], ahead[rows]
        curvature = max_curvature(curve, s[rows] - here, s[rows] - here - reach)
        curvature = np.maximum(curvature, SMALLEST_STEP / chord)
        slope = 1 - curvature * distance[rows]
        # The positive root, without cancellation.
        total = np.abs(slope) + np.sqrt(slope**2 + 4 * curvature * growth[rows])
        step = np.minimum(np.where(slope > 0, total / (2 * curvature), 2 * growth[rows] / total), reach)
        before[rows], offset[rows] = here, here + step
        # Where steps are short, the curvature much further ahead does not matter.
        ahead[rows] = np.minimum(4 * step, LOOKAHEAD * chord)
        points, tangents = frame(curve, s[rows] - offset[rows])
        between = fronts[rows] - points
        distance[rows], growth[rows] = np.hypot(between[..., 0], between[..., 1]), _dot(between, tangents)
        beyond = np.isnan(distance[rows]) | (distance[rows] >= chord)
        stuck = ~beyond & (step < SMALLEST_STEP * chord)
        before[rows[stuck]] = np.nan
        rows = rows[~(beyond | stuck)]
        if not rows.size:
            break
    before[rows] = np.nan
    return before, offset


def _distance(points: Array, others: Array) -> Array:
    distance: Array = np.hypot(points[..., 0] - others[..., 0], points[..., 1] - others[..., 1])
    return distance


def _dot(vectors: Array, directions: Array) -> Array:
    product: Array = vectors[..., 0] * directions[..., 0] + vectors[..., 1] * directions[..., 1]
    return product
