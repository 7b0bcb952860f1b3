"""A smooth path through points that a user gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Indices
from pymunk_dragon._extras import library
from pymunk_dragon._files import number_rows
from pymunk_dragon.errors import FileFormatError, ParameterError
from pymunk_dragon.model.curves._arguments import FARTHEST, overlap, within
from pymunk_dragon.model.curves.base import Curve

# The module of cells needs NumPy's polynomials, and is imported where such a path is used.
if TYPE_CHECKING:
    from pymunk_dragon.model.curves._cells import Cells

__all__ = ["Sampled"]


# A cubic that is the same on both sides of the second and the last but one point needs two more.
MIN_POINTS = 4
# A point for every metre of a day's march, nearly; every point costs some kB and a millisecond for a hundred of them.
MAX_POINTS = 50_000
# m. Neighbouring points closer than this count as one point given twice, without a direction between them.
MIN_CHORD = 1e-3
# Coordinates evaluated together: their temporaries fit into a processor's cache.
CHUNK = 1024
# Share of a cell: after so small a step of Newton's the next one would be below the last digit.
STEP_TOLERANCE = 1e-9
# Newton's method doubles the digits of a guess that is right to a hundredth; 3 are enough.
MAX_PASSES = 8


@dataclass(frozen=True, eq=False)
class Sampled(Curve, kind="sampled"):
    """Smooth path through points: the cubic spline by chord length, whose curvature is continuous (not-a-knot ends).

    It begins at the first point and ends at the last one; the coordinate is the arc length from the first. Two paths
    are equal if their points are.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        x and y in m, in the order of travel, N from 4 to 50 000.

    Raises
    ------
    ParameterError
        If the points are no such array of finite numbers, if one lies more than 100 km from the origin along an axis or
        less than 1 mm from the one before, or if the path through them nearly has a cusp.
    MissingExtraError
        If SciPy is not installed.

    References
    ----------
    C. de Boor, A Practical Guide to Splines, chapter IV. SciPy's `CubicSpline` solves for it.

    Examples
    --------
    >>> path = Sampled([(0, 0), (3, 1), (6, 0), (9, 1)])
    >>> path.point([0.0, path.end_s]).round(6).tolist()
    [[0.0, 0.0], [9.0, 1.0]]
    """

    points: Array
    _cells: Cells = field(init=False, repr=False)
    # Coordinates at which each cell begins and the last one ends, (C + 1,), m.
    _edges: Array = field(init=False, repr=False)
    # The bound on the curvature over 2^k cells from each on, one row for each k.
    _curvatures: list[Array] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        from pymunk_dragon.model.curves._cells import cut

        points = _checked(self.points)
        chords = np.hypot(*np.diff(points, axis=0).T)
        spline = library("scipy.interpolate").CubicSpline(np.concatenate([[0.0], np.cumsum(chords)]), points)
        # SciPy gives the highest power first, and a piece's parameter in m.
        powers = np.arange(4)[:, None, None]
        cells = cut(np.moveaxis(spline.c[::-1] * np.diff(spline.x)[:, None] ** powers, 0, 1), points)
        edges = np.concatenate([[0.0], np.cumsum(cells.lengths)])
        curvatures = [cells.curvatures]
        while 2 ** len(curvatures) <= cells.curvatures.size:
            half = 2 ** (len(curvatures) - 1)
            curvatures.append(np.maximum(curvatures[-1][:-half], curvatures[-1][half:]))
        for name, value in (("points", points), ("_cells", cells), ("_edges", edges), ("_curvatures", curvatures)):
            object.__setattr__(self, name, value)

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Path through the points of a CSV file: x and y in m on each line, with or without one line of heads.

        Raises
        ------
        ParameterError
            If there is no such file, if it cannot be read, or if it holds too few points for `Sampled`, or too many.
        FileFormatError
            If a line is not two numbers, or they are no point for `Sampled`.
        MissingExtraError
            If SciPy is not installed.
        """
        lines, rows = number_rows(path, "curve", ("x in m", "y in m"))
        try:
            return cls(np.array(rows))
        except ParameterError as error:
            number = error.name.removeprefix("point ")
            if number.isdigit():
                raise FileFormatError(path, f"line {lines[int(number) - 1]}: {error}") from error
            raise ParameterError("curve", str(path), error.bound) from error

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return np.array_equal(self.points, other.points)

    def __hash__(self) -> int:
        return hash(self.points.tobytes())

    @property
    def begin_s(self) -> float:
        """0 m."""
        return 0.0

    @property
    def end_s(self) -> float:
        """Length, m."""
        return float(self._edges[-1])

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        return self._evaluated(s, _point, (2,))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        return self._evaluated(s, _tangent, (2,))

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        both = self._evaluated(s, _frame, (2, 2))
        return both[..., 0, :], both[..., 1, :]

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive to the left."""
        from pymunk_dragon.model.curves._cells import cubic_curvature

        return self._evaluated(s, cubic_curvature, ())

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Upper bound (...) on the absolute curvature between two coordinates, 1/m."""
        lower, upper = overlap(s, other, self.begin_s, self.end_s)
        shared = lower <= upper
        first, last = self._cell(np.where(shared, lower, 0.0)), self._cell(np.where(shared, upper, 0.0))
        # Two overlapping ranges of 2^k cells each cover all from the first to the last one.
        rows = np.frexp(last - first + 1)[1] - 1
        curvatures = np.zeros(lower.shape)
        for k in np.unique(rows[shared]).tolist():
            here = shared & (rows == k)
            curvatures[here] = np.maximum(self._curvatures[k][first[here]], self._curvatures[k][last[here] - 2**k + 1])
        return curvatures

    def _cell(self, s: Array) -> Indices:
        """Cell of each coordinate."""
        return np.clip(np.searchsorted(self._edges, s, side="right") - 1, 0, self._cells.lengths.size - 1)

    def _evaluated(self, s: ArrayLike, what: Callable[[Array, Array], Array], tail: tuple[int, ...]) -> Array:
        """`what` (n, ...) of cubics (n, 4, 2) at their w (n,), for coordinates of any shape."""
        coordinates = within(s, self.begin_s, self.end_s)
        flat = coordinates.ravel()
        answer = np.empty(flat.shape + tail)
        for start in range(0, flat.size, CHUNK):
            chunk = flat[start : start + CHUNK]
            cell = self._cell(chunk)
            cubics = self._cells.cubics[cell]
            w = _solved(cubics, chunk - self._edges[cell], self._cells.lengths[cell])
            answer[start : start + CHUNK] = what(cubics, w)
        return answer.reshape(coordinates.shape + tail)


