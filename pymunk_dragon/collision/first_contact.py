"""First contact in continuous time. Bounds on the motion (`bounds.py`) prove that there is no earlier contact.

The package's docstring has the method. The search uses the head's distance as its time (a march at
1 m/s).

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
from dataclasses import replace
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array, Flags, Indices, as_complex, as_vectors
from pymunk_dragon._checks import function
from pymunk_dragon.collision.bounds import UNPROVEN_ROUNDING, Intervals, MotionBounds, near_pairs
from pymunk_dragon.collision.result import FirstContact, NearMiss, Status
from pymunk_dragon.collision.sat import deepest_overlap, separation
from pymunk_dragon.model.march import March, checked_times

__all__ = ["first_contact"]

# The three tolerances. An interval no longer than this, in m of the head's distance or in last
# digits of it, is decided by the state at its midpoint: coordinates are no more exact.
_RESOLUTION, _LAST_DIGITS = 1e-12, 4
# m. A gap that may be this far below zero, besides rounding, counts as open: coordinates are hardly
# more exact.
_GAP_TOLERANCE = 8e-12
# m. The same where the work exceeds its budget; it grows with the square of the excess.
_LIMITED_TOLERANCE = 2.5e-7

# The budget of work, in bench poses computed for all intervals of one length, of which a pair test
# costs 20: it takes a few seconds, and division exceeds it where a gap stays near zero for long.
_WORK_LIMIT, _PAIR_WORK = 2_000_000, 20
# A batch has a share of the budget by its duration, but at least this share, because the last batch
# before a contact may be short, and at least so many times its first work in short intervals.
_MIN_SHARE, _WORK_GROWTH = 0.05, 8

# Lengths of the first intervals, in shortest spacings; shorter while all pairs are tested, because
# each pair is tested again in all parts. Other values only change the number of divisions.
_INTERVAL, _ALL_PAIRS_INTERVAL = 1.2, 0.3
# Fewest and most intervals evaluated together, otherwise half of those that are left: many at
# first, and few where a march ends, because an inward one ends soon after its contact.
_FEWEST_INTERVALS, _MOST_INTERVALS = 16, 128
# Intervals that are not cleared are divided into so many parts that there are about as many pairs
# to test as this, for NumPy's overhead per call dominates with fewer; and bounds on the number of
# parts.
_PAIRS, _FEWEST_PARTS, _MOST_PARTS = 200, 2, 256
# Points per pass in the search for the last time at which the chain has a state.
_LAST_POINTS = 33

# A local minimum of a gap below this share of the narrowest bench's width is a near miss: 1 cm at
# the paper's 0.3 m.
_NEAR_MISS = 1 / 30
# Length of intervals in which near misses are sampled, in widths: a local minimum lasts about one
# width.
_NEAR_MISS_INTERVAL = 0.4
# Points per bracket in the search for a local minimum, and passes: each pass narrows the bracket
# eightfold.
_MINIMUM_POINTS, _MINIMUM_PASSES = 17, 7
# Handles placed together in that search: 20 MB of corners.
_MINIMUM_HANDLES = 300_000
# m of the head's distance, and share of the bracket: so close to its end, the minimum lies outside
# the bracket.
_BRACKET_END, _BRACKET_END_SHARE = 1e-9, 1e-6
# Share of the sum of their lengths: centres of adjacent intervals are half of it apart, but for
# rounding.
_ADJACENT = 0.51


def first_contact(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> FirstContact:
    """First contact of benches that are not neighbours, certified: there is no earlier one, however short.

    Parameters
    ----------
    march : March
        The motion.
    start, until : float
        Times of the search, s. It ends where the curve does; without `until`, it goes on to there.
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
    if progress is not None:
        function("progress", progress)
    march.handles_s(start)  # An error names the time of this march.
    unit = march.at_unit_speed()
    begin, end = march.distance([start, until]).tolist()
    # Not beyond the end of the curve by rounding.
    if until == march.end:
        end = unit.end
    elif until < march.end:
        end = min(end, unit.end)

    def report(cleared: float) -> None:
        if progress is not None:
            progress(float(march.time(cleared)), until)

    found = _Search(unit, begin, end).run(report)
    # `start` and `until` are returned as they were passed.
    time = {begin: start, end: until}.get(found.time, float(march.time(found.time)))
    misses = [replace(miss, time=float(march.time(miss.time))) for miss in found.near_misses or ()]
    return replace(found, time=time, near_misses=tuple(misses))


