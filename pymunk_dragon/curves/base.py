"""What the exact kinematics and the rails need to know of a path."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Array", "Curve"]

Array = NDArray[np.float64]


@runtime_checkable
class Curve(Protocol):
    """A smooth path with a direction of travel, by arc length.

    A place on the path is its arc length ``s`` in m, which grows in the direction of travel; where it is zero is the
    curve's own choice. Every method is vectorised over places and returns arrays of their shape, or that shape + (2,)
    for points and vectors. Beyond the ends there is no place: the answer is nan.

    Any class with these members is a curve that a dragon can march on.
    """

    @property
    def begin(self) -> float:
        """Place where the path begins, m; -inf for one that comes from infinity."""
        ...

    @property
    def end(self) -> float:
        """Place where the path ends, m; inf for one that goes on for ever."""
        ...

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        ...

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        ...

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive where the path bends to the left."""
        ...

    def sharpest(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Curvature (...) in 1/m that the path nowhere exceeds, to either side, between two places in any order.

        The certificate of a first contact rests on this bound. What lies beyond the ends bends nowhere.
        """
        ...
