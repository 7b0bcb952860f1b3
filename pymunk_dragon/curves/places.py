"""Places on a curve that ends somewhere, and points of the plane as users give them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon.checks import finite
from pymunk_dragon.curves.base import Array
from pymunk_dragon.errors import ParameterError

__all__ = ["FARTHEST", "overlap", "plane_point", "within"]

# Metres from the origin, a day's march. So far out a double still tells places 0.02 nm apart.
FARTHEST = 1e5


def within(s: ArrayLike, begin: float, end: float) -> Array:
    """Places as an array, with nan for those that are not from `begin` to `end`."""
    places = np.asarray(s, dtype=float)
    return np.where((places >= begin) & (places <= end), places, np.nan)


def overlap(s: ArrayLike, other: ArrayLike, begin: float, end: float) -> tuple[Array, Array]:
    """Lower and upper ends of what the stretches from `s` to `other` share with that from `begin` to `end`.

    Where they share nothing, the lower one is above the upper one.
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
