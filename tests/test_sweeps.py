"""Sweeps: rows and their values, points, files, the partial table, what is refused, and figures."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from itertools import pairwise, product
from multiprocessing import get_context
from pathlib import Path

import matplotlib.text
import numpy as np
import psutil
import pytest
import sweep_functions as functions
from conftest import LIMIT, assert_one_line, refusal, wait_until
from sweep_functions import FLAGS, RAISED, SMALL, UNFIT, VALUES

from pymunk_dragon import Dragon, Scenario, first_contact, max_speed, min_pitch, sweep
from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError
from pymunk_dragon.sweeps.quantities import contact_time

THREAD = ThreadPoolExecutor(1)
PYTHON = sys.executable
# Programs find the quantities of the tests.
ENVIRONMENT = os.environ | {
    "PYTHONPATH": f"{Path(__file__).parent}{os.pathsep}{os.environ.get('PYTHONPATH', '.')}"
}
# A dragon whose head runs into it after 13 s: an exact search takes a tenth of a second.
SHORT = {"benches": 10, "turns": 5}
X = {"x": [-1.5, 0.0, 1.0, 2.0, 2.5, 3.0]}


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir() if path.name != "__pycache__")


def test_contact_time_is_that_of_first_contact():
    axes = {"pitch": [0.5, 0.55], "start_s": [-45.0, -40.0], "width": [0.2, 0.3]}
    found = sweep(SHORT, axes, executor=ThreadPoolExecutor(2))
    assert found.columns == (*axes, "contact_time", "bench_a", "bench_b", "status", "error")
    for pitch, start_s, width, *values, error in found.rows():
        hit = first_contact(Scenario(pitch=pitch, start_s=start_s, width=width, benches=10).march())
        time_of_contact = hit.time if hit.status == "contact" else None
        assert (values, error) == (
            [time_of_contact, *(hit.benches or (None, None)), hit.status],
            None,
        )
    assert len(set(found.column("status"))) > 1


@pytest.mark.parametrize("count", [8, pytest.param(40, marks=pytest.mark.thorough)])
def test_points_of_equal_motion_are_those_of_single_searches_to_the_bit(count):
    # A long enough dragon meets the centre, itself, or both.
    random = np.random.default_rng(count)
    dragon = {"benches": 25, "turns": 6} if count == 8 else {"benches": 223, "turns": 16}
    axes = {
        "pitch": random.uniform(0.45, 0.8, count // 4).tolist(),
        "width": random.uniform(0.2, 0.4, 4).tolist(),
    }
    for values in sweep(dragon, axes, executor=ThreadPoolExecutor(1)).rows():
        at = dict(zip(axes, values, strict=False))
        single = contact_time(Scenario(**dragon, **at).march())
        assert values[2:-1] == list(single.values()), at


@pytest.mark.thorough
def test_values_are_those_of_the_studies():
    dragon = Dragon(benches=20)
    for quantity, axes, expected in (
        (
            "min-pitch",
            {"radius": [5]},
            [(found := min_pitch(dragon, radius=5)).pitch, *found.benches],
        ),
        (
            "max-speed",
            {"limit": [1.5]},
            [(found := max_speed(dragon, limit=1.5)).speed, found.handle, found.ratio],
        ),
    ):
        [(_, *values, _)] = sweep({"benches": 20}, axes, quantity, THREAD).rows()
        assert values == expected, quantity


def test_scenario_and_quantity_are_given_in_any_form():
    expected = first_contact(Scenario(**SHORT, pitch=0.6).march()).time
    for scenario, quantity in (
        (Scenario(**SHORT, pitch=0.6), contact_time),
        (Scenario(**SHORT, pitch=0.6).march(), "contact-time"),
        (
            {"dragon": {"benches": 10}, "curve": {"kind": "spiral", "pitch": 0.6}, "turns": 5},
            contact_time,
        ),
        (
            {"benches": np.int64(10), "turns": 5, "pitch": 0.6},
            "pymunk_dragon.sweeps.quantities:contact_time",
        ),
    ):
        found = sweep(scenario, {"width": [0.3]}, quantity, THREAD)
        assert (found.column("contact_time")[0], found.reference) == (expected, {"width": 0.3}), (
            scenario
        )
    for options in (
        {"quantity": lambda march: {}},
        {"executor": 3},
        {"axes": {"x": [[0.5], [1, 2]]}},
        {"axes": {}},
    ):
        refusal(sweep, **{"axes": {"width": [0.3]}, "executor": THREAD} | options)


def test_table_is_in_the_order_of_the_grid_wherever_points_are_evaluated(tmp_path):
    axes = {"x": [3.0, 1.5, 1.5], "n": range(60), "y": [0.5, 0.25]}
    points = [(x, n, y) for x in axes["x"] for n in axes["n"] for y in axes["y"]]
    told = []
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        for options in ({"executor": ThreadPoolExecutor(2)}, {"workers": 2}, {"executor": pool}):
            options["progress"] = lambda *count: told.append(count)
            found = sweep(
                {**SMALL, "z": np.float32(0.5)},
                axes,
                functions.total,
                out=tmp_path / "map.csv",
                **options,
            )
            assert list(found.rows()) == [[x, n, y, x + y + n + 0.5, 4, None] for x, n, y in points]
            assert (tmp_path / "map.csv").read_text().splitlines()[1] == "3.0,0,0.5,4.0,4,"
            assert (told[-1], told) == ((360, 360), sorted(told))
            told.clear()
        assert pool.submit(abs, -4).result() == 4


def test_values_of_a_function_are_plain_cells_and_columns_are_those_of_all_points(tmp_path):
    sweep(SMALL, {"k": range(len(VALUES))}, functions.value, THREAD, tmp_path / "map.csv")
    plain = ["0.1", "-0.0", "-inf", 'a,"b"', r"龙 \ud800", "3", "1.5", "True", str(2**62), ""]
    with (tmp_path / "map.csv").open(newline="", encoding="utf-8") as file:
        head, first, *rows = csv.reader(file)
    assert (head, first) == (["k", "w", "v", "error"], ["0", "7", "", ""])
    assert rows == [[str(k), "", value, ""] for k, value in enumerate(plain, start=1)]
    assert np.isnan(sweep(SMALL, {"k": [1, 10]}, functions.value, THREAD).column("v")).tolist() == [
        False,
        True,
    ]


def test_refined_grid_has_the_borders_and_bands_of_a_fine_one_on_its_lines_in_few_points():
    axes = {"y": [0.0, 0.25, 1.0], "x": [0.0, 1.0, 0.5]}
    found = sweep(SMALL, axes, functions.banded, THREAD, refine=6)
    fine_y, fine_x = found.axes.values()
    assert (len(fine_y), fine_y[::64], fine_x[::64]) == (129, (0.0, 0.25, 1.0), (0.0, 0.5, 1.0))

    known = {(y, x): value for y, x, *value, _ in found.rows()}
    kinds = {}
    for at in known | dict.fromkeys([*product(axes["y"], fine_x), *product(fine_y, axes["x"])]):
        value = list(functions.banded(None, y=at[0], x=at[1]).values())
        assert known.get(at, value) == value
        kinds[at] = value[-1]
    lines = [[(y, x) for x in fine_x] for y in axes["y"]]
    lines += [[(y, x) for y in fine_y] for x in axes["x"]]
    borders = [
        pair for line in lines for pair in pairwise(line) if kinds[pair[0]] != kinds[pair[1]]
    ]
    assert len(borders) == 8
    assert {at for pair in borders for at in pair} <= set(known)
    assert found.points == len(known) < 129 * 129 / 100
    refusal(sweep, SMALL, axes, functions.banded, THREAD, refine=-1)


def test_failing_point_is_a_row_with_the_reason_and_harms_no_other(tmp_path):
    # From a process, to which an exception would come back pickled.
    count = len(RAISED) + len(UNFIT)
    found = sweep(
        SMALL, {"k": range(count)}, functions.raising, out=tmp_path / "map.csv", workers=1
    )
    raised = [
        r"ValueError: two lines\x1b[1m\ud800",
        "UnpicklableError: this and that",
        "SystemExit: 3",
    ]
    assert found.column("error").tolist()[: len(RAISED)] == raised
    assert (found.columns, found.failed) == (("k", "error"), count)
    assert len((tmp_path / "map.csv").read_text().splitlines()) == count + 1
    found = sweep(SMALL, {"pitch": [0.1, 0.5], "width": [0.2, 0.9]}, functions.total, THREAD)
    assert [row[-1] is None for row in found.rows()] == [False, False, True, False]


def test_program_writes_the_table_or_prints_it_only_whatever_functions_print(tmp_path):
    axes = [
        "--axis",
        "pitch=0.10:0.70:0.3",
        "--axis",
        "x=7",
        "--axis",
        "head-spacing=2.50",
        "--axis",
        "x=5:6:1",
    ]
    command = [
        PYTHON,
        "-m",
        "pymunk_dragon",
        "sweep",
        *FLAGS,
        *axes,
        "--workers",
        "1",
        "--quantity",
        "mine:printing",
    ]

    def program(*arguments):
        return subprocess.run(
            [*command, *arguments], capture_output=True, text=True, cwd=tmp_path, env=ENVIRONMENT
        )

    (tmp_path / "mine.py").write_text("from sweep_functions import printing")
    done = program("--json", "-o", "map.csv")
    assert done.returncode == 1
    assert {"printed by the quantity", "printed by a program"} <= set(done.stderr.splitlines())
    told = json.loads(done.stdout)
    assert told == {"points": 9, "failed": 3, "resumed": 0, "seconds": told["seconds"]}
    first, *rows = (tmp_path / "map.csv").read_text().splitlines()
    assert first == "pitch,x,head_spacing,v,sizes,error"
    # A spiral must be wider than the benches.
    assert re.fullmatch(r'0.1,7,2.5,,,"?pitch is 0.1, .*', rows[0])
    assert rows[6:] == [f"0.7,{x},2.5,{x},0.7 2.5," for x in (7, 5, 6)]
    assert names(tmp_path) == ["map.csv", "mine.py"]
    assert program().stdout == (tmp_path / "map.csv").read_text()


class Case:
    """A sweep of six points, interrupted after four; evaluations are counted."""

    def __init__(self, folder):
        self.out = folder / "map.csv"
        self.partial = folder / "map.csv.partial"
        self.log = f"{folder}.log"

    def run(self, **options):
        Path(self.log).write_text("")
        given = {
            "scenario": {**SMALL, "log": self.log},
            "axes": X,
            "quantity": functions.logged,
        } | options
        return sweep(executor=THREAD, out=self.out, **given)

    def evaluated(self):
        return list(map(float, Path(self.log).read_text().split()))

    def interrupt(self, **options):
        def stop(done, total):
            if done == 4:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt, match=r"4 of \d+ points are in .*map.csv.partial"):
            self.run(progress=stop, **options)
        assert names(self.out.parent) == ["map.csv.partial"]
        return self.partial.read_bytes()

    def assert_refused(self, match, error=FileFormatError, **options):
        before = self.partial.read_bytes()
        with pytest.raises(error, match=match):
            self.run(**options)
        assert (self.partial.read_bytes(), self.evaluated()) == (before, [])

    def assert_resumed(self, count):
        assert self.run(resume=True).resumed == count
        assert self.evaluated() == X["x"][count:]
        rows = [f"{x},{x * x},{'left' if x < 3 else 'right'}," for x in X["x"]]
        assert self.out.read_text().splitlines() == ["x,square,side,error", *rows]
        assert names(self.out.parent) == ["map.csv"]
        self.out.unlink()


@pytest.fixture
def case(tmp_path, monkeypatch):
    # One point at a time, so that a row is written before the next point begins.
    monkeypatch.setattr(sys.modules["pymunk_dragon.sweeps.sweep"], "_MAX_RUNNING", 1)
    return Case(tmp_path)


def test_interrupted_sweep_is_resumed_to_the_same_bytes_even_if_the_last_line_was_cut(case):
    content = case.interrupt()
    ends = [match.end() for match in re.finditer(rb"\n", content)]
    for end in (0, 1, ends[0] // 2, ends[0], ends[3], ends[3] + 1, ends[4] - 1, ends[4]):
        case.partial.write_bytes(content[:end])
        case.assert_resumed(max(0, sum(end >= each for each in ends) - 1))


def test_full_disk_keeps_what_was_written(case, monkeypatch):
    def full(*given):
        raise OutputError("map.csv", "No space left on device")

    for function, kept in (("os.fsync", 1), ("pymunk_dragon.sweeps.result.write_text", 6)):
        with monkeypatch.context() as other:
            other.setattr(function, full)
            with pytest.raises(OutputError, match="No space left"):
                case.run()
        case.assert_resumed(kept)


def test_damaged_partial_table_and_one_that_is_none_is_left_alone(case):
    whole = case.interrupt()
    case.assert_refused("map.csv.partial", ParameterError)
    first, _, third, *_ = whole.splitlines(keepends=True)
    lines = (
        b"garbage\n",
        b"\n",
        b"\x00" * 20 + b"\n",
        third.replace(b"0", b"1", 1),
        third[1:],
        b"\xff\n",
    )
    contents = [
        b"my notes\n",
        b"my notes",
        b"\x00\x01",
        b"{\n}\n",
        *(whole.replace(third, line) for line in lines),
    ]
    places = range(len(first), len(whole) - 1)
    for content in [
        *contents,
        *(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :] for at in places),
    ]:
        case.partial.write_bytes(content)
        case.assert_refused("partial table", resume=True)


def test_other_sweep_is_not_resumed(case, monkeypatch):
    scenario = {**SMALL, "log": case.log}
    # More numbers than a cell of a CSV file usually has digits.
    pairs = {"x": X["x"], "width": [0.2] * 40_000}
    for given, changed in (
        ({}, {"scenario": {**scenario, "width": 0.25}}),
        ({}, {"axes": {"x": [*X["x"], 9.5]}}),
        ({"axes": pairs}, {"axes": dict(reversed(pairs.items()))}),
        ({}, {"quantity": "sweep_functions:total", "scenario": SMALL}),
    ):
        case.interrupt(**given)
        case.assert_refused("of another sweep", resume=True, **given | changed)
        # Another version, and another file that defines the quantity.
        for name in ("version", "crc32"):
            with monkeypatch.context() as other:
                other.setattr(sys.modules["pymunk_dragon.sweeps.sweep"], name, lambda of: "9.9")
                case.assert_refused("of another sweep", resume=True, **given)
        case.partial.unlink()


SIDES = {"x": [0.3, 0.1, 0.2, 0.6], "y": [1.0, 3.0, 2.0]}


def artists(drawing, gid):
    return list(drawing.findobj(lambda part: part.get_gid() == gid))


def test_map_has_a_colour_for_each_point_and_lines_where_other_benches_touch():
    drawing = sweep({**SMALL, "x": 0.25}, SIDES, functions.sides, THREAD).plot()
    [mesh], [reference] = artists(drawing, "values"), artists(drawing, "reference")
    expected = [x * y if x < 0.55 else np.nan for x in SIDES["x"] for y in SIDES["y"]]
    np.testing.assert_allclose(np.ma.filled(mesh.get_array(), np.nan), expected)
    # Benches 9 at (0.2, 3), (0.3, 2) and (0.3, 3), benches 8 at smaller products, and none at x =
    # 0.6.
    lines = [np.round(line.get_xydata(), 9).tolist() for line in artists(drawing, "jumps")]
    ends = {tuple(end) for line in lines for end in line}
    # Half-way between all neighbouring points that differ; between (0.3, 1) and (0.6, 2), three
    # kinds meet.
    between = {(0.15, 3.0), (0.2, 2.5), (0.25, 2.0), (0.3, 1.5)}
    between |= {(0.45, y) for y in (1.0, 2.0, 3.0)}
    assert ends == between | {(0.4, 1.5)}
    assert [[0.25, 2.0], [0.3, 1.5]] in map(sorted, lines)
    texts = {text.get_text() for text in drawing.findobj(matplotlib.text.Text)}
    labels = {"0 and 8", "0 and 9", "clear", "gap, m", "no value", "reference: x 0.25"}
    assert labels | {"Two sides over x and y: 0.1 to 0.9 m"} <= texts
    assert reference.get_xdata() == [0.25, 0.25]


def test_line_is_broken_where_other_benches_touch():
    drawing = sweep(SMALL, {"x": SIDES["x"], "y": [2.0]}, functions.sides, THREAD).plot()
    lines = [line.get_data() for line in artists(drawing, "line")]
    assert [x.tolist() for x, _ in lines] == [[0.1, 0.2], [0.3]]
    np.testing.assert_allclose(np.concatenate([y for _, y in lines]), [0.2, 0.4, 0.6])
    [missing] = artists(drawing, "missing")
    assert missing.get_xdata() == [0.6]
    assert not artists(drawing, "reference")


def test_odd_data_are_drawn_twice_the_same(tmp_path):
    for axes, quantity in (
        ({"k": [0.5, 2]}, functions.raising),
        ({"k": [0, 1, 10, 1]}, functions.value),
        ({"k": [9, 3], "width": [0.2, 0.3]}, functions.value),
        ({"x": [1e300, 2e300]}, functions.total),
    ):
        # Warnings are errors.
        sweep(SMALL, axes, quantity, THREAD, [tmp_path / "a.png", tmp_path / "b.png"])
        assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


# Workers, schedulers and programs that are killed, or interrupted: one line, no process left, no
# finished point again

# A sweep of twelve points of which four end, and its table.
SWEEP = [
    PYTHON,
    "-m",
    "pymunk_dragon",
    "sweep",
    *FLAGS,
    "--quantity",
    "sweep_functions:logged",
    "-o",
    "map.csv",
]
TWELVE = ["--axis", "x=0:11:1", "--workers", "2"]
TABLE = "".join(
    [
        "x,square,side,error\n",
        *(f"{x},{x * x},{'left' if x < 3 else 'right'},\n" for x in range(12)),
    ]
)
KEPT = " of 12 points are in map.csv.partial"


@contextmanager
def program(folder, *arguments, command=SWEEP):
    """The program that sweeps in a folder; its process group is its own, as in a terminal."""
    environment = ENVIRONMENT | {"SWEEP_LOG": str(folder / "points.log")}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    running = subprocess.Popen(
        [*command, *arguments], cwd=folder, env=environment, process_group=0, **pipes
    )
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


def workers(running):
    found = []
    for child in psutil.Process(running.pid).children(recursive=True):
        with suppress(psutil.Error):  # It may have ended.
            found += [child] * ("spawn_main" in " ".join(child.cmdline()))
    return found


def assert_ended(running, code, *words, processes=()):
    """The program ends with a code and one line, and its processes with it."""
    out, err = running.communicate(timeout=LIMIT)
    assert (running.returncode, out) == (code, ""), err
    assert_one_line(err, *words)
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
        wait_until(running, lambda: finished(tmp_path) == 4 and len(begun(tmp_path)) == 6)
        processes = workers(running)
        assert len(processes) == 2
        send(running.pid, number)
        assert_ended(running, 128 + number, KEPT, processes=processes)
    assert_resumed(tmp_path, "--workers", "1")


INTERRUPTED_WAIT = """
import concurrent.futures, signal
import pymunk_dragon.__main__

