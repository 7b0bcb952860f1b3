"""Near misses: local minima of the gaps between benches, located from samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pymunk_dragon._arrays import Array, Indices, as_vectors
from pymunk_dragon.collision.result import NearMiss
from pymunk_dragon.collision.sat import separation
from pymunk_dragon.model.march import March

__all__ = ["NearMiss", "near_misses"]


# Points per bracket in the search for a local minimum, and passes: each pass narrows the bracket eightfold.
MINIMUM_POINTS = 17
MINIMUM_PASSES = 7
# Handles placed together in that search: 20 MB of corners.
MINIMUM_HANDLES = 300_000
# m of the head's distance, and share of the bracket: so close to its end, the minimum lies outside the bracket.
BRACKET_END = 1e-9
BRACKET_END_SHARE = 1e-6
# Share of the sum of their lengths: centres of adjacent intervals are half of it apart, but for rounding.
ADJACENT = 0.51


def near_misses(march: March, samples: Array, start: float, end: float, near: float) -> tuple[NearMiss, ...]:
    """Local minima below `near` m of the gaps between `start` and `end` s, on a march at 1 m/s.

    Parameters
    ----------
    march : March
        The motion.
    samples : ndarray, shape (K, 6)
        First bench, second bench, time, length of the interval about this time, gap, and bound on the gap's rounding
        error of each sample. Where an interval has no neighbour, the gap is larger there.
    """
    samples = samples[samples[:, 2] <= end]
    brackets = np.array(list(_brackets(samples[np.lexsort(samples.T[2::-1])].tolist()))).reshape(-1, 5)
    if not brackets.size:
        return ()
    pairs, (low, high, rounding) = brackets[:, :2].astype(np.intp), brackets[:, 2:].T
    low, high = np.maximum(low, start), np.minimum(high, end)
    some = max(1, MINIMUM_HANDLES // (MINIMUM_POINTS * (int(pairs.max()) + 2)))
    parts = [slice(at, at + some) for at in range(0, len(pairs), some)]
    minima = [_local_minima(march, pairs[part], low[part], high[part], rounding[part]) for part in parts]
    found = np.concatenate(minima)
    found = found[(found[:, 3] > 0) & (found[:, 3] < near)]
    return tuple(NearMiss(time=time, benches=(int(i), int(j)), gap=gap) for time, i, j, gap in sorted(found.tolist()))


def _brackets(samples: list[list[float]]) -> Iterator[tuple[float, float, float, float, float]]:
    """Pairs, times between which their gap has a local minimum, and rounding error, from samples in order.

    The gap falls to a minimum and rises from it by more than rounding.
    """
    before: list[float] = [-1, -1, 0, 0, 0, 0]
    falls, low, lowest, highest = False, 0.0, 0.0, 0.0
    for sample in [*samples, before]:
        first, second, time, length, gap, rounding = sample
        if (first, second) != tuple(before[:2]) or time - before[2] > ADJACENT * (length + before[3]):
            if falls:
                yield before[0], before[1], low, before[2] + before[3] / 2, before[5]
            falls, low, lowest = True, time - length / 2, gap
        elif falls and gap < lowest - rounding:
            low, lowest = before[2], gap
        elif falls and gap > lowest + rounding:
            yield first, second, low, time, rounding
            falls, highest = False, gap
        elif not falls and gap < highest - rounding:
            falls, low, lowest = True, before[2], gap
        highest = max(highest, gap)
        before = sample


def _local_minima(march: March, pairs: Indices, low: Array, high: Array, rounding: Array) -> Array:
    """Minima (B, 4) of the gaps of `pairs` (K, 2) inside the brackets from `low` to `high` (K,).

    Each is time, first bench, second bench, and gap in m. A bracket whose gap is no smaller inside than at one of its
    ends, but for `rounding` (K,), has none.
    """
    # No time is outside a bracket that is shorter than both margins: the chain may have no state there.
    margin = np.clip(BRACKET_END_SHARE * (high - low), BRACKET_END, (high - low) / 2)
    times = np.column_stack([low, np.linspace(low + margin, high - margin, MINIMUM_POINTS, axis=-1), high])
    gaps = _gaps(march, pairs, times)
    inside = (gaps[:, [0, -1]].min(axis=1) > gaps.min(axis=1) + rounding) & (high - low > 2 * margin)
    pairs, times, gaps = pairs[inside], times[inside], gaps[inside]
    rows = np.arange(len(pairs))
    for _ in range(MINIMUM_PASSES if rows.size else 0):
        best = np.clip(gaps.argmin(axis=1), 1, times.shape[1] - 2)
        times = np.linspace(times[rows, best - 1], times[rows, best + 1], MINIMUM_POINTS, axis=-1)
        gaps = _gaps(march, pairs, times)
    best = gaps.argmin(axis=1)
    return np.stack([times[rows, best], *pairs.T, gaps[rows, best]], axis=1)


def _gaps(march: March, pairs: Indices, times: Array) -> Array:
    """Gaps (B, K) of `pairs` (B, 2) at `times` (B, K), m."""
    rows, (first, second) = np.arange(times.size), np.repeat(pairs, times.shape[1], axis=0).T
    corners = as_vectors(march.dragon.outlines_between(march.motion(times, int(pairs.max()) + 2).points))
    return separation(corners[rows, first], corners[rows, second]).distance.reshape(times.shape)
