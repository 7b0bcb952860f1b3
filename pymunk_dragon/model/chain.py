"""Equations of a rigid chain whose handles are on a path, without units.

A bench of spacing d has its front handle at the arc-length coordinate s of a path P and its rear handle at r < s, with
|P(s) - P(r)| = d. Let alpha and beta be the angles from the bench to the path's tangent T at its front and rear handle,
and kappa_f and kappa_r the curvatures there. Then, with e = P(s) - P(r), e . T(s) = d cos alpha and
e . T(r) = d cos beta, and the rigid bench has

- velocity ratio:  dr/ds = rho = cos alpha / cos beta,
- angular rate:    dphi/ds = omega = (sin alpha - rho sin beta) / d,
- and so           drho/ds = (rho^2 kappa_r sin beta - kappa_f sin alpha + omega^2 d) / cos beta,
                   domega/ds = (kappa_f cos alpha - rho^2 kappa_r cos beta - drho/ds sin beta) / d.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, Flags

# Newton's method needs 3 or 4 passes, and bisection, its fallback within a bracket, 53.
MAX_PASSES = 80
# Share of a chord: after a Newton step as small as this, the next one is below the last digit.
STEP_TOLERANCE = 1e-10
# Share of a chord. Shorter steps mean that the straight distance has its maximum.
SMALLEST_STEP = 1e-9
# Steps after which the search on a strongly curved path ends without a result.
MAX_STEPS = 1_000
# Chords over which the largest curvature ahead is taken when the growth of a distance is followed.
LOOKAHEAD = 0.25
# So close to the estimate of a foot, the path differs from its tangent by a few 1e-11 of the radius of curvature.
NEAR_FOOT = 1e-5
# Passes for a foot: each leaves a share of the error, the distance from the path over its radius of curvature.
FOOT_PASSES = 20


class Path(Protocol):
    """Interface of a path that this module uses; `Curve` implements it."""

    # As in `Curve`; this module does not depend on it.
    # ruff: noqa: D102
    @property
    def begin_s(self) -> float: ...
    @property
    def end_s(self) -> float: ...
    def point(self, s: ArrayLike) -> Array: ...
    def frame(self, s: ArrayLike) -> tuple[Array, Array]: ...
    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array: ...


class RateBounds(NamedTuple):
    """Upper bounds (...) on the absolute rates of benches by the front handle's coordinate."""

    ratio: Array
    ratio_change: Array
    omega: Array
    omega_change: Array


def angles(points: Array, tangents: Array, spacings: Array) -> tuple[Complex, Complex]:
    """e^(i alpha) and e^(i beta), each (..., N), from the handles' points and unit tangents (..., N + 1, 2)."""
    handles, directions = (array.view(complex)[..., 0] for array in (points, tangents))
    heading = ((handles[..., :-1] - handles[..., 1:]) / spacings).conj()
    return directions[..., :-1] * heading, directions[..., 1:] * heading


def velocity_ratios(front: Array, rear: Array) -> Array:
    """Velocities (..., N + 1) of all handles along the path, in units of the first one's.

    Parameters
    ----------
    front, rear : ndarray, shape (..., N)
        cos alpha and cos beta of each bench, or both of them times any factor.

    Returns
    -------
    ndarray, shape (..., N + 1)
        Negative for a handle that a jackknifed bench pushes back.

    Examples
    --------
    >>> velocity_ratios(np.array([0.9, 0.8]), np.array([1.0, 1.0])).tolist()
    [1.0, 0.9, 0.7200000000000001]
    """
    ratios = np.ones((*front.shape[:-1], front.shape[-1] + 1))
    np.cumprod(front / rear, axis=-1, out=ratios[..., 1:])
    return ratios


def log_velocity_ratios(front: Array, rear: Array) -> Array:
    """Logarithms (..., N + 1) of `velocity_ratios`, summed, so that no product overflows; all cosines are positive."""
    logs = np.zeros((*front.shape[:-1], front.shape[-1] + 1))
    np.cumsum(np.log(front) - np.log(rear), axis=-1, out=logs[..., 1:])
    return logs


def angular_rates(front: Complex, rear: Complex, spacings: Array) -> Array:
    """Angular rates omega (..., N) by the front handle's coordinate, from e^(i alpha) and e^(i beta)."""
    rates: Array = (front.imag - front.real / rear.real * rear.imag) / spacings
    return rates


def rate_bounds(
    sines: tuple[Array, Array], ratio: Array, cosine: Array, curvature: Array, spacing: Array
) -> RateBounds:
    """Bounds by the equations of this module, with the worst signs.

    Parameters
    ----------
    sines : tuple of ndarray, shape (...)
        Upper bounds on |sin alpha| and |sin beta|.
    ratio, curvature : ndarray, shape (...)
        Upper bounds on |rho| and on the absolute curvature at both handles.
    cosine : ndarray, shape (...)
        Lower bound on cos beta.
    spacing : ndarray, shape (...)
        Spacings of the benches.
    """
    front, rear = sines
    omega = (front + ratio * rear) / spacing
    ratio_change = (curvature * (front + ratio**2 * rear) + omega**2 * spacing) / cosine
    omega_change = (curvature * (1 + ratio**2) + ratio_change * rear) / spacing
    return RateBounds(ratio, ratio_change, omega, omega_change)


