"""The shortest turn against a fine grid: no turn on it that is shorter keeps to the limit.

Run it with `python tests/bench/bench_turns.py`; it takes some minutes.
"""

from __future__ import annotations

import time
from itertools import product

import numpy as np

from pymunk_dragon.curves import UTurn
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.studies.shortest import hurry, shortest_turn
from pymunk_dragon.studies.turns import three_arcs

RADII = np.arange(0.4, 3.2, 0.2)
BENDS = (-0.3, -0.1, -0.03, 0.0, 0.03, 0.1, 0.3)
KEPT = (0.0, 0.3)
LIMITS = (1.3, 1.6047933789666373, 1.7)


def main() -> None:
    """Search, then try every turn of the grid that is shorter than what was found."""
    base, spacings = UTurn(), Dragon().spacings
    found = []
    for limit in LIMITS:
        start = time.perf_counter()
        shortest = shortest_turn(base, spacings, limit)
        wall = time.perf_counter() - start
        found.append(shortest.turn.length)
        print(f"limit {limit:.6f}: {shortest.turn.length:.6f} m after {shortest.looks} looks, {wall:.1f} s", flush=True)
    tried = 0
    best = dict.fromkeys(LIMITS, np.inf)
    for first, second, bend, late, early in product(RADII, RADII, BENDS, KEPT, KEPT):
        turn = three_arcs(base, first, second, bend, late=late, early=early)
        if turn is None or turn.length >= max(found):
            continue
        tried += 1
        peaks = hurry(turn.path, spacings[:9], -3.0, turn.length + 5.0)
        most = np.inf if peaks is None else peaks[0].max()
        for limit in LIMITS:
            if most <= limit:
                best[limit] = min(best[limit], turn.length)
    for limit, length in zip(LIMITS, found, strict=True):
        print(f"limit {limit:.6f}: shortest on the grid {best[limit]:.6f} m, found {length:.6f} m")
    print(f"{tried} turns of the grid looked at")


if __name__ == "__main__":
    main()
