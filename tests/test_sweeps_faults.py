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
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil
import pytest
import sweep_functions as functions
from conftest import assert_says, not_under_coverage
from sweep_functions import FLAGS, SMALL

from pymunk_dragon import sweep
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.sweeps import computation, workers

# s: no program of this file works for longer, whatever happens to it.
LIMIT = 60
POINTS = 24
# A sweep of many points that take a while, and its table.
QUANTITY = ["--quantity", "sweep_functions:logged", "--axis", f"x=0:{POINTS - 1}:1", "--axis", "pause=0.03"]
SWEEP = [sys.executable, "-m", "pymunk_dragon", "sweep", *FLAGS, *QUANTITY, "-o", "map.csv"]
ROWS = [f"{x}.0,0.03,{x * x}.0,{'left' if x < 4 else 'right'},\n" for x in range(POINTS)]
TABLE = "".join(["x,pause,square,side,error\n", *ROWS])
# A sweep in which one point is special.
X = {"x": [float(x) for x in range(8)]}


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def wait_for(condition, limit=LIMIT):
    """What `condition()` returns, as soon as it is true."""
    end = time.monotonic() + limit
    while not (found := condition()):
        assert time.monotonic() < end, f"{condition} is not true after {limit} s"
        time.sleep(0.02)
    return found


