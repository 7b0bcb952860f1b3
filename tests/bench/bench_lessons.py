"""Time of each lesson as a process of its own, and the size of its picture: `python tests/bench/bench_lessons.py`."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path
from statistics import median

from measure import durations, sized

from pymunk_dragon.lessons import LESSONS

REPEATS = sized(3, 1)
NAMES = sized(list(LESSONS), ["spiral"])


def main() -> None:
    """Print a line for each lesson."""
    print(f"{'lesson':<14} {'s':>5} {'lines':>6} {'kB':>5}")
    for name in NAMES:
        lesson = LESSONS[name]
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, str(lesson.path), "--save", folder]
            play = partial(subprocess.run, command, check=True, stdout=subprocess.DEVNULL)
            seconds = median(durations(play, REPEATS))
            [picture] = Path(folder).iterdir()
            kilobytes = picture.stat().st_size / 1000
            print(f"{name:<14} {seconds:>5.1f} {len(lesson.source.splitlines()):>6} {kilobytes:>5.0f}", flush=True)


if __name__ == "__main__":
    main()