class _Search:
    """The search on a march at 1 m/s; its times are the head's distance from its position at t = 0, m."""

    def __init__(self, march: March, start: float, until: float) -> None:
        self._march, self._start, self._until, self._end = (
            march,
            start,
            until,
            min(until, march.end),
        )
        self._near = _NEAR_MISS * float(march.dragon.widths.min())
        self._near_miss_interval = _NEAR_MISS_INTERVAL * float(march.dragon.widths.min())
        self._hit, self._pair = np.inf, (0, 0)
        self._samples = self._tests = 0
        self._resolution = 0.0
        # Rows of pair, time, length of the interval, gap, bound on its rounding error.
        self._small_gaps: list[Array] = [np.empty((0, 6))]

    def run(self, report: Callable[[float], None]) -> FirstContact:
        """Result of the search; `report` is called with each time up to which the march is cleared."""
        march, last = self._march, self._start
        dragon, state = march.dragon, march.at(last)
        self._start_s, poses = state.handles_s[0], state.poses[0]
        near = near_pairs(as_complex(poses[:, :2]), np.hypot(dragon.lengths, dragon.widths) / 2)
        if (pair := deepest_overlap(dragon.outlines(poses), near)) is not None:
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
                end = _last_reachable(march, last, float(times[times > last][0]))
                last = self._clear(np.array([last, end])) if end > last else last
            if self._hit < np.inf:
                return self._result("contact", self._hit, self._pair)
            report(last)
            if last < times[-1]:
                break
        return self._result("clear" if last >= self._until else "unreachable", last, None)

    def _result(self, status: Status, time: float, pair: tuple[int, int] | None) -> FirstContact:
        """Result with the figures of the search so far."""
        misses = _near_misses(
            self._march, np.concatenate(self._small_gaps), self._start, time, self._near
        )
        figures = {"samples": self._samples, "tests": self._tests, "resolution": self._resolution}
        return result_at(self._march, status, time, pair, near_misses=misses, **figures)

    def _end_of_warm_up(self) -> float:
        """Time by which each bench behind bench 1 has reached the start position of the bench before it, or the end."""
        if not self._one_function:
            return self._end
        # 5 % more than a spacing, and 5 % more until the condition holds.
        wait = 1.05 * float(self._march.dragon.spacings[-1])
        while self._start + wait < self._end:
            if np.all(
                self._march.motion_or_nan(self._start + wait).handles_s[0, 2:-1]
                >= self._start_s[1:-2]
            ):
                return self._start + wait
            wait *= 1.05
        return self._end

    def _batches(self) -> Iterator[Array]:
        """Bounds of consecutive intervals, one array for each batch; shorter intervals during the warm-up."""
        ends, shortest = (
            (self._start, self._warm_up_end, self._end),
            self._march.dragon.spacings.min(),
        )
        for begin, last, length in zip(
            ends, ends[1:], (_ALL_PAIRS_INTERVAL, _INTERVAL), strict=False
        ):
            count = int(np.ceil((last - begin) / (length * shortest)))
            done = 0
            while done < count:
                batch = min(
                    max((count - done) // 2, _FEWEST_INTERVALS), _MOST_INTERVALS, count - done
                )
                shares = np.arange(done, done + batch + 1) / count
                done += batch
                # Exact at both ends.
                yield (1 - shares) * begin + shares * last

    def _clear(self, times: Array) -> float:
        """Clear the intervals between `times` up to the last one with a state of the chain, which is returned."""
        march = self._march
        intervals = Intervals.between(march, times)
        last = float(times[intervals.begins.size])
        if not intervals.begins.size:
            return last
        bounds = MotionBounds(march, intervals)
        rows, pairs = bounds.candidates(
            self._near, np.where(self._one_function, self._start_s, np.inf)
        )
        # Intervals that are cleared without a proof for rounding count in the resolution.
        self._resolution = max(self._resolution, UNPROVEN_ROUNDING * (not bounds.proven.all()))
        share = max(float(times[-1] - times[0]) / (self._end - self._start), _MIN_SHARE)
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
        """Clear `pairs` (P, 2) in the intervals `rows` (P,) and in parts of these, or find their first contact."""
        sampled, limit = np.zeros(rows.size, dtype=bool), 0.0
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
                # benches that move independently is faster, and the bound for their relative motion
                # clears some of the rest.
                gaps = bounds.smallest_gaps(rows, pairs, found.normal)
                rest = ~(gaps > self._near)
                gaps[rest] = bounds.smallest_gaps_together(
                    rows[rest], pairs[rest], found.normal[rest]
                )
                open_ = gaps > self._near
            else:
                # A short interval: the bound by relative motion needs the proof for rounding, the
                # bound by travel not.
                gaps = bounds.smallest_gaps_together(rows, pairs, found.normal)
                weak = ~bounds.proven[rows]
                gaps[weak] = bounds.gaps_by_travel(rows[weak], pairs[weak], found.distance[weak])
                # The first time that a gap has a bound, and may be a near miss, its midpoint is
                # kept as a sample.
                fresh = np.isfinite(gaps) & ~sampled
                sampled |= fresh
                fresh &= (gaps <= self._near) & (pairs[:, 0] <= 1 if self._one_function else True)
                lengths = np.full(rows.size, length)
                small = np.column_stack(
                    [pairs, middles, lengths, found.distance, bounds.rounding[rows]]
                )
                self._small_gaps.append(small[fresh])
                # The tolerance grows once the work exceeds its budget.
                work = samples * (int(pairs.max()) + 2) + _PAIR_WORK * rows.size
                limit = limit or max(budget, _WORK_GROWTH * work)
                tolerance = (
                    _GAP_TOLERANCE if work <= limit else _LIMITED_TOLERANCE * (work / limit) ** 2
                )
                # Gaps above zero are open, and those that may be below by the tolerance, except in
                # the interval just before the earliest contact found. That one is divided to the
                # resolution, where its midpoint decides.
                within = (gaps > -(bounds.rounding[rows] + tolerance)) & (
                    intervals.ends[rows] + length < self._hit
                )
                self._resolution = max(self._resolution, -float(gaps[within].min(initial=0.0)))
                open_ = (gaps > 0) | within | (length <= _resolution(float(np.abs(middles).max())))
            self._resolution = max(
                self._resolution, UNPROVEN_ROUNDING * (not bounds.proven[rows[open_]].all())
            )
            left = ~open_ & (intervals.begins[rows] < self._hit)
            rows, pairs, sampled = rows[left], pairs[left], sampled[left]
            if rows.size:
                # Intervals with pairs that are left are divided, and each of these pairs is tested
                # in all parts.
                parts = min(max(_PAIRS // rows.size, _FEWEST_PARTS), _MOST_PARTS)
                chosen, rows = np.unique(rows, return_inverse=True)
                intervals = intervals.divided(self._march, chosen, parts, int(pairs.max()) + 2)
                rows = (parts * rows[:, None] + np.arange(parts)).ravel()
                pairs, sampled = np.repeat(pairs, parts, axis=0), np.repeat(sampled, parts)
                bounds = MotionBounds(self._march, intervals)

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
    """Result at `time`, with the contact point and the normal of the benches `pair` if there is one."""
    point = normal = None
    if pair is not None:
        poses = march.at(time, handles=pair[1] + 2).poses[0]
        found = separation(*march.dragon.outlines(poses)[list(pair)])
        (x, y), (nx, ny) = found.point.tolist(), found.normal.tolist()
        point, normal = (x, y), (nx, ny)
    return FirstContact(status=status, time=time, benches=pair, point=point, normal=normal, **rest)


def _resolution(time: float) -> float:
    """Length of the shortest intervals about a time, m of the head's distance."""
    return max(_RESOLUTION, _LAST_DIGITS * float(np.spacing(abs(time))))


def _last_reachable(march: March, begin: float, later: float) -> float:
    """Last time at which the chain has a state, between one at which it has and one at which it has not.

    It is early by the resolution: nearer to the end, rounding decides whether there is a state, and
    rounding depends on the processor and on the number of times that are computed together.
    """
    reachable = begin
    while later - reachable > _RESOLUTION and reachable < (reachable + later) / 2 < later:
        times = np.linspace(reachable, later, _LAST_POINTS)
        # If a handle has no coordinate, the last one has none.
        lost: Flags = np.isnan(march.motion_or_nan(times).handles_s[:, -1])
        lost[-1] = True
        first = max(1, int(lost.argmax()))
        reachable, later = float(times[first - 1]), float(times[first])
    return max(begin, reachable - _resolution(reachable))


def _near_misses(
    march: March, samples: Array, start: float, end: float, near: float
) -> tuple[NearMiss, ...]:
    """Local minima of gaps between `start` and `end` below `near` m, from the samples (K, 6) that `_Search` keeps."""
    samples = samples[samples[:, 2] <= end]
    brackets = np.array(list(_brackets(samples[np.lexsort(samples.T[2::-1])].tolist()))).reshape(
        -1, 5
    )
    if not brackets.size:
        return ()
    pairs, (low, high, rounding) = brackets[:, :2].astype(np.intp), brackets[:, 2:].T
    low, high = np.maximum(low, start), np.minimum(high, end)
    some = max(1, _MINIMUM_HANDLES // (_MINIMUM_POINTS * (int(pairs.max()) + 2)))
    parts = (slice(at, at + some) for at in range(0, len(pairs), some))
    found = np.concatenate(
        [_local_minima(march, pairs[part], low[part], high[part], rounding[part]) for part in parts]
    )
    found = found[(found[:, 3] > 0) & (found[:, 3] < near)]
    return tuple(
        NearMiss(time=time, benches=(int(i), int(j)), gap=gap)
        for time, i, j, gap in sorted(found.tolist())
    )


def _brackets(samples: list[list[float]]) -> Iterator[tuple[float, float, float, float, float]]:
    """Pairs, times between which their gap has a local minimum, and rounding error, from samples in order.

    The gap falls to a minimum and rises from it by more than rounding. Where samples end, the gap
    is larger.
    """
    before: list[float] = [-1, -1, 0, 0, 0, 0]
    falls, low, lowest, highest = False, 0.0, 0.0, 0.0
    for sample in [*samples, before]:
        first, second, time, length, gap, rounding = sample
        if (first, second) != tuple(before[:2]) or time - before[2] > _ADJACENT * (
            length + before[3]
        ):
            # Another pair begins, or other intervals: a gap that fell to the end of the last ones
            # has a minimum.
            if falls:
                yield before[0], before[1], low, before[2] + before[3] / 2, before[5]
            falls, low, lowest = True, time - length / 2, gap
        elif falls and gap < lowest - rounding:
            # The gap falls further.
            low, lowest = before[2], gap
        elif falls and gap > lowest + rounding:
            # It rises: its minimum is behind.
            yield first, second, low, time, rounding
            falls, highest = False, gap
        elif not falls and gap < highest - rounding:
            # It falls again, from a maximum.
            falls, low, lowest = True, before[2], gap
        highest = max(highest, gap)
        before = sample


def _local_minima(march: March, pairs: Indices, low: Array, high: Array, rounding: Array) -> Array:
    """Minima (B, 4) of the gaps of `pairs` (K, 2) inside the brackets from `low` to `high` (K,).

    Each is time, first bench, second bench, and gap in m. A bracket whose gap is no smaller inside
    than at one of its ends, but for `rounding` (K,), has none.
    """
    # No time is outside a bracket that is shorter than both margins: the chain may have no state
    # there.
    margin = np.clip(_BRACKET_END_SHARE * (high - low), _BRACKET_END, (high - low) / 2)
    times = np.column_stack(
        [low, np.linspace(low + margin, high - margin, _MINIMUM_POINTS, axis=-1), high]
    )
    gaps = _gaps(march, pairs, times)
    inside = (gaps[:, [0, -1]].min(axis=1) > gaps.min(axis=1) + rounding) & (
        high - low > 2 * margin
    )
    pairs, times, gaps = pairs[inside], times[inside], gaps[inside]
    rows = np.arange(len(pairs))
    for _ in range(_MINIMUM_PASSES if rows.size else 0):
        best = np.clip(gaps.argmin(axis=1), 1, times.shape[1] - 2)
        times = np.linspace(times[rows, best - 1], times[rows, best + 1], _MINIMUM_POINTS, axis=-1)
        gaps = _gaps(march, pairs, times)
    best = gaps.argmin(axis=1)
    return np.stack([times[rows, best], *pairs.T, gaps[rows, best]], axis=1)


def _gaps(march: March, pairs: Indices, times: Array) -> Array:
    """Gaps (B, K) of `pairs` (B, 2) at `times` (B, K), m."""
    rows, (first, second) = np.arange(times.size), np.repeat(pairs, times.shape[1], axis=0).T
    corners = as_vectors(
        march.dragon.outlines_between(march.motion(times, int(pairs.max()) + 2).points)
    )
    return separation(corners[rows, first], corners[rows, second]).distance.reshape(times.shape)