def environment(folder):
    return os.environ | {
        "PYTHONPATH": str(Path(__file__).parent),
        "SWEEP_LOG": str(folder / "evaluated.log"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }


class Program:
    """The program that sweeps in a folder."""

    def __init__(self, folder, *arguments):
        self.folder = folder
        self.process = subprocess.Popen(
            [*SWEEP, *map(str, arguments)],
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
        wait_for(lambda: len(self.finished()) >= points or self.process.poll() is not None)
        assert self.process.poll() is None, self.process.stderr.read()

    def workers(self):
        """The worker processes."""
        found = psutil.Process(self.process.pid).children(recursive=True)
        return [child for child in found if any("spawn_main" in part for part in child.cmdline())]

    def end(self):
        """Exit code, stdout and stderr, after all of it."""
        out, err = self.process.communicate(timeout=LIMIT)
        return self.process.returncode, out, err


@contextmanager
def program(folder, *arguments):
    running = Program(folder, *arguments)
    try:
        yield running
    finally:
        with suppress(ProcessLookupError):
            os.killpg(running.process.pid, signal.SIGKILL)
        running.process.communicate()


def ended(folder, *arguments):
    with program(folder, *arguments) as running:
        return running.end()


def assert_one_line(err, *words):
    assert err.endswith("\n")
    assert_says(Exception(err[:-1]), "pymunk-dragon: ", *words)


def assert_resumed(folder, finished, *arguments):
    """A sweep goes on, evaluates the points that are not `finished` once, and ends with the same table as ever."""
    log = folder / "evaluated.log"
    log.write_text("")
    code, out, err = ended(folder, "--resume", "--json", *arguments)
    assert (code, err) == (0, "")
    told = json.loads(out)
    assert (told["points"], told["failed"], told["resumed"]) == (POINTS, 0, len(finished))
    assert sorted(map(float, log.read_text().split())) == sorted(set(range(POINTS)) - set(finished))
    assert (folder / "map.csv").read_text() == TABLE
    assert names(folder) == ["evaluated.log", "map.csv"]


def new_workers(before):
    """Processes of this one that were not there before, but for one that Python keeps."""
    found = set(psutil.Process().children(recursive=True)) - set(before)
    return [process for process in found if "resource_tracker" not in " ".join(process.cmdline())]


def assert_gone(processes):
    _, alive = psutil.wait_procs(processes, timeout=20)
    assert alive == []


# Signals, and a program that is killed


@pytest.mark.parametrize(
    ("number", "group"),
    [
        # A terminal sends Ctrl-C to all processes.
        (signal.SIGINT, True),
        pytest.param(signal.SIGTERM, False, marks=pytest.mark.thorough),
        pytest.param(signal.SIGHUP, False, marks=pytest.mark.thorough),
    ],
)
def test_signal_is_one_line_keeps_the_journal_and_leaves_no_process(tmp_path, number, group):
    with program(tmp_path, "--workers", "2") as running:
        running.wait_for(4)
        processes = running.workers()
        assert len(processes) == 2
        (os.killpg if group else os.kill)(running.process.pid, number)
        code, out, err = running.end()
        finished = running.finished()
    assert (code, out) == (128 + number, "")
    assert_one_line(err, f"interrupted: {len(finished)} of {POINTS} points are in map.csv.journal")
    assert_gone(processes)
    assert names(tmp_path) == ["evaluated.log", "map.csv.journal"]
    if group:
        assert_resumed(tmp_path, finished, "--workers", "1")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("delay", "arguments"),
    [(0.8, ["--workers", "2"]), (1.3, ["--scheduler", "local"])],
    ids=str,
)
def test_ctrl_c_while_workers_start_is_one_line(tmp_path, delay, arguments):
    with program(tmp_path, *arguments) as running:
        with suppress(subprocess.TimeoutExpired):
            running.process.wait(delay)
        processes = psutil.Process(running.process.pid).children(recursive=True)
        os.killpg(running.process.pid, signal.SIGINT)
        code, out, err = running.end()
    # Before the program's first line Python answers.
    if code != -signal.SIGINT:
        assert (code, out) == (130, "")
        assert_one_line(err, "interrupted")
    assert_gone(processes)


@pytest.mark.thorough
def test_no_worker_survives_a_program_that_was_killed(tmp_path):
    with program(tmp_path, "--workers", "2") as running:
        running.wait_for(4)
        processes = running.workers()
        assert len(processes) == 2
        running.process.kill()
        running.process.wait()
        assert_gone(processes)
        finished = running.finished()
    assert 4 <= len(finished) < POINTS
    assert_resumed(tmp_path, finished, "--workers", "2")


@pytest.mark.thorough
def test_no_worker_of_a_local_cluster_survives_either(tmp_path):
    with program(tmp_path, "--workers", "2", "--scheduler", "local") as running:
        running.wait_for(4)
        processes = running.workers()
        assert len(processes) == 2
        running.process.kill()
        running.process.wait()
        assert_gone(processes)
        finished = running.finished()
    assert 4 <= len(finished) < POINTS


@pytest.mark.thorough
def test_ctrl_c_of_a_sweep_with_a_local_cluster_is_one_line(tmp_path):
    with program(tmp_path, "--workers", "2", "--scheduler", "local") as running:
        running.wait_for(4)
        processes = running.workers()
        os.killpg(running.process.pid, signal.SIGINT)
        code, out, err = running.end()
        finished = running.finished()
    assert (code, out) == (130, "")
    assert_one_line(err, f"interrupted: {len(finished)} of {POINTS} points")
    assert_gone(processes)


@pytest.mark.thorough
def test_interrupted_sweep_in_python_leaves_no_process():
    before = psutil.Process().children(recursive=True)

    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(SMALL, X, functions.spinning, workers=2, progress=interrupt)
    assert_gone(new_workers(before))


# Processes


@pytest.mark.thorough
def test_worker_that_is_killed_changes_nothing(tmp_path):
    with program(tmp_path, "--workers", "2") as running:
        running.wait_for(4)
        running.workers()[0].kill()
        code, _, err = running.end()
    assert (code, err) == (0, "")
    assert (tmp_path / "map.csv").read_text() == TABLE


@pytest.mark.thorough
def test_point_that_ends_its_worker_is_a_row_and_harms_no_other():
    found = sweep(SMALL, X, functions.ending, workers=2, batch_size=2)
    errors = {row[0]: row[-1] for row in found.rows() if row[-1]}
    assert errors == {3.0: "its worker was ended whenever it was evaluated"}


@pytest.mark.thorough
@pytest.mark.parametrize("quantity", [functions.sleeping, functions.spinning, functions.ignoring])
def test_point_that_exceeds_its_time_in_a_process_fails_alone(quantity):
    found = sweep(SMALL, X, quantity, workers=2, timeout=1.5)
    errors = {row[0]: row[-1] for row in found.rows() if row[-1]}
    assert errors == {3.0: "takes longer than the time limit of 1.5 s"}


@pytest.mark.thorough
def test_process_that_ignores_all_exceptions_is_killed(monkeypatch):
    monkeypatch.setattr(computation, "GRACE", 0.3)
    monkeypatch.setattr(computation, "POLL", 0.1)
    before = psutil.Process().children(recursive=True)
    found = sweep(SMALL, X, functions.stubborn, workers=2, timeout=1.5)
    errors = {row[0]: row[-1] for row in found.rows() if row[-1]}
    assert errors == {3.0: "takes longer than the time limit of 1.5 s"}
    assert_gone(new_workers(before))


def test_thread_that_sleeps_fails_its_point_when_it_wakes():
    with ThreadPoolExecutor(2) as threads:
        found = sweep({**SMALL, "s": 0.5}, X, functions.sleeping, threads, timeout=0.1)
    assert [row[0] for row in found.rows() if row[-1]] == [3.0]


def test_thread_that_does_not_return_ends_the_sweep(tmp_path, monkeypatch):
    monkeypatch.setattr(computation, "GRACE", 0.1)
    monkeypatch.setattr(computation, "POLL", 0.1)
    path = tmp_path / "map.csv"
    with ThreadPoolExecutor(2) as threads, pytest.raises(DragonError, match=r"of 8 points are in .*map.csv.journal"):
        sweep({**SMALL, "s": 1.0}, X, functions.sleeping, threads, path, timeout=0.1)
    assert names(tmp_path) == ["map.csv.journal"]


SCRIPT = """
from pymunk_dragon import sweep
sweep({"benches": 4, "turns": 5}, {"width": [0.2, 0.3]}, out="map.csv", workers=1)
"""


def test_script_whose_workers_cannot_start_is_an_error_and_no_table(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        "pymunk_dragon.errors.DragonError: worker processes end as soon as they are started; "
        'a script calls sweep under `if __name__ == "__main__":`'
    )
    assert names(tmp_path) == ["script.py"]


# Dask


class Cluster:
    """A Dask scheduler and workers, each a process of its own."""

    def __init__(self, folder, count=2, *options):
        self.folder = folder
        self.file = folder / "scheduler.json"
        self._options = options
        command = ["scheduler", "--port", "0", "--scheduler-file", self.file]
        self.scheduler = self._start("scheduler", command)
        self.nannies: list[subprocess.Popen] = []
        wait_for(self.file.exists)
        self.address = wait_for(self._address)
        self.add(count)

    def _address(self):
        with suppress(ValueError):
            return json.loads(self.file.read_text())["address"]
        return None

    def _start(self, name, command):
        with (self.folder / f"{name}.log").open("w") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "dask", *map(str, command), "--host", "127.0.0.1", "--no-dashboard"],
                cwd=self.folder,
                env=environment(self.folder),
                stdout=log,
                stderr=log,
                start_new_session=True,
            )

    def add(self, count):
        """Start workers, and wait for them."""
        for _ in range(count):
            name = f"worker-{len(self.nannies)}"
            command = ["worker", "--scheduler-file", self.file, "--nthreads", "1", "--local-directory", name]
            self.nannies.append(self._start(name, [*command, *self._options]))
        if self.nannies:
            self.pids()

    def pids(self):
        """Numbers of the processes that evaluate points, when all are there."""
        from distributed import Client

        count = sum(nanny.poll() is None for nanny in self.nannies)
        with Client(self.address, set_as_default=False, timeout=20) as client:
            # A worker that was lost is started again by its nanny.
            client.wait_for_workers(count, timeout=LIMIT)
            return list(client.run(os.getpid).values())

    def close(self):
        for process in (self.scheduler, *self.nannies):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@contextmanager
