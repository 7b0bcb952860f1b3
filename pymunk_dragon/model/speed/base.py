"""Interface of a speed profile, and the constant one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import answer, finite
from pymunk_dragon.errors import ParameterError

__all__ = ["MAX_SPEED", "MIN_SPEED", "Array", "ConstantSpeed", "OwnSpeed", "Speed", "largest_between"]


# m/s, a thousandth of a snail's speed.
MIN_SPEED = 1e-6
# m/s; sprinters reach 13 m/s.
MAX_SPEED = 20.0


@runtime_checkable
class Speed(Protocol):
    """Speed of handle 0 over time. It is never zero, so every distance has one time.

    Examples
    --------
    >>> from pymunk_dragon.model.speed import SpeedTable
    >>> profile: Speed = SpeedTable([0, 10], [1, 3])
    >>> profile.distance([5.0, 10.0]).tolist()
    [7.5, 20.0]
    """

    def at(self, t: ArrayLike) -> Array:
        """Speed (T,) in m/s at times `t` (T,) in s."""
        ...

    def distance(self, t: ArrayLike) -> Array:
        """Distance (T,) in m travelled from time 0 to `t` (T,) in s, negative before 0."""
        ...

    def time(self, distance: ArrayLike) -> Array:
        """Times (T,) in s at which the `distance` (T,) in m is reached: the inverse of the method `distance`."""
        ...

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """Upper bound (T,) in m/s, up to rounding, on the speed from `t0` (T,) to `t1` (T,) in s, `t0` <= `t1`."""
        ...


@dataclass(frozen=True)
class ConstantSpeed:
    """The same speed at all times, `value` in m/s.

    Raises
    ------
    ParameterError
        If it is not a number from 1e-6 to 20 m/s.
    """

    value: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", finite("speed", self.value, MIN_SPEED, MAX_SPEED, "m/s"))

    def at(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        return np.full(np.shape(t), self.value)

    def distance(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        return self.value * np.asarray(t, dtype=float)

    def time(self, distance: ArrayLike) -> Array:
        """As in `Speed`."""
        return np.asarray(distance, dtype=float) / self.value

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """As in `Speed`."""
        return np.full(np.broadcast_shapes(np.shape(t0), np.shape(t1)), self.value)


@dataclass(frozen=True)
class OwnSpeed:
    """Wrapper of a user-defined speed profile that checks all return values.

    Raises
    ------
    ParameterError
        When a method is called: if it returns anything but numbers of the shape that `Speed` requires, nan, or a speed
        below 1e-6 or above 20 m/s.
    """

    speed: Speed

    def at(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        return self._called("at", t, low=MIN_SPEED, high=MAX_SPEED)

    def distance(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        return self._called("distance", t)

    def time(self, distance: ArrayLike) -> Array:
        """As in `Speed`."""
        return self._called("time", distance)

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """As in `Speed`."""
        return self._called("fastest", t0, t1, low=MIN_SPEED)

    def _called(self, method: str, *given: ArrayLike, low: float = -np.inf, high: float = np.inf) -> Array:
        name = f"{type(self.speed).__name__}.{method}"
        values = answer(name, getattr(self.speed, method)(*given), np.broadcast_shapes(*map(np.shape, given)))
        arguments = np.broadcast_arrays(*given)
        bad = ~((values >= low) & (values <= high)) & np.all(np.isfinite(arguments), axis=0)
        if bad.any():
            where = ", ".join(f"{argument[bad][0]:.9g}" for argument in arguments)
            raise ParameterError(f"{name}({where})", values[bad][0].item(), f"a number from {low:g} to {high:g}")
        return values


def largest_between(values: Array, first: NDArray[np.intp], last: NDArray[np.intp]) -> Array:
    """Largest of `values[first:last]` for each pair (T,) of indices, 0 where there are none; no value is negative."""
    largest: Array = np.maximum.reduceat(np.append(values, 0.0), np.stack([first, last], axis=-1).ravel())[::2]
    return np.where(first < last, largest, 0.0)
