"""Sweeps whose workers, scheduler or program are killed, or that are interrupted.

A message is one line, no process is left, and the sweep goes on to the same table without a finished point again.
"""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil
import pytest
from conftest import assert_says
from sweep_functions import FLAGS

# s: no program of this file works for longer, whatever happens to it.
LIMIT = 60
PYTHON = sys.executable
# A sweep of twelve points of which four end, and its table.
SWEEP = [PYTHON, "-m", "pymunk_dragon", "sweep", *FLAGS, "--quantity", "sweep_functions:logged", "-o", "map.csv"]
TWELVE = ["--axis", "x=0:11:1", "--workers", "2"]
TABLE = "".join(["x,square,side,error\n", *(f"{x},{x * x},{'left' if x < 3 else 'right'},\n" for x in range(12))])
KEPT = " of 12 points are in map.csv.partial"


@contextmanager
def program(folder, *arguments, command=SWEEP):
    """The program that sweeps in a folder, in a process group of its own as a shell in a terminal has it."""
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", ".")])
    environment = os.environ | {"PYTHONPATH": path, "SWEEP_LOG": str(folder / "points.log")}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    running = subprocess.Popen([*command, *arguments], cwd=folder, env=environment, process_group=0, **pipes)
    try:
        yield running
    finally:
        with suppress(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
        running.communicate()


def finished(folder):
    partial = folder / "map.csv.partial"
    return partial.read_bytes().count(b"\n") - 1 if partial.exists() else 0


def begun(folder):
    log = folder / "points.log"
    return sorted(map(int, log.read_text().split())) if log.exists() else []


def wait_until(running, state):
    """Wait until `state()` is true, and return the worker processes; the program must not end before."""
    end = time.monotonic() + LIMIT
    while not state():
        assert time.monotonic() < end
        with pytest.raises(subprocess.TimeoutExpired):
            running.wait(0.02)
    return workers(running)


def workers(running):
    found = []
    for child in psutil.Process(running.pid).children(recursive=True):
        with suppress(psutil.Error):  # It may have ended.
            found += [child] * ("spawn_main" in " ".join(child.cmdline()))
    return found


def assert_ended(running, code, *words, processes=()):
    """The program ends with a code and one line, and its processes with it."""
    out, err = running.communicate(timeout=LIMIT)
    assert (running.returncode, out, err.count("\n")) == (code, "", 1), err
    assert_says(Exception(err.rstrip("\n")), "pymunk-dragon: ", *words)
    assert psutil.wait_procs(processes, timeout=LIMIT)[1] == []


def assert_resumed(folder, *arguments):
    before = finished(folder)
    (folder / "points.log").write_text("")
    (folder / "points.log.go").touch()
    with program(folder, *TWELVE, "--resume", *arguments) as running:
        out, err = running.communicate(timeout=LIMIT)
    assert (running.returncode, err, f"{before} resumed" in out) == (0, "", True)
    assert len(set(begun(folder))) == len(begun(folder)) == 12 - before
    assert (folder / "map.csv").read_text() == TABLE
    assert sorted(os.listdir(folder)) == ["map.csv", "points.log", "points.log.go"]


# A terminal sends Ctrl-C, and SIGHUP when it is closed, to all processes.
@pytest.mark.parametrize(
    ("number", "send"),
    [
        (signal.SIGINT, os.killpg),
        pytest.param(signal.SIGTERM, os.kill, marks=pytest.mark.thorough),
        pytest.param(signal.SIGHUP, os.killpg, marks=pytest.mark.thorough),
    ],
)
def test_signal_keeps_the_partial_table_and_waits_for_no_point(tmp_path, number, send):
    with program(tmp_path, *TWELVE, command=["env", "--default-signal=HUP", *SWEEP]) as running:
        processes = wait_until(running, lambda: finished(tmp_path) == 4 and len(begun(tmp_path)) == 6)
        assert len(processes) == 2
        send(running.pid, number)
        assert_ended(running, 128 + number, KEPT, processes=processes)
    assert_resumed(tmp_path, "--workers", "1")


def test_two_points_end_at_ctrl_c_while_their_workers_start_or_evaluate_them(tmp_path):
    for state in (workers, lambda running: begun(tmp_path) == [8, 9]):
        (tmp_path / "points.log").write_text("")
        with program(tmp_path, "--axis", "x=8,9", "--workers", "2") as running:
            processes = wait_until(running, lambda state=state, running=running: state(running))
            os.killpg(running.pid, signal.SIGINT)
            assert_ended(running, 130, "interrupted", processes=processes)
        assert os.listdir(tmp_path) == ["points.log"]


@pytest.mark.parametrize("killed", ["worker", pytest.param("program", marks=pytest.mark.thorough)])
def test_killed_worker_ends_the_sweep_and_killed_program_its_workers(tmp_path, killed):
    with program(tmp_path, *TWELVE) as running:
        processes = wait_until(running, lambda: finished(tmp_path) == 4)
        if killed == "worker":
            processes[0].kill()
            assert_ended(running, 1, KEPT, processes=processes)
        else:
            running.kill()
            assert psutil.wait_procs(processes, timeout=LIMIT)[1] == []
    assert_resumed(tmp_path)


def test_python_that_cannot_be_executed_is_an_error(tmp_path):
    code = "import multiprocessing, sys; from pymunk_dragon.cli import main; multiprocessing.set_executable('/none');"
    with program(tmp_path, *TWELVE, command=[PYTHON, "-c", f"{code} main(sys.argv[1:])", *SWEEP[3:]]) as running:
        assert_ended(running, 1, "/none")
    assert os.listdir(tmp_path) == []


CLUSTER = """
import distributed, threading
with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
    print(cluster.scheduler_address, flush=True)
    threading.Event().wait()
"""


@pytest.mark.thorough
def test_sweep_on_dask_is_the_same_and_ends_when_its_scheduler_does(tmp_path):
    with program(tmp_path, command=[PYTHON, "-c", CLUSTER]) as cluster:
        dask = ["--scheduler", cluster.stdout.readline().strip()]
        with program(tmp_path, *TWELVE, *dask) as running:
            wait_until(running, lambda: finished(tmp_path) == 4)
            os.killpg(running.pid, signal.SIGINT)
            assert_ended(running, 130, KEPT)
        assert_resumed(tmp_path, *dask)
        (tmp_path / "points.log.go").unlink()
        with program(tmp_path, *TWELVE, *dask) as running:
            wait_until(running, lambda: finished(tmp_path) == 4)
            os.killpg(cluster.pid, signal.SIGKILL)
            assert_ended(running, 1, KEPT)
    assert_resumed(tmp_path)
