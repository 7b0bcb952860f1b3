"""Circular arcs of one turn or of several."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import FARTHEST, PackageCurve, position

# m. Smaller circles are too narrow even for benches of a millimetre.
_MIN_RADIUS = 1e-3
# rad: a thousand turns. More is taken for a typing error, and costs digits.
_MAX_ANGLE = 2000 * math.pi
# m. Less is taken for a typing error.
_SHORTEST = 1e-9


@dataclass(frozen=True, kw_only=True)
class Arc(PackageCurve, kind="arc"):
    """Circular arc; the coordinate is the arc length from its beginning.

    Parameters
    ----------
    centre : tuple of float
        x and y in m, from -100 to 100 km.
    radius : float
        m, from 1 mm to 100 km.
    begin_angle : float
        Direction from the centre to where the arc begins, rad, at most 1000 turns.
    sweep : float
        Angle that it covers, positive counter-clockwise, rad, at most 1000 turns: after one, the
        arc goes round again.

    Examples
    --------
    >>> Arc(radius=2, sweep=3.0).end_s
    6.0
    """

    begin_s = 0.0

    centre: tuple[float, float] = (0.0, 0.0)
    radius: float
    begin_angle: float = 0.0
    sweep: float

    def __post_init__(self) -> None:
        radius = finite("radius", self.radius, _MIN_RADIUS, FARTHEST, "m")
        begin = finite("begin_angle", self.begin_angle, -_MAX_ANGLE, _MAX_ANGLE, "rad")
        sweep = finite("sweep", self.sweep, -_MAX_ANGLE, _MAX_ANGLE, "rad")
        self._set(centre=position("centre", self.centre), radius=radius)
        self._set(begin_angle=begin, sweep=sweep, end_s=radius * abs(sweep))
        if self.end_s < _SHORTEST:
            bound = f"at least {_SHORTEST / radius:.3g} rad, to either side"
            raise ParameterError("sweep", self.sweep, bound)

    def _frame(self, s: Array) -> tuple[Array, Array]:
        angle = self.begin_angle + self._curvature(s) * s
        cosine = np.cos(angle)
        sine = np.sin(angle)
        side = math.copysign(1.0, self.sweep)
        points = self.centre + self.radius * np.stack([cosine, sine], axis=-1)
        return points, side * np.stack([-sine, cosine], axis=-1)

    def _curvature(self, s: Array) -> Array:
        return math.copysign(1 / self.radius, self.sweep) + 0 * s

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return 1 / self.radius + 0 * lower
