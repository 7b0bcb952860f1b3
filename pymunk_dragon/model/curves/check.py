"""Check of a curve of a user's own against what marches, first contacts and the engine rely on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, as_vectors
from pymunk_dragon._checks import finite, number, numbers
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Curve, required_curve

# Coordinates at which a curve is sampled, and m of an infinite one that are sampled.
_SAMPLES, _REACH = 2001, 200.0
# m. Central differences over it are off by its square, and rounding by a double's last digit over
# it.
_STEP = 1e-4
# Of a unit vector, and of a curvature times a metre: for derivatives by differences, where the
# radius is 1 m, for two ways to compute the same, and for rounding.
_TOLERANCE, _SAME, _ROUNDING = 3e-7, 1e-9, 1e-12
# m beyond an end that are no rounding, and more.
_BEYOND = np.array([1e-6, 1.0, 1e9])
# Samples between the coordinates for which `max_curvature` is called.
_WIDTHS = (0, 1, 2, 5, 40, _SAMPLES // 3, _SAMPLES)
# Axes that a method's result has beside those of its arguments.
_TAILS: dict[str, tuple[int, ...]] = {"point": (2,), "tangent": (2,), "curvature": ()}


def check_curve(curve: Curve, low: float | None = None, high: float | None = None) -> None:
    """Check that a curve of your own keeps what `Curve` requires; a `ParameterError` names the first fault.

    Call it once, in the tests of your class: marches do not check at each call what a curve
    returns. It samples the curve at 2001 coordinates. Results must have the shapes of the arguments
    and be finite between the ends and nan beyond; the derivative of `point` must be `tangent`, and
    that of `tangent` the curvature, which may jump; `max_curvature` must be above all curvatures;
    and what the class inherits must agree with its `point`.

    Parameters
    ----------
    curve : Curve
        An object of the class.
    low, high : float, optional
        Coordinates between which it is sampled, m: by default the ends, or 200 m of a curve without
        end.

    Examples
    --------
    >>> from pymunk_dragon import Spiral
    >>> class Shifted(Spiral):
    ...     def point(self, s):
    ...         return super().point(s) + [1.0, 0.0]
    >>> check_curve(Shifted(), -300, -1)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    pymunk_dragon.errors.ParameterError: Shifted.frame(-300) is [..., ...], but must be what point and tangent return
    """
    required_curve("curve", curve)
    ends = getattr(curve, "begin_s", None), getattr(curve, "end_s", None)
    begin, end = map(number, ends)
    # Written so that nan fails.
    if not begin < end:
        raise ParameterError(
            f"{type(curve).__name__}.begin_s and end_s",
            ends,
            "two numbers, m, the first one smaller",
        )
    if low is None:
        low = begin if np.isfinite(begin) else min(end, _REACH / 2) - _REACH
    low = finite("low", low, begin, end, "m")
    if high is None:
        high = end if np.isfinite(end) else low + _REACH
    s = np.linspace(low, finite("high", high, low, end, "m"), _SAMPLES)
    edges = {
        edge: edge + side * _BEYOND for side, edge in ((-1, begin), (1, end)) if np.isfinite(edge)
    }
    _check_values(curve, s, edges)
    _check_derivatives(curve, s[(s - _STEP >= begin) & (s + _STEP <= end)])
    _check_max_curvature(curve, s, edges)
    _check_other_methods(curve, s)


def _result(curve: Curve, method: str, *arguments: ArrayLike) -> Array:
    """What a method returns, if it is numbers of the right shape."""
    result = getattr(curve, method)(*arguments)
    shape = np.broadcast_shapes(*map(np.shape, arguments))
    name, wanted = f"{type(curve).__name__}.{method}(s)", shape + _TAILS.get(method, ())
    array: Array = numbers(name, result)
    if array.shape != wanted:
        raise ParameterError(
            name, result, f"of the shape {wanted} for coordinates of the shape {shape}"
        )
    return array


def _require(curve: Curve, method: str, s: Array, found: Array, right: Any, bound: str) -> None:
    """Raise an error for the first coordinate (n,) at which what was `found` (n, ...) is not right."""
    for i in np.flatnonzero(~np.all(right, axis=tuple(range(1, np.ndim(right)))))[:1].tolist():
        raise ParameterError(
            f"{type(curve).__name__}.{method}({s[i]:.9g})", found[i].tolist(), bound
        )


def _check_values(curve: Curve, s: Array, edges: dict[float, Array]) -> None:
    inside, outside = np.array([*s, *edges]), np.array([*edges.values()]).ravel()
    for method in _TAILS:
        found = _result(curve, method, inside)
        _require(curve, method, inside, found, np.isfinite(found), "finite from begin_s to end_s")
        found = _result(curve, method, outside)
        _require(curve, method, outside, found, np.isnan(found), "nan beyond the ends")
        for arguments in (s[:6].reshape(2, 3), np.empty((0, 4)), s[::-37]):
            alone = [_result(curve, method, float(one)) for one in arguments.flat]
            found = _result(curve, method, arguments).reshape(len(alone), *_TAILS[method])
            same = np.abs(found - np.reshape(alone, found.shape)) <= _SAME * (1 + np.abs(found))
            _require(
                curve,
                method,
                arguments.ravel(),
                found,
                same,
                "the same as for each coordinate alone",
            )


def _check_derivatives(curve: Curve, s: Array) -> None:
    around = [s - _STEP, s, s + _STEP]
    points, tangents = (
        [_result(curve, name, part) for part in around] for name in ("point", "tangent")
    )
    curvatures = np.array([_result(curve, "curvature", part) for part in around])
    size, jump = 1 + np.abs(curvatures).max(initial=0) ** 2, np.ptp(curvatures, axis=0)[:, None]
    ahead, curvature = tangents[1], curvatures[1][:, None]
    unit = np.abs(np.linalg.norm(ahead, axis=1) - 1) <= _ROUNDING
    _require(curve, "tangent", s, ahead, unit, "a unit vector")
    close = (
        np.abs((points[2] - points[0]) / (2 * _STEP) - ahead) <= _TOLERANCE * size + _STEP * jump
    )
    _require(curve, "tangent", s, ahead, close, "the derivative of point by the arc length")
    normals = np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)
    off = np.abs((tangents[2] - tangents[0]) / (2 * _STEP) - curvature * normals)
    close = off <= _TOLERANCE * size**1.5 + jump
    _require(
        curve, "curvature", s, curvatures[1], close, "the derivative of the direction of tangent"
    )


def _check_max_curvature(curve: Curve, s: Array, edges: dict[float, Array]) -> None:
    for pair in ((s[:3], s[:2, None]), (float(s[0]), float(s[1]))):
        _result(curve, "max_curvature", *pair)
    for edge, beyond in edges.items():
        found = _result(curve, "max_curvature", beyond[:1], beyond[2:])
        _require(curve, "max_curvature", beyond[:1], found, found == 0, "0 beyond the ends")
        found, known = (
            _result(curve, "max_curvature", np.array([one]), s[:1]) for one in (beyond[1], edge)
        )
        right = np.abs(found - known) <= _ROUNDING * known
        _require(
            curve, "max_curvature", beyond[1:2], found, right, f"{known[0]:.9g}, as from the end on"
        )
    curvatures, first = np.abs(_result(curve, "curvature", s)), np.arange(0, s.size, 7)
    for width in _WIDTHS:
        last = np.minimum(first + width, s.size - 1)
        bound, swapped = (
            _result(curve, "max_curvature", s[a], s[b]) for a, b in ((first, last), (last, first))
        )
        largest = np.array([curvatures[a : b + 1].max() for a, b in zip(first, last, strict=True)])
        right = np.isfinite(bound) & (bound * (1 + _ROUNDING) >= largest)
        _require(
            curve,
            "max_curvature",
            s[first],
            bound,
            right,
            "finite, and no less than any curvature in between",
        )
        _require(
            curve, "max_curvature", s[last], swapped, swapped == bound, "the same in both orders"
        )


def _check_other_methods(curve: Curve, s: Array) -> None:
    wanted = np.stack([_result(curve, name, s) for name in ("point", "tangent")], axis=1)
    frame = np.stack(curve.frame(s), axis=1)
    _require(
        curve,
        "frame",
        s,
        frame[:, 0],
        np.abs(frame - wanted) <= _SAME,
        "what point and tangent return",
    )
    parameters = curve._parameter(s)
    back, (points, derivatives) = curve._coordinate(parameters), curve._motion(parameters)
    bound = (
        "as point and tangent have it: derive the class from Curve, not from a curve of the package"
    )
    _require(curve, "_coordinate", s, back, np.abs(back - s) <= _SAME, bound)
    found = np.stack(
        [as_vectors(points.copy()), as_vectors(derivatives / np.abs(derivatives))], axis=1
    )
    _require(curve, "_motion", s, found[:, 0], np.abs(found - wanted) <= _SAME, bound)
