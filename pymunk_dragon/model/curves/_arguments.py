"""Checks of the arguments of curves, and their coordinates between two ends."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, number
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Curve, is_of_package

# m from the origin. At this distance a double still resolves 0.02 nm.
FARTHEST = 1e5


def check_curve(name: str, value: object) -> None:
    """Check that `value` is a curve, and call each method of a class outside the package with coordinates (1, 3).

    Raises
    ------
    ParameterError
        If it is no curve, its ends are no numbers in the order of travel, or a method returns anything but finite
        numbers of the shape that `Curve` requires.
    """
    if not isinstance(value, Curve):
        raise ParameterError(name, value, "a Curve")
    if is_of_package(type(value)):
        return
    kind = type(value).__name__
    ends = getattr(value, "begin_s", None), getattr(value, "end_s", None)
    begin, end = map(number, ends)
    # Written so that nan fails.
    if not begin < end:
        raise ParameterError(f"{kind}.begin_s and end_s", ends, "two numbers, m, the first one smaller")
    if np.isinf(begin):
        begin = min(end, 1.0) - 1
    coordinates = begin + min(end - begin, 1.0) * np.array([[0.25, 0.5, 0.75]])
    for method in (value.point, value.tangent, value.curvature):
        method(coordinates)
    value.max_curvature(coordinates[:, :-1], coordinates[:, 1:])


def within(s: ArrayLike, begin: float, end: float) -> Array:
    """Coordinates as an array, with nan for those that are not from `begin` to `end`."""
    coordinates = np.asarray(s, dtype=float)
    return np.where((coordinates >= begin) & (coordinates <= end), coordinates, np.nan)


def overlap(s: ArrayLike, other: ArrayLike, begin: float, end: float) -> tuple[Array, Array]:
    """Lower and upper ends of the intersections of the intervals from `s` to `other` with that from `begin` to `end`.

    If an intersection is empty, its lower end is above its upper end.
    """
    lower, upper = np.minimum(s, other), np.maximum(s, other)
    return np.maximum(lower, begin), np.minimum(upper, end)


def plane_point(name: str, value: object) -> tuple[float, float]:
    """`value` as x and y in m, or a `ParameterError`."""
    bound = f"two numbers x, y from {-FARTHEST:g} to {FARTHEST:g} m"
    if isinstance(value, Iterable) and len(parts := list(value)) == 2:
        try:
            x, y = (finite(name, part, -FARTHEST, FARTHEST, "m") for part in parts)
        except ParameterError:
            pass  # The error below names the whole value.
        else:
            return x, y
    raise ParameterError(name, value, bound)
