"""Search for the shortest turn on n arcs on which no handle exceeds a given multiple of the head's speed.

The turn is an optimal-control problem with a piecewise constant control: the curvature of the path that the head
follows. Unknowns are curvature and length of each of n arcs; the length of the turn is minimised so that

- the last arc ends at the circle's exit with the exit's tangent,
- the arcs stay inside the circle, and no radius is smaller than a given one,
- at every moment the speed of every handle is at most a given multiple of the head's.

The last constraint holds at infinitely many moments. It is imposed at finitely many, to which the maxima that are left
are added after each solution (an exchange method for semi-infinite programmes: J. W. Blankenship, J. E. Falk,
"Infinitely constrained optimization problems", J. Optim. Theory Appl. 19, 1976). Each finite problem is solved by
`scipy.optimize.minimize(method="SLSQP")` inside a trust region, with exact derivatives.

A speed has a kink where a handle passes from one arc to the next, and the maxima of the best turns lie there. So each
moment is defined by a handle's distance from an end of an arc, and moves with that end.

The problem is not convex. The search starts from several turns, and its result is the best that was found.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.curves import UTurn, chain
from pymunk_dragon.curves.base import Curve, frame
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.extras import library
from pymunk_dragon.march import March
from pymunk_dragon.studies.max_speed import SpeedRatio, largest_ratio
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.turns import ArcPath, Turn, closed_turn

__all__ = ["Shortest", "shortest_turn"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Indices = NDArray[np.intp]
Solution = tuple[Turn, float]

# Starts on 5 arcs, and on each larger number; and 1/m: standard deviation of the curvatures that are added to those of
# the best turn on three arcs, whose longest arcs are halved. From the best on two arcs fewer the search seldom leaves
# its neighbourhood: on 7 arcs it then ended 0.12 m longer.
STARTS, NOISE = (1, 2), 0.1
# Finite problems for each start, and for the best of them; and solutions with a lower limit after one that does not
# keep to it everywhere.
ROUNDS, LAST_ROUNDS, REPAIRS = 25, 4, 8
# m behind the circle as far as which the chain reaches that is regarded in the search.
LEAD = 3.0

# m of the head's way between evaluations of the speeds; about a maximum they are repeated with a sixteenth of the
# distance, as many times.
STEP, POINTS, PASSES = 0.02, 17, 4
# m beyond the turn as far as which the head goes in the search. The certificate of the result has no such limit.
BEYOND = 9.0
# Logarithms of a speed ratio below that of the limit from which a maximum, and a kink, is constrained.
PEAKS, KINKS = 0.1, 0.2
# m of a handle from an end of an arc, from which a maximum is not at the kink.
AT_KINK = 1e-3
# Least length of an arc, m.
MIN_ARC = 0.02
# Trust region: m of an arc's length, and 1/m of its curvature for each of these; first, largest and last size.
CURVATURE_PER_LENGTH = 2.0
FIRST_SIZE, MAX_SIZE, MIN_SIZE = 0.3, 0.6, 1e-4
GROWTH, SHRINKAGE = 1.6, 1 / 3
# m of length that a unit of the logarithm of a speed ratio above the limit is worth, several times its multiplier.
PENALTY = 10.0
# m by which a solution has to be better for the search to go on: from each start, and from the best of all turns.
SETTLED, FINALLY = 5e-4, 1e-4
# m of penalty from which a turn is not repaired: its fastest handle is above the limit by a hundredth.
HOPELESS = 0.1
# Iterations of SLSQP for each finite problem, and its tolerance, m.
ITERATIONS, TOLERANCE = 40, 1e-7
# Newton steps for the places of a chain, their tolerance and largest step, m, and the least cosine of an angle between
# a bench and the path at either end.
NEWTON_STEPS, NEWTON_SETTLED, NEWTON_STEP, MIN_COSINE = 12, 1e-6, 0.3, 0.02
# Logarithm of the ratio by which the search stays below the limit: several times what SLSQP leaves of a violation. It
# makes the turn some micrometres longer.
MARGIN = 1e-6
# Share of the largest curvature that is left to the step that closes a turn.
ROOM = 1e-6
# Share of the limit from which a handle's largest speed counts as equal to it.
BINDING = 1e-5


@dataclass(frozen=True, eq=False)
class _Moments:
    """Moments at which a handle's speed is constrained: those at which another one is so far from an end of an arc.

    `anchors`, `ends`, `offsets`: that other handle, the end's number, and the distance in m; `handles`: those whose
    speeds are constrained; `places`: a first guess of the places of all handles; one row per moment.
    """

    anchors: Indices
    ends: Indices
    offsets: Array
    handles: Indices
    places: Array

    def __getitem__(self, rows: NDArray[np.bool_] | Indices) -> _Moments:
        return _Moments(*(part[rows] for part in vars(self).values()))

    def __add__(self, other: _Moments) -> _Moments:
        return _Moments(*map(np.concatenate, zip(vars(self).values(), vars(other).values(), strict=True)))


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
        Largest speed of a handle over the head's on this turn, enclosed by branch and bound.
    binding : tuple of int
        Handles whose speed reaches the limit.
    evaluations : int
        Turns for which the speeds were computed.
    """

    turn: Turn
    lengths: tuple[tuple[int, float], ...]
    min_radius: float
    ratio: SpeedRatio
    binding: tuple[int, ...]
    evaluations: int


