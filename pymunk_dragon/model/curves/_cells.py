"""Path of cubics, cut into cells so short that arc length and curvature are accurate to the last digits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import ParameterError

# Gauss-Legendre on [0, 1]. Eight nodes are exact to degree 15.
_nodes, _weights = np.polynomial.legendre.leggauss(8)
NODES = (_nodes + 1) / 2
WEIGHTS = _weights / 2
# Share of a cell's length. Halves that agree with the whole so well have 16 more bits than this, and rounding has none.
LENGTH_TOLERANCE = 4e-15
# Share of the parametric speed along the chords. A slower path is close to a cusp.
MIN_SPEED = 0.01
# Excess of the bound on a cell's curvature, as a share of the cell's curvature.
LOOSE = 0.02
# The same as a share of the path's largest curvature.
LOOSE_OVERALL = 0.001
# Parameters in a cell at which the curvature is sampled.
SEEN = (0.0, 0.5, 1.0)
# Share of a bound that covers its rounding.
ROUNDING = 1e-9
# Times that a cell is halved. A path that needs more has a cusp; others need fewer than ten.
MAX_HALVINGS = 40
# From the powers of a polynomial on [0, 1] to its Bernstein coefficients, between which all its values lie.
BERNSTEIN_2 = np.array([[1, 0, 0], [1, 1 / 2, 0], [1, 1, 1]])
BERNSTEIN_4 = np.array(
    [[1, 0, 0, 0, 0], [1, 1 / 4, 0, 0, 0], [1, 1 / 2, 1 / 6, 0, 0], [1, 3 / 4, 1 / 2, 1 / 4, 0], [1, 1, 1, 1, 1]]
)


class Cells(NamedTuple):
    """A path of C cells.

    Attributes
    ----------
    cubics : ndarray, shape (C, 4, 2)
        x and y in m as polynomials of w, which goes from 0 to 1 in every cell: coefficients of 1, w, w^2, w^3.
    lengths : ndarray, shape (C,)
        m.
    curvatures : ndarray, shape (C,)
        Upper bounds on the size of the curvature, 1/m.
    """

    cubics: Array
    lengths: Array
    curvatures: Array


def speed(cubics: Array, w: Array | float) -> Array:
    """Metres per unit of w, of cubics (n, 4, 2) at w (..., n)."""
    one, two, three = cubics[:, 1], 2 * cubics[:, 2], 3 * cubics[:, 3]
    dx = one[:, 0] + w * (two[:, 0] + w * three[:, 0])
    dy = one[:, 1] + w * (two[:, 1] + w * three[:, 1])
    size: Array = np.sqrt(dx * dx + dy * dy)
    return size


def travelled(cubics: Array, w: Array | float) -> Array:
    """Arc length (n,) in m of cubics (n, 4, 2) from 0 to w (n,)."""
    speeds = WEIGHTS[:, None] * speed(cubics, NODES[:, None] * w)
    # Not NumPy's sum, whose rounding depends on n.
    length: Array = w * sum(speeds[1:], start=speeds[0])
    return length


def cubic_curvature(cubics: Array, w: Array | float) -> Array:
    """Curvature (n,) in 1/m, positive to the left, of cubics (n, 4, 2) at w (n,)."""
    one, two, three = cubics[:, 1], cubics[:, 2], cubics[:, 3]
    w = np.reshape(w, (-1, 1))
    first = one + w * (2 * two + 3 * w * three)
    second = 2 * two + 6 * w * three
    curvatures: Array = _cross(first, second) / np.hypot(first[:, 0], first[:, 1]) ** 3
    return curvatures


def cut(cubics: Array, points: Array) -> Cells:
    """Cells of a path, from the cubics (n, 4, 2) between the points (n + 1, 2) that it goes through.

    Raises
    ------
    ParameterError
        If the parametric speed nearly vanishes somewhere, as at a cusp.
    """
    chords = np.hypot(*np.diff(points, axis=0).T)
    numbers = np.arange(1, chords.size + 1)
    for _ in range(MAX_HALVINGS):
        slowest, curvatures = _bounds(cubics)
        too_slow = np.min([speed(cubics, w) for w in SEEN], axis=0) < MIN_SPEED * chords
        if too_slow.any():
            break
        seen = np.max([np.abs(cubic_curvature(cubics, w)) for w in SEEN], axis=0)
        lengths = travelled(cubics, 1.0)
        halves = _halved(cubics)
        by_halves = travelled(halves, 1.0).reshape(-1, 2).sum(axis=1)
        coarse = np.abs(by_halves - lengths) > LENGTH_TOLERANCE * lengths
        too_slow = slowest < MIN_SPEED * chords
        coarse |= too_slow
        coarse |= ~(curvatures <= (1 + LOOSE) * seen + LOOSE_OVERALL * seen.max())
        if not coarse.any():
            return Cells(cubics, lengths, curvatures * (1 + ROUNDING))
        # A cell that is cut makes room for two.
        coordinates = np.cumsum(1 + coarse) - 1
        cubics = np.repeat(cubics, 1 + coarse, axis=0)
        cubics[coordinates[coarse] - 1], cubics[coordinates[coarse]] = halves[0::2][coarse], halves[1::2][coarse]
        chords = np.repeat(np.where(coarse, chords / 2, chords), 1 + coarse)
        numbers = np.repeat(numbers, 1 + coarse)
    number = int(numbers[np.argmax(too_slow)])
    bound = f"followed by a smooth path; from it to point {number + 1} the path nearly stops, as at a cusp"
    raise ParameterError(f"point {number}", points[number - 1].tolist(), bound)


def _bounds(cubics: Array) -> tuple[Array, Array]:
    """Lower bound on the speed and upper bound on the size of the curvature of each cubic, (n,) each."""
    one, two, three = cubics[:, 1], 2 * cubics[:, 2], 3 * cubics[:, 3]
    middle = _dot(two, two) + 2 * _dot(one, three)
    squares = np.stack([_dot(one, one), 2 * _dot(one, two), middle, 2 * _dot(two, three), _dot(three, three)])
    slowest = np.sqrt(np.maximum((BERNSTEIN_4 @ squares).min(axis=0), 0.0))
    turning = np.stack([_cross(one, two), 2 * _cross(one, three), _cross(two, three)])
    with np.errstate(divide="ignore", invalid="ignore"):
        return slowest, np.abs(BERNSTEIN_2 @ turning).max(axis=0) / slowest**3


def _halved(cubics: Array) -> Array:
    """Both halves (2n, 4, 2) of each cubic (n, 4, 2), with w from 0 to 1 again."""
    zero, one, two, three = np.moveaxis(cubics, 1, 0)
    one, two, three = one / 2, two / 4, three / 8
    left = [zero, one, two, three]
    right = [zero + one + two + three, one + 2 * two + 3 * three, two + 3 * three, three]
    return np.stack([np.stack(left, axis=1), np.stack(right, axis=1)], axis=1).reshape(-1, 4, 2)


def _cross(a: Array, b: Array) -> Array:
    product: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _dot(a: Array, b: Array) -> Array:
    product: Array = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]
    return product
