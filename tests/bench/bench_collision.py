"""Speed of broad phase, narrow phase and first contact: `python tests/bench/bench_collision.py`.

Prints the median and the range, in microseconds, of filing and pairing the benches of a dragon, of the narrow phase on
the pairs that come out, and of the narrow phase on random rectangles; then, in seconds, of the certified first contact.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from measure import durations, sized, spread
from numpy.typing import NDArray

from pymunk_dragon.collision import first_contact
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.sat import overlap, separation
from pymunk_dragon.model.dragon import Dragon, outlines
from pymunk_dragon.model.march import March

REPEATS = sized(300, 1)


def microseconds(work: Callable[[], object], repeats: int = REPEATS) -> str:
    """Median and range of the time of a call."""
    return spread([1e6 * seconds for seconds in durations(work, repeats)], 0)


def rectangles(count: int) -> NDArray[np.float64]:
    """Outlines (count, 4, 2) of random rectangles, m."""
    rng = np.random.default_rng(0)
    poses = np.column_stack([rng.uniform(-5, 5, (count, 2)), rng.uniform(-np.pi, np.pi, count)])
    return outlines(poses, 10 ** rng.uniform(-1, 1, count), 0.3)


def main() -> None:
    """Print the three tables."""
    print(f"{'us, median of ' + str(REPEATS):40}{'file':>22}{'file and pair':>22}{'overlap':>22}{'separation':>22}")
    for benches, when in ((223, 0.0), (223, 412.0), (1000, 0.0)):
        march = March(Dragon(benches=benches))
        grid, corners = Grid.of(march), march.dragon.outlines(march.at(when).poses[0])
        one, two = (corners[side] for side in grid.pairs(corners).T)
        name = f"{benches} benches at {when:g} s, {len(one)} pairs"
        figures = [
            microseconds(partial(grid.file, corners)),
            microseconds(partial(grid.pairs, corners)),
            microseconds(partial(overlap, one, two)),
            microseconds(partial(separation, one, two)),
        ]
        print(f"{name:40}" + "".join(f"{figure:>22}" for figure in figures))
    for count in sized((1, 500, 2000, 1_000_000), (1, 500)):
        one, two = rectangles(2 * count).reshape(2, count, 4, 2)
        repeats = REPEATS if count < 10_000 else 5
        figures = [microseconds(partial(work, one, two), repeats) for work in (overlap, separation)]
        print(f"{f'{count} random pairs':40}{'':44}" + "".join(f"{figure:>22}" for figure in figures))
    print(f"{'first contact, s, median of 15':40}")
    for benches in sized((16, 223, 1000), (16,)):
        march = March(Dragon(benches=benches), turns=16 if benches < 1000 else 30)
        found = spread(durations(partial(first_contact, march), sized(15, 1)), 3)
        print(f"{f'{benches} benches, {march.end:.0f} s':40}{found:>22}")


if __name__ == "__main__":
    main()
