"""Turns on n circular arcs between the two spirals of a U-turn, and derivatives by curvatures and lengths."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field

import numpy as np

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon.model.curves import Arc, Composite, Curve, Line, UTurn

# 1/m. An arc with a smaller curvature is replaced by a line, because `Arc` does not accept a radius above 100 km.
STRAIGHT = 1e-5
# rad. Below this angle the integral over an arc is evaluated by its series, because of cancellation in the closed form.
SMALL_ANGLE = 0.05
# Newton steps to the end pose, at most; convergence is quadratic.
CLOSING_STEPS = 30
# m and rad. Largest error of the end pose: next to rounding.
CLOSED = 2e-14


@dataclass(frozen=True, kw_only=True)
class Turn:
    """A turn on n circular arcs, tangent to each other and to both spirals where these meet the circle.

    Curvatures are positive to the left, in 1/m, and 0 for a line. The arc-length coordinate of the path is 0 where the
    circle is entered.
    """

    base: UTurn
    curvatures: tuple[float, ...]
    lengths: tuple[float, ...]
    path: Composite = field(repr=False)

    @property
    def length(self) -> float:
        """Length from the entry of the circle to its exit, m."""
        return math.fsum(self.lengths)


class ArcPath:
    """The inward spiral, n arcs, and the outward spiral attached rigidly to the end of the last arc.

    `x` (2 n,) are the curvatures, 1/m, and then the lengths of the arcs, m. The arcs need not end at the circle's exit:
    the path of the search is closed only in the limit of convergence.
    """

    def __init__(self, base: UTurn, x: Array) -> None:
        self.count = x.size // 2
        self.curvatures, self.lengths = x[: self.count], x[self.count :]
        inward, outward = base.pieces[0], base.pieces[-1]
        start, direction = _frame(inward, np.array([inward.end_s]))
        turned = self.curvatures * self.lengths
        self.edges = np.concatenate([[0.0], np.cumsum(self.lengths)])
        self.headings = np.angle(direction) + np.concatenate([[0.0], np.cumsum(turned)])
        chords = self.lengths * np.exp(1j * self.headings[:-1]) * _chord(turned)
        self.joints: Complex = start + np.concatenate([[0.0], np.cumsum(chords)])
        self._inward, self._outward = inward, outward
        stop, leaving = _frame(outward, np.array([outward.begin_s]))
        self._stop, self._leaving = stop, leaving
        self._rotation = np.exp(1j * self.headings[-1]) / leaving

    def at(self, s: Array) -> tuple[Complex, Complex, Array]:
        """Points and tangents as complex numbers, and curvatures, each (...), at arc-length coordinates (...)."""
        k = np.clip(np.searchsorted(self.edges, s, side="right") - 1, 0, self.count - 1)
        local = s - self.edges[k]
        curvatures = self.curvatures[k]
        starts = np.exp(1j * self.headings[k])
        angles = curvatures * local
        points = self.joints[k] + local * starts * _chord(angles)
        tangents = starts * np.exp(1j * angles)
        before, after = s < 0, s >= self.edges[-1]
        if before.any():
            there = s[before] + self._inward.end_s
            points[before], tangents[before] = _frame(self._inward, there)
            curvatures[before] = self._inward.curvature(there)
        if after.any():
            there = s[after] - self.edges[-1] + self._outward.begin_s
            spiral, direction = _frame(self._outward, there)
            points[after] = self.joints[-1] + self._rotation * (spiral - self._stop)
            tangents[after] = self._rotation * direction
            curvatures[after] = self._outward.curvature(there)
        return points, tangents, curvatures

    def partials(self, s: Array, points: Complex, tangents: Complex, curvatures: Array) -> tuple[Complex, Array]:
        """Derivatives (..., 2 n) of points and headings by the curvatures and lengths at fixed coordinates `s`.

        The part of the path after an arc moves rigidly when the arc changes.
        """
        n = self.count
        of_points = np.zeros((*s.shape, 2 * n), dtype=complex)
        of_headings = np.zeros((*s.shape, 2 * n))
        starts = np.exp(1j * self.headings)
        for j in range(n):
            curvature, length, joint = self.curvatures[j], self.lengths[j], self.joints[j + 1]
            behind, inside = s >= self.edges[j + 1], (s > self.edges[j]) & (s < self.edges[j + 1])
            local = s[inside] - self.edges[j]
            of_headings[inside, j], of_headings[behind, j] = local, length
            of_points[inside, j] = local**2 * starts[j] * _moment(curvature * local)
            whole = length**2 * starts[j] * _moment(np.array(curvature * length))
            of_points[behind, j] = whole + 1j * length * (points[behind] - joint)
            of_headings[behind, n + j] = curvature - curvatures[behind]
            moved = starts[j + 1] + 1j * curvature * (points[behind] - joint) - tangents[behind]
            of_points[behind, n + j] = moved
        return of_points, of_headings

    def end_error(self) -> tuple[Array, Array]:
        """Error (3,) of the end point, m, and of the tangent there, rad, and its derivatives (3, 2 n)."""
        off, turned = self.joints[-1:] - self._stop, self.headings[-1] - self.headings[0]
        tangent = np.exp(1j * self.headings[-1:])
        of_points, of_headings = self.partials(self.edges[-1:], self.joints[-1:], tangent, np.zeros(1))
        of_points[:, self.count :] += tangent
        error = np.array([off[0].real, off[0].imag, turned])
        return error, np.concatenate([of_points.real, of_points.imag, of_headings])

    def squared_radii(self) -> tuple[Array, Array]:
        """Squared distances (2 n - 1,) of the arcs' midpoints and inner ends from the centre, and derivatives."""
        shares = np.arange(1, 2 * self.count) / 2
        arcs = np.minimum(np.floor(shares).astype(int), self.count - 1)
        s = self.edges[arcs] + (shares - arcs) * self.lengths[arcs]
        points, tangents, curvatures = self.at(s)
        moved = np.clip(shares[:, None] - np.arange(self.count), 0, 1)
        of_points, _ = self.partials(s, points, tangents, curvatures)
        of_points[:, self.count :] += tangents[:, None] * moved
        return np.abs(points) ** 2, 2 * (points.conj()[:, None] * of_points).real


