"""Sweeps whose workers, scheduler or program are killed, that are interrupted, or whose disk is full.

Whatever happens, the table is the same in the end, no finished point is computed twice, and no process is left.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil
import pytest
import sweep_functions as functions
from conftest import assert_says, not_under_coverage
from sweep_functions import FLAGS, SMALL

from pymunk_dragon import sweep
from pymunk_dragon.sweeps.computation import LOST

# s: no program of this file works for longer, whatever happens to it.
LIMIT = 60
POINTS = 24
# A sweep of many points that take a while, and its table.
QUANTITY = ["--quantity", "sweep_functions:logged", "--axis", f"x=0:{POINTS - 1}:1", "--axis", "pause=0.2"]
SWEEP = [sys.executable, "-m", "pymunk_dragon", "sweep", *FLAGS, *QUANTITY, "-o", "map.csv"]
ROWS = [f"{x}.0,0.2,{x * x}.0,{'left' if x < 4 else 'right'},\n" for x in range(POINTS)]
TABLE = "".join(["x,pause,square,side,error\n", *ROWS])
DASK = ["--workers", "2", "--scheduler", "local"]
# A sweep in which one point is special.
X = {"x": [float(x) for x in range(8)]}


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def environment(folder):
    return os.environ | {
        "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", ".")]),
        "SWEEP_LOG": str(folder / "evaluated.log"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }


class Program:
    """The program that sweeps in a folder."""

    def __init__(self, folder, *arguments, command=SWEEP):
        self.folder = folder
        self.process = subprocess.Popen(
            [*command, *map(str, arguments)],
            cwd=folder,
            env=environment(folder),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # As a shell in a terminal does.
            process_group=0,
        )

    def finished(self):
        """Numbers of the points in the journal."""
        with suppress(FileNotFoundError):
            lines = (self.folder / "map.csv.journal").read_bytes().split(b"\n")[1:-1]
            return [json.loads(line)[0] for line in lines]
        return []

    def wait_for(self, points):
        """Wait until points are in the journal; the program must not end before."""
        end = time.monotonic() + LIMIT
        while len(self.finished()) < points:
            assert time.monotonic() < end
            with pytest.raises(subprocess.TimeoutExpired):
                self.process.wait(0.02)

    def workers(self):
        """The worker processes."""
        found = []
        for child in psutil.Process(self.process.pid).children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                found += [child] * any("spawn_main" in part for part in child.cmdline())
        return found

    def kill(self):
        self.process.kill()
        self.process.wait()
        return self.finished()

    def end(self):
        """Exit code, stdout and stderr, after all of it."""
        out, err = self.process.communicate(timeout=LIMIT)
        return self.process.returncode, out, err


@contextmanager
def program(*arguments, **options):
    running = Program(*arguments, **options)
    try:
        yield running
    finally:
        with suppress(ProcessLookupError):
            os.killpg(running.process.pid, signal.SIGKILL)
        running.process.communicate()


def assert_one_line(err, *words):
    assert err.endswith("\n")
    assert_says(Exception(err[:-1]), "pymunk-dragon: ", *words)


def assert_resumed(folder, finished, *arguments):
    """A sweep goes on, evaluates the points that are not `finished` once, and ends with the same table as ever."""
    log, hurry = folder / "evaluated.log", folder / "evaluated.log.hurry"
    log.write_text("")
    hurry.touch()
    with program(folder, "--resume", "--json", *arguments) as running:
        code, out, err = running.end()
    hurry.unlink()
    assert (code, err) == (0, "")
    told = json.loads(out)
    assert (told["points"], told["failed"], told["resumed"]) == (POINTS, 0, len(finished))
    assert sorted(map(float, log.read_text().split())) == sorted(set(range(POINTS)) - set(finished))
    assert (folder / "map.csv").read_text() == TABLE
    assert names(folder) == ["evaluated.log", "map.csv"]


def assert_gone(processes):
    _, alive = psutil.wait_procs(processes, timeout=LIMIT)
    assert alive == []


@pytest.mark.parametrize(
    ("number", "group", "arguments"),
    # A terminal sends Ctrl-C to all processes.
    [
        (signal.SIGINT, True, ["--workers", "2"]),
        pytest.param(signal.SIGTERM, False, ["--workers", "2"], marks=pytest.mark.thorough),
        pytest.param(signal.SIGINT, True, DASK, marks=pytest.mark.thorough),
    ],
)
def test_signal_is_one_line_keeps_the_journal_and_leaves_no_process(tmp_path, number, group, arguments):
    with program(tmp_path, *arguments) as running:
        running.wait_for(4)
        processes = running.workers()
        assert len(processes) == 2
        (os.killpg if group else os.kill)(running.process.pid, number)
        code, out, err = running.end()
        finished = running.finished()
    assert (code, out) == (128 + number, "")
    assert_one_line(err, f"{len(finished)} of {POINTS} points are in map.csv.journal")
    assert_gone(processes)
    assert names(tmp_path) == ["evaluated.log", "map.csv.journal"]
    assert_resumed(tmp_path, finished, "--workers", "1")


@pytest.mark.thorough
@pytest.mark.parametrize("arguments", [["--workers", "2"], DASK], ids=["processes", "Dask"])
def test_program_or_worker_that_is_killed_leaves_no_process_and_changes_nothing(tmp_path, arguments):
    with program(tmp_path, *arguments) as running:
        running.wait_for(2)
        running.workers()[0].kill()
        running.wait_for(8)
        processes = running.workers()
        finished = running.kill()
        assert_gone(processes)
    assert 8 <= len(finished) < POINTS
    assert_resumed(tmp_path, finished, *arguments)


@pytest.mark.thorough
@pytest.mark.parametrize("options", [{"workers": 2}, {"workers": 2, "scheduler": "local"}], ids=["processes", "Dask"])
def test_point_that_ends_its_worker_is_a_row_and_harms_no_other(options):
    found = sweep(SMALL, X, functions.ending, batch_size=2, **options)
    assert {row[0]: row[-1] for row in found.rows() if row[-1]} == {3.0: LOST}


def test_script_whose_workers_cannot_start_is_an_error_and_no_table(tmp_path):
    (tmp_path / "script.py").write_text(
        "from pymunk_dragon import sweep\nsweep({'benches': 4}, {'width': [0.2, 0.3]}, out='map.csv', workers=1)\n"
    )
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 1
    assert 'if __name__ == "__main__":' in done.stderr.splitlines()[-1]
    assert names(tmp_path) == ["script.py"]


@pytest.mark.thorough
def test_address_without_a_scheduler_is_bad_input(call, monkeypatch):
    monkeypatch.setattr("pymunk_dragon.sweeps.workers.CONNECT_TIMEOUT", 0.3)
    code, out, err = call("sweep", *FLAGS, "--axis", "pitch=0.5", "--scheduler", "tcp://127.0.0.1:1")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "--scheduler is 'tcp://127.0.0.1:1'" in err


# Writing beyond a size fails like on a full disk.
LIMITED = """
import os, resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (1100, resource.RLIM_INFINITY))
os.execv(sys.executable, [sys.executable, *sys.argv[1:]])
"""


@not_under_coverage
@pytest.mark.thorough
def test_journal_on_a_full_disk_is_one_line_and_whole(tmp_path):
    with program(tmp_path, "--workers", "2", command=[sys.executable, "-c", LIMITED, *SWEEP[1:]]) as running:
        code, out, err = running.end()
        finished = running.finished()
    journal = (tmp_path / "map.csv.journal").read_bytes()
    assert (code, out) == (1, "")
    assert journal.endswith(b"\n")
    assert len(journal) <= 1100
    assert finished
    assert_one_line(err, "cannot write map.csv.journal", f"{len(finished)} of {POINTS} points")
    assert_resumed(tmp_path, finished, "--workers", "2")
