"""The shortest turn inside a circle on which nobody has to hurry more than is allowed.

It is sought among turns on three arcs (`turns.py`), of which the middle one may be straight. Its length is known in
closed form. What limits it is how many times as fast as the head each handle comes to be, which is measured on a chain
long enough to fill the turn. Both are linearised about the best turn so far, the small linear programme that this makes
is solved by looking at all its vertices, and its step is taken where it leads to something better (sequential linear
programming with a trust region; J. Nocedal and S. Wright, Numerical Optimization, chapter 18).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.curves import Curve, UTurn, chain
from pymunk_dragon.curves.base import frame
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.studies.turns import Turn, three_arcs

__all__ = ["LEAD", "Shortest", "hurry", "shortest_turn"]

Array = NDArray[np.float64]
Look = tuple[float, Array]

# m of the head's way between looks at how fast handles are. A peak of a handle's speed is some tenths of a metre wide.
LOOK = 0.05
# Peaks of each handle that are looked at closely, at most: its highest.
TOPS = 4
# Share of the highest speed from which a peak is looked at closely: points in its bracket, and passes, each of
# which narrows it to a sixteenth; in the end it is known to 1e-7 m.
CLOSE, POINTS, PASSES = 0.8, 33, 5
# m: from before the turn, behind which the chain that is looked at reaches as well, to so far beyond it goes its head.
# By then body benches have followed it all the way round.
LEAD, BEYOND = 3.0, 9.0
# Share of the circle's radius that both arcs have to begin with.
FIRST_GUESS = 0.45
# Share of an unknown's scale over which differences are taken, and that of the first step.
DIFFERENCE, FIRST_STEP = 1e-4, 0.05
# A step is taken if the turn gets better by so much of what the linear programme promises; from the second share on the
# next step may be longer.
TAKEN, TRUSTED = 0.1, 0.75
# Share of the length by which the turn has to promise to get shorter for another step, and steps at most.
SETTLED, STEPS = 1e-7, 120
# Circle's radii by which a turn counts as longer for each unit by which the inverse of a handle's speed is too low:
# several times what it is worth at a shortest turn.
PENALTY = 10.0
# Handles whose limits are put into the linear programme: those nearest to them. Others' peaks are not known so well.
WATCHED = 6
# Share of the limit by which the search may leave it; and by which it counts as reached.
EXCESS, REACHED = 1e-7, 1e-4
# m, and by how much of their scales the unknowns may be adapted to so much: several times as much as it takes.
MILLIMETRE, ADAPTED = 1e-3, 1e-3
# Limits between which several starts led the contest's dragon to the same turn, to 1e-5 m, or to none.
SURE = 1.3, 1.7
# Vertices of the linear programme that are none, and what rounding may do to them.
SINGULAR, ROUNDING = 1e-12, 1e-12


@dataclass(frozen=True, kw_only=True)
class Shortest:
    """The shortest turn found.

    Attributes
    ----------
    turn : Turn
        On three arcs.
    binding : tuple of int
        Handles that come to be as fast as is allowed.
    late, early : float
        By how much the turn would become longer for each metre by which the inward spiral was left later, or the
        outward one joined earlier, inside the circle, if it was adapted as well as possible otherwise. Above zero: it
        is best to turn at once.
    sure : bool
        Whether the limit is from 1.3 to 1.7, where searches from other starts found no shorter turn. With faster
        dancers several handles come to the limit at once, and the search gets caught between them.
    looks : int
        Turns looked at.
    """

    turn: Turn
    binding: tuple[int, ...]
    late: float
    early: float
    sure: bool
    looks: int


def hurry(curve: Curve, spacings: Array, since: float, until: float) -> tuple[Array, Array] | None:
    """How many times as fast as the head each handle becomes while the head goes from one place to another.

    Parameters
    ----------
    curve : Curve
        What they go on.
    spacings : ndarray, shape (N,)
        As in `chain`, m.
    since, until : float
        Places of the head, m.

    Returns
    -------
    peaks : ndarray, shape (N + 1,)
        Highest speeds over the head's; those far below the highest of all are right to a tenth only.
    heads : ndarray, shape (N + 1,)
        Where the head is then, m.
    None where a handle has no place at some time.
    """
    heads = np.linspace(since, until, int(np.ceil((until - since) / LOOK)) + 1)
    speeds = _speeds(curve, spacings, heads)
    if np.isnan(speeds).any():
        return None
    # The highest places that are no lower than both beside them.
    beside = np.pad(speeds, ((1, 1), (0, 0)), constant_values=-np.inf)
    tops = np.where((speeds >= beside[:-2]) & (speeds >= beside[2:]), speeds, -np.inf)
    times = np.argsort(-tops, axis=0, kind="stable")[:TOPS]
    peaks, places = speeds.max(axis=0), heads[times[0]]
    rows, handles = np.nonzero(np.take_along_axis(tops, times, axis=0) >= CLOSE * peaks.max())
    around = times[rows, handles]
    low, high = heads[np.maximum(around - 1, 0)], heads[np.minimum(around + 1, heads.size - 1)]
    chosen = np.arange(handles.size)
    for _ in range(PASSES):
        ways = np.linspace(low, high, POINTS, axis=-1)
        speeds = _speeds(curve, spacings[: handles.max()], ways.ravel())
        if np.isnan(speeds).any():
            return None
        own = speeds.reshape(*ways.shape, -1)[chosen, :, handles]
        best = own.argmax(axis=1)
        low, high = ways[chosen, np.maximum(best - 1, 0)], ways[chosen, np.minimum(best + 1, POINTS - 1)]
    for handle, peak, way in zip(handles, own[chosen, best], ways[chosen, best], strict=True):
        if peak > peaks[handle]:
            peaks[handle], places[handle] = peak, way
    return peaks, places


def _speeds(curve: Curve, spacings: Array, heads: Array) -> Array:
    """Speeds (T, H) of the handles over that of the head, at places (T,) of the head."""
    points, tangents = frame(curve, chain(curve, heads, spacings))
    along = points[:, :-1] - points[:, 1:]
    lags = np.sum(tangents[:, :-1] * along, axis=-1) / np.sum(tangents[:, 1:] * along, axis=-1)
    return np.concatenate([np.ones((heads.size, 1)), np.abs(np.cumprod(lags, axis=1))], axis=1)


def shortest_turn(base: UTurn, spacings: Array, limit: float) -> Shortest:
    """The shortest turn on three arcs on which no handle ever is more than `limit` times as fast as the head.

    Parameters
    ----------
    base : UTurn
        Between whose spirals, inside whose circle.
    spacings : ndarray, shape (N,)
        Of the chain that goes round, m.
    limit : float
        Above 1.

    Raises
    ------
    ParameterError
        If no such turn is found: the limit is too low.
    """
    return _Search(base, spacings, limit).run()


class _Search:
    """Looks at turns; x are the radii of the first and the last arc, and the bend between, each over its scale."""

    def __init__(self, base: UTurn, spacings: Array, limit: float) -> None:
        self._base, self._limit = base, limit
        # As many benches as fill the contest's turn: the shortest one is shorter.
        count = 1 + int(np.searchsorted(np.cumsum(spacings), base.length + LEAD))
        self._spacings = spacings[:count]
        self._scales = np.array([base.radius, base.radius, 1 / base.radius])
        self._penalty = PENALTY * base.radius
        self._looks = 0

    def run(self) -> Shortest:
        x, size = np.array([FIRST_GUESS, FIRST_GUESS, 0.0]), FIRST_STEP
        here = self._look(x)
        if here is None:
            raise ParameterError("radius", self._base.radius, "large enough for the dragon to turn in the circle")
        slopes = self._slopes(x, here)
        for _ in range(STEPS):
            step, cost = _linear_step(slopes, here[1], size, self._penalty)
            gain = self._excess(here) - cost
            if gain < SETTLED * here[0]:
                break
            there = self._look(x + step)
            if there is not None and self._merit(there) > self._merit(here) - TRUSTED * gain:
                # Limits are no straight lines: the same programme again, right for what is to spare there.
                step, _ = _linear_step(slopes, there[1] - slopes[1] @ step, size, self._penalty)
                there = self._look(x + step)
            better = -np.inf if there is None else self._merit(here) - self._merit(there)
            size = size * 2 if better >= TRUSTED * gain else size / 3
            if there is not None and better >= TAKEN * gain:
                x, here = x + step, there
                slopes = self._slopes(x, here)
        turn = self._turn(x)
        if turn is None or here[1].min() < -EXCESS:
            raise ParameterError("fastest", self._limit, "higher: no turn inside the circle was found that keeps to it")
        return self._answer(x, here, turn)

    def _turn(self, x: Array, late: float = 0.0, early: float = 0.0) -> Turn | None:
        first, second, bend = (x * self._scales).tolist()
        return three_arcs(self._base, first, second, bend, late=late, early=early) if min(first, second) > 0 else None

    def _look(self, x: Array, late: float = 0.0, early: float = 0.0) -> Look | None:
        """Length of a turn, and how much the inverse of each handle's highest speed is above that of the limit."""
        self._looks += 1
        turn = self._turn(x, late, early)
        if turn is None:
            return None
        found = hurry(turn.path, self._spacings, -LEAD, turn.length + BEYOND)
        return None if found is None else (turn.length, 1 / found[0][1:] - 1 / self._limit)

    def _merit(self, look: Look) -> float:
        """Length of a turn, and a penalty for speeds above the limit."""
        return look[0] + self._excess(look)

    def _excess(self, look: Look) -> float:
        return self._penalty * max(0.0, -float(look[1].min()))

    def _slopes(self, x: Array, here: Look) -> tuple[Array, Array]:
        """Change of the length (3,), and of what each handle has to spare (N, 3), for each unit of x."""
        columns = [self._slope(x, here, unit, 0.0, 0.0) for unit in np.eye(3)]
        return np.array([growth for growth, _ in columns]), np.stack([spare for _, spare in columns], axis=-1)

    def _slope(self, x: Array, here: Look, unit: Array, late: float, early: float) -> Look:
        """Change of both for a small step, over its size."""
        for side in (1, -1):
            there = self._look(x + side * DIFFERENCE * unit, side * DIFFERENCE * late, side * DIFFERENCE * early)
            if there is not None:
                over = side * DIFFERENCE
                return (there[0] - here[0]) / over, (there[1] - here[1]) / over
        raise DragonError("the shortest turn lies where the dragon can hardly go round: ask for a lower fastest")

    def _answer(self, x: Array, here: Look, turn: Turn) -> Shortest:
        change, penalty = self._slopes(x, here), self._penalty
        _, cost = _linear_step(change, here[1], ADAPTED, penalty)
        costs = []
        for late, early in ((1.0, 0.0), (0.0, 1.0)):
            # How well the rest can be adapted, by the slopes, where a millimetre more of a spiral is kept.
            longer, spare = self._slope(x, here, np.zeros(3), late, early)
            _, dearer = _linear_step(change, here[1] + MILLIMETRE * spare, ADAPTED, penalty)
            costs.append(longer + (dearer - cost) / MILLIMETRE)
        return Shortest(
            turn=turn,
            binding=tuple((np.flatnonzero(here[1] < REACHED) + 1).tolist()),
            late=costs[0],
            early=costs[1],
            sure=SURE[0] <= self._limit <= SURE[1],
            looks=self._looks,
        )


def _linear_step(change: tuple[Array, Array], spare: Array, size: float, penalty: float) -> tuple[Array, float]:
    """The step d (3,), none of its parts above `size`, that is best by the slopes of length and spare; and its cost.

    That is growth d + penalty t, the smallest where t >= 0 and spare + slopes d + t >= 0: the best of all points where
    four of these conditions are just met.
    """
    growth, slopes = change
    watched = np.argsort(spare)[:WATCHED]
    unit = np.eye(4)
    left = np.concatenate([np.column_stack([slopes[watched], np.ones(watched.size)]), unit[:3], -unit[:3], unit[3:]])
    right = np.concatenate([-spare[watched], np.full(6, -size), [0.0]])
    chosen = np.array(list(combinations(range(right.size), 4)))
    chosen = chosen[np.abs(np.linalg.det(left[chosen])) > SINGULAR]
    points = np.linalg.solve(left[chosen], right[chosen][..., None])[..., 0]
    costs = points @ np.append(growth, penalty)
    # The smallest step keeps everything that is met at the start, so there always is a vertex.
    costs[np.any(points @ left.T < right - ROUNDING * (1 + np.abs(right)), axis=1)] = np.inf
    best = int(costs.argmin())
    return points[best, :3], float(costs[best])
