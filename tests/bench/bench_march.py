"""What it costs to place the dragon: on the spiral, by the code for any curve, in the U-turn, and on a user's points.

Prints medians in ms for 301 times at once: positions, velocities and speeds of all 224 handles.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from time import perf_counter

import numpy as np

from pymunk_dragon import March, Reversed, Sampled, Spiral, UTurn

REPEATS = 9


def median_ms(work: Callable[[], object]) -> float:
    times = []
    for _ in range(REPEATS):
        begin = perf_counter()
        work()
        times.append(perf_counter() - begin)
    return 1e3 * statistics.median(times)


def main() -> None:
    spiral = March()
    times = np.linspace(0, 412, 301)
    points = spiral.curve.point(np.linspace(-900, -1, 4000))
    marches = {
        "spiral": spiral,
        "the same by the code for any curve": March(curve=Reversed(Reversed(Spiral())), start=spiral.head_start),
        "the same through 4000 points": March(curve=Sampled(points), start=900 + spiral.head_start - 1),
        "u-turn, from -100 s to 312 s": March(curve=UTurn(), start=-100.0),
    }
    alone = None
    for name, march in marches.items():
        ms = median_ms(lambda march=march: march.at(times))
        alone = alone or ms
        print(f"{name:<38} {ms:7.1f} ms  {ms / alone:5.2f}")


if __name__ == "__main__":
    main()
