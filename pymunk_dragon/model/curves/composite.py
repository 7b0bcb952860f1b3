"""Curves that are made of other curves: joined end to begin, in part, or travelled the other way."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Complex, as_complex
from pymunk_dragon._checks import number
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Curve, PackageCurve, required_curve

# m and rad that two pieces may be apart where they meet: far above rounding, and far below what
# results need.
_MAX_GAP = _MAX_KINK = 1e-9
# m before a section at which a handle still counts as on it.
_ROUNDING = 1e-10


class _Link(NamedTuple):
    """A piece, and what its coordinates and parameters are above those of the composite."""

    curve: Curve
    shift: float
    parameter_shift: float

    def on(self, s: Array) -> Array:
        """Coordinates on the piece, clipped to it against rounding."""
        return np.clip(s + self.shift, self.curve.begin_s, self.curve.end_s)


@dataclass(frozen=True)
class Composite(PackageCurve, kind="composite"):
    """Curves joined end to begin, without gaps and kinks: they may be 1e-9 m and 1e-9 rad apart.

    Its coordinate is 0 where the first piece begins, or where the first piece ends if it comes from
    infinity.

    Parameters
    ----------
    pieces : sequence of Curve
        In the order of travel. Only the first may come from infinity, only the last may go on for
        ever.

    Attributes
    ----------
    joints : tuple of float
        Coordinates at which a piece ends and the next one begins, m: one fewer than pieces. At a
        joint the curvature is that of the later piece.

    Examples
    --------
    >>> from pymunk_dragon import Arc, Line
    >>> round_it = Arc(centre=(0, 1), radius=1, begin_angle=-math.pi / 2, sweep=3)
    >>> path = Composite([Line(start=(-4, 0), stop=(0, 0)), round_it])
    >>> path.joints, round(path.end_s, 6)
    ((4.0,), 7.0)
    """

    pieces: tuple[Curve, ...]
    joints: tuple[float, ...] = field(init=False, repr=False, compare=False)
    _parameter_joints: tuple[float, ...] = field(init=False, repr=False, compare=False)
    _links: tuple[_Link, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        given: object = self.pieces
        pieces: tuple[Curve, ...] = tuple(given) if isinstance(given, Sequence) else ()
        if not pieces or not all(isinstance(piece, Curve) for piece in pieces):
            raise ParameterError("pieces", self.pieces, "one Curve or more")
        zero = next(
            (float(end) for end in (pieces[0].begin_s, pieces[0].end_s) if math.isfinite(end)), 0.0
        )
        links, joints, parameter_joints = [_Link(pieces[0], zero, 0.0)], [], []
        for before, after in pairwise(pieces):
            ends = (before, before.end_s), (after, after.begin_s)
            self._check_joint(len(links), *ends)
            end, begin = (float(curve._parameter(np.array(s))) for curve, s in ends)
            joints.append(before.end_s - links[-1].shift)
            parameter_joints.append(end - links[-1].parameter_shift)
            links.append(_Link(after, after.begin_s - joints[-1], begin - parameter_joints[-1]))
        self._set(
            pieces=pieces,
            joints=tuple(joints),
            _parameter_joints=tuple(parameter_joints),
            _links=tuple(links),
        )
        ends_s = [
            end for piece in pieces for end in (piece.begin_s, piece.end_s, *piece.inner_ends)
        ]
        self._set(inner_ends=tuple(filter(math.isfinite, ends_s)))
        self._set(begin_s=pieces[0].begin_s - zero, end_s=pieces[-1].end_s - links[-1].shift)

    def _check_joint(
        self, number: int, before: tuple[Curve, float], after: tuple[Curve, float]
    ) -> None:
        """Refuse two curves that do not meet at these coordinates: joint `number`, counted from 1."""
        names = f"piece {number} ({type(before[0]).__name__}) and piece {number + 1} ({type(after[0]).__name__})"
        if not (math.isfinite(before[1]) and math.isfinite(after[1])):
            raise ParameterError(
                "pieces", self.pieces, f"finite where they meet: {names} lie infinitely far apart"
            )
        (point, ahead), (other, turned) = (
            map(as_complex, curve.frame(end)) for curve, end in (before, after)
        )
        gap, kink = abs(other - point), abs(np.angle(turned / ahead))
        # Written so that nan fails.
        if not (gap <= _MAX_GAP and kink <= _MAX_KINK):
            apart = f"{gap:.3g} m and {kink:.3g} rad ({math.degrees(kink):.3g} degrees)"
            raise ParameterError(
                "pieces",
                self.pieces,
                f"joined smoothly: at joint {number} {names} are {apart} apart",
            )

    def _parts(self, joints: tuple[float, ...], values: Array) -> Iterator[tuple[_Link, Any]]:
        """Pieces that end at `joints`, each with the indices of the values (...) on it; nan is on the last one."""
        index = np.searchsorted(joints, values, side="right")
        first, last = int(index.min(initial=len(joints))), int(index.max(initial=0))
        for k in range(first, last + 1):
            yield self._links[k], ... if first == last else index == k

    def _frame(self, s: Array) -> tuple[Array, Array]:
        points, tangents = np.empty((2, *s.shape, 2))
        for link, here in self._parts(self.joints, s):
            points[here], tangents[here] = link.curve.frame(link.on(s[here]))
        return points, tangents

    def _curvature(self, s: Array) -> Array:
        curvatures = np.empty(s.shape)
        for link, here in self._parts(self.joints, s):
            curvatures[here] = link.curve.curvature(link.on(s[here]))
        return curvatures

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        curvatures = np.zeros(lower.shape)
        for link, (begin, end) in zip(
            self._links, pairwise([-np.inf, *self.joints, np.inf]), strict=True
        ):
            shared = (lower <= end) & (upper >= begin)
            if shared.any():
                found = link.curve.max_curvature(link.on(lower[shared]), link.on(upper[shared]))
                curvatures[shared] = np.maximum(curvatures[shared], found)
        return curvatures

    def _parameter(self, s: Array) -> Array:
        s, parameters = self._inside(s), np.empty(s.shape)
        for link, here in self._parts(self.joints, s):
            parameters[here] = link.curve._parameter(link.on(s[here])) - link.parameter_shift
        return parameters

    def _coordinate(self, parameter: Array) -> Array:
        s = np.empty(parameter.shape)
        for link, here in self._parts(self._parameter_joints, parameter):
            s[here] = link.curve._coordinate(parameter[here] + link.parameter_shift) - link.shift
        return s

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        points, derivatives = np.empty((2, *parameter.shape), dtype=complex)
        for link, here in self._parts(self._parameter_joints, parameter):
            points[here], derivatives[here] = link.curve._motion(
                parameter[here] + link.parameter_shift
            )
        return points, derivatives

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        """As the first piece does where all heads are on it."""
        if not self.joints or not (heads <= self.joints[0]).all():
            return super()._estimate(heads, parameters, spacings)
        first = self._links[0]
        estimate = first.curve._estimate(
            first.on(heads), parameters + first.parameter_shift, spacings
        )
        return estimate - first.parameter_shift


@dataclass(frozen=True)
class Section(PackageCurve, kind="section"):
    """Part of a curve, with the coordinates of the curve.

    Parameters
    ----------
    curve : Curve
        What it is a part of.
    begin_s, end_s : float
        Its first and last coordinate on the curve, m. They may be infinite if the curve's are.

    Examples
    --------
    >>> from pymunk_dragon import Line
    >>> Section(Line(stop=(10, 0)), 2, 6).point([1.0, 2.0]).tolist()
    [[nan, nan], [2.0, 0.0]]
    """

    curve: Curve
    begin_s: float
    end_s: float

    def __post_init__(self) -> None:
        required_curve("curve", self.curve)
        first, last = self.curve.begin_s, self.curve.end_s
        begin, end = number(self.begin_s), number(self.end_s)
        # Written so that nan fails.
        if not first <= begin < last:
            raise ParameterError(
                "begin_s", self.begin_s, f"a coordinate on the curve, from {first:g} to {last:g} m"
            )
        if not begin < end <= last:
            bound = f"a coordinate on the curve after {begin:g} m, at most {last:g} m"
            raise ParameterError("end_s", self.end_s, bound)
        self._set(begin_s=begin, end_s=end)

    def _frame(self, s: Array) -> tuple[Array, Array]:
        return self.curve.frame(s)

    def _curvature(self, s: Array) -> Array:
        return self.curve.curvature(s)

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return self.curve.max_curvature(lower, upper)

    def _parameter(self, s: Array) -> Array:
        return self.curve._parameter(self._inside(s))

    def _coordinate(self, parameter: Array) -> Array:
        s = self.curve._coordinate(parameter)
        # Rounding may put a handle at the beginning before it.
        return np.where(s < self.begin_s - _ROUNDING, np.nan, np.maximum(s, self.begin_s))

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        return self.curve._motion(parameter)

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        return self.curve._estimate(heads, parameters, spacings)


@dataclass(frozen=True)
class Reversed(PackageCurve, kind="reversed"):
    """A curve with the direction of travel reversed; its coordinates are those of the curve with the opposite sign.

    Parameters
    ----------
    curve : Curve
        The same path, travelled forward.

    Examples
    --------
    >>> from pymunk_dragon import Line
    >>> Reversed(Line(stop=(10, 0))).tangent(-4.0).tolist()
    [-1.0, -0.0]
    """

    curve: Curve

    def __post_init__(self) -> None:
        required_curve("curve", self.curve)
        self._set(begin_s=-self.curve.end_s, end_s=-self.curve.begin_s)

    def _frame(self, s: Array) -> tuple[Array, Array]:
        points, tangents = self.curve.frame(-s)
        return points, -tangents

    def _curvature(self, s: Array) -> Array:
        return -self.curve.curvature(-s)

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return self.curve.max_curvature(-upper, -lower)
