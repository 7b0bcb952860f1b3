"""What the exact kinematics and the rails need to know of a path."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Curve"]

Array = NDArray[np.float64]


@runtime_checkable
class Curve(Protocol):
    """A path with a direction of travel.

    A place on the path is a value of the curve's own parameter ``u``; every method is vectorised over it and returns
    arrays of the broadcast shape, or that shape + (2,) for points and vectors. Where a place does not exist the
    answer is nan, never another place.
    """

    @property
    def turn_distance(self) -> float:
        """Distance between neighbouring turns in m, ``inf`` for a path that never comes back beside itself."""
        ...

    def start(self, turns: float) -> float:
        """Parameter of the place where a march that begins on turn `turns` begins."""
        ...

    def remaining(self, u: ArrayLike) -> Array:
        """Arc length from `u` to the end of the path, m."""
        ...

    def advance(self, u: ArrayLike, distance: ArrayLike) -> Array:
        """Place that lies `distance` m of arc length further along (negative: back)."""
        ...

    def behind(self, u: ArrayLike, chord: float) -> Array:
        """Nearest place back along the path whose straight distance from `u` is `chord` m."""
        ...

    def foot(self, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
        """Place beside each of `points` (..., 2) on the turn nearest to the place `near`, its point and its tangent."""
        ...

    def point(self, u: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        ...

    def tangent(self, u: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        ...

    def stretch(self, u: ArrayLike) -> Array:
        """Metres of arc length per unit of `u` (positive)."""
        ...

    def sharpest(self, u: ArrayLike, v: ArrayLike) -> Array:
        """Largest curvature in 1/m, whichever way the path bends, between the places `u` and `v`."""
        ...
