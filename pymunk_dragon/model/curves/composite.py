"""Curves joined end to begin."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._arrays import Array, Complex, as_complex, as_vectors
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves._arguments import check_curve, overlap, within
from pymunk_dragon.model.curves.base import Curve

__all__ = ["Composite"]

# m that two pieces may be apart where they meet: far above rounding, 1e-13 m, and far below what results need.
MAX_GAP = 1e-9
# rad, the same for their directions.
MAX_KINK = 1e-9


@dataclass(frozen=True)
class Composite(Curve, kind="composite"):
    """Curves joined end to begin, without gaps and kinks.

    Its coordinate is 0 where the first piece begins, or where the first piece ends if it comes from infinity.

    Parameters
    ----------
    pieces : iterable of Curve
        In the order of travel. Only the first may come from infinity, only the last may go on for ever.

    Attributes
    ----------
    joints : tuple of float
        Coordinates at which a piece ends and the next one begins, m: one fewer than pieces. At a joint the curvature is
        that of the later piece.

    Raises
    ------
    ParameterError
        If there is no piece or one is no curve, if an inner end lies at infinity, or if two pieces do not meet: they
        may be 1e-9 m and 1e-9 rad apart.

    Examples
    --------
    >>> from pymunk_dragon.model.curves import Arc, Line
    >>> round_it = Arc(centre=(0, 1), radius=1, begin_angle=-math.pi / 2, sweep=3)
    >>> path = Composite([Line(start=(-4, 0), stop=(0, 0)), round_it])
    >>> path.joints, round(path.end_s, 6)
    ((4.0,), 7.0)
    """

    pieces: tuple[Curve, ...]
    joints: tuple[float, ...] = field(init=False, repr=False, compare=False)
    # Offsets from the curve's coordinates to those of each piece.
    _shifts: tuple[float, ...] = field(init=False, repr=False, compare=False)
    # The parameter is that of the pieces, scaled and shifted so that it and its rate are continuous at the joints.
    _scales: tuple[float, ...] = field(init=False, repr=False, compare=False)
    _parameter_shifts: tuple[float, ...] = field(init=False, repr=False, compare=False)
    _parameter_joints: tuple[float, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        given: object = self.pieces
        pieces: tuple[Curve, ...] = tuple(given) if isinstance(given, Iterable) else ()
        if not pieces or not all(isinstance(piece, Curve) for piece in pieces):
            raise ParameterError("pieces", self.pieces, "one Curve or more")
        for i, piece in enumerate(pieces):
            check_curve(f"pieces[{i}]", piece)
        first = pieces[0]
        shifts = [
            next((float(coordinate) for coordinate in (first.begin_s, first.end_s) if math.isfinite(coordinate)), 0.0)
        ]
        joints: list[float] = []
        for before, after in pairwise(pieces):
            self._check_joint(len(shifts), before, after)
            joints.append(before.end_s - shifts[-1])
            shifts.append(after.begin_s - joints[-1])
        object.__setattr__(self, "pieces", pieces)
        object.__setattr__(self, "joints", tuple(joints))
        object.__setattr__(self, "_shifts", tuple(shifts))
        self._join_parameters()

    def _join_parameters(self) -> None:
        scales, shifts, joints = [1.0], [0.0], []
        for before, after in pairwise(self.pieces):
            (end, end_rate), (begin, begin_rate) = (
                _parameter_at(before, before.end_s),
                _parameter_at(after, after.begin_s),
            )
            joints.append(scales[-1] * end - shifts[-1])
            scales.append(scales[-1] * begin_rate / end_rate)
            shifts.append(scales[-1] * begin - joints[-1])
        for name, values in (("_scales", scales), ("_parameter_shifts", shifts), ("_parameter_joints", joints)):
            object.__setattr__(self, name, tuple(values))

    @property
    def begin_s(self) -> float:
        """Coordinate at which the first piece begins: 0 m, or -inf."""
        return self.pieces[0].begin_s - self._shifts[0]

    @property
    def end_s(self) -> float:
        """Coordinate at which the last piece ends, m."""
        return self.pieces[-1].end_s - self._shifts[-1]

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        return self.frame(s)[0]

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        return self.frame(s)[1]

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        points, tangents = self._by_piece(
            within(s, self.begin_s, self.end_s),
            self.joints,
            lambda k, part: [*map(as_complex, self.pieces[k].frame(self._on_piece(k, part)))],
            complex,
            complex,
        )
        return as_vectors(points), as_vectors(tangents)

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive to the left."""
        [curvatures] = self._by_piece(
            within(s, self.begin_s, self.end_s),
            self.joints,
            lambda k, part: [self.pieces[k].curvature(self._on_piece(k, part))],
            float,
        )
        return curvatures

    def parameter(self, s: Array) -> Array:
        """Parameters (...): those of the pieces, scaled and shifted."""
        [parameters] = self._by_piece(
            within(s, self.begin_s, self.end_s),
            self.joints,
            lambda k, part: [
                self._scales[k] * self.pieces[k].parameter(self._on_piece(k, part)) - self._parameter_shifts[k]
            ],
            float,
        )
        return parameters

    def coordinate(self, parameter: Array) -> Array:
        """Coordinates (...) of parameters, m."""
        [coordinates] = self._by_piece(
            parameter,
            self._parameter_joints,
            lambda k, part: [self.pieces[k].coordinate(self._of_piece(k, part)) - self._shifts[k]],
            float,
        )
        return coordinates

    def estimate(self, heads: Array, spacings: Array) -> Array:
        """Estimated parameters (T, H) of chains: as the first piece does where all of them are on it."""
        if not self.joints or not (heads <= self.joints[0]).all():
            return super().estimate(heads, spacings)
        first = self.pieces[0].estimate(self._on_piece(0, heads), spacings)
        return self._scales[0] * first - self._parameter_shifts[0]

    def motion(self, parameter: Array) -> tuple[Complex, Complex]:
        """Positions and their derivatives by the parameter, each (...), as complex numbers."""

        def motion(k: int, part: Array) -> list[Complex]:
            points, derivatives = self.pieces[k].motion(self._of_piece(k, part))
            return [points, derivatives * (1 / self._scales[k])]

        points, derivatives = self._by_piece(parameter, self._parameter_joints, motion, complex, complex)
        return points, derivatives

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Upper bound (...) on the absolute curvature between two coordinates, 1/m."""
        lower, upper = overlap(s, other, self.begin_s, self.end_s)
        curvatures = np.zeros(lower.shape)
        edges = [self.begin_s, *self.joints, self.end_s]
        for k, piece in enumerate(self.pieces):
            shared = (lower <= edges[k + 1]) & (upper >= edges[k]) & (lower <= upper)
            if shared.any():
                first, last = self._on_piece(k, lower[shared]), self._on_piece(k, upper[shared])
                curvatures[shared] = np.maximum(curvatures[shared], piece.max_curvature(first, last))
        return curvatures

    @property
    def inner_ends(self) -> tuple[float, ...]:
        """Finite coordinates, m, at which the pieces begin or end, each by its own zero."""
        ends = (end for piece in self.pieces for end in (piece.begin_s, piece.end_s, *piece.inner_ends))
        return tuple(end for end in ends if math.isfinite(end))

    def _by_piece(
        self,
        values: Array,
        joints: tuple[float, ...],
        method: Callable[[int, Array], list[NDArray[Any]]],
        *kinds: type,
    ) -> list[NDArray[Any]]:
        """Joined results of `method` for the number of each piece and the values (...) between its joints.

        They are arrays (...) of these `kinds`.
        """
        # nan is sorted behind all joints, and gives nan on the last piece.
        index = np.searchsorted(joints, values, side="right")
        first, last = (int(index.min()), int(index.max())) if index.size else (0, 0)
        if first == last:
            return method(first, values)
        answers: list[NDArray[Any]] = [np.empty(values.shape, kind) for kind in kinds]
        for k in range(first, last + 1):
            here = np.flatnonzero(index == k)
            for answer, part in zip(answers, method(k, values.take(here)), strict=True):
                answer.reshape(-1)[here] = part
        return answers

    def _on_piece(self, k: int, coordinates: Array) -> Array:
        """Coordinates on piece `k`, clipped to it against rounding."""
        return np.clip(coordinates + self._shifts[k], self.pieces[k].begin_s, self.pieces[k].end_s)

    def _of_piece(self, k: int, parameters: Array) -> Array:
        """Parameters on piece `k`."""
        return (parameters + self._parameter_shifts[k]) / self._scales[k]

    def _check_joint(self, number: int, before: Curve, after: Curve) -> None:
        """Refuse two pieces that do not meet at joint `number`, counted from 1."""
        names = f"piece {number} ({type(before).__name__}) and piece {number + 1} ({type(after).__name__})"
        if not (math.isfinite(before.end_s) and math.isfinite(after.begin_s)):
            raise ParameterError("pieces", self.pieces, f"finite where they meet: {names} lie infinitely far apart")
        (x, y), (dx, dy) = before.frame(before.end_s)
        (x_after, y_after), (dx_after, dy_after) = after.frame(after.begin_s)
        gap = math.hypot(x_after - x, y_after - y)
        kink = abs(math.atan2(dx * dy_after - dy * dx_after, dx * dx_after + dy * dy_after))
        # Written so that nan fails.
        if not (gap <= MAX_GAP and kink <= MAX_KINK):
            apart = f"{gap:.3g} m and {kink:.3g} rad ({math.degrees(kink):.3g} degrees)"
            raise ParameterError("pieces", self.pieces, f"joined smoothly: at joint {number} {names} are {apart} apart")


def _parameter_at(curve: Curve, s: float) -> tuple[float, float]:
    """The parameter of a coordinate, and metres per unit of the parameter there."""
    parameter = curve.parameter(np.array([s]))
    return float(parameter[0]), float(np.abs(curve.motion(parameter)[1][0]))