def wait(futures, **options):
    for each in futures:
        each._condition.acquire()
    signal.raise_signal(signal.SIGINT)

concurrent.futures.wait = wait
pymunk_dragon.__main__.main()
"""


def test_two_points_end_at_ctrl_c_while_their_workers_start_or_evaluate_them(tmp_path):
    # An interruption in `concurrent.futures.wait` leaves futures locked.
    command = [PYTHON, "-c", INTERRUPTED_WAIT, *SWEEP[3:]]
    for state in (workers, lambda running: begun(tmp_path) == [8, 9]):
        (tmp_path / "points.log").write_text("")
        with program(tmp_path, "--axis", "x=8,9", "--workers", "2", command=command) as running:
            wait_until(running, lambda state=state, running=running: state(running))
            processes = workers(running)
            os.killpg(running.pid, signal.SIGINT)
            assert_ended(running, 130, "interrupted", processes=processes)
        assert os.listdir(tmp_path) == ["points.log"]


# Ctrl-C goes to a thread of a library, as of OpenBLAS, since the main thread blocks it.
INTERRUPTED_START = """
import signal, threading
from multiprocessing import util
import pymunk_dragon.__main__

started = threading.Event()
start = util.spawnv_passfds

def interrupt():
    started.wait()
    signal.pthread_kill(threading.get_ident(), signal.SIGINT)

