"""Search for the shortest turn on five arcs on which no handle exceeds a given multiple of the head's speed.

The chord of an arc is at the mean angle of the tangents at both ends. So the entry and its tangent, and the points at
which arcs end, determine these arcs. Two more arcs lead to the exit with its tangent if the angle between their chords
is half the angle that they turn by. The ratio of the chords is free. So the unknowns are the points at which the first
three arcs end, as complex numbers in units of the entry, and the logarithm of the ratio of the last two chords.

The method is sequential linear programming: the constraints are linearised by differences, and `scipy.optimize.linprog`
finds the best step inside a trust region. Speeds have kinks where a handle passes from one arc to the next; they are
sampled at fixed fractions of the time intervals between kinks, where they depend smoothly on the unknowns. The problem
is not convex, so the result is the best turn near the start. A certificate checks its largest speed at all times.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon._extras import library
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model import chain
from pymunk_dragon.model.curves import Arc, Composite, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies._speed_ratio import SpeedRatio, largest_ratio
from pymunk_dragon.studies._study import Progress

# Start of the search: short, sharp arcs at both ends, and long ones between.
START = (0.95, -0.1, 0.4, -0.2, -0.5, 0.2, -2.5)
# Start of a second search where the first one fails, the contest's turn: fractions of its arcs at which the four
# inner joints are.
_JOINTS = np.array([0.4, 1.0, 1.3, 1.7])
# m. Least radius and length of an arc: smaller radii save centimetres, and slow down the certificate of first contact.
MIN_RADIUS, _MIN_ARC = 0.5, 0.02
# m travelled by the head between chains, and beyond the turn; m behind the circle up to which handles are included; and
# samples of the speeds from one kink to the next.
_SAMPLING, _HEAD_MARGIN, _CHAIN_MARGIN, SAMPLES = 0.02, 9.0, 3.0, 8
# Steps at most; and first, largest and least size of the trust region, in units of the unknowns, of which the last one
# may change by more; and factors on the size after a better turn and after any other.
STEPS, _FIRST_SIZE, MAX_SIZE, _MIN_SIZE, _GROWTH, _SHRINKAGE = 80, 0.1, 0.2, 1e-5, 1.6, 1 / 3
_SCALES = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 5.0])
# m per unit of a violated constraint: several times the Lagrange multiplier of the speed. Violation by a bench that is
# pushed back or has no position.
_PENALTY, STUCK = 4.0, 10.0
# Constraints closer to their limits than this are linearised, and a turn that violates one by more is not repaired.
_NEAR, _MAX_VIOLATION = 0.4, 0.05
# First distance kept from the limits; step of the differences; and searches, at most, each with a wider distance.
MARGIN, _DIFFERENCE, _REPAIRS = 1e-4, 1e-7, 4


def shortest_turn(base: UTurn, dragon: Dragon, limit: float, progress: Progress) -> tuple[Composite, SpeedRatio]:
    """The shortest turn found on which no handle exceeds `limit` times the head's speed, and its largest speed ratio.

    Raises `MissingExtraError` without SciPy, and `ParameterError` if no such turn is found.
    """
    search = _Search(base, dragon, limit)
    for done in range(_REPAIRS):
        progress(done, done + 1)
        x = search.run(np.array(START))
        if search.violations(x).max() > _MAX_VIOLATION:
            x = search.run(search.contests_turn())
        if search.violations(x).max() > _MAX_VIOLATION:
            break
        path = search.arcs(x).path(base)
        ratio = largest_ratio(dragon, path)
        excess = max((ratio.ratio - limit) / (limit - 1), search.arcs(x).violations(base.radius).max())
        if excess <= 0:
            progress(1, 1)
            return path, ratio
        search.margin += excess + MARGIN
    raise ParameterError("fastest", limit, "higher: no turn inside the circle was found that satisfies this limit")


class _Arcs(NamedTuple):
    """Joints (n + 1,) of arcs as complex numbers, m, directions (n + 1,) there, rad, and lengths (n,), m."""

    joints: Complex
    headings: Array
    lengths: Array

    @property
    def curvatures(self) -> Array:
        """Signed curvatures (n,), 1/m."""
        return np.diff(self.headings) / self.lengths

    @property
    def centres(self) -> Complex:
        """Centres (n,) as complex numbers, m."""
        centres: Complex = self.joints[:-1] + 1j * np.exp(1j * self.headings[:-1]) / self.curvatures
        return centres

    def path(self, base: UTurn) -> Composite:
        """The path with the spirals of another turn; an error if an arc vanishes or is straight."""
        curvatures, centres = self.curvatures.tolist(), self.centres.tolist()
        begins, sweeps = self.headings[:-1] - np.copysign(np.pi / 2, curvatures), np.diff(self.headings)
        arcs = [
            Arc(centre=(centre.real, centre.imag), radius=1 / abs(curvature), begin_angle=begin, sweep=sweep)
            for centre, curvature, begin, sweep in zip(centres, curvatures, begins, sweeps, strict=True)
        ]
        return Composite((base.pieces[0], *arcs, base.pieces[-1]))

    def violations(self, radius: float) -> Array:
        """Violations of the limits of arcs: the circle of the radius, the least radius of an arc and its length."""
        curvatures, centres = self.curvatures, self.centres
        # The farthest point of a full circle is on the ray from the origin through its centre.
        turned = (np.angle(1j * centres * curvatures) - self.headings[:-1]) * np.sign(curvatures) % (2 * np.pi)
        summits = np.where(turned < np.abs(curvatures) * self.lengths, np.abs(centres) + 1 / np.abs(curvatures), 0.0)
        outside = np.concatenate([np.abs(self.joints[1:-1]), summits]) / radius - 1
        return np.concatenate([outside, np.abs(curvatures) * MIN_RADIUS - 1, _MIN_ARC - self.lengths])


class _Search:
    """The optimisation problem. `margin` is the distance that is kept from the limits."""

    def __init__(self, base: UTurn, dragon: Dragon, limit: float) -> None:
        self._base, self._limit, self.margin = base, limit, MARGIN
        reach = int(np.searchsorted(np.cumsum(dragon.spacings), base.length + _CHAIN_MARGIN))
        self._spacings = dragon.spacings[: reach + 1]
        entry, tangent = (part.view(complex)[0] for part in base.frame(0.0))
        self._entry, self._heading = complex(entry), float(np.angle(tangent))
        self._optimize = library("scipy.optimize")

    def contests_turn(self) -> Array:
        """Unknowns of the contest's turn with its arcs divided."""
        joints = np.interp(_JOINTS, [0, 1, 2], self._base.joints)
        points = self._base.point(joints).view(complex)[:, 0] / self._entry
        ratio = abs((-1 - points[3]) / (points[3] - points[2]))
        return np.append(points[:3].view(float), np.log(ratio))

    def arcs(self, x: Array) -> _Arcs:
        """The arcs of unknowns (7,)."""
        chords = list(np.diff(self._entry * np.append(1, x[:6].view(complex))))
        headings = [self._heading]
        for k in range(len(chords) + 2):
            if k == len(chords):
                rest = -2 * self._entry - sum(chords)
                chord = rest / (1 + np.exp(x[6] + 0.5j * (self._heading - headings[-1])))
                chords += [chord, rest - chord]
            headings.append(headings[-1] + 2 * float(np.angle(chords[k] * np.exp(-1j * headings[-1]))))
        lengths = np.abs(chords) / np.sinc(np.diff(headings) / (2 * np.pi))
        return _Arcs(self._entry + np.cumsum([0, *chords]), np.array(headings), lengths)

    def length(self, x: Array) -> float:
        """Length of the turn, m."""
        return float(self.arcs(x).lengths.sum())

    def violations(self, x: Array) -> Array:
        """Violations of all limits, with the margin: 0 at the limit. That of speed is in units of `limit - 1`."""
        arcs = self.arcs(x)
        path = arcs.path(self._base)
        heads = np.arange(0.0, self._base.length + _HEAD_MARGIN, _SAMPLING)
        chains = path.chain(heads, self._spacings).T
        kinks = np.sort(np.concatenate([np.interp(path.joints, handle, heads) for handle in chains]))
        sampled = np.interp(np.arange(SAMPLES * (kinks.size - 1)) / SAMPLES, np.arange(kinks.size), kinks)
        handles_s = np.stack([np.interp(sampled, heads, handle) for handle in chains], axis=1)
        ratios = chain.chain_motion(path, handles_s, self._spacings).ratios[:, 1:].ravel()
        speeds = np.where(ratios > 0, (ratios - self._limit) / (self._limit - 1), STUCK)
        return np.concatenate([speeds, arcs.violations(self._base.radius)]) + self.margin

    def cost(self, x: Array) -> float:
        """Length with a penalty for violated constraints, m; inf where an arc vanishes or is straight."""
        try:
            return self.length(x) + _PENALTY * max(0.0, float(self.violations(x).max()))
        except DragonError:
            return np.inf

    def run(self, x: Array) -> Array:
        """The best unknowns found from a start."""
        size, cost, better = _FIRST_SIZE, self.cost(x), True
        for _ in range(STEPS):
            if better:
                values, derivatives = self.violations(x), self._optimize.approx_fprime
                near = values > -_NEAR
                slopes = derivatives(x, lambda x: self.violations(x)[near], _DIFFERENCE)  # noqa: B023  # Called at once.
                gradient = derivatives(x, self.length, _DIFFERENCE)
            # The last unknown is the largest violation.
            step = self._optimize.linprog(
                np.append(gradient, _PENALTY),
                A_ub=np.column_stack([slopes, np.full(len(slopes), -1.0)]),
                b_ub=-values[near],
                bounds=[*(size * np.outer(_SCALES, [-1, 1])), (0, None)],
            )
            other = x + step.x[:-1]
            better = (found := self.cost(other)) < cost
            if better:
                x, cost = other, found
            size = min(size * _GROWTH, MAX_SIZE) if better else size * _SHRINKAGE
            if size < _MIN_SIZE:
                break
        return x
