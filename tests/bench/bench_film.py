"""Time and memory of a film, beside imageio and matplotlib: `python tests/bench/bench_film.py`.

The film has 300 frames of 640 x 640 pixels of the reference scenario with 223 benches. Each way runs in a process of
its own, in turns, and the medians over the rounds are printed: the time from the first frame to the closed file without
imports, and the peak memory of the process and of its largest child, with interpreters and imports.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np
from measure import arguments, sized

from pymunk_dragon.drawing import Film, Palette, render
from pymunk_dragon.drawing.film.layout import Canvas
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

FRAMES, ROUNDS = sized((300, 3), (4, 1))
SINCE, STEP, SIZE, FPS = 100.0, 0.5, 640, 20


def film_of(frames: int) -> tuple[Run, Film]:
    """A run with a frame every half second, as a film of the whole march needs it, and the film."""
    last = SINCE + (frames - 1) * STEP
    return Run.exact(March(), np.arange(SINCE, last + STEP, STEP)), Film(
        size=SIZE, fps=FPS, speedup=FPS * STEP, start=SINCE, until=last, hold=0.0, legend=False
    )


def ours(ending: str) -> Callable[[Run, Film, Path], None]:
    """The project's own way, to a format."""

    def write(run: Run, film: Film, folder: Path) -> None:
        render(run, folder / f"film{ending}", film)

    return write


def imageio_rgb(run: Run, film: Film, folder: Path) -> None:
    """The default of imageio: a stack of RGB frames, drawn as ours are."""
    import imageio.v3 as iio

    stack = np.stack([np.asarray(frame) for frame in Canvas([run], film.timing([run]).times, film).frames()])
    iio.imwrite(folder / "film.gif", stack, duration=1000 / FPS, loop=0)


def matplotlib_animation(run: Run, film: Film, folder: Path) -> None:
    """FuncAnimation and PillowWriter of matplotlib with axes and a title, as they come."""
    from matplotlib.animation import FuncAnimation, PillowWriter
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    times = film.timing([run]).times
    march, palette = run.march, Palette()
    figure = Figure(figsize=(SIZE / 100, SIZE / 100), dpi=100)
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_xlim(-11.5, 11.5)
    axes.set_ylim(-11.5, 11.5)
    path = march.curve.point(np.linspace(*march.span(times[0], times[-1]), 5000))
    axes.plot(*path.T, color=palette.curve, linewidth=0.5)
    colours = [palette.head, *[palette.body] * (march.dragon.benches - 2), palette.tail]
    benches = PolyCollection([], facecolors=colours, edgecolors=palette.ink, linewidths=0.5)
    axes.add_collection(benches)
    clock = axes.set_title("")

    def draw(frame: int) -> None:
        benches.set_verts([*march.dragon.outlines(run.poses_at(times[frame])[0])])
        clock.set_text(f"t = {times[frame]:.2f} s")

    FuncAnimation(figure, draw, frames=len(times)).save(str(folder / "film.gif"), writer=PillowWriter(fps=FPS))


WAYS: dict[str, Callable[[Run, Film, Path], None]] = {
    "ours, GIF": ours(".gif"),
    "ours, APNG": ours(".apng"),
    "ours, WebP": ours(".webp"),
    "ours, MP4, beside FFmpeg": ours(".mp4"),
    "imageio, a stack of RGB frames, GIF": imageio_rgb,
    "matplotlib, FuncAnimation and PillowWriter, GIF": matplotlib_animation,
}


def measured(way: str, frames: int) -> tuple[float, float, float]:
    """Milliseconds a frame, MB of film and MB of memory."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # What is loaded on first use is loaded.
        WAYS[way](*film_of(2), folder)
        run, film = film_of(frames)
        begin = time.perf_counter()
        WAYS[way](run, film, folder)
        seconds = time.perf_counter() - begin
        size = max(file.stat().st_size for file in folder.iterdir())
    peak = sum(resource.getrusage(whose).ru_maxrss for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return 1000 * seconds / frames, size / 1e6, peak / (1e6 if sys.platform == "darwin" else 1e3)


def main() -> None:
    """Print the table, or one way's figures as JSON for the process that makes it."""
    if given := arguments():
        print(json.dumps(measured(given[0], FRAMES)))
        return
    found: dict[str, list[list[float]]] = {way: [] for way in WAYS}
    for _ in range(ROUNDS):
        for way, figures in found.items():
            child = [sys.executable, __file__, way, *sys.argv[1:]]
            figures.append(json.loads(subprocess.run(child, check=True, capture_output=True, text=True).stdout))
    print(f"{FRAMES} frames of {SIZE} x {SIZE}, 223 benches; {os.cpu_count()} cores, medians of {ROUNDS}")
    print(f"{'way':<50}{'ms a frame':>11}{'times ours':>12}{'MB':>7}{'memory, MB':>12}")
    medians = {way: [median(column) for column in zip(*figures, strict=True)] for way, figures in found.items()}
    first = next(iter(medians.values()))[0]
    for way, (milliseconds, megabytes, memory) in medians.items():
        print(f"{way:<50}{milliseconds:>11.1f}{milliseconds / first:>12.1f}{megabytes:>7.1f}{memory:>12.0f}")


if __name__ == "__main__":
    main()
