"""What the exact kinematics and the rails need to know of a path."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._checks import answer, number
from pymunk_dragon.errors import ParameterError

__all__ = ["Array", "Curve", "check_curve", "curvature", "frame", "max_curvature", "point", "tangent"]

Array = NDArray[np.float64]


@runtime_checkable
class Curve(Protocol):
    """A smooth path with a direction of travel, by arc length.

    A point of the path is given by its arc-length coordinate ``s`` in m, which grows in the direction of travel; each
    curve defines its zero. Every method is vectorised over coordinates and returns arrays of their shape, or that shape
    + (2,) for points and vectors. Beyond the ends the result is nan.

    Any class with these members is a curve that a dragon can march on.

    Examples
    --------
    A rope that hangs between two posts, with its lowest point at (0, 2) m:

    >>> import numpy as np
    >>> class Catenary:
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

    @property
    def begin_s(self) -> float:
        """Coordinate where the path begins, m; -inf for one that comes from infinity."""
        ...

    @property
    def end_s(self) -> float:
        """Coordinate where the path ends, m; inf for one that goes on for ever."""
        ...

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m.

        Right to 8 last digits of the largest coordinate, in space or along the path: the certificate of a first contact
        rests on this.
        """
        ...

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        ...

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive for a curve to the left."""
        ...

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Upper bound (...) on the absolute curvature between two coordinates in any order, 1/m.

        The certificate of a first contact depends on this bound. It is 0 beyond the ends.
        """
        ...


def check_curve(name: str, value: object) -> None:
    """Check that `value` is a curve, and call each method of a user-defined class with coordinates of shape (1, 3).

    Raises
    ------
    ParameterError
        If it is no curve, its ends are no numbers in the order of travel, or a method returns anything but finite
        numbers of the shape that `Curve` requires.
    """
    if isinstance(value, type) or not isinstance(value, Curve):
        raise ParameterError(name, value, "a Curve")
    if _is_of_package(value):
        return
    kind = type(value).__name__
    begin, end = number(value.begin_s), number(value.end_s)
    # Written so that nan fails.
    if not begin < end:
        raise ParameterError(
            f"{kind}.begin_s and end_s", (value.begin_s, value.end_s), "two numbers, m, the first one smaller"
        )
    if np.isinf(begin):
        begin = min(end, 1.0) - 1
    coordinates = begin + min(end - begin, 1.0) * np.array([[0.25, 0.5, 0.75]])
    frame(value, coordinates)
    curvature(value, coordinates)
    max_curvature(value, coordinates[:, :-1], coordinates[:, 1:])


def point(curve: Curve, s: ArrayLike) -> Array:
    """Points (..., 2) of a curve, m."""
    return _called(curve, "point", s, (2,))


def tangent(curve: Curve, s: ArrayLike) -> Array:
    """Tangents (..., 2) of a curve."""
    return _called(curve, "tangent", s, (2,))


def curvature(curve: Curve, s: ArrayLike) -> Array:
    """Curvature (...) of a curve, 1/m."""
    return _called(curve, "curvature", s, ())


def frame(curve: Curve, s: ArrayLike) -> tuple[Array, Array]:
    """Points and tangents of a curve, each (..., 2); at once where it has a method `frame`, which costs less."""
    if _is_of_package(curve) and (own := getattr(curve, "frame", None)) is not None:
        points, tangents = own(s)
    else:
        points, tangents = point(curve, s), tangent(curve, s)
    return np.ascontiguousarray(points, dtype=float), np.ascontiguousarray(tangents, dtype=float)


def max_curvature(curve: Curve, s: ArrayLike, other: ArrayLike) -> Array:
    """A curve's bound on its curvature between coordinates, as a new array of their shape."""
    shape = np.broadcast_shapes(np.shape(s), np.shape(other))
    bounds = curve.max_curvature(s, other)
    if not _is_of_package(curve):
        method = f"{type(curve).__name__}.max_curvature(s, other)"
        bounds = answer(method, bounds, shape)
        bad = ~(np.isfinite(bounds) & (bounds >= 0) | np.isnan(np.add(s, other)))
        if bad.any():
            raise ParameterError(method, bounds[bad][0].item(), "finite and not negative, 1/m")
    return np.array(np.broadcast_to(bounds, shape), dtype=float)


def _is_of_package(curve: Curve) -> bool:
    """Whether the tests vouch for the class of a curve."""
    return type(curve).__module__.startswith(__package__)


def _called(curve: Curve, method: str, s: ArrayLike, tail: tuple[int, ...]) -> Array:
    """Result of a curve's method for coordinates; checked if the class is user-defined."""
    value: Any = getattr(curve, method)(s)
    if _is_of_package(curve):
        return np.asarray(value)
    coordinates = np.asarray(s, dtype=float)
    name = f"{type(curve).__name__}.{method}"
    array = answer(f"{name}(s)", value, coordinates.shape, tail)
    on = np.isfinite(coordinates) & (coordinates >= curve.begin_s) & (coordinates <= curve.end_s)
    bad = on & ~(np.isfinite(array).all(axis=-1) if tail else np.isfinite(array))
    if bad.any():
        bound = f"finite from begin_s = {curve.begin_s:g} m to end_s = {curve.end_s:g} m"
        raise ParameterError(f"{name}({coordinates[bad][0]:.9g})", array[bad][0].tolist(), bound)
    return array
