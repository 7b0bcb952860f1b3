"""Search for the shortest turn on n arcs on which no handle exceeds a given multiple of the head's speed.

The turn is an optimal-control problem with a piecewise constant control: the curvature of the path that the head
follows. Unknowns are curvature and length of each of n arcs; the length of the turn is minimised so that

- the last arc ends at the circle's exit with the exit's tangent,
- the arcs stay inside the circle, and no radius is smaller than a given one,
- at every time the speed of every handle is at most a given multiple of the head's.

The last constraint is semi-infinite. It is imposed at finitely many instants, to which the maxima of each solution that
violate it are added (an exchange method for semi-infinite programmes: J. W. Blankenship, J. E. Falk,
"Infinitely constrained optimization problems", J. Optim. Theory Appl. 19, 1976). Each finite problem is solved by
`scipy.optimize.minimize(method="SLSQP")` inside a trust region, with exact derivatives.

A speed has a kink where a handle passes from one arc to the next, and the maxima of the best turns lie there. So each
instant is defined by the distance of one handle, the anchor, from an end of an arc, and moves with that end.

The problem is not convex. The search starts from several turns, and its result is the best that was found.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array, Indices
from pymunk_dragon._extras import library
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies._speed_ratio import SpeedRatio, largest_ratio
from pymunk_dragon.studies._study import Progress, silent
from pymunk_dragon.studies._turn_speeds import Constraints, constrained_speeds, sampled_speeds, speed_maxima
from pymunk_dragon.studies._turns import ArcPath, Turn, closed_turn

Solution = tuple[Turn, float]

# Random starts on each number of arcs above 3. Where one start ends may depend on rounding: on 5 arcs 0.02 m apart.
STARTS = 2
# 1/m. Standard deviation of the curvatures that are added to those of the best turn on three arcs, whose longest arcs
# are halved. A search that starts from the best turn on two arcs fewer hardly leaves its neighbourhood: on 7 arcs it
# ended 0.12 m longer.
NOISE = 0.1
# Finite problems for each start, at most: bounds the work of starts that hardly improve.
ROUNDS = 25
# Finite problems after the limit has been lowered: the start is almost a solution.
LAST_ROUNDS = 4
# Solutions with a lower limit, at most, after a solution that violates the limit somewhere.
REPAIRS = 8
# m behind the circle up to which the chain reaches in the search. The certificate of the result has no such limit.
CHAIN_MARGIN = 3.0

# m travelled by the head between samples of the speeds, before refinement.
STEP = 0.02
# m travelled by the head beyond the turn in the search. The certificate of the result has no such limit.
HEAD_MARGIN = 9.0
# Logarithm of a speed ratio, relative to the limit's, above which a maximum is constrained.
PEAK_MARGIN = 0.1
# The same for a kink.
KINK_MARGIN = 0.2
# m. Distance of a handle from an end of an arc above which a maximum is not at the kink.
AT_KINK = 1e-3
# m. Least length of an arc: an arc that vanishes makes the turn invalid.
MIN_ARC = 0.02
# 1/m of curvature for each m of an arc's length in the trust region.
CURVATURE_PER_LENGTH = 2.0
# m. First size of the trust region.
FIRST_SIZE = 0.3
# m. Largest size of the trust region.
MAX_SIZE = 0.6
# m. Size of the trust region at which a search ends.
MIN_SIZE = 1e-4
# Factor on the size after a better solution.
GROWTH = 1.6
# Factor on the size after any other solution.
SHRINKAGE = 1 / 3
# m per unit of the logarithm of a speed ratio above the limit: several times the constraint's Lagrange multiplier.
PENALTY = 10.0
# m. Least gain of a solution with which the search from a start continues.
MIN_GAIN = 5e-4
# m. The same for the search from the best of all turns.
FINAL_MIN_GAIN = 1e-4
# m. Largest penalty of a turn that is repaired: its fastest handle is above the limit by a hundredth.
MAX_PENALTY = 0.1
# Iterations of SLSQP for each finite problem, at most.
ITERATIONS = 40
# m. Tolerance of SLSQP: far below the least gain.
TOLERANCE = 1e-7
# Logarithm of the ratio by which the search remains below the limit: several times the violations that SLSQP leaves.
# It makes the turn some micrometres longer.
MARGIN = 1e-6
# Share of the largest curvature that is reserved for the step that closes a turn.
CURVATURE_MARGIN = 1e-6
# Relative distance from the limit within which a handle's largest speed counts as equal to it: ten times the margin.
BINDING = 1e-5


@dataclass(frozen=True, kw_only=True)
class Shortest:
    """The shortest turn that was found; no proof that there is no shorter one.

    Attributes
    ----------
    turn : Turn
        The turn.
    lengths : tuple of (int, float)
        Numbers of arcs, and the least length found with each, m.
    min_radius : float
        Least radius of an arc in the search, m.
    ratio : SpeedRatio
        Largest ratio of a handle's speed to the head's on this turn, enclosed by branch and bound.
    binding : tuple of int
        Handles whose speed reaches the limit.
    evaluations : int
        Number of turns whose speeds were computed.
    """

    turn: Turn
    lengths: tuple[tuple[int, float], ...]
    min_radius: float
    ratio: SpeedRatio
    binding: tuple[int, ...]
    evaluations: int

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units."""
        turn = self.turn
        return {
            "length": turn.length,
            "proven": False,
            "arcs": [{"curvature": k, "length": m} for k, m in zip(turn.curvatures, turn.lengths, strict=True)],
            "joints": turn.path.point(turn.path.joints).tolist(),
            "lengths": [{"arcs": arcs, "length": length} for arcs, length in self.lengths],
            "min_radius": self.min_radius,
            "binding": self.binding,
            "peak_speed_ratio": self.ratio.to_dict(),
        }


