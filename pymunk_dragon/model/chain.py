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

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._arrays import Array, Complex, Flags, as_complex

# Newton's method needs 3 or 4 passes, and bisection, its fallback within a bracket, 53.
MAX_PASSES = 80
# Newton's method for whole chains needs 3 to 6 passes, the last one to check the result.
WHOLE_PASSES = 8
# Error of a distance, as a share of the shortest spacing, whose square, the error after the next step, is negligible.
WHOLE_ERROR = 1e-7
# Error of the distance between neighbouring handles up to which a whole chain is accepted, in last digits of the
# largest coordinate.
WHOLE_RESIDUAL = 64
# m by which two computed coordinates of one handle may differ.
SAME_HANDLE = 1e-9
# Sine of half the angle of an arc that is as long as its chord.
LEAST_SINE = 1e-9
# Handles of whole chains that are computed together: their temporaries stay in a processor's second cache.
WHOLE_HANDLES = 16384
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
    def parameter(self, s: Array) -> Array: ...
    def coordinate(self, parameter: Array) -> Array: ...
    def estimate(self, heads: Array, spacings: Array) -> Array: ...
    def motion(self, parameter: Array) -> tuple[Complex, Complex]: ...
    def nearest(self, parameters: Array, handles_s: Array, spacings: Array) -> Flags: ...
    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array: ...


class RateBounds(NamedTuple):
    """Upper bounds (...) on the absolute rates of benches by the front handle's coordinate."""

    ratio: Array
    ratio_change: Array
    omega: Array
    omega_change: Array


def angles(points: Array, tangents: Array, spacings: Array) -> tuple[Complex, Complex]:
    """e^(i alpha) and e^(i beta), each (..., N), from the handles' points and unit tangents (..., N + 1, 2)."""
    handles, directions = as_complex(points), as_complex(tangents)
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


class ChainMotion(NamedTuple):
    """Chains of H handles with T positions of the head, and their motion.

    Attributes
    ----------
    handles_s : ndarray, shape (T, H)
        Coordinates of the handles; nan for a handle that has none, and for all behind it.
    points, tangents : ndarray of complex, shape (T, H)
        Positions, and the path's unit tangents there.
    ratios : ndarray, shape (T, H)
        Velocities along the path, in units of the head's.
    """

    handles_s: Array
    points: Complex
    tangents: Complex
    ratios: Array

    def each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> ChainMotion:
        """The arrays after a change of each, such as a selection of rows."""
        return ChainMotion(*map(change, self))


def chain_motion(path: Path, handles_s: Array, spacings: Array) -> ChainMotion:
    """Motion of chains whose handles have the coordinates (T, H)."""
    points, tangents = path.frame(handles_s)
    front, rear = angles(points, tangents, spacings)
    ratios = velocity_ratios(front.real, rear.real)
    return ChainMotion(handles_s, as_complex(points), as_complex(tangents), ratios)


