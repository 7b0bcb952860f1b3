"""Search for the shortest turn on n arcs on which no handle exceeds a given multiple of the head's speed.

Unknowns are curvature and length of each arc. The length of the turn is minimised so that the last arc ends at the
circle's exit with the exit's tangent, the arcs stay inside the circle, no radius is smaller than a given one, and the
speed of every handle is at most a given multiple of the head's: at closely spaced positions of the head, and where a
handle passes from one arc to the next, because speeds have kinks there.

The method is sequential linear programming: the constraints are linearised by differences in the directions in which
the turn stays closed, `scipy.optimize.linprog` finds the best step inside a trust region, and Newton's method closes
the turn again. The problem is not convex. The search starts from several turns, and its result is the best of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Complex, Indices
from pymunk_dragon._extras import library
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves import Arc, Composite, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies._speed_ratio import SpeedRatio, largest_ratio
from pymunk_dragon.studies._study import Progress

# Starts on each number of arcs above 3. One has sharper ends than the best turn on two arcs fewer: a share of the first
# and the last arc becomes an arc of its own, with a multiple of the curvature. In the other one random curvatures of
# this standard deviation, 1/m, are added to those of the best turn on three arcs, whose longest arcs are halved.
SHARE, SHARPENING, NOISE = 0.2, 1.5, 0.1
# Steps from each start, at most, and m of gain below which several steps in a row end the search.
STEPS, MIN_GAIN, PATIENCE = 60, 1e-4, 4
# Searches with a wider margin, at most, after a turn that violates the limit between the positions of the search.
REPAIRS = 8
# m travelled by the head between samples of the speeds, and beyond the turn; and m behind the circle up to which the
# chain reaches. The certificate of the result has no such limits.
SAMPLING, HEAD_MARGIN, CHAIN_MARGIN = 0.02, 9.0, 3.0
# Constraints closer to their limits than this are linearised, and a turn that violates one by more is not repaired.
NEAR, MAX_VIOLATION = 0.2, 0.01
# m. Least length of an arc.
MIN_ARC = 0.02
# m. First, largest and least size of the trust region, factors on it after a better turn and after any other, and 1/m
# of curvature for each m of an arc's length.
FIRST_SIZE, MAX_SIZE, MIN_SIZE, GROWTH, SHRINKAGE, CURVATURE_PER_LENGTH = 0.3, 0.6, 1e-4, 1.6, 1 / 3, 2.0
# m per unit of a violated constraint: several times the Lagrange multiplier of the speed.
PENALTY = 10.0
# Distance kept from the limits, which makes the turn some micrometres longer; and step of the differences, m and 1/m.
MARGIN, DIFFERENCE = 1e-6, 1e-6
# Largest error of the end pose, m and rad, and largest last step of a chain's Newton iteration, m, whose error is its
# square; and steps to both, at most.
CLOSED, SETTLED, NEWTON_STEPS = 2e-14, 1e-8, 30
# Least cosine of an angle between a bench and the path: speeds are unbounded as it goes to zero.
MIN_COSINE = 0.02


@dataclass(frozen=True, kw_only=True)
class Shortest:
    """The shortest turn that was found; no proof that there is no shorter one.

    Attributes
    ----------
    curvatures, lengths : tuple of float
        Curvatures of the arcs, positive to the left, 1/m, and their lengths, m.
    path : Composite
        The path between both spirals. Its coordinate is 0 where the circle is entered.
    by_arcs : tuple of (int, float)
        Numbers of arcs, and the least length found with each, m.
    ratio : SpeedRatio
        Largest ratio of a handle's speed to the head's on this turn, enclosed by branch and bound.
    """

    curvatures: tuple[float, ...]
    lengths: tuple[float, ...]
    path: Composite = field(repr=False)
    by_arcs: tuple[tuple[int, float], ...]
    ratio: SpeedRatio

    @property
    def length(self) -> float:
        """Length from the entry of the circle to its exit, m."""
        return math.fsum(self.lengths)

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units."""
        return {
            "length": self.length,
            "proven": False,
            "arcs": [{"curvature": k, "length": m} for k, m in zip(self.curvatures, self.lengths, strict=True)],
            "joints": self.path.point(self.path.joints).tolist(),
            "lengths": [{"arcs": arcs, "length": length} for arcs, length in self.by_arcs],
            "peak_speed_ratio": self.ratio.to_dict(),
        }