def shortest_turn(
    base: UTurn, dragon: Dragon, limit: float, arcs: int, min_radius: float, progress: Progress = silent
) -> Shortest:
    """Search for the shortest turn on at most `arcs` arcs on which no handle exceeds `limit` times the head's speed.

    All odd numbers of arcs from 3 are searched, with radii of at least `min_radius` m. `progress` is called with the
    number of arcs that have been searched, and a number that represents the end. Raises `MissingExtraError` without
    SciPy, and `ParameterError` if no such turn is found.
    """
    count = 1 + int(np.searchsorted(np.cumsum(dragon.spacings), base.length + CHAIN_MARGIN))
    programme = _Programme(base, dragon.spacings[:count], limit, min_radius)
    (right, left), turned = base.radii.tolist(), float(base.sweeps[1])
    first = np.array([-1 / right, 0, 1 / left, right * turned, MIN_ARC, left * turned])
    best = programme.solve(first)
    progress(3, arcs + 2)
    if best is None:
        raise ParameterError("radius", base.radius, "large enough for the dragon to turn in the circle")
    lengths = [(3, best)]
    for n in range(5, arcs + 1, 2):
        divided = _divided(_unknowns(lengths[0][1][0]), n - 3)
        found = [best]
        for seed in range(STARTS):
            noise = np.concatenate([np.random.default_rng(seed).standard_normal(n), np.zeros(n)])
            found.append(programme.solve(divided + NOISE * noise) or best)
        best = min(found, key=lambda solution: solution[1])
        progress(n, arcs + 2)
        lengths.append((n, best))
    too_fast = ParameterError("fastest", limit, "higher: no turn inside the circle was found that satisfies this limit")
    if best[1] - best[0].length > MAX_PENALTY:
        raise too_fast
    for _ in range(REPAIRS):
        # The certificate includes all handles at all times.
        ratio = largest_ratio(dragon, best[0].path)
        if ratio.ratio <= limit:
            break
        programme.log_limit -= np.log(ratio.ratio / limit) + MARGIN
        best = programme.solve(_unknowns(best[0]), LAST_ROUNDS, FINAL_MIN_GAIN) or best
    else:
        raise too_fast
    progress(arcs + 2, arcs + 2)
    return Shortest(
        turn=best[0],
        lengths=(*((n, turn.length) for n, (turn, _) in lengths[:-1]), (arcs, best[0].length)),
        min_radius=min_radius,
        ratio=ratio,
        binding=programme.binding(best[0]),
        evaluations=programme.evaluations,
    )


