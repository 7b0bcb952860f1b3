"""Speed profile given by a function of time, integrated once with piecewise polynomial fits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebint, chebval, chebvander
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._checks import answer
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.speed.base import MAX_SPEED, MIN_SPEED, Array, largest_between

__all__ = ["SpeedFunction"]

# s. Length of a block; each is fitted independently of the others, and halved as often as needed. The points of the
# first fit are at most 0.13 s apart: shorter features can be missed.
BLOCK = 2.0
DEGREE = 24
# Number of last coefficients of a piece that decide whether its fit is good enough.
LAST = 4
# Their largest share, integrated over the piece, of the distance in the block: the distances of all pieces of a block
# are then accurate to a few last digits of the block's distance.
GOOD = 1e-14
# s. A kink is negligible in a piece of a microsecond; a difference that remains within a nanosecond is a jump.
MIN_PIECE = 1e-9
# Pieces of one length in a block without a good fit: a kink affects one or two of them. If there are more, the speed
# varies within 2 ms nearly everywhere, like noise or an oscillation of 1 kHz.
MAX_ROUGH = 1000
# s, more than a day: fitting takes at most half a minute.
MAX_TIME = 1e5
# Cells of a piece, each with its own bound on the speed.
CELLS = 32
# Newton's method halves its bracket where a step leaves it, so it always ends within this number of steps.
MAX_STEPS = 60
# Half lengths of a piece. The error after a step is about the step's square, here below the last digit.
LAST_STEP = 1e-9

_ANGLES = np.pi * np.arange(DEGREE + 1) / DEGREE
_NODES = -np.cos(_ANGLES)
_HALVED = np.where(np.isin(np.arange(DEGREE + 1), (0, DEGREE)), 0.5, 1.0)
# From values at the nodes to coefficients: a discrete cosine transform.
_COEFFICIENTS = 2 / DEGREE * np.outer(_HALVED * (-1.0) ** np.arange(DEGREE + 1), _HALVED)
_COEFFICIENTS *= np.cos(np.outer(np.arange(DEGREE + 1), _ANGLES))
_AT_CELLS = chebvander(np.linspace(-1, 1, CELLS + 1), DEGREE)


@dataclass(frozen=True, eq=False)
class _Fit:
    """P pieces in the order of time, from one edge of blocks to another.

    `edges` (P + 1,) in s; `speeds` (DEGREE + 1, P) and `gone` (DEGREE + 2, P): coefficients of the speed in m/s and of
    the distance since the piece's beginning in m; `bounds` (P, CELLS) on the speed in m/s.
    """

    edges: Array
    speeds: Array
    gone: Array
    bounds: Array

    @cached_property
    def distances(self) -> Array:
        """Distances (P + 1,) in m at the edges, one of which is time 0."""
        steps = np.asarray(chebval(1.0, self.gone))
        # Summed from time 0 outwards, so that the result does not depend on the order of the blocks.
        zero = int(np.searchsorted(self.edges, 0.0))
        return np.concatenate([-np.cumsum(steps[:zero][::-1])[::-1], [0.0], np.cumsum(steps[zero:])])


_NOTHING = _Fit(np.zeros(1), np.empty((DEGREE + 1, 0)), np.empty((DEGREE + 2, 0)), np.empty((0, CELLS)))


@dataclass(frozen=True)
class SpeedFunction:
    """The speed of handle 0 as a function of time.

    Parameters
    ----------
    function : callable
        From times in s, an array or one number, to speeds in m/s. It may have kinks, but no jumps.

    Raises
    ------
    ParameterError
        When a method is called: if the function is not a number from 1e-6 to 20 m/s somewhere, jumps, or is too rough;
        for times beyond 100,000 s from 0, and for distances that are not reached by then.

    Notes
    -----
    Distances are integrals of piecewise Chebyshev fits, with a relative error of about 1e-13. The fits are made block
    by block when needed; the result does not depend on the order. Features shorter than 0.1 s can be missed.
    """

    function: Callable[[Any], Any]
    # The fit so far: a list of one, since the dataclass is frozen.
    _fits: list[_Fit] = field(default_factory=lambda: [_NOTHING], init=False, repr=False, compare=False)

    def at(self, t: ArrayLike) -> Array:
        """As in `Speed`: the function itself."""
        t = np.asarray(t, dtype=float)
        return self._values(t.ravel()).reshape(t.shape)

    def distance(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        t = np.asarray(t, dtype=float)
        flat = np.where(np.isfinite(t), t, 0.0).ravel()
        fit = self._fitted(flat)
        piece = _piece(fit.edges, flat)
        begin, end = fit.edges[piece], fit.edges[piece + 1]
        distances = fit.distances[piece] + chebval(
            2 * (flat - begin) / (end - begin) - 1, fit.gone[:, piece], tensor=False
        )
        return np.where(np.isfinite(t), distances.reshape(t.shape), t)

    def time(self, distance: ArrayLike) -> Array:
        """As in `Speed`: Newton's method within a bracket, to the last digits."""
        distance = np.asarray(distance, dtype=float)
        flat = np.where(np.isfinite(distance), distance, 0.0).ravel()
        fit = self._covering(flat)
        piece = _piece(fit.distances, flat)
        begin, half = fit.edges[piece], (fit.edges[piece + 1] - fit.edges[piece]) / 2
        gone, speeds = fit.gone[:, piece], fit.speeds[:, piece]
        target = np.clip(flat - fit.distances[piece], 0.0, chebval(np.ones(flat.size), gone, tensor=False))
        low, high, x = -np.ones(flat.size), np.ones(flat.size), np.zeros(flat.size)
        for _ in range(MAX_STEPS):
            excess = chebval(x, gone, tensor=False) - target
            low, high = np.where(excess < 0, x, low), np.where(excess < 0, high, x)
            better = np.clip(x - excess / (half * chebval(x, speeds, tensor=False)), -1, 1)
            better = np.where((better < low) | (better > high), (low + high) / 2, better)
            done = np.abs(better - x) <= LAST_STEP
            x = better
            if done.all():
                break
        return np.where(np.isfinite(distance), (begin + half * (1 + x)).reshape(distance.shape), distance)

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """As in `Speed`: of the fits, from a bound on their second derivative."""
        t0, t1 = np.broadcast_arrays(np.asarray(t0, dtype=float), np.asarray(t1, dtype=float))
        fit = self._fitted(np.concatenate([t0.ravel(), t1.ravel()]))
        first, last = _cell(fit.edges, t0.ravel()), _cell(fit.edges, t1.ravel()) + 1
        return largest_between(fit.bounds.ravel(), first, last).reshape(t0.shape)

    def _covering(self, distances: Array) -> _Fit:
        """The fit, extended to the times at which all `distances` are reached."""
        fit = self._fitted(np.zeros(1))
        for sign in (-1.0, 1.0):
            farthest = float((sign * distances).max(initial=0.0))
            while (there := sign * fit.distances[-1 if sign > 0 else 0]) < farthest:
                edge = sign * fit.edges[-1 if sign > 0 else 0]
                if edge >= MAX_TIME:
                    bound = f"within the {there:g} m that are travelled in {MAX_TIME:g} s"
                    raise ParameterError("distance", sign * farthest, bound)
                # As far as the largest speed allows, so no block is computed that is not needed.
                ahead = max((farthest - there) / MAX_SPEED, BLOCK / 2)
                fit = self._fitted(np.array([sign * min(edge + ahead, MAX_TIME)]))
        return fit

    def _fitted(self, times: Array) -> _Fit:
        """The fit, extended to `times` (T,) in s."""
        fit = self._fits[0]
        if not (np.abs(times) <= MAX_TIME).all():
            wrong = times[~(np.abs(times) <= MAX_TIME)][0].item()
            raise ParameterError("time", wrong, f"a number from {-MAX_TIME:g} to {MAX_TIME:g} s for a function of time")
        first = round(fit.edges[0] / BLOCK)
        last = round(fit.edges[-1] / BLOCK)
        before = range(first - 1, int(np.floor(times.min(initial=0.0) / BLOCK)) - 1, -1)
        after = range(last, max(int(np.ceil(times.max(initial=0.0) / BLOCK)), 1))
        if before or after:
            fit = _joined([*reversed([self._block(i) for i in before]), fit, *(self._block(i) for i in after)])
            self._fits[0] = fit
        return fit

    def _block(self, number: int) -> _Fit:
        """The fit of one block."""
        begin, end, width = number * BLOCK, (number + 1) * BLOCK, BLOCK
        begins, found, speeds = np.array([begin]), [], []
        while begins.size:
            values = self._values((begins[:, None] + width / 2 * (1 + _NODES)).ravel()).reshape(begins.size, -1)
            coefficients = (_COEFFICIENTS * values[:, None]).sum(axis=2)
            rest = np.abs(coefficients[:, -LAST:]).max(axis=1) * width
            rough = rest > GOOD * BLOCK * np.abs(coefficients[:, 0])
            found.append(begins[~rough])
            speeds.append(coefficients[~rough])
            if rough.any() and width < MIN_PIECE:
                first = int(np.argmax(rough))
                jump = (float(f"{values[first, 0]:.6g}"), float(f"{values[first, -1]:.6g}"))
                name = f"speed at t = {begins[first] + width:.9g} s"
                raise ParameterError(name, jump, "one speed: the head's must not jump")
            if np.count_nonzero(rough) > MAX_ROUGH:
                name = f"speed from t = {begin:g} s to {end:g} s"
                raise ParameterError(name, self.function, f"smooth but for some kinks: it varies within {width:.1g} s")
            width /= 2
            begins = np.add.outer(begins[rough], [0.0, width]).ravel()
        edges = np.concatenate(found)
        order = np.argsort(edges)
        return _fit(np.append(edges[order], end), np.concatenate(speeds)[order])

    def _values(self, times: Array) -> Array:
        """The function at `times` (T,) in s, checked."""
        values = self._called(times)
        bad = ~((values >= MIN_SPEED) & (values <= MAX_SPEED))
        if bad.any():
            name = f"speed at t = {times[bad][0]:.9g} s"
            raise ParameterError(name, values[bad][0].item(), f"a number from {MIN_SPEED:g} to {MAX_SPEED:g} m/s")
        return values

    def _called(self, times: Array) -> Array:
        """The function at `times` (T,) in s, in one call or, if it does not take arrays, one by one."""
        with np.errstate(all="ignore"):
            try:
                values = np.asarray(self.function(times))
                if values.shape == times.shape:
                    return answer("speed(t)", values, times.shape)
            except (TypeError, ValueError):
                pass  # It takes no arrays.
            return np.array([self._called_once(time) for time in times.tolist()])

    def _called_once(self, time: float) -> float:
        name = f"speed({time:g})"
        try:
            return float(answer(name, self.function(time), ()))
        except ArithmeticError:
            return float("nan")
        except ParameterError as error:
            bound = "a number in m/s, and for an array of T times an array of shape (T,)"
            raise ParameterError(error.name, error.value, bound) from error
        except (TypeError, ValueError) as error:
            raise ParameterError(
                "speed", self.function, f"a function from s to m/s (at {time:g} s: {error})"
            ) from error


