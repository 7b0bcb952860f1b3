"""What takes how long, beside the plain ways to do it: `python tests/bench/bench_speed.py`.

All rows come from one run, with repeats in turns, as medians in ms. The plain recursion goes from handle to handle,
vectorised over the times, with Newton's method in polar angles (paper, eq. 10-15). Films have frames of 640 x 640
pixels of the reference scenario.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
from bench_film import film_of, imageio_rgb, matplotlib_animation, ours
from measure import durations, sized

from pymunk_dragon import Dragon, March, UTurn, first_contact, simulate
from pymunk_dragon._arrays import Array

REPEATS = sized(15, 1)
TIMES = sized(301, 3)
FRAMES = sized(60, 3)
# s, from t = 0 to the first contact of the reference march.
ENGINE_UNTIL = sized(415.0, 0.2)
PLAIN_TOLERANCE = 1e-12


def plain_recursion(times: Array) -> tuple[Array, Array]:
    """Positions and velocities (T, 224) of the reference march, handle after handle, as complex numbers."""
    dragon, k, turns = Dragon(), 0.55 / (2 * np.pi), 16.0
    theta = np.empty((times.size, dragon.handles))
    arc = np.pi * turns * np.hypot(2 * np.pi * turns, 1) + np.arcsinh(2 * np.pi * turns) / 2 - times / k
    theta[:, 0] = np.sqrt(2 * arc)
    for _ in range(4):
        rise = np.hypot(theta[:, 0], 1)
        theta[:, 0] -= ((theta[:, 0] * rise + np.arcsinh(theta[:, 0])) / 2 - arc) / rise
    for i, chord in enumerate(dragon.spacings):
        front = theta[:, i]
        phi = chord / (k * front)
        for _ in range(20):
            rear = front + phi
            distance = front**2 + rear**2 - 2 * front * rear * np.cos(phi) - (chord / k) ** 2
            step = distance / (2 * rear - 2 * front * np.cos(phi) + 2 * front * rear * np.sin(phi))
            phi = phi - step
            if np.max(np.abs(step)) < PLAIN_TOLERANCE:
                break
        theta[:, i + 1] = front + phi
    points = k * theta * np.exp(1j * theta)
    tangents = -(1 + 1j * theta) * np.exp(1j * theta) / np.hypot(1, theta)
    speeds = np.ones(theta.shape)
    for i in range(dragon.benches):
        bench = points[:, i] - points[:, i + 1]
        ratio = (tangents[:, i] * bench.conj()).real / (tangents[:, i + 1] * bench.conj()).real
        speeds[:, i + 1] = speeds[:, i] * ratio
    return points, speeds * tangents


def process(*arguments: str) -> None:
    """Run the program."""
    subprocess.run([sys.executable, "-m", "pymunk_dragon", *arguments], check=True, stdout=subprocess.DEVNULL)


def medians(ways: dict[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Median times in ms, of repeats in turns after a first one that is not measured."""
    for work in ways.values():
        work()
    found: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(repeats):
        for name, work in ways.items():
            found[name] += durations(work, 1)
    return {name: 1e3 * median(values) for name, values in found.items()}


def show(times: dict[str, float], unit: str) -> None:
    """A row for each of the times, with its share of the first one."""
    first = next(iter(times.values()))
    for name, value in times.items():
        print(f"| {name} | {value:.1f} {unit} | {value / first:.2f} |")


def marches() -> dict[str, Callable[[], object]]:
    """Positions and velocities of all handles at once: by the plain recursion, and by the project."""
    times, turn_times = np.linspace(0.0, 300.0, TIMES), np.linspace(-100.0, 100.0, TIMES)
    spiral = March()
    apart = np.abs(plain_recursion(times)[0] - spiral.motion(times).points).max()
    print(f"\nThe plain recursion and the project differ by at most {apart:.1e} m.")
    return {
        "plain recursion with NumPy": lambda: plain_recursion(times),
        "`March.at`": lambda: spiral.at(times),
        "the same on the U-turn, from -100 s to 100 s": partial(March(curve=UTurn()).at, turn_times),
    }


def films(folder: Path) -> dict[str, Callable[[], object]]:
    """A film as a GIF: by `render`, and by the usual libraries."""
    run, film = film_of(FRAMES)
    ways = {
        "`render`, one process": ours(".gif"),
        "imageio, a stack of RGB frames": imageio_rgb,
        "matplotlib, `FuncAnimation` and `PillowWriter`": matplotlib_animation,
    }
    return {name: partial(write, run, film, folder) for name, write in ways.items()}


def main() -> None:
    """Print the tables."""
    table = "| {} | median | share |\n| --- | --- | --- |"
    ways = marches()
    print(table.format(f"{TIMES} times x 224 handles"))
    show(medians(ways, REPEATS), "ms")
    print(table.format("search or process"))
    searches: dict[str, Callable[[], object]] = {
        "`first_contact`, reference march": lambda: first_contact(March()),
        "process `pymunk-dragon contact`": lambda: process("contact"),
        "process `pymunk-dragon study min-pitch`": lambda: process("study", "min-pitch"),
    }
    show(medians(searches, REPEATS), "ms")
    with tempfile.TemporaryDirectory() as name:
        print(table.format(f"GIF of {FRAMES} frames"))
        show(medians(films(Path(name)), max(1, REPEATS // 5)), "ms")
    run = simulate(March(), until=ENGINE_UNTIL)
    late = (run.first_contact.time - first_contact(March()).time) if run.first_contact else np.nan
    found = run.to_dict()
    print(
        f"\nEngine from t = 0 to the contact: {found['realtime_factor']:.1f} times real time, "
        f"driver {found['driver_overhead']:.2f} of the steps, drift {1e6 * run.max_drift:.1f} um, "
        f"contact {1e3 * late:+.3f} ms late"
    )


if __name__ == "__main__":
    main()
