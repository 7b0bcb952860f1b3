"""A smooth path through points.

It is a spline, cut so short that arc length and curvature are right to the last digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import comb, factorial
from pathlib import Path
from typing import Any, Self

import numpy as np

from pymunk_dragon._arrays import (
    Array,
    ArrayRecord,
    Complex,
    Indices,
    as_complex,
    as_vectors,
    read_only,
)
from pymunk_dragon._checks import numbers
from pymunk_dragon._extras import library
from pymunk_dragon._files import number_rows
from pymunk_dragon.errors import FileFormatError, ParameterError
from pymunk_dragon.model.curves.base import FARTHEST, PackageCurve

# A cubic that is the same on both sides of the second and the last but one point needs two more.
_MIN_POINTS = 4
# A point for every metre of a day's march, nearly; every point costs some kB.
_MAX_POINTS = 50_000
# m. Neighbouring points closer than this count as one point given twice.
_MIN_CHORD = 1e-3
# Share of a cell: after so small a step of Newton's method the next one is below the last digit.
_STEP_TOLERANCE = 1e-9
# Passes of Newton's method: 3 are enough.
_MAX_PASSES = 8
# Share of a cell's length. Halves that agree with the whole so well have 16 more bits than this,
# and rounding has none.
_LENGTH_TOLERANCE = 4e-15
# Share of the parametric speed along the chords. A slower path is close to a cusp.
_MIN_SPEED = 0.01
# Excess of the bound on a cell's curvature, as a share of the cell's curvature.
_LOOSE = 0.02
# Excess that is allowed beside it, as a share of the path's largest curvature.
_LOOSE_OVERALL = 0.001
# Parameters in a cell at which speed and curvature are sampled.
_SEEN = (0.0, 0.5, 1.0)
# Share of a bound that covers its rounding.
_ROUNDING = 1e-9
# Times that a cell is halved. A path that needs more has a cusp; others need fewer than ten.
_MAX_HALVINGS = 40


class _Cells:
    """What follows from the points of a path: C cells."""

    # Coefficients (C, 4) of 1, w, w^2, w^3 for w from 0 to 1, m.
    _cubics: Complex
    # Bounds on the curvatures (C,), 1/m.
    _curvatures: Array
    # Lengths, m, and coordinates at which cells begin and the last one ends, (C + 1,), m.
    _lengths: Array
    _edges: Array


@dataclass(frozen=True, eq=False)
class Sampled(ArrayRecord, _Cells, PackageCurve, kind="sampled"):
    """Smooth path through points: the cubic spline by chord length, with not-a-knot ends.

    Its curvature is continuous. It begins at the first point and ends at the last one; the
    coordinate is the arc length from the first. Two paths are equal if their points are. It needs
    SciPy.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        x and y in m, in the order of travel, N from 4 to 50 000: at least 1 mm apart, and at most
        100 km from the origin along either axis. A path that nearly has a cusp is refused.

    References
    ----------
    C. de Boor, A Practical Guide to Splines, chapter IV. SciPy's `CubicSpline` solves for it.

    Examples
    --------
    >>> path = Sampled([(0, 0), (3, 1), (6, 0), (9, 1)])
    >>> path.point([0.0, path.end_s]).round(6).tolist()
    [[0.0, 0.0], [9.0, 1.0]]
    """

    begin_s = 0.0

    points: Array

    def __post_init__(self) -> None:
        points = _checked(self.points)
        path = as_complex(points)
        knots = np.append(0.0, np.cumsum(np.abs(np.diff(path))))
        spline = library("scipy.interpolate").CubicSpline(knots, path)
        cubics, lengths, curvatures = _cut(spline, knots)
        edges = np.append(0.0, np.cumsum(lengths))
        self._set(points=points, end_s=float(edges[-1]))
        self._set(_cubics=cubics, _curvatures=curvatures, _lengths=lengths, _edges=edges)

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Path through the points of a CSV file: x and y in m on each line.

        One line of heads may stand before them.
        """
        lines, rows = number_rows(path, "curve", ("x in m", "y in m"))
        try:
            return cls(np.array(rows))
        except ParameterError as error:
            number = error.name.removeprefix("point ")
            if number.isdigit():
                raise FileFormatError(path, f"line {lines[int(number) - 1]}: {error}") from error
            raise ParameterError("curve", str(path), error.bound) from error

    def _frame(self, s: Array) -> tuple[Array, Array]:
        cubics, w = self._located(s)
        zero, one, two, three = cubics.T
        velocity = _velocity(cubics, w)
        points = zero + w * (one + w * (two + w * three))
        tangents = velocity * (1 / np.abs(velocity))
        return as_vectors(points.reshape(s.shape)), as_vectors(tangents.reshape(s.shape))

    def _curvature(self, s: Array) -> Array:
        return _curvature(*self._located(s)).reshape(s.shape)

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        last = self._cell(upper)
        first = np.minimum(self._cell(lower), last)
        ends = np.stack([first, last + 1], axis=-1).ravel()
        largest = np.maximum.reduceat(np.append(self._curvatures, 0.0), ends)
        return np.reshape(largest[::2], lower.shape)

    def _cell(self, s: Array) -> Indices:
        """Cell of each coordinate."""
        return np.searchsorted(self._edges[1:-1], s, side="right")

    def _located(self, s: Array) -> tuple[Complex, Array]:
        """Cubics (n, 4) and their w (n,) for coordinates of any shape."""
        s = s.ravel()
        cell = self._cell(s)
        cubics = self._cubics[cell]
        return cubics, _solved(cubics, s - self._edges[cell], self._lengths[cell])


