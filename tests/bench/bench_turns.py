"""The shortest turn found against a random search by brute force, which shares no code with it but the dragon's sizes.

Run it with `python tests/bench/bench_turns.py`. It prints the lengths by the number of arcs, and what the random search
finds in the same family from the contest's turn.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from arc_turns import random_search
from measure import sized

from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies._shortest import shortest_turn
from pymunk_dragon.studies.u_turn import MIN_RADIUS

CONTESTS = 1.6047933789666373
LIMITS = sized((1.3, CONTESTS, 1.7), (CONTESTS,))
ARCS = sized(7, 3)
TRIALS = sized(20_000, 20)


def main() -> None:
    """Search with each limit, and then at random with the contest's."""
    for limit in LIMITS:
        start = time.perf_counter()
        found = shortest_turn(UTurn(), Dragon(), limit, ARCS, MIN_RADIUS)
        wall = time.perf_counter() - start
        lengths = ", ".join(f"{length:.5f} m on {arcs} arcs" for arcs, length in found.lengths)
        print(f"limit {limit:.6f}: {lengths}; {found.evaluations} evaluations, {wall:.1f} s", flush=True)
    for arcs in (3, 5):
        start = time.perf_counter()
        length = random_search(arcs, CONTESTS, TRIALS)[0]
        print(f"at random, {arcs} arcs: {length:.5f} m after {TRIALS} trials, {time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main()
