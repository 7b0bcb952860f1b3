"""What a speed over time has to answer, and the plainest one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.checks import finite

__all__ = ["MAX_SPEED", "MIN_SPEED", "Array", "ConstantSpeed", "Speed", "largest_between"]

Array = NDArray[np.float64]

# Metres per second. Nobody runs faster than 13, and a snail is a thousand times as fast as the slowest.
MIN_SPEED, MAX_SPEED = 1e-6, 20.0


@runtime_checkable
class Speed(Protocol):
    """The speed of handle 0 over time; never zero, so that every way has its time."""

    def at(self, t: ArrayLike) -> Array:
        """Speed (T,) in m/s at times `t` (T,) in s."""
        ...

    def way(self, t: ArrayLike) -> Array:
        """Distance (T,) in m gone from time 0 to `t` (T,) in s, negative before 0."""
        ...

    def time(self, way: ArrayLike) -> Array:
        """Times (T,) in s at which `way` (T,) in m has been gone: the inverse of `way`."""
        ...

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """Upper bound (T,) in m/s, up to rounding, on the speed from `t0` (T,) to `t1` (T,) in s, `t0` <= `t1`."""
        ...


@dataclass(frozen=True)
class ConstantSpeed:
    """One speed at all times, `value` in m/s.

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

    def way(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        return self.value * np.asarray(t, dtype=float)

    def time(self, way: ArrayLike) -> Array:
        """As in `Speed`."""
        return np.asarray(way, dtype=float) / self.value

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """As in `Speed`."""
        return np.full(np.broadcast_shapes(np.shape(t0), np.shape(t1)), self.value)


def largest_between(values: Array, first: NDArray[np.intp], last: NDArray[np.intp]) -> Array:
    """Largest of `values[first:last]` for each pair (T,) of indices, 0 where there are none; no value is negative."""
    largest: Array = np.maximum.reduceat(np.append(values, 0.0), np.stack([first, last], axis=-1).ravel())[::2]
    return np.where(first < last, largest, 0.0)
