"""Speed of the broad phase and of the first contact: `python tests/bench/bench_collision.py`.

Prints the median and the range, in microseconds, of filing and pairing the benches of a dragon, and of the narrow phase
on the pairs that come out; then, in seconds, of the certified first contact.
"""

from __future__ import annotations

from functools import partial

from measure import durations, sized, spread

from pymunk_dragon import Dragon, March, first_contact
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.sat import separation

REPEATS = sized(300, 1)


def main() -> None:
    """Print both tables."""
    print(f"{'us, median of ' + str(REPEATS):40}{'file':>22}{'file and pair':>22}{'separation':>22}")
    for benches, when in ((223, 0.0), (223, 412.0), (1000, 0.0)):
        march = March(Dragon(benches=benches))
        grid, corners = Grid.of(march), march.dragon.outlines(march.at(when).poses[0])
        one, two = (corners[side] for side in grid.pairs(corners).T)
        works = partial(grid.file, corners), partial(grid.pairs, corners), partial(separation, one, two)
        figures = [spread([1e6 * seconds for seconds in durations(work, REPEATS)], 0) for work in works]
        name = f"{benches} benches at {when:g} s, {len(one)} pairs"
        print(f"{name:40}" + "".join(f"{figure:>22}" for figure in figures))
    print(f"{'first contact, s, median of 15':40}")
    for benches in sized((16, 223, 1000), (16,)):
        march = March(Dragon(benches=benches), turns=16 if benches < 1000 else 30)
        found = spread(durations(partial(first_contact, march), sized(15, 1)), 3)
        print(f"{f'{benches} benches, {march.end:.0f} s':40}{found:>22}")


if __name__ == "__main__":
    main()
