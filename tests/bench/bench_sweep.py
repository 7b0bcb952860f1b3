"""Sweeps: overhead of a point, efficiency on two cores, memory, and ten thousand contact times.

The overhead is the wall time of a sweep of a quantity of no work, a point. The start of the workers is left out: twice
as many points are compared with as many.

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
from pymunk_dragon._extras import library

WORKERS = 2
SHORT = {"benches": 2, "turns": 8}


def seconds(points: int, scheduler: str | None = None) -> float:
    """Wall time of a sweep of the quantity of no work, s."""
    axes = {"pitch": np.linspace(0.5, 0.6, points // 10).tolist(), "overhang": np.linspace(0.1, 0.2, 10).tolist()}
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder, "table.csv")
        return sweep(SHORT, axes, nothing, out=table, scheduler=scheduler, workers=WORKERS).seconds


def overhead() -> None:
    count = sized(1000, 20)
    with library("distributed").LocalCluster(
        n_workers=WORKERS, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        for name, scheduler in (("processes", None), ("Dask", cluster.scheduler_address)):
            found = [1e3 * (seconds(2 * count, scheduler) - seconds(count, scheduler)) / count for _ in range(3)]
            print(f"overhead of a point on {name}: {spread(found, 2)} ms", flush=True)


def efficiency() -> None:
    axes = {"pitch": np.linspace(0.45, 0.75, sized(20, 2)).tolist(), "width": np.linspace(0.2, 0.4, sized(10, 1))}
    found = []
    for _ in range(sized(3, 1)):
        one, two = (sweep(None, axes, workers=count).seconds for count in (1, 2))
        found.append(one / (2 * two))
    print(f"{sized(200, 2)} contact times: two workers do {spread(found, 3)} of twice the work of one")


def memory() -> None:
    """Largest memory of the process that sweeps, not of its workers."""
    code = (
        "import resource, sys; sys.path.insert(0, sys.argv[1]); from bench_sweep import seconds\n"
        "if __name__ == '__main__':\n"
        "    seconds(int(sys.argv[2]))\n"
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
