"""What the benchmarks share: a small size for the tests, repeated timings, and how they are printed."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import TypeVar

from pymunk_dragon import March

T = TypeVar("T")

# With this flag a benchmark runs its whole code on little work. Its figures mean nothing then.
SMALL = "--small"


def arguments() -> list[str]:
    """Arguments of the command line without `--small`."""
    return [argument for argument in sys.argv[1:] if argument != SMALL]


def sized(full: T, small: T) -> T:
    """`full`, or `small` where the command line has `--small`."""
    return small if SMALL in sys.argv else full


def durations(work: Callable[[], object], repeats: int, clock: Callable[[], float] = time.perf_counter) -> list[float]:
    """Time of each of `repeats` calls, s."""
    found = []
    for _ in range(repeats):
        begin = clock()
        work()
        found.append(clock() - begin)
    return found


def spread(values: Sequence[float], digits: int) -> str:
    """Median of `values`, and their range in brackets."""
    return f"{median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def nothing(march: March) -> dict[str, float]:
    """A quantity of no work, for `bench_sweep.py`: workers import it by its name."""
    return {"length": march.dragon.head_spacing}
