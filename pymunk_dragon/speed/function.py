"""A speed as a function of time, integrated once by fits and looked up from then on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebint, chebval, chebvander
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.checks import answer
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.speed.base import MAX_SPEED, MIN_SPEED, Array, largest_between

__all__ = ["SpeedFunction"]

# Seconds between the edges of two blocks; each is fitted by itself, whatever was asked before, and halved as often as
# it takes. Of the first fit's points no two are further apart than 0.13 s: what is shorter can be overlooked.
BLOCK = 2.0
DEGREE = 24
# A piece is good enough when its last coefficients, over its length, are below this share of the speed's way in its
# block: the ways of all pieces of a block are good to a few units in the last place of the block's way then.
LAST, GOOD = 4, 1e-14
# Seconds. A kink disappears in a piece of a microsecond; what still is there in a nanosecond is a jump.
MIN_PIECE = 1e-9
# Pieces of one length in a block that no fit is good enough for: a kink is in one or two of them. Where there are more,
# the speed varies within 2 ms nearly everywhere, as noise does and an oscillation of 1 kHz.
MAX_ROUGH = 1000
# Seconds, more than a day: within it, fitting takes half a minute at most.
MAX_TIME = 1e5
# Cells of a piece that have a bound on the speed of their own.
CELLS = 32
# A bracket of Newton's method is halved where a step leaves it, so that this many steps always end it.
MAX_STEPS = 60
# Half lengths of a piece. The error after a step is about the step's square: nothing is left of it after this one.
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
    the way since the piece's begin in m; `bounds` (P, CELLS) on the speed in m/s.
    """

    edges: Array
    speeds: Array
    gone: Array
    bounds: Array

    @cached_property
    def ways(self) -> Array:
        """Ways (P + 1,) in m at the edges, one of which is time 0."""
        steps = np.asarray(chebval(1.0, self.gone))
        # Added up from time 0 outwards, so that it does not matter in which order the blocks came.
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
        When it is asked: where the function is no number from 1e-6 to 20 m/s, jumps, or is too rough; for times
        further than 100,000 s from 0, and for ways that it does not get through till then.

    Notes
    -----
    Ways are integrals of piecewise Chebyshev fits, good to about 1e-13 of themselves. The fits are made block after
    block as they are needed, and are the same in whatever order that happens. What lasts for less than 0.1 s can be
    overlooked.
    """

    function: Callable[[Any], Any]
    # The fit so far: a list of one, since the dataclass is frozen.
    _fits: list[_Fit] = field(default_factory=lambda: [_NOTHING], init=False, repr=False, compare=False)

    def at(self, t: ArrayLike) -> Array:
        """As in `Speed`: the function itself."""
        t = np.asarray(t, dtype=float)
        return self._values(t.ravel()).reshape(t.shape)

    def way(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        t = np.asarray(t, dtype=float)
        flat = np.where(np.isfinite(t), t, 0.0).ravel()
        fit = self._fitted(flat)
        piece = _piece(fit.edges, flat)
        begin, end = fit.edges[piece], fit.edges[piece + 1]
        ways = fit.ways[piece] + chebval(2 * (flat - begin) / (end - begin) - 1, fit.gone[:, piece], tensor=False)
        return np.where(np.isfinite(t), ways.reshape(t.shape), t)

    def time(self, way: ArrayLike) -> Array:
        """As in `Speed`: Newton's method within a bracket, to the last places."""
        way = np.asarray(way, dtype=float)
        flat = np.where(np.isfinite(way), way, 0.0).ravel()
        fit = self._covering(flat)
        piece = _piece(fit.ways, flat)
        begin, half = fit.edges[piece], (fit.edges[piece + 1] - fit.edges[piece]) / 2
        gone, speeds = fit.gone[:, piece], fit.speeds[:, piece]
        target = np.clip(flat - fit.ways[piece], 0.0, chebval(np.ones(flat.size), gone, tensor=False))
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
        return np.where(np.isfinite(way), (begin + half * (1 + x)).reshape(way.shape), way)

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """As in `Speed`: of the fits, from a bound on their second derivative."""
        t0, t1 = np.broadcast_arrays(np.asarray(t0, dtype=float), np.asarray(t1, dtype=float))
        fit = self._fitted(np.concatenate([t0.ravel(), t1.ravel()]))
        first, last = _cell(fit.edges, t0.ravel()), _cell(fit.edges, t1.ravel()) + 1
        return largest_between(fit.bounds.ravel(), first, last).reshape(t0.shape)

    def _covering(self, ways: Array) -> _Fit:
        """The fit, long enough for the times at which all `ways` have been gone."""
        fit = self._fitted(np.zeros(1))
        for sign in (-1.0, 1.0):
            farthest = float((sign * ways).max(initial=0.0))
            while (there := sign * fit.ways[-1 if sign > 0 else 0]) < farthest:
                edge = sign * fit.edges[-1 if sign > 0 else 0]
                if edge >= MAX_TIME:
                    bound = f"within the {there:g} m that the speed gets through in {MAX_TIME:g} s"
                    raise ParameterError("way", sign * farthest, bound)
                # As far as the fastest could get, and never a block that is not needed.
                ahead = max((farthest - there) / MAX_SPEED, BLOCK / 2)
                fit = self._fitted(np.array([sign * min(edge + ahead, MAX_TIME)]))
        return fit

    def _fitted(self, times: Array) -> _Fit:
        """The fit, long enough for `times` (T,) in s."""
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
        """The function at `times` (T,) in s, all at once or, where it does not take arrays, one by one."""
        with np.errstate(all="ignore"):
            try:
                values = np.asarray(self.function(times))
                if values.shape == times.shape:
                    return answer("speed(t)", values, times.shape)
            except (TypeError, ValueError):
                pass
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
    # Between two points a curve is above its chord by no more than `sag`; nor is it above the sum of all its waves.
    bounds = np.maximum(values[:, :-1], values[:, 1:]) + sag[:, None]
    bounds = np.minimum(bounds, (speeds[:, 0] + np.abs(speeds[:, 1:]).sum(axis=1))[:, None])
    bounds += LAST * np.abs(speeds[:, -LAST:]).max(axis=1)[:, None]
    return _Fit(edges, speeds.T, gone, bounds)


def _joined(fits: list[_Fit]) -> _Fit:
    """One fit of `fits` that follow one another."""
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