def whole_chains(path: Path, heads: Array, spacings: Array) -> tuple[ChainMotion, Flags]:
    """Chains with the heads at the coordinates (T,), each computed as a whole; and for which (T,) this succeeded.

    The equation of bench i, F_i = (|P_i - P_{i+1}|^2 - d_i^2) / 2 = 0, depends on the parameters of handles i and i + 1
    only. So each step of Newton's method solves a bidiagonal system: with A_i and -B_i, the derivatives of F_i by
    these two, the steps are x_0 = 0, x_{i+1} = (A_i x_i + F_i) / B_i. The products R of the ratios A / B solve it in
    closed form, x = R cumsum(F / (B R)). They are also the velocity ratios of the chain in this parameter.

    A chain is accepted where all distances are the spacings to rounding, and each handle is the nearest one back along
    the path (`Path.nearest`). Apart from rounding, the result for a head does not depend on the other heads.
    """
    handles = spacings.size + 1
    found = ChainMotion(*(np.empty((heads.size, handles), kind) for kind in (float, complex, complex, float)))
    settled = np.empty(heads.size, dtype=bool)
    rows = max(1, WHOLE_HANDLES // handles)
    with np.errstate(all="ignore"):
        for begin in range(0, heads.size, rows):
            block = slice(begin, begin + rows)
            parts, settled[block] = _whole_block(path, heads[block], spacings)
            for into, part in zip(found, parts, strict=True):
                into[block] = part
    return found, settled


def _whole_block(path: Path, heads: Array, spacings: Array) -> tuple[ChainMotion, Flags]:
    parameters = path.estimate(heads, spacings)
    settled = np.zeros(heads.shape, dtype=bool)
    for _ in range(WHOLE_PASSES):
        points, derivatives = path.motion(parameters)
        residual, ratios, behind = _bench_equations(points, derivatives, spacings)
        error = np.abs(residual / spacings).max(axis=1, initial=0)
        if settled.all():
            break
        residual /= behind
        residual /= ratios[:, 1:]
        np.cumsum(residual, axis=1, out=residual)
        residual *= ratios[:, 1:]
        residual[settled] = 0
        parameters[:, 1:] += residual
        settled |= error <= WHOLE_ERROR * spacings.min(initial=np.inf)
    handles_s = path.coordinate(parameters)
    # The inverse of `parameter` rounds; the heads keep their coordinates.
    handles_s[:, 0] = heads
    largest = np.maximum(np.abs(handles_s[:, [0, -1]]).max(axis=1), np.abs(points[:, 0]) + spacings.sum())
    # Written so that nan fails.
    settled &= error <= WHOLE_RESIDUAL * np.spacing(largest)
    settled[settled] = path.nearest(parameters[settled], handles_s[settled], spacings)
    speeds = np.abs(derivatives)
    # NumPy multiplies complex numbers several times as fast as it divides them.
    derivatives *= 1 / speeds
    ratios *= speeds
    ratios /= speeds[:, :1]
    return ChainMotion(handles_s, points, derivatives, ratios), settled


def arcs(spacings: Array, curvature: Array) -> Array:
    """Lengths (T, N) of arcs of circles with this curvature (T, N) and the spacings as chords, at most half circles."""
    sine = np.clip(curvature * (spacings / 2), LEAST_SINE, 1.0)
    lengths: Array = np.arcsin(sine)
    lengths /= sine
    lengths *= spacings
    return lengths


def _bench_equations(points: Complex, derivatives: Complex, spacings: Array) -> tuple[Array, Array, Array]:
    """F (T, N), the velocity ratios (T, N + 1) and B (T, N) of `whole_chains`."""
    benches = points[:, :-1] - points[:, 1:]
    np.conjugate(benches, out=benches)
    residual, behind = np.square(benches.real), np.square(benches.imag)
    residual += behind
    residual -= spacings**2
    residual /= 2
    ahead = (benches * derivatives[:, :-1]).real
    benches *= derivatives[:, 1:]
    return residual, velocity_ratios(ahead, benches.real), benches.real


def rear_handle(path: Path, s: Array, chord: float) -> Array:
    """Nearest coordinates (T,) back along the path from `s` (T,) at the straight distance `chord`; nan if none."""
    fronts = path.point(s)
    shortest, longest, gentle = gentle_offsets(path, s, chord)
    sharp = np.flatnonzero(~gentle)
    if sharp.size:
        shortest[sharp], longest[sharp] = _bracket(path, s[sharp], fronts[sharp], chord)
    return rear_between(path, s, fronts, chord, shortest, longest)


def nearest(path: Path, handles_s: Array, spacings: Array) -> Flags:
    """Whether each rear handle of chains (T, H) at these distances is the one that `rear_handle` finds; (T,)."""
    if not spacings.size:
        return np.ones(len(handles_s), dtype=bool)
    fronts, rears, reach = handles_s[:, :-1], handles_s[:, 1:], np.pi / 2 * spacings
    # Where the path is gentle as in `gentle_offsets`, it is the only one within reach. First with one bound on the
    # curvature for the whole chain, then with one for each bench.
    found = (fronts > rears) & (fronts - rears <= reach)
    curvature = path.max_curvature((fronts - reach).min(axis=1), fronts.max(axis=1))
    rows = np.flatnonzero(~(curvature * spacings.max() < 2))
    sharp = np.zeros(fronts.shape, dtype=bool)
    if rows.size:
        sharp[rows] = ~(path.max_curvature(fronts[rows] - reach, fronts[rows]) * spacings < 2)
    for spacing in np.unique(spacings).tolist() if sharp.any() else []:
        chosen = np.nonzero(sharp & (spacings == spacing))
        found[chosen] = np.abs(rear_handle(path, fronts[chosen], spacing) - rears[chosen]) <= SAME_HANDLE
    return np.asarray(found.all(axis=1))


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
    lost = np.isnan(low) | (low > first)
    if (at_begin := high == first).any():
        # Rounding may put a handle at the path's begin before it.
        distance = _length(fronts[at_begin] - path.point(path.begin_s))
        lost[at_begin] |= distance < chord * (1 - STEP_TOLERANCE)
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
