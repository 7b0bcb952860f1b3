"""The Archimedean spiral r = k theta (paper, eq. 2-13), travelled inward or outward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, Flags, as_complex, as_vectors
from pymunk_dragon._checks import finite, positive
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model import chain
from pymunk_dragon.model.curves._unit_spiral import (
    MAX_PASSES,
    STEP_TOLERANCE,
    arc_rate,
    estimated_angle,
    first_reached,
    squared_distance,
    unit_vector,
)
from pymunk_dragon.model.curves.base import Curve

__all__ = ["Spiral"]


# m. No bench fits into a narrower turn.
MIN_PITCH = 0.001
# m. No dance floor has a wider turn. Both bounds also keep squares of lengths far from the ends of a double.
MAX_PITCH = 1000.0
# rad.
TURN = 2 * np.pi
# A thousand turns of the contest's pitch are a dance floor of a kilometre; more is taken for a typing error.
MAX_TURNS = 1000.0
# Most benches need 2; what needs more than this is better kept within a bracket.
FREE_PASSES = 6
# The same for Halley's, which trebles the digits.
HALLEY_TOLERANCE = 5e-6
# Spacings over k between which a rear handle may vanish near the centre and exist again further in: from m(theta*) to
# 2 pi, and by rounding a little more (see `chain_follows_motion`).
INNERMOST = 5.78, 6.29


@dataclass(frozen=True, kw_only=True)
class Spiral(Curve, kind="spiral"):
    """Archimedean spiral about the origin; the coordinate is the arc length from the centre, negative if inward.

    Parameters
    ----------
    pitch : float
        Radial distance between turns, m.
    rotation : float
        Angle by which the spiral is turned about the origin, counter-clockwise, rad. At 0 it leaves the centre along
        the x axis.
    mirrored : bool
        Whether it winds clockwise outward; the paper's winds clockwise inward. It is mirrored in the x
        axis first and turned then.
    outward : bool
        Whether it is travelled from the centre out; the paper's goes in.

    Raises
    ------
    ParameterError
        If `pitch` is not a number from 0.001 to 1000 m, or `rotation` not one from -1000 to 1000 rad.

    Examples
    --------
    >>> Spiral().point(Spiral().at_turn(16)).round(6).tolist()
    [8.8, -0.0]
    """

    # On the reference scenario's spiral, the point (8.8, 0) m.
    default_turns = 16.0
    flags: ClassVar = {"pitch": ("M", "Distance between the turns of the spiral, m.")}

    pitch: float = 0.55
    rotation: float = 0.0
    mirrored: bool = False
    outward: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "pitch", finite("pitch", self.pitch, MIN_PITCH, MAX_PITCH, "m"))
        object.__setattr__(self, "rotation", finite("rotation", self.rotation, -1000.0, 1000.0, "rad"))
        for name in ("mirrored", "outward"):
            if not isinstance(getattr(self, name), bool):
                raise ParameterError(name, getattr(self, name), "True or False")

    @property
    def k(self) -> float:
        """Metres of radius per radian (eq. 2)."""
        return self.pitch / TURN

    @property
    def begin_s(self) -> float:
        """The centre, 0 m, of an outward spiral; -inf for an inward one."""
        return 0.0 if self.outward else -np.inf

    @property
    def end_s(self) -> float:
        """The centre, 0 m, of an inward spiral; inf for an outward one."""
        return np.inf if self.outward else 0.0

    @property
    def turn_width(self) -> float:
        """The pitch, m."""
        return self.pitch

    @property
    def inward(self) -> bool:
        """Whether the spiral is travelled inward."""
        return not self.outward

    @property
    def _sign(self) -> int:
        """1 if the angle grows in the direction of travel, otherwise -1."""
        return 1 if self.outward else -1

    def turns(self, s: float) -> float:
        """Number of turns from the centre at the coordinate `s` m."""
        return float(self.angle(s)) / TURN

    def at_turn(self, turns: float) -> float:
        """Coordinate `turns` turns from the centre, m.

        Raises
        ------
        ParameterError
            If `turns` is not a number above 0 and at most 1000.
        """
        return self._at_angle(TURN * positive("turns", turns, MAX_TURNS, ""))

    def at_radius(self, radius: float) -> float:
        """Coordinate at the distance `radius` m from the centre, m.

        Raises
        ------
        ParameterError
            If `radius` is not a number above 0 and at most 1000 pitches.
        """
        return self._at_angle(positive("radius", radius, MAX_TURNS * self.pitch, "m") / self.k)

    def angle(self, s: ArrayLike) -> Array:
        """Polar angle theta in rad, counted from the centre along the winding (eq. 6); nan beyond the centre."""
        length = np.atleast_1d(self._length(s))
        # Twice the arc length over k: theta sqrt(theta^2 + 1) + arcsinh theta (eq. 3-5).
        target = np.maximum(length, 0.0) * (2 / self.k)
        theta = estimated_angle(target)
        for _ in range(MAX_PASSES):
            rise = arc_rate(theta)
            newton = theta + rise
            np.log(newton, out=newton)
            newton -= target
            newton /= rise
            newton += theta
            newton /= 2
            # Halley's method; the derivative of `rise` is theta / rise.
            rise *= rise
            np.divide(theta, rise, out=rise)
            rise *= newton
            rise /= -2
            rise += 1
            newton /= rise
            theta -= newton
            np.maximum(theta, 0.0, out=theta)
            if np.all(np.abs(newton, out=newton) <= HALLEY_TOLERANCE * theta + STEP_TOLERANCE):
                break
        beyond = ~(length >= 0)
        if beyond.any():
            theta[beyond] = np.nan
        return theta.reshape(np.shape(s))

    def speeds_by_difference(self, now: Array, later: Array, step: float) -> Array:
        """Speeds (...), m/s, of handles at `now`, and at `later` after `step` s, from their polar angles (eq. 15)."""
        theta = self.angle(now)
        speeds: Array = self.k * arc_rate(theta) * np.abs(self.angle(later) - theta) / step
        return speeds

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 2) in m (eq. 7, 8, 11)."""
        theta = self.angle(s)
        return as_vectors(self._placed(self.k * theta * unit_vector(theta)))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector (..., 2) in the direction of travel."""
        # Not self.frame: a derived class may have one that calls this method.
        return Spiral.frame(self, s)[1]

    def frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions and unit vectors in the direction of travel, each (..., 2)."""
        theta = self.angle(s)
        direction = unit_vector(theta)
        points, tangents = self.k * theta * direction, self._tangent(theta, direction, arc_rate(theta))
        return as_vectors(self._placed(points)), as_vectors(self._placed(tangents))

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) in 1/m, positive to the left: the paper's spiral curves to the right."""
        return np.asarray(self._curvature_at(self.angle(s)) * (1 if self.outward != self.mirrored else -1))

    def max_curvature(self, s: ArrayLike, other: ArrayLike) -> Array:
        """Curvature at the inner one of two coordinates, 1/m: it decreases outward."""
        length, other_length = self._length(s), self._length(other)
        nearest = np.maximum(np.minimum(length, other_length), 0.0)
        curvatures = self._curvature_at(self.angle(nearest if self.outward else -nearest))
        return np.where(np.maximum(length, other_length) < 0, 0.0, curvatures)

    def parameter(self, s: Array) -> Array:
        """Polar angles (...), negative on an inward spiral, in which `chain` computes (eq. 10, 12, 13)."""
        return self._sign * self.angle(s)

    def coordinate(self, parameter: Array) -> Array:
        """Coordinates (...) of parameters, m."""
        return self._sign * self.arc(self._sign * parameter)

    def estimate(self, heads: Array, spacings: Array) -> Array:
        """Estimated parameters (T, H) of chains: each arc is as long as on a circle of the spiral's radius there."""
        if self.outward:
            return super().estimate(heads, spacings)
        length = np.concatenate([[0.0], np.cumsum(spacings)]) - heads[:, None]
        # The radius is nearly the root of 2 k times the arc length.
        curvature = 1 / np.sqrt(self.k * (length[:, 1:] + length[:, :-1]))
        length[:, 1:] = np.cumsum(chain.arcs(spacings, curvature), axis=1) - heads[:, None]
        length *= 2 / self.k
        parameters = -estimated_angle(length)
        parameters[:, 0] = self.parameter(heads)
        return parameters

    def motion(self, parameter: Array) -> tuple[Complex, Complex]:
        """Positions and their derivatives by the parameter, each (...), as complex numbers."""
        derivatives = unit_vector(self._sign * parameter)
        derivatives *= self._sign * self.k
        points = parameter * derivatives
        derivatives += self._sign * 1j * points
        return self._placed(points), self._placed(derivatives)

    def nearest(self, parameters: Array, handles_s: Array, spacings: Array) -> Flags:
        """Whether each handle of chains (T,), with parameters and coordinates (T, H), is the nearest one back.

        On an inward spiral the distance grows over half a turn back: every term of its growth is positive.
        """
        if self.outward:
            return super().nearest(parameters, handles_s, spacings)
        back = parameters[:, :-1] - parameters[:, 1:]
        within: Flags = (back > 0) & (back < np.pi)
        return np.asarray(within.all(axis=1))

    def behind(self, parameter: Array, chord: float) -> Array:
        """Parameters (T,) of the nearest points back along the path at the straight distance `chord` m; nan if none.

        On an inward spiral the distance grows along the path up to its first maximum, a little over half a turn back.
        Up to there the nearest intersection is the only one. Further back the bench would lie across the spiral with
        its end on another turn, which no motion of the chain leads to: then the result is nan. It is nan also if the
        distance grows over a whole turn, as close to the centre, and is still too short at its end.
        """
        if self.outward:
            return super().behind(parameter, chord)
        theta, reach = -parameter, (chord / self.k) ** 2
        # The chord of a circle with the radius that the spiral has halfway, to third order.
        phi = chord / (self.k * arc_rate(theta + chord / (2 * self.k * arc_rate(theta))))
        phi += phi**3 / 24
        with np.errstate(all="ignore"):
            for _ in range(FREE_PASSES):
                value, growth = squared_distance(phi, theta)
                step = (value - reach) / growth
                phi = phi - step
                settled = np.abs(step) <= STEP_TOLERANCE * phi
                if settled.all():
                    break
            # Every term of the growth is positive up to half a turn back, so a root that Newton's method finds there is
            # the only one.
            found = settled & (phi < np.pi)
        missed = ~(found | np.isnan(theta))
        if missed.any():
            phi[missed] = first_reached(theta[missed], reach)
        return -(theta + phi)

    def chain_follows_motion(self, spacings: Array) -> bool:
        """Whether `chain` always finds the state to which continuous motion leads, for spacings (N,) in m.

        Let D be the distance over k between the points at the angles theta and theta + x, and G = d(D^2)/dx / 2. Then
        G = x + theta (1 - cos x) + theta (theta + x) sin x, and G > 0 for 0 < x <= pi. For pi < x < 2 pi, G = 0 means
        cos x / (theta + x) - sin x = 1 / theta. The left side is below the right one at both ends of this interval, and
        has one maximum in it, where tan x = -(theta + x) - 1 / (theta + x). The maximum lies beyond 3 pi / 2, where
        theta times the left side grows with theta. So there is one angle theta* = 0.98577 above which D has one maximum
        m(theta) within a turn, and below which D grows over the whole turn, to 2 pi. By the envelope theorem m grows
        with theta: dm^2/dtheta = 2 (2 theta + x) (1 - cos x) > 0; and m(theta*) = 5.78357.

        `behind` finds the x < 2 pi up to which D grows to the spacing over k. So where theta falls, a spacing of at
        most 5.78 k always has its rear handle, one above 2 pi k loses it for good, at the fold, where m(theta) is the
        spacing; only one in between may lose it and have another one further in. As m grows outward, a bench that is no
        longer than the one before it loses its rear handle no earlier.
        """
        chords = spacings / self.k
        between = (chords > INNERMOST[0]) & (chords < INNERMOST[1])
        return not self.outward and bool(np.all(np.diff(chords) <= 0) and not between.any())

    def foot(self, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
        """Feet of `points` (..., 2) on the turns nearest to the coordinates `near`: coordinates, points, tangents.

        The foot is at the polar angle of the point, so one division replaces four sines. Guides call this at every
        substep, and most of its time is NumPy's for each call: so there are few of them, in place.
        """
        z = self._unplaced(as_complex(np.asarray(points, dtype=float)))
        theta = np.arctan2(z.imag, z.real)
        # The angle at `near` to a few hundredths, except on the innermost turn: enough to identify the turn.
        turns = np.sqrt(2 / self.k * np.abs(near))
        turns -= theta
        turns *= 1 / TURN
        theta = theta + TURN * np.rint(turns)
        rise = arc_rate(theta)
        # The arc length of eq. 3-5; a logarithm costs less than its arcsinh.
        coordinate = np.log(theta + rise)
        coordinate += theta * rise
        coordinate *= self._sign * self.k / 2
        radius = np.abs(z)
        # As in `_tangent`, from a vector of length `radius`.
        rise *= radius
        ahead = np.empty(theta.shape, dtype=complex)
        np.divide(self._sign, rise, out=ahead.real)
        np.multiply(theta, ahead.real, out=ahead.imag)
        ahead *= z
        theta *= self.k
        theta /= radius
        return coordinate, as_vectors(self._placed(theta * z)), as_vectors(self._placed(ahead))

    def _length(self, s: ArrayLike) -> Array:
        """Arc length from the centre, m; negative beyond it."""
        length = np.asarray(s, dtype=float)
        return length if self.outward else -length

    def _at_angle(self, theta: float) -> float:
        length = float(self.arc(np.asarray(theta)))
        return length if self.outward else -length

    def arc(self, theta: Array) -> Array:
        """Arc length from the centre, m: the closed form of eq. 3-5."""
        length: Array = self.k / 2 * (theta * arc_rate(theta) + np.arcsinh(theta))
        return length

    def _curvature_at(self, theta: Array) -> Array:
        rise = arc_rate(theta)
        curvature: Array = (rise + 1 / rise) / (self.k * rise**2)
        return curvature

    def _tangent(self, theta: Array, direction: Complex, rise: Array) -> Complex:
        """Tangents before the spiral is mirrored and turned, where `direction` points away from the centre.

        The spiral goes `rise` times k for each radian.
        """
        ahead = np.empty(theta.shape, dtype=complex)
        ahead.real = (1 if self.outward else -1) / rise
        ahead.imag = theta * ahead.real
        ahead *= direction
        return ahead

    def _placed(self, vectors: Complex) -> Complex:
        """Vectors (...) of the plane, from those of a spiral that is neither mirrored nor turned."""
        if self.mirrored:
            vectors = vectors.conj()
        if self.rotation:
            vectors = vectors * np.exp(1j * self.rotation)
        return vectors

    def _unplaced(self, vectors: Complex) -> Complex:
        """The inverse of `_placed`."""
        if self.rotation:
            vectors = vectors * np.exp(-1j * self.rotation)
        return vectors.conj() if self.mirrored else vectors
