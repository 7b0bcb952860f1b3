"""The paper's way to the first contact: look every so often, with grid, DDA and SAT, and bisect (paper, section 2.2).

Quick to explain, and wrong wherever benches touch and part again between two looks: `impact.py` does not miss those.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import positive
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.impact import Impact, Status, checked_times
from pymunk_dragon.collision.sat import separation
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.march import March

__all__ = ["STEP", "TOLERANCE", "scan"]

Array = NDArray[np.float64]
Pair = tuple[int, int]

# s. The paper names the second in which the dragon collides.
STEP = 1.0
# s. A head at 1 m/s goes a micrometre.
TOLERANCE = 1e-6
# Looks for which the dragon is placed together.
BATCH = 64
MAX_LOOKS = 10_000_000


def scan(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    step: float = STEP,
    tolerance: float = TOLERANCE,
    progress: Callable[[float, float], None] | None = None,
) -> Impact:
    """First contact that a look at every `step` notices, bisected to `tolerance`.

    Parameters
    ----------
    march : March
        What to look at.
    start, until : float
        Times of the first and the last look, s; without `until`, the last is at the end of the curve.
    step, tolerance : float
        Time between looks, and how closely bisection encloses the contact, s.
    progress : callable, optional
        Told the time of the last look, and `until`, s.

    Returns
    -------
    Impact
        Its time is one at which the benches overlap, at most `tolerance` after one at which none do. It has no near
        misses: nobody measured gaps.

    Raises
    ------
    ParameterError
        If a time is no number, `until` is not later than `start`, `step` or `tolerance` is not above 0, or there would
        be more than ten million looks.
    UnreachableError
        If the dragon has no place at `start`.
    """
    start, until = checked_times(march, start, until)
    positive("step", step, np.inf, "s")
    positive("tolerance", tolerance, np.inf, "s")
    end = min(until, march.end)
    if (end - start) / step > MAX_LOOKS:
        raise ParameterError("step", step, f"long enough for at most {MAX_LOOKS:,} looks until {end:g} s")
    looks = _Looks(march)
    if (pair := looks.overlapping(march.at(start).poses[0])) is not None:
        return looks.impact("overlapping", start, pair)
    before = start
    for times, poses in _batches(march, np.append(np.arange(start + step, end, step), end)):
        for time, then in zip(times.tolist(), poses, strict=True):
            if (pair := looks.overlapping(then)) is not None:
                return looks.bisected(before, time, pair, tolerance)
            before = time
        if progress is not None:
            progress(before, until)
    return looks.impact("clear" if before >= until else "unreachable", before, None)


def _batches(march: March, times: Array) -> Iterator[tuple[Array, Array]]:
    """Some of `times` at once, with the poses then, as long as the chain has a place on the curve."""
    for first in range(0, times.size, BATCH):
        batch = times[first : first + BATCH]
        try:
            yield batch, march.at(batch).poses
        except UnreachableError as error:
            batch = batch[batch < error.time]
            yield batch, march.at(batch).poses
            return


class _Looks:
    """Looks at a dragon, and what they have cost."""

    def __init__(self, march: March) -> None:
        self._march, self._grid = march, Grid.of(march)
        self._looks = self._tests = 0

    def overlapping(self, poses: Array) -> Pair | None:
        """The pair that overlaps most at `poses` (N, 3), if any does."""
        corners = self._march.dragon.outlines(poses)
        pairs = self._grid.pairs(corners)
        distances = separation(corners[pairs[:, 0]], corners[pairs[:, 1]]).distance
        self._looks += 1
        self._tests += len(pairs)
        if not np.any(distances <= 0):
            return None
        first, second = pairs[distances.argmin()].tolist()
        return first, second

    def bisected(self, before: float, after: float, pair: Pair, tolerance: float) -> Impact:
        """The contact between a time at which no benches overlap and one at which `pair` does."""
        while after - before > tolerance and before < (middle := (before + after) / 2) < after:
            found = self.overlapping(self._march.at(middle).poses[0])
            if found is None:
                before = middle
            else:
                after, pair = middle, found
        return self.impact("contact", after, pair)

    def impact(self, status: Status, time: float, pair: Pair | None) -> Impact:
        return Impact.at(self._march, status, time, pair, clearances=None, looks=self._looks, tests=self._tests)
