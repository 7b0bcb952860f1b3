"""Speed of the engine at its default settings: `python tests/bench/bench_engine.py`.

Prints, for stretches of the seed's march, how many times as fast as real time the stepping loop runs, and the driver's
overhead: loop time outside `Space.step` over time inside it. Medians of interleaved repeats, with the range.
"""

from __future__ import annotations

from statistics import median

from pymunk_dragon.dragon import Dragon
from pymunk_dragon.march import March
from pymunk_dragon.physics import simulate

REPEATS = 5
STRETCHES = [
    ("223 benches, 0 to 40 s", 223, 0.0, 40.0),
    ("223 benches, 370 to 410 s", 223, 370.0, 410.0),
    ("16 benches, 370 to 410 s", 16, 370.0, 410.0),
    ("1000 benches, 0 to 5 s", 1000, 0.0, 5.0),
]


def spread(values: list[float], digits: int) -> str:
    return f"{median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def main() -> None:
    speeds: dict[str, list[float]] = {}
    overheads: dict[str, list[float]] = {}
    for _ in range(REPEATS):
        for name, benches, start, until in STRETCHES:
            timing = simulate(March(Dragon(benches=benches)), start=start, until=until).timing
            speeds.setdefault(name, []).append((until - start) / timing["wall_seconds"])
            overheads.setdefault(name, []).append(timing["wall_seconds"] / timing["step_seconds"] - 1)
    print(f"{'stretch':28}{'times real time':>24}{'driver over bare steps':>28}")
    for name, *_ in STRETCHES:
        print(f"{name:28}{spread(speeds[name], 1):>24}{spread(overheads[name], 2):>28}")


if __name__ == "__main__":
    main()
