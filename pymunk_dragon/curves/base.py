"""What the exact kinematics and the rails need to know of a path."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Array", "Curve", "frame", "sharpest"]

Array = NDArray[np.float64]


@runtime_checkable
class Curve(Protocol):
    """A smooth path with a direction of travel, by arc length.

    A place on the path is its arc length ``s`` in m, which grows in the direction of travel; where it is zero is the
    curve's own choice. Every method is vectorised over places and returns arrays of their shape, or that shape + (2,)
    for points and vectors. Beyond the ends there is no place: the answer is nan.

    Any class with these members is a curve that a dragon can march on.

    Examples
    --------
    A rope that hangs between two posts, with its lowest point at (0, 2) m:

    >>> import numpy as np
    >>> class Catenary:
    ...     begin, end = -np.inf, np.inf
    ...
    ...     def point(self, s):
    ...         return np.stack([2 * np.arcsinh(np.divide(s, 2)), np.hypot(s, 2)], axis=-1)
    ...
    ...     def tangent(self, s):
    ...         return np.stack([np.full(np.shape(s), 2.0), np.asarray(s)], axis=-1) / np.hypot(s, 2)[..., None]
    ...
    ...     def curvature(self, s):
    ...         return 2 / (np.square(s) + 4)
    ...
    ...     def sharpest(self, s, other):
    ...         # It bends most at its lowest point.
    ...         return self.curvature(np.clip(0, np.minimum(s, other), np.maximum(s, other)))
    >>> from pymunk_dragon.curves import Composite, Line, Section
    >>> top, slope = Catenary().point(3.0), Catenary().tangent(3.0)
    >>> path = Composite([Section(Catenary(), -3.0, 3.0), Line(start=top, stop=top + slope)])
    >>> path.point([0.0, 3.0, 6.0, 7.0]).round(3).tolist()
    [[-2.39, 3.606], [0.0, 2.0], [2.39, 3.606], [2.944, 4.438]]
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


def frame(curve: Curve, s: ArrayLike) -> tuple[Array, Array]:
    """Points and tangents of a curve, each (..., 2); at once where it has a method `frame`, which costs less."""
    own = getattr(curve, "frame", None)
    points, tangents = own(s) if own is not None else (curve.point(s), curve.tangent(s))
    # A user's curve may lay its numbers out in another order, or not own them.
    return np.ascontiguousarray(points, dtype=float), np.ascontiguousarray(tangents, dtype=float)


def sharpest(curve: Curve, s: Array, other: Array) -> Array:
    """A curve's bound on its curvature between places, as an array of their shape that is the caller's own."""
    return np.array(np.broadcast_to(curve.sharpest(s, other), np.broadcast_shapes(s.shape, other.shape)), dtype=float)
