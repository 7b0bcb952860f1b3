"""The spiral r = theta: arc length, distances between its points, and equations for its angles.

`Spiral` scales it by k.
"""

from __future__ import annotations

import numpy as np

from pymunk_dragon._arrays import Array, Complex

# Newton doubles its digits at every pass and reaches a double's last one in about 6; bisection, its fallback, in 53.
MAX_PASSES = 80
# Share of an angle: after so small a step of Newton's the next one would be below the last digit.
STEP_TOLERANCE = 1e-10
# Last digits by which rounding may change the square of a distance: five operations, of which the sine has two.
ROUNDED_SQUARE = 8
# Twice the arc length from which the angle is estimated by its asymptotic form; it is right to 2 % there.
FAR_OUT = 8.0


def squared_distance(phi: Array, theta: Array) -> tuple[Array, Array]:
    """|P(theta + phi) - P(theta)|^2, in a form without cancellation for small phi, and its growth with phi."""
    sine = np.sin(phi / 2)
    product = 2 * theta * (theta + phi)
    turned = 2 * sine**2
    return phi**2 + product * turned, 2 * phi + 2 * theta * turned + product * np.sin(phi)


def _growth(phi: Array, theta: Array) -> Array:
    return squared_distance(phi, theta)[1]


def _growth_rate(phi: Array, theta: Array) -> Array:
    """Half the derivative of `_growth` by phi."""
    rate: Array = 1 + 2 * theta * np.sin(phi) + theta * (theta + phi) * np.cos(phi)
    return rate


def first_reached(theta: Array, reach: float) -> Array:
    """How far back, in rad, the squared distance first is `reach`, by Newton within a bracket; else nan."""
    limit = np.full(theta.shape, np.pi)
    beyond = squared_distance(limit, theta)[0] < reach
    if beyond.any():
        limit[beyond] = _first_maximum(theta[beyond])
        beyond = squared_distance(limit, theta)[0] < reach
    low, high = np.zeros(theta.shape), limit
    phi = limit / 2
    for _ in range(MAX_PASSES):
        value, growth = squared_distance(phi, theta)
        short = value < reach
        low, high = np.where(short, phi, low), np.where(short, high, phi)
        with np.errstate(divide="ignore", invalid="ignore"):
            better = phi - (value - reach) / growth
        # A step that leaves the bracket (or is nan, where the distance has its maximum) becomes a bisection.
        better = np.where((better >= low) & (better <= high), better, (low + high) / 2)
        # Close to the maximum, where the growth is small, the rounding of the distance moves the root.
        rounding = growth * 2 * np.spacing(theta + phi) + ROUNDED_SQUARE * np.spacing(reach)
        done = np.abs(better - phi) * growth <= rounding
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
    middle = (low + high) / 2
    for _ in range(MAX_PASSES):
        growth = _growth(middle, theta)
        low, high = np.where(growth > 0, middle, low), np.where(growth > 0, high, middle)
        newton = middle - growth / (2 * _growth_rate(middle, theta))
        better = np.where((newton >= low) & (newton <= high), newton, (low + high) / 2)
        done = np.abs(better - middle) <= STEP_TOLERANCE
        middle = better
        if np.all(done | endless):
            break
    return np.where(endless, 2 * np.pi, middle)


def _least_growth(theta: Array) -> Array:
    """Where in the last quarter of the first turn back, in rad, the distance from `theta` grows least."""
    low, high = np.full(theta.shape, 1.5 * np.pi), np.full(theta.shape, 2 * np.pi)
    for _ in range(MAX_PASSES):
        phi = (low + high) / 2
        falling = _growth_rate(phi, theta) < 0
        low, high = np.where(falling, phi, low), np.where(falling, high, phi)
    return low


def estimated_angle(target: Array) -> Array:
    """Angle by twice its arc length: by two terms of the asymptotic form, or by the tangent at the centre."""
    # theta^2 = target - log(4 theta^2) / 2 - 1 / 2 - ..., used twice.
    far = np.maximum(target, FAR_OUT)
    logs = np.log(4 * far)
    logs *= -2
    logs -= 2
    logs += 4 * far
    np.log(logs, out=logs)
    logs /= 2
    far -= logs
    far -= 0.5
    theta = np.sqrt(far, out=far)
    near = target <= FAR_OUT
    if near.any():
        theta[near] = target[near] / 2
    return theta


def arc_rate(theta: Array) -> Array:
    """Arc length per radian. Angles are far too small for their squares to overflow."""
    rate: Array = np.sqrt(theta * theta + 1)
    return rate


def unit_vector(theta: Array) -> Complex:
    """e^(i theta), from the tangent of half the angle: NumPy computes it several times as fast as sine and cosine."""
    half = np.tan(theta / 2)
    share = 2 / (1 + half * half)
    direction = np.empty(theta.shape, dtype=complex)
    np.subtract(share, 1, out=direction.real)
    np.multiply(share, half, out=direction.imag)
    return direction