def cluster_in(folder, *arguments):
    folder.mkdir(exist_ok=True)
    started = Cluster(folder, *arguments)
    try:
        yield started
    finally:
        started.close()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with cluster_in(tmp_path_factory.mktemp("cluster")) as started:
        yield started


@pytest.mark.thorough
def test_dask_gives_the_same_table(cluster, tmp_path):
    code, out, err = ended(tmp_path, "--scheduler", cluster.address)
    assert (code, err) == (0, "")
    assert out.startswith(f"{POINTS} points of sweep_functions:logged over x and pause")
    assert (tmp_path / "map.csv").read_text() == TABLE


@pytest.mark.thorough
@pytest.mark.parametrize("what", ["worker", "nanny"])
def test_worker_of_dask_that_is_killed_changes_nothing(cluster, tmp_path, what):
    pids = cluster.pids()
    with program(tmp_path, "--scheduler", cluster.address) as running:
        running.wait_for(4)
        if what == "worker":
            os.kill(pids[0], signal.SIGKILL)
        else:
            os.killpg(cluster.nannies[0].pid, signal.SIGKILL)
        code, _, err = running.end()
    assert (code, err) == (0, "")
    assert (tmp_path / "map.csv").read_text() == TABLE
    if what == "nanny":
        cluster.nannies[0].wait()
        cluster.add(1)


