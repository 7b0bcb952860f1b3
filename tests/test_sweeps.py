"""Sweeps: rows and their values, points, files, refinement, the journal, and what is refused.

`test_sweeps_faults.py` has workers that are killed, signals and full disks.
"""

from __future__ import annotations

import csv
import json
import math
import os
import re
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
import sweep_functions as functions
from conftest import assert_says
from sweep_functions import FLAGS, RAISED, SMALL, UNFIT, VALUES, Immediate, Shuffled

from pymunk_dragon import March, Scenario, first_contact, simulate, sweep
from pymunk_dragon.collision import first_contact as search
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies import max_speed, min_pitch
from pymunk_dragon.sweeps import evaluation, plan
from pymunk_dragon.sweeps.quantities import contact_time

# A dragon whose head runs into it after 13 s: an exact search takes a tenth of a second.
SHORT = {"benches": 10, "turns": 5}
X = {"x": [float(x) for x in range(6)]}


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


@pytest.fixture
def here(tmp_path, monkeypatch):
    """The working directory, which the program adds to the path of modules."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    return tmp_path


@pytest.fixture(scope="module")
def threads():
    with ThreadPoolExecutor(2) as executor:
        yield executor


def test_rows_are_in_the_order_of_the_grid_whatever_the_order_of_completion():
    axes = {"x": [3.0, 1.0, 1.0], "n": range(6), "y": [0.5, 0.25]}
    points = [(x, n, y) for x in axes["x"] for n in axes["n"] for y in axes["y"]]
    told = []
    with Shuffled(len(points)) as shuffled:
        found = sweep(SMALL, axes, functions.total, shuffled, batch_size=1, progress=lambda *count: told.append(count))
    assert shuffled.order != points
    assert sorted(shuffled.order) == sorted(points)
    assert found.columns == ("x", "n", "y", "total", "benches_of_march", "error")
    assert list(found.rows()) == [[x, n, y, x + y + n, 4, None] for x, n, y in points]
    assert told == sorted(told)
    assert told[-1] == (36, 36)


def test_contact_time_is_that_of_first_contact(threads):
    found = sweep(SHORT, {"pitch": [0.5, 0.55], "start_s": [-45.0, -40.0], "width": [0.2, 0.3]}, executor=threads)
    assert found.columns == ("pitch", "start_s", "width", "contact_time", "bench_a", "bench_b", "status", "error")
    statuses = set()
    for pitch, start_s, width, *values, error in found.rows():
        hit = first_contact(Scenario(pitch=pitch, start_s=start_s, width=width, benches=10).march())
        time_of_contact = hit.time if hit.status == "contact" else None
        assert (values, error) == ([time_of_contact, *(hit.benches or (None, None)), hit.status], None)
        statuses.add(hit.status)
    assert len(statuses) > 1


@pytest.mark.thorough
def test_values_are_those_of_the_studies_and_of_near_misses(threads):
    # The paper's dragon passes two benches closely in the last 7 s before its first contact.
    [(start, gap, moment, *benches, status, error)] = sweep(None, {"start": [405.0]}, "nearest-gap", threads).rows()
    nearest = min(search(March(), start=start).near_misses, key=lambda miss: miss.gap)
    assert (gap, moment, tuple(benches), status, error) == (nearest.gap, nearest.time, nearest.benches, "contact", None)
    for width, pitch, a, b, limit, _ in sweep({"benches": 20}, {"width": [0.25, 0.3]}, "min-pitch", threads).rows():
        found = min_pitch(Dragon(benches=20, width=width))
        assert (pitch, (a, b), limit) == (found.pitch, found.benches, found.limit)
    scenario = {"dragon": {"benches": np.int64(30)}, "curve": {"kind": "u-turn", "radius": 5.0}}
    for limit, *values, _ in sweep(scenario, {"limit": [1.5, 2.0]}, "max-speed", threads).rows():
        found = max_speed(Dragon(benches=30), limit=limit, radius=5.0)
        assert values == [found.speed, found.handle, found.ratio]


@pytest.mark.thorough
def test_engine_quantities_are_those_of_simulate():
    axes = {"substep": [0.02, 0.05], "iterations": [10]}
    played = sweep(SHORT, axes, "engine-contact-time", Immediate())
    errors = sweep(SHORT, axes, "engine-error", Immediate())
    march = Scenario(**SHORT).march()
    exact = first_contact(march).time
    for row, error in zip(played.rows(), errors.rows(), strict=True):
        run = simulate(march, substep=row[0], iterations=row[1])
        assert row[2:] == [run.first_contact.time, *run.first_contact.benches, run.outcome, None]
        assert error[2:] == [run.first_contact.time - exact, run.head_drift, run.max_drift, run.outcome, None]


def test_scenario_and_quantity_are_given_in_any_form():
    time = first_contact(Scenario(**SHORT, pitch=0.6).march()).time
    for scenario in (
        Scenario(**SHORT, pitch=0.6),
        Scenario(**SHORT, pitch=0.6).march(),
        {"dragon": {"benches": 10}, "curve": {"kind": "spiral", "pitch": 0.6}, "turns": 5},
        {"benches": np.int64(10), "turns": 5, "pitch": np.float64(0.6)},
    ):
        found = sweep(scenario, {"width": [0.3]}, contact_time, Immediate())
        assert (found.column("contact_time")[0], found.reference) == (time, {"width": 0.3}), scenario
    named = sweep(scenario, {"width": [0.3]}, "pymunk_dragon.sweeps.quantities:contact_time", Immediate())
    assert list(named.rows()) == list(found.rows())


def test_own_parameters_are_axes_with_the_annotated_types_or_fixed_values():
    axes = {"gain": [0.5, 1.5], "points": [0.25], "wide": [0.125], "count": [3]}
    rows = list(sweep(SMALL, axes, functions.annotated, Immediate()).rows())
    assert rows == [[0.5, 0.25, 0.125, 3, 0.875, None], [1.5, 0.25, 0.125, 3, 1.875, None]]
    found = sweep({**SMALL, "x": np.float32(0.5), "n": np.int64(2)}, {"y": [1.0]}, functions.total, Immediate())
    assert list(found.rows()) == [[1.0, 3.5, 4, None]]


def test_samples_are_in_the_box_and_follow_the_seed():
    axes = {"x": [-1.0, 3.0], "n": [2, 5], "pitch": [0.5, 0.6]}
    for sampling in ("sobol", "random"):

        def points(seed, sampling=sampling):
            found = sweep(SMALL, axes, functions.total, Immediate(), samples=32, seed=seed, sampling=sampling)
            return [tuple(row[:3]) for row in found.rows()]

        drawn = points(7)
        assert len(drawn) == 32
        assert drawn == points(7) != points(8)
        for low, high, values in ((-1, 3, [x for x, _, _ in drawn]), (0.5, 0.6, [pitch for *_, pitch in drawn])):
            assert all(low <= value <= high for value in values)
            # A quarter of the interval or more is at no end.
            assert min(values) < low + 0.25 * (high - low) < high - 0.25 * (high - low) < max(values)
        assert {(n, type(n)) for _, n, _ in drawn} == {(n, int) for n in (2, 3, 4, 5)}


def test_refined_points_lie_at_the_boundary_and_locate_it():
    axes = {"x": np.linspace(-1, 1, 9), "y": np.linspace(-1, 1, 9)}
    found = sweep(SMALL, axes, functions.in_circle, Immediate(), refine=150)
    rows = [tuple(row) for row in found.rows()]
    assert 75 < len(rows) - 81 <= 150
    assert len(set(rows)) == len(rows)
    assert all(abs(math.hypot(x, y) - 0.7) <= math.sqrt(2) * 0.25 for x, y, *_ in rows[81:])
    # Wherever one looks, a cell of half the size has both sides.
    for angle in np.linspace(0, 2 * math.pi, 100):
        at = 0.7 * math.cos(angle), 0.7 * math.sin(angle)
        for status in ("in", "out"):
            assert min(math.dist(at, row[:2]) for row in rows if row[3] == status) <= math.sqrt(2) * 0.125
    assert {type(row[0]) for row in sweep(SMALL, {"n": [0, 9]}, functions.total, Immediate(), refine=5).rows()} == {int}


def undisturbed(path, **options):
    """Bytes of a table of failing and other points."""
    axes = {"pitch": [0.1, 0.5, 0.55], "x": [0.1 * x for x in range(20)], "n": [1, 2]}
    sweep(SMALL, axes, functions.total, out=path, **options)
    return path.read_bytes()


def test_table_is_the_same_from_threads_and_processes(tmp_path, threads):
    expected = undisturbed(tmp_path / "immediate.csv", executor=Immediate())
    for options in ({"executor": threads, "batch_size": 1}, {"executor": threads, "batch_size": 4096}, {"workers": 2}):
        assert undisturbed(tmp_path / "other.csv", **options) == expected, options


@pytest.mark.thorough
def test_pool_of_the_users_gives_the_same_table_and_is_not_closed(tmp_path):
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        found = undisturbed(tmp_path / "pool.csv", executor=pool, batch_size=7)
        assert found == undisturbed(tmp_path / "immediate.csv", executor=Immediate())
        assert pool.submit(math.sqrt, 4.0).result() == 2.0


def test_values_of_a_function_are_plain_cells_of_csv_and_parquet(tmp_path):
    files = [tmp_path / "map.csv", tmp_path / "map.parquet"]
    for k, value in enumerate(VALUES):
        sweep(SMALL, {"k": [k]}, functions.value, Immediate(), files)
        expected = value.item() if isinstance(value, np.generic) else value
        with files[0].open(newline="", encoding="utf-8") as file:
            assert list(csv.reader(file)) == [["k", "v", "error"], [str(k), str(expected), ""]]
        assert pyarrow.parquet.read_table(files[1]).to_pylist() == [{"k": k, "v": expected, "error": None}]


def test_columns_are_those_of_all_points_and_none_is_not_nan(tmp_path):
    files = [tmp_path / "map.csv", tmp_path / "map.parquet"]
    found = sweep(SMALL, {"k": range(3)}, functions.mixed, Immediate(), files)
    assert files[0].read_text() == "k,v,w,odd,error\n0,1.5,1,,\n1,,text,1,\n2,nan,True,,\n"
    stored = pyarrow.parquet.read_table(files[1])
    kinds = {field.name: str(field.type) for field in stored.schema}
    assert kinds == {"k": "int64", "v": "double", "w": "string", "odd": "int64", "error": "string"}
    assert str(stored.column("v").to_pylist()) == "[1.5, None, nan]"
    assert stored.column("w").to_pylist() == ["1", "text", "True"]
    assert np.isnan(found.column("v")).tolist() == [False, True, True]
    assert found.to_dict() == {"points": 3, "failed": 0, "resumed": 0, "seconds": found.seconds}
    # The journal is gone; the result can still be written.
    found.write(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == files[0].read_bytes()


def test_failing_point_is_a_row_with_the_reason_and_harms_no_other():
    found = sweep(SMALL, {"k": range(len(UNFIT) + 1)}, functions.unfit, Immediate())
    *failed, fine = found.rows()
    assert fine == [len(UNFIT), 1, None]
    assert all(row[1] is None and "the quantity returned" in row[-1] for row in failed), failed
    found = sweep(SMALL, {"k": range(len(RAISED) + 1)}, functions.raising, Immediate(), batch_size=20)
    *errors, nothing = (row[-1] for row in found.rows())
    assert errors[:3] == [r"ValueError: two lines\x1b[1m", "Stop: now", "SystemExit: 3"]
    assert (found.failed, nothing) == (len(RAISED), None)
    found = sweep(SMALL, {"pitch": [0.1, 0.5], "width": [0.2, 0.9]}, functions.total, Immediate())
    assert [row[-1] is None for row in found.rows()] == [False, False, True, False]


def program(*arguments):
    command = [sys.executable, "-m", "pymunk_dragon", "sweep", *FLAGS, *arguments, "--workers", "1"]
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", ".")])
    return subprocess.run(command, capture_output=True, text=True, timeout=120, env=os.environ | {"PYTHONPATH": path})


def test_program_reads_ranges_lists_and_functions_of_its_folder_and_prints_the_table(here):
    (here / "mine.py").write_text(
        "def both(march, *, n: int):\n"
        "    return {'twice': 2 * n, 'sizes': f'{march.curve.pitch} {march.dragon.head_spacing}'}\n"
    )
    axes = ["--axis", "pitch=0.10:0.70:0.3", "--axis", "n=7,5:6:1", "--axis", "head-spacing=2.50"]
    done = program("--quantity", "mine:both", *axes, "-o", "map.csv")
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert "9 points of mine:both over pitch and n and head_spacing, 3 failed" in done.stdout
    first, *rows = (here / "map.csv").read_text().splitlines()
    assert first == "pitch,n,head_spacing,twice,sizes,error"
    # A spiral must be wider than the benches.
    assert re.fullmatch(r'0.1,7,2.5,,,"?pitch is 0.1, .*', rows[0])
    # Decimals as they were written, both ends included.
    assert rows[6:] == [f"0.7,{n},2.5,{2 * n},0.7 2.5," for n in (7, 5, 6)]
    assert set(names(here)) - {"__pycache__"} == {"map.csv", "mine.py"}


def test_program_takes_samples_and_prints_json_only_whatever_functions_print(here):
    axes = ["--axis", "x=0.5:1", "--axis", "n=2,4", "--samples", "5", "--seed", "3"]
    done = program("--quantity", "sweep_functions:printing", *axes, "--json", "-o", "map.csv")
    assert done.returncode == 0
    assert {"printed by the quantity", "printed by a program"} <= set(done.stderr.splitlines())
    told = json.loads(done.stdout)
    assert told.pop("seconds") > 0
    assert told == {"points": 5, "failed": 0, "resumed": 0}
    expected = sweep(SMALL, {"x": [0.5, 1.0], "n": [2, 4]}, functions.printing, Immediate(), samples=5, seed=3)
    assert (here / "map.csv").read_text().splitlines() == list(expected.csv())


ONE = ["--axis", "pitch=0.5"]
INTERVAL = ["--axis", "pitch=0.5:0.6"]
# Arguments, and the flag and the value that the message names.
REFUSED = [
    ([], "--axis"),
    (["--axis", "pitch=wide"], "'pitch=wide'"),
    (["--axis", "pitch=0.6:0.5:0.1"], "'pitch=0.6:0.5:0.1'"),
    (["--axis", "length=1"], "'length'"),
    ([*ONE, "--axis", "pitch=0.6"], "'pitch=0.6'"),
    (["--axis", "pitch=nan"], "'pitch=[nan]'"),
    (["--axis", "pitch=-2,-1"], "'pitch=-2.0'"),
    ([*ONE, "--benches", "1"], "--benches is 1"),
    ([*ONE, "--scenario", "none.toml"], "--scenario is 'none.toml'"),
    (["--axis", "pitch=0.1:1:0.00001", "--axis", "width=0.1:0.2:0.00001"], "--axis is '900100001 points'"),
    ([*ONE, "--quantity", "math:none"], "--quantity is 'math:none'"),
    ([*ONE, "--quantity", "failing:f"], "--quantity is 'failing:f'"),
    ([*ONE, "--quantity", "broken:f"], "--quantity is 'broken:f'"),
    ([*INTERVAL, "--samples", "4", "--refine", "2"], "--refine is 2"),
    (["--axis", "pitch=0.5,0.6,0.7", "--samples", "2"], "--axis is 'pitch=[0.5, 0.6, 0.7]'"),
    (INTERVAL, "--axis is 'pitch=0.5:0.6'"),
    ([*INTERVAL, "--samples", "2", "--sampling", "grid"], "--sampling"),
    ([*ONE, "--timeout", "0"], "--timeout is 0.0"),
    ([*ONE, "--scheduler", "localhost"], "--scheduler is 'localhost'"),
    ([*ONE, "-o", "map.txt"], "-o is 'map.txt'"),
    ([*ONE, "-o", "folder.csv"], "-o is 'folder.csv'"),
    ([*ONE, "--resume"], "--resume"),
]
# Libraries that are absent, arguments, and the extra that the message names.
ABSENT = [
    ("scipy.stats", [*INTERVAL, "--samples", "2"], "studies"),
    ("pyarrow", [*ONE, "-o", "map.parquet"], "parquet"),
    ("distributed", [*ONE, "--scheduler", "local"], "cluster"),
]


def test_bad_input_and_missing_libraries_are_one_line_with_what_is_wrong(here, call, monkeypatch):
    (here / "folder.csv").mkdir()
    (here / "failing.py").write_text("1 / 0\n")
    (here / "broken.py").write_text("def f(:\n")
    before = names(here)

    def assert_refused(arguments, *words):
        out = [] if "-o" in arguments or "--resume" in arguments else ["-o", "map.csv"]
        code, out, err = call("sweep", *FLAGS, *arguments, *out)
        assert (code, out, err.count("\n")) == (2, "", 1), (arguments, err)
        assert_says(Exception(err.rstrip("\n")), "pymunk-dragon: ", *words)
        assert sorted({*names(here)} - {"__pycache__"}) == before, arguments

    for arguments, word in REFUSED:
        assert_refused(arguments, word)
    for library, arguments, extra in ABSENT:
        with monkeypatch.context() as without:
            without.setitem(sys.modules, library, None)
            assert_refused(arguments, f"pymunk-dragon[{extra}]")


def test_bad_arguments_are_errors_of_the_package():
    for arguments, word in (
        ({"axes": "pitch"}, "axis is 'pitch'"),
        ({"axes": {"pitch": []}}, "axis is 'pitch=[]'"),
        ({"axes": {"pitch": [[0.5], [0.6, 0.7]]}}, "axis"),
        ({"axes": {"count": [0.5]}, "quantity": functions.annotated}, "count=[0.5]"),
        ({"scenario": 5}, "scenario is 5"),
        ({"scenario": {"benchs": 5}, "axes": {"width": [0.3]}, "quantity": "min-pitch"}, "benchs is 5"),
        ({"scenario": {**SMALL, "x": [1.0]}, "quantity": functions.total}, "x is"),
        ({"quantity": lambda march: {}}, "quantity"),
        ({"executor": 3}, "executor is 3"),
        ({"scheduler": "local"}, "scheduler is 'local'"),
        ({"batch_size": 0}, "batch_size is 0"),
        ({"workers": 1.5}, "workers is 1.5"),
    ):
        given = {"scenario": SMALL, "axes": {"pitch": [0.5]}, "executor": Immediate()} | arguments
        with pytest.raises(ParameterError) as error:
            sweep(**given)
        assert_says(error.value, word)


class Case:
    """A sweep of six points whose evaluations are counted."""

    def __init__(self, folder):
        self.out = folder / "map.csv"
        self.journal = folder / "map.csv.journal"
        self.log = folder.parent / f"{folder.name}.log"
        self.log.write_text("")

    def run(self, executor=None, **options):
        given = {"scenario": {**SMALL, "log": str(self.log)}, "axes": X, "quantity": functions.logged} | options
        return sweep(executor=executor or Immediate(), out=self.out, batch_size=1, **given)

    def interrupt(self, points=4, **options):
        """Finish this many points, whose numbers it returns, and no more."""
        with pytest.raises(KeyboardInterrupt, match=rf"{points} of \d points are in .*map.csv.journal"):
            self.run(Immediate(points), **options)
        finished = [json.loads(line)[0] for line in self.journal.read_bytes().splitlines()[1:]]
        assert len(finished) == points
        self.log.write_text("")
        return finished

    def evaluated(self):
        return sorted(map(float, self.log.read_text().split()))

    def assert_refused(self, match, error=FileFormatError, **options):
        before = self.journal.read_bytes()
        with pytest.raises(error, match=match):
            self.run(**options)
        assert self.journal.read_bytes() == before
        assert self.evaluated() == []


@pytest.fixture
def case(tmp_path):
    return Case(tmp_path)


@pytest.fixture
def expected(tmp_path_factory):
    whole = Case(tmp_path_factory.mktemp("whole"))
    whole.run()
    assert names(whole.out.parent) == ["map.csv"]
    return whole.out.read_bytes()


def test_interrupted_sweep_is_resumed_to_the_same_bytes_even_if_the_last_line_was_cut(case, expected):
    case.interrupt()
    assert names(case.out.parent) == ["map.csv.journal"]
    content = case.journal.read_bytes()
    finished = [json.loads(line)[0] for line in content.splitlines()[1:]]
    last = content.rindex(b"\n", 0, -1) + 1
    for end in (last, last + 1, len(content) - 1, len(content)):
        case.journal.write_bytes(content[:end])
        case.log.write_text("")
        kept = 4 if end == len(content) else 3
        # In another order than before: the bytes that were cut off are not those that are written.
        with Shuffled(len(X["x"]) - kept) as executor:
            assert case.run(executor, resume=True).resumed == kept
        assert case.evaluated() == sorted(set(X["x"]) - set(finished[:kept]))
        assert case.out.read_bytes() == expected
        assert names(case.out.parent) == ["map.csv"]


def test_sweep_without_a_finished_point_begins_anew(case, expected):
    with pytest.raises(KeyboardInterrupt):
        case.run(Immediate(0))
    assert names(case.out.parent) == []
    case.interrupt()
    first = case.journal.read_bytes().partition(b"\n")[0]
    for end in (0, 1, len(first) // 2, len(first)):
        for resume in (False, True):
            case.journal.write_bytes(first[:end])
            assert case.run(resume=resume).resumed == 0
            assert case.out.read_bytes() == expected


def test_table_that_cannot_be_written_needs_no_point_again(case, expected, monkeypatch):
    def full(path, columns, rows):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as other:
        other.setattr("pymunk_dragon.sweeps.result.WRITERS", {".csv": full})
        with pytest.raises(DragonError, match=r"No space left.*6 of 6 points are in"):
            case.run()
    case.log.write_text("")
    assert case.run(Immediate(0), resume=True).resumed == 6
    assert case.evaluated() == []
    assert case.out.read_bytes() == expected


def test_damaged_journal_and_one_that_is_none_or_of_finished_points_is_left_alone(case):
    case.interrupt()
    whole = case.journal.read_bytes()
    case.assert_refused("4 finished points", ParameterError)
    lines = whole.split(b"\n")
    for damage in (b"garbage", b"", b"{}", b"[1,{}]", b'["1",{},null]', b"[1,5,null]", b"[-1,{},null]", b"[" * 5000):
        case.journal.write_bytes(b"\n".join([*lines[:2], damage, *lines[3:]]))
        for resume in (True, False):
            case.assert_refused("line 3 is damaged", resume=resume)
    for content in (b"my notes\n", b"my notes", b"\x00\x01", b"{\n}\n", b"{]\n[]\n"):
        case.journal.write_bytes(content)
        for resume in (True, False):
            case.assert_refused("not a journal of a sweep", resume=resume)


def test_other_sweep_is_not_resumed_and_the_change_is_named(case, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path.parent)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    source = tmp_path.parent / "changed_quantity.py"
    source.write_text("def f(march, *, x: float, log: str):\n    return {'v': x}\n")
    scenario = {**SMALL, "log": str(case.log)}
    for given, changed, word in (
        ({}, {"scenario": {**scenario, "width": 0.25}}, "scenario width was 0.3, but is 0.25"),
        ({}, {"axes": {"x": [*X["x"], 9.0]}}, "axis x was"),
        ({}, {"axes": {"x": X["x"], "pause": [0.0]}}, "axis pause was null"),
        ({"axes": {"x": [0.0], "pause": [0.0] * 5}}, {"axes": {"pause": [0.0] * 5, "x": [0.0]}}, "order of the axes"),
        ({}, {"refine": 5}, "refine was 0, but is 5"),
        ({}, {"quantity": "sweep_functions:total", "scenario": SMALL}, "quantity name was"),
        ({"axes": {"x": [0.0, 1.0]}, "samples": 8}, {"samples": 9}, "axis samples was 8, but is 9"),
        ({"axes": {"x": [0.0, 1.0]}, "samples": 8}, {"seed": 1}, "axis seed was 0, but is 1"),
        ({"quantity": "changed_quantity:f"}, {}, "quantity source was"),
    ):
        finished = case.interrupt(**given)
        if "source" in word:
            text = source.read_text()
            source.write_text(text.replace("x}", "-x}"))
        case.assert_refused(f"(?s)of another sweep.*{word}", resume=True, **given | changed)
        if "source" in word:
            source.write_text(text)
        with monkeypatch.context() as other:
            for module in (plan, evaluation):
                other.setattr(module, "program_version", lambda: "9.9")
            case.assert_refused(r'version was .*, but is "9\.9"', resume=True, **given)
        # The order of a scenario's values does not matter.
        again = dict(reversed(scenario.items()))
        assert case.run(resume=True, **{"scenario": again} | given).resumed == len(finished)


def test_two_sweeps_do_not_write_one_table(case, expected):
    refused = []

    def second(done, total):
        if done == 2:
            for resume in (False, True):
                with pytest.raises(ParameterError, match="a table of no other running sweep"):
                    case.run(resume=resume)
                refused.append(resume)

    case.run(progress=second)
    assert refused == [False, True]
    assert case.out.read_bytes() == expected
    assert case.evaluated() == X["x"]
