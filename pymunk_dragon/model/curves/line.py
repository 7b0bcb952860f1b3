"""Straight lines."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import PackageCurve, position

# m. Closer points do not define a direction.
_SHORTEST = 1e-3


@dataclass(frozen=True, kw_only=True)
class Line(PackageCurve, kind="line"):
    """Straight line; the coordinate is the distance from its start.

    Parameters
    ----------
    start : tuple of float
        First point: x and y in m, from -100 to 100 km.
    stop : tuple of float
        Last point, at least 1 mm from the first one: x and y in m, from -100 to 100 km.

    Examples
    --------
    >>> Line(stop=(30, 40)).point([0.0, 25.0]).tolist()
    [[0.0, 0.0], [15.0, 20.0]]
    """

    begin_s = 0.0

    start: tuple[float, float] = (0.0, 0.0)
    stop: tuple[float, float]

    def __post_init__(self) -> None:
        start, stop = position("start", self.start), position("stop", self.stop)
        self._set(start=start, stop=stop, end_s=math.dist(start, stop))
        if self.end_s < _SHORTEST:
            raise ParameterError("stop", stop, f"at least {_SHORTEST:g} m from the start, {start}")

    def _frame(self, s: Array) -> tuple[Array, Array]:
        direction = np.subtract(self.stop, self.start) / self.end_s
        return self.start + s[..., None] * direction, direction + 0 * s[..., None]

    def _curvature(self, s: Array) -> Array:
        return 0 * s

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return 0 * lower
