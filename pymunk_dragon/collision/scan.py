"""First contact by sampling at equal time steps, with grid, DDA and SAT, then bisection (paper, section 2.2).

It misses contacts that open again between two samples; `first_contact.py` does not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import positive
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.result import FirstContact, Status, result_at
from pymunk_dragon.collision.sat import deepest_overlap
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.march import March, checked_times

__all__ = ["scan"]

Pair = tuple[int, int]

# Samples computed together.
BATCH = 64
# About a day of computing.
MAX_SAMPLES = 10_000_000


def scan(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    step: float = 1.0,
    tolerance: float = 1e-6,
    progress: Callable[[float, float], None] | None = None,
) -> FirstContact:
    """First contact among samples every `step`, bisected to `tolerance`.

    Parameters
    ----------
    march : March
        The motion.
    start, until : float
        Times of the first and the last sample, s; without `until`, the last is at the end of the curve.
    step, tolerance : float
        Time between samples, and length of the interval that bisection ends with, s. By default a second, to which
        the paper gives its answer, and the time in which a head at 1 m/s moves by a micrometre.
    progress : callable, optional
        Called with the time of the last sample, and with `until`, s.

    Returns
    -------
    FirstContact
        Its time is one at which the benches overlap, at most `tolerance` after one at which none do. Near misses and
        resolution are None: gaps are not measured.

    Raises
    ------
    ParameterError
        If a time is not a number, `until` is not later than `start`, `step` or `tolerance` is not above 0, or the
        number of samples is above ten million.
    UnreachableError
        If the dragon has no state at `start`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, scan
    >>> scan(March(Dragon(benches=16), turns=8), step=0.5).benches
    (0, 8)
    """
    start, until = checked_times(march, start, until)
    positive("step", step, np.inf, "s")
    positive("tolerance", tolerance, np.inf, "s")
    end = min(until, march.end)
    if (end - start) / step > MAX_SAMPLES:
        raise ParameterError("step", step, f"long enough for at most {MAX_SAMPLES:,} samples until {end:g} s")
    sampler = _Sampler(march)
    if (pair := sampler.overlapping(march.at(start).poses[0])) is not None:
        return sampler.result("overlapping", start, pair)
    before = start
    for times, poses in _batches(march, np.append(np.arange(start + step, end, step), end)):
        for time, then in zip(times.tolist(), poses, strict=True):
            if (pair := sampler.overlapping(then)) is None:
                before = time
                continue
            # Bisection, between a time at which no benches overlap and one at which `pair` does.
            while time - before > tolerance and before < (middle := (before + time) / 2) < time:
                if (found := sampler.overlapping(march.at(middle).poses[0])) is None:
                    before = middle
                else:
                    time, pair = middle, found
            return sampler.result("contact", time, pair)
        if progress is not None:
            progress(before, until)
    return sampler.result("clear" if before >= until else "unreachable", before, None)


def _batches(march: March, times: Array) -> Iterator[tuple[Array, Array]]:
    """Batches of `times` with the poses at these times, until the chain has no state."""
    for first in range(0, times.size, BATCH):
        batch = times[first : first + BATCH]
        try:
            yield batch, march.at(batch).poses
        except UnreachableError as error:
            batch = batch[batch < error.time]
            yield batch, march.at(batch).poses
            return


class _Sampler:
    """Overlap tests of a dragon, and their number."""

    def __init__(self, march: March) -> None:
        self._march, self._grid = march, Grid.of(march)
        self._samples = self._tests = 0

    def overlapping(self, poses: Array) -> Pair | None:
        """The pair with the deepest overlap at `poses` (N, 3), or None."""
        corners = self._march.dragon.outlines(poses)
        pairs = self._grid.pairs(corners)
        self._samples += 1
        self._tests += len(pairs)
        return deepest_overlap(corners, pairs)

    def result(self, status: Status, time: float, pair: Pair | None) -> FirstContact:
        counts = {"samples": self._samples, "tests": self._tests}
        return result_at(self._march, status, time, pair, near_misses=None, resolution=None, **counts)