@pytest.mark.thorough
def test_scheduler_that_is_killed_is_one_line_and_the_sweep_goes_on_elsewhere(tmp_path):
    here = tmp_path / "here"
    here.mkdir()
    with cluster_in(tmp_path / "cluster") as started, program(here, "--scheduler", started.address) as running:
        running.wait_for(8)
        started.scheduler.kill()
        code, out, err = running.end()
        finished = running.finished()
    assert (code, out) == (1, "")
    assert_one_line(err, f"{len(finished)} of {POINTS} points are in map.csv.journal")
    assert 8 <= len(finished) < POINTS
    assert_resumed(here, finished, "--workers", "2")


@pytest.mark.thorough
def test_sweep_of_processes_is_resumed_on_dask(cluster, tmp_path):
    with program(tmp_path, "--workers", "1") as running:
        running.wait_for(4)
        running.process.kill()
        running.process.wait()
        finished = running.finished()
    log = cluster.folder / "evaluated.log"
    log.write_text("")
    assert ended(tmp_path, "--resume", "--scheduler", cluster.address)[0] == 0
    assert sorted(map(float, log.read_text().split())) == sorted(set(range(POINTS)) - set(finished))
    assert (tmp_path / "map.csv").read_text() == TABLE


@pytest.mark.thorough
def test_point_that_ends_its_worker_of_dask_is_a_row_and_harms_no_other(cluster):
    found = sweep(SMALL, X, functions.ending, scheduler=cluster.address, batch_size=1)
    errors = {row[0]: row[-1] for row in found.rows() if row[-1]}
    assert errors == {3.0: "its worker was ended whenever it was evaluated"}


@pytest.mark.thorough
@pytest.mark.parametrize("quantity", [functions.sleeping, functions.spinning])
def test_point_that_exceeds_its_time_on_dask_fails_alone(cluster, monkeypatch, quantity):
    monkeypatch.setattr(computation, "GRACE", 2.0)
    found = sweep(SMALL, X, quantity, scheduler=cluster.address, timeout=1.5)
    errors = {row[0]: row[-1] for row in found.rows() if row[-1]}
    assert errors == {3.0: "takes longer than the time limit of 1.5 s"}


@pytest.mark.thorough
def test_scheduler_without_workers_fails_no_point(tmp_path, monkeypatch):
    monkeypatch.setattr(computation, "GRACE", 5.0)
    monkeypatch.setattr(computation, "POLL", 0.2)
    monkeypatch.setattr(workers, "COUNT_INTERVAL", 0.2)
    with cluster_in(tmp_path / "cluster", 0) as empty:
        with monkeypatch.context() as hurried:
            hurried.setattr(workers, "UNMANNED_AFTER", 1.5)
            with pytest.raises(DragonError, match="has no workers"):
                sweep(SMALL, X, functions.total, scheduler=empty.address, timeout=0.5)
        with ThreadPoolExecutor(1) as threads:
            found = threads.submit(sweep, SMALL, X, functions.total, scheduler=empty.address, timeout=0.5)
            # Longer than all points may take.
            time.sleep(10)
            assert not found.done()
            empty.add(1)
            assert found.result(LIMIT).failed == 0


