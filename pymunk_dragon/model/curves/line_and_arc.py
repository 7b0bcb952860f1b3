"""Straight lines, and circular arcs of one turn or of several."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arguments import Array, finite, numbers
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.base import FARTHEST, PackageCurve

# m. Closer points do not define a direction, and smaller circles are too narrow even for benches of a millimetre.
_SHORTEST_LINE = _MIN_RADIUS = 1e-3
# rad: a thousand turns, and the angle at which they begin. More is taken for a typing error, and costs digits.
_MAX_ANGLE = 2000 * math.pi
# m. Less is taken for a typing error.
_SHORTEST_ARC = 1e-9


@dataclass(frozen=True, kw_only=True)
class Line(PackageCurve, kind="line"):
    """Straight line; the coordinate is the distance from its start.

    Parameters
    ----------
    start, stop : tuple of float
        End points, at least 1 mm apart: x and y in m, from -100 to 100 km.

    Examples
    --------
    >>> Line(stop=(30, 40)).point([0.0, 25.0]).tolist()
    [[0.0, 0.0], [15.0, 20.0]]
    """

    begin_s = 0.0

    start: tuple[float, float] = (0.0, 0.0)
    stop: tuple[float, float]

    def __post_init__(self) -> None:
        start, stop = _point("start", self.start), _point("stop", self.stop)
        self._set(start=start, stop=stop, end_s=math.dist(start, stop))
        if self.end_s < _SHORTEST_LINE:
            raise ParameterError("stop", stop, f"at least {_SHORTEST_LINE:g} m from the start, {start}")

    def _frame(self, s: Array) -> tuple[Array, Array]:
        direction = np.subtract(self.stop, self.start) / self.end_s
        return self.start + s[..., None] * direction, direction + 0 * s[..., None]

    def _curvature(self, s: Array) -> Array:
        return 0 * s

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return 0 * lower


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
        Angle that it covers, positive counter-clockwise, rad, at most 1000 turns: after one, the arc goes round again.

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
        angles = {n: finite(n, getattr(self, n), -_MAX_ANGLE, _MAX_ANGLE, "rad") for n in ("begin_angle", "sweep")}
        self._set(centre=_point("centre", self.centre), radius=radius, **angles, end_s=radius * abs(angles["sweep"]))
        if self.end_s < _SHORTEST_ARC:
            raise ParameterError("sweep", self.sweep, f"at least {_SHORTEST_ARC / radius:.3g} rad, to either side")

    def _frame(self, s: Array) -> tuple[Array, Array]:
        angle = self.begin_angle + self._curvature(s) * s
        cosine, sine, side = np.cos(angle), np.sin(angle), math.copysign(1.0, self.sweep)
        points = self.centre + self.radius * np.stack([cosine, sine], axis=-1)
        return points, side * np.stack([-sine, cosine], axis=-1)

    def _curvature(self, s: Array) -> Array:
        return math.copysign(1 / self.radius, self.sweep) + 0 * s

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        return 1 / self.radius + 0 * lower


def _point(name: str, value: object) -> tuple[float, float]:
    """`value` as x and y in m."""
    xy = numbers(name, value)
    if xy.shape != (2,) or not (np.abs(xy) <= FARTHEST).all():
        raise ParameterError(name, value, f"two numbers x, y from {-FARTHEST:g} to {FARTHEST:g} m")
    x, y = xy.tolist()
    return x, y