def shortest_turn(
    base: UTurn, dragon: Dragon, limit: float, arcs: int, min_radius: float, progress: Progress = silent
) -> Shortest:
    """Search for the shortest turn on at most `arcs` arcs on which no handle exceeds `limit` times the head's speed.

    Parameters
    ----------
    base : UTurn
        Spirals and circle.
    dragon : Dragon
        The dragon that goes round.
    limit : float
        Above 1.
    arcs : int
        An odd number from 3; all odd numbers up to it are searched.
    min_radius : float
        Least radius of an arc, m.
    progress : callable, optional
        Called with the number of arcs for which the search is done, and one that stands for the end.

    Raises
    ------
    MissingExtraError
        If SciPy is not installed.
    ParameterError
        If no such turn is found.
    """
    count = 1 + int(np.searchsorted(np.cumsum(dragon.spacings), base.length + LEAD))
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
        for seed in range(STARTS[n > 5]):
            noise = np.concatenate([np.random.default_rng(seed).standard_normal(n), np.zeros(n)])
            found += [turn for turn in (programme.solve(divided + NOISE * noise),) if turn is not None]
        best = min(found, key=lambda solution: solution[1])
        progress(n, arcs + 2)
        lengths.append((n, best))
    too_fast = ParameterError("fastest", limit, "higher: no turn inside the circle was found that keeps to it")
    if best[1] - best[0].length > HOPELESS:
        raise too_fast
    for _ in range(REPAIRS):
        # The certificate regards all handles at all times.
        ratio = largest_ratio(March(dragon, best[0].path))
        if ratio.ratio <= limit:
            break
        programme.floor -= np.log(ratio.ratio / limit) + MARGIN
        best = programme.solve(_unknowns(best[0]), LAST_ROUNDS, FINALLY) or best
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
    return np.array([*turn.curvatures, *turn.lengths])


def _divided(x: Array, times: int) -> Array:
    """The same turn with the longest arc halved, so many times."""
    curvatures, lengths = (part.tolist() for part in np.split(x, 2))
    for _ in range(times):
        longest = int(np.argmax(lengths))
        lengths[longest : longest + 1] = [lengths[longest] / 2] * 2
        curvatures.insert(longest, curvatures[longest])
    return np.array([*curvatures, *lengths])


