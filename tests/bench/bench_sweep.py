"""Sweeps: overhead of a point, efficiency on two cores, memory, and ten thousand contact times.

The overhead is the wall time of a sweep of a quantity of no work, less the time that the workers measure for it, a
point. The start of the workers is left out: twice as many points are compared with as many.

    python tests/bench/bench_sweep.py overhead      # seconds
    python tests/bench/bench_sweep.py efficiency    # two minutes
    python tests/bench/bench_sweep.py memory        # minutes
    python tests/bench/bench_sweep.py map           # ten minutes
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from measure import arguments, nothing, sized, spread

from pymunk_dragon import sweep
from pymunk_dragon.sweeps.evaluation import evaluate
from pymunk_dragon.sweeps.plan import Plan

WORKERS = 2
SHORT = {"benches": 2, "turns": 8}
REPEATS = sized(3, 1)


def seconds(points: int, scheduler: str | None, batch_size: int | None) -> float:
    """Wall time of a sweep of the quantity of no work, s."""
    with tempfile.TemporaryDirectory() as folder:
        return sweep(
            SHORT,
            # Lists of few values, which take no memory.
            {"pitch": np.linspace(0.5, 0.6, points // 10).tolist(), "overhang": np.linspace(0.1, 0.2, 10).tolist()},
            nothing,
            out=Path(folder, "table.csv"),
            scheduler=scheduler,
            workers=WORKERS,
            batch_size=batch_size,
        ).seconds


def overhead() -> None:
    plan = Plan.of(SHORT, {"pitch": [0.5, 0.6]}, nothing, None, 0, "sobol")
    points = [(pitch,) for pitch in np.linspace(0.5, 0.6, 500).tolist()]
    work = min(evaluate(plan.task(None), points)[1] for _ in range(5)) / len(points)
    print(f"the quantity of no work itself: {1e3 * work:.2f} ms a point, on each of {WORKERS} workers")
    print("| workers | points of a batch | overhead of a point, ms |")
    print("| --- | --- | --- |")
    for name, scheduler in sized((("processes", None), ("Dask", "local")), (("Dask", "local"),)):
        for batch_size, count in sized(((1, 500), (None, 4000)), ((None, 20),)):
            found = []
            for _ in range(REPEATS):
                short, long = (seconds(part * count, scheduler, batch_size) for part in (1, 2))
                found.append(1e3 * ((long - short) / count - work / WORKERS))
            print(f"| {name} | {batch_size or 'as measured'} | {spread(found, 2)} |", flush=True)


def efficiency() -> None:
    pitches = np.linspace(0.45, 0.75, sized(20, 2)).tolist()
    widths = np.linspace(0.2, 0.4, sized(10, 1)).tolist()
    found = []
    for _ in range(sized(3, 1)):
        one, two = (sweep(None, {"pitch": pitches, "width": widths}, workers=count).seconds for count in (1, 2))
        found.append(one / (2 * two))
    points = len(pitches) * len(widths)
    print(f"{points} contact times: two workers do {spread(found, 3)} of twice the work of one")


def memory() -> None:
    """Largest memory of the process that sweeps, not of its workers."""
    code = (
        "import resource, sys; sys.path.insert(0, sys.argv[1]); from bench_sweep import seconds\n"
        "if __name__ == '__main__':\n"
        "    seconds(int(sys.argv[2]), None, None)\n"
        "    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)"
    )
    for points in sized((1_000, 10_000, 100_000), (20,)):
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder, "measured.py")
            script.write_text(code)
            command = [sys.executable, str(script), str(Path(__file__).parent), str(points)]
            printed = subprocess.run(command, check=True, capture_output=True, text=True, env=dict(os.environ)).stdout
        print(f"{points} points: {float(printed):.0f} MB", flush=True)


def contact_map() -> None:
    side = sized(100, 2)
    axes = {"pitch": np.linspace(0.4, 0.8, side).tolist(), "width": np.linspace(0.2, 0.4, side).tolist()}
    begin = perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        found = sweep(None, axes, out=Path(folder, "map.csv"), workers=WORKERS)
    print(f"{found.points} contact times: {(perf_counter() - begin) / 60:.1f} minutes, {found.failed} failed")


PARTS = {"overhead": overhead, "efficiency": efficiency, "memory": memory, "map": contact_map}

if __name__ == "__main__":
    for name in arguments() or PARTS:
        PARTS[name]()