def shortest_turn(
    base: UTurn, dragon: Dragon, limit: float, arcs: int, min_radius: float, progress: Progress
) -> Shortest:
    """Search for the shortest turn on at most `arcs` arcs on which no handle exceeds `limit` times the head's speed.

    All odd numbers of arcs from 3 are searched, with radii of at least `min_radius` m. Raises `MissingExtraError`
    without SciPy, and `ParameterError` if no such turn is found.
    """
    count = 1 + int(np.searchsorted(np.cumsum(dragon.spacings), base.length + CHAIN_MARGIN))
    search = _Search(base, dragon.spacings[:count], limit, min_radius)
    # Two equal arcs as the contest's, with a short one between them.
    k, angle = 2 / float(base.radii.sum()), float(base.sweeps[1])
    three = best = search.run(np.array([-k, k / 10, k, angle / k, 5 * MIN_ARC, angle / k]))
    progress(3, arcs + 2)
    if three is None or best is None:
        raise ParameterError("radius", base.radius, "large enough for the dragon to turn in the circle")
    by_arcs = {3: best.length}
    for n in range(5, arcs + 1, 2):
        noise = NOISE * np.random.default_rng(0).standard_normal(n)
        starts = _sharpened(best.x), _divided(three.x, n - 3) + np.concatenate([noise, np.zeros(n)])
        best = min([best, *filter(None, map(search.run, starts))], key=lambda turn: turn.cost)
        by_arcs[n] = best.length
        progress(n, arcs + 2)
    too_fast = ParameterError("fastest", limit, "higher: no turn inside the circle was found that satisfies this limit")
    for _ in range(REPAIRS):
        if best.values.max() > MAX_VIOLATION:
            raise too_fast
        # The certificate includes all handles at all times.
        ratio = largest_ratio(dragon, best.path)
        excess = max(ratio.ratio / limit - 1, search.outside(best.x).max() - search.margin)
        if excess <= 0:
            break
        search.margin += excess + MARGIN
        best = search.run(best.x) or best
    else:
        raise too_fast
    progress(1, 1)
    by_arcs[arcs] = best.length
    curvatures, lengths = (tuple(part.tolist()) for part in np.split(best.x, 2))
    return Shortest(curvatures=curvatures, lengths=lengths, path=best.path, by_arcs=tuple(by_arcs.items()), ratio=ratio)


def _sharpened(x: Array) -> Array:
    """Unknowns of a turn with two arcs more: the outer parts of the first and the last arc have more curvature."""
    curvatures, lengths = np.split(x, 2)
    ends, parts = SHARPENING * curvatures[[0, -1]], SHARE * lengths[[0, -1]]
    inner = lengths.copy()
    inner[[0, -1]] -= parts
    return np.concatenate([ends[:1], curvatures, ends[1:], parts[:1], inner, parts[1:]])


def _divided(x: Array, times: int) -> Array:
    """Unknowns of the same turn with its longest arc halved, repeated `times` times."""
    for _ in range(times):
        curvatures, lengths = np.split(x, 2)
        longest = int(np.argmax(lengths))
        lengths = np.insert(lengths, longest, lengths[longest] / 2)
        lengths[longest + 1] /= 2
        x = np.concatenate([np.insert(curvatures, longest, curvatures[longest]), lengths])
    return x


