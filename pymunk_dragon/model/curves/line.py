"""A straight line from one point to another."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves._arguments import plane_point, within
from pymunk_dragon.model.curves.base import Curve

__all__ = ["Line"]

# m. Two points closer than this do not define a direction.
SHORTEST = 1e-3


@dataclass(frozen=True, kw_only=True)
class Line(Curve, kind="line"):
    """Straight line; the coordinate is the distance from its start.

    Parameters
    ----------
    start, stop : tuple of float
        End points: x and y in m. (The attribute `end` is the last coordinate, as on every curve.)

    Raises
    ------
    ParameterError
        If they are not two points at least 1 mm apart and no further than 100 km from the origin along either axis.

    Examples
    --------
    >>> Line(stop=(30, 40)).point([0.0, 25.0]).tolist()
    [[0.0, 0.0], [15.0, 20.0]]
    """

    start: tuple[float, float] = (0.0, 0.0)
    stop: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", plane_point("start", self.start))
        object.__setattr__(self, "stop", plane_point("stop", self.stop))
        if self.end_s < SHORTEST:
            raise ParameterError("stop", self.stop, f"at least {SHORTEST:g} m from the start, {self.start}")

    @property
    def begin_s(self) -> float:
        """0 m."""
        return 0.0

    @property
    def end_s(self) -> float:
        """Length, m."""
        return math.dist(self.start, self.stop)

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        coordinates = within(s, self.begin_s, self.end_s)
        return self.start + coordinates[..., None] * self._direction

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        return self._direction + 0 * within(s, self.begin_s, self.end_s)[..., None]

    def curvature(self, s: ArrayLike) -> Array:
        """0 (...) on the line."""
        return np.asarray(0 * within(s, self.begin_s, self.end_s))

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """0 (...)."""
        return np.zeros(np.broadcast_shapes(np.shape(s), np.shape(other)))

    @property
    def _direction(self) -> Array:
        direction: Array = np.subtract(self.stop, self.start) / self.end_s
        return direction
