"""Check of a curve of a user's own against what marches, first contacts and the engine rely on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, as_vectors
from pymunk_dragon._checks import finite, number, numbers
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Curve, required_curve

# Coordinates at which a curve is sampled.
_SAMPLES = 2001
# m of an infinite curve that are sampled.
_REACH = 200.0
# m. Central differences over it are off by its square; rounding, by a double's last digit over it.
_STEP = 1e-4
# Error of a unit vector, or of a curvature times a metre, by differences on a radius of 1 m.
_TOLERANCE = 3e-7
# Difference of two ways to compute one vector or coordinate, m.
_SAME = 1e-9
# Rounding error of a unit vector, and share of a curvature.
_ROUNDING = 1e-12
# m beyond an end that are no rounding, and more.
_BEYOND = np.array([1e-6, 1.0, 1e9])
# Samples between the coordinates for which `max_curvature` is called.
_WIDTHS = (0, 1, 2, 5, 40, _SAMPLES // 3, _SAMPLES)
# Axes that a method's result has beside those of its arguments.
_TAILS: dict[str, tuple[int, ...]] = {"point": (2,), "tangent": (2,), "curvature": ()}


def check_curve(curve: Curve, low: float | None = None, high: float | None = None) -> None:
    """Check that a curve of your own keeps what `Curve` requires.

    A `ParameterError` names the first fault. Call it once, in the tests of your class: marches do
    not check at each call what a curve returns. It samples the curve at 2001 coordinates. Results
    must have the shapes of the arguments and be finite between the ends and nan beyond; the
    derivative of `point` must be `tangent`, and that of `tangent` the curvature, which may jump;
    `max_curvature` must be above all curvatures, and `normal_offset` above all distances of normals
    from the origin; and what the class inherits must agree with its `point`.

    Parameters
    ----------
    curve : Curve
        An object of the class.
    low : float, optional
        First coordinate that is sampled, m: by default the begin, if the curve has one.
    high : float, optional
        Last coordinate that is sampled, m: by default the end, or 200 m later on an infinite curve.

    Examples
    --------
    >>> from pymunk_dragon import Spiral
    >>> class Shifted(Spiral):
    ...     def point(self, s):
    ...         return super().point(s) + [1.0, 0.0]
    >>> check_curve(Shifted(), -300, -1)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    pymunk_dragon.errors.ParameterError: Shifted.frame(-300) is [..., ...], but must be what ...
    """
    required_curve(curve)
    ends = getattr(curve, "begin_s", None), getattr(curve, "end_s", None)
    begin, end = map(number, ends)
    # The comparison is false for nan.
    if not begin < end:
        name = f"{type(curve).__name__}.begin_s and end_s"
        raise ParameterError(name, ends, "two numbers, m, the first one smaller")

    if low is None:
        low = begin if np.isfinite(begin) else min(end, _REACH / 2) - _REACH
    low = finite("low", low, begin, end, "m")
    if high is None:
        high = end if np.isfinite(end) else low + _REACH
    s = np.linspace(low, finite("high", high, low, end, "m"), _SAMPLES)

    # Coordinates beyond each end.
    edges = {}
    if np.isfinite(begin):
        edges[begin] = begin - _BEYOND
    if np.isfinite(end):
        edges[end] = end + _BEYOND
    _check_values(curve, s, edges)
    _check_derivatives(curve, s[(s - _STEP >= begin) & (s + _STEP <= end)])
    _check_max_curvature(curve, s, edges)
    _check_other_methods(curve, s)


def _result(curve: Curve, method: str, *arguments: ArrayLike) -> Array:
    """What a method returns, if it is numbers of the right shape."""
    result = getattr(curve, method)(*arguments)
    shape = np.broadcast_shapes(*map(np.shape, arguments))
    wanted = shape + _TAILS.get(method, ())
    name = f"{type(curve).__name__}.{method}(s)"
    array: Array = numbers(name, result)
    if array.shape != wanted:
        bound = f"of the shape {wanted} for coordinates of the shape {shape}"
        raise ParameterError(name, result, bound)
    return array


def _require(curve: Curve, method: str, s: Array, found: Array, right: Any, bound: str) -> None:
    """Raise an error for the first coordinate (n,) at which `found` (n, ...) is not right."""
    axes = tuple(range(1, np.ndim(right)))
    wrong = np.flatnonzero(~np.all(right, axis=axes))
    if wrong.size:
        i = wrong[0]
        name = f"{type(curve).__name__}.{method}({s[i]:.9g})"
        raise ParameterError(name, found[i].tolist(), bound)


def _check_values(curve: Curve, s: Array, edges: dict[float, Array]) -> None:
    inside = np.array([*s, *edges])
    outside = np.array([*edges.values()]).ravel()
    for method in _TAILS:
        found = _result(curve, method, inside)
        _require(curve, method, inside, found, np.isfinite(found), "finite from begin_s to end_s")
        found = _result(curve, method, outside)
        _require(curve, method, outside, found, np.isnan(found), "nan beyond the ends")

        for arguments in (s[:6].reshape(2, 3), np.empty((0, 4)), s[::-37]):
            each = arguments.ravel()
            alone = [_result(curve, method, one) for one in each.tolist()]
            found = _result(curve, method, arguments).reshape(each.size, *_TAILS[method])
            off = np.abs(found - np.reshape(alone, found.shape))
            same = off <= _SAME * (1 + np.abs(found))
            _require(curve, method, each, found, same, "the same as for each coordinate alone")


def _check_derivatives(curve: Curve, s: Array) -> None:
    around = [s - _STEP, s, s + _STEP]
    points = [_result(curve, "point", part) for part in around]
    tangents = [_result(curve, "tangent", part) for part in around]
    curvatures = np.array([_result(curve, "curvature", part) for part in around])
    size = 1 + np.abs(curvatures).max(initial=0) ** 2
    jump = np.ptp(curvatures, axis=0)[:, None]

    ahead = tangents[1]
    unit = np.abs(np.linalg.norm(ahead, axis=1) - 1) <= _ROUNDING
    _require(curve, "tangent", s, ahead, unit, "a unit vector")

    off = np.abs((points[2] - points[0]) / (2 * _STEP) - ahead)
    close = off <= _TOLERANCE * size + _STEP * jump
    _require(curve, "tangent", s, ahead, close, "the derivative of point by the arc length")

    curvature = curvatures[1]
    normals = np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)
    off = np.abs((tangents[2] - tangents[0]) / (2 * _STEP) - curvature[:, None] * normals)
    close = off <= _TOLERANCE * size**1.5 + jump
    bound = "the derivative of the direction of tangent"
    _require(curve, "curvature", s, curvature, close, bound)


def _check_max_curvature(curve: Curve, s: Array, edges: dict[float, Array]) -> None:
    name = "max_curvature"
    # Arguments of different shapes, and numbers.
    _result(curve, name, s[:3], s[:2, None])
    _result(curve, name, float(s[0]), float(s[1]))

    for edge, beyond in edges.items():
        near, far = beyond[:1], beyond[1:2]
        found = _result(curve, name, near, beyond[2:])
        _require(curve, name, near, found, found == 0, "0 beyond the ends")
        found = _result(curve, name, far, s[:1])
        known = _result(curve, name, np.array([edge]), s[:1])
        right = np.abs(found - known) <= _ROUNDING * known
        _require(curve, name, far, found, right, f"{known[0]:.9g}, as from the end on")

    curvatures = np.abs(_result(curve, "curvature", s))
    first = np.arange(0, s.size, 7)
    for width in _WIDTHS:
        last = np.minimum(first + width, s.size - 1)
        bound = _result(curve, name, s[first], s[last])
        swapped = _result(curve, name, s[last], s[first])
        largest = [curvatures[a : a + width + 1].max() for a in first]
        right = np.isfinite(bound) & (bound * (1 + _ROUNDING) >= largest)
        least = "finite, and no less than any curvature in between"
        _require(curve, name, s[first], bound, right, least)
        _require(curve, name, s[last], swapped, swapped == bound, "the same in both orders")


def _check_other_methods(curve: Curve, s: Array) -> None:
    wanted = np.stack([_result(curve, "point", s), _result(curve, "tangent", s)], axis=1)
    frame = np.stack(curve.frame(s), axis=1)
    same = np.abs(frame - wanted) <= _SAME
    _require(curve, "frame", s, frame[:, 0], same, "what point and tangent return")

    offsets = np.abs(np.sum(wanted[:, 0] * wanted[:, 1], axis=-1))
    right = offsets <= number(curve.normal_offset) + _SAME
    _require(curve, "normal_offset", s, offsets, right, "at most the normal_offset of the curve, m")

    parameters = curve._parameter(s)
    remedy = "derive the class from Curve, not from a curve of the package"
    bound = f"as point and tangent have it: {remedy}"
    back = curve._coordinate(parameters)
    _require(curve, "_coordinate", s, back, np.abs(back - s) <= _SAME, bound)

    points, derivatives = curve._motion(parameters)
    ahead = derivatives / np.abs(derivatives)
    found = np.stack([as_vectors(points.copy()), as_vectors(ahead)], axis=1)
    _require(curve, "_motion", s, found[:, 0], np.abs(found - wanted) <= _SAME, bound)