def _checked(points: object) -> Array:
    """A read-only copy of `points` (N, 2), if a path can go through them."""
    array: Array = numbers("points", points).copy()
    if array.ndim != 2 or array.shape[1] != 2 or not _MIN_POINTS <= len(array) <= _MAX_POINTS:
        bound = f"{_MIN_POINTS} to {_MAX_POINTS} points, each x and y in m"
        raise ParameterError("points", points, bound)

    far = ~(np.abs(array).max(axis=1) <= FARTHEST)
    if far.any():
        i = int(far.argmax())
        bound = f"at most {FARTHEST:g} m from the origin along either axis"
        raise ParameterError(f"point {i + 1}", array[i].tolist(), bound)

    close = np.abs(np.diff(as_complex(array))) < _MIN_CHORD
    if close.any():
        i = int(close.argmax()) + 1
        bound = f"at least {_MIN_CHORD:g} m from the one before"
        raise ParameterError(f"point {i + 1}", array[i].tolist(), bound)
    return read_only(array)


def _cut(spline: Any, points: Array) -> tuple[Complex, Array, Array]:
    """Cubics, lengths and curvatures of the cells of a spline with known parameters at points."""
    knots = points
    for _ in range(_MAX_HALVINGS):
        cubics = _cubics(spline, knots)
        slowest, curvatures = _bounds(cubics)
        begins, steps = knots[:-1], np.diff(knots)
        least = _MIN_SPEED * steps
        too_slow = np.min([_speed(cubics, w) for w in _SEEN], axis=0) < least
        if too_slow.any():
            break

        seen = np.max([np.abs(_curvature(cubics, w)) for w in _SEEN], axis=0)
        lengths = _travelled(cubics, 1.0)
        middles = begins + steps / 2
        halves = _cubics(spline, np.sort([*knots, *middles]))
        by_halves = _travelled(halves, 1.0).reshape(-1, 2).sum(axis=1)
        too_slow = slowest < least
        coarse = too_slow | (np.abs(by_halves - lengths) > _LENGTH_TOLERANCE * lengths)
        # The comparison is false for nan.
        coarse |= ~(curvatures <= (1 + _LOOSE) * seen + _LOOSE_OVERALL * seen.max())
        if not coarse.any():
            return cubics, lengths, curvatures * (1 + _ROUNDING)

        knots = np.sort([*knots, *middles[coarse]])
    number = int(np.searchsorted(points, begins[np.argmax(too_slow)], side="right"))
    stop = f"from it to point {number + 1} the path nearly stops, as at a cusp"
    x, y = as_vectors(spline(points[number - 1 : number]))[0].tolist()
    raise ParameterError(f"point {number}", [x, y], f"followed by a smooth path; {stop}")