class _Programme:
    """The search among turns on a fixed number of arcs."""

    def __init__(self, base: UTurn, spacings: Array, limit: float, min_radius: float) -> None:
        self.base, self.spacings = base, spacings
        self.floor = np.log(limit) - MARGIN
        self.max_curvature = (1 - ROOM) / min_radius
        self.evaluations = 0
        self._minimize = library("scipy.optimize").minimize

    def solve(self, start: Array, rounds: int = ROUNDS, settled: float = SETTLED) -> Solution | None:
        """The best turn from a start (2 n,), and its length with the penalty; None if the start is no turn.

        The search ends where a solution is better by less than `settled` m.
        """
        found = self._measured(start)
        if found is None:
            return None
        turn, cost, table, tops = found
        moments, size = self._maxima(turn, tops), FIRST_SIZE
        for _ in range(rounds):
            x = _unknowns(turn)
            kinks = self._kinks(turn, *table)
            better = self._measured(self._finite(x, moments + kinks, size))
            if better is not None:
                moments = moments + self._maxima(better[0], better[3])
            gain = -np.inf if better is None else cost - better[1]
            if better is None or gain <= 0:
                size *= SHRINKAGE
            else:
                turn, cost, table, tops = better
                size = min(size * GROWTH, MAX_SIZE)
                moments = self._near_the_limit(turn, moments)
            if abs(gain) < settled or size < MIN_SIZE:
                break
        return turn, cost

    def binding(self, turn: Turn) -> tuple[int, ...]:
        """Handles whose largest speed equals the limit."""
        found = self._measured(_unknowns(turn))
        assert found is not None
        _, handles, logs = found[3]
        return tuple(np.unique(handles[logs > self.floor - BINDING]).tolist())

    def _finite(self, x: Array, moments: _Moments, size: float) -> Array:
        """Solution of the problem with finitely many moments in the trust region about `x`."""
        count, last = x.size // 2, b""
        ahead: tuple[Array, Array] = np.empty(0), np.empty((0, 0))
        places = moments.places

        def spare(y: Array) -> tuple[Array, Array]:
            nonlocal last, ahead, places
            if y.tobytes() != last:
                last = y.tobytes()
                path = ArcPath(self.base, y)
                speeds = self._speeds(path, replace(moments, places=places))
                radii, slopes = path.squared_radii()
                inside = 1 - radii / self.base.radius**2, -slopes / self.base.radius**2
                if speeds is None:
                    # No chain stands there: the line search has to come back.
                    ahead = np.append(np.full(places.shape[0], -1.0), inside[0]), np.zeros((ahead_rows, y.size))
                else:
                    places = speeds[0]
                    ahead = np.append(self.floor - speeds[1], inside[0]), np.vstack([-speeds[2], inside[1]])
            return ahead

        ahead_rows = places.shape[0] + x.size - 1
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
                {
                    "type": "eq",
                    "fun": lambda y: ArcPath(self.base, y).end_error()[0],
                    "jac": lambda y: ArcPath(self.base, y).end_error()[1],
                },
                {"type": "ineq", "fun": lambda y: spare(y)[0], "jac": lambda y: spare(y)[1]},
            ],
            method="SLSQP",
            options={"maxiter": ITERATIONS, "ftol": TOLERANCE},
        )
        result: Array = found.x
        return result

    def _speeds(self, path: ArcPath, moments: _Moments) -> tuple[Array, Array, Array] | None:
        """Places (M, H) of the handles at moments, logarithms (M,) of the speed ratios and derivatives (M, 2 n).

        With the cosines a and b of a bench's angles to the path at its front and rear handle, a rigid bench lets the
        rear handle go a / b for each metre of the front one. None where a chain has no such place, or stands
        perpendicular to the path.
        """
        self.evaluations += 1
        # Several handles are constrained at one moment.
        same = np.stack([moments.anchors, moments.ends, moments.offsets])
        _, first, inverse = np.unique(same, axis=1, return_index=True, return_inverse=True)
        given, moments = moments, moments[first]
        settled = self._settled(path, moments)
        if settled is None:
            return None
        places, points, tangents, curvatures = settled
        rows, benches = np.arange(len(places)), self.spacings.size
        facing = ((points[:, :-1] - points[:, 1:]) / self.spacings).conj()
        front, rear = facing * tangents[:, :-1], facing * tangents[:, 1:]
        logs = _logs(front.real, rear.real)
        rates = np.exp(logs)[..., None]
        of_points, of_headings = path.partials(places, points, tangents, curvatures)
        # Derivatives of the places, the head being fixed, from the constant length of each bench; and then with the
        # anchor at its distance from the end of an arc.
        moved = np.zeros_like(of_headings)
        for i in range(benches):
            along = (facing[:, i, None] * (of_points[:, i] - of_points[:, i + 1])).real
            moved[:, i + 1] = (along + front[:, i, None].real * moved[:, i]) / rear[:, i, None].real
        anchors = moments.anchors
        ends = np.zeros((rows.size, of_headings.shape[-1]))
        ends[:, path.count :] = np.arange(path.count) < moments.ends[:, None]
        head = (ends - moved[rows, anchors]) / rates[rows, anchors]
        moved += rates * head[:, None]
        of_points += tangents[..., None] * moved
        of_headings += curvatures[..., None] * moved
        turned = (facing[..., None] * (of_points[:, :-1] - of_points[:, 1:])).imag / self.spacings[:, None]
        change = (rear.imag / rear.real)[..., None] * (of_headings[:, 1:] - turned)
        change -= (front.imag / front.real)[..., None] * (of_headings[:, :-1] - turned)
        handles = given.handles
        return places[inverse], logs[inverse, handles], np.cumsum(change, axis=1)[inverse, handles - 1]

    def _settled(self, path: ArcPath, moments: _Moments) -> tuple[Array, Complex, Complex, Array] | None:
        """Places (M, H), points, tangents and curvatures of the handles at moments, by Newton's method."""
        places, rows = moments.places.copy(), np.arange(len(moments.places))
        goals = path.edges[moments.ends] + moments.offsets
        for _ in range(NEWTON_STEPS):
            points, tangents, curvatures = path.at(places)
            between = points[:, :-1] - points[:, 1:]
            distances = np.abs(between)
            facing = (between / distances).conj()
            front, rear = (facing * tangents[:, :-1]).real, (facing * tangents[:, 1:]).real
            if not min(front.min(), rear.min()) > MIN_COSINE:
                return None
            excess, steps = distances - self.spacings, np.zeros_like(places)
            steps[rows, moments.anchors] = goals - places[rows, moments.anchors]
            for i in range(self.spacings.size):
                behind = (front[:, i] * steps[:, i] + excess[:, i]) / rear[:, i]
                steps[:, i + 1] = np.where(moments.anchors <= i, behind, steps[:, i + 1])
            for i in range(self.spacings.size - 1, -1, -1):
                ahead = (rear[:, i] * steps[:, i + 1] - excess[:, i]) / front[:, i]
                steps[:, i] = np.where(moments.anchors > i, ahead, steps[:, i])
            steps = np.clip(steps, -NEWTON_STEP, NEWTON_STEP)
            places += steps
            if np.abs(steps).max() < NEWTON_SETTLED:
                # What a step changes is known to its square.
                return places, points + steps * tangents, tangents * np.exp(1j * curvatures * steps), curvatures
        return None

    def _measured(self, x: Array) -> tuple[Turn, float, tuple[Array, Array], tuple[Array, Indices, Array]] | None:
        """The turn at `x`, its length with a penalty, its places and speeds at many moments, and their maxima."""
        turn = closed_turn(self.base, x)
        if turn is None:
            return None
        heads = np.arange(0.0, turn.length + BEYOND, STEP)
        table = _evaluated(turn.path, self.spacings, heads)
        tops = None if table is None else _maxima(turn.path, self.spacings, heads, table[1], self.floor - PEAKS)
        if table is None or tops is None:
            return None
        return turn, turn.length + PENALTY * max(0.0, float(tops[2].max()) - self.floor), table, tops

    def _maxima(self, turn: Turn, tops: tuple[Array, Indices, Array]) -> _Moments:
        """Moments of the maxima that are at no kink; the anchor is the handle that is nearest to the end of an arc."""
        heads, handles, _ = tops
        places = chain(turn.path, heads, self.spacings)
        edges = np.array([0.0, *np.cumsum(turn.lengths)])
        offsets = places[:, :, None] - edges
        behind = np.arange(places.shape[1]) > handles[:, None]
        distances = np.where(behind[..., None], np.inf, np.abs(offsets)).reshape(heads.size, -1)
        nearest = distances.argmin(axis=1)
        anchors, ends = np.divmod(nearest, edges.size)
        offset = offsets.reshape(heads.size, -1)[np.arange(heads.size), nearest]
        return _Moments(anchors, ends, offset, handles, places)[np.abs(offset) > AT_KINK]

    def _kinks(self, turn: Turn, places: Array, logs: Array) -> _Moments:
        """Moments at which a handle passes an end of an arc, where one of the handles from it on may be too fast."""
        found: list[_Moments] = []
        edges, fast = np.array([0.0, *np.cumsum(turn.lengths)]), logs > self.floor - KINKS
        for anchor, end in np.ndindex(self.spacings.size, edges.size):
            after = int(np.searchsorted(places[:, anchor], edges[end]))
            if not 0 < after < len(places):
                continue
            handles = np.flatnonzero(fast[after - 1] | fast[after])
            handles = handles[handles >= max(anchor, 1)]
            same = np.full(handles.size, anchor), np.full(handles.size, end), np.zeros(handles.size)
            found.append(_Moments(*same, handles, np.tile(places[after], (handles.size, 1))))
        return sum(found[1:], found[0])

    def _near_the_limit(self, turn: Turn, moments: _Moments) -> _Moments:
        """Those of the moments at which a handle is nearly as fast as the limit, with their places on a turn."""
        path = ArcPath(self.base, _unknowns(turn))
        speeds = self._speeds(path, moments)
        if speeds is None:
            return moments[np.zeros(len(moments.handles), dtype=bool)]
        return replace(moments, places=speeds[0])[speeds[1] > self.floor - PEAKS]