def rear_handle(path: Path, s: Array, chord: float) -> Array:
    """Nearest coordinates (T,) back along the path from `s` (T,) at the straight distance `chord`; nan if none."""
    fronts = path.point(s)
    shortest, longest, gentle = gentle_offsets(path, s, chord)
    sharp = np.flatnonzero(~gentle)
    if sharp.size:
        shortest[sharp], longest[sharp] = _bracket(path, s[sharp], fronts[sharp], chord)
    return rear_between(path, s, fronts, chord, shortest, longest)


def gentle_offsets(path: Path, s: Array, chord: float) -> tuple[Array, Array, Flags]:
    """Offsets back from `s` (T,) that bracket the handle behind, and whether the path is gentle there (T,).

    Where the path is no more curved than a circle with the chord as its diameter, the straight distance grows over half
    that circle's circumference, and the arc to the handle is no longer than the circle's arc.
    """
    sine = path.max_curvature(s - np.pi / 2 * chord, s) * chord / 2
    gentle = sine < 1
    # Longer by at least one last digit, so that the bracket on a straight line is not empty.
    longest = np.where(gentle, np.arcsin(np.where(gentle, sine, 0.0)) / np.where(sine > 0, sine, 1.0), 1.0)
    longest = np.where(sine > 0, longest, 1.0) * chord * (1 + STEP_TOLERANCE)
    return np.full(s.shape, chord * (1 - STEP_TOLERANCE)), longest, gentle


def rear_between(path: Path, s: Array, fronts: Array, chord: float, low: Array, high: Array) -> Array:
    """Coordinates (T,) back from `s` at which the distance from the points `fronts` is `chord`.

    Newton's method, bracketed by the offsets `low` and `high`, between which the distance grows; nan before the path's
    begin.
    """
    first = s - path.begin_s
    high = np.minimum(high, first)
    begins = path.point(np.full(s.shape, path.begin_s)) if np.isfinite(path.begin_s) else fronts
    # Rounding may put a handle at the path's begin before it.
    lost = np.isnan(low) | (low > first) | ((high == first) & (_length(fronts - begins) < chord * (1 - STEP_TOLERANCE)))
    low, high = np.where(lost, np.nan, low), np.where(lost, np.nan, high)
    offset = high.copy()
    for _ in range(MAX_PASSES):
        points, tangents = path.frame(np.maximum(s - offset, path.begin_s))
        between = fronts - points
        distance = _length(between)
        short = distance < chord
        low, high = np.where(short, offset, low), np.where(short, high, offset)
        with np.errstate(divide="ignore", invalid="ignore"):
            better = offset + (chord - distance) * distance / _dot(between, tangents)
        better = np.where((better >= low) & (better <= high), better, (low + high) / 2)
        step = np.abs(better - offset)
        offset = better
        if not np.any(step > STEP_TOLERANCE * chord):
            break
    return np.maximum(s - offset, path.begin_s)


def _bracket(path: Path, s: Array, fronts: Array, chord: float) -> tuple[Array, Array]:
    """Offsets back from `s`, each (T,), that bracket the first point at distance `chord`, growing from `s` on.

    Let d be the distance at the offset h, and g the derivative of d^2 / 2. The derivative of g is at least
    1 - K (d + h) where the curvature is at most K. So a step of h is safe while g + h (1 - K (d + h)) is not negative.
    """
    before, offset = np.zeros(s.shape), np.zeros(s.shape)
    distance, growth = np.zeros(s.shape), np.zeros(s.shape)
    rows, ahead = np.arange(s.size), np.full(s.shape, LOOKAHEAD * chord)
    for _ in range(MAX_STEPS):
        here, reach = offset[rows], ahead[rows]
        curvature = path.max_curvature(s[rows] - here, s[rows] - here - reach)
        curvature = np.maximum(curvature, SMALLEST_STEP / chord)
        slope = 1 - curvature * distance[rows]
        # The positive root, without cancellation.
        total = np.abs(slope) + np.sqrt(slope**2 + 4 * curvature * growth[rows])
        step = np.minimum(np.where(slope > 0, total / (2 * curvature), 2 * growth[rows] / total), reach)
        before[rows], offset[rows] = here, here + step
        # Where steps are short, the curvature much further ahead does not matter.
        ahead[rows] = np.minimum(4 * step, LOOKAHEAD * chord)
        points, tangents = path.frame(s[rows] - offset[rows])
        between = fronts[rows] - points
        distance[rows], growth[rows] = _length(between), _dot(between, tangents)
        beyond = np.isnan(distance[rows]) | (distance[rows] >= chord)
        stuck = ~beyond & (step < SMALLEST_STEP * chord)
        before[rows[stuck]] = np.nan
        rows = rows[~(beyond | stuck)]
        if not rows.size:
            break
    before[rows] = np.nan
    return before, offset


def foot(path: Path, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
    """Coordinates (...), points and tangents (..., 2) of the feet of `points` (..., 2) nearest to `near` (...)."""
    xy = np.asarray(points, dtype=float)
    s = np.clip(np.array(near, dtype=float), path.begin_s, path.end_s)
    for _ in range(FOOT_PASSES):
        feet, tangents = path.frame(s)
        step = np.clip(s + _dot(xy - feet, tangents), path.begin_s, path.end_s) - s
        s += step
        if np.all(np.abs(step) <= NEAR_FOOT):
            break
    return s, feet + step[..., None] * tangents, tangents


def _length(vectors: Array) -> Array:
    length: Array = np.hypot(vectors[..., 0], vectors[..., 1])
    return length


def _dot(vectors: Array, directions: Array) -> Array:
    product: Array = vectors[..., 0] * directions[..., 0] + vectors[..., 1] * directions[..., 1]
    return product
