"""Every benchmark runs; the thorough tests run each at a small size, so that its figures can be measured again."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from browser import needs_browser
from documents import DOCUMENTS
from PIL import Image

from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player import write_player

ROOT = Path(__file__).parent.parent
BENCHMARKS = sorted((ROOT / "tests" / "bench").glob("bench_*.py"))


def run_script(*arguments):
    command = [sys.executable, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.thorough
@pytest.mark.parametrize(
    "path",
    [pytest.param(path, id=path.stem, marks=needs_browser if "live" in path.stem else ()) for path in BENCHMARKS],
)
def test_benchmark_runs_at_a_small_size(path):
    assert re.search(r"\d", run_script(path, "--small"))


@pytest.mark.thorough
@needs_browser
def test_screenshot_shows_a_page(tmp_path):
    page, picture = tmp_path / "run.html", tmp_path / "run.png"
    write_player(Run.exact(March(Dragon(benches=8)), np.arange(10.0)), page)
    run_script(ROOT / "tests" / "bench" / "screenshot.py", page, "#t=4", picture)
    with Image.open(picture) as shown:
        assert shown.size == (1200, 750)
        assert len(shown.convert("RGB").getcolors(maxcolors=2**24)) > 10


def test_texts_name_only_benchmarks_that_exist():
    named = {name for document in DOCUMENTS for name in re.findall(r"tests/bench/(\w+)\.py", document.text)}
    assert len(named) > 5
    assert named <= {path.stem for path in BENCHMARKS}
