"""Speed of the engine: `python tests/bench/bench_engine.py`.

Prints, for the paper's march to its contact and for parts of other marches, how many times as fast as real time the
stepping loop runs, and the driver's overhead: loop time outside `Space.step` over time inside it. Medians of
interleaved repeats, with the range.
"""

from __future__ import annotations

from measure import sized, spread

from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.settings import FINE_ITERATIONS, FINE_STRIDE, EngineSettings
from pymunk_dragon.physics import simulate

REPEATS = sized(5, 1)
FINE = EngineSettings(substep=FINE_STRIDE, iterations=FINE_ITERATIONS)
# March, start and end, s (None: the first contact), and settings.
CASES: dict[str, tuple[March, float, float | None, EngineSettings]] = sized(
    {
        "223 benches, 0 s to the contact": (March(), 0.0, None, EngineSettings()),
        "the same, from 400 s": (March(), 400.0, None, EngineSettings()),
        "the same, --fine": (March(), 400.0, None, FINE),
        "in the U-turn, -10 to 30 s": (March(curve=UTurn()), -10.0, 30.0, EngineSettings()),
        "16 benches, 370 to 410 s": (March(Dragon(benches=16)), 370.0, 410.0, EngineSettings()),
        "1000 benches, 0 to 10 s": (March(Dragon(benches=1000)), 0.0, 10.0, EngineSettings()),
    },
    {"16 benches": (March(Dragon(benches=16)), 0.0, 0.2, EngineSettings())},
)


def main() -> None:
    """Print the table."""
    speeds: dict[str, list[float]] = {name: [] for name in CASES}
    overheads: dict[str, list[float]] = {name: [] for name in CASES}
    for _ in range(REPEATS):
        for name, (march, start, until, settings) in CASES.items():
            result = simulate(march, start=start, until=until, settings=settings).to_dict()
            speeds[name].append(result["realtime_factor"])
            overheads[name].append(result["driver_overhead"])
    print(f"{'march':33}{'times real time':>24}{'driver over bare steps':>28}")
    for name in CASES:
        print(f"{name:33}{spread(speeds[name], 1):>24}{spread(overheads[name], 2):>28}")


if __name__ == "__main__":
    main()
