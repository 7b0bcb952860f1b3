"""Speed of broad phase, narrow phase and first contact: `python tests/bench/bench_collision.py`.

Prints the median and the range, in microseconds, of filing and pairing the benches of a dragon, of the narrow phase on
the pairs that come out, and of the narrow phase on random rectangles; then, in seconds, of the certified first contact.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median

import numpy as np

from pymunk_dragon.collision import first_contact
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.sat import overlap, separation
from pymunk_dragon.dragon import Dragon, outlines
from pymunk_dragon.march import March

REPEATS = 300


def spread(work: Callable[[], object], repeats: int = REPEATS, units: float = 1e6) -> str:
    durations = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        durations.append(units * (time.perf_counter() - begin))
    digits = 0 if units > 1 else 3
    return f"{median(durations):.{digits}f} ({min(durations):.{digits}f} to {max(durations):.{digits}f})"


def rectangles(count: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    poses = np.column_stack([rng.uniform(-5, 5, (count, 2)), rng.uniform(-np.pi, np.pi, count)])
    return outlines(poses, 10 ** rng.uniform(-1, 1, count), 0.3)


def main() -> None:
    print(f"{'us, median of ' + str(REPEATS):40}{'file':>22}{'file and pair':>22}{'overlap':>22}{'separation':>22}")
    for benches, when in ((223, 0.0), (223, 412.0), (1000, 0.0)):
        march = March(Dragon(benches=benches))
        grid, corners = Grid.of(march), march.dragon.outlines(march.at(when).poses[0])
        one, two = (corners[side] for side in grid.pairs(corners).T)
        name = f"{benches} benches at {when:g} s, {len(one)} pairs"
        figures = [
            spread(lambda grid=grid, corners=corners: grid.file(corners)),
            spread(lambda grid=grid, corners=corners: grid.pairs(corners)),
            spread(lambda one=one, two=two: overlap(one, two)),
            spread(lambda one=one, two=two: separation(one, two)),
        ]
        print(f"{name:40}" + "".join(f"{figure:>22}" for figure in figures))
    for count in (1, 500, 2000, 1_000_000):
        one, two = rectangles(2 * count).reshape(2, count, 4, 2)
        repeats = REPEATS if count < 10_000 else 5
        figures = [
            spread(lambda one=one, two=two: overlap(one, two), repeats),
            spread(lambda one=one, two=two: separation(one, two), repeats),
        ]
        print(f"{f'{count} random pairs':40}{'':44}" + "".join(f"{figure:>22}" for figure in figures))
    print(f"{'first contact, s, median of 15':40}")
    for benches in (16, 223, 1000):
        march = March(Dragon(benches=benches), turns=16 if benches < 1000 else 30)
        print(
            f"{f'{benches} benches, {march.end:.0f} s':40}{spread(lambda march=march: first_contact(march), 15, 1):>22}"
        )


if __name__ == "__main__":
    main()
