"""The contest's turn inside a circle."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite
from pymunk_dragon.model.curves.arc import Arc
from pymunk_dragon.model.curves.base import Curve
from pymunk_dragon.model.curves.composite import Composite, Section
from pymunk_dragon.model.curves.spiral import Spiral

# m. Smaller circles are too narrow for benches.
_MIN_RADIUS = 0.1
# m. On larger circles, coordinates on the spiral lose digits.
_MAX_RADIUS = 100.0
# Beyond this ratio of the radii the turn is one on a single arc.
_MAX_RATIO = 50.0


class _Shape:
    """What follows from the parameters of a turn."""

    length: float
    sweeps: Array
    radii: Array
    tangent_points: Array
    centres: Array


@dataclass(frozen=True, kw_only=True)
class UTurn(_Shape, Composite, kind="u-turn"):
    """In on a spiral, round inside a circle on two arcs that touch, and out on another spiral.

    The way out is the spiral turned by 180 degrees. The coordinate is 0 at the entry to the circle.
    Entry and exit are opposite to each other with equal tangents, so both arcs turn by twice the
    angle between the entry's direction and the straight line to the exit. This fixes the sum of the
    radii, and the length of the turn, whatever the ratio.

    Parameters
    ----------
    pitch : float
        Radial distance between turns of either spiral, m, from 0.001 to 1000.
    radius : float
        Radius of the circle about the origin, m, from 0.1 to 100 and at most 1000 pitches.
    ratio : float
        Radius of the first arc over that of the second, from 0.02 to 50.

    Attributes
    ----------
    length : float
        Length of both arcs, m.
    radii : ndarray, shape (2,), m
    sweeps : ndarray, shape (2,), rad
        Angles of the arcs.
    centres : ndarray, shape (2, 2), m
    tangent_points : ndarray, shape (3, 2), m
        Entry, the point between the arcs, and exit.

    Examples
    --------
    >>> round(UTurn().length, 6)
    13.621245
    """

    flags: ClassVar = {
        "pitch": "Distance between the turns of the spiral, m.",
        "radius": "Radius of the circle in which a u-turn is made, m.",
        "ratio": "Radius of a u-turn's first arc over that of its second.",
    }

    pieces: tuple[Curve, ...] = field(init=False, repr=False, compare=False)
    pitch: float = 1.7
    radius: float = 4.5
    ratio: float = 2.0

    def __post_init__(self) -> None:
        inward = Spiral(pitch=self.pitch)
        outward = Spiral(pitch=self.pitch, rotation=math.pi, outward=True)
        radius = finite("radius", self.radius, _MIN_RADIUS, _MAX_RADIUS, "m")
        ratio = finite("ratio", self.ratio, 1 / _MAX_RATIO, _MAX_RATIO, "")
        s = inward.at_radius(radius)

        # The polar angle of the entry; the angle between the path there and the straight line to
        # the exit.
        angle = 2 * math.pi * radius / inward.pitch
        aside = math.atan(angle)
        heading = angle - math.pi + aside
        sweeps = np.array([-2 * aside, 2 * aside])
        # Each arc's chord is twice its radius times the sine of half its angle; together they are
        # the diameter.
        radii = radius / math.sin(aside) / (1 + ratio) * np.array([ratio, 1.0])
        entry = radius * np.array([math.cos(angle), math.sin(angle)])
        points = np.outer([1.0, (1 - ratio) / (1 + ratio), -1.0], entry)
        normal = [-math.sin(heading), math.cos(heading)]
        centres = points[[0, 2]] + np.outer(radii * [-1, 1], normal)
        begins = heading + math.pi / 2, heading - 2 * aside - math.pi / 2

        first, second = (
            Arc(centre=centres[i], radius=radii[i], begin_angle=begins[i], sweep=sweeps[i])
            for i in range(2)
        )
        way_in = Section(inward, -math.inf, s)
        way_out = Section(outward, -s, math.inf)
        self._set(pieces=(way_in, first, second, way_out))
        super().__post_init__()
        length = 2 * aside * radius / math.sin(aside)
        self._set(pitch=inward.pitch, radius=radius, ratio=ratio, length=length)
        self._set(sweeps=sweeps, radii=radii, tangent_points=points, centres=centres)
        self._set(turn_width=inward.pitch, circles=((0.0, 0.0, radius),))
