"""Checks of the results of curves' methods, for classes outside the package."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import answer
from pymunk_dragon.errors import ParameterError

if TYPE_CHECKING:
    from pymunk_dragon.model.curves.base import Curve

# Attribute of methods that check their results.
CHECK = "_checks_results"


def checked_method(name: str, method: Any, tail: tuple[int, ...]) -> Callable[[Any, ArrayLike], Array]:
    """The method `name`, with its results checked: finite numbers (...) + `tail` for coordinates (...) on the curve."""

    @wraps(getattr(method, "__func__", method))
    def checked(self: Curve, s: ArrayLike) -> Array:
        coordinates = np.asarray(s, dtype=float)
        called = f"{type(self).__name__}.{name}"
        values = answer(f"{called}(s)", method.__get__(self, type(self))(s), coordinates.shape, tail)
        on = np.isfinite(coordinates) & (coordinates >= self.begin_s) & (coordinates <= self.end_s)
        bad = on & ~(np.isfinite(values).all(axis=-1) if tail else np.isfinite(values))
        if bad.any():
            bound = f"finite from begin_s = {self.begin_s:g} m to end_s = {self.end_s:g} m"
            raise ParameterError(f"{called}({coordinates[bad][0]:.9g})", values[bad][0].tolist(), bound)
        return values

    setattr(checked, CHECK, True)
    return checked


def checked_bound(name: str, method: Any, tail: tuple[int, ...]) -> Callable[[Any, ArrayLike, ArrayLike], Array]:
    """`method` with a check that it returns bounds (...), finite and not negative, for two coordinates."""

    @wraps(getattr(method, "__func__", method))
    def checked(self: Curve, s: ArrayLike, other: ArrayLike) -> Array:
        called = f"{type(self).__name__}.{name}(s, other)"
        shape = np.broadcast_shapes(np.shape(s), np.shape(other))
        bounds = answer(called, method.__get__(self, type(self))(s, other), shape, tail)
        bad = ~(np.isfinite(bounds) & (bounds >= 0) | np.isnan(s) | np.isnan(other))
        if bad.any():
            raise ParameterError(called, bounds[bad][0].item(), "finite and not negative, 1/m")
        return bounds

    setattr(checked, CHECK, True)
    return checked
