"""What it costs to place the dragon: on the spiral, by the code for any curve, in the U-turn, and on a user's points.

Prints medians in ms for 301 times at once: positions, velocities and speeds of all 224 handles.
"""

from __future__ import annotations

from functools import partial
from statistics import median

import numpy as np
from measure import durations, sized

from pymunk_dragon import March, Reversed, Sampled, Spiral, UTurn

REPEATS = sized(9, 1)
TIMES = sized(301, 3)


def main() -> None:
    """Print a line for each march."""
    spiral = March()
    times = np.linspace(0, 412, TIMES)
    points = spiral.curve.point(np.linspace(-900, -1, 4000))
    marches = {
        "spiral": spiral,
        "the same by the code for any curve": March(curve=Reversed(Reversed(Spiral())), start_s=spiral.head_start),
        "the same through 4000 points": March(curve=Sampled(points), start_s=900 + spiral.head_start - 1),
        "u-turn, from -100 s to 312 s": March(curve=UTurn(), start_s=-100.0),
    }
    alone = None
    for name, march in marches.items():
        ms = 1e3 * median(durations(partial(march.at, times), REPEATS))
        alone = alone or ms
        print(f"{name:<38} {ms:7.1f} ms  {ms / alone:5.2f}")


if __name__ == "__main__":
    main()
