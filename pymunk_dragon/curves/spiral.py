"""The Archimedean spiral r = k theta, travelled inward and clockwise (paper, eq. 2-13)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon.checks import finite
from pymunk_dragon.curves.base import Array

__all__ = ["Spiral"]

# Metres. A turn wider than this is no dance floor, and no bench fits into a narrower one; the bounds also keep squares
# of lengths far from the ends of a double.
MIN_PITCH, MAX_PITCH = 0.001, 1000.0
TURN = 2 * np.pi
# Newton doubles its digits at every pass and reaches a double's last one in about 6; bisection, its fallback, in 53.
MAX_PASSES = 80
# Most benches need 2; what needs more than this is better kept within a bracket.
FREE_PASSES = 6
# Share of an angle: after so small a step of Newton's the next one would be below the last digit.
SETTLED = 1e-10


@dataclass(frozen=True, kw_only=True)
class Spiral:
    """Archimedean spiral about the origin; its parameter ``u`` is the polar angle theta in rad, which falls on the way.

    Parameters
    ----------
    pitch : float
        Radial distance between turns, m.

    Raises
    ------
    ParameterError
        If `pitch` is not a number from 0.001 to 1000 m.
    """

    pitch: float = 0.55

    def __post_init__(self) -> None:
        object.__setattr__(self, "pitch", finite("pitch", self.pitch, MIN_PITCH, MAX_PITCH, "m"))

    @property
    def k(self) -> float:
        """Metres of radius per radian (eq. 2)."""
        return self.pitch / (2 * np.pi)

    @property
    def turn_distance(self) -> float:
        """Distance between neighbouring turns: the pitch, m."""
        return self.pitch

    def start(self, turns: float) -> float:
        """Polar angle after `turns` whole turns from the centre, rad."""
        return 2 * np.pi * turns

    def remaining(self, u: ArrayLike) -> Array:
        """Arc length from the centre, m: the closed form of eq. 3-5."""
        theta = np.asarray(u, dtype=float)
        length: Array = self.k / 2 * (theta * np.hypot(theta, 1) + np.arcsinh(theta))
        return length

    def advance(self, u: ArrayLike, distance: ArrayLike) -> Array:
        """Polar angle `distance` m further inward (eq. 6); nan beyond the centre."""
        s = np.asarray(self.remaining(u) - np.asarray(distance, dtype=float))
        valid = s >= 0
        s = np.where(valid, s, 0.0)
        # Both are upper bounds, and s(theta) is convex: Newton comes down from them without ever passing the root.
        theta = np.minimum(np.sqrt(2 * s / self.k), s / self.k)
        for _ in range(MAX_PASSES):
            step = (self.remaining(theta) - s) / self.stretch(theta)
            theta = np.maximum(theta - step, 0.0)
            if np.all(np.abs(step) <= 4 * np.spacing(theta + 1)):
                break
        return np.where(valid, theta, np.nan)

    def behind(self, u: ArrayLike, chord: float) -> Array:
        """Polar angle of the nearest point back along the spiral at straight distance `chord` (eq. 10, 12, 13).

        The distance grows along the path up to its first maximum, a little over half a turn back. Up to there the
        nearest intersection is the only one. Further back the bench would lie across the spiral with its end on
        another turn, a place that no motion of the chain leads to: then the answer is nan. So it is where a distance
        that grows all the way round, as it does close to the centre, is still too short after one whole turn.
        """
        theta = np.asarray(u, dtype=float)
        flat = theta.ravel()
        reach = (chord / self.k) ** 2
        # The chord of a circle with the radius that the spiral has halfway, to third order.
        phi = chord / self.stretch(flat + chord / (2 * self.stretch(flat)))
        phi += phi**3 / 24
        with np.errstate(all="ignore"):
            for _ in range(FREE_PASSES):
                value, growth = _squared_distance(phi, flat)
                step = (value - reach) / growth
                phi = phi - step
                settled = np.abs(step) <= SETTLED * phi
                if settled.all():
                    break
            # Every term of the growth is positive up to half a turn back, so what Newton finds there is the only place.
            found = settled & (phi < np.pi)
        missed = ~(found | np.isnan(flat))
        if missed.any():
            phi[missed] = _first_reached(flat[missed], reach)
        return (flat + phi).reshape(theta.shape)

    def foot(self, points: ArrayLike, near: ArrayLike) -> tuple[Array, Array, Array]:
        """Polar angle of each of `points` on the turn nearest to `near`, with the point and tangent there.

        The foot has the bearing of the point, so one division replaces four sines: rails ask for it at every substep.
        """
        xy = np.ascontiguousarray(points, dtype=float)
        z = xy.view(complex)
        bearing = np.arctan2(z.imag, z.real)
        turns = np.rint((np.asarray(near, dtype=float)[..., None] - bearing) / TURN)
        theta = bearing + TURN * turns
        outward = z / np.abs(z)
        tangents = np.empty_like(z)
        tangents.real, tangents.imag = -1.0, -theta
        tangents *= outward
        tangents /= np.hypot(theta, 1)
        outward *= self.k * theta
        return theta[..., 0], outward.view(float), tangents.view(float)

    def point(self, u: ArrayLike) -> Array:
        """Position (..., 2) in m (eq. 7, 8, 11)."""
        theta = np.asarray(u, dtype=float)
        unit: Array = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
        return self.k * theta[..., None] * unit

    def tangent(self, u: ArrayLike) -> Array:
        """Unit vector (..., 2) inward along the spiral."""
        theta = np.asarray(u, dtype=float)
        cos, sin = np.cos(theta), np.sin(theta)
        inward: Array = np.stack([theta * sin - cos, -sin - theta * cos], axis=-1)
        inward /= np.hypot(theta, 1)[..., None]
        return inward

    def stretch(self, u: ArrayLike) -> Array:
        """Metres of arc per radian (eq. 3)."""
        metres: Array = self.k * np.hypot(u, 1)
        return metres

    def sharpest(self, u: ArrayLike, v: ArrayLike) -> Array:
        """Curvature in 1/m of whichever place is further in: it falls on the way out."""
        square = np.minimum(u, v) ** 2
        curvature: Array = (square + 2) / (self.k * (square + 1) ** 1.5)
        return curvature


def _squared_distance(phi: Array, theta: Array) -> tuple[Array, Array]:
    """|P(theta + phi) - P(theta)|^2 / k^2, in a form without cancellation for small phi, and its growth with phi."""
    sine = np.sin(phi / 2)
    product = 2 * theta * (theta + phi)
    turned = 2 * sine**2
    return phi**2 + product * turned, 2 * phi + 2 * theta * turned + product * np.sin(phi)


def _growth(phi: Array, theta: Array) -> Array:
    return _squared_distance(phi, theta)[1]


def _first_reached(theta: Array, reach: float) -> Array:
    """How far back, in rad, the squared distance over k^2 first is `reach`, by Newton within a bracket; else nan."""
    limit = np.full(theta.shape, np.pi)
    beyond = _squared_distance(limit, theta)[0] < reach
    if beyond.any():
        limit[beyond] = _first_maximum(theta[beyond])
        beyond = _squared_distance(limit, theta)[0] < reach
    low, high = np.zeros(theta.shape), limit
    phi = limit / 2
    for _ in range(MAX_PASSES):
        value, growth = _squared_distance(phi, theta)
        short = value < reach
        low, high = np.where(short, phi, low), np.where(short, high, phi)
        with np.errstate(divide="ignore", invalid="ignore"):
            better = phi - (value - reach) / growth
        # A step that leaves the bracket (or is nan, where the distance has its maximum) becomes a bisection.
        better = np.where((better >= low) & (better <= high), better, (low + high) / 2)
        done = np.abs(better - phi) <= 2 * np.spacing(theta + phi)
        phi = better
        if np.all(done | beyond):
            break
    return np.where(beyond, np.nan, phi)


def _first_maximum(theta: Array) -> Array:
    """How far back, in rad, the straight distance from `theta` keeps growing: to its first maximum or one turn."""
    # Past 3 pi / 2 the growth is convex. At 3 pi / 2 itself it has the sign of 1 - theta: more than one radian from
    # the centre the maximum lies before. Closer than that the spiral opens nearly as fast as it turns: from 0.986 rad
    # to 1 rad the distance still falls for a moment, about where its growth is least, and below that it never does.
    high = np.full(theta.shape, 1.5 * np.pi)
    central = theta <= 1
    if central.any():
        high[central] = _least_growth(theta[central])
    low = np.full(theta.shape, np.pi)
    endless = _growth(high, theta) > 0
    for _ in range(MAX_PASSES):
        middle = (low + high) / 2
        rising = _growth(middle, theta) > 0
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    return np.where(endless, 2 * np.pi, low)


def _least_growth(theta: Array) -> Array:
    """Where in the last quarter of the first turn back, in rad, the distance from `theta` grows least."""
    low, high = np.full(theta.shape, 1.5 * np.pi), np.full(theta.shape, 2 * np.pi)
    for _ in range(MAX_PASSES):
        phi = (low + high) / 2
        # Half the derivative of `_growth`.
        falling = 1 + 2 * theta * np.sin(phi) + theta * (theta + phi) * np.cos(phi) < 0
        low, high = np.where(falling, phi, low), np.where(falling, high, phi)
    return low
