"""First contact in continuous time, with a proof that there is no earlier one.

The package's docstring has the method, and `bounds.py` the bounds on the motion. The search uses
the head's distance as its time (a march at 1 m/s).

If all benches behind the head have the same size, few pairs need tests. Let s_i(t) be the
arc-length coordinate of handle i. The rear handle of bench i is at s_{i+1} = g(s_i), with one
function g for all benches behind the head (`model/continuation.py`; checked by
`Continuation.is_one_function`). So the poses of benches i and j > i depend on s_i only, and benches
i - 1 and j - 1 have the same two poses whenever s_{i-1} has the same value, if i >= 2.

Claim: at the time t of a first contact some touching pair (i, j) has i <= 1 or s_i(t) <
s_{i-1}(start). Proof: assume the contrary and take a touching pair, so i >= 2 and s_i(t) >=
s_{i-1}(start). As s_i(t) < s_{i-1}(t) and s_{i-1} is continuous, s_{i-1} had the value s_i(t) at
some time between the start and t, before t. Benches i - 1 and j - 1 touched at that time, which is
earlier than the first contact: a contradiction. The proof does not need handles to move forward;
they do not where a long head bench pushes the chain back. So pairs with i <= 1 are tested at all
times, and all other pairs in every interval in which s_i may be below s_{i-1}(start). If benches
differ in size, or follow different functions g, all pairs are tested at all times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import astuple, replace
from functools import partial
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array, Flags, Indices, as_complex, as_vectors
from pymunk_dragon._checks import function, silent
from pymunk_dragon.collision.bounds import UNPROVEN_ROUNDING, Intervals, MotionBounds, near_pairs
from pymunk_dragon.collision.result import FirstContact, NearMiss, Status
from pymunk_dragon.collision.sat import deepest_overlap, separation
from pymunk_dragon.model.march import March, checked_times, last_reachable

# The tolerances. m of the head's distance: an interval no longer than this is decided by the state
# at its midpoint, because coordinates are no more exact.
_RESOLUTION = 1e-12
# Length of such an interval in last digits of the head's distance, where that is more.
_LAST_DIGITS = 4
# m. A gap that may be this far below zero, besides rounding, counts as open: coordinates are hardly
# more exact.
_GAP_TOLERANCE = 8e-12
# m. Tolerance of a gap where the work exceeds its budget; it grows with the square of the excess.
_LIMITED_TOLERANCE = 2.5e-7

# The budget of work, in bench poses computed for all intervals of one length: it takes a few
# seconds, and division exceeds it where a gap stays near zero for long.
_WORK_LIMIT = 2_000_000
# Cost of a pair test, in bench poses.
_PAIR_WORK = 20
# Least share of the budget for a batch, which otherwise has a share by its duration: the last batch
# before a contact may be short.
_MIN_SHARE = 0.05
# Least budget of a batch, in its first work in short intervals.
_WORK_GROWTH = 8

# Length of the first intervals, in shortest spacings; others only change the number of divisions.
_INTERVAL = 1.2
# Their length while all pairs are tested: shorter, because each pair is tested again in all parts.
_ALL_PAIRS_INTERVAL = 0.3
# Intervals evaluated together are half of those that are left: many at first, and few where a march
# ends, because an inward one ends soon after its contact. Fewest of them, and most.
_FEWEST_INTERVALS = 16
_MOST_INTERVALS = 128
# Intervals that are not cleared are divided into so many parts that there are about as many pairs
# to test as this, because NumPy's overhead per call dominates with fewer.
_PAIRS = 200
# Fewest and most parts of an interval.
_FEWEST_PARTS = 3
_MOST_PARTS = 256

# A local minimum of a gap below this share of the narrowest bench's width is a near miss: 1 cm at
# the paper's 0.3 m.
_NEAR_MISS = 1 / 30
# Length of intervals in which near misses are sampled, in widths: a local minimum lasts about one
# width.
_NEAR_MISS_INTERVAL = 0.4
# Points per bracket in the search for a local minimum: each pass narrows the bracket eightfold.
_MINIMUM_POINTS = 17
# Passes of the search.
_MINIMUM_PASSES = 7
# Handles placed together in the search for a minimum: 20 MB of corners.
_MINIMUM_HANDLES = 300_000
# Margin at the ends of a bracket, as a share of it: a minimum so close to an end lies outside.
_BRACKET_END_SHARE = 1e-6
# m of the head's distance. Least margin.
_BRACKET_END = 1e-9
# Share of the sum of their lengths: centres of adjacent intervals are half of it apart, but for
# rounding.
_ADJACENT = 0.51


def first_contact(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    progress: Callable[[float, float], None] = silent,
) -> FirstContact:
    """First contact of benches that are not neighbours, certified: there is no earlier one.

    However short a contact is, the search finds it.

    Parameters
    ----------
    march : March
        The motion.
    start : float
        Time at which the search begins, s.
    until : float, optional
        Time at which it ends, s; at the latest, and by default, where the curve ends.
    progress : callable, optional
        Called with the time up to which the march is cleared, and with `until`, s.

    Returns
    -------
    FirstContact
        The time is accurate to 1e-11 s where the gap closes at centimetres per second, as in the
        paper's march, and in general to the time in which the gap closes by `resolution`. Benches
        that graze each other less deeply than that count as apart.

    Raises
    ------
    UnreachableError
        If the dragon has no state at `start`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, first_contact
    >>> hit = first_contact(March(Dragon(benches=16), turns=8))
    >>> hit.status, hit.benches
    ('contact', (0, 8))
    """
    start, until = checked_times(march, start, until)
    function("progress", progress)
    march.handles_s(start)  # An error names the time of this march.
    unit = march.at_unit_speed()
    begin, end = march.distance([start, until]).tolist()
    # Rounding must not put the end beyond that of the curve.
    if until == march.end:
        end = unit.end
    elif until < march.end:
        end = min(end, unit.end)

    def report(cleared: float) -> None:
        progress(float(march.time(cleared)), until)

    found = _Search(unit, begin, end).run(report)
    # `start` and `until` are returned as they were passed.
    time = float(march.time(found.time))
    time = {begin: start, end: until}.get(found.time, time)
    near_misses = found.near_misses or ()
    misses = [replace(miss, time=float(march.time(miss.time))) for miss in near_misses]
    return replace(found, time=time, near_misses=tuple(misses))


class _Search:
    """The search on a march at 1 m/s.

    Its times are the head's distance from its position at t = 0, m.
    """

    def __init__(self, march: March, start: float, until: float) -> None:
        self._march = march
        self._start = start
        self._until = until
        self._end = min(until, march.end)
        width = float(march.dragon.widths.min())
        self._near = _NEAR_MISS * width
        self._near_miss_interval = _NEAR_MISS_INTERVAL * width
        self._hit = np.inf
        self._pair = (0, 0)
        self._samples = self._tests = 0
        self._resolution = 0.0
        # Rows of pair, time, length of the interval, gap, bound on its rounding error.
        self._small_gaps: list[Array] = [np.empty((0, 6))]

    def run(self, report: Callable[[float], None]) -> FirstContact:
        """Result of the search; `report` is called with times up to which the march is cleared."""
        march = self._march
        dragon = march.dragon
        last = self._start
        state = march.at(last)
        poses = state.poses[0]
        self._start_s = state.handles_s[0]
        radii = np.hypot(dragon.lengths, dragon.widths) / 2
        near = near_pairs(as_complex(poses[:, :2]), radii)
        pair = deepest_overlap(dragon.outlines(poses), near)
        if pair is not None:
            return self._result("overlapping", last, pair)

        # Whether all benches behind the head follow the same function g.
        heads = (march.head_start + march.distance([self._start, self._end])).tolist()
        self._one_function = dragon.has_equal_benches and march.continuation.is_one_function(*heads)
        self._warm_up_end = self._end_of_warm_up()

        for times in self._batches():
            last = self._clear(times)
            if last < times[-1] and self._hit == np.inf:
                # The chain loses its state in the interval after `last`, which is cleared up to the
                # last state.
                ends = last, float(times[times > last][0])
                end = march.continuation.keep(ends, 1, partial(_end_of_motion, march, *ends))
                if end > last:
                    last = self._clear(np.array([last, end]))
            if self._hit < np.inf:
                return self._result("contact", self._hit, self._pair)
            report(last)
            if last < times[-1]:
                break
        return self._result("clear" if last >= self._until else "unreachable", last, None)

    def _result(self, status: Status, time: float, pair: tuple[int, int] | None) -> FirstContact:
        """Result with the figures of the search so far."""
        samples = np.concatenate(self._small_gaps)
        misses = _near_misses(self._march, samples, self._start, time, self._near)
        figures = {"samples": self._samples, "tests": self._tests, "resolution": self._resolution}
        return result_at(self._march, status, time, pair, near_misses=misses, **figures)

    def _end_of_warm_up(self) -> float:
        """End of the warm-up: each bench from bench 2 on is where the one before it started."""
        if not self._one_function:
            return self._end
        # 5 % more than a spacing, and 5 % more until the condition holds.
        wait = 1.05 * float(self._march.dragon.spacings[-1])
        while (time := self._start + wait) < self._end:
            handles_s = self._march.motion_or_nan(time).handles_s[0]
            if np.all(handles_s[2:-1] >= self._start_s[1:-2]):
                return time
            wait *= 1.05
        return self._end

    def _batches(self) -> Iterator[Array]:
        """Bounds of consecutive intervals, one array for each batch."""
        shortest = self._march.dragon.spacings.min()
        warm_up = self._start, self._warm_up_end, _ALL_PAIRS_INTERVAL
        rest = self._warm_up_end, self._end, _INTERVAL
        for begin, last, length in (warm_up, rest):
            count = int(np.ceil((last - begin) / (length * shortest)))
            done = 0
            while done < count:
                half = max((count - done) // 2, _FEWEST_INTERVALS)
                batch = min(half, _MOST_INTERVALS, count - done)
                shares = np.arange(done, done + batch + 1) / count
                # Exact at both ends.
                times = (1 - shares) * begin + shares * last
                # The continuation is not followed before all earlier intervals are cleared.
                direct = self._march.continuation.is_direct(self._march.head_start + times)
                leading = int(direct[1:].argmin())
                if leading:
                    times = times[: leading + 1]
                done += times.size - 1
                yield times

    def _clear(self, times: Array) -> float:
        """Clear the intervals between `times`, up to the last time at which the chain has a state.

        That time is returned.
        """
        intervals = Intervals.between(self._march, times)
        last = float(times[intervals.begins.size])
        if not intervals.begins.size:
            return last
        bounds = MotionBounds(self._march, intervals)
        start_s = np.where(self._one_function, self._start_s, np.inf)
        rows, pairs = bounds.candidates(self._near, start_s)
        # Intervals that are cleared without a proof for rounding count in the resolution.
        if not bounds.proven.all():
            self._resolution = max(self._resolution, UNPROVEN_ROUNDING)
        duration = float(times[-1] - times[0])
        share = max(duration / (self._end - self._start), _MIN_SHARE)
        self._divide(intervals, bounds, rows, pairs, share * _WORK_LIMIT)
        return last

    def _divide(
        self,
        intervals: Intervals,
        bounds: MotionBounds,
        rows: Indices,
        pairs: Indices,
        budget: float,
    ) -> None:
        """Clear `pairs` (P, 2) in the intervals `rows` (P,), or find their first contact.

        Intervals that are not cleared are divided.
        """
        sampled = np.zeros(rows.size, dtype=bool)
        limit = 0.0
        while rows.size:
            # This loop ends when each pair is open in each interval that begins before the earliest
            # contact found.
            middles = (intervals.begins[rows] + intervals.ends[rows]) / 2
            length = float(intervals.ends[0] - intervals.begins[0])
            found = bounds.separations(rows, pairs)
            samples = int(np.count_nonzero(np.bincount(rows)))
            self._note_contact(middles, pairs, found.distance, samples)

            if length > self._near_miss_interval:
                # A long interval: gaps that stay wider than a near miss are open. The bound for two
                # benches that move independently is the faster one.
                open_ = bounds.smallest_gaps(rows, pairs, found.normal) > self._near
            else:
                # A short interval: the bound by relative motion needs the proof for rounding, the
                # bound by travel not.
                gaps = bounds.smallest_gaps_together(rows, pairs, found.normal)
                weak = ~bounds.proven[rows]
                gaps[weak] = bounds.gaps_by_travel(rows[weak], pairs[weak], found.distance[weak])

                rounding = bounds.rounding[rows]
                midpoints = [pairs, middles, np.full(rows.size, length), found.distance, rounding]
                self._keep_samples(np.column_stack(midpoints), gaps, sampled)

                # The tolerance grows once the work exceeds its budget.
                work = samples * (int(pairs.max()) + 2) + _PAIR_WORK * rows.size
                limit = limit or max(budget, _WORK_GROWTH * work)
                tolerance = _GAP_TOLERANCE
                if work > limit:
                    tolerance = _LIMITED_TOLERANCE * (work / limit) ** 2

                # Gaps above zero are open, and those that may be below by the tolerance, except in
                # the interval just before the earliest contact found. That interval is divided to
                # the resolution, where its midpoint decides.
                earlier = intervals.ends[rows] + length < self._hit
                within = earlier & (gaps > -(rounding + tolerance))
                self._resolution = max(self._resolution, -float(gaps[within].min(initial=0.0)))
                shortest = length <= _resolution(float(np.abs(middles).max()))
                open_ = (gaps > 0) | within | shortest

            if not bounds.proven[rows[open_]].all():
                self._resolution = max(self._resolution, UNPROVEN_ROUNDING)
            left = ~open_ & (intervals.begins[rows] < self._hit)
            rows = rows[left]
            pairs = pairs[left]
            sampled = sampled[left]
            if rows.size:
                intervals, bounds, kept = self._divided(intervals, rows, pairs, sampled)
                rows, pairs, sampled = kept

    def _divided(
        self, intervals: Intervals, rows: Indices, pairs: Indices, sampled: Flags
    ) -> tuple[Intervals, MotionBounds, tuple[Indices, Indices, Flags]]:
        """Parts of the intervals `rows` (P,) in which `pairs` (P, 2) are left, and their bounds.

        Each of these pairs is tested in all parts, unless a circle about the origin separates it.
        """
        parts = min(max(_PAIRS // rows.size, _FEWEST_PARTS), _MOST_PARTS)
        chosen, rows = np.unique(rows, return_inverse=True)
        intervals = intervals.divided(self._march, chosen, parts, int(pairs.max()) + 2)
        bounds = MotionBounds(self._march, intervals)
        rows = (parts * rows[:, None] + np.arange(parts)).ravel()
        pairs = np.repeat(pairs, parts, axis=0)
        left = bounds.may_meet(rows, pairs, self._near)
        return intervals, bounds, (rows[left], pairs[left], np.repeat(sampled, parts)[left])

    def _keep_samples(self, samples: Array, gaps: Array, sampled: Flags) -> None:
        """Keep `samples` (P, 6) of gaps with a bound for the first time that may be near misses.

        `gaps` (P,) are the bounds; `sampled` (P,) says which gaps had one before.
        """
        fresh = np.isfinite(gaps) & ~sampled
        sampled |= fresh
        fresh &= gaps <= self._near
        if self._one_function:
            fresh &= samples[:, 0] <= 1
        self._small_gaps.append(samples[fresh])

    def _note_contact(self, times: Array, pairs: Indices, distances: Array, samples: int) -> None:
        """Count the tests and the samples, and keep the earliest contact among them."""
        self._samples += samples
        self._tests += len(pairs)
        earlier = np.flatnonzero((distances <= 0) & (times < self._hit))
        if earlier.size:
            earliest = earlier[times[earlier].argmin()]
            self._hit = float(times[earliest])
            self._pair = int(pairs[earliest, 0]), int(pairs[earliest, 1])


def result_at(
    march: March, status: Status, time: float, pair: tuple[int, int] | None, **rest: Any
) -> FirstContact:
    """Result at `time`, with the contact point and the normal of the benches `pair`, if any."""
    point = normal = None
    if pair is not None:
        poses = march.at(time, handles=pair[1] + 2).poses[0]
        found = separation(*march.dragon.outlines(poses)[list(pair)])
        point = tuple(found.point.tolist())
        normal = tuple(found.normal.tolist())
    return FirstContact(status=status, time=time, benches=pair, point=point, normal=normal, **rest)


def _resolution(time: float) -> float:
    """Length of the shortest intervals about a time, m of the head's distance."""
    return max(_RESOLUTION, _LAST_DIGITS * float(np.spacing(abs(time))))