def _solved(cubics: Array, s: Array, lengths: Array) -> Array:
    """Parameter from 0 to 1 at which each cubic (n, 4, 2), of the lengths (n,), has the arc length `s` (n,)."""
    from pymunk_dragon.model.curves._cells import speed, travelled

    share = s / lengths
    # The initial guess is the cubic with the correct values and slopes at both ends.
    first, last = lengths / speed(cubics, 0.0), lengths / speed(cubics, 1.0)
    w = share * (first + share * (3 - 2 * first - last + share * (first + last - 2)))
    for _ in range(MAX_PASSES):
        step = (travelled(cubics, w) - s) / speed(cubics, w)
        w = np.clip(w - step, 0.0, 1.0)
        if not np.any(np.abs(step) > STEP_TOLERANCE):
            break
    return w


def _point(cubics: Array, w: Array) -> Array:
    w = w[:, None]
    points: Array = cubics[:, 0] + w * (cubics[:, 1] + w * (cubics[:, 2] + w * cubics[:, 3]))
    return points


def _tangent(cubics: Array, w: Array) -> Array:
    w = w[:, None]
    velocity = cubics[:, 1] + w * (2 * cubics[:, 2] + w * (3 * cubics[:, 3]))
    tangents: Array = velocity / np.hypot(velocity[:, :1], velocity[:, 1:])
    return tangents


def _frame(cubics: Array, w: Array) -> Array:
    return np.stack([_point(cubics, w), _tangent(cubics, w)], axis=1)


def _checked(points: object) -> Array:
    """A read-only copy of `points` (N, 2), if a path can go through them."""
    try:
        array = np.array(points, dtype=float)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != 2 or not MIN_POINTS <= len(array) <= MAX_POINTS:
        raise ParameterError("points", points, f"{MIN_POINTS} to {MAX_POINTS} points, each x and y in m")
    bad = ~(np.abs(array) <= FARTHEST).all(axis=1)
    if bad.any():
        number = int(np.argmax(bad))
        bound = f"finite and at most {FARTHEST:g} m from the origin along either axis"
        raise ParameterError(f"point {number + 1}", array[number].tolist(), bound)
    close = np.hypot(*np.diff(array, axis=0).T) < MIN_CHORD
    if close.any():
        number = int(np.argmax(close)) + 1
        bound = f"at least {MIN_CHORD:g} m from the one before"
        raise ParameterError(f"point {number + 1}", array[number].tolist(), bound)
    array.flags.writeable = False
    return array
