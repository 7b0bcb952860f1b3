"""Speed of the engine: `python tests/bench/bench_engine.py`.

Prints, for whole marches and parts of them at the default settings and for the fine ones, how many times as fast as real
time the stepping loop runs, the driver's overhead (loop time outside `Space.step` over time inside it), and the time of a
substep outside and inside of it. Medians of interleaved repeats, with the range.
"""

from __future__ import annotations

from measure import sized, spread

from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.settings import FINE_ITERATIONS, FINE_STRIDE, EngineSettings
from pymunk_dragon.physics import simulate

REPEATS = sized(5, 1)
FINE = EngineSettings(substep=FINE_STRIDE, iterations=FINE_ITERATIONS)
# March, start and end, s (None: the first contact), and settings.
CASES = sized(
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
    runs: dict[str, list[Run]] = {name: [] for name in CASES}
    for _ in range(REPEATS):
        for name, (march, start, until, settings) in CASES.items():
            runs[name].append(simulate(march, start=start, until=until, settings=settings))
    print(f"{'march':33}{'times real time':>24}{'driver over steps':>24}{'driver, µs':>24}{'step, µs':>24}")
    for name, found in runs.items():
        values = [run.to_dict() for run in found]
        columns = [
            spread([value["realtime_factor"] for value in values], 1),
            spread([value["driver_overhead"] for value in values], 2),
            spread([1e6 * (run.wall_seconds - run.step_seconds) / run.substeps for run in found], 0),
            spread([1e6 * run.step_seconds / run.substeps for run in found], 0),
        ]
        print(f"{name:33}" + "".join(f"{column:>24}" for column in columns), flush=True)


if __name__ == "__main__":
    main()
