"""Speed of the engine at its default settings: `python tests/bench/bench_engine.py`.

Prints, for intervals of the paper's march, how many times as fast as real time the stepping loop runs, and the driver's
overhead: loop time outside `Space.step` over time inside it. Medians of interleaved repeats, with the range.
"""

from __future__ import annotations

from measure import sized, spread

from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.physics import simulate

REPEATS = sized(5, 1)
# Benches, start and end, s.
INTERVALS = sized(
    [(223, 0.0, 40.0), (223, 370.0, 410.0), (16, 370.0, 410.0), (1000, 0.0, 5.0)],
    [(16, 0.0, 0.2)],
)


def main() -> None:
    """Print the table."""
    speeds: dict[str, list[float]] = {}
    overheads: dict[str, list[float]] = {}
    for _ in range(REPEATS):
        for benches, start, until in INTERVALS:
            name = f"{benches} benches, {start:g} to {until:g} s"
            result = simulate(March(Dragon(benches=benches)), start=start, until=until).to_dict()
            speeds.setdefault(name, []).append(result["realtime_factor"])
            overheads.setdefault(name, []).append(result["driver_overhead"])
    print(f"{'interval':28}{'times real time':>24}{'driver over bare steps':>28}")
    for name in speeds:
        print(f"{name:28}{spread(speeds[name], 1):>24}{spread(overheads[name], 2):>28}")


if __name__ == "__main__":
    main()
