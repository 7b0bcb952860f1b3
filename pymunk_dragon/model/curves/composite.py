"""Curves joined end to begin."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Curve, check_curve, overlap, within

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
        [points] = self._by_piece(s, lambda piece, coordinates: [piece.point(coordinates)], (2,))
        return points

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        [tangents] = self._by_piece(s, lambda piece, coordinates: [piece.tangent(coordinates)], (2,))
        return tangents

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        points, tangents = self._by_piece(s, lambda piece, coordinates: piece.frame(coordinates), (2,), (2,))
        return points, tangents

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive to the left."""
        [curvatures] = self._by_piece(s, lambda piece, coordinates: [piece.curvature(coordinates)], ())
        return curvatures

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

    def chain(self, s: ArrayLike, spacings: ArrayLike) -> Array:
        """As `Curve.chain`, computed on the first piece in the parameter of that piece, which may be faster."""
        if not self.joints:
            return super().chain(s, spacings)
        piece, chords = self.pieces[0], np.asarray(spacings, dtype=float)
        handles_s = np.full((np.size(s), chords.size + 1), np.nan)
        handles_s[:, 0] = self.parameter(np.asarray(s, dtype=float))
        parameters, on = np.full(handles_s.shape, np.nan), np.zeros(len(handles_s), dtype=bool)
        for i, chord in enumerate(chords.tolist()):
            here = handles_s[:, i]
            fresh = ~on & (here <= self.joints[0])
            parameters[fresh, i] = piece.parameter(self._on_piece(0, here[fresh]))
            on |= fresh
            parameters[on, i + 1] = piece.behind(parameters[on, i], chord)
            rest = np.flatnonzero(~on & ~np.isnan(here))
            if rest.size:
                handles_s[rest, i + 1] = self.behind(here[rest], chord)
        missing = np.isnan(handles_s)
        handles_s[missing] = piece.coordinate(parameters[missing]) - self._shifts[0]
        return handles_s

    def _by_piece(
        self, s: ArrayLike, method: Callable[[Curve, Array], Sequence[Array]], *tails: tuple[int, ...]
    ) -> Sequence[Array]:
        """Joined results of `method` for the pieces: an array for each of `tails`, of the coordinates' shape + tail."""
        coordinates = within(s, self.begin_s, self.end_s)
        # nan is sorted behind all joints, and gives nan on the last piece.
        index = np.searchsorted(self.joints, coordinates, side="right")
        first, last = (int(index.min()), int(index.max())) if index.size else (0, 0)
        if first == last:
            return method(self.pieces[first], self._on_piece(first, coordinates))
        answers = [np.empty(coordinates.shape + tail) for tail in tails]
        for k in range(first, last + 1):
            here = index == k
            for answer, part in zip(answers, method(self.pieces[k], self._on_piece(k, coordinates[here])), strict=True):
                answer[here] = part
        return answers

    def _on_piece(self, k: int, coordinates: Array) -> Array:
        """Coordinates on piece `k`, clipped to it against rounding."""
        return np.clip(coordinates + self._shifts[k], self.pieces[k].begin_s, self.pieces[k].end_s)

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
