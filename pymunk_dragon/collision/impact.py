"""The first contact in continuous time, with every moment before it ruled out by a bound on the motion.

Looking at the dragon every so often and bisecting misses a contact that opens again between two looks. Here a stretch
of time is cleared only by proof: where two benches are in its middle, and how far each may move from there within it
(`motion.py`), leave a gap between them. A stretch that is not cleared is halved, down to a picosecond: conservative
advancement (B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996) on all pairs at once.

How fast the head goes does not matter: where the dragon is depends on nothing but how far the head has gone. So the
search goes by that way, and times are only worked out of it in the end.

Where all benches but the head are alike, few pairs have to be watched for long. Let s_i(t) be the place of hole i. The
rear hole of bench i is at s_{i+1} = g(s_i), with one and the same function g for all benches behind the head
(`curves/continuation.py`; checked by `Continuation.alike`). So the poses of benches i and j > i are functions of s_i
alone, and benches i - 1 and j - 1 are in the same two poses whenever s_{i-1} has the same value, if i >= 2.

Claim: at the time t of a first contact some touching pair (i, j) has i <= 1 or s_i(t) < s_{i-1}(start). Proof: else
take a touching pair, which has i >= 2 and s_i(t) >= s_{i-1}(start). As s_i(t) < s_{i-1}(t) and s_{i-1} is continuous,
it had the value s_i(t) at some time between the start and t, before t. Then benches i - 1 and j - 1 touched at that
time, which is earlier than the first contact: a contradiction. No hole has to move forward for this, and none does
where a long head bench pushes the chain back. So pairs with i <= 1 are tested all the time, and other pairs in every
stretch in which s_i may be below s_{i-1}(start). Where benches differ, or follow different functions, all pairs are
tested to the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite
from pymunk_dragon.collision.motion import Motion, Stretches, handles_in_reach, near_pairs
from pymunk_dragon.collision.sat import separation
from pymunk_dragon.contact import Contact
from pymunk_dragon.curves.base import point
from pymunk_dragon.dragon import bench_poses
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March, check_march, last_time

__all__ = ["Clearance", "Impact", "Status", "first_contact"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
Progress = Callable[[float, float], None]
Status = Literal["contact", "clear", "overlapping", "unreachable"]

# Shortest spacings that the head goes in one of the stretches to begin with; others only change how often it is halved.
STRETCH = 1.2
# The same while all pairs have to be watched: short, because each is looked at again in both halves.
SHORT_STRETCH = 0.3
# Stretches looked at together: few enough to stop soon after a contact, enough to make NumPy worth its calls.
WINDOW = 128
# m. A gap that may be so far below zero within a stretch, and that rounding may have, is called open: positions are
# hardly more exact.
STILL = 8e-12
# The same where gaps stay near zero for so long that halving leads to a crowd: work at one length of the stretches that
# is above `CROWD` for the whole search, or above the least share of it for a window. The excess coarsens it, squared.
CROWDED, CROWD, LEAST_SHARE = 1e-6, 2_000_000, 0.05
# Work of a pair tested, in benches placed; and by how much halving may multiply the work in a window before that.
PAIR_WORK, GROWTH = 20, 8
# m of the head's way, and its last digits. Shorter stretches are decided by their middle: positions are no more exact.
RESOLUTION, LAST_DIGITS = 1e-12, 4
# Where so few pairs are left, stretches are halved this often before the next look, which costs NumPy as much for one.
FEW, HALVINGS = 8, 3
# Smallest gaps below this share of a bench's width are near misses: 1 cm at the contest's 0.3 m.
NEAR = 1 / 30
# Widths that the head goes between looks at two benches that are so near: a smallest gap lasts about one.
NEAR_STRETCH = 0.4
# Points looked at in each bracket of a smallest gap, and passes; each pass narrows the bracket eightfold.
NEAR_POINTS, NEAR_PASSES = 17, 8
# Handles placed together for that: 20 MB of corners.
NEAR_HANDLES = 300_000
# Moments looked at together, on the way to the last one at which the chain has a place.
LAST_POINTS = 33
# m of head's way, and share of its bracket: so close to an end of it a gap is not smallest, but falls beyond.
NEAR_END, NEAR_END_SHARE = 1e-9, 1e-6


@dataclass(frozen=True, kw_only=True)
class Clearance:
    """A smallest gap between two benches.

    Attributes
    ----------
    time : float
        s; right to a few microseconds only, because a gap that is smallest hardly changes.
    benches : tuple of int
        The smaller number first.
    gap : float
        m.
    """

    time: float
    benches: tuple[int, int]
    gap: float


@dataclass(frozen=True, kw_only=True)
class Impact:
    """The answer to when benches that are not neighbours first touch.

    Attributes
    ----------
    status : {"contact", "clear", "overlapping", "unreachable"}
        Two benches come to touch; none do until the end; two overlap at the start already; the curve has no place for
        some handle any more, and none touched before.
    time : float
        Of the contact; of the end; of the start; when the last place was, s.
    benches : tuple of int or None
        The two that touch or overlap, the smaller number first.
    point : tuple of float or None
        Where they touch, m.
    normal : tuple of float or None
        Unit vector from the first bench towards the second.
    clearances : tuple of Clearance or None
        Smallest gaps below a thirtieth of the width before `time`, in the order of time; where all benches behind the
        head do the same one after the other, only those of benches 0 and 1. None where nobody measured gaps.
    looks : int
        Moments at which the dragon was looked at.
    tests : int
        Pairs of benches tested at all of them together.
    resolution : float or None
        m. Before `time`, benches may overlap by this much and no more: by what rounding leaves open, and where a gap
        stays near zero for long, by about a micrometre. None where nothing was certified.
    """

    status: Status
    time: float
    benches: tuple[int, int] | None
    point: tuple[float, float] | None
    normal: tuple[float, float] | None
    clearances: tuple[Clearance, ...] | None
    looks: int
    tests: int
    resolution: float | None = None

    @property
    def contact(self) -> Contact | None:
        """The same as a contact of a run; None where none came, and where benches overlapped at the start."""
        if self.status != "contact" or self.benches is None or self.point is None or self.normal is None:
            return None
        return Contact(
            time=self.time,
            raw_time=self.time,
            benches=self.benches,
            point=self.point,
            normal=self.normal,
            depth=0.0,
        )

    @classmethod
    def at(cls, march: March, status: Status, time: float, pair: tuple[int, int] | None, **others: Any) -> Impact:
        """The answer with the point and the normal of the benches `pair`, if there is one, at `time`."""
        if pair is None:
            return cls(status=status, time=time, benches=None, point=None, normal=None, **others)
        poses = march.at(time, handles=pair[1] + 2).poses[0]
        corners = march.dragon.outlines(poses)
        found = separation(*corners[list(pair)])
        (x, y), (nx, ny) = found.point.tolist(), found.normal.tolist()
        return cls(status=status, time=time, benches=pair, point=(x, y), normal=(nx, ny), **others)


def first_contact(
    march: March, *, start: float = 0.0, until: float | None = None, progress: Progress | None = None
) -> Impact:
    """First contact of benches that are not neighbours, certified: there is no earlier one, however short.

    What the certificate rests on is told at the head of this module.

    Parameters
    ----------
    march : March
        What to look at.
    start, until : float
        Times between which to look, s; without `until`, to the end of the curve.
    progress : callable, optional
        Told how far the march is cleared, and `until`, s.

    Returns
    -------
    Impact
        Its time is right to 1e-11 s where the gap closes at centimetres a second, as the seed's does, and in general to
        the time in which it closes by its `resolution`. Benches that graze each other more lightly count as apart.

    Raises
    ------
    ParameterError
        If one of the times is no number, or `until` is not later than `start`.
    UnreachableError
        If the dragon has no place at `start`.
    """
    start, until = checked_times(march, start, until)
    steady = March(march.dragon, march.curve, start=march.head_start)
    begin, end = march.way([start, until]).tolist()
    if until == march.end:
        # Not a rounding beyond it.
        end = steady.end

    def tell(cleared: float, last: float) -> None:
        if progress is not None:
            progress(float(march.time(cleared)), until)

    found = _Search(steady).run(begin, end, tell)
    # The times that were given stay as they were given.
    time = {begin: start, end: until}.get(found.time, float(march.time(found.time)))
    misses = [replace(miss, time=float(march.time(miss.time))) for miss in found.clearances or ()]
    return replace(found, time=time, clearances=tuple(misses))


def checked_times(march: March, start: float, until: float | None) -> tuple[float, float]:
    """Both as floats, `until` by default the end of the curve; a `ParameterError` if the one is not after the other."""
    check_march(march)
    start = finite("start", start, -np.inf, np.inf, "s")
    until = last_time(march, start) if until is None else finite("until", until, -np.inf, np.inf, "s")
    if until <= start:
        raise ParameterError("until", until, f"later than the start, {start:g} s")
    return start, until


class _Search:
    """What is known so far of a march at 1 m/s: the earliest touch, and where gaps are small.

    Its times are the head's ways.
    """

    def __init__(self, march: March) -> None:
        self._march = march
        dragon = march.dragon
        narrowest = float(dragon.widths.min())
        self._near = NEAR * narrowest
        self._near_stretch = NEAR_STRETCH * narrowest
        self._stretch = STRETCH * dragon.spacings.min()
        self._short_stretch = SHORT_STRETCH * dragon.spacings.min()
        self._hit, self._pair = np.inf, (0, 0)
        # Places of the holes at the start, and whether all benches behind the head follow each other.
        self._begins, self._alike = np.empty(0), False
        self._looks = self._tests = 0
        self._resolution = 0.0
        self._whole = 1.0
        self._familiar_from = np.inf
        # Rows of pair, time, length of the stretch, gap.
        self._small_gaps: list[Array] = [np.empty((0, 5))]

    def run(self, start: float, until: float, progress: Progress) -> Impact:
        march = self._march
        begins = march.parameters(start)
        if (pair := _overlapping(march, begins)) is not None:
            return self._impact("overlapping", start, start, pair)
        last = start
        self._begins = begins[0]
        end = min(until, march.end)
        heads = (march.head_start + march.way([start, end])).tolist()
        self._alike = march.dragon.alike and march.continuation.alike(*heads)
        self._whole = end - start
        for times in self._windows(start, begins, end):
            last = self._clear_as_far_as_placed(times)
            if self._hit < np.inf:
                return self._impact("contact", start, self._hit, self._pair)
            progress(last, until)
            if last < times[-1]:
                break
        return self._impact("clear" if last >= until else "unreachable", start, last, None)

    def _impact(self, status: Status, start: float, time: float, pair: tuple[int, int] | None) -> Impact:
        misses = self._clearances(start, time)
        counts = {"looks": self._looks, "tests": self._tests, "resolution": self._resolution}
        return Impact.at(self._march, status, time, pair, clearances=misses, **counts)

    def _windows(self, start: float, begins: Array, end: float) -> Iterator[Array]:
        """Times at which stretches begin and end, some at once: shorter ones while all benches are watched."""
        self._familiar_from = familiar = self._familiar(start, begins, end)
        for begin, last, stretch in ((start, familiar, self._short_stretch), (familiar, end, self._stretch)):
            count = int(np.ceil((last - begin) / stretch))
            for done in range(0, count, WINDOW):
                shares = np.arange(done, min(done + WINDOW, count) + 1) / count
                # Exact at both ends.
                yield (1 - shares) * begin + shares * last

    def _familiar(self, start: float, begins: Array, end: float) -> float:
        """A time by which each bench behind bench 1 has reached the place where the one before it was at the start.

        The end, if there is none.
        """
        march = self._march
        if not self._alike:
            return end
        # A little longer than it takes at the head's speed; where that is too short, a little more.
        wait = 1.05 * float(march.dragon.spacings[-1])
        while start + wait < end:
            if np.all(march.places(start + wait)[0, 2:-1] >= begins[0, 1:-2]):
                return start + wait
            wait *= 1.05
        return end

    def _clear_as_far_as_placed(self, times: Array) -> float:
        """Clear the time between the first and the last of `times`, or find the first contact in it.

        Returns the last moment until which the chain has a place.
        """
        last = self._clear(times)
        if last == times[-1] or self._hit < np.inf:
            return last
        end = _last_placed(self._march, last, float(times[np.searchsorted(times, last, side="right")]))
        return self._clear(np.array([last, end])) if end > last else last

    def _clear(self, times: Array) -> float:
        """Clear the stretches between `times`, or find the first contact in them.

        Returns the last of the times until which the chain has a place.
        """
        march = self._march
        handles = march.dragon.handles
        if times[0] >= self._familiar_from:
            handles = handles_in_reach(march, float(times[0]), float(times[-1]), self._near)
        stretches = Stretches.between(march, times, handles)
        last = float(times[stretches.begins.size])
        if not stretches.begins.size:
            return last
        motion = Motion(march, stretches)
        watched = motion.breaking_new_ground(self._begins if self._alike else np.full_like(self._begins, np.inf))
        rows, pairs = motion.candidates(self._near, watched)
        sampled = np.zeros(rows.size, dtype=bool)
        crowd = 0.0
        while rows.size:
            length, middles = float(stretches.lengths[0]), stretches.middles[rows]
            found = motion.separations(rows, pairs)
            self._note(middles, pairs, found.distance)
            if length > self._near_stretch:
                unsettled = motion.smallest_gaps(rows, pairs, found.normal) <= self._near
                doubtful = rows[unsettled], pairs[unsettled], found.normal[unsettled]
                unsettled[unsettled] = motion.smallest_gaps_together(*doubtful) <= self._near
            else:
                gaps = motion.smallest_gaps_together(rows, pairs, found.normal)
                fresh = np.isfinite(gaps) & ~sampled
                sampled |= fresh
                if self._alike:
                    fresh &= pairs[:, 0] <= 1
                self._note_small_gaps(middles, length, pairs, found.distance, fresh & (gaps <= self._near))
                work = np.unique(rows).size * (int(pairs.max()) + 2) + PAIR_WORK * rows.size
                share = max((times[-1] - times[0]) / self._whole, LEAST_SHARE)
                crowd = crowd or max(share * CROWD, GROWTH * work)
                limit = motion.rounding[rows] + (STILL if work <= crowd else CROWDED * (work / crowd) ** 2)
                # Not in the stretch before the first one that has them touching in its middle.
                apart = (gaps > -limit) & (stretches.ends[rows] + length < self._hit)
                self._resolution = max(self._resolution, -float(gaps[apart].min(initial=0.0)))
                instant = max(RESOLUTION, LAST_DIGITS * float(np.spacing(np.abs(middles).max())))
                unsettled = (gaps <= 0) & ~apart & (length > instant)
            unsettled &= stretches.begins[rows] < self._hit
            rows, pairs, sampled = rows[unsettled], pairs[unsettled], sampled[unsettled]
            if rows.size:
                for _ in range(1 if rows.size > FEW else HALVINGS):
                    chosen, rows = np.unique(rows, return_inverse=True)
                    stretches = stretches.halved(march, chosen, int(pairs.max()) + 2)
                    rows, pairs = np.concatenate([rows, rows + chosen.size]), np.concatenate([pairs, pairs])
                    sampled = np.concatenate([sampled, sampled])
                motion = Motion(march, stretches)
        return last

    def _note(self, times: Array, pairs: Indices, distances: Array) -> None:
        """Note what was looked at, and the earliest touch."""
        self._looks += np.unique(times).size
        self._tests += len(pairs)
        touching = np.flatnonzero(distances <= 0)
        if touching.size:
            earliest = touching[times[touching].argmin()]
            if times[earliest] < self._hit:
                self._hit = float(times[earliest])
                first, second = pairs[earliest].tolist()
                self._pair = first, second

    def _note_small_gaps(self, times: Array, length: float, pairs: Indices, distances: Array, chosen: Flags) -> None:
        """Note the `chosen` pairs, whose gap may be small within a stretch of this length about their time."""
        lengths = np.full(times.size, length)
        self._small_gaps.append(np.column_stack([pairs, times, lengths, distances])[chosen])

    def _clearances(self, start: float, end: float) -> tuple[Clearance, ...]:
        """Smallest gaps between `start` and `end`."""
        samples = np.concatenate(self._small_gaps)
        samples = samples[samples[:, 2] <= end]
        if not samples.size:
            return ()
        first, second, times, lengths, gaps = samples[np.lexsort(samples.T[2::-1])].T
        # A sample without a neighbour has a larger gap there: it was ruled out by a bound.
        follows = (np.diff(first) == 0) & (np.diff(second) == 0) & (np.diff(times) < 1.5 * lengths[1:])
        falls = np.diff(gaps) < 0
        smallest = ~np.append(follows & falls, False) & ~np.append(False, follows & ~falls)
        pairs = np.stack([first, second], axis=-1)[smallest].astype(np.intp)
        low, high = np.maximum(times - lengths, start)[smallest], np.minimum(times + lengths, end)[smallest]
        some = max(1, NEAR_HANDLES // (NEAR_POINTS * (int(pairs.max()) + 2)))
        parts = [slice(at, at + some) for at in range(0, len(pairs), some)]
        smallest_gaps = [_smallest_gaps(self._march, pairs[part], low[part], high[part]) for part in parts]
        times, gaps = np.concatenate(smallest_gaps, axis=1)
        margin = np.maximum(NEAR_END_SHARE * (high - low), NEAR_END)
        inside = (times > low + margin) & (times < high - margin) & (gaps > 0) & (gaps < self._near)
        found = zip(times[inside].tolist(), pairs[inside].tolist(), gaps[inside].tolist(), strict=True)
        return tuple(Clearance(time=time, benches=(i, j), gap=gap) for time, (i, j), gap in sorted(found))


def _overlapping(march: March, places: Array) -> tuple[int, int] | None:
    """The pair that overlaps most where the handles are at `places` (1, H), if any does."""
    dragon, poses = march.dragon, bench_poses(point(march.curve, places[0]))
    corners = dragon.outlines(poses)
    first, second = near_pairs(poses[:, :2], np.hypot(dragon.lengths, dragon.widths) / 2).T
    distances = separation(corners[first], corners[second]).distance
    if not np.any(distances <= 0):
        return None
    deepest = int(distances.argmin())
    return int(first[deepest]), int(second[deepest])


def _last_placed(march: March, placed: float, later: float) -> float:
    """Last moment from `placed` on at which the chain has a place; it has none at `later`."""
    while later - placed > RESOLUTION and placed < (placed + later) / 2 < later:
        times = np.linspace(placed, later, LAST_POINTS)
        lost: Flags = np.isnan(march.places(times)[:, -1])
        lost[-1] = True
        first = max(1, int(lost.argmax()))
        placed, later = float(times[first - 1]), float(times[first])
    return placed


def _smallest_gaps(march: March, pairs: Indices, low: Array, high: Array) -> tuple[Array, Array]:
    """When the gaps of `pairs` (B, 2) are smallest between the times `low` and `high` (B,), and how small then."""
    handles, chosen = int(pairs.max()) + 2, np.arange(len(pairs))
    rows = np.arange(len(pairs) * NEAR_POINTS)
    first, second = np.repeat(pairs, NEAR_POINTS, axis=0).T
    for _ in range(NEAR_PASSES):
        times = np.linspace(low, high, NEAR_POINTS, axis=-1)
        corners = march.dragon.outlines(march.at(times, handles).poses)
        gaps = separation(corners[rows, first], corners[rows, second]).distance.reshape(times.shape)
        best = gaps.argmin(axis=1)
        low, high = times[chosen, np.maximum(best - 1, 0)], times[chosen, np.minimum(best + 1, NEAR_POINTS - 1)]
    return times[chosen, best], gaps[chosen, best]
