"""The largest speed of the head at which no handle is too fast in the turn (the contest's question 5).

How much faster than the head a handle is depends on nothing but how far the head has gone. Its largest value is found
by branch and bound: over a stretch of the head's way it is at most its value in the middle plus half the stretch times
a bound on its slope, and stretches that cannot hold the largest value are left out, the others halved. The slopes come
from interval arithmetic on the rigid-bench equations (`collision/bounds.py` has them): with the angles alpha and beta
from a bench to the path's directions at its holes, its spacing L and the path's curvatures there, the rear hole goes
rho = cos alpha / cos beta for each metre of the front hole, and

    drho/ds = (rho^2 kappa_r sin beta - kappa_f sin alpha + omega^2 L) / cos beta,
    omega = (sin alpha - rho sin beta) / L.

Three facts leave little to look at:

- On the way in no handle is faster than the one before it: the end of a spiral's arc that bends more has the larger
  angle to the chord (W. Vogt, "Über monotongekrümmte Kurven", 1914).
- On the way out each one is faster, but all of them together by no more than a bound that depends on the curvature
  kappa at the exit alone. The angle to a chord lies between those on the circles with the largest and the smallest
  curvature of the arc (A. Schur, 1921), so both cosines of a bench lie between c(L, kappa at its front hole) and
  c(L, kappa at its rear hole), where c(L, k) = sqrt(1 - (k L / 2)^2). At a hole between benches of the spacings L and M
  the product has the factor cos alpha / cos beta, which is at most max(1, c(M, kappa) / c(L, kappa)); what remains is
  at most 1 / c(L, kappa) of the last bench.
- Benches but the head are alike, so once the head is out, the picture in the turn repeats with every bench.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite
from pymunk_dragon.curves import Composite, Section, Spiral, UTurn, frame
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.speed import MAX_SPEED, MIN_SPEED
from pymunk_dragon.studies.progress import Progress, silent

__all__ = ["MaxSpeed", "SpeedRatio", "largest_ratio", "max_speed"]

Array = NDArray[np.float64]
Interval = tuple[Array, Array]

# Head's way in the first stretches, in spacings. Longer ones are halved more often, shorter ones cost more at once.
STRETCH = 1 / 16
# Parts whose progress is reported.
PARTS = 2
# First stretches times benches up to which a whole dragon is followed through the turn: some seconds of work.
WORK = 100_000
# Share of the largest ratio to which it is enclosed; and the same of two handles that are equally fast.
EXACT, EQUAL = 1e-11, 1e-10
# Share of a ratio that rounding may be wrong by.
ROUNDING = 1e-13
# m. Shorter stretches have nothing between their ends.
SHORTEST = 1e-12
QUARTER = np.pi / 2
FORWARD = "one on which every hole goes forward all the time"


@dataclass(frozen=True, kw_only=True)
class SpeedRatio:
    """The largest speed of a handle over the head's in a turn.

    Attributes
    ----------
    ratio : float
        Largest speed of a handle for each m/s of the head.
    excess : float
        Share of that by which the true value may be larger.
    handle, handles : int and tuple of int
        The foremost handle with that speed, and all handles with it.
    way : float
        Distance of the head from the entry of the circle at that moment, m.
    looks : int
        Number of moments at which the speeds were computed.
    """

    ratio: float
    excess: float
    handle: int
    handles: tuple[int, ...]
    way: float
    looks: int


@dataclass(frozen=True, kw_only=True)
class MaxSpeed:
    """The answer to how fast the head may go.

    Attributes
    ----------
    speed : float
        Largest speed of the head, m/s.
    limit : float
        Speed that no handle may exceed, m/s.
    ratio : float
        Largest speed of a handle for each m/s of the head; `speed` is `limit` over that.
    excess : float
        By how much, at most, the true largest ratio is larger.
    handle, handles : int and tuple of int
        Who is so fast; the foremost of them, and all of them.
    way, time : float
        How far the head has gone into the circle then, m, and when that is at `speed`, s.
    speeds : tuple of float
        Of the foremost handles at that moment, if the head goes at `speed`, m/s.
    looks : int
        Moments looked at.
    curve : UTurn
        What they march on.
    dragon : Dragon
        Who marches.
    """

    speed: float
    limit: float
    ratio: float
    excess: float
    handle: int
    handles: tuple[int, ...]
    way: float
    time: float
    speeds: tuple[float, ...]
    looks: int
    curve: UTurn
    dragon: Dragon


def max_speed(
    dragon: Dragon | None = None,
    *,
    limit: float = 2.0,
    pitch: float = 1.7,
    radius: float = 4.5,
    ratio: float = 2.0,
    progress: Progress = silent,
) -> MaxSpeed:
    """The largest constant speed of the head for which no handle exceeds a limit, ever, on the path of the U-turn.

    Parameters
    ----------
    dragon : Dragon, optional
        Who marches; by default the contest's. Its benches but the head must be alike.
    limit : float
        m/s.
    pitch, radius, ratio : float
        As in `UTurn`.
    progress : callable, optional
        Called with the number of parts that are done, and of all.

    Returns
    -------
    MaxSpeed
        Its speed is right to `excess` of itself: the largest ratio is enclosed, for all times and all handles. That is
        1e-11 but in turns as gentle as the way out, and of dragons so long that they are not followed as a whole (more
        than some 80 benches of the contest's size), if the last benches may be the fastest, because the head bench is
        hardly longer than the others: then it is about 0.01.

    Raises
    ------
    ParameterError
        If a number cannot be used, the benches behind the head differ, or the circle is so small that the dragon
        cannot stand at it or a bench is pushed back.
    UnreachableError
        If the dragon does not fit round the turn.
    """
    dragon = Dragon() if dragon is None else dragon
    limit = finite("limit", limit, MIN_SPEED, MAX_SPEED, "m/s")
    if not dragon.alike:
        raise ParameterError("dragon", dragon, "one whose benches but the head are alike")
    curve = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    try:
        march = March(dragon, curve)
    except ParameterError as error:
        if error.name != "start":
            raise
        raise ParameterError("radius", radius, "large enough for the dragon to stand at the circle") from error
    try:
        found = largest_ratio(march, progress)
    except ParameterError as error:
        raise ParameterError("radius", radius, "large enough for every hole to go forward all the time") from error
    speed = limit / found.ratio
    speeds = speed * march.at(found.way, min(found.handles[-1] + 3, dragon.handles)).speeds[0]
    return MaxSpeed(
        speed=speed,
        limit=limit,
        time=found.way / speed,
        speeds=tuple(speeds.tolist()),
        curve=curve,
        dragon=dragon,
        **asdict(found),
    )


def largest_ratio(march: March, progress: Progress = silent) -> SpeedRatio:
    """The largest speed of a handle over the head's, for all handles and all times, enclosed by branch and bound.

    Parameters
    ----------
    march : March
        At 1 m/s on a curve that comes in on a spiral and goes out on one, the head being at the end of the first at
        t = 0. Between them are arcs and lines.

    Raises
    ------
    ParameterError
        If a bench stands perpendicular to the path at its front handle: the handle behind is pushed back from there on.
    UnreachableError
        If the dragon does not fit round the turn.
    """
    dragon, search = march.dragon, _Search(march)
    head, whole = float(dragon.spacings[0]), float(dragon.spacings.sum())
    if not dragon.alike:
        search.run(0.0, _out(march, dragon.benches, whole))
        return search.answer(_gain(search.curve, dragon.spacings))
    search.run(0.0, _out(march, 1, head))
    # Once the head is out, what follows it does what benches alike do while the first of them goes on by one bench.
    gain, body = _gain(search.curve, dragon.spacings[:2]), float(dragon.spacings[1:2].sum()) or head
    alike = March(replace(dragon, head_spacing=body), march.curve, start=search.curve.joints[-1])
    followers = _Search(alike, search.ratio / gain)
    followers.run(0.0, _out(alike, 1, body))
    bound = gain
    if followers.found:
        # A bench behind may be faster on top of what the benches on the way out add, which is at most the gain: the
        # moments at which the followers are fastest, for each bench that is out; and then all others, if they are few.
        progress(1, PARTS)
        search.enclose(*_rounds(march, followers.way))
        if whole / (STRETCH * body) * dragon.benches <= WORK:
            search.run(_out(march, 1, head), _out(march, dragon.benches, whole))
        else:
            bound = followers.ratio * gain
    progress(PARTS, PARTS)
    search.looks += followers.looks
    return search.answer(bound)


def _rounds(march: March, phase: float) -> tuple[Array, Array]:
    """Ways of the head, as stretches of no length, at which handle 1, 2, ... is `phase` m behind the exit.

    The benches from there to the head are on the way out, and their places follow from there outward.
    """
    assert isinstance(march.curve, Composite)
    outward = march.curve.pieces[-1]
    spiral = outward.curve if isinstance(outward, Section) else outward
    assert isinstance(spiral, Spiral)
    head, body = float(march.dragon.spacings[0]), float(march.dragon.spacings[-1])
    angles, heads = spiral.angle([outward.begin + phase]), []
    for _ in range(1, march.dragon.benches):
        heads.append(spiral.behind(angles, head))
        angles = spiral.behind(angles, body)
    ways = spiral.arc(np.concatenate(heads)) - outward.begin + march.curve.joints[-1] - march.head_start
    return ways, ways


def _gain(curve: Composite, spacings: Array) -> float:
    """How much faster than the head, at most, benches are that are all on the way out."""
    outward = curve.pieces[-1]
    cosines = np.sqrt(1 - (outward.curvature(outward.begin) * spacings / 2) ** 2)
    return float(np.prod(np.maximum(1.0, cosines[1:] / cosines[:-1])) / cosines[-1])


def _out(march: March, handle: int, step: float) -> float:
    """A way of the head, m, after which `handle` is out of the turn; to within `step`, more or less.

    Raises
    ------
    ParameterError
        If the handle is pushed back.
    """
    assert isinstance(march.curve, Composite)
    exit_place = march.curve.joints[-1]
    way, place = exit_place - march.head_start + step, -np.inf
    while True:
        before, place = place, float(march.parameters(march.time(way), handle + 1)[0, -1])
        if place >= exit_place:
            return way
        if place <= before:
            raise ParameterError("curve", march.curve, FORWARD)
        way += step / 8


class _Search:
    """The largest ratio of a march at 1 m/s that is above a floor, if there is one, and when."""

    def __init__(self, march: March, floor: float = 1.0) -> None:
        assert isinstance(march.curve, Composite)
        self.march, self.curve = march, march.curve
        self.ratio, self.found = floor, False
        self.looks = 0
        self.way, self._handles = 0.0, 1
        self._spacings = march.dragon.spacings

    def run(self, begin: float, end: float) -> None:
        """Enclose the largest ratio on the head's ways from `begin` to `end`, m; as `enclose`."""
        edges = np.linspace(begin, end, int(np.ceil((end - begin) / (STRETCH * self._spacings.min()))) + 1)
        self.enclose(edges[:-1], edges[1:])

    def enclose(self, begins: Array, ends: Array) -> None:
        """Enclose the largest ratio on stretches of the head's way."""
        # Those behind, which are on the way in, are no faster than the last of these.
        ahead = int(np.count_nonzero(self.march.parameters(self.march.time(ends.max()))[0] > 0))
        handles = min(max(2, ahead + 1), self.march.dragon.handles)
        ways, halves = (begins + ends) / 2, (ends - begins) / 2
        parts = [self.march.parameters(way, handles) for way in (begins, ways, ends)]
        while ways.size:
            first, middle, last = parts
            self.looks += ways.size
            ratios, most = self._ratios(first, middle, last)
            self._note(ways, ratios)
            left = np.flatnonzero((most > self.ratio * (1 + EXACT)).any(axis=1))
            if not left.size or 2 * halves.max() < SHORTEST:
                break
            handles = int(np.flatnonzero((most[left] > self.ratio).any(axis=0))[-1]) + 2
            first, middle, last = (part[left, :handles] for part in parts)
            halves = np.tile(halves[left] / 2, 2)
            ways = np.concatenate([ways[left], ways[left]]) + np.repeat([-1, 1], left.size) * halves
            joined = np.concatenate([first, middle]), np.concatenate([middle, last])
            parts = [joined[0], self.march.parameters(ways, handles), joined[1]]

    def _note(self, ways: Array, ratios: Array) -> None:
        largest = ratios.max(axis=1)
        best = int(largest.argmax())
        if largest[best] > self.ratio:
            self.ratio, self.found, self.way = float(largest[best]), True, float(ways[best])
            self._handles = ratios.shape[1] + 1

    def _ratios(self, first: Array, middle: Array, last: Array) -> tuple[Array, Array]:
        """Speeds (K, H - 1) of handles 1 to H - 1 for each m/s of the head: in the middle of stretches, and at most.

        The handles are at `first`, `middle` and `last` (K, H) when a stretch begins, in its middle and at its end.
        """
        spacings = self._spacings[: first.shape[1] - 1]
        points, tangents = (part.view(complex)[..., 0] for part in frame(self.curve, middle))
        facing = ((points[:, :-1] - points[:, 1:]) / spacings).conj()
        front, rear = np.angle(tangents[:, :-1] * facing), np.angle(tangents[:, 1:] * facing)
        if np.any(np.abs(front) >= QUARTER):
            raise ParameterError("curve", self.curve, FORWARD)
        # While both holes go forward they stay between their places at the ends, and no bench turns by more than both
        # of them go, over its spacing.
        ways = np.maximum(middle - first, last - middle)
        swing = ways * self.curve.sharpest(first, last)
        turned = (ways[:, :-1] + ways[:, 1:]) / spacings
        fronts = _about(front, swing[:, :-1] + turned)
        rears = _about(rear, swing[:, 1:] + turned)
        bend = self._bend(first, last)
        lag, slope = _lag(fronts, rears, (bend[0][:, :-1], bend[1][:, :-1]), (bend[0][:, 1:], bend[1][:, 1:]), spacings)
        ratios = np.cumprod(np.cos(front) / np.cos(rear), axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            slowest, fastest = _products(lag[0][:, :-1]), _products(lag[1][:, :-1])
            low, high = _product((slowest, fastest), _quotient(slope, lag))
            change = np.maximum(np.abs(np.cumsum(low, axis=1)), np.abs(np.cumsum(high, axis=1)))
            most = ratios * np.exp(change * ways[:, :1]) * (1 + ROUNDING)
        # Where an angle may come to a right one, nothing is known, of this handle and of those behind.
        known = np.logical_and.accumulate((_largest(fronts) < QUARTER) & (_largest(rears) < QUARTER), axis=1)
        return ratios, np.where(known & np.isfinite(most), most, np.inf)

    def _bend(self, first: Array, last: Array) -> Interval:
        """The least and the largest signed curvature of the path between places.

        On an arc it is constant, on a spiral it only rises or only falls.
        """
        ends = self.curve.curvature(first), self.curve.curvature(last)
        low, high = np.minimum(*ends), np.maximum(*ends)
        for joint, before, after in zip(self.curve.joints, self.curve.pieces[:-1], self.curve.pieces[1:], strict=True):
            here = (first <= joint + SHORTEST) & (last >= joint - SHORTEST)
            for bend in (float(before.curvature(before.end)), float(after.curvature(after.begin))):
                low, high = np.where(here, np.minimum(low, bend), low), np.where(here, np.maximum(high, bend), high)
        return low, high

    def answer(self, bound: float) -> SpeedRatio:
        """The answer that follows from the largest ratio, where none is above `bound` in what was not enclosed."""
        speeds = self.march.at(self.way, self._handles).speeds[0]
        fastest = np.flatnonzero(speeds > self.ratio * (1 - EQUAL)).tolist()
        return SpeedRatio(
            ratio=self.ratio,
            excess=max(EXACT, bound / self.ratio - 1),
            handle=fastest[0],
            handles=tuple(fastest),
            way=self.way,
            looks=self.looks,
        )


def _products(factors: Array) -> Array:
    """Products (K, N + 1) of the first 0, 1, ... of `factors` (K, N)."""
    return np.concatenate([np.ones((len(factors), 1)), np.cumprod(factors, axis=1)], axis=1)


def _lag(
    fronts: Interval, rears: Interval, front_bend: Interval, rear_bend: Interval, spacings: Array
) -> tuple[Interval, Interval]:
    """Way of a bench's rear hole for each metre of its front hole, and how that changes with the metre."""
    sines, cosines = (_sine(fronts), _sine(rears)), (_cosine(fronts), _cosine(rears))
    lag = _quotient(cosines[0], cosines[1])
    turn = _difference(sines[0], _product(lag, sines[1]))
    rear = _product(_product(lag, lag), _product(rear_bend, sines[1]))
    front = _product(front_bend, sines[0])
    (low, high), squared = _difference(rear, front), _product(turn, turn)
    # What is squared is not negative.
    total = low + np.maximum(squared[0], 0.0) / spacings, high + squared[1] / spacings
    return lag, _quotient(total, cosines[1])


def _about(middle: Array, half: Array) -> Interval:
    return middle - half, middle + half


def _largest(angles: Interval) -> Array:
    return np.maximum(np.abs(angles[0]), np.abs(angles[1]))


def _sine(angles: Interval) -> Interval:
    """Of angles up to a right one."""
    return np.sin(angles[0]), np.sin(angles[1])


def _cosine(angles: Interval) -> Interval:
    """Of angles up to a right one; above 0."""
    ends = np.cos(angles[0]), np.cos(angles[1])
    # A right angle has none; what comes of it is not used.
    low = np.maximum(np.minimum(*ends), SHORTEST)
    return low, np.where(angles[0] * angles[1] <= 0, 1.0, np.maximum(np.maximum(*ends), low))


def _difference(one: Interval, other: Interval) -> Interval:
    return one[0] - other[1], one[1] - other[0]


def _product(one: Interval, other: Interval) -> Interval:
    ends = [a * b for a in one for b in other]
    return np.minimum.reduce(ends), np.maximum.reduce(ends)


def _quotient(one: Interval, other: Interval) -> Interval:
    """Over what is above 0."""
    return _product(one, (1 / other[1], 1 / other[0]))
