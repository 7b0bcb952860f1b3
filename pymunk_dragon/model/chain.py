"""Equations of a rigid chain whose handles are on a path, without units.

A bench of spacing d has its front handle at the arc-length coordinate s of a path P and its rear
handle at r < s, with |P(s) - P(r)| = d. Let alpha and beta be the angles from the bench to the
path's tangent T at its front and rear handle, and kappa_f and kappa_r the curvatures there. Then,
with e = P(s) - P(r), e . T(s) = d cos alpha and e . T(r) = d cos beta, and the rigid bench has

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

# Passes of Newton's method, which needs 3 or 4, and of bisection, its fallback within a bracket,
# which needs 53.
_MAX_PASSES = 80
# Passes of Newton's method for whole chains, which need 3 to 6, the last one to check the result.
_WHOLE_PASSES = 8
# Error of a distance, as a share of the shortest spacing: its square, the error after the next
# step, is negligible.
_WHOLE_ERROR = 3e-7
# Error, as a share of the shortest spacing, up to which the derivatives of a pass serve the next.
_SAME_DERIVATIVES = 1e-3
# Error at which a whole chain is accepted, in last digits of the largest coordinate.
_WHOLE_RESIDUAL = 64
# m by which two computed coordinates of one handle may differ.
_SAME_HANDLE = 1e-9
# Benches that are computed one by one before the chain behind them is computed as a whole again.
_BLOCK = 16
# Handles of whole chains that are computed together: their temporaries stay in a processor's second
# cache.
_WHOLE_HANDLES = 14_000
# Doubles from which on NumPy takes large pages, which come up to a hundred times as fast. Once such
# a block was freed, the C library also keeps the memory of later arrays: ten players cause 1,400
# page faults in place of 45,000, which is 6 % of their time.
_LARGE_PAGES = 1 << 19
# Share of a chord: after a Newton step as small as this, the next one is below the last digit.
_STEP_TOLERANCE = 1e-10
# Share of a chord. Shorter steps mean that the straight distance has its maximum.
_SMALLEST_STEP = 1e-9
# Steps after which the search on a strongly curved path ends without a result.
_MAX_STEPS = 1_000
# Chords over which the largest curvature ahead is taken when the growth of a distance is followed.
_LOOKAHEAD = 0.25


class Path(Protocol):
    """The part of `Curve` that this module uses; `Curve` is above this module and imports it."""

    # ruff: noqa: D102  # `Curve` documents them.
    begin_s: float

    def point(self, s: ArrayLike) -> Array: ...
    def frame(self, s: ArrayLike) -> tuple[Array, Array]: ...
    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array: ...
    def _coordinate(self, parameter: Array) -> Array: ...
    def _parameter(self, s: Array) -> Array: ...
    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array: ...
    def _motion(self, parameter: Array) -> tuple[Complex, Complex]: ...


class RateBounds(NamedTuple):
    """Upper bounds (...) on the absolute rates of benches by the front handle's coordinate."""

    ratio: Array
    ratio_change: Array
    omega: Array
    omega_change: Array


def angles(points: Array, tangents: Array, spacings: Array) -> tuple[Complex, Complex]:
    """e^(i alpha) and e^(i beta), each (..., N), of points and tangents (..., N + 1, 2)."""
    handles = as_complex(points)
    directions = as_complex(tangents)
    benches = handles[..., :-1] - handles[..., 1:]
    heading = (benches / spacings).conj()
    return directions[..., :-1] * heading, directions[..., 1:] * heading


def velocity_ratios(front: Array, rear: Array) -> Array:
    """Velocities (..., N + 1) over the first handle's, from cos alpha and cos beta (..., N)."""
    *times, benches = front.shape
    ratios = np.ones((*times, benches + 1))
    np.cumprod(front / rear, axis=-1, out=ratios[..., 1:])
    return ratios


def angular_rates(front: Complex, rear: Complex, spacings: Array) -> Array:
    """Angular rates omega (..., N) by the front handle's coordinate, from both angles."""
    return (front.imag - front.real / rear.real * rear.imag) / spacings


