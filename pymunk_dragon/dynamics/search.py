"""Search for the first contact of benches whose motion is computed step by step.

It keeps a lower bound on the gap of each pair of benches that are near each other, and lowers it in
each step by as much as the pair can close by its speeds at both ends of the step. The gap itself is
computed only where the bound reaches zero, and only where the pair can then close it in this step
is its motion within the step searched. This is no proof, as the speeds within a step are not
bounded.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Indices, as_complex, as_vectors
from pymunk_dragon._extras import library
from pymunk_dragon.collision.sat import Separation, separation
from pymunk_dragon.model.dragon import Dragon, rectangles

# Longest bench radii: pairs whose circles are closer than this are near. Others only change how
# often the near pairs are collected.
_MARGIN = 1.0
# Parts into which a time interval is divided in which a pair may touch.
_PARTS = 4
# s: an interval as short as this is not divided. Its two ends differ by rounding errors only.
_RESOLUTION = 1e-12
# Last digits of a time: the same.
_LAST_DIGITS = 8


class Bodies(NamedTuple):
    """Poses (..., N, 3) of the benches, and their rates of change: m, m, rad, and per s."""

    poses: Array
    rates: Array

    def part(self, index: int | slice) -> Bodies:
        """The bodies at one or some of several times."""
        return Bodies(self.poses[index], self.rates[index])


class Step(NamedTuple):
    """A step of the integrator from `begin` to `end`, s, and the bodies (2, N, 3) at both.

    `at` returns the bodies (T, N, 3) at times (T,) within the step.
    """

    begin: float
    end: float
    bodies: Bodies
    at: Callable[[Array], Bodies]


class ContactSearch:
    """The search, which takes one step after the other."""

    def __init__(self, dragon: Dragon) -> None:
        self._dragon = dragon
        self._radii = np.hypot(dragon.lengths, dragon.widths) / 2
        # The near pairs (P, 2), and one number for each.
        self._pairs: Indices = np.empty((0, 2), dtype=np.intp)
        self._codes: Indices = np.empty(0, dtype=np.intp)
        # Lower bounds on the gaps of the pairs, m, and upper ones on the rates at which they close,
        # m/s, at the end of the last step.
        self._gaps = np.empty(0)
        self._rates = np.empty(0)
        # m by which pairs that are not near may close until they can be near.
        self._room = 0.0

    def touching(self, bodies: Bodies) -> tuple[int, int] | None:
        """Pair of the bodies (N, 3) that overlaps most deeply, or None."""
        self._collect(bodies, 0.0)
        near = np.flatnonzero(self._gaps <= 0)
        self._gaps[near] = self.separations(bodies, self._pairs[near]).distance
        if not near.size or self._gaps.min() > 0:
            return None
        i, j = self._pairs[self._gaps.argmin()].tolist()
        return i, j

    def first_touch(self, step: Step) -> tuple[float, tuple[int, int]] | None:
        """Time and pair of the first contact in a step, the next one, or None."""
        duration = step.end - step.begin
        before = step.bodies.part(0)
        fastest = np.abs(as_complex(step.bodies.rates[..., :2])).max()
        reach = float(2 * duration * fastest)
        if reach > self._room:
            self._collect(before, reach)
        self._room -= reach

        one = self._rates
        two = self._rates = self._closing_rates(step.bodies.part(1))
        # Half the difference more than the larger one, as the rate may be largest in between.
        rates = np.maximum(one, two) + np.abs(one - two) / 2
        closing = duration * rates
        due = np.flatnonzero(self._gaps <= closing)
        if due.size:
            self._gaps[due] = self.separations(before, self._pairs[due]).distance
            due = due[self._gaps[due] <= closing[due]]
        if due.size:
            found = self._within(step, self._pairs[due], rates[due])
            if found is not None:
                return found
            after = self.separations(step.bodies.part(1), self._pairs[due])
            self._gaps[due] = after.distance + closing[due]
        self._gaps -= closing
        return None

    def separations(self, bodies: Bodies, pairs: Indices) -> Separation:
        """Distances (...) of `pairs` (..., 2) of bodies (N, 3)."""
        sides = []
        for side in (pairs[..., 0], pairs[..., 1]):
            poses = bodies.poses[side]
            sides.append(rectangles(poses, self._dragon.lengths[side], self._dragon.widths[side]))
        return separation(*sides)

    def _collect(self, bodies: Bodies, reach: float) -> None:
        """Collect the near pairs; those that were near keep their bounds."""
        margin = max(_MARGIN * float(self._radii.max()), reach)
        centres = as_complex(bodies.poses[:, :2])
        tree = library("scipy.spatial").cKDTree(as_vectors(centres))
        radius = 2 * float(self._radii.max()) + margin
        # One number for both benches of a pair, in order.
        benches = self._dragon.benches
        codes = np.sort(tree.query_pairs(radius, output_type="ndarray") @ [benches, 1])
        first, second = np.divmod(codes, benches)
        gaps = np.abs(centres[first] - centres[second]) - self._radii[first] - self._radii[second]
        near = (second - first > 1) & (gaps <= margin)
        codes = codes[near]
        gaps = gaps[near]

        # Pairs that were near have a bound by their shapes, not only by their circles.
        if self._codes.size:
            at = np.minimum(np.searchsorted(self._codes, codes), self._codes.size - 1)
            bounds = np.where(self._codes[at] == codes, self._gaps[at], -np.inf)
            gaps = np.maximum(gaps, bounds)
        self._pairs = np.stack([first[near], second[near]], axis=1)
        self._codes = codes
        self._gaps = gaps
        self._rates = self._closing_rates(bodies)
        self._room = margin

    def _closing_rates(self, bodies: Bodies) -> Array:
        """Upper bounds on the rates (P,) at which the gaps of the near pairs close, m/s.

        In a frame that rotates at the mean W of both angular rates, the centres move at V - W r
        relative to each other, and the outlines rotate at half the difference.
        """
        first, second = self._pairs.T
        centres = as_complex(bodies.poses[:, :2])
        velocities = as_complex(bodies.rates[:, :2])
        spins = bodies.rates[:, 2]
        mean = (spins[first] + spins[second]) / 2
        moving = velocities[second] - velocities[first]
        moving -= 1j * mean * (centres[second] - centres[first])
        reach = self._radii[first] + self._radii[second]
        turning = np.abs(spins[second] - spins[first]) / 2
        return np.asarray(np.abs(moving) + turning * reach)

    def _within(
        self, step: Step, pairs: Indices, rates: Array
    ) -> tuple[float, tuple[int, int]] | None:
        """Time and pair of the first contact of `pairs` (P, 2) in a step.

        Each interval in which a pair may touch, by its gaps at both ends and by its closing rate
        (P,), is divided.
        """
        rows = np.arange(len(pairs))
        lows = np.full(rows.size, step.begin)
        highs = np.full(rows.size, step.end)
        resolution = max(_RESOLUTION, _LAST_DIGITS * float(np.spacing(abs(step.end))))
        shares = np.linspace(0.0, 1.0, _PARTS + 1)
        found = None
        while rows.size:
            times = lows[:, None] * (1 - shares) + highs[:, None] * shares
            distances = self._distances(step, times, pairs[rows])
            touching = distances <= 0
            if touching.any():
                earliest = np.where(touching, times, np.inf).min(axis=1)
                row = int(earliest.argmin())
                if found is None or earliest[row] < found[0]:
                    i, j = pairs[rows[row]].tolist()
                    found = float(earliest[row]), (i, j)

            begins = times[:, :-1]
            ends = times[:, 1:]
            closing = (ends - begins) * rates[rows, None]
            possible = distances[:, :-1] + distances[:, 1:] <= closing
            possible |= touching[:, 1:]
            possible &= ends - begins > resolution
            if found is not None:
                possible &= begins < found[0]
            chosen, _ = np.nonzero(possible)
            lows = begins[possible]
            highs = ends[possible]
            rows = rows[chosen]
        return found

    def _distances(self, step: Step, times: Array, pairs: Indices) -> Array:
        """Distances (R, T) of pairs (R, 2) at times (R, T)."""
        known, index = np.unique(times, return_inverse=True)
        poses = step.at(known).poses
        index = index.reshape(times.shape)
        sides = []
        for side in pairs.T:
            lengths = self._dragon.lengths[side][:, None]
            widths = self._dragon.widths[side][:, None]
            sides.append(rectangles(poses[index, side[:, None]], lengths, widths))
        return separation(*sides).distance
