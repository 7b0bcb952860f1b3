"""Curves made of other curves: joined end to begin, in part, or travelled the other way."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Complex, as_complex
from pymunk_dragon._checks import instances, number
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Curve, PackageCurve, required_curve

# m that two pieces may be apart where they meet: far above rounding, far below what results need.
_MAX_GAP = 1e-9
# rad between their tangents there, as for the gap.
_MAX_KINK = 1e-9
# m before a section at which a handle still counts as on it.
_ROUNDING = 1e-10


class _Link(NamedTuple):
    """A piece, and what its coordinates and parameters are above those of the composite.

    Its parameters are from `first` to `last`.
    """

    curve: Curve
    shift: float
    parameter_shift: float
    first: float
    last: float

    def on(self, s: Array) -> Array:
        """Coordinates on the piece, clipped to it against rounding."""
        return np.clip(s + self.shift, self.curve.begin_s, self.curve.end_s)

    def at(self, parameter: Array) -> Array:
        """Parameters of the piece, clipped to it against rounding."""
        return np.clip(parameter + self.parameter_shift, self.first, self.last)


class _Joined:
    """What follows from the pieces of a composite."""

    joints: tuple[float, ...]
    _parameter_joints: tuple[float, ...]
    _links: tuple[_Link, ...]


@dataclass(frozen=True)
class Composite(_Joined, PackageCurve, kind="composite"):
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

    def __post_init__(self) -> None:
        bound = "one Curve or more"
        pieces: tuple[Curve, ...] = instances("pieces", self.pieces, Curve, bound)
        if not pieces:
            raise ParameterError("pieces", self.pieces, bound)

        first = pieces[0]
        known = filter(math.isfinite, (first.begin_s, first.end_s))
        zero = float(next(known, 0.0))
        # What lies before the begin of the whole curve is not clipped to it.
        link = _Link(first, zero, 0.0, -np.inf, _last_parameter(first))
        links = [link]
        joints = []
        parameter_joints = []
        for before, after in pairwise(pieces):
            self._check_joint(len(links), before, after)
            joint = before.end_s - link.shift
            parameter_joint = link.last - link.parameter_shift
            begin = float(after._parameter(np.array(after.begin_s)))
            shifts = after.begin_s - joint, begin - parameter_joint
            link = _Link(after, *shifts, begin, _last_parameter(after))
            joints.append(joint)
            parameter_joints.append(parameter_joint)
            links.append(link)

        self._set(pieces=pieces, joints=tuple(joints), _links=tuple(links))
        self._set(_parameter_joints=tuple(parameter_joints))
        self._set(begin_s=first.begin_s - zero, end_s=pieces[-1].end_s - link.shift)
        ends = []
        jumps = list(joints)
        for piece, shift, *_ in links:
            ends += [piece.begin_s, piece.end_s, *piece.inner_ends]
            inside = [s for s in piece.curvature_jumps if piece.begin_s < s < piece.end_s]
            jumps += [s - shift for s in inside]
        self._set(inner_ends=tuple(filter(math.isfinite, ends)))
        self._set(curvature_jumps=tuple(sorted(jumps)))

    def _check_joint(self, number: int, before: Curve, after: Curve) -> None:
        """Refuse two curves that do not meet at joint `number`, counted from 1."""
        names = f"piece {number} ({type(before).__name__})"
        names += f" and piece {number + 1} ({type(after).__name__})"
        if not (math.isfinite(before.end_s) and math.isfinite(after.begin_s)):
            bound = f"finite where they meet: {names} lie infinitely far apart"
            raise ParameterError("pieces", self.pieces, bound)

        point, ahead = map(as_complex, before.frame(before.end_s))
        other, turned = map(as_complex, after.frame(after.begin_s))
        gap = abs(other - point)
        kink = abs(np.angle(turned / ahead))
        # The comparisons are false for nan.
        if not (gap <= _MAX_GAP and kink <= _MAX_KINK):
            apart = f"{gap:.3g} m and {kink:.3g} rad ({math.degrees(kink):.3g} degrees)"
            bound = f"joined smoothly: at joint {number} {names} are {apart} apart"
            raise ParameterError("pieces", self.pieces, bound)

    def _parts(self, joints: tuple[float, ...], values: Array) -> Iterator[tuple[_Link, Any]]:
        """Pieces that end at `joints`, and indices of the values on each; the last has nan."""
        index = np.searchsorted(joints, values, side="right")
        first = int(index.min(initial=len(joints)))
        last = int(index.max(initial=0))
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
        ends = pairwise([-np.inf, *self.joints, np.inf])
        for link, (begin, end) in zip(self._links, ends, strict=True):
            shared = (lower <= end) & (upper >= begin)
            if shared.any():
                low = link.on(lower[shared])
                found = link.curve.max_curvature(low, link.on(upper[shared]))
                curvatures[shared] = np.maximum(curvatures[shared], found)
        return curvatures

    def _parameter(self, s: Array) -> Array:
        s = self._inside(s)
        parameters = np.empty(s.shape)
        for link, here in self._parts(self.joints, s):
            parameters[here] = link.curve._parameter(link.on(s[here])) - link.parameter_shift
        return parameters

    def _coordinate(self, parameter: Array) -> Array:
        s = np.empty(parameter.shape)
        for link, here in self._parts(self._parameter_joints, parameter):
            s[here] = link.curve._coordinate(link.at(parameter[here])) - link.shift
        return s

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        points, derivatives = np.empty((2, *parameter.shape), dtype=complex)
        for link, here in self._parts(self._parameter_joints, parameter):
            points[here], derivatives[here] = link.curve._motion(link.at(parameter[here]))
        return points, derivatives

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        """Estimate of the first piece, if all heads are on it."""
        if not self.joints or not (heads <= self.joints[0]).all():
            return super()._estimate(heads, parameters, spacings)
        first = self._links[0]
        parameters = parameters + first.parameter_shift
        estimate = first.curve._estimate(first.on(heads), parameters, spacings)
        return estimate - first.parameter_shift


def _last_parameter(curve: Curve) -> float:
    """Parameter at the end of a curve."""
    return float(curve._parameter(np.array(curve.end_s))) if curve.end_s < np.inf else np.inf


@dataclass(frozen=True)
class Section(PackageCurve, kind="section"):
    """Part of a curve, with the coordinates of the curve.

    Parameters
    ----------
    curve : Curve
        What it is a part of.
    begin_s : float
        Its first coordinate on the curve, m. It may be infinite if the curve's is.
    end_s : float
        Its last coordinate on the curve, m. It may be infinite if the curve's is.

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
        required_curve(self.curve)
        first, last = self.curve.begin_s, self.curve.end_s
        begin, end = number(self.begin_s), number(self.end_s)
        # The comparisons are false for nan.
        if not first <= begin < last:
            bound = f"a coordinate on the curve, from {first:g} to {last:g} m"
            raise ParameterError("begin_s", self.begin_s, bound)
        if not begin < end <= last:
            bound = f"a coordinate on the curve after {begin:g} m, at most {last:g} m"
            raise ParameterError("end_s", self.end_s, bound)
        self._set(begin_s=begin, end_s=end)
        self._set(curvature_jumps=self.curve.curvature_jumps)

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
        lost = s < self.begin_s - _ROUNDING
        return np.where(lost, np.nan, np.maximum(s, self.begin_s))

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        return self.curve._motion(parameter)

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        return self.curve._estimate(heads, parameters, spacings)


@dataclass(frozen=True)
class Reversed(PackageCurve, kind="reversed"):
    """A curve with the direction of travel reversed.

    Its coordinates are those of the curve with the opposite sign.

    Parameters
    ----------
    curve : Curve
        The path in its own direction.

    Examples
    --------
    >>> from pymunk_dragon import Line
    >>> Reversed(Line(stop=(10, 0))).tangent(-4.0).tolist()
    [-1.0, -0.0]
    """

    curve: Curve

    def __post_init__(self) -> None:
        required_curve(self.curve)
        self._set(begin_s=-self.curve.end_s, end_s=-self.curve.begin_s)
        jumps = reversed(self.curve.curvature_jumps)
        self._set(curvature_jumps=tuple(-jump for jump in jumps))

    def _frame(self, s: Array) -> tuple[Array, Array]:
        points, tangents = self.curve.frame(-s)
        return points, -tangents

    def _curvature(self, s: Array) -> Array:
        return -self.curve.curvature(-s)

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return self.curve.max_curvature(-upper, -lower)