class _Turn(NamedTuple):
    """A closed turn, and its constraints."""

    # (2 n,) Curvatures, 1/m, and lengths, m, of the arcs.
    x: Array
    path: Composite
    # Instants at which speeds are constrained: handles, numbers of the joints at which they are, and m beyond these.
    instants: tuple[Indices, Indices, Array]
    # Coordinates of all handles at the instants.
    handles_s: Array
    # Constraints, which are satisfied up to 0: logarithms of speed ratios, and relative distances from the centre.
    values: Array

    @property
    def length(self) -> float:
        """Length of the arcs, m."""
        return float(self.x[self.x.size // 2 :].sum())

    @property
    def cost(self) -> float:
        """Length with a penalty for violated constraints, m."""
        return self.length + PENALTY * max(0.0, float(self.values.max()))


class _Search:
    """The optimisation problem. `margin` is the distance that is kept from the limits."""

    def __init__(self, base: UTurn, spacings: Array, limit: float, min_radius: float) -> None:
        self.base, self.spacings, self.margin = base, spacings, MARGIN
        self._log_limit, self._max_curvature = math.log(limit), (1 - MARGIN) / min_radius
        entry, tangent = (part.view(complex)[0] for part in base.frame(0.0))
        self._entry, self._heading = complex(entry), float(np.angle(tangent))
        self._linprog = library("scipy.optimize").linprog

    def run(self, start: Array) -> _Turn | None:
        """The best turn found from a start (2 n,); None if the start is no turn."""
        best, size, slow = self._evaluated(start), FIRST_SIZE, 0
        for _ in range(STEPS):
            if best is None or slow == PATIENCE or (linear := self._linearised(best)) is None:
                break
            better = None
            while size >= MIN_SIZE and better is None:
                better = self._evaluated(self._stepped(best, *linear, size))
                if better is None or better.cost >= best.cost:
                    better, size = None, size * SHRINKAGE
            if better is None:
                break
            slow = slow + 1 if best.cost - better.cost < MIN_GAIN else 0
            best, size = better, min(size * GROWTH, MAX_SIZE)
        return best

    def outside(self, x: Array) -> Array:
        """Relative distances beyond the circle, with the margin, of the inner ends and of the summits of arcs."""
        curvatures, lengths = np.split(x, 2)
        joints, headings, centres = self._geometry(x)
        # The farthest point of a full circle is on the ray from the origin through its centre.
        turned = (np.angle(1j * centres * curvatures) - headings[:-1]) * np.sign(curvatures) % (2 * np.pi)
        on_arc = turned < np.abs(curvatures) * lengths
        summits = np.where(on_arc, np.abs(centres) + 1 / np.abs(curvatures), 0.0)
        return np.concatenate([np.abs(joints[1:-1]), summits]) / self.base.radius - 1 + self.margin

    def _geometry(self, x: Array) -> tuple[Complex, Array, Complex]:
        """Ends (n + 1,) of the arcs from the entry of the circle on, headings there, and centres (n,)."""
        curvatures, lengths = np.split(x, 2)
        turned = curvatures * lengths
        headings = self._heading + np.concatenate([[0.0], np.cumsum(turned)])
        chords = lengths * np.exp(1j * (headings[:-1] + turned / 2)) * np.sinc(turned / (2 * np.pi))
        joints = self._entry + np.concatenate([[0.0], np.cumsum(chords)])
        with np.errstate(divide="ignore", invalid="ignore"):
            return joints, headings, joints[:-1] + 1j * np.exp(1j * headings[:-1]) / curvatures

    def _end_error(self, x: Array) -> Array:
        """Error (3,) of the end point, m, and of the tangent there, rad."""
        joints, headings, _ = self._geometry(x)
        off = joints[-1] + self._entry
        return np.array([off.real, off.imag, headings[-1] - headings[0]])

    def _closed(self, x: Array) -> tuple[Array, Composite] | None:
        """Unknowns near `x`, by least-norm Newton steps, of a turn that ends at the exit with its tangent."""
        for _ in range(NEWTON_STEPS):
            error = self._end_error(x)
            if np.abs(error).max() < CLOSED:
                break
            x = x - np.linalg.lstsq(_derivatives(self._end_error, x), error, rcond=None)[0]
        curvatures, lengths = np.split(x, 2)
        _, headings, centres = self._geometry(x)
        parts = (centres, curvatures, headings[:-1] - np.sign(curvatures) * np.pi / 2, lengths)
        try:
            arcs = [
                Arc(centre=(centre.real, centre.imag), radius=1 / abs(k), begin_angle=begin, sweep=k * length)
                for centre, k, begin, length in zip(*(part.tolist() for part in parts), strict=True)
            ]
            return x, Composite((self.base.pieces[0], *arcs, self.base.pieces[-1]))
        except (ParameterError, ZeroDivisionError):  # No convergence, or an arc that vanishes or is almost straight.
            return None

    def _evaluated(self, x: Array | None) -> _Turn | None:
        """The turn near `x`, and its constraints; None if there is none, or the chain cannot follow it."""
        if x is None or (closed := self._closed(x)) is None:
            return None
        joints = np.array(closed[1].joints)
        heads = np.arange(0.0, joints[-1] + HEAD_MARGIN, SAMPLING)
        try:
            sampled = closed[1].chain(heads, self.spacings)
        except DragonError:
            return None
        # Samples, in which the head is beyond joint 0, and kinks, in which a handle is at a joint.
        handles, numbers = np.indices((sampled.shape[1], joints.size)).reshape(2, -1)
        after = np.array([np.searchsorted(sampled[:, i], joints[j]) for i, j in zip(handles, numbers, strict=True)])
        passed = (after > 0) & (after < heads.size)
        zeros = np.zeros(heads.size, dtype=np.intp)
        instants = (
            np.concatenate([zeros, handles[passed]]),
            np.concatenate([zeros, numbers[passed]]),
            np.concatenate([heads, np.zeros(passed.sum())]),
        )
        found = self._constraints(*closed, instants, np.concatenate([sampled, sampled[after[passed]]]))
        return None if found is None else _Turn(*closed, instants, *found)

    def _constraints(
        self, x: Array, path: Composite, instants: tuple[Indices, Indices, Array], handles_s: Array
    ) -> tuple[Array, Array] | None:
        """Coordinates of the handles at the instants, by Newton's method from `handles_s`, and the constraints."""
        handles, numbers, offsets = instants
        rows, goals = np.arange(len(handles_s)), np.array(path.joints)[numbers] + offsets
        for _ in range(NEWTON_STEPS):
            points, tangents = (part.view(complex)[..., 0] for part in path.frame(handles_s))
            between = points[:, :-1] - points[:, 1:]
            distances = np.abs(between)
            front, rear = ((between.conj() * part).real / distances for part in (tangents[:, :-1], tangents[:, 1:]))
            if not min(front.min(), rear.min()) > MIN_COSINE:
                return None
            ratios = np.cumprod(np.concatenate([np.ones((rows.size, 1)), front / rear], axis=1), axis=1)
            # Steps with the head in its position, and then with the handle of the instant in its own.
            steps = np.zeros_like(handles_s)
            steps[:, 1:] = ratios[:, 1:] * np.cumsum((distances - self.spacings) / rear / ratios[:, 1:], axis=1)
            missing = goals - (handles_s + steps)[rows, handles]
            steps += ratios * (missing / ratios[rows, handles])[:, None]
            handles_s = handles_s + steps
            if np.abs(steps).max() < SETTLED:
                speeds = np.log(ratios[:, 1:]).ravel() - self._log_limit + self.margin
                return handles_s, np.concatenate([speeds, self.outside(x)])
        return None

    def _linearised(self, turn: _Turn) -> tuple[Array, Array, Array] | None:
        """Directions (2 n, K) in which a turn stays closed, constraints near their limits, and their derivatives."""
        directions = np.linalg.svd(_derivatives(self._end_error, turn.x))[2][3:].T
        near, columns = turn.values > -NEAR, []
        for direction in directions.T:
            closed = self._closed(turn.x + DIFFERENCE * direction)
            if closed is None or (found := self._constraints(*closed, turn.instants, turn.handles_s)) is None:
                return None
            columns.append((found[1] - turn.values)[near] / DIFFERENCE)
        return directions, turn.values[near], np.stack(columns, axis=1)

    def _stepped(self, turn: _Turn, directions: Array, values: Array, slopes: Array, size: float) -> Array | None:
        """Unknowns of the best turn in the trust region according to the linearised constraints."""
        count = turn.x.size // 2
        sizes = np.repeat([CURVATURE_PER_LENGTH * size, size], count)
        lowest = np.repeat([-self._max_curvature, MIN_ARC], count) - turn.x
        highest = np.repeat([self._max_curvature, np.inf], count) - turn.x
        # The last unknown is the largest violation.
        sides = np.concatenate([directions, -directions])
        found = self._linprog(
            np.append(directions[count:].sum(axis=0), PENALTY),
            A_ub=np.block([[slopes, np.full((len(slopes), 1), -1.0)], [sides, np.zeros((len(sides), 1))]]),
            b_ub=np.concatenate([-values, np.minimum(sizes, highest), np.minimum(sizes, -lowest)]),
            bounds=[(None, None)] * directions.shape[1] + [(0, None)],
        )
        return None if found.x is None else turn.x + directions @ found.x[:-1]


def _derivatives(function: Callable[[Array], Array], x: Array) -> Array:
    """Derivatives (M, N) of a function (M,) by its argument (N,), by central differences."""
    steps = DIFFERENCE * np.eye(x.size)
    return np.stack([(function(x + step) - function(x - step)) / (2 * DIFFERENCE) for step in steps], axis=1)