def _logs(front: Array, rear: Array) -> Array:
    """Logarithms (..., H) of the handles' speeds over the head's from the cosines at both ends of the benches."""
    logs = np.cumsum(np.log(front) - np.log(rear), axis=-1)
    return np.concatenate([np.zeros((*logs.shape[:-1], 1)), logs], axis=-1)


def _evaluated(curve: Curve, spacings: Array, heads: Array) -> tuple[Array, Array] | None:
    """Places and logarithms of the speed ratios, each (T, H), at places of the head.

    None where a handle has no place or does not go forward.
    """
    places = chain(curve, heads, spacings)
    points, tangents = frame(curve, places)
    along = points[:, :-1] - points[:, 1:]
    front, rear = (np.sum(part * along, axis=-1) / spacings for part in (tangents[:, :-1], tangents[:, 1:]))
    # Written so that nan fails.
    return (places, _logs(front, rear)) if np.all(front > 0) and np.all(rear > 0) else None


def _maxima(
    curve: Curve, spacings: Array, heads: Array, logs: Array, floor: float
) -> tuple[Array, Indices, Array] | None:
    """Local maxima above a floor of the logarithms (T, H): places of the head, handles, and values."""
    beside = np.pad(logs, ((1, 1), (0, 0)), constant_values=-np.inf)
    rows, handles = np.nonzero((logs >= beside[:-2]) & (logs >= beside[2:]) & (logs > floor))
    rows, handles = rows[handles > 0], handles[handles > 0]
    low, high = heads[np.maximum(rows - 1, 0)], heads[np.minimum(rows + 1, heads.size - 1)]
    chosen = np.arange(rows.size)
    for _ in range(PASSES):
        ways = np.linspace(low, high, POINTS, axis=-1)
        found = _evaluated(curve, spacings, ways.ravel())
        if found is None:
            return None
        own = found[1].reshape(*ways.shape, -1)[chosen, :, handles]
        best = own.argmax(axis=1)
        low, high = ways[chosen, np.maximum(best - 1, 0)], ways[chosen, np.minimum(best + 1, POINTS - 1)]
    return ways[chosen, best], handles, own[chosen, best]
