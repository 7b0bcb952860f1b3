"""How long each lesson takes, run by itself as a process, and how large its picture is."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

from pymunk_dragon.demos import DEMOS

REPEATS = 3


def seconds(program: Path, folder: str) -> float:
    begin = perf_counter()
    subprocess.run([sys.executable, program, "--save", folder], check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - begin


print(f"{'lesson':<14} {'s':>5} {'lines':>6} {'kB':>5}")
for name, demo in DEMOS.items():
    with tempfile.TemporaryDirectory() as folder:
        took = median(seconds(demo.path, folder) for _ in range(REPEATS))
        [picture] = Path(folder).iterdir()
        print(f"{name:<14} {took:>5.1f} {len(demo.source.splitlines()):>6} {picture.stat().st_size / 1000:>5.0f}")