def _end_of_motion(march: March, begin: float, later: float) -> float:
    """Last time at which the chain has a state: it has one at `begin`, and none at `later`.

    The result is early by the resolution: nearer to the end, rounding decides whether there is a
    state, and rounding depends on the processor and on the number of times that are computed
    together.
    """
    end = last_reachable(march, begin, later, march.dragon.handles, _RESOLUTION)
    return max(begin, end - _resolution(end))


def _near_misses(
    march: March, samples: Array, start: float, end: float, near: float
) -> tuple[NearMiss, ...]:
    """Local minima of gaps below `near` m between `start` and `end`.

    They are found from the samples (K, 6) that `_Search` keeps.
    """
    samples = samples[samples[:, 2] <= end]
    ordered = samples[np.lexsort(samples.T[2::-1])]
    brackets = np.array(list(_brackets(ordered.tolist())))
    if not brackets.size:
        return ()
    pairs = brackets[:, :2].astype(np.intp)
    low = np.maximum(brackets[:, 2], start)
    high = np.minimum(brackets[:, 3], end)
    rounding = brackets[:, 4]

    handles = _MINIMUM_POINTS * (int(pairs.max()) + 2)
    some = max(1, _MINIMUM_HANDLES // handles)
    misses = []
    for at in range(0, len(pairs), some):
        part = slice(at, at + some)
        found = _local_minima(march, pairs[part], low[part], high[part], rounding[part])
        for time, i, j, gap in found.tolist():
            if 0 < gap < near:
                misses.append(NearMiss(time=time, benches=(int(i), int(j)), gap=gap))
    return tuple(sorted(misses, key=astuple))


def _brackets(samples: list[list[float]]) -> Iterator[tuple[float, float, float, float, float]]:
    """Pairs, times between which their gap has a local minimum, and rounding error, from samples.

    The samples are in order. The gap falls to a minimum and rises from it by more than rounding.
    Where samples end, the gap is larger.
    """
    before: list[float] = [-1, -1, 0, 0, 0, 0]
    falls = False
    low = lowest = highest = 0.0
    for sample in [*samples, before]:
        first, second, time, length, gap, rounding = sample
        same_pair = [first, second] == before[:2]
        adjacent = time - before[2] <= _ADJACENT * (length + before[3])

        if not (same_pair and adjacent):
            # Another pair begins, or other intervals: a gap that fell to the end of the last ones
            # has a minimum.
            if falls:
                end = before[2] + before[3] / 2
                yield before[0], before[1], low, end, before[5]
            falls = True
            low = time - length / 2
            lowest = gap
        elif falls and gap < lowest - rounding:
            # The gap falls further.
            low = before[2]
            lowest = gap
        elif falls and gap > lowest + rounding:
            # The gap rises: its minimum is behind.
            yield first, second, low, time, rounding
            falls = False
            highest = gap
        elif not falls and gap < highest - rounding:
            # The gap falls again, from a maximum.
            falls = True
            low = before[2]
            lowest = gap
        highest = max(highest, gap)
        before = sample


def _local_minima(march: March, pairs: Indices, low: Array, high: Array, rounding: Array) -> Array:
    """Minima (B, 4) of the gaps of `pairs` (K, 2) inside the brackets from `low` to `high` (K,).

    A row is time, first bench, second bench, and gap in m. A bracket whose gap is no smaller inside
    than at one of its ends, but for `rounding` (K,), has none.
    """
    # No time is outside a bracket that is shorter than both margins: the chain may have no state
    # there.
    length = high - low
    margin = np.clip(_BRACKET_END_SHARE * length, _BRACKET_END, length / 2)
    inner = np.linspace(low + margin, high - margin, _MINIMUM_POINTS, axis=-1)
    times = np.column_stack([low, inner, high])
    gaps = _gaps(march, pairs, times)
    at_ends = gaps[:, [0, -1]].min(axis=1)
    inside = (at_ends > gaps.min(axis=1) + rounding) & (length > 2 * margin)
    if not inside.any():
        return np.empty((0, 4))

    pairs = pairs[inside]
    times = times[inside]
    gaps = gaps[inside]
    rows = np.arange(len(pairs))
    for _ in range(_MINIMUM_PASSES):
        best = np.clip(gaps.argmin(axis=1), 1, times.shape[1] - 2)
        begin = times[rows, best - 1]
        end = times[rows, best + 1]
        times = np.linspace(begin, end, _MINIMUM_POINTS, axis=-1)
        gaps = _gaps(march, pairs, times)
    best = gaps.argmin(axis=1)
    return np.stack([times[rows, best], *pairs.T, gaps[rows, best]], axis=1)


def _gaps(march: March, pairs: Indices, times: Array) -> Array:
    """Gaps (B, K) of `pairs` (B, 2) at `times` (B, K), m."""
    rows = np.arange(times.size)
    first, second = np.repeat(pairs, times.shape[1], axis=0).T
    points = march.motion(times, int(pairs.max()) + 2).points
    corners = as_vectors(march.dragon.outlines_between(points))
    distances = separation(corners[rows, first], corners[rows, second]).distance
    return distances.reshape(times.shape)