@pytest.mark.thorough
def test_worker_without_a_nanny_cannot_be_restarted(tmp_path, monkeypatch):
    monkeypatch.setattr(computation, "GRACE", 0.2)
    with (
        cluster_in(tmp_path / "cluster", 1, "--no-nanny") as started,
        pytest.raises(DragonError, match=r"cannot be restarted: .*nanny"),
    ):
        sweep(SMALL, X, functions.sleeping, scheduler=started.address, timeout=0.2)


# Full disks


def limited(size):
    """The program with a limit of a file's size, bytes; writing beyond fails like on a full disk."""
    lines = (
        "import os, resource, sys",
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, resource.RLIM_INFINITY))",
        "os.execv(sys.executable, [sys.executable, *sys.argv[1:]])",
    )
    return [sys.executable, "-c", "\n".join(lines), *SWEEP[1:]]


def run_limited(folder, size, *arguments):
    done = subprocess.run(
        [*limited(size), *arguments],
        cwd=folder,
        env=environment(folder),
        capture_output=True,
        text=True,
        timeout=LIMIT,
    )
    return done.returncode, done.stdout, done.stderr


@not_under_coverage
@pytest.mark.thorough
def test_journal_on_a_full_disk_is_one_line_and_whole(tmp_path):
    size = 1100
    code, out, err = run_limited(tmp_path, size, "--workers", "2")
    journal = (tmp_path / "map.csv.journal").read_bytes()
    assert (code, out) == (1, "")
    assert journal.endswith(b"\n")
    assert len(journal) <= size
    finished = [json.loads(line)[0] for line in journal.splitlines()[1:]]
    assert finished
    assert_one_line(err, "cannot write map.csv.journal: File too large", f"{len(finished)} of {POINTS} points")
    assert names(tmp_path) == ["evaluated.log", "map.csv.journal"]
    assert_resumed(tmp_path, finished, "--workers", "2")


@not_under_coverage
@pytest.mark.thorough
def test_disk_that_has_no_space_for_the_first_line_is_left_empty(tmp_path):
    code, out, err = run_limited(tmp_path, 100)
    assert (code, out) == (1, "")
    assert_one_line(err, "cannot write map.csv.journal: File too large")
    assert names(tmp_path) == []


@pytest.mark.thorough
def test_table_on_a_full_disk_is_one_line_and_needs_no_point_again(tmp_path):
    path = tmp_path / "map.csv"
    path.symlink_to("/dev/full")
    code, out, err = ended(tmp_path, "--workers", "2")
    assert (code, out) == (1, "")
    assert_one_line(err, "cannot write", "No space left", f"{POINTS} of {POINTS} points are in map.csv.journal")
    path.unlink()
    assert_resumed(tmp_path, range(POINTS), "--workers", "1")


def test_folder_that_is_gone_at_the_end_keeps_the_points(tmp_path):
    folder, other = tmp_path / "folder", tmp_path / "other"
    folder.mkdir()

    def move(done, total):
        if done == total:
            folder.rename(other)

    with pytest.raises(ParameterError, match="No such file"):
        sweep(SMALL, X, functions.total, functions.Immediate(), folder / "map.csv", progress=move)
    other.rename(folder)
    assert names(folder) == ["map.csv.journal"]
    assert sweep(SMALL, X, functions.total, functions.Immediate(0), folder / "map.csv", resume=True).resumed == len(
        X["x"]
    )


@pytest.mark.skipif(sys.platform != "linux", reason="has no folder that nobody can write to")
def test_folder_that_cannot_be_written_is_bad_input(tmp_path):
    code, out, err = ended(tmp_path, "-o", "/sys/map.csv")
    assert (code, out) == (2, "")
    assert names(tmp_path) == []
    assert_one_line(err, "-o is '/sys/map.csv'", "in a folder that can be written")


@pytest.mark.thorough
def test_program_without_stderr_still_writes_its_table(tmp_path):
    command = [sys.executable, "-m", "pymunk_dragon", "sweep", *FLAGS, "--axis", "k=1", "--workers", "1"]
    command = [*command, "--quantity", "sweep_functions:printing"]
    done = subprocess.run(
        ["bash", "-c", '"$@" 2>&-', "-", *command],
        env=environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=LIMIT,
    )
    assert (done.returncode, done.stdout) == (0, "k,v,error\n1,1,\n")