def _fit(edges: Array, speeds: Array) -> _Fit:
    """Fit of pieces between `edges` (P + 1,), from coefficients (P, DEGREE + 1) of the speed."""
    half = np.diff(edges) / 2
    gone = chebint(speeds.T, lbnd=-1) * half
    values = (_AT_CELLS * speeds[:, None]).sum(axis=2)
    sag = (2 / CELLS) ** 2 / 8 * np.abs(chebder(speeds, 2, axis=1)).sum(axis=1)
    # Between two points the curve is above its chord by at most `sag`, and nowhere above the sum of all its terms.
    bounds = np.maximum(values[:, :-1], values[:, 1:]) + sag[:, None]
    bounds = np.minimum(bounds, (speeds[:, 0] + np.abs(speeds[:, 1:]).sum(axis=1))[:, None])
    bounds += LAST * np.abs(speeds[:, -LAST:]).max(axis=1)[:, None]
    return _Fit(edges, speeds.T, gone, bounds)


def _joined(fits: list[_Fit]) -> _Fit:
    """Concatenation of consecutive `fits`."""
    return _Fit(
        np.concatenate([fits[0].edges[:1], *(fit.edges[1:] for fit in fits)]),
        np.concatenate([fit.speeds for fit in fits], axis=1),
        np.concatenate([fit.gone for fit in fits], axis=1),
        np.concatenate([fit.bounds for fit in fits]),
    )


def _piece(edges: Array, values: Array) -> NDArray[np.intp]:
    """Numbers (T,) of the pieces that `values` (T,) lie in, between `edges` (P + 1,)."""
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)


def _cell(edges: Array, times: Array) -> NDArray[np.intp]:
    """Numbers (T,) of the cells, counted over all pieces, that `times` (T,) lie in."""
    piece = _piece(edges, times)
    share = (times - edges[piece]) / (edges[piece + 1] - edges[piece])
    cell = np.clip(np.floor(share * CELLS), 0, CELLS - 1).astype(np.intp)
    cells: NDArray[np.intp] = piece * CELLS + cell
    return cells
