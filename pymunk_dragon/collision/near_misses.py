"""Near misses: local minima of the gaps between benches, located from samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arrays import Array, Indices, as_vectors
from pymunk_dragon.collision.sat import separation
from pymunk_dragon.model.march import March

__all__ = ["NearMiss", "near_misses"]


# Points per bracket in the search for a local minimum, and passes: each pass narrows the bracket eightfold.
MINIMUM_POINTS = 17
MINIMUM_PASSES = 8
# Handles placed together in that search: 20 MB of corners.
MINIMUM_HANDLES = 300_000
# m of the head's distance, and share of the bracket: so close to its end, the minimum lies outside the bracket.
BRACKET_END = 1e-9
BRACKET_END_SHARE = 1e-6


@dataclass(frozen=True, kw_only=True)
class NearMiss:
    """A local minimum of the gap between two benches.

    Attributes
    ----------
    time : float
        s; accurate to a few microseconds only, because the gap is stationary there.
    benches : tuple of int
        The smaller number first.
    gap : float
        m.

    Examples
    --------
    >>> NearMiss(time=409.827, benches=(0, 11), gap=0.0009).benches
    (0, 11)
    """

    time: float
    benches: tuple[int, int]
    gap: float

    def __str__(self) -> str:
        i, j = self.benches
        return f"near miss at t = {self.time:.4f} s: benches {i} and {j}, {1e3 * self.gap:.3f} mm apart"


def near_misses(march: March, samples: Array, start: float, end: float, near: float) -> tuple[NearMiss, ...]:
    """Local minima below `near` m of the gaps between `start` and `end` s, on a march at 1 m/s.

    Parameters
    ----------
    march : March
        The motion.
    samples : ndarray, shape (K, 5)
        First bench, second bench, time, length of the interval about this time, and gap of each sample. Where a sample
        has no neighbour, the gap there is known to be larger.
    """
    samples = samples[samples[:, 2] <= end]
    if not samples.size:
        return ()
    first, second, times, lengths, gaps = samples[np.lexsort(samples.T[2::-1])].T
    follows = (np.diff(first) == 0) & (np.diff(second) == 0) & (np.diff(times) < 1.5 * lengths[1:])
    falls = np.diff(gaps) < 0
    smallest = ~np.append(follows & falls, False) & ~np.append(False, follows & ~falls)
    pairs = np.stack([first, second], axis=-1)[smallest].astype(np.intp)
    low, high = np.maximum(times - lengths, start)[smallest], np.minimum(times + lengths, end)[smallest]
    some = max(1, MINIMUM_HANDLES // (MINIMUM_POINTS * (int(pairs.max()) + 2)))
    parts = [slice(at, at + some) for at in range(0, len(pairs), some)]
    minima = [_local_minima(march, pairs[part], low[part], high[part]) for part in parts]
    times, gaps = np.concatenate(minima, axis=1)
    margin = np.maximum(BRACKET_END_SHARE * (high - low), BRACKET_END)
    inside = (times > low + margin) & (times < high - margin) & (gaps > 0) & (gaps < near)
    found = zip(times[inside].tolist(), pairs[inside].tolist(), gaps[inside].tolist(), strict=True)
    return tuple(NearMiss(time=time, benches=(i, j), gap=gap) for time, (i, j), gap in sorted(found))


def _local_minima(march: March, pairs: Indices, low: Array, high: Array) -> tuple[Array, Array]:
    """Times (B,) of the minima of the gaps of `pairs` (B, 2) between `low` and `high` (B,), and the gaps (B,), m."""
    handles, chosen = int(pairs.max()) + 2, np.arange(len(pairs))
    rows = np.arange(len(pairs) * MINIMUM_POINTS)
    first, second = np.repeat(pairs, MINIMUM_POINTS, axis=0).T
    for _ in range(MINIMUM_PASSES):
        times = np.linspace(low, high, MINIMUM_POINTS, axis=-1)
        corners = as_vectors(march.dragon.outlines_between(march.motion(times, handles).points))
        gaps = separation(corners[rows, first], corners[rows, second]).distance.reshape(times.shape)
        best = gaps.argmin(axis=1)
        low, high = times[chosen, np.maximum(best - 1, 0)], times[chosen, np.minimum(best + 1, MINIMUM_POINTS - 1)]
    return times[chosen, best], gaps[chosen, best]
