"""Smallest gap between benches on an inward march, from closely spaced samples.

Gaps of benches 0 and 1 to the benches that they pass are sampled: where all benches but the head are alike, every other
bench repeats the motion of bench 1. Samples prove nothing; `first_contact` certifies what they find.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, as_complex, as_vectors
from pymunk_dragon.collision import FirstContact, Separation, first_contact, separation
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March

# Samples per shortest spacing travelled by the head. A local minimum of a gap hardly changes between two samples.
_SAMPLES_PER_SPACING = 6
# Positions of the head evaluated at once: 30 MB with a hundred handles.
_BATCH = 4000
# Turns behind the head that contain all benches that it passes. Benches further back are further away.
_TURNS_BACK = 1.25
# Points per bracket of a local minimum in each refinement pass, which narrows the bracket by 32, and passes: half a
# metre becomes 5e-13 m.
POINTS, _PASSES = 33, 8


class Gap(NamedTuple):
    """Signed distance of two benches, m, negative where they overlap, the head's distance from its start, and where."""

    size: float
    travelled: float
    benches: tuple[int, int]
    point: tuple[float, float]


@dataclass(frozen=True)
class InwardMarch:
    """March at 1 m/s from a turn of a spiral of some `pitch`, m, inward to a circle of `radius` m about its centre."""

    dragon: Dragon
    pitch: float
    turns: float
    radius: float

    @cached_property
    def march(self) -> March:
        """The march, of which handle 0 is on the circle after `length` m."""
        return March(self.dragon, Spiral(pitch=self.pitch), turns=self.turns)

    @cached_property
    def length(self) -> float:
        """Distance along the spiral from the start of handle 0 to the circle, m."""
        # Rounding may give a negative distance where the start is on the circle.
        return max(0.0, Spiral(pitch=self.pitch).at_radius(self.radius) - self.march.head_start)

    @cached_property
    def first_contact(self) -> FirstContact:
        """Certified first contact before the circle."""
        return first_contact(self.march, until=self.length)

    def smallest_gap(self) -> Gap:
        """The smallest gap before the circle, refined about a sample; infinite if the head passes no bench."""
        spacing, spiral = float(self.dragon.spacings.min()), Spiral(pitch=self.pitch)
        passed = spiral.at_turn(self.turns) - spiral.at_turn(self.turns + _TURNS_BACK)
        handles = min(self.dragon.handles, int(passed / spacing) + 3)
        step = spacing / _SAMPLES_PER_SPACING
        travelled = np.linspace(0.0, self.length, math.ceil(self.length / step) + 1)
        parts = (travelled[at : at + _BATCH] for at in range(0, travelled.size, _BATCH))
        size, at, benches = min(self._smallest_sample(part, handles) for part in parts)
        return Gap(size, at, benches, (0.0, 0.0)) if math.isinf(size) else self.gap_about(at, step, benches)

    def _smallest_sample(self, travelled: Array, handles: int) -> tuple[float, float, tuple[int, int]]:
        """Smallest gap, m, at distances (T,) of the head, m, its distance and its benches, between some handles."""
        dragon, points, benches = self.dragon, self.march.motion(travelled, handles).points, np.arange(handles - 1)
        centres = (points[:, :-1] + points[:, 1:]) / 2
        # Benches whose bounding circles are further apart than the largest width are skipped.
        reach = (np.hypot(dragon.lengths, dragon.widths)[benches] + dragon.widths.max()) / 2
        near = np.abs(centres[:, :2, None] - centres[:, None]) < reach[:2, None] + reach
        row, *pair = np.nonzero(near & (benches > benches[:2, None] + 1))
        if not row.size:
            return math.inf, 0.0, (0, 0)
        corners = (dragon.corners(points[row, bench], points[row, bench + 1], bench) for bench in pair)
        gaps = separation(*map(as_vectors, corners)).distance
        least = gaps.argmin()
        return float(gaps[least]), float(travelled[row[least]]), (int(pair[0][least]), int(pair[1][least]))

    def gap_about(self, travelled: float, step: float, benches: tuple[int, int]) -> Gap:
        """The smallest gap of two benches within `step` m of the head's distance `travelled`, m."""
        low, high = max(0.0, travelled - step), min(self.length, travelled + step)
        for _ in range(_PASSES):
            at = np.linspace(low, high, POINTS)
            falling = self._gaps(at, benches)[1] < 0
            # First point at which the gap does not decrease.
            turning = POINTS if falling.all() else int(falling.argmin())
            low, high = at[np.clip([turning - 1, turning], 0, POINTS - 1)].tolist()
        middle = (low + high) / 2
        found = self._gaps(np.array([middle]), benches)[0]
        x, y = found.point[0].tolist()
        return Gap(float(found.distance[0]), middle, benches, (x, y))

    def _gaps(self, travelled: Array, benches: tuple[int, int]) -> tuple[Separation, Array]:
        """Gaps of two benches at distances (T,) of the head, m, and their derivatives (T,) by this distance."""
        motion = self.march.motion(travelled, max(benches) + 2)
        points, velocities = motion.points, motion.ratios * motion.tangents
        outlines = as_vectors(self.dragon.outlines_between(points))
        found = separation(*(outlines[:, bench] for bench in benches))
        normal, between, rates = as_complex(found.normal), as_complex(found.point), np.zeros(len(travelled))
        for bench, side in zip(benches, (-1, 1), strict=True):
            # Velocity of the bench at the closest point. That the closest points slide along edges does not contribute.
            closest = between + side * found.distance / 2 * normal
            share = (closest - points[:, bench + 1]) / (points[:, bench] - points[:, bench + 1])
            velocity = velocities[:, bench + 1] + share * (velocities[:, bench] - velocities[:, bench + 1])
            rates += side * (normal.conj() * velocity).real
        return found, rates
