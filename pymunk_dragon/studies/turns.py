"""Turns on three arcs, tangent to each other and to both spirals: what the shortest one is sought among."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.curves import Arc, Composite, Curve, Line, Section, UTurn

__all__ = ["Turn", "three_arcs"]

Array = NDArray[np.float64]

# 1/m. An arc that bends less is drawn as a line: from end to end they are less than 0.1 mm apart.
STRAIGHT = 1e-5
# m. A shorter piece between the arcs is none.
SHORTEST = 1e-3
# rad. Arcs that turn further go round the wrong way.
MAX_SWEEP = 1.5 * math.pi


@dataclass(frozen=True, kw_only=True)
class Turn:
    """In on a spiral, round to the right, on along a line or a gentle arc, round to the left, and out on the other.

    Attributes
    ----------
    path : Composite
        All of it; its place 0 is where the inward spiral is left.
    length : float
        From where the circle is entered to where it is left, m.
    radii : tuple of float
        Of the arcs to the right and to the left, m.
    bend : float
        Curvature of what is between them, positive to the left, 1/m.
    sweeps : tuple of float
        Angles that the three turn by, positive to the left, rad.
    """

    path: Composite
    length: float
    radii: tuple[float, float]
    bend: float
    sweeps: tuple[float, float, float]


def three_arcs(
    base: UTurn, first: float, second: float, bend: float = 0.0, *, late: float = 0.0, early: float = 0.0
) -> Turn | None:
    """The turn with arcs of the radii `first` and `second` and a middle piece of curvature `bend`.

    Parameters
    ----------
    base : UTurn
        Whose spirals and circle.
    first, second : float
        m.
    bend : float
        1/m, positive to the left.
    late, early : float
        How far inside the circle the inward spiral is left, and the outward one is joined, m along them.

    Returns
    -------
    Turn or None
        None where the arcs do not fit.
    """
    inward, outward = base.pieces[0], base.pieces[-1]
    assert isinstance(inward, Section)
    assert isinstance(outward, Section)
    before = Section(inward.curve, inward.begin, inward.end + late)
    after = Section(outward.curve, outward.begin - early, outward.end)
    start, setting_out = _complex(before.point(before.end)), _complex(before.tangent(before.end))
    stop, arriving = _complex(after.point(after.begin)), _complex(after.tangent(after.begin))
    # The first circle lies on the right of the way, the second one on its left.
    one, other = start - 1j * first * setting_out, stop + 1j * second * arriving
    headings = _headings(other - one, first, second, bend)
    if headings is None:
        return None
    leaving, joining = headings
    sweeps = (-_angle(leaving, setting_out), cmath.phase(joining / leaving), _angle(joining, arriving))
    middle, goal = one + 1j * first * leaving, other - 1j * second * joining
    straight = abs(bend) < STRAIGHT
    between = abs(goal - middle) if straight else sweeps[1] / bend
    if between < SHORTEST or max(-sweeps[0], sweeps[2]) > MAX_SWEEP:
        return None
    connection: Curve = Line(start=_pair(middle), stop=_pair(goal))
    if not straight:
        connection = _arc(middle, leaving, 1 / bend, sweeps[1])
    right, left = _arc(start, setting_out, -first, sweeps[0]), _arc(goal, joining, second, sweeps[2])
    path = Composite((before, right, connection, left, after))
    length = late - first * sweeps[0] + between + second * sweeps[2] + early
    return Turn(path=path, length=length, radii=(first, second), bend=bend, sweeps=sweeps)


def _headings(between: complex, first: float, second: float, bend: float) -> tuple[complex, complex] | None:
    """Directions where the middle piece begins and ends, if the second circle's centre lies `between` from the first's.

    The middle of a bent piece is 1 / bend to its left. So it is first + 1 / bend away from the one centre, and
    1 / bend - second from the other: two sides of a triangle whose third is known.
    """
    distance = abs(between)
    if abs(bend) < STRAIGHT:
        sine = (first + second) / distance
        if sine >= 1:
            return None
        heading = between / distance * complex(math.sqrt(1 - sine**2), -sine)
        return heading, heading
    one, other = first + 1 / bend, 1 / bend - second
    cosine = (one**2 + distance**2 - other**2) / (2 * one * distance)
    if not abs(cosine) < 1:
        return None
    # Of both triangles the one whose middle piece leads from the first circle towards the second.
    ways = []
    for side in (1, -1):
        left = between / distance * complex(cosine, side * math.sqrt(1 - cosine**2))
        left_after = (one * left - between) / other
        ways.append((left / 1j, left_after / 1j))
    return max(ways, key=lambda way: (way[0] * between.conjugate()).real)


def _arc(start: complex, direction: complex, radius: float, sweep: float) -> Arc:
    """Arc from a point on; its `radius` is positive to the left, as its sweep."""
    left = 1j * direction * radius
    return Arc(centre=_pair(start + left), radius=abs(radius), begin_angle=cmath.phase(-left), sweep=sweep)


def _angle(direction: complex, other: complex) -> float:
    """Angle by which one turns to the left from a direction to another, rad, from 0 to a whole turn."""
    return cmath.phase(other / direction) % (2 * math.pi)


def _complex(vector: Array) -> complex:
    return complex(*vector.tolist())


def _pair(point: complex) -> tuple[float, float]:
    return point.real, point.imag