def rate_bounds(
    sines: tuple[Array, Array], ratio: Array, cosine: Array, curvature: Array, spacing: Array
) -> RateBounds:
    """Bounds (...) by the equations of this module with the worst signs.

    `sines` are upper bounds on |sin alpha| and |sin beta|, `ratio` and `curvature` on |rho| and the
    absolute curvature at both handles, and `cosine` is a lower bound on cos beta.
    """
    front, rear = sines
    omega = (front + ratio * rear) / spacing
    ratio_change = (curvature * (front + ratio**2 * rear) + omega**2 * spacing) / cosine
    omega_change = (curvature * (1 + ratio**2) + ratio_change * rear) / spacing
    return RateBounds(ratio, ratio_change, omega, omega_change)


class ChainMotion(NamedTuple):
    """Arrays (T, H): coordinates, complex points and unit tangents, velocities over the head's.

    They are nan for a handle that has no coordinate, and for all behind it.
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


def chains(path: Path, heads: Array, spacings: Array) -> ChainMotion:
    """Chains with the heads at the coordinates (T,), as `Curve.chain` describes them.

    Each chain is computed as a whole. Where this does not succeed, as its front is where the path
    bends sharply, a block of benches is computed one by one, and then the chain behind them.
    """
    found, converged = _whole_chains(path, heads, spacings)
    if not converged.all():
        rest = ~converged
        number = int(rest.sum())
        handles_s = np.full((number, spacings.size + 1), np.nan)
        handles_s[:, : _BLOCK + 1] = _bench_by_bench(path, heads[rest], spacings[:_BLOCK])

        behind = ~np.isnan(handles_s[:, min(_BLOCK, spacings.size)])
        if spacings.size > _BLOCK and behind.any():
            fronts = handles_s[behind, _BLOCK]
            handles_s[behind, _BLOCK:] = chains(path, fronts, spacings[_BLOCK:]).handles_s

        for into, part in zip(found, chain_motion(path, handles_s, spacings), strict=True):
            into[rest] = part
    return found


def _bench_by_bench(path: Path, heads: Array, spacings: Array) -> Array:
    """Coordinates (T, H) of chains, from each handle to the next."""
    handles_s = np.full((heads.size, spacings.size + 1), np.nan)
    off = np.isnan(path._parameter(heads))
    handles_s[:, 0] = np.where(off, np.nan, heads)
    for i, spacing in enumerate(spacings.tolist()):
        on = ~np.isnan(handles_s[:, i])
        handles_s[on, i + 1] = rear_handle(path, handles_s[on, i], spacing)
    return handles_s


def _whole_chains(path: Path, heads: Array, spacings: Array) -> tuple[ChainMotion, Flags]:
    """Chains with the heads at the coordinates (T,), each computed as a whole, where that succeeds.

    The second value is for which (T,) it did.

    The equation of bench i, F_i = (|P_i - P_{i+1}|^2 - d_i^2) / 2 = 0, depends on the parameters of
    handles i and i + 1 only. So each step of Newton's method solves a bidiagonal system: with A_i
    and -B_i, the derivatives of F_i by these two, the steps are x_0 = 0, x_{i+1} = (A_i x_i + F_i)
    / B_i. The products R of the ratios A / B solve it in closed form, x = R cumsum(F / (B R)). They
    are also the velocity ratios of the chain in this parameter.

    A chain is accepted where all distances are the spacings to rounding, and each handle is the
    nearest one back along the path.
    """
    handles = spacings.size + 1
    found = _empty(heads.size, handles)
    converged = np.empty(heads.size, dtype=bool)
    parameters = path._parameter(heads)
    rows = max(1, _WHOLE_HANDLES // handles)

    with np.errstate(all="ignore"):
        for begin in range(0, heads.size, rows):
            block = slice(begin, begin + rows)
            into = found.each(lambda part: part[block].T)  # noqa: B023  # Called at once.
            converged[block] = _solve_block(path, heads[block], parameters[block], spacings, into)
        chosen = found.handles_s if converged.all() else found.handles_s[converged]
        converged[converged] = _nearest(path, chosen.T, spacings)
    return found, converged


def _empty(chains: int, handles: int) -> ChainMotion:
    """Arrays (chains, handles) of any contents."""
    size = chains * handles
    length = 6 * size if size < _WHOLE_HANDLES else max(6 * size, _LARGE_PAGES)
    memory = np.empty(length)
    handles_s, points, tangents, ratios = np.split(memory[: 6 * size], [size, 3 * size, 5 * size])
    found = ChainMotion(handles_s, points.view(complex), tangents.view(complex), ratios)
    return found.each(lambda part: part.reshape(chains, handles))


def _solve_block(
    path: Path, heads: Array, parameters: Array, spacings: Array, into: ChainMotion
) -> Flags:
    """Write chains to arrays (H, T), whose rows are contiguous; which are accepted, (T,)."""
    lengths = spacings[:, None]
    shortest = spacings.min(initial=np.inf)
    parameters = path._estimate(heads, parameters, lengths)
    converged = np.zeros(heads.shape, dtype=bool)
    # Errors where the derivatives were computed.
    known = np.full(heads.shape, np.nan)

    for _ in range(_WHOLE_PASSES):
        points, derivatives = path._motion(parameters)
        benches = (points[:-1] - points[1:]).conj()
        # 2 F.
        twice = benches.real**2 + benches.imag**2 - lengths**2
        error = np.abs(twice * (0.5 / lengths)).max(axis=0, initial=0)
        if converged.all():
            break
        if not (known <= _SAME_DERIVATIVES * shortest).all():
            ratios, behind = _ratios(benches, derivatives)
            weights = 0.5 / (behind * ratios[1:])
            known = error
        step = np.cumsum(twice * weights, axis=0) * ratios[1:]
        step[:, converged] = 0
        parameters[1:] += step
        converged |= error * known <= (_WHOLE_ERROR * shortest) ** 2

    into.handles_s[:] = path._coordinate(parameters)
    # The inverse of `_parameter` rounds; the heads keep their coordinates.
    into.handles_s[0] = heads
    along = np.abs(into.handles_s[[0, -1]]).max(axis=0)
    largest = np.maximum(along, np.abs(points[0]) + spacings.sum())
    # The comparison is false for nan.
    converged &= error <= _WHOLE_RESIDUAL * np.spacing(largest)

    ratios, _ = _ratios(benches, derivatives)
    speeds = np.abs(derivatives)
    into.points[:] = points
    # NumPy multiplies complex numbers several times as fast as it divides them.
    into.tangents[:] = derivatives * (1 / speeds)
    into.ratios[:] = ratios * (speeds / speeds[0])
    return converged


def _ratios(benches: Complex, derivatives: Complex) -> tuple[Array, Array]:
    """Velocity ratios (H, T) in the parameter, and B (N, T), of conjugate `benches` (N, T)."""
    behind = (benches * derivatives[1:]).real
    ratios = np.empty(derivatives.shape)
    ratios[0] = 1
    np.divide((benches * derivatives[:-1]).real, behind, out=ratios[1:])
    return np.cumprod(ratios, axis=0, out=ratios), behind


def rear_handle(path: Path, s: Array, chord: float) -> Array:
    """Nearest coordinates (T,) back from `s` (T,) at the straight distance `chord`; nan if none."""
    shortest, longest, gentle = gentle_offsets(path, s, chord)
    sharp = np.flatnonzero(~gentle)
    if sharp.size:
        shortest[sharp], longest[sharp] = _bracket(path, s[sharp], chord)
    return rear_between(path, s, chord, shortest, longest)


def _nearest(path: Path, handles_s: Array, spacings: Array) -> Flags:
    """Whether (T,) the rear handles of chains (H, T) are those that `rear_handle` finds."""
    fronts = handles_s[:-1]
    rears = handles_s[1:]
    reach = np.pi / 2 * spacings[:, None]
    # Where the path is gentle as in `gentle_offsets`, it is the only one within reach: with one
    # bound on the curvature for the whole chain, or with one for each bench.
    back = fronts - rears
    found = (back > 0) & (back <= reach)
    tails = handles_s[-1] - reach.max(initial=0)
    curvature = path.max_curvature(tails, handles_s[0])
    rest = np.flatnonzero(~(curvature * spacings.max(initial=0) < 2))

    if rest.size:
        sharp = np.zeros(fronts.shape, dtype=bool)
        some = fronts[:, rest]
        curvature = path.max_curvature(some - reach, some)
        sharp[:, rest] = ~(curvature * spacings[:, None] < 2)
        for spacing in sorted({*spacings.tolist()}):
            chosen = np.nonzero(sharp & (spacings[:, None] == spacing))
            nearest = rear_handle(path, fronts[chosen], spacing)
            found[chosen] = np.abs(nearest - rears[chosen]) <= _SAME_HANDLE
    return np.asarray(found.all(axis=0))


def gentle_offsets(path: Path, s: Array, chord: float) -> tuple[Array, Array, Flags]:
    """Offsets back from `s` (T,) that bracket the handle behind, and whether the path is gentle.

    Where the path is no more curved than a circle with the chord as its diameter, the straight
    distance grows over half that circle's circumference, and the arc to the handle is no longer
    than the circle's arc.
    """
    curvature = path.max_curvature(s - np.pi / 2 * chord, s)
    sine = np.maximum(curvature * chord / 2, _SMALLEST_STEP)
    # Longer by at least one last digit, so that the bracket on a straight line is not empty.
    longest = np.arcsin(np.minimum(sine, 1.0)) / sine * chord * (1 + _STEP_TOLERANCE)
    shortest = np.full(s.shape, chord * (1 - _STEP_TOLERANCE))
    return shortest, longest, sine < 1


def rear_between(
    path: Path, s: Array, chord: float, low: Array, high: Array, guess: Array | float = np.inf
) -> Array:
    """Coordinates (T,) back from `s` at the straight distance `chord`; nan before the path's begin.

    Newton's method from an offset `guess`, bracketed by the offsets `low` and `high`, between which
    the distance grows.
    """
    fronts = as_complex(path.point(s))
    first = s - path.begin_s
    high = np.minimum(high, first)
    lost = np.isnan(low) | (low > first)
    if (at_begin := high == first).any():
        # Rounding may put a handle at the path's begin before it.
        distance = np.abs(fronts[at_begin] - as_complex(path.point(path.begin_s)))
        lost[at_begin] |= distance < chord * (1 - _STEP_TOLERANCE)

    low = np.where(lost, np.nan, low)
    high = np.where(lost, np.nan, high)
    offset: Array = np.clip(guess, low, high)
    for _ in range(_MAX_PASSES):
        points, tangents = path.frame(np.maximum(s - offset, path.begin_s))
        between = fronts - as_complex(points)
        distance = np.abs(between)
        short = distance < chord
        low = np.where(short, offset, low)
        high = np.where(short, high, offset)
        with np.errstate(divide="ignore", invalid="ignore"):
            # Half the derivative of the squared distance by the offset.
            growth = (between.conj() * as_complex(tangents)).real
            better = offset + (chord - distance) * distance / growth
        # A step that leaves the bracket is replaced by bisection.
        better = np.where((better >= low) & (better <= high), better, (low + high) / 2)
        step = np.abs(better - offset)
        offset = better
        if not np.any(step > _STEP_TOLERANCE * chord):
            break
    return np.maximum(s - offset, path.begin_s)


def _bracket(path: Path, s: Array, chord: float) -> tuple[Array, Array]:
    """Offsets back from `s`, each (T,), that bracket the first point at distance `chord`.

    The distance grows from `s` to there. Let d be the distance at the offset h, and g the
    derivative of d^2 / 2. The derivative of g is at least 1 - K (d + h) where the curvature is at
    most K. So a step of h is safe while g + h (1 - K (d + h)) is not negative.
    """
    fronts = as_complex(path.point(s))
    before, offset, distance, growth = np.zeros((4, s.size))
    rows = np.arange(s.size)
    ahead = np.full(s.shape, _LOOKAHEAD * chord)

    for _ in range(_MAX_STEPS):
        here = offset[rows]
        reach = ahead[rows]
        begin = s[rows] - here
        curvature = path.max_curvature(begin, begin - reach)
        curvature = np.maximum(curvature, _SMALLEST_STEP / chord)
        slope = 1 - curvature * distance[rows]
        # The positive root, without cancellation.
        total = np.abs(slope) + np.sqrt(slope**2 + 4 * curvature * growth[rows])
        safe = np.where(slope > 0, total / (2 * curvature), 2 * growth[rows] / total)
        step = np.minimum(safe, reach)
        before[rows] = here
        offset[rows] = here + step
        # Where steps are short, the curvature much further ahead does not matter.
        ahead[rows] = np.minimum(4 * step, _LOOKAHEAD * chord)

        points, tangents = path.frame(s[rows] - offset[rows])
        between = fronts[rows] - as_complex(points)
        distance[rows] = np.abs(between)
        growth[rows] = (between.conj() * as_complex(tangents)).real
        beyond = np.isnan(distance[rows]) | (distance[rows] >= chord)
        # Where steps vanish, the distance has its maximum before it is the chord.
        stuck = ~beyond & (step < _SMALLEST_STEP * chord)
        before[rows[stuck]] = np.nan
        rows = rows[~(beyond | stuck)]
        if not rows.size:
            break
    before[rows] = np.nan
    return before, offset
