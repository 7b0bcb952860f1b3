"""First contact in continuous time. Bounds on the motion prove that there is no earlier contact.

Sampling the motion at discrete times misses a contact that opens again between two samples. Here a time interval is
cleared only by proof: the gap between two benches at its midpoint, less a bound on how far each may move within the
interval (`bounds.py`), is positive. An interval that is not cleared is divided, down to a picosecond. This is
conservative advancement (B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996), applied to all
pairs at once.

The state of the chain depends only on the distance that the head has travelled, not on its speed. So the search uses
this distance as its time (a march at 1 m/s), and converts it to times at the end.

If all benches behind the head have the same size, few pairs need tests. Let s_i(t) be the arc-length coordinate of
handle i. The rear handle of bench i is at s_{i+1} = g(s_i), with one function g for all benches behind the head
(`model/continuation.py`; checked by `Continuation.alike`). So the poses of benches i and j > i depend on s_i only, and
benches i - 1 and j - 1 have the same two poses whenever s_{i-1} has the same value, if i >= 2.

Claim: at the time t of a first contact some touching pair (i, j) has i <= 1 or s_i(t) < s_{i-1}(start). Proof: assume
the contrary and take a touching pair, so i >= 2 and s_i(t) >= s_{i-1}(start). As s_i(t) < s_{i-1}(t) and s_{i-1} is
continuous, s_{i-1} had the value s_i(t) at some time between the start and t, before t. Benches i - 1 and j - 1 touched
at that time, which is earlier than the first contact: a contradiction. The proof does not need handles to move forward;
they do not where a long head bench pushes the chain back. So pairs with i <= 1 are tested at all times, and all other
pairs in every interval in which s_i may be below s_{i-1}(start). If benches differ in size, or follow different
functions g, all pairs are tested at all times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from pymunk_dragon._arrays import Array, Flags, Indices
from pymunk_dragon.collision.bounds import (
    UNPROVEN_ROUNDING,
    Intervals,
    MotionBounds,
    handles_in_reach,
    overlapping_pair,
)
from pymunk_dragon.collision.near_misses import near_misses
from pymunk_dragon.collision.result import FirstContact, Status, result_at
from pymunk_dragon.model.march import March, checked_times

__all__ = ["first_contact"]

Progress = Callable[[float, float], None]

# Length of the initial intervals, in shortest spacings. Other values only change the number of divisions.
INTERVAL = 1.2
# The same while all pairs are tested: shorter, because each pair is tested again in all parts.
ALL_PAIRS_INTERVAL = 0.3
# Most and fewest intervals evaluated together, otherwise half of those that are left: many at first, and few where a
# march ends, because an inward one ends soon after its contact.
MOST_INTERVALS = 128
FEWEST_INTERVALS = 16
# m. A gap that may be this far below zero, in addition to rounding, counts as open: coordinates are hardly more exact.
GAP_TOLERANCE = 8e-12
# Work of the whole search at one length of the intervals, in bench poses computed, above which the tolerance grows: a
# few seconds. Division reaches it where a gap stays near zero for long.
WORK_LIMIT = 2_000_000
# Smallest share of `WORK_LIMIT` for a batch: the last batch before a contact may be short.
MIN_SHARE = 0.05
# Factor by which division may increase the work in a batch before the tolerance grows.
WORK_GROWTH = 8
# Work of a pair test, in bench poses computed (measured).
PAIR_WORK = 20
# m. Tolerance at the work limit; above, it grows with the square of the excess.
LIMITED_TOLERANCE = 2.5e-7
# m of the head's distance. The state at the midpoint decides shorter intervals: coordinates are no more exact.
RESOLUTION = 1e-12
# The same in last digits of the head's distance.
LAST_DIGITS = 4
# Intervals that are not cleared are divided into so many parts that there are about as many pairs to test as this: for
# fewer, NumPy's overhead per call dominates.
PAIRS = 300
# Bounds on the number of parts.
FEWEST_PARTS = 2
MOST_PARTS = 256
# Share of the narrowest bench's width below which a local minimum of a gap is a near miss: 1 cm at the paper's 0.3 m.
NEAR_MISS = 1 / 30
# Length of intervals in which near misses are sampled, in widths: a local minimum lasts about one width.
NEAR_MISS_INTERVAL = 0.4
# Points per pass in the search for the last time at which the chain has a state.
LAST_POINTS = 33


def first_contact(
    march: March, *, start: float = 0.0, until: float | None = None, progress: Progress | None = None
) -> FirstContact:
    """First contact of benches that are not neighbours, certified: there is no earlier one, however short.

    The module's docstring has the method and the proof.

    Parameters
    ----------
    march : March
        The motion.
    start, until : float
        Times of the search, s; without `until`, to the end of the curve.
    progress : callable, optional
        Called with the time up to which the march is cleared, and with `until`, s.

    Returns
    -------
    FirstContact
        The time is accurate to 1e-11 s where the gap closes at centimetres per second, as in the paper's march, and in
        general to the time in which the gap closes by `resolution`. Benches that graze each other less deeply than
        that count as apart.

    Raises
    ------
    ParameterError
        If one of the times is not a number, or `until` is not later than `start`.
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
    steady = March(march.dragon, march.curve, start_s=march.head_start)
    steady.share_states(march)
    begin, end = march.distance([start, until]).tolist()
    if until == march.end:
        # Not beyond it by rounding.
        end = steady.end

    def report(cleared: float, last: float) -> None:
        if progress is not None:
            progress(float(march.time(cleared)), until)

    found = _Search(steady).run(begin, end, report)
    # `start` and `until` are returned as they were passed.
    time = {begin: start, end: until}.get(found.time, float(march.time(found.time)))
    misses = [replace(miss, time=float(march.time(miss.time))) for miss in found.near_misses or ()]
    return replace(found, time=time, near_misses=tuple(misses))


