"""What the benchmarks share: a small size for tests, timings, and the table of benchmarks."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import TypeVar

from pymunk_dragon import March

T = TypeVar("T")

# With this flag a benchmark runs its whole code on little work. Its figures mean nothing then.
SMALL = "--small"


def sized(full: T, small: T) -> T:
    """`full`, or `small` where the command line has `--small`."""
    return small if SMALL in sys.argv else full


def run(benchmarks: Mapping[str, Callable[[], None]]) -> None:
    """Run the benchmarks that the command line names, or all."""
    for name in [argument for argument in sys.argv[1:] if argument != SMALL] or benchmarks:
        print(f"\n{name}: {benchmarks[name].__doc__}", flush=True)
        benchmarks[name]()


def compare(
    works: Mapping[str, Callable[[], object]],
    repeats: int,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Print and return the median time of each work, ms, of repeats in turns after a first one."""
    found: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(repeats + 1):
        for name, work in works.items():
            begin = clock()
            work()
            found[name].append(1e3 * (clock() - begin))
    medians = {name: median(values[1:]) for name, values in found.items()}
    for name, value in medians.items():
        print(f"| {name} | {value:.1f} ms | {value / next(iter(medians.values())):.2f} |")
    return medians


def spread(values: Sequence[float], digits: int) -> str:
    """Median of `values`, and their range in brackets."""
    return f"{median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def nothing(march: March) -> dict[str, float]:
    """A quantity of no work: workers of sweeps import it by its name."""
    return {"length": march.dragon.head_spacing}
