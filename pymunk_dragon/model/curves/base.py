"""The base class of curves, and the registry of their kinds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, as_complex
from pymunk_dragon._checks import finite, fitting, instance, numbers, within, word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model import chain

# m from the origin. At this distance a double still resolves 0.02 nm.
FARTHEST = 1e5
# m along a curve without end: at this coordinate a double resolves 0.1 m.
_FARTHEST_S = 1e15
# Levels of curves inside curves. A level takes up to 4 of Python's 1000 nested calls in an
# evaluation.
_MAX_DEPTH = 32
# m: from a micrometre to ten times the farthest point.
_SPACINGS = 1e-6, 10 * FARTHEST
# Sine of half the angle of an arc that is as long as its chord.
_LEAST_SINE = 1e-9
# So close to the estimate of a foot, the path differs from its tangent by a few 1e-11 of the radius
# of curvature.
_NEAR_FOOT = 1e-5
# Passes for a foot: each leaves a share of the error, the distance from the path over its radius of
# curvature.
_FOOT_PASSES = 20


class Curve(ABC):
    """A smooth path with a direction of travel, by arc length.

    For a curve of your own, derive a class that defines `begin_s`, `end_s`, `point`, `tangent`,
    `curvature` and `max_curvature`, and call `check_curve` on one of its objects: marches,
    certified first contacts and the engine rely on what it checks.
    ``class Name(Curve, kind="name")`` also registers a dataclass, so that scenario files and saved
    runs may contain it.

    A class whose curvature jumps says where, in `curvature_jumps`: exact dynamics are faster and
    more exact with it.

    A point of the path is given by its arc-length coordinate ``s`` in m, which grows in the
    direction of travel; each curve defines its zero. Coordinates may be arrays of any shape;
    results have that shape, or that shape + (2,) for points and vectors. Beyond the ends they are
    nan.

    Examples
    --------
    A rope that hangs between two posts, with its lowest point at (0, 2) m, where the curvature is
    largest:

    >>> import numpy as np
    >>> class Catenary(Curve):
    ...     begin_s, end_s = -np.inf, np.inf
    ...
    ...     def point(self, s):
    ...         return np.stack([2 * np.arcsinh(np.divide(s, 2)), np.hypot(s, 2)], axis=-1)
    ...
    ...     def tangent(self, s):
    ...         ahead = np.stack([np.full(np.shape(s), 2.0), np.asarray(s)], axis=-1)
    ...         return ahead / np.hypot(s, 2)[..., None]
    ...
    ...     def curvature(self, s):
    ...         return 2 / (np.square(s) + 4)
    ...
    ...     def max_curvature(self, s, other):
    ...         return self.curvature(np.clip(0, np.minimum(s, other), np.maximum(s, other)))
    >>> from pymunk_dragon import check_curve
    >>> check_curve(Catenary())
    >>> Catenary().point([-3.0, 0.0]).round(3).tolist()
    [[-2.39, 3.606], [0.0, 2.0]]
    """

    # Registered classes by their kinds, the names in scenario files and saved runs.
    kinds: ClassVar[dict[str, type[Any]]] = {}
    kind: ClassVar[str | None] = None
    # Turn on which a march begins by default; None on a curve whose turns are not counted.
    default_turns: ClassVar[float | None] = None
    # Parameters that are flags of the command line, and what they are.
    flags: ClassVar[Mapping[str, str]] = {}

    # Distance between neighbouring turns, m, which benches have to be narrower than; None without
    # such turns.
    turn_width: float | None = None
    # Upper bound on the distance from the origin to the normals of the path, m. It is half the rate
    # at which the squared distance of the path from the origin changes. A circle about the origin
    # has 0; where no bound is known, it is infinite. A finite one shortens searches for contacts.
    normal_offset: float = np.inf
    # Circles about the curve that pictures show: x and y of the centre, and radius, m.
    circles: tuple[tuple[float, float, float], ...] = ()
    # Finite coordinates, m, at which pieces inside this curve begin or end, by their own zero.
    inner_ends: tuple[float, ...] = ()
    # Coordinates, m, at which the curvature may jump.
    curvature_jumps: tuple[float, ...] = ()

    # First and last coordinate, m; infinite on a path without begin or end.
    begin_s: float
    end_s: float

    def __init_subclass__(cls, kind: str | None = None) -> None:
        super().__init_subclass__()
        # A dataclass with slots is a second class with the members of the first one.
        cls.kind = cls.__dict__.get("kind") if kind is None else kind
        if cls.kind is not None:
            # A class of the same name, as in a notebook's cell, is replaced.
            known = Curve.kinds.get(cls.kind, cls)
            if (known.__module__, known.__name__) != (cls.__module__, cls.__name__):
                bound = f"no other class's, but it is that of {known.__name__}"
                raise ParameterError("kind", cls.kind, bound)
            Curve.kinds[cls.kind] = cls

    @abstractmethod
    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m, right to 8 last digits of the largest coordinate.

        Coordinates in space and along the path count.
        """

    @abstractmethod
    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""

    @abstractmethod
    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive for a curve to the left."""

    @abstractmethod
    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Upper bound (...) on the absolute curvature between two coordinates in any order, 1/m.

        It is 0 beyond the ends.
        """

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        return self.point(s), self.tangent(s)

    def chain(self, s: ArrayLike, spacings: ArrayLike) -> Array:
        """Coordinates (T, N + 1), m, of chains with heads at `s` (T,) and `spacings` (N,), m.

        Each handle is at the first point back along the path whose straight distance from the
        handle before is the spacing; that distance has to grow over the whole arc between. A handle
        that has no such point is nan, as all behind it. Motion may take a chain to other states:
        `March` follows it.

        Examples
        --------
        >>> from pymunk_dragon import Line
        >>> Line(stop=(30, 40)).chain([10.0], [3.0, 2.0]).round(9).tolist()
        [[10.0, 7.0, 5.0]]
        """
        lengths = within("spacings", numbers("spacings", spacings).ravel(), *_SPACINGS, "m")
        return chain.chains(self, numbers("s", s).ravel(), lengths).handles_s

    def foot(self, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
        """Feet of the perpendiculars from `points` (..., 2), m, to the path.

        They are the feet nearest to the coordinates `near` (...), m: their coordinates (...) and
        points (..., 2), m, and the unit tangents (..., 2) there. The points have to be closer to
        the path than its radius of curvature.

        Examples
        --------
        >>> from pymunk_dragon import Line
        >>> s, feet, tangents = Line(stop=(10, 0)).foot([[4.0, 0.5]], [3.0])
        >>> s.tolist(), feet.tolist()
        ([4.0], [[4.0, 0.0]])
        """
        xy = numbers("points", points, 2)
        s = numbers("near", near)
        fitting("points and near", xy.shape[:-1], s.shape)
        # Points far from the path have no foot, but numbers without a meaning.
        with np.errstate(all="ignore"):
            return self._foot(xy, s)

    def at_turn(self, turns: float) -> float:
        """Coordinate `turns` turns from the centre, m; an error on a curve without turns."""
        bound = "absent: only a Spiral has turns, other curves have a start_s"
        raise ParameterError("turns", turns, bound)

    def turns(self, s: float) -> float | None:
        """Number of turns from the centre at `s` m; None on a curve without turns."""
        finite("s", s, -np.inf, np.inf, "m")
        return None

    def to_dict(self) -> dict[str, Any]:
        """Kind and parameters as plain values, of which `Curve.from_dict` makes an equal curve.

        The classes of the curve and of those inside it must be registered, and at most 32 levels
        may be nested.
        """
        plain: dict[str, Any] = _plain(self, "curve", 1)
        return plain

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Curve:
        """Curve of a registered kind with the given parameters.

        Parameters that are curves are mappings as well.

        Examples
        --------
        >>> Curve.from_dict({"kind": "line", "stop": [3, 4]})
        Line(start=(0.0, 0.0), stop=(3.0, 4.0))
        """
        bound = "a table with the kind of a curve and its parameters"
        instance("curve", values, Mapping, bound)
        curve: Curve = _made(values, "curve", 1)
        return curve

    # What follows are faster or closed forms that a curve may have; `check_curve` checks that they
    # agree with `point`.

    def _inside(self, s: Array) -> Array:
        """Coordinates, with nan for those off the curve."""
        begin, end = max(self.begin_s, -_FARTHEST_S), min(self.end_s, _FARTHEST_S)
        return np.where((s >= begin) & (s <= end), s, np.nan)

    def _parameter(self, s: Array) -> Array:
        """The parameter (...) in which chains are computed; nan off the curve.

        It grows in the direction of travel.
        """
        return self._inside(s)

    def _coordinate(self, parameter: Array) -> Array:
        """Coordinates (...), m, of parameters: the inverse of `_parameter`."""
        return parameter

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        """Positions and their derivatives by the parameter, each (...), as complex numbers."""
        points, tangents = self.frame(parameter)
        return as_complex(points), as_complex(tangents)

    def _foot(self, xy: Array, s: Array) -> tuple[Array, Array, Array]:
        """What `foot` returns, for points (..., 2) and coordinates (...)."""
        begin, end = self.begin_s, self.end_s
        s = np.clip(s, begin, end)
        for _ in range(_FOOT_PASSES):
            feet, tangents = self.frame(s)
            along = np.sum((xy - feet) * tangents, axis=-1)
            step = np.clip(s + along, begin, end) - s
            s = s + step
            if np.all(np.abs(step) <= _NEAR_FOOT):
                break
        return s, feet + step[..., None] * tangents, tangents

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        """Estimated parameters (H, T) of chains: heads and their parameters (T,), spacings (N, 1).

        Each arc is as long as on a circle of the path's curvature there, at most half a circle.
        """
        straight = heads - np.cumsum(spacings, axis=0)
        s = np.concatenate([heads[None], straight])
        square = self.curvature(np.clip(s, self.begin_s, self.end_s)) ** 2
        curvature = np.sqrt((square[1:] + square[:-1]) / 2)
        sine = np.clip(curvature * (spacings / 2), _LEAST_SINE, 1.0)
        arcs = np.arcsin(sine) / sine * spacings
        s[1:] = heads - np.cumsum(arcs, axis=0)
        return self._parameter(np.maximum(s, self.begin_s))


class PackageCurve(Curve):
    """Base class of the package's curves: one check of arguments, points along with tangents.

    Derived classes have `_frame` and `_curvature` for coordinates (...) that are nan off the curve,
    and `_max_curvature` for intervals (...) whose lower ends are nan if they are off the curve.
    """

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        return self.frame(s)[0]

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        return self.frame(s)[1]

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        return self._frame(self._inside(numbers("s", s)))

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive to the left."""
        return np.asarray(self._curvature(self._inside(numbers("s", s))))

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Upper bound (...) on the absolute curvature between two coordinates, 1/m."""
        one = numbers("s", s)
        two = numbers("other", other)
        fitting("s and other", one.shape, two.shape)
        lower = np.maximum(np.minimum(one, two), max(self.begin_s, -_FARTHEST_S))
        upper = np.minimum(np.maximum(one, two), min(self.end_s, _FARTHEST_S))
        on = lower <= upper
        bound = self._max_curvature(np.where(on, lower, np.nan), upper)
        return np.where(on, bound, 0.0)

    def _set(self, **values: Any) -> None:
        """Set attributes of a frozen dataclass."""
        vars(self).update(values)

    @abstractmethod
    def _frame(self, s: Array) -> tuple[Array, Array]: ...

    @abstractmethod
    def _curvature(self, s: Array) -> Array: ...

    @abstractmethod
    def _max_curvature(self, lower: Array, upper: Array) -> Array: ...


def within_reach(s: Array) -> Array:
    """`s`, if no number in it is finite and larger than those at which curves have points."""
    far = s[np.isfinite(s) & (np.abs(s) > _FARTHEST_S)]
    if far.size:
        raise ParameterError("s", far[0].item(), f"at most {_FARTHEST_S:g} m")
    return s


def required_curve(value: object) -> None:
    """Raise a ParameterError if `value` is no curve."""
    instance("curve", value, Curve, "a Curve")


def parameters_of(cls: type[Any]) -> dict[str, bool]:
    """Names of the parameters of a registered class, and whether each is required."""
    known = fields(cls) if is_dataclass(cls) else ()
    return {f.name: f.default is MISSING and f.default_factory is MISSING for f in known if f.init}


def _plain(value: Any, where: str, depth: int) -> Any:
    """A curve, or a value inside it, as plain values."""
    if isinstance(value, tuple):
        return [_plain(item, f"{where}[{i}]", depth) for i, item in enumerate(value)]
    if not isinstance(value, Curve):
        return value.tolist() if isinstance(value, np.ndarray) else value
    if depth > _MAX_DEPTH:
        bound = f"nested in at most {_MAX_DEPTH - 1} other curves"
        raise ParameterError("curve", type(value).__name__, bound)
    if value.kind is None or not is_dataclass(value):
        kinds = ", ".join(sorted(Curve.kinds))
        bound = f"a curve of a registered kind: {kinds} or one of your own"
        raise ParameterError(where, type(value).__name__, bound)

    plain = {"kind": value.kind}
    for name in parameters_of(type(value)):
        plain[name] = _plain(getattr(value, name), f"{where}.{name}", depth + 1)
    return plain


def _made(values: Any, where: str, depth: int) -> Any:
    """A curve of a mapping, or a value inside it."""
    if isinstance(values, list | tuple) and any(isinstance(item, Mapping) for item in values):
        return [_made(item, f"{where}[{i}]", depth) for i, item in enumerate(values)]
    if not isinstance(values, Mapping):
        return values
    if depth > _MAX_DEPTH:
        raise ParameterError("curve", values, f"nested in at most {_MAX_DEPTH - 1} other curves")

    given = dict(values)
    kind = word(f"{where}.kind", given.pop("kind", None), sorted(Curve.kinds))
    _check_names(kind, given, where)
    for name, value in given.items():
        given[name] = _made(value, f"{where}.{name}", depth + 1)
    try:
        return Curve.kinds[kind](**given)
    except ParameterError as error:
        raise ParameterError(f"{where}.{error.name}", error.value, error.bound) from error


def _check_names(kind: str, given: Mapping[str, Any], where: str) -> None:
    """Refuse unknown parameters of a kind, and the absence of one that has no default."""
    known = parameters_of(Curve.kinds[kind])
    for name in given:
        if name not in known:
            kinds = Curve.kinds.items()
            owners = sorted(other for other, cls in kinds if name in parameters_of(cls))
            hint = f"kinds with it: {', '.join(owners)}" if owners else f"it has {', '.join(known)}"
            bound = f"absent on a {kind} curve; {hint}"
            raise ParameterError(f"{where}.{name}", given[name], bound)

    for name, required in known.items():
        if required and name not in given:
            bound = f"given: the kind {kind} has no default for it"
            raise ParameterError(f"{where}.{name}", None, bound)


def position(name: str, value: object) -> tuple[float, float]:
    """`value` as x and y in m."""
    xy = numbers(name, value)
    if xy.shape != (2,) or not (np.abs(xy) <= FARTHEST).all():
        raise ParameterError(name, value, f"two numbers x, y from {-FARTHEST:g} to {FARTHEST:g} m")
    x, y = xy.tolist()
    return x, y
