"""The base class of curves, and the registry of their kinds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, Flags, as_complex
from pymunk_dragon._checks import did_you_mean
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model import chain
from pymunk_dragon.model.chain import ChainMotion
from pymunk_dragon.model.curves._checked import CHECK, checked_bound, checked_method

# Benches that are computed one by one before the chain behind them is computed as a whole again.
BLOCK = 16
# Levels of curves inside curves. A level takes up to 4 of Python's 1000 nested calls in an evaluation.
MAX_DEPTH = 32
# Methods whose results are checked in classes outside the package, and the axes that they add to their argument's.
CHECKED: Mapping[str, tuple[int, ...]] = {"point": (2,), "tangent": (2,), "curvature": (), "max_curvature": ()}
# Members that depend on the points of a curve. A class outside the package that changes its points inherits the general
# ones of `Curve`.
DERIVED = (
    "frame",
    "chain",
    "chain_motion",
    "parameter",
    "coordinate",
    "estimate",
    "motion",
    "nearest",
    "behind",
    "chain_follows_motion",
    "foot",
    "inward",
)


class Curve(ABC):
    """A smooth path with a direction of travel, by arc length.

    A point of the path is given by its arc-length coordinate ``s`` in m, which grows in the direction of travel; each
    curve defines its zero. Every method is vectorised over coordinates and returns arrays of their shape, or that shape
    + (2,) for points and vectors. Beyond the ends the result is nan.

    A derived class defines `begin_s`, `end_s`, `point`, `tangent`, `curvature` and `max_curvature`; a dragon can then
    march on it. ``class Name(Curve, kind="name")`` also registers a dataclass, so that scenario files and saved runs
    may contain it. The results of these methods are checked at each call in classes outside the package.

    Attributes
    ----------
    begin_s, end_s : float
        First and last coordinate, m; -inf or inf for a path without begin or end.
    kind : str or None
        Name in scenario files and saved runs.
    turn_width : float or None
        Distance between neighbouring turns, m, which benches have to be narrower than; None without such turns.
    default_turns : float or None
        Turn on which a march begins by default; None on a curve whose turns are not counted.
    inward : bool
        Whether the distance from the origin falls and the absolute curvature grows along the whole path.
    flags : mapping of str to (str, str)
        Parameters that are flags of the command line: a placeholder of the value, and a description.
    inner_ends : tuple of float
        Finite coordinates, m, at which pieces inside this curve begin or end, by their own zero.

    Examples
    --------
    A rope that hangs between two posts, with its lowest point at (0, 2) m:

    >>> import numpy as np
    >>> class Catenary(Curve):
    ...     begin_s, end_s = -np.inf, np.inf
    ...
    ...     def point(self, s):
    ...         return np.stack([2 * np.arcsinh(np.divide(s, 2)), np.hypot(s, 2)], axis=-1)
    ...
    ...     def tangent(self, s):
    ...         return np.stack([np.full(np.shape(s), 2.0), np.asarray(s)], axis=-1) / np.hypot(s, 2)[..., None]
    ...
    ...     def curvature(self, s):
    ...         return 2 / (np.square(s) + 4)
    ...
    ...     def max_curvature(self, s, other):
    ...         # The curvature is largest at the lowest point.
    ...         return self.curvature(np.clip(0, np.minimum(s, other), np.maximum(s, other)))
    >>> from pymunk_dragon.model.curves import Composite, Line, Section
    >>> top, slope = Catenary().point(3.0), Catenary().tangent(3.0)
    >>> path = Composite([Section(Catenary(), -3.0, 3.0), Line(start=top, stop=top + slope)])
    >>> path.point([0.0, 3.0, 6.0, 7.0]).round(3).tolist()
    [[-2.39, 3.606], [0.0, 2.0], [2.39, 3.606], [2.944, 4.438]]
    """

    kinds: ClassVar[dict[str, type[Any]]] = {}
    kind: ClassVar[str | None] = None
    default_turns: ClassVar[float | None] = None
    flags: ClassVar[Mapping[str, tuple[str, str]]] = {}

    if TYPE_CHECKING:
        # Only declared, so that a dataclass may have fields of these names.
        @property
        def begin_s(self) -> float:
            """First coordinate, m."""

        @property
        def end_s(self) -> float:
            """Last coordinate, m."""

    def __init_subclass__(cls, kind: str | None = None, **others: Any) -> None:
        super().__init_subclass__(**others)
        # A dataclass with slots is a second class with the members of the first one.
        cls.kind = cls.__dict__.get("kind") if kind is None else kind
        if cls.kind is not None:
            _register(cls.kind, cls)
        own = {}
        for name in (*CHECKED, *DERIVED):
            base = next(base for base in cls.__mro__ if name in vars(base))
            if not is_of_package(base):
                own[name] = vars(base)[name]
        if "point" in own or "tangent" in own:
            for name in DERIVED:
                if name not in own:
                    setattr(cls, name, getattr(Curve, name))
        for name, tail in CHECKED.items():
            if name in own and not hasattr(own[name], CHECK):
                check = checked_bound if name == "max_curvature" else checked_method
                setattr(cls, name, check(name, own[name], tail))

    @property
    def turn_width(self) -> float | None:
        """Distance between neighbouring turns, m, or None."""
        return None

    @property
    def inward(self) -> bool:
        """Whether the distance from the origin falls and the absolute curvature grows along the whole path."""
        return False

    @property
    def circles(self) -> tuple[tuple[float, float, float], ...]:
        """Circles about the curve that pictures show: x and y of the centre, and radius, m."""
        return ()

    @property
    def inner_ends(self) -> tuple[float, ...]:
        """Finite coordinates, m, at which pieces inside this curve begin or end, by their own zero."""
        return ()

    @abstractmethod
    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m.

        Right to 8 last digits of the largest coordinate, in space or along the path: the certificate of a first contact
        rests on this.
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

        The certificate of a first contact depends on this bound. It is 0 beyond the ends.
        """

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        return self.point(s), self.tangent(s)

    def chain(self, s: ArrayLike, spacings: ArrayLike) -> Array:
        """Coordinates of all handles of chains with the heads at `s`, each laid out along the path from its head.

        Each handle is at the first point back along the path whose straight distance from the handle before is the
        spacing, never at a later intersection. That distance has to grow over the whole arc between. Motion may take a
        chain to other states: `continuation.py` follows it.

        Parameters
        ----------
        s : array_like, shape (T,)
            Coordinates of the heads, m.
        spacings : array_like, shape (N,)
            Straight distances between neighbouring handles, m.

        Returns
        -------
        ndarray, shape (T, N + 1)
            Coordinates, m; nan for a handle that has none on the curve, and for all behind it.

        Examples
        --------
        >>> from pymunk_dragon.model.curves import Line
        >>> Line(stop=(30, 40)).chain([10.0], [3.0, 2.0]).round(9).tolist()
        [[10.0, 7.0, 5.0]]
        """
        return self.chain_motion(s, spacings).handles_s

    def chain_motion(self, s: ArrayLike, spacings: ArrayLike) -> ChainMotion:
        """The chains of `chain` with the positions of their handles, tangents and velocity ratios.

        Each chain is computed as a whole. Where this does not succeed, as its front is where the path bends sharply, a
        block of benches is computed one by one, and then the chain behind them.
        """
        heads, chords = np.array(s, dtype=float).ravel(), np.asarray(spacings, dtype=float).ravel()
        found, settled = chain.whole_chains(self, heads, chords)
        if not settled.all():
            rest = ~settled
            handles_s = np.full((int(rest.sum()), chords.size + 1), np.nan)
            handles_s[:, : BLOCK + 1] = self._bench_by_bench(heads[rest], chords[:BLOCK])
            behind = ~np.isnan(handles_s[:, min(BLOCK, chords.size)])
            if chords.size > BLOCK and behind.any():
                handles_s[behind, BLOCK:] = self.chain(handles_s[behind, BLOCK], chords[BLOCK:])
            for into, part in zip(found, chain.chain_motion(self, handles_s, chords), strict=True):
                into[rest] = part
        return found

    def _bench_by_bench(self, s: Array, chords: Array) -> Array:
        """Coordinates (T, H) as in `chain`, from each handle to the next."""
        parameters = np.empty((s.size, chords.size + 1))
        parameters[:, 0] = self.parameter(s)
        for i, chord in enumerate(chords.tolist()):
            parameters[:, i + 1] = self.behind(parameters[:, i], chord)
        handles_s = self.coordinate(parameters)
        # The inverse of `parameter` rounds; the heads keep their coordinates.
        handles_s[:, 0] = np.where(np.isnan(parameters[:, 0]), np.nan, s)
        return handles_s

    def parameter(self, s: Array) -> Array:
        """The parameter in which `chain` computes, (...), growing in the direction of travel; nan off the curve.

        It is the coordinate unless a curve has a faster one.
        """
        return np.where((s >= self.begin_s) & (s <= self.end_s), s, np.nan)

    def coordinate(self, parameter: Array) -> Array:
        """Coordinates (...) of parameters, m: the inverse of `parameter`."""
        return parameter

    def estimate(self, heads: Array, spacings: Array) -> Array:
        """Estimated parameters (T, H) of chains: each arc is as long as on a circle of the path's curvature there."""
        s = heads[:, None] - np.concatenate([[0.0], np.cumsum(spacings)])
        square = self.curvature(np.clip(s, self.begin_s, self.end_s)) ** 2
        curvature = np.sqrt((square[:, 1:] + square[:, :-1]) / 2)
        s[:, 1:] = heads[:, None] - np.cumsum(chain.arcs(spacings, curvature), axis=1)
        return self.parameter(np.maximum(s, self.begin_s))

    def motion(self, parameter: Array) -> tuple[Complex, Complex]:
        """Positions and their derivatives by the parameter, each (...), as complex numbers."""
        points, tangents = self.frame(parameter)
        return as_complex(points), as_complex(tangents)

    def nearest(self, parameters: Array, handles_s: Array, spacings: Array) -> Flags:
        """Whether each handle of chains (T,), with parameters and coordinates (T, H), is the nearest one back.

        The straight distances are the spacings; they have to grow over the whole arcs between.
        """
        return chain.nearest(self, handles_s, spacings)

    def behind(self, parameter: Array, chord: float) -> Array:
        """Parameters (T,) of the nearest points back along the path at the straight distance `chord`; nan if none."""
        found = np.full(parameter.shape, np.nan)
        on = ~np.isnan(parameter)
        found[on] = self.parameter(chain.rear_handle(self, self.coordinate(parameter[on]), chord))
        return found

    def chain_follows_motion(self, spacings: Array) -> bool:
        """Whether `chain` always finds the state to which continuous motion leads, for spacings (N,) in m."""
        return False

    def foot(self, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
        """Feet of the perpendiculars from `points` (..., 2) close to the path.

        Parameters
        ----------
        points : array_like, shape (..., 2)
            m.
        near : array_like, shape (...)
            Estimates of the coordinates, m: the foot is the one nearest to them along the path.

        Returns
        -------
        s : ndarray, shape (...)
            Coordinates of the feet, m.
        feet, tangents : ndarray, shape (..., 2)
            The path's points, m, and unit tangents there.

        Examples
        --------
        >>> from pymunk_dragon.model.curves import Line
        >>> s, feet, tangents = Line(stop=(10, 0)).foot([[4.0, 0.5]], [3.0])
        >>> s.tolist(), feet.tolist()
        ([4.0], [[4.0, 0.0]])
        """
        return chain.foot(self, points, near)

    def at_turn(self, turns: float) -> float:
        """Coordinate `turns` turns from the centre, m.

        Raises
        ------
        ParameterError
            If the curve has no turns that are counted, or `turns` is out of range.
        """
        raise ParameterError("turns", turns, "absent: only a Spiral has turns, other curves have a start_s")

    def turns(self, s: float) -> float | None:
        """Number of turns from the centre at the coordinate `s` m; None on a curve whose turns are not counted."""
        return None

    def speeds_by_difference(self, now: Array, later: Array, step: float) -> Array:
        """Speeds (...), m/s, of handles at `now`, and at `later` after `step` s, from their polar angles (eq. 15).

        Raises
        ------
        ParameterError
            If the curve has no polar angles.
        """
        raise ParameterError("curve", type(self).__name__, "a Spiral, which has polar angles")

    def to_dict(self) -> dict[str, Any]:
        """Kind and parameters as plain values, of which `Curve.from_dict` makes an equal curve.

        Raises
        ------
        ParameterError
            If the class of this curve, or of one inside it, is not registered, or more than 32 levels are nested. A
            class derived from a registered one is not registered itself, because it may override anything.

        Examples
        --------
        >>> from pymunk_dragon.model.curves import Arc, Reversed
        >>> Reversed(Arc(radius=2, sweep=1)).to_dict()["curve"]
        {'kind': 'arc', 'centre': [0.0, 0.0], 'radius': 2.0, 'begin_angle': 0.0, 'sweep': 1.0}
        """
        return _to_dict(self, "curve", 1)

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Curve:
        """Curve of a registered kind with the given parameters; those that are curves are mappings as well.

        Raises
        ------
        ParameterError
            If the kind is unknown, a parameter is missing, unknown or refused by the class, or more than 32 levels are
            nested. The error names the path to the parameter, as in ``curve.pieces[1].radius``.

        Examples
        --------
        >>> Curve.from_dict({"kind": "line", "stop": [3, 4]})
        Line(start=(0.0, 0.0), stop=(3.0, 4.0))
        """
        return _from_dict(values, "curve", 1)


def _register(kind: object, cls: type[Any]) -> None:
    """Add a class to `Curve.kinds`; a class of the same name, as in a notebook's cell, is replaced."""
    if not isinstance(kind, str):
        raise ParameterError("kind", kind, "a text")
    known = Curve.kinds.get(kind, cls)
    if (known.__module__, known.__name__) != (cls.__module__, cls.__name__):
        raise ParameterError("kind", kind, f"a text that no other class has; this is the kind of {known.__name__}")
    Curve.kinds[kind] = cls


def is_of_package(cls: type[Any]) -> bool:
    """Whether a class belongs to the package; the results of others are checked at each call."""
    return cls.__module__.startswith(__package__)


def _to_dict(curve: Curve, where: str, depth: int) -> dict[str, Any]:
    if curve.kind is None or not is_dataclass(curve):
        known = ", ".join(sorted(Curve.kinds))
        bound = f"a curve of the package ({known}) to be written down, or of a class with a kind of its own"
        raise ParameterError(where, type(curve).__name__, bound)
    _check_depth(type(curve).__name__, depth)

    def plain(value: Any, where: str) -> Any:
        if isinstance(value, Curve):
            return _to_dict(value, where, depth + 1)
        if isinstance(value, tuple):
            return [plain(item, f"{where}[{i}]") for i, item in enumerate(value)]
        return value.tolist() if isinstance(value, np.ndarray) else value

    return {"kind": curve.kind} | {
        name: plain(getattr(curve, name), f"{where}.{name}") for name in parameters_of(type(curve))
    }


def _from_dict(values: Mapping[str, Any], where: str, depth: int) -> Curve:
    _check_depth(values, depth)
    if not isinstance(values, Mapping):
        raise ParameterError(where, values, "a table with the kind of a curve and its parameters")
    given = dict(values)
    kind = given.pop("kind", None)
    if not (isinstance(kind, str) and kind in Curve.kinds):
        bound = f"one of {', '.join(sorted(Curve.kinds))}{did_you_mean(kind, Curve.kinds)}"
        raise ParameterError(f"{where}.kind", kind, bound)
    parameters = parameters_of(Curve.kinds[kind])
    for name, value in given.items():
        if name not in parameters:
            owners = ", ".join(sorted(other for other, cls in Curve.kinds.items() if name in parameters_of(cls)))
            hint = f"kinds with it: {owners}" if owners else f"its parameters are {', '.join(parameters)}"
            raise ParameterError(f"{where}.{name}", value, f"absent on a {kind} curve; {hint}")
    for name, required in parameters.items():
        if required and name not in given:
            raise ParameterError(f"{where}.{name}", None, f"given: the kind {kind} has no default for it")

    def made(value: Any, where: str) -> Any:
        if isinstance(value, Mapping):
            return _from_dict(value, where, depth + 1)
        if isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value):
            return [made(item, f"{where}[{i}]") for i, item in enumerate(value)]
        return value

    arguments = {name: made(value, f"{where}.{name}") for name, value in given.items()}
    try:
        curve: Curve = Curve.kinds[kind](**arguments)
    except ParameterError as error:
        raise ParameterError(f"{where}.{error.name}", error.value, error.bound) from error
    return curve


def parameters_of(cls: type[Any]) -> dict[str, bool]:
    """Names of the parameters of a registered class, and whether each is required."""
    known = fields(cls) if is_dataclass(cls) else ()
    return {f.name: f.default is MISSING and f.default_factory is MISSING for f in known if f.init}


def _check_depth(value: object, depth: int) -> None:
    if depth > MAX_DEPTH:
        raise ParameterError("curve", value, f"nested in at most {MAX_DEPTH - 1} other curves")
