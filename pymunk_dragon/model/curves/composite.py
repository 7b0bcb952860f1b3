"""Curves that are made of other curves: joined end to begin, in part, or travelled the other way."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array, Complex, as_complex
from pymunk_dragon._checks import number
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Curve, PackageCurve, required_curve

__all__ = ["Composite", "Reversed", "Section"]

# m that two pieces may be apart where they meet: far above rounding, 1e-13 m, and far below what results need.
MAX_GAP = 1e-9
# rad, the same for their directions.
MAX_KINK = 1e-9
# m before a section at which a handle still counts as on it.
ROUNDING = 1e-10


class _Link(NamedTuple):
    """A piece, and how its coordinates and parameters follow from the composite's."""

    curve: Curve
    shift: float
    # So that the composite's parameter and its rate are continuous at the joints.
    scale: float
    parameter_shift: float

    def on(self, s: Array) -> Array:
        """Coordinates on the piece, clipped to it against rounding."""
        return np.clip(s + self.shift, self.curve.begin_s, self.curve.end_s)

    def parameters(self, parameters: Array) -> Array:
        """Parameters on the piece."""
        return (parameters + self.parameter_shift) / self.scale


@dataclass(frozen=True)
class Composite(PackageCurve, kind="composite"):
    """Curves joined end to begin, without gaps and kinks: they may be 1e-9 m and 1e-9 rad apart.

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
        pieces: tuple[Curve, ...] = tuple(given) if isinstance(given, Iterable) else ()
        if not pieces or not all(isinstance(piece, Curve) for piece in pieces):
            raise ParameterError("pieces", self.pieces, "one Curve or more")
        ends = pieces[0].begin_s, pieces[0].end_s
        links = [_Link(pieces[0], next((float(end) for end in ends if math.isfinite(end)), 0.0), 1.0, 0.0)]
        joints, parameter_joints = [], []
        for before, after in pairwise(pieces):
            self._check_joint(len(links), before, after)
            (end, end_rate), (begin, rate) = _parameter_at(before, before.end_s), _parameter_at(after, after.begin_s)
            joints.append(before.end_s - links[-1].shift)
            parameter_joints.append(links[-1].scale * end - links[-1].parameter_shift)
            scale = links[-1].scale * rate / end_rate
            links.append(_Link(after, after.begin_s - joints[-1], scale, scale * begin - parameter_joints[-1]))
        found = {"pieces": pieces, "joints": joints, "_parameter_joints": parameter_joints, "_links": links}
        for name, values in found.items():
            object.__setattr__(self, name, tuple(values))

    def _check_joint(self, number: int, before: Curve, after: Curve) -> None:
        """Refuse two pieces that do not meet at joint `number`, counted from 1."""
        names = f"piece {number} ({type(before).__name__}) and piece {number + 1} ({type(after).__name__})"
        if not (math.isfinite(before.end_s) and math.isfinite(after.begin_s)):
            raise ParameterError("pieces", self.pieces, f"finite where they meet: {names} lie infinitely far apart")
        (point, ahead), (other, ahead_after) = (
            map(as_complex, curve.frame(end)) for curve, end in ((before, before.end_s), (after, after.begin_s))
        )
        gap, kink = abs(other - point), abs(np.angle(ahead_after / ahead))
        # Written so that nan fails.
        if not (gap <= MAX_GAP and kink <= MAX_KINK):
            apart = f"{gap:.3g} m and {kink:.3g} rad ({math.degrees(kink):.3g} degrees)"
            raise ParameterError("pieces", self.pieces, f"joined smoothly: at joint {number} {names} are {apart} apart")

    @property
    def begin_s(self) -> float:
        """Coordinate at which the first piece begins: 0 m, or -inf."""
        return self.pieces[0].begin_s - self._links[0].shift

    @property
    def end_s(self) -> float:
        """Coordinate at which the last piece ends, m."""
        return self.pieces[-1].end_s - self._links[-1].shift

    @property
    def inner_ends(self) -> tuple[float, ...]:
        """Finite coordinates, m, at which the pieces begin or end, each by its own zero."""
        ends = (end for piece in self.pieces for end in (piece.begin_s, piece.end_s, *piece.inner_ends))
        return tuple(end for end in ends if math.isfinite(end))

    def _frame(self, s: Array) -> tuple[Array, Array]:
        points, tangents = self._joined(s, self.joints, lambda link, part: link.curve.frame(link.on(part)))
        return points, tangents

    def _curvature(self, s: Array) -> Array:
        return self._joined(s, self.joints, lambda link, part: (link.curve.curvature(link.on(part)),))[0]

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        curvatures = np.zeros(lower.shape)
        for link, (begin, end) in zip(self._links, pairwise([-np.inf, *self.joints, np.inf]), strict=True):
            shared = (lower <= end) & (upper >= begin)
            if shared.any():
                found = link.curve.max_curvature(link.on(lower[shared]), link.on(upper[shared]))
                curvatures[shared] = np.maximum(curvatures[shared], found)
        return curvatures

    def _parameter(self, s: Array) -> Array:
        def parameters(link: _Link, part: Array) -> tuple[Array]:
            return (link.scale * link.curve._parameter(link.on(part)) - link.parameter_shift,)

        return self._joined(self._on(s), self.joints, parameters)[0]

    def _coordinate(self, parameter: Array) -> Array:
        def coordinates(link: _Link, part: Array) -> tuple[Array]:
            return (link.curve._coordinate(link.parameters(part)) - link.shift,)

        return self._joined(parameter, self._parameter_joints, coordinates)[0]

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        def motion(link: _Link, part: Array) -> tuple[Complex, Complex]:
            points, derivatives = link.curve._motion(link.parameters(part))
            return points, derivatives * (1 / link.scale)

        points, derivatives = self._joined(parameter, self._parameter_joints, motion)
        return points, derivatives

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        """As the first piece does where all heads are on it."""
        if not self.joints or not (heads <= self.joints[0]).all():
            return super()._estimate(heads, parameters, spacings)
        first = self._links[0]
        estimate = first.curve._estimate(first.on(heads), first.parameters(parameters), spacings)
        return first.scale * estimate - first.parameter_shift

    def _joined(
        self, values: Array, joints: tuple[float, ...], method: Callable[[_Link, Array], tuple[NDArray[Any], ...]]
    ) -> tuple[NDArray[Any], ...]:
        """Joined results of `method` for each piece and the values (...) on it, which end at the `joints`."""
        # nan is sorted behind all joints, and gives nan on the last piece.
        index = np.searchsorted(joints, values, side="right")
        first, last = (int(index.min()), int(index.max())) if index.size else (0, 0)
        if first == last:
            return method(self._links[first], values)
        places = [np.flatnonzero(index == k) for k in range(first, last + 1)]
        parts = [method(link, values.take(place)) for link, place in zip(self._links[first:], places, strict=False)]
        results = tuple(np.empty((values.size, *part.shape[1:]), part.dtype) for part in parts[0])
        for place, found in zip(places, parts, strict=True):
            for result, part in zip(results, found, strict=True):
                result[place] = part
        return tuple(result.reshape(values.shape + result.shape[1:]) for result in results)


def _parameter_at(curve: Curve, s: float) -> tuple[float, float]:
    """The parameter of a coordinate, and metres per unit of the parameter there."""
    parameter = curve._parameter(np.array([s]))
    return float(parameter[0]), float(np.abs(curve._motion(parameter)[1][0]))


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
            raise ParameterError("begin_s", self.begin_s, f"a coordinate on the curve, from {first:g} to {last:g} m")
        if not begin < end <= last:
            bound = f"a coordinate on the curve after {begin:g} m, at most {last:g} m"
            raise ParameterError("end_s", self.end_s, bound)
        object.__setattr__(self, "begin_s", begin)
        object.__setattr__(self, "end_s", end)

    def _frame(self, s: Array) -> tuple[Array, Array]:
        return self.curve.frame(s)

    def _curvature(self, s: Array) -> Array:
        return self.curve.curvature(s)

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return self.curve.max_curvature(lower, upper)

    def _parameter(self, s: Array) -> Array:
        return self.curve._parameter(self._on(s))

    def _coordinate(self, parameter: Array) -> Array:
        s = self.curve._coordinate(parameter)
        # Rounding may put a handle at the beginning before it.
        return np.where(s < self.begin_s - ROUNDING, np.nan, np.maximum(s, self.begin_s))

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        return self.curve._estimate(heads, parameters, spacings)

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        return self.curve._motion(parameter)

    def _behind(self, parameter: Array, chord: float) -> Array:
        return self.curve._behind(parameter, chord)


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

    @property
    def begin_s(self) -> float:
        """Where the curve ends, m."""
        return -self.curve.end_s

    @property
    def end_s(self) -> float:
        """Where the curve begins, m."""
        return -self.curve.begin_s

    def _frame(self, s: Array) -> tuple[Array, Array]:
        points, tangents = self.curve.frame(-s)
        return points, -tangents

    def _curvature(self, s: Array) -> Array:
        return -self.curve.curvature(-s)

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return self.curve.max_curvature(-upper, -lower)
