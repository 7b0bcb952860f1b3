"""Circular arcs, of one turn or of several."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves._arguments import FARTHEST, overlap, plane_point, within
from pymunk_dragon.model.curves.base import Curve

__all__ = ["Arc"]

# m. Smaller circles are too narrow even for benches of a millimetre.
MIN_RADIUS = 1e-3
# Radians: a thousand turns and the angle at which they begin. More is taken for a typing error, and costs digits.
MAX_ANGLE = 2000 * math.pi

# m. Less is taken for a typing error.
SHORTEST = 1e-9


@dataclass(frozen=True, kw_only=True)
class Arc(Curve, kind="arc"):
    """Circular arc; the coordinate is the arc length from its beginning.

    Parameters
    ----------
    centre : tuple of float
        x and y in m.
    radius : float
        m.
    begin_angle : float
        Direction from the centre to where the arc begins, rad.
    sweep : float
        Angle that it covers, positive counter-clockwise, rad. More than a whole turn goes round again.

    Raises
    ------
    ParameterError
        If the centre is not a point at most 100 km from the origin along either axis, the radius not from 1 mm to
        100 km, an angle not from -1000 to 1000 turns, or the sweep so small that the arc is shorter than 1 nm.

    Examples
    --------
    >>> Arc(radius=2, sweep=3.0).end_s
    6.0
    """

    centre: tuple[float, float] = (0.0, 0.0)
    radius: float
    begin_angle: float = 0.0
    sweep: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", plane_point("centre", self.centre))
        object.__setattr__(self, "radius", finite("radius", self.radius, MIN_RADIUS, FARTHEST, "m"))
        for name in ("begin_angle", "sweep"):
            object.__setattr__(self, name, finite(name, getattr(self, name), -MAX_ANGLE, MAX_ANGLE, "rad"))
        if self.end_s < SHORTEST:
            raise ParameterError("sweep", self.sweep, f"at least {SHORTEST / self.radius:.3g} rad, to either side")

    @property
    def begin_s(self) -> float:
        """0 m."""
        return 0.0

    @property
    def end_s(self) -> float:
        """Length, m."""
        return self.radius * abs(self.sweep)

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m."""
        return self.frame(s)[0]

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        return self.frame(s)[1]

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        angle = self._angle(s)
        outward = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        leftward = np.stack([-outward[..., 1], outward[..., 0]], axis=-1)
        return self.centre + self.radius * outward, self._side * leftward

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive for an arc to the left."""
        return self._side / self.radius + 0 * within(s, self.begin_s, self.end_s)

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """1 / radius (...) between coordinates of the arc."""
        lower, upper = overlap(s, other, self.begin_s, self.end_s)
        return np.where(lower <= upper, 1 / self.radius, 0.0)

    @property
    def _side(self) -> float:
        return math.copysign(1.0, self.sweep)

    def _angle(self, s: ArrayLike) -> Array:
        return np.asarray(self.begin_angle + self._side / self.radius * within(s, self.begin_s, self.end_s))
