"""Near misses: local minima of the gaps between benches, located from samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arrays import Array, Indices, as_vectors
from pymunk_dragon._language import text
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
        line = text("near miss at t = {t:.4f} s: benches {i} and {j}, {gap:.3f} mm apart")
        return line.format(t=self.time, i=i, j=j, gap=1e3 * self.gap)


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
    found = np.concatenate(minima)
    found = found[(found[:, 3] > 0) & (found[:, 3] < near)]
    return tuple(NearMiss(time=time, benches=(int(i), int(j)), gap=gap) for time, i, j, gap in sorted(found.tolist()))


def _local_minima(march: March, pairs: Indices, low: Array, high: Array) -> Array:
    """Minima (B, 4) of the gaps of `pairs` (K, 2) inside the brackets from `low` to `high` (K,).

    Each is time, first bench, second bench, and gap in m. A bracket whose gap is smallest at one of its ends has none.
    """
    # No time is outside a bracket that is shorter than both margins: the chain may have no state there.
    margin = np.clip(BRACKET_END_SHARE * (high - low), BRACKET_END, (high - low) / 2)
    times = np.column_stack([low, np.linspace(low + margin, high - margin, MINIMUM_POINTS, axis=-1), high])
    gaps = _gaps(march, pairs, times)
    best = gaps.argmin(axis=1)
    inside = (best > 0) & (best < MINIMUM_POINTS + 1) & (high - low > 2 * margin)
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