def closed_turn(base: UTurn, x: Array) -> Turn | None:
    """A turn that ends at the exit with its tangent, by least-norm Newton steps from curvatures and lengths `x` (2 n,).

    None where the Newton steps do not converge, an arc vanishes or the turn leaves the circle.
    """
    x, count = x.copy(), x.size // 2
    x[:count][np.abs(x[:count]) < STRAIGHT] = 0.0
    free = x != 0
    for _ in range(CLOSING_STEPS):
        if x[count:].min() <= STRAIGHT:
            return None
        path = ArcPath(base, x)
        error, slopes = path.end_error()
        if np.abs(error).max() < CLOSED:
            break
        x[free] -= np.linalg.lstsq(slopes[:, free], error, rcond=None)[0]
    else:
        return None
    pieces: list[Curve] = [base.pieces[0]]
    parts = (path.curvatures, path.lengths, path.headings[:-1], path.joints[:-1], path.joints[1:])
    for curvature, length, heading, joint, stop in zip(*(part.tolist() for part in parts), strict=True):
        if curvature == 0:
            pieces.append(Line(start=(joint.real, joint.imag), stop=(stop.real, stop.imag)))
            continue
        side = math.copysign(1.0, curvature)
        centre = joint + 1j * complex(math.cos(heading), math.sin(heading)) / curvature
        radius, begin, sweep = abs(1 / curvature), heading - side * math.pi / 2, curvature * length
        if _farthest(centre, radius, begin, sweep) > base.radius * (1 + CLOSED):
            return None
        pieces.append(Arc(centre=(centre.real, centre.imag), radius=radius, begin_angle=begin, sweep=sweep))
    curvatures, lengths = tuple(path.curvatures.tolist()), tuple(path.lengths.tolist())
    return Turn(base=base, curvatures=curvatures, lengths=lengths, path=Composite((*pieces, base.pieces[-1])))


def _frame(curve: Curve, s: Array) -> tuple[Complex, Complex]:
    """Points and tangents of a curve as complex numbers."""
    points, tangents = (part.view(complex)[..., 0] for part in curve.frame(s))
    return points, tangents


def _chord(angles: Array) -> Complex:
    """Integral of exp(i a v) over v from 0 to 1."""
    chord: Complex = np.sinc(angles / (2 * np.pi)) * np.exp(0.5j * angles)
    return chord


def _moment(angles: Array) -> Complex:
    """Integral of i v exp(i a v) over v from 0 to 1: the derivative of `_chord` by the angle."""
    small = np.abs(angles) < SMALL_ANGLE
    a = np.where(small, angles, 0.0)
    series = 1j / 2 - a / 3 - 1j * a**2 / 8 + a**3 / 30 + 1j * a**4 / 144 - a**5 / 840
    b = np.where(small, 1.0, angles)
    return np.where(small, series, 1j * (np.exp(1j * b) * (1 - 1j * b) - 1) / b**2)


def _farthest(centre: complex, radius: float, begin: float, sweep: float) -> float:
    """Largest distance of an arc from the origin, m."""
    ends = (abs(centre + cmath.rect(radius, end)) for end in (begin, begin + sweep))
    # The farthest point of the full circle is on the ray from the origin through its centre.
    angle = (cmath.phase(centre) - begin) * math.copysign(1.0, sweep) % (2 * math.pi)
    return abs(centre) + radius if angle < abs(sweep) else max(ends)
