"""What Pyodide runs for `bench_live.py`: imports of a session in a page, its steps and frames."""

import json
import sys
from pathlib import Path

from js import process

# Steps of 223 benches; benchmarks of a small size make fewer.
STEPS = int(Path("/results/steps").read_text())
times: dict[str, float] = {}


def processor() -> float:
    """Processor time, s; `time.process_time` is the time of the day in Pyodide."""
    usage = process.cpuUsage()
    return float(usage.user + usage.system) / 1e6


begin = processor()


def lap(name: str, parts: int = 1) -> None:
    """Note the time since the last call, s."""
    global begin
    now = processor()
    times[name] = (now - begin) / parts
    begin = now


# Each import is timed by itself.
import numpy  # noqa: E402, F401  # Only timed.

lap("import NumPy")
import pymunk  # noqa: E402, F401  # Only timed.

lap("import Pymunk")
from pymunk_dragon.sessions.scenes import named_scene  # noqa: E402  # Timed.
from pymunk_dragon.sessions.session import Session  # noqa: E402  # Timed.

lap("import sessions")
scene = Session(named_scene("dragon")).scene
lap("build 223 benches")
for _ in range(STEPS):
    scene.advance()
lap("a step of 223 benches", STEPS)
for _ in range(STEPS):
    scene.frame({})
lap("a frame of 223 benches", STEPS)
assert not {"click", "imageio"} & sys.modules.keys()
Path("/results/times.json").write_text(json.dumps(times))