def _cubics(spline: Any, knots: Array) -> Complex:
    """Coefficients (C, 4) of a spline between C + 1 of its parameters, for w from 0 to 1."""
    steps = np.diff(knots)
    powers = [spline(knots[:-1], k) * steps**k / factorial(k) for k in range(4)]
    return np.transpose(powers)


def _bounds(cubics: Complex) -> tuple[Array, Array]:
    """Lower bounds on speeds and upper bounds on absolute curvatures of cubics, (n,) each."""
    # The velocity is one + two w + three w^2; the real part of a product is a dot, the imaginary
    # part a cross product.
    one = cubics[:, 1]
    two = 2 * cubics[:, 2]
    three = 3 * cubics[:, 3]
    a = one.conj() * two
    b = one.conj() * three
    c = two.conj() * three
    ones, twos, threes = (np.square(np.abs(each)) for each in (one, two, three))
    squares = np.stack([ones, 2 * a.real, twos + 2 * b.real, 2 * c.real, threes])
    slowest = np.sqrt(np.maximum((_bernstein(4) @ squares).min(axis=0), 0.0))

    turning = np.stack([a.imag, 2 * b.imag, c.imag])
    with np.errstate(divide="ignore", invalid="ignore"):
        return slowest, np.abs(_bernstein(2) @ turning).max(axis=0) / slowest**3


def _bernstein(degree: int) -> Array:
    """Matrix from the powers of a polynomial on [0, 1] to its Bernstein coefficients.

    All its values lie between these.
    """
    powers = range(degree + 1)
    return np.array([[comb(i, k) / comb(degree, k) for k in powers] for i in powers])


def _solved(cubics: Complex, s: Array, lengths: Array) -> Array:
    """Parameters (n,) from 0 to 1 at which cubics (n, 4) of these lengths have arc lengths `s`."""
    share = s / lengths
    # The initial guess is the cubic with the correct values and slopes at both ends.
    first = lengths / _speed(cubics, 0.0)
    last = lengths / _speed(cubics, 1.0)
    w = share * (first + share * (3 - 2 * first - last + share * (first + last - 2)))

    for _ in range(_MAX_PASSES):
        step = (_travelled(cubics, w) - s) / _speed(cubics, w)
        w = np.clip(w - step, 0.0, 1.0)
        if not np.any(np.abs(step) > _STEP_TOLERANCE):
            break
    return w


@cache
def _gauss() -> tuple[Array, Array]:
    """Eight nodes and weights of the Gauss-Legendre rule on [0, 1], which is exact to degree 15."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    return (nodes[:, None] + 1) / 2, weights[:, None] / 2


def _travelled(cubics: Complex, w: Array | float) -> Array:
    """Arc length (n,) in m of cubics (n, 4) from 0 to w (n,)."""
    nodes, weights = _gauss()
    speeds = weights * _speed(cubics, nodes * w)
    # Not NumPy's sum, whose rounding depends on n.
    return np.asarray(w * sum(speeds[1:], start=speeds[0]))


def _speed(cubics: Complex, w: Array | float) -> Array:
    """Metres per unit of w, of cubics (n, 4) at w (..., n)."""
    return np.abs(_velocity(cubics, w))


def _velocity(cubics: Complex, w: Array | float) -> Complex:
    _, one, two, three = cubics.T
    return np.asarray(one + w * (2 * two + w * (3 * three)))


def _curvature(cubics: Complex, w: Array | float) -> Array:
    """Curvature (n,) in 1/m, positive to the left, of cubics (n, 4) at w (n,)."""
    velocity = _velocity(cubics, w)
    change = 2 * cubics[:, 2] + 6 * w * cubics[:, 3]
    return np.asarray((velocity.conj() * change).imag / np.abs(velocity) ** 3)