class _Search:
    """State of the search on a march at 1 m/s: earliest contact and samples of small gaps.

    All its times are the head's distance from its position at t = 0, m.
    """

    def __init__(self, march: March) -> None:
        self._march = march
        dragon = march.dragon
        narrowest, shortest = float(dragon.widths.min()), dragon.spacings.min()
        self._near = NEAR_MISS * narrowest
        self._near_miss_interval = NEAR_MISS_INTERVAL * narrowest
        self._interval = INTERVAL * shortest
        self._all_pairs_interval = ALL_PAIRS_INTERVAL * shortest
        self._hit, self._pair = np.inf, (0, 0)
        # Coordinates of the handles at the start, and whether all benches behind the head follow the same function g.
        self._start_s, self._alike = np.empty(0), False
        self._duration, self._warm_up_end = 1.0, np.inf
        self._samples = self._tests = 0
        self._resolution = 0.0
        # Rows of pair, time, length of the interval, gap, bound on its rounding error.
        self._small_gaps: list[Array] = [np.empty((0, 6))]

    def run(self, start: float, until: float, progress: Progress) -> FirstContact:
        """Result of the search between two times."""
        march = self._march
        start_s = march.handles_s(start)
        if (pair := overlapping_pair(march, start_s)) is not None:
            return self._result("overlapping", start, start, pair)
        last = start
        self._start_s = start_s[0]
        end = min(until, march.end)
        heads = (march.head_start + march.distance([start, end])).tolist()
        self._alike = march.dragon.alike and march.continuation.alike(*heads)
        self._duration = end - start
        self._warm_up_end = self._end_of_warm_up(start, end)
        for times in self._batches(start, end):
            last = self._clear_while_reachable(times)
            if self._hit < np.inf:
                return self._result("contact", start, self._hit, self._pair)
            progress(last, until)
            if last < times[-1]:
                break
        return self._result("clear" if last >= until else "unreachable", start, last, None)

    def _result(self, status: Status, start: float, time: float, pair: tuple[int, int] | None) -> FirstContact:
        return result_at(
            self._march,
            status,
            time,
            pair,
            near_misses=near_misses(self._march, np.concatenate(self._small_gaps), start, time, self._near),
            samples=self._samples,
            tests=self._tests,
            resolution=self._resolution,
        )

    def _batches(self, start: float, end: float) -> Iterator[Array]:
        """Bounds of consecutive intervals, one array for each batch; shorter intervals during the warm-up."""
        warm_up_end = self._warm_up_end
        phases = (start, warm_up_end, self._all_pairs_interval), (warm_up_end, end, self._interval)
        for begin, last, length in phases:
            count = int(np.ceil((last - begin) / length))
            done = 0
            while done < count:
                batch = min(max((count - done) // 2, FEWEST_INTERVALS), MOST_INTERVALS, count - done)
                shares = np.arange(done, done + batch + 1) / count
                done += batch
                # Exact at both ends.
                yield (1 - shares) * begin + shares * last

    def _end_of_warm_up(self, start: float, end: float) -> float:
        """Time by which each bench behind bench 1 has reached the start position of the bench before it, or the end."""
        march, start_s = self._march, self._start_s
        if not self._alike:
            return end
        # 5 % more than a spacing, and 5 % more until the condition holds.
        wait = 1.05 * float(march.dragon.spacings[-1])
        while start + wait < end:
            if np.all(march.handles_s_or_nan(start + wait)[0, 2:-1] >= start_s[1:-2]):
                return start + wait
            wait *= 1.05
        return end

    def _clear_while_reachable(self, times: Array) -> float:
        """Clear the time between the first and the last of `times`, or find the first contact in it.

        Returns the last time at which the chain has a state.
        """
        last = self._clear(times)
        if last == times[-1] or self._hit < np.inf:
            return last
        end = _last_reachable(self._march, last, float(times[np.searchsorted(times, last, side="right")]))
        return self._clear(np.array([last, end])) if end > last else last

    def _clear(self, times: Array) -> float:
        """Clear the intervals between `times`, or find the first contact in them.

        Returns the last of the times at which the chain has a state.
        """
        march, handles = self._march, self._march.dragon.handles
        if times[0] >= self._warm_up_end:
            handles = handles_in_reach(march, float(times[0]), float(times[-1]), self._near)
        intervals = Intervals.between(march, times, handles)
        last = float(times[intervals.begins.size])
        if not intervals.begins.size:
            return last
        bounds = MotionBounds(march, intervals)
        tested = bounds.at_new_poses(self._start_s if self._alike else np.full_like(self._start_s, np.inf))
        rows, pairs = bounds.candidates(self._near, tested)
        self._note_unproven(bounds.proven)
        sampled = np.zeros(rows.size, dtype=bool)
        limit = 0.0
        while rows.size:
            length, middles = float(intervals.lengths[0]), intervals.middles[rows]
            found = bounds.separations(rows, pairs)
            used = np.bincount(rows) > 0
            self._samples += int(np.count_nonzero(used))
            self._note_contact(middles, pairs, found.distance)
            if length > self._near_miss_interval:
                gaps = bounds.smallest_gaps(rows, pairs, found.normal)
                rest = ~(gaps > self._near)
                gaps[rest] = bounds.smallest_gaps_together(rows[rest], pairs[rest], found.normal[rest])
                open_ = gaps > self._near
            else:
                gaps = bounds.smallest_gaps_together(rows, pairs, found.normal)
                if (unproven := ~bounds.proven[rows]).any():
                    by_travel = bounds.gaps_by_travel(rows[unproven], pairs[unproven], found.distance[unproven])
                    gaps[unproven] = by_travel
                fresh = np.isfinite(gaps) & ~sampled
                sampled |= fresh
                fresh &= (gaps <= self._near) & (pairs[:, 0] <= 1 if self._alike else True)
                lengths = np.full(rows.size, length)
                samples = np.column_stack([pairs, middles, lengths, found.distance, bounds.rounding[rows]])
                self._small_gaps.append(samples[fresh])
                work = int(np.count_nonzero(used)) * (int(pairs.max()) + 2) + PAIR_WORK * rows.size
                limit = limit or max(self._share(times) * WORK_LIMIT, WORK_GROWTH * work)
                tolerance = GAP_TOLERANCE if work <= limit else LIMITED_TOLERANCE * (work / limit) ** 2
                open_ = self._are_open(intervals, bounds, rows, gaps, tolerance)
            self._note_unproven(bounds.proven[rows[open_]])
            left = ~open_ & (intervals.begins[rows] < self._hit)
            rows, pairs, sampled = rows[left], pairs[left], sampled[left]
            if rows.size:
                parts = min(max(PAIRS // rows.size, FEWEST_PARTS), MOST_PARTS)
                used = np.bincount(rows) > 0
                chosen, rows = np.flatnonzero(used), (np.cumsum(used) - 1)[rows]
                intervals = intervals.divided(march, chosen, parts, int(pairs.max()) + 2)
                rows = (parts * rows[:, None] + np.arange(parts)).ravel()
                pairs, sampled = np.repeat(pairs, parts, axis=0), np.repeat(sampled, parts)
                bounds = MotionBounds(march, intervals)
        return last

    def _share(self, times: Array) -> float:
        """Share of the whole search's work that a batch may have."""
        return max(float(times[-1] - times[0]) / self._duration, MIN_SHARE)

    def _are_open(
        self, intervals: Intervals, bounds: MotionBounds, rows: Indices, gaps: Array, tolerance: float
    ) -> Flags:
        """Whether pairs count as apart in the intervals `rows`, given lower bounds on their gaps, m.

        A gap that may be below zero by the tolerance counts as open, except in the interval just before
        the earliest contact that was found: that interval is divided to the resolution.
        """
        length = float(intervals.lengths[0])
        within = (gaps > -(bounds.rounding[rows] + tolerance)) & (intervals.ends[rows] + length < self._hit)
        self._resolution = max(self._resolution, -float(gaps[within].min(initial=0.0)))
        latest = float(np.abs(intervals.middles[rows]).max())
        return (gaps > 0) | within | (length <= _resolution(latest))

    def _note_unproven(self, proven: Flags) -> None:
        """Include `UNPROVEN_ROUNDING` in the resolution if intervals were cleared without a proof for rounding."""
        if not proven.all():
            self._resolution = max(self._resolution, UNPROVEN_ROUNDING)

    def _note_contact(self, times: Array, pairs: Indices, distances: Array) -> None:
        """Count the tests, and keep the earliest contact among them."""
        self._tests += len(pairs)
        touching = np.flatnonzero(distances <= 0)
        if touching.size:
            earliest = touching[times[touching].argmin()]
            if times[earliest] < self._hit:
                self._hit = float(times[earliest])
                first, second = pairs[earliest].tolist()
                self._pair = first, second


def _resolution(time: float) -> float:
    """Length of the shortest intervals about a time, m of the head's distance."""
    return max(RESOLUTION, LAST_DIGITS * float(np.spacing(abs(time))))


def _last_reachable(march: March, reachable: float, later: float) -> float:
    """Last time at which the chain has a state, between one at which it has and one at which it has not.

    It is early by the resolution: nearer to the end, rounding decides whether there is a state, and rounding depends on
    the processor and on the number of times that are computed together.
    """
    lost = np.isnan(march.handles_s_or_nan(later)[0])
    # A handle behind the first one that is lost later may be lost earlier, but hardly ever is.
    for handles in (int(lost.argmax()) + 1, march.dragon.handles):
        found = _last_time(march, reachable, later, handles)
        if not np.isnan(march.handles_s_or_nan(found)).any():
            break
    return max(reachable, found - _resolution(found))


def _last_time(march: March, reachable: float, later: float, handles: int) -> float:
    """The same for the foremost `handles`."""
    while later - reachable > RESOLUTION and reachable < (reachable + later) / 2 < later:
        times = np.linspace(reachable, later, LAST_POINTS)
        lost: Flags = np.isnan(march.handles_s_or_nan(times, handles)[:, -1])
        lost[-1] = True
        first = max(1, int(lost.argmax()))
        reachable, later = float(times[first - 1]), float(times[first])
    return reachable
