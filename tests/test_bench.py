"""Every benchmark runs; the thorough tests run each at a small size, so that its figures can be measured again."""

import re
import subprocess
import sys

import bench
import bench_live
import numpy as np
import pytest
from browser import needs_browser
from documents import DOCUMENTS, ROOT
from PIL import Image

from pymunk_dragon import Dragon, March, Run, write_player

NAMES = {"bench.py": bench.BENCHMARKS, "bench_live.py": bench_live.BENCHMARKS}


def run_script(script, *arguments):
    command = [sys.executable, str(ROOT / "tests" / "bench" / script), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("script", "name"),
    [("bench.py", name) for name in bench.BENCHMARKS]
    + [pytest.param("bench_live.py", name, marks=needs_browser) for name in bench_live.BENCHMARKS],
)
def test_benchmark_runs_at_a_small_size(script, name):
    if name == "time-of-impact":
        pytest.importorskip("Box2D")
    _, output = run_script(script, name, "--small").split("\n", 2)[1:]
    assert re.search(r"\d", output)


@pytest.mark.thorough
@needs_browser
def test_screenshot_shows_a_page(tmp_path):
    page, picture = tmp_path / "run.html", tmp_path / "run.png"
    write_player(Run.exact(March(Dragon(benches=8)), np.arange(10.0)), page)
    run_script("screenshot.py", page, "#t=4", picture)
    with Image.open(picture) as shown:
        assert shown.size == (1200, 750)
        assert len(shown.convert("RGB").getcolors(maxcolors=2**24)) > 10


def test_texts_name_only_benchmarks_that_exist():
    named = {match for each in DOCUMENTS for match in re.findall(r"tests/bench/(\w+\.py)([a-z -]*)", each.text)}
    assert len(named) > 5
    for script, names in named:
        assert NAMES[script].keys() >= {*names.split()}
