"""Every benchmark runs; the thorough tests run each of them at a small size."""

import re
import subprocess
import sys
from importlib.util import find_spec

import bench
import bench_live
import engines
import in_node
import order
import pytest
from browser import needs_browser
from documents import DOCUMENTS, ROOT

NAMES = {
    "bench.py": bench.BENCHMARKS,
    "order.py": order.BENCHMARKS,
    "bench_live.py": bench_live.BENCHMARKS,
    "engines.py": engines.BENCHMARKS,
}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("script", "name"),
    [(script, name) for script in ("bench.py", "order.py", "engines.py") for name in NAMES[script]]
    + [pytest.param("bench_live.py", name, marks=needs_browser) for name in bench_live.BENCHMARKS],
)
def test_benchmark_runs_at_a_small_size(script, name):
    if name == "time-of-impact" and find_spec("Box2D") is None:
        pytest.skip("Box2D is not for this Python")
    if name == "pyodide" and (reason := in_node.missing()):
        pytest.skip(reason)
    command = [sys.executable, str(ROOT / "tests" / "bench" / script), name, "--small"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"\d", done.stdout.split("\n", 2)[2])


def test_texts_name_only_benchmarks_that_exist():
    named = {
        match
        for each in DOCUMENTS
        for match in re.findall(r"tests/bench/(\w+\.py)([a-z -]*)", each.text)
    }
    assert len(named) > 5
    for script, names in named:
        assert NAMES[script].keys() >= {*names.split()}
