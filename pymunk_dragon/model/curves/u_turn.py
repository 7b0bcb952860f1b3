"""The turn of the contest's question 4: in on one spiral, round on two arcs, out on the other."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite
from pymunk_dragon.model.curves.base import Curve
from pymunk_dragon.model.curves.composite import Composite, Section
from pymunk_dragon.model.curves.line_and_arc import Arc
from pymunk_dragon.model.curves.spiral import Spiral

__all__ = ["UTurn"]

# m. Smaller circles are too narrow for benches.
MIN_RADIUS = 0.1
# m. On larger circles, coordinates on the spiral lose digits.
MAX_RADIUS = 100.0
# A turn on arcs more different than this is one on a single arc.
MAX_RATIO = 50.0


@dataclass(frozen=True, kw_only=True)
class UTurn(Composite, kind="u-turn"):
    """In on a spiral, round inside a circle on two arcs that touch, and out on the spiral turned by 180 degrees.

    The coordinate is 0 at the entry to the circle. Entry and exit are opposite to each other with equal tangents, so
    both arcs have the same angle: twice that between the entry's direction and the straight line to the
    exit. With that the sum of the radii is fixed, and the length of the turn as well, whatever their ratio.

    Parameters
    ----------
    pitch : float
        Radial distance between turns of either spiral, m, from 0.001 to 1000.
    radius : float
        Radius of the circle about the origin, m, from 0.1 to 100 and at most 1000 pitches.
    ratio : float
        Radius of the first arc over that of the second, from 0.02 to 50.

    Examples
    --------
    >>> round(UTurn().length, 6)
    13.621245
    """

    flags: ClassVar = {
        "pitch": ("M", "Distance between the turns of the spiral, m."),
        "radius": ("M", "Radius of the circle in which a u-turn is made, m."),
        "ratio": ("X", "Radius of a u-turn's first arc over that of its second."),
    }

    pieces: tuple[Curve, ...] = field(init=False, repr=False, compare=False)
    pitch: float = 1.7
    radius: float = 4.5
    ratio: float = 2.0

    def __post_init__(self) -> None:
        inward = Spiral(pitch=self.pitch)
        object.__setattr__(self, "pitch", inward.pitch)
        object.__setattr__(self, "radius", finite("radius", self.radius, MIN_RADIUS, MAX_RADIUS, "m"))
        object.__setattr__(self, "ratio", finite("ratio", self.ratio, 1 / MAX_RATIO, MAX_RATIO, ""))
        s, outward = inward.at_radius(self.radius), Spiral(pitch=self.pitch, rotation=math.pi, outward=True)
        begins = self._heading + math.pi / 2, self._heading + self.sweeps[0] - math.pi / 2
        arcs = (
            Arc(centre=centre, radius=radius, begin_angle=begin, sweep=sweep)
            for centre, radius, begin, sweep in zip(self.centres, self.radii, begins, self.sweeps, strict=True)
        )
        object.__setattr__(self, "pieces", (Section(inward, -math.inf, s), *arcs, Section(outward, -s, math.inf)))
        super().__post_init__()

    @property
    def turn_width(self) -> float:
        """The pitch, m."""
        return self.pitch

    @property
    def circles(self) -> tuple[tuple[float, float, float], ...]:
        """The circle inside which the turn is made: x and y of the centre, and radius, m."""
        return ((0.0, 0.0, self.radius),)

    @property
    def radii(self) -> Array:
        """Radii of the arcs, (2,), m."""
        # Each arc's chord is twice its radius times the sine of half its angle; together they are the diameter.
        return self.radius / math.sin(self._aside) / (1 + self.ratio) * np.array([self.ratio, 1.0])

    @property
    def centres(self) -> Array:
        """Centres of the arcs, (2, 2), m: the first on the right of the path, the second on its left."""
        left = np.array([-math.sin(self._heading), math.cos(self._heading)])
        return self.tangent_points[[0, 2]] + np.outer(self.radii * [-1, 1], left)

    @property
    def sweeps(self) -> Array:
        """Angles that the arcs turn by, (2,), rad."""
        return np.array([-2 * self._aside, 2 * self._aside])

    @property
    def tangent_points(self) -> Array:
        """Entry, the point between the arcs, and exit, (3, 2), m."""
        entry = self.radius * np.array([math.cos(self._angle), math.sin(self._angle)])
        return np.outer([1.0, (1 - self.ratio) / (1 + self.ratio), -1.0], entry)

    @property
    def length(self) -> float:
        """Length of both arcs, m."""
        return 2 * self._aside * self.radius / math.sin(self._aside)

    @property
    def _angle(self) -> float:
        """Polar angle of the entry, rad."""
        return 2 * math.pi * self.radius / self.pitch

    @property
    def _aside(self) -> float:
        """Angle between the direction at the entry and the straight line to the exit, rad."""
        return math.atan(self._angle)

    @property
    def _heading(self) -> float:
        """Direction of travel at the entry and at the exit, rad."""
        return self._angle - math.pi + self._aside
