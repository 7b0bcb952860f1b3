"""Size of a player's page, and the time to write it: `python tests/bench/bench_player.py [RUN]`.

Without a run, the page plays the exact model's, 223 benches in frames a tenth of a second apart up to the first
contact.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
from measure import arguments, sized

from pymunk_dragon import March, Run
from pymunk_dragon.player import write_player


def main() -> None:
    """Print the size and the time."""
    given = arguments()
    run = Run.load(given[0]) if given else Run.exact(March(), np.arange(sized(4125, 50)) / 10)
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "run.html"
        begin = time.perf_counter()
        write_player(run, file)
        seconds = time.perf_counter() - begin
        print(f"{len(run.times)} frames: {file.stat().st_size / 1e6:.2f} MB, written in {seconds:.2f} s")


if __name__ == "__main__":
    main()
