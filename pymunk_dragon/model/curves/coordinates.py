"""Coordinates on curves with ends, and points of the plane given by users."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._checks import finite
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import Array

__all__ = ["FARTHEST", "overlap", "plane_point", "within"]

# m from the origin. At this distance a double still resolves 0.02 nm.
FARTHEST = 1e5


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
    """`value` as x and y in m, if it is two numbers.

    Raises
    ------
    ParameterError
        If it is not.
    """
    bound = f"two numbers x, y from {-FARTHEST:g} to {FARTHEST:g} m"
    if isinstance(value, Iterable) and np.shape(parts := list(value)) == (2,):
        try:
            x, y = (finite(name, part, -FARTHEST, FARTHEST, "m") for part in parts)
        except ParameterError:
            pass
        else:
            return x, y
    raise ParameterError(name, value, bound)
