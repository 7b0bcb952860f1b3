"""The Archimedean spiral r = k theta (paper, eq. 2-13), travelled inward or outward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex, as_complex, as_vectors
from pymunk_dragon._checks import finite, instance, numbers, positive
from pymunk_dragon.model.curves.base import PackageCurve, within_reach

# m. No bench fits into a narrower turn.
_MIN_PITCH = 0.001
# m. No dance floor has a wider turn.
MAX_PITCH = 1000.0
# rad in a turn.
_TURN = 2 * np.pi
# A thousand turns of the contest's pitch are a dance floor of a kilometre; more is taken for a
# typing error.
_MAX_TURNS = 1000.0
# Passes of Halley's method: it needs 2.
_MAX_PASSES = 20
# Share of an angle: after such a step of Halley's method, which trebles the digits, the next is
# below the last one.
_HALLEY_TOLERANCE = 5e-6
# Twice the arc length over k from which the angle is estimated by its asymptotic form; it is right
# to 2 % there.
_FAR_OUT = 8.0


@dataclass(frozen=True, kw_only=True)
class Spiral(PackageCurve, kind="spiral"):
    """Archimedean spiral about the origin.

    The coordinate is the arc length from the centre, negative if inward.

    Parameters
    ----------
    pitch : float
        Radial distance between turns, m, from 0.001 to 1000.
    rotation : float
        Angle by which the spiral is turned about the origin, counter-clockwise, rad, from -1000 to
        1000. At 0 it leaves the centre along the x axis.
    outward : bool
        Whether it is travelled from the centre out; the paper's goes in.

    Examples
    --------
    >>> Spiral().point(Spiral().at_turn(16)).round(6).tolist()
    [8.8, -0.0]
    """

    # On the reference scenario's spiral, the point (8.8, 0) m.
    default_turns = 16.0
    flags: ClassVar = {"pitch": "Distance between the turns of the spiral, m."}

    pitch: float = 0.55
    rotation: float = 0.0
    outward: bool = False

    def __post_init__(self) -> None:
        pitch = finite("pitch", self.pitch, _MIN_PITCH, MAX_PITCH, "m")
        rotation = finite("rotation", self.rotation, -1000.0, 1000.0, "rad")
        self._set(pitch=pitch, rotation=rotation)
        instance("outward", self.outward, bool, "True or False")
        begin_s, end_s = (0.0, np.inf) if self.outward else (-np.inf, 0.0)
        # The normal at the polar angle theta passes the origin at k theta / sqrt(theta^2 + 1).
        self._set(begin_s=begin_s, end_s=end_s, turn_width=pitch, normal_offset=self.k)

    @property
    def k(self) -> float:
        """Metres of radius per radian (eq. 2)."""
        return self.pitch / _TURN

    @property
    def _sign(self) -> int:
        """1 if the angle grows in the direction of travel, otherwise -1."""
        return 1 if self.outward else -1

    def turns(self, s: float) -> float:
        """Number of turns from the centre at the coordinate `s` m."""
        theta = self.angle(finite("s", s, -np.inf, np.inf, "m"))
        return float(theta) / _TURN

    def at_turn(self, turns: float) -> float:
        """Coordinate `turns` turns from the centre, m; `turns` is above 0 and at most 1000."""
        theta = _TURN * positive("turns", turns, _MAX_TURNS, "")
        return float(self._coordinate(np.array(self._sign * theta)))

    def at_radius(self, radius: float) -> float:
        """Coordinate at the distance `radius` m from the centre, m, at most 1000 pitches."""
        radius = positive("radius", radius, _MAX_TURNS * self.pitch, "m")
        return self.at_turn(min(radius / self.pitch, _MAX_TURNS))

    def angle(self, s: ArrayLike) -> Array:
        """Polar angle theta in rad, counted from the centre along the winding (eq. 6).

        It is nan beyond the centre.
        """
        length = np.atleast_1d(self._sign * within_reach(numbers("s", s)))
        # Twice the arc length over k: theta sqrt(theta^2 + 1) + arcsinh theta (eq. 3-5).
        target = np.maximum(length, 0.0) * (2 / self.k)
        # The asymptotic form theta^2 = target - log(4 theta^2) / 2 - 1 / 2 - ..., or the tangent at
        # the centre.
        far = np.maximum(target, _FAR_OUT)
        square = far - 0.5 - np.log(4 * far - 2 * np.log(4 * far) - 2) / 2
        theta = np.where(target > _FAR_OUT, np.sqrt(square), target / 2)

        for _ in range(_MAX_PASSES):
            rise = _rise(theta)
            newton = (theta + (np.log(theta + rise) - target) / rise) / 2
            # Halley's method; the derivative of `rise` is theta / rise.
            step = newton / (1 - theta * newton / (2 * rise**2))
            theta = np.maximum(theta - step, 0.0)
            if np.all(np.abs(step) <= _HALLEY_TOLERANCE * theta + 1e-10):
                break
        return np.where(length >= 0, theta, np.nan).reshape(np.shape(s))

    def _frame(self, s: Array) -> tuple[Array, Array]:
        points, derivatives = self._motion(self._parameter(s))
        derivatives *= 1 / np.abs(derivatives)
        return as_vectors(points), as_vectors(derivatives)

    def _curvature(self, s: Array) -> Array:
        rise = _rise(self.angle(s))
        return self._sign * (rise + 1 / rise) / (self.k * rise**2)

    def _max_curvature(self, lower: Array, upper: Array) -> Array:
        """The curvature at the inner end: it decreases outward."""
        return np.abs(self._curvature(lower if self.outward else upper))

    def _foot(self, xy: Array, s: Array) -> tuple[Array, Array, Array]:
        """Feet at the polar angles of points: a division replaces four sines."""
        z = _turned(as_complex(xy), -self.rotation)
        theta = np.arctan2(z.imag, z.real)
        # The angle at `near` to a few hundredths, except on the innermost turn: enough to identify
        # the turn.
        turns = np.rint((np.sqrt(2 / self.k * np.abs(s)) - theta) / _TURN)
        theta = theta + _TURN * turns

        rise = _rise(theta)
        coordinate = self._arc_length(theta, rise)
        radius = np.abs(z)
        # The tangent on the way out is z (1 + i theta) / (radius rise).
        ahead = z * (1 + 1j * theta) * (self._sign / (radius * rise))
        feet = _turned(z * (self.k * theta / radius), self.rotation)
        return coordinate, as_vectors(feet), as_vectors(_turned(ahead, self.rotation))

    def _parameter(self, s: Array) -> Array:
        """Polar angles (...), negative on an inward spiral (eq. 10, 12, 13)."""
        return self._sign * self.angle(s)

    def _coordinate(self, parameter: Array) -> Array:
        theta = self._sign * parameter
        return self._arc_length(theta, _rise(theta))

    def _arc_length(self, theta: Array, rise: Array) -> Array:
        """Coordinate of a polar angle, m (eq. 3-5); a logarithm costs less than its arcsinh."""
        return (np.log(theta + rise) + theta * rise) * (self._sign * self.k / 2)

    def _estimate(self, heads: Array, parameters: Array, spacings: Array) -> Array:
        """Estimated parameters (H, T), as on any curve.

        Where M is the mean square of the angles of two handles, and c the spacing over k, the
        square grows by 4 sqrt(M) arcsin x from one to the other, with x^2 = c^2 / 4 (M - 1) / M^2.
        M grows by nearly 2 c.
        """
        if self.outward:
            return super()._estimate(heads, parameters, spacings)
        chords = spacings / self.k
        squares = np.empty((spacings.size + 1, heads.size))
        squares[0] = parameters**2

        # 1 / M.
        middles = 2 * np.cumsum(chords, axis=0) - chords
        growth = 1 / (squares[0] + middles)
        sine = np.minimum(chords**2 / 4 * growth, 1.0)

        # The series of arcsin x / x, and the root of (M - 1) / M.
        growth = (1 - growth / 2) * (1 + sine * (1 / 6 + sine * (3 / 40)))

        np.cumsum(2 * chords * growth, axis=0, out=squares[1:])
        squares[1:] += squares[0]
        estimate: Array = -np.sqrt(squares, out=squares)
        estimate[0] = parameters
        return estimate

    def _motion(self, parameter: Array) -> tuple[Complex, Complex]:
        """Eq. 7, 8 and 11."""
        derivatives = _unit_vector(parameter * (self._sign / 2))
        derivatives *= self._sign * self.k
        points = parameter * derivatives
        derivatives += self._sign * 1j * points
        return _turned(points, self.rotation), _turned(derivatives, self.rotation)


def _turned(vectors: Complex, angle: float) -> Complex:
    """Vectors (...) of the plane, turned by an angle."""
    return vectors * np.exp(1j * angle) if angle else vectors


def _rise(theta: Array) -> Array:
    """Arc length over k per radian. Angles are far too small for their squares to overflow."""
    return np.sqrt(theta * theta + 1)


def _unit_vector(half: Array) -> Complex:
    """e^(2i half), from the tangent: several times as fast in NumPy as sine and cosine."""
    tangent = np.tan(half)
    share = tangent * tangent
    share += 1
    share = 2 / share
    direction = np.empty(half.shape, dtype=complex)
    np.subtract(share, 1, out=direction.real)
    np.multiply(share, tangent, out=direction.imag)
    return direction