thread = threading.Thread(target=interrupt)
thread.start()

def start_and_interrupt(path, arguments, files):
    number = start(path, arguments, files)
    if "spawn_main" in str(arguments):
        started.set()
        thread.join()
    return number

util.spawnv_passfds = start_and_interrupt
pymunk_dragon.__main__.main()
"""


def test_ctrl_c_before_a_worker_has_read_what_it_is_to_do_is_one_line(tmp_path):
    command = [PYTHON, "-c", INTERRUPTED_START, *SWEEP[3:]]
    with program(tmp_path, "--axis", "x=8,9", "--workers", "2", command=command) as running:
        assert_ended(running, 130, "interrupted")
    assert set(os.listdir(tmp_path)) <= {"points.log"}


@pytest.mark.parametrize("killed", ["worker", pytest.param("program", marks=pytest.mark.thorough)])
def test_killed_worker_ends_the_sweep_and_killed_program_its_workers(tmp_path, killed):
    with program(tmp_path, *TWELVE) as running:
        wait_until(running, lambda: finished(tmp_path) == 4)
        processes = workers(running)
        if killed == "worker":
            processes[0].kill()
            assert_ended(running, 1, KEPT, processes=processes)
        else:
            running.kill()
            assert psutil.wait_procs(processes, timeout=LIMIT)[1] == []
    assert_resumed(tmp_path)


def test_python_that_cannot_be_executed_is_an_error(tmp_path):
    code = "import multiprocessing, pymunk_dragon.__main__ as m;"
    code += " multiprocessing.set_executable('/none'); m.main()"
    with program(tmp_path, *TWELVE, command=[PYTHON, "-c", code, *SWEEP[3:]]) as running:
        assert_ended(running, 1, "/none")
    assert os.listdir(tmp_path) == []


CLUSTER = """
import distributed, threading
options = {"threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
with distributed.LocalCluster(n_workers=2, **options) as cluster:
    print(cluster.scheduler_address, flush=True)
    threading.Event().wait()
"""


@pytest.mark.thorough
def test_sweep_on_dask_is_the_same_and_ends_when_its_scheduler_does(tmp_path):
    for code, number in ((130, signal.SIGINT), (1, signal.SIGKILL)):
        # Workers that end a point of the sweep before may begin another one.
        with program(tmp_path, command=[PYTHON, "-c", CLUSTER]) as cluster:
            dask = ["--scheduler", cluster.stdout.readline().strip()]
            if code == 1:
                assert_resumed(tmp_path, *dask)
                (tmp_path / "points.log.go").unlink()
            with program(tmp_path, *TWELVE, *dask) as running:
                wait_until(running, lambda: finished(tmp_path) == 4)
                os.killpg(running.pid if code == 130 else cluster.pid, number)
                assert_ended(running, code, KEPT)
    assert_resumed(tmp_path)