def _unknowns(turn: Turn) -> Array:
    """Curvatures, 1/m, and lengths, m, of the arcs, (2 n,)."""
    return np.array([*turn.curvatures, *turn.lengths])


def _divided(x: Array, times: int) -> Array:
    """The same turn with its longest arc halved, repeated `times` times."""
    curvatures, lengths = (part.tolist() for part in np.split(x, 2))
    for _ in range(times):
        longest = int(np.argmax(lengths))
        lengths[longest : longest + 1] = [lengths[longest] / 2] * 2
        curvatures.insert(longest, curvatures[longest])
    return np.array([*curvatures, *lengths])


class _Programme:
    """The optimisation problem for turns on circular arcs."""

    def __init__(self, base: UTurn, spacings: Array, limit: float, min_radius: float) -> None:
        self.base, self.spacings = base, spacings
        self.log_limit = np.log(limit) - MARGIN
        self.max_curvature = (1 - CURVATURE_MARGIN) / min_radius
        self.evaluations = 0
        self._minimize = library("scipy.optimize").minimize

    def solve(self, start: Array, rounds: int = ROUNDS, min_gain: float = MIN_GAIN) -> Solution | None:
        """The best turn found from a start (2 n,), and its length with the penalty; None if the start is no turn.

        The search ends at a gain of less than `min_gain` m.
        """
        found = self._evaluated(start)
        if found is None:
            return None
        turn, cost, samples, maxima = found
        constraints, size = self._peak_constraints(turn, maxima), FIRST_SIZE
        for _ in range(rounds):
            x = _unknowns(turn)
            kinks = self._kink_constraints(turn, *samples)
            better = self._evaluated(self._finite_solution(x, constraints + kinks, size))
            if better is not None:
                constraints = constraints + self._peak_constraints(better[0], better[3])
            gain = -np.inf if better is None else cost - better[1]
            if better is None or gain <= 0:
                size *= SHRINKAGE
            else:
                turn, cost, samples, maxima = better
                size = min(size * GROWTH, MAX_SIZE)
                constraints = self._active(turn, constraints)
            if abs(gain) < min_gain or size < MIN_SIZE:
                break
        return turn, cost

    def binding(self, turn: Turn) -> tuple[int, ...]:
        """Handles whose largest speed equals the limit."""
        found = self._evaluated(_unknowns(turn))
        assert found is not None  # Only called with a turn that exists.
        _, handles, logs = found[3]
        return tuple(np.unique(handles[logs > self.log_limit - BINDING]).tolist())

    def _finite_solution(self, x: Array, constraints: Constraints, size: float) -> Array:
        """Solution of the problem with finitely many constraints in the trust region about `x`."""
        count, rows = x.size // 2, len(constraints.handles) + x.size - 1
        guesses = constraints.guesses

        def end_error(y: Array) -> tuple[Array, Array]:
            return ArcPath(self.base, y).end_error()

        # SLSQP takes values and derivatives at the same points separately.
        @lru_cache(1)
        def inequalities(unknowns: bytes) -> tuple[Array, Array]:
            nonlocal guesses
            path = ArcPath(self.base, np.frombuffer(unknowns))
            speeds = self._speeds(path, replace(constraints, guesses=guesses))
            radii, slopes = path.squared_radii()
            inside, of_inside = 1 - radii / self.base.radius**2, -slopes / self.base.radius**2
            if speeds is None:
                # The chain has no position on this path. Violated constraints shorten the step of the line search.
                return np.append(np.full(len(guesses), -1.0), inside), np.zeros((rows, x.size))
            guesses = speeds[0]
            return np.append(self.log_limit - speeds[1], inside), np.vstack([-speeds[2], of_inside])

        sizes = np.repeat([CURVATURE_PER_LENGTH * size, size], count)
        lowest = np.repeat([-self.max_curvature, MIN_ARC], count)
        highest = np.repeat([self.max_curvature, np.inf], count)
        slope = np.repeat([0.0, 1.0], count)
        found = self._minimize(
            lambda y: float(slope @ y),
            x,
            jac=lambda y: slope,
            bounds=np.stack([np.clip(x - sizes, lowest, highest), np.clip(x + sizes, lowest, highest)], axis=-1),
            constraints=[
                {"type": "eq", "fun": lambda y: end_error(y)[0], "jac": lambda y: end_error(y)[1]},
                {
                    "type": "ineq",
                    "fun": lambda y: inequalities(y.tobytes())[0],
                    "jac": lambda y: inequalities(y.tobytes())[1],
                },
            ],
            method="SLSQP",
            options={"maxiter": ITERATIONS, "ftol": TOLERANCE},
        )
        result: Array = found.x
        return result

    def _speeds(self, path: ArcPath, constraints: Constraints) -> tuple[Array, Array, Array] | None:
        self.evaluations += 1
        return constrained_speeds(path, self.spacings, constraints)

    def _evaluated(self, x: Array) -> tuple[Turn, float, tuple[Array, Array], tuple[Array, Indices, Array]] | None:
        """The turn at `x`, its length with a penalty, sampled coordinates and speeds of handles, and their maxima."""
        turn = closed_turn(self.base, x)
        if turn is None:
            return None
        heads = np.arange(0.0, turn.length + HEAD_MARGIN, STEP)
        samples = sampled_speeds(turn.path, self.spacings, heads)
        if samples is None:
            return None
        maxima = speed_maxima(turn.path, self.spacings, heads, samples[1], self.log_limit - PEAK_MARGIN)
        if maxima is None:
            return None
        return turn, turn.length + PENALTY * max(0.0, float(maxima[2].max()) - self.log_limit), samples, maxima

    def _peak_constraints(self, turn: Turn, maxima: tuple[Array, Indices, Array]) -> Constraints:
        """Constraints at the maxima that are not at a kink; the anchor is the handle closest to an end of an arc."""
        heads, handles, _ = maxima
        s = turn.path.chain(heads, self.spacings)
        edges = np.array([0.0, *np.cumsum(turn.lengths)])
        offsets = s[:, :, None] - edges
        behind = np.arange(s.shape[1]) > handles[:, None]
        distances = np.where(behind[..., None], np.inf, np.abs(offsets)).reshape(heads.size, -1)
        closest = distances.argmin(axis=1)
        anchors, ends = np.divmod(closest, edges.size)
        offset = offsets.reshape(heads.size, -1)[np.arange(heads.size), closest]
        return Constraints(anchors, ends, offset, handles, s)[np.abs(offset) > AT_KINK]

    def _kink_constraints(self, turn: Turn, s: Array, logs: Array) -> Constraints:
        """Constraints where a handle passes an end of an arc, for the handles from it on that may exceed the limit."""
        found: list[Constraints] = []
        edges, fast = np.array([0.0, *np.cumsum(turn.lengths)]), logs > self.log_limit - KINK_MARGIN
        for anchor, end in np.ndindex(self.spacings.size, edges.size):
            after = int(np.searchsorted(s[:, anchor], edges[end]))
            if not 0 < after < len(s):
                continue
            handles = np.flatnonzero(fast[after - 1] | fast[after])
            handles = handles[handles >= max(anchor, 1)]
            same = np.full(handles.size, anchor), np.full(handles.size, end), np.zeros(handles.size)
            found.append(Constraints(*same, handles, np.tile(s[after], (handles.size, 1))))
        return sum(found[1:], found[0])

    def _active(self, turn: Turn, constraints: Constraints) -> Constraints:
        """The constraints whose speeds on a turn are close to the limit, with the coordinates on that turn."""
        path = ArcPath(self.base, _unknowns(turn))
        speeds = self._speeds(path, constraints)
        if speeds is None:
            return constraints[np.zeros(len(constraints.handles), dtype=bool)]
        return replace(constraints, guesses=speeds[0])[speeds[1] > self.log_limit - PEAK_MARGIN]
