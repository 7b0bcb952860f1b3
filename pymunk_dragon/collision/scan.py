"""First contact by sampling at equal time steps, then bisection (paper, section 2.2).

Grid, DDA and SAT find the benches that overlap. The method misses contacts that open again between
two samples; `first_contact.py` does not.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import function, positive, silent
from pymunk_dragon.collision.first_contact import result_at
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.result import FirstContact, Status
from pymunk_dragon.collision.sat import deepest_overlap
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March, checked_times, states_while_reachable

# s. Length of the interval that bisection ends with: a head at 1 m/s moves by a micrometre in it.
_TOLERANCE = 1e-6
# Samples computed together.
_BATCH = 64
# About a day of computing.
_MAX_SAMPLES = 10_000_000


def scan(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    step: float = 1.0,
    progress: Callable[[float, float], None] = silent,
) -> FirstContact:
    """First contact among samples every `step`, bisected to a microsecond.

    Parameters
    ----------
    march : March
        The motion.
    start : float
        Time of the first sample, s.
    until : float, optional
        Time of the last sample, s; at the latest, and by default, where the curve ends.
    step : float
        Time between samples, s. The paper gives the second in which the dragon collides.
    progress : callable, optional
        Called with the time of the last sample, and with `until`, s.

    Returns
    -------
    FirstContact
        Its time is one at which the benches overlap, at most a microsecond after one at which none
        do. Near misses and resolution are None: gaps are not measured.

    Raises
    ------
    UnreachableError
        If the dragon has no state at `start`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, scan
    >>> scan(March(Dragon(benches=16), turns=8), step=0.5).benches
    (0, 8)
    """
    start, until = checked_times(march, start, until)
    function("progress", progress)
    step = positive("step", step, np.inf, "s")
    end = min(until, march.end)
    if (end - start) / step > _MAX_SAMPLES:
        bound = f"long enough for at most {_MAX_SAMPLES:,} samples until {end:g} s"
        raise ParameterError("step", step, bound)
    grid = Grid.of(march)
    counts = {"samples": 0, "tests": 0}

    def overlapping(poses: Array) -> tuple[int, int] | None:
        corners = march.dragon.outlines(poses)
        pairs = grid.pairs(corners)
        counts["samples"] += 1
        counts["tests"] += len(pairs)
        return deepest_overlap(corners, pairs)

    def result(status: Status, time: float, pair: tuple[int, int] | None) -> FirstContact:
        return result_at(march, status, time, pair, near_misses=None, resolution=None, **counts)

    pair = overlapping(march.at(start).poses[0])
    if pair is not None:
        return result("overlapping", start, pair)
    before = start
    times = np.append(np.arange(start + step, end, step), end)
    batches = (times[first : first + _BATCH] for first in range(0, times.size, _BATCH))
    for states in states_while_reachable(march, batches):
        for after, poses in zip(states.times.tolist(), states.poses, strict=True):
            pair = overlapping(poses)
            if pair is None:
                before = after
                progress(before, until)
                continue
            # Bisection between a time at which no benches overlap and one at which `pair` does.
            while after - before > _TOLERANCE and before < (middle := (before + after) / 2) < after:
                found = overlapping(march.at(middle).poses[0])
                if found is None:
                    before = middle
                else:
                    after = middle
                    pair = found
            return result("contact", after, pair)
    return result("clear" if before >= until else "unreachable", before, None)
