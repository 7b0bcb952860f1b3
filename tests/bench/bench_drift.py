"""Drift and time error against substep, iterations and drag: `python tests/bench/bench_drift.py`.

The paper's march from 400 s to its first contact. The exact time is the certified one.
"""

from __future__ import annotations

from measure import sized

from pymunk_dragon import March, first_contact
from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics import simulate

START = sized(400.0, 412.0)
# Those of `EngineSettings` at 1 m/s.
DEFAULT = (1 / 50, 10)
RATES, TRIES = sized(((25, 50, 100, 400), (10, 60)), ((100,), (10,)))
SETTINGS = [(1 / rate, iterations) for rate in RATES for iterations in TRIES]
DRAGS = sized((5.0, 7.0, 9.0, 11.5, 15.0, 20.0), (5.0,))


def row(march: March, exact: float, substep: float, iterations: int, drag: float = EngineSettings.drag) -> str:
    """Drift of the first twelve benches and of any, µm, and the error of the contact time, ms."""
    settings = EngineSettings(substep=substep, iterations=iterations, drag=drag)
    run = simulate(march, settings=settings, start=START, until=414.0)
    head, largest = 1e6 * run.head_drift, 1e6 * run.max_drift
    found = run.first_contact
    if found is None:
        ending = "none"
    elif found.benches != (0, 8):
        ending = f"benches {found.benches[0]} and {found.benches[1]} at {found.time:.2f} s"
    else:
        ending = f"{1e3 * (found.time - exact):+.3f}"
    return f"{head:.2f} | {largest:.2f} | {ending}"


def main() -> None:
    """Print both tables."""
    march = March()
    exact = first_contact(march).time
    print(f"exact first contact: {exact:.9f} s\n")
    print("| substep | iterations | drift of the first twelve, µm | of any, µm | error of the contact time, ms |")
    print("| --- | --- | --- | --- | --- |")
    for substep, iterations in SETTINGS:
        mark = " (default)" if (substep, iterations) == DEFAULT else ""
        print(f"| 1/{1 / substep:.0f} s | {iterations}{mark} | {row(march, exact, substep, iterations)} |", flush=True)
    print("\n| drag, 1/s | drift of the first twelve, µm | of any, µm | error of the contact time, ms |")
    print("| --- | --- | --- | --- |")
    for drag in DRAGS:
        print(f"| {drag:g} | {row(march, exact, *DEFAULT, drag)} |", flush=True)


if __name__ == "__main__":
    main()
