"""Time and memory of a film: `python tests/bench/bench_film.py`.

The film is 300 frames of 640 x 640 of the seed's 223 benches. Drawing and encoding are timed apart, frame by frame in
turns, and the medians over the repeats are printed; the peak is that of a process of its own that makes the film once,
interpreter and imports included.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np

from pymunk_dragon.march import March
from pymunk_dragon.render import Film, write_film
from pymunk_dragon.render.film import make_scene, states
from pymunk_dragon.render.gif import GifStream
from pymunk_dragon.render.palette import TRANSPARENT
from pymunk_dragon.run import Run

FRAMES, REPEATS = 300, 5
SINCE = 100.0
FILM = Film(size=640, fps=20, speedup=10.0, since=SINCE, until=SINCE + (FRAMES - 1) / 2)
PEAK_ONLY = "--peak"


def example() -> Run:
    """A run with a frame every half second, as a film of the whole march needs it."""
    return Run.exact(March(), np.arange(SINCE, SINCE + FRAMES / 2 + 0.5, 0.5))


def timed(run: Run, folder: Path) -> tuple[float, float]:
    """Milliseconds a frame for drawing (poses included) and for encoding."""
    times = FILM.times(run)
    assert len(times) == FRAMES
    scene = make_scene(run, FILM, times)
    drawing = encoding = 0.0
    with (folder / "film.gif").open("wb") as file, GifStream(file, FILM.shape, FILM.palette.table, TRANSPARENT) as gif:
        moments = states(run, times)
        while True:
            begin = time.perf_counter()
            moment = next(moments, None)
            if moment is None:
                break
            picture = scene.draw(*moment)
            drawn = time.perf_counter()
            gif.add(picture, 5)
            drawing += drawn - begin
            encoding += time.perf_counter() - drawn
    return 1000 * drawing / FRAMES, 1000 * encoding / FRAMES


def peak_memory() -> float:
    """Largest resident set of this process so far, MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)


def main() -> None:
    """Print one line."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if PEAK_ONLY in sys.argv:
            write_film(example(), folder / "film.gif", FILM)
            print(f"{peak_memory():.0f}")
            return
        run = example()
        figures = [timed(run, folder) for _ in range(REPEATS)]
        megabytes = (folder / "film.gif").stat().st_size / 1e6
    child = subprocess.run([sys.executable, __file__, PEAK_ONLY], check=True, capture_output=True, text=True)
    draw, encode = median(f[0] for f in figures), median(f[1] for f in figures)
    total = median(sum(f) for f in figures)
    print(
        f"film, {FRAMES} frames of 640 x 640, 223 benches: draw {draw:.1f} ms, encode {encode:.1f} ms, "
        f"total {total:.1f} ms a frame; {megabytes:.1f} MB; peak memory {child.stdout.strip()} MB"
    )


if __name__ == "__main__":
    main()
