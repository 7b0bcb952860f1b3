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


# Benchmarks that run in one process: a start takes a second.
PARTS = 3


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("script", "part"),
    [("bench.py", slice(part, None, PARTS)) for part in range(PARTS)]
    + [("order.py", slice(None)), ("engines.py", slice(None))]
    + [
        pytest.param("bench_live.py", slice(number, number + 1), marks=needs_browser)
        for number in range(len(bench_live.BENCHMARKS))
    ],
)
def test_benchmarks_run_at_a_small_size(script, part):
    names = [*NAMES[script]][part]
    if "time-of-impact" in names and find_spec("Box2D") is None:
        names.remove("time-of-impact")  # Box2D is not for this Python.
    if names in (["pyodide"], ["page"]) and (reason := in_node.missing()):
        pytest.skip(reason)
    command = [sys.executable, str(ROOT / "tests" / "bench" / script), *names, "--small"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    for name in names:
        _, printed = done.stdout.split(f"\n{name}: ", 1)
        _, figures = printed.split("\n", 1)
        assert re.search(r"\d", figures.split("\n\n", 1)[0]), name


def test_texts_name_only_benchmarks_that_exist():
    named = {
        match
        for each in DOCUMENTS
        for match in re.findall(r"tests/bench/(\w+\.py)([a-z -]*)", each.text)
    }
    assert len(named) > 5
    for script, names in named:
        assert NAMES[script].keys() >= {*names.split()}
