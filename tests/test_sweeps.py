"""Sweeps: rows and their values, points, files, refinement, the journal, and what is refused.

`test_sweeps_faults.py` has workers that are killed, signals and full disks.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import os
import random
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from importlib import import_module, reload
from itertools import pairwise, product
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
from pymunk_dragon.sweeps import QUANTITIES, computation, evaluation, plan
from pymunk_dragon.sweeps.journal import Journal
from pymunk_dragon.sweeps.quantities import contact_time
from pymunk_dragon.sweeps.workers import Borrowed

# A dragon whose head runs into it after 13 s: an exact search takes a tenth of a second.
SHORT = {"benches": 10, "turns": 5}
X = {"x": [float(x) for x in range(6)]}


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def table(found):
    """The rows of a table as text, by the names of the columns."""
    return list(csv.DictReader(io.StringIO("\n".join(found.csv()))))


def column(rows, name):
    return [row[name] for row in rows]


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


@pytest.fixture
def shuffled():
    with Shuffled() as executor:
        yield executor


# Rows


def test_rows_are_in_the_order_of_the_grid_whatever_the_order_of_completion(shuffled):
    axes = {"x": [3.0, 1.0, 2.0], "n": range(6), "y": [0.5, 0.25]}
    found = sweep(SMALL, axes, functions.total, shuffled, batch_size=1)
    points = [(x, n, y) for x in axes["x"] for n in axes["n"] for y in axes["y"]]
    assert shuffled.order != points
    assert sorted(shuffled.order) == sorted(points)
    assert found.columns == ("x", "n", "y", "total", "benches_of_march", "error")
    assert list(found.rows()) == [[x, n, y, x + y + n, 4, None] for x, n, y in points]


def test_point_that_is_listed_twice_has_two_rows():
    found = sweep(SMALL, {"x": [1.0, 1.0]}, functions.total, Immediate())
    assert [row[0] for row in found.rows()] == [1.0, 1.0]


def test_contact_time_is_that_of_first_contact(threads):
    found = sweep(SHORT, {"pitch": [0.5, 0.55], "width": [0.2, 0.3]}, executor=threads)
    assert found.columns == ("pitch", "width", "contact_time", "bench_a", "bench_b", "status", "error")
    statuses = set()
    for pitch, width, *values, error in found.rows():
        hit = first_contact(Scenario(pitch=pitch, width=width, **SHORT).march())
        time_of_contact = hit.time if hit.status == "contact" else None
        assert (values, error) == ([time_of_contact, *(hit.benches or (None, None)), hit.status], None)
        statuses.add(hit.status)
    assert len(statuses) > 1


@pytest.mark.thorough
def test_nearest_gap_is_the_smallest_near_miss_of_first_contact(threads):
    # The paper's dragon passes two benches closely in the last 7 s before its first contact.
    found = sweep(None, {"start": [405.0, 408.0]}, "nearest-gap", threads)
    for start, gap, moment, *benches, status, error in found.rows():
        hit = search(March(), start=start)
        nearest = min(hit.near_misses, key=lambda miss: miss.gap)
        assert (gap, moment, tuple(benches)) == (nearest.gap, nearest.time, nearest.benches)
        assert (status, error) == ("contact", None)


@pytest.mark.thorough
def test_min_pitch_is_that_of_the_study(threads):
    for width, pitch, a, b, limit, _ in sweep({"benches": 20}, {"width": [0.25, 0.3]}, "min-pitch", threads).rows():
        found = min_pitch(Dragon(benches=20, width=width))
        assert (pitch, (a, b), limit) == (found.pitch, found.benches, found.limit)


@pytest.mark.thorough
def test_max_speed_is_that_of_the_study(threads):
    for limit, ratio, speed, handle, speed_ratio, _ in sweep(
        {"benches": 30}, {"limit": [1.5, 2.0], "ratio": [2.0, 1.9]}, "max-speed", threads
    ).rows():
        found = max_speed(Dragon(benches=30), limit=limit, ratio=ratio)
        assert (speed, handle, speed_ratio) == (found.speed, found.handle, found.ratio)


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


@pytest.mark.parametrize(
    "scenario",
    [
        Scenario(**SHORT, pitch=0.6),
        Scenario(**SHORT, pitch=0.6).march(),
        {**SHORT, "pitch": 0.6},
        {"dragon": {"benches": 10}, "curve": {"kind": "spiral", "pitch": 0.6}, "turns": 5},
        {"benches": np.int64(10), "turns": 5, "pitch": np.float64(0.6)},
    ],
    ids=["scenario", "march", "values", "tables", "NumPy"],
)
def test_scenario_is_given_in_any_form(scenario):
    found = sweep(scenario, {"width": [0.3]}, executor=Immediate())
    assert found.column("contact_time")[0] == first_contact(Scenario(**SHORT, pitch=0.6).march()).time
    assert found.reference == {"width": 0.3}


@pytest.mark.thorough
def test_study_takes_the_values_of_a_scenario_that_are_its_parameters():
    expected = list(sweep({"benches": 30, "radius": 5.0}, {"limit": [1.0]}, "max-speed", Immediate()).csv())
    for scenario in (
        {"dragon": {"benches": np.int64(30)}, "curve": {"kind": "u-turn", "radius": 5.0}},
        Scenario(benches=30, curve="u-turn", radius=5.0),
    ):
        assert list(sweep(scenario, {"limit": [1.0]}, "max-speed", Immediate()).csv()) == expected
    assert list(sweep(None, {"limit": [1.0]}, "max-speed", Immediate()).csv()) != expected


def test_parameter_that_depends_on_an_axis_is_not_kept_from_one_point():
    axes = {"start_s": [-45.0, -40.0]}
    times = sweep({"benches": 10, "turns": 5}, axes, executor=Immediate()).column("contact_time").tolist()
    assert times == [first_contact(Scenario(benches=10, start_s=s).march()).time for s in axes["start_s"]]
    assert times[0] > times[1] + 4


def test_axes_may_leave_a_single_valid_corner():
    # A spiral must be wider than the benches.
    found = sweep(SMALL, {"pitch": [0.1, 0.5], "width": [0.2, 0.9]}, functions.total, Immediate())
    assert [row[-1] is None for row in found.rows()] == [False, False, True, False]
    assert_says(Exception(table(found)[0]["error"]), "pitch is 0.1", "more than the width")


# Points


@pytest.mark.parametrize("sampling", ["sobol", "random"])
def test_samples_are_in_the_box_and_follow_the_seed(sampling):
    axes = {"x": [-1.0, 3.0], "n": [2, 5], "pitch": [0.5, 0.6]}

    def points(seed):
        found = sweep(SMALL, axes, functions.total, Immediate(), samples=40, seed=seed, sampling=sampling)
        return [tuple(row[:3]) for row in found.rows()]

    drawn = points(7)
    assert len(drawn) == 40
    assert drawn == points(7)
    assert drawn != points(8)
    for low, high, values in ((-1, 3, [x for x, _, _ in drawn]), (0.5, 0.6, [pitch for *_, pitch in drawn])):
        assert all(low <= value <= high for value in values)
        # A quarter of the interval or more is at no end.
        assert min(values) < low + 0.25 * (high - low) < high - 0.25 * (high - low) < max(values)
    assert {n for _, n, _ in drawn} == {2, 3, 4, 5}
    assert all(type(n) is int for _, n, _ in drawn)


def test_sobol_samples_are_more_even_than_random_ones():
    def counts(sampling):
        axes = {"x": [0.0, 1.0], "y": [0.0, 1.0]}
        rows = sweep(SMALL, axes, functions.total, Immediate(), samples=64, sampling=sampling).rows()
        return np.histogram2d(*np.array([row[:2] for row in rows]).T, bins=8, range=[[0, 1], [0, 1]])[0]

    assert (counts("sobol") == 1).all()
    assert not (counts("random") == 1).all()


def test_samples_of_thirty_parameters_need_no_billion_corners():
    parameters = ", ".join(f"p{i}: float = 0.0" for i in range(30))
    space: dict = {}
    exec(f"def wide(march, *, {parameters}): return {{'sum': {'+'.join(f'p{i}' for i in range(30))}}}", space)
    functions.wide = space["wide"]
    functions.wide.__module__ = "sweep_functions"
    try:
        axes = {f"p{i}": [0.0, 1.0] for i in range(30)}
        assert sweep(SMALL, axes, functions.wide, Immediate(), samples=4).failed == 0
        with pytest.raises(ParameterError, match="benches is 1"):
            sweep({"benches": 1}, axes, functions.wide, Immediate(), samples=4)
    finally:
        del functions.wide


def test_program_reads_ranges_lists_and_functions_of_its_folder_and_prints_the_table(here):
    (here / "mine.py").write_text(
        "def both(march, *, n: int):\n"
        "    return {'twice': 2 * n, 'sizes': f'{march.curve.pitch} {march.dragon.head_spacing}'}\n"
    )
    command = [sys.executable, "-m", "pymunk_dragon", "sweep", "--quantity", "mine:both", *FLAGS, "--workers", "2"]
    axes = ["--axis", "pitch=0.40:0.80:0.1", "--axis", "n=7,5:6:1", "--axis", "head-spacing=2.50"]
    done = subprocess.run([*command, *axes], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    # Decimals as they were written, both ends included.
    rows = [f"{pitch},{n},2.5,{2 * n},{pitch} 2.5," for pitch in (0.4, 0.5, 0.6, 0.7, 0.8) for n in (7, 5, 6)]
    assert done.stdout.splitlines() == ["pitch,n,head_spacing,twice,sizes,error", *rows]
    assert names(here) == ["mine.py"] or names(here) == ["__pycache__", "mine.py"]


def test_program_takes_samples_of_intervals(here, call, threads, monkeypatch):
    monkeypatch.setattr(import_module("pymunk_dragon.sweeps.sweep"), "Processes", lambda count: Borrowed(threads))
    given = ["sweep", *FLAGS, "--quantity", "sweep_functions:total", "--samples", "5", "--seed", "3"]
    code, out, err = call(*given, "--axis", "x=0.5:1", "--axis", "n=2,4")
    expected = sweep(SMALL, {"x": [0.5, 1.0], "n": [2, 4]}, functions.total, threads, samples=5, seed=3)
    assert (code, out.splitlines(), err) == (0, list(expected.csv()), "")


# Input that is refused

OUT = ["-o", "map.csv"]
ONE = ["--axis", "pitch=0.5"]
REFUSED = {
    "no axis": ([], "--axis", "at least one"),
    "axis without values": (["--axis", "pitch"], "--axis", "'pitch'", "pitch=0.4:0.8:0.01"),
    "axis of words": (["--axis", "pitch=wide"], "--axis", "'pitch=wide'", "such as"),
    "empty axis": (["--axis", "pitch="], "--axis", "'pitch='", "such as"),
    "descending range": (["--axis", "pitch=0.6:0.5:0.1"], "--axis", "'pitch=0.6:0.5:0.1'", "such as"),
    "endless range": (["--axis", "pitch=0:1:1e-9"], "--axis", "'pitch=0:1:1e-9'", "such as"),
    "unknown axis": (["--axis", "length=1"], "--axis", "'length'", "one of benches, head_spacing"),
    "axis twice": ([*ONE, "--axis", "pitch=0.6"], "--axis", "'pitch=0.6'", "once"),
    "axis twice in other letters": (["--axis", "head-spacing=1", "--axis", "head_spacing=2"], "--axis", "once"),
    "part of a bench": (["--axis", "benches=4,4.5"], "--axis", "'benches=[4.0, 4.5]'", "whole numbers"),
    "nan": (["--axis", "pitch=nan"], "--axis", "'pitch=[nan]'", "finite"),
    "infinite": (["--axis", "pitch=inf"], "--axis", "'pitch=[inf]'", "finite"),
    "no valid point": (["--axis", "pitch=-2,-1"], "--axis", "'pitch=-2.0'", "a number from 0.001"),
    "axis of another curve": (["--axis", "ratio=2,3"], "--axis", "'ratio=2.0'", "absent"),
    "invalid scenario": ([*ONE, "--benches", "1"], "--benches is 1", "a whole number from 2"),
    "missing scenario": ([*ONE, "--scenario", "none.toml"], "--scenario is 'none.toml'", "No such file"),
    "too many points": (
        ["--axis", "pitch=0.1:1:0.00001", "--axis", "width=0.1:0.2:0.00001"],
        "--axis is '900100001 points'",
        "at most 100000000",
    ),
    "unknown quantity": ([*ONE, "--quantity", "length"], "--quantity is 'length'", "contact-time", "module:function"),
    "module without function": ([*ONE, "--quantity", "math:none"], "--quantity is 'math:none'", "no attribute 'none'"),
    "missing module": ([*ONE, "--quantity", "none:f"], "--quantity is 'none:f'", "No module named 'none'"),
    "no module": ([*ONE, "--quantity", ":f"], "--quantity is ':f'", "importable"),
    "relative module": ([*ONE, "--quantity", ".x:f"], "--quantity is '.x:f'", "importable"),
    "module that fails": ([*ONE, "--quantity", "failing:f"], "--quantity is 'failing:f'", "division by zero"),
    "module that ends": ([*ONE, "--quantity", "leaving:f"], "--quantity is 'leaving:f'", "SystemExit: 5"),
    "no Python": ([*ONE, "--quantity", "broken:f"], "--quantity is 'broken:f'", "SyntaxError"),
    "no function": ([*ONE, "--quantity", "math:pi"], "--quantity is 'math:pi'", "a function"),
    "class of C": ([*ONE, "--quantity", "builtins:int"], "--quantity is 'builtins:int'", "a function of a march"),
    "refined samples": (["--axis", "pitch=0.5:0.6", "--samples", "4", "--refine", "2"], "--refine is 2", "absent"),
    "negative refinement": ([*ONE, "--refine", "-1"], "--refine is -1", "a whole number from 0"),
    "no samples": (["--axis", "pitch=0.5:0.6", "--samples", "0"], "--samples is 0", "a whole number from 1"),
    "samples of a list": (
        ["--axis", "pitch=0.5,0.6,0.7", "--samples", "2"],
        "--axis is 'pitch=[0.5, 0.6, 0.7]'",
        "the two ends",
    ),
    "samples of a number": ([*ONE, "--samples", "2"], "--axis is 'pitch=[0.5]'", "the two ends"),
    "interval the wrong way": (["--axis", "pitch=0.6:0.5", "--samples", "2"], "--axis is 'pitch=[0.6, 0.5]'", "ends"),
    "interval without samples": (["--axis", "pitch=0.5:0.6"], "--axis is 'pitch=0.5:0.6'", "with --samples"),
    "unknown samples": (["--axis", "pitch=0.5:0.6", "--samples", "2", "--sampling", "grid"], "--sampling", "sobol"),
    "negative seed": (["--axis", "pitch=0.5:0.6", "--samples", "2", "--seed", "-1"], "--seed is -1", "from 0"),
    "no time": ([*ONE, "--timeout", "0"], "--timeout is 0.0", "a number above 0"),
    "no number of seconds": ([*ONE, "--timeout", "nan"], "--timeout is nan", "a number above 0"),
    "no workers": ([*ONE, "--workers", "0"], "--workers is 0", "a whole number from 1"),
    "dead scheduler": ([*ONE, "--scheduler", "tcp://127.0.0.1:1"], "--scheduler is 'tcp://127.0.0.1:1'", "answers"),
    "scheduler without port": ([*ONE, "--scheduler", "localhost"], "--scheduler is 'localhost'", "tcp://HOST:8786"),
    "unknown protocol": ([*ONE, "--scheduler", "ftp://127.0.0.1:1"], "--scheduler is 'ftp://127.0.0.1:1'", "tcp://"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_one_line_with_flag_value_and_what_is_allowed(here, call, monkeypatch, case):
    arguments, *words = REFUSED[case]
    monkeypatch.setattr("pymunk_dragon.sweeps.workers.CONNECT_TIMEOUT", 0.3)
    modules = {"failing.py": "1 / 0\n", "leaving.py": "raise SystemExit(5)\n", "broken.py": "def f(:\n"}
    for name, content in modules.items():
        (here / name).write_text(content)
    code, out, err = call("sweep", *FLAGS, *arguments, *OUT)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert_says(Exception(err.rstrip("\n")), "pymunk-dragon: ", *words)
    assert {"map.csv", "map.csv.journal"}.isdisjoint(names(here))


@pytest.mark.parametrize(
    ("output", "words"),
    [
        (["-o", "map.txt"], ["-o is 'map.txt'", ".csv or .parquet"]),
        (["-o", "map"], ["-o is 'map'", ".csv or .parquet"]),
        (["-o", "none/map.csv"], ["-o is 'none/map.csv'", "No such file"]),
        (["-o", "folder.csv"], ["-o is 'folder.csv'", "not a folder"]),
        (["-o", "map.csv", "-o", "map.txt"], ["-o is 'map.txt'"]),
        (["--resume"], ["--resume", "without a file"]),
    ],
    ids=lambda value: " ".join(value) if "-" in value[0] else "",
)
def test_bad_output_is_one_line(here, call, output, words):
    (here / "folder.csv").mkdir()
    code, out, err = call("sweep", *FLAGS, *ONE, *output)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert_says(Exception(err.rstrip("\n")), *words)
    assert names(here) == ["folder.csv"]


@pytest.mark.parametrize(
    ("library", "arguments", "extra"),
    [
        ("scipy.stats", ["--axis", "pitch=0.5:0.6", "--samples", "2"], "studies"),
        ("pyarrow", [*ONE, "-o", "map.parquet"], "parquet"),
        ("distributed", [*ONE, "--scheduler", "local"], "cluster"),
    ],
)
def test_missing_library_is_one_line_that_names_its_extra(here, call, monkeypatch, library, arguments, extra):
    monkeypatch.setitem(sys.modules, library, None)
    code, out, err = call("sweep", *FLAGS, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"pip install 'pymunk-dragon[{extra}]'" in err
    assert names(here) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"axes": None}, ["axis"]),
        ({"axes": [("pitch", [0.5])]}, ["axis"]),
        ({"axes": "pitch"}, ["axis is 'pitch'"]),
        ({"axes": {"pitch": []}}, ["axis is 'pitch=[]'"]),
        ({"axes": {"pitch": "0.5"}}, ["axis is 'pitch=0.5'"]),
        ({"axes": {"pitch": [None]}}, ["axis is 'pitch=[None]'"]),
        ({"axes": {"pitch": [True]}}, ["axis is 'pitch=[True]'"]),
        ({"axes": {"pitch": [[0.5], [0.6, 0.7]]}}, ["axis"]),
        ({"axes": {"pitch": [10**400]}}, ["axis"]),
        ({"axes": {1: [0.5]}}, ["axis is 1"]),
        ({"scenario": 5}, ["scenario is 5"]),
        ({"scenario": "dragon.toml"}, ["scenario is 'dragon.toml'"]),
        ({"scenario": {"benchs": 5}}, ["benchs is 5", "absent"]),
        ({"scenario": {"benchs": 5}, "axes": {"width": [0.3]}, "quantity": "min-pitch"}, ["benchs is 5", "absent"]),
        ({"quantity": lambda march: {}}, ["quantity", "module:function"]),
        ({"quantity": 3}, ["quantity is 3"]),
        ({"quantity": None}, ["quantity is None"]),
        ({"executor": 3}, ["executor is 3", "concurrent.futures.Executor"]),
        ({"scheduler": "local"}, ["scheduler is 'local'", "absent where an executor is given"]),
        ({"batch_size": 0}, ["batch_size is 0"]),
        ({"workers": 1.5}, ["workers is 1.5"]),
        ({"samples": 2.5, "axes": {"pitch": [0.5, 0.6]}}, ["samples is 2.5"]),
        ({"timeout": "soon"}, ["timeout is 'soon'"]),
    ],
)
def test_bad_arguments_are_errors_of_the_package(arguments, words):
    given = {"scenario": SMALL, "axes": {"pitch": [0.5]}, "executor": Immediate()} | arguments
    with pytest.raises(ParameterError) as error:
        sweep(**given)
    assert_says(error.value, *words)


def test_function_in_another_function_is_refused():
    def inner(march):
        return {}

    with pytest.raises(ParameterError, match="importable function"):
        sweep(SMALL, X, inner, Immediate())


# Functions of the user's


def test_own_parameters_are_axes_with_the_annotated_types():
    axes = {"gain": [0.5, 1.5], "points": [0.25], "wide": [0.125], "count": [3]}
    rows = list(sweep(SMALL, axes, functions.annotated, Immediate()).rows())
    assert rows == [[0.5, 0.25, 0.125, 3, 0.875, None], [1.5, 0.25, 0.125, 3, 1.875, None]]
    with pytest.raises(ParameterError, match=r"count=\[0.5\].*whole numbers"):
        sweep(SMALL, {"count": [0.5]}, functions.annotated, Immediate())


def test_own_parameter_that_is_no_axis_has_a_fixed_value():
    found = sweep({**SMALL, "x": np.float32(0.5), "n": np.int64(2)}, {"y": [1.0]}, functions.total, Immediate())
    assert list(found.rows()) == [[1.0, 3.5, 4, None]]
    with pytest.raises(ParameterError, match="x is"):
        sweep({**SMALL, "x": [1.0]}, {"y": [1.0]}, functions.total, Immediate())


@pytest.mark.parametrize("quantity", [contact_time, "contact-time", "pymunk_dragon.sweeps.quantities:contact_time"])
def test_function_is_given_as_itself_or_by_name(quantity):
    found = sweep(SHORT, {"start": [0.0], "until": [9.0, 20.0]}, quantity, Immediate())
    assert found.column("status").tolist() == ["clear", "contact"]
    assert found.column("contact_time")[1] == pytest.approx(first_contact(Scenario(**SHORT).march()).time, abs=1e-9)


def test_function_that_was_loaded_again_is_the_new_one(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    for text in ("old", "newer"):
        (tmp_path / "edited_quantity.py").write_text(f"def f(march): return {{'v': '{text}'}}\n")
        module = reload(import_module("edited_quantity"))
        found = sweep(SMALL, {"width": [0.3]}, module.f, Immediate())
        assert found.column("v").tolist() == [text]


@pytest.mark.parametrize("name", VALUES)
def test_value_of_a_function_is_a_plain_cell(name, tmp_path):
    k = list(VALUES).index(name)
    files = [tmp_path / "map.csv", tmp_path / "map.parquet"]
    found = sweep(SMALL, {"k": [k]}, functions.value, Immediate(), files)
    expected = VALUES[name].item() if isinstance(VALUES[name], np.generic) else VALUES[name]
    if name == "surrogate":
        expected = r"\udc80"
    ((_, cell, error),) = found.rows()
    assert (cell, type(cell) in (int, float, str, bool), error) == (expected, True, None)
    with files[0].open(newline="", encoding="utf-8") as file:
        assert list(csv.reader(file)) == [["k", "v", "error"], [str(k), str(cell), ""]]
    assert pyarrow.parquet.read_table(files[1]).to_pylist() == [{"k": k, "v": cell, "error": None}]


@pytest.mark.parametrize("name", UNFIT)
def test_result_that_is_no_mapping_of_values_fails_the_point(name):
    k = list(UNFIT).index(name)
    found = sweep(SMALL, {"k": [k, len(UNFIT)]}, functions.unfit, Immediate())
    (failed, fine) = found.rows()
    assert_says(Exception(failed[-1]), "the quantity returned")
    assert failed[:-1] == [k, None]
    assert fine == [len(UNFIT), 1, None]
    assert found.failed == 1


def test_exception_of_any_class_fails_the_point_and_no_other():
    found = sweep(SMALL, {"k": range(len(RAISED) + 1)}, functions.raising, Immediate(), batch_size=20)
    assert found.failed == len(RAISED)
    errors = [row[-1] for row in found.rows()]
    assert errors[0] == r"ValueError: two lines\x1b[1m"
    assert errors[1:5] == ["SilentError", "Stop: now", "SystemExit: 3", "GeneratorExit:"]
    assert errors[-1] is None


def test_columns_are_those_of_all_points_in_the_order_of_the_grid(shuffled):
    found = sweep(SMALL, {"k": range(4)}, functions.columns_that_differ, shuffled, batch_size=1)
    assert list(found.csv()) == ["k,even,odd,error", "0,0,,", "1,,1,", "2,2,,", "3,,3,"]


def test_none_and_nan_are_different_cells(tmp_path):
    files = [tmp_path / "map.csv", tmp_path / "map.parquet"]
    found = sweep(SMALL, {"k": range(3)}, functions.undefined, Immediate(), files)
    assert files[0].read_text() == "k,v,error\n0,1.5,\n1,,\n2,nan,\n"
    stored = pyarrow.parquet.read_table(files[1]).column("v").to_pylist()
    assert stored[:2] == [1.5, None]
    assert math.isnan(stored[2])
    assert np.isnan(found.column("v")).tolist() == [False, True, True]


# Points that fail


def test_dragon_that_does_not_fit_is_a_row_with_the_reason_and_exit_code_1(here, call):
    flags = ["--turns", "5", "--workers", "1", "-o", "map.csv"]
    code, out, err = call("sweep", *flags, "--axis", "benches=10,1,4", "--quantity", "sweep_functions:total")
    assert (code, err) == (1, "pymunk-dragon: 1 of 3 points failed; the column error has the reasons\n")
    assert "3 points of sweep_functions:total over benches, 1 failed" in out
    lines = (here / "map.csv").read_text().splitlines()
    assert lines[:2] == ["benches,total,benches_of_march,error", "10,0.0,10,"]
    assert re.fullmatch(r'1,,,"?benches is 1, but must be a whole number .*"?', lines[2])
    assert lines[3] == "4,0.0,4,"
    assert names(here) == ["map.csv"]


# Files


@pytest.mark.parametrize("lines", [1, 100])
def test_parquet_has_the_values_of_the_csv(tmp_path, lines):
    files = [tmp_path / "map.csv", tmp_path / "map.parquet"]
    axes = {"x": np.linspace(0, 1, lines), "n": [1, 2], "pitch": [0.2, 0.5]}
    found = sweep(SMALL, axes, functions.total, Immediate(), files)
    assert found.failed == 2 * lines
    stored = pyarrow.parquet.read_table(files[1])
    kinds = {field.name: str(field.type) for field in stored.schema}
    assert kinds == {
        "x": "double",
        "n": "int64",
        "pitch": "double",
        "total": "double",
        "benches_of_march": "int64",
        "error": "string",
    }
    with files[0].open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row, cells in zip(rows, stored.to_pylist(), strict=True):
        assert {name: "" if cell is None else str(cell) for name, cell in cells.items()} == row


def test_parquet_column_of_several_types_loses_nothing_that_a_number_can_hold(tmp_path):
    path = tmp_path / "map.parquet"
    sweep(SMALL, {"k": range(3)}, functions.mixed, Immediate(), path)
    stored = pyarrow.parquet.read_table(path)
    assert stored.column("v").to_pylist() == [float(2**62 + 1), 0.5, None]
    assert stored.column("w").to_pylist() == ["1", "text", "True"]


def test_program_prints_json_or_nothing_but_the_table_whatever_functions_print(here):
    program = [sys.executable, "-m", "pymunk_dragon", "sweep", *FLAGS, "--axis", "k=0:3:1", "--workers", "1"]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    given = {"capture_output": True, "text": True, "timeout": 60, "env": environment}
    done = subprocess.run([*program, "--quantity", "sweep_functions:printing", "--json"], **given)
    assert done.returncode == 0
    assert "printed by the quantity\n" in done.stderr
    assert "printed by a program\n" in done.stderr
    told = json.loads(done.stdout)
    assert set(told) == {"points", "failed", "resumed", "seconds"}
    assert (told["points"], told["failed"], told["resumed"]) == (4, 0, 0)
    assert 0 < told["seconds"] < 60
    assert names(here) == []


def undisturbed(path, **options):
    """Bytes of a table of failing and other points."""
    axes = {"pitch": [0.1, 0.5, 0.55], "x": [0.1 * x for x in range(20)], "n": [1, 2]}
    sweep(SMALL, axes, functions.total, out=path, **options)
    return path.read_bytes()


@pytest.mark.parametrize("batch_size", [None, 1, 7, 4096])
def test_table_is_the_same_for_all_sizes_of_batches_and_executors(tmp_path, threads, batch_size):
    expected = undisturbed(tmp_path / "immediate.csv", executor=Immediate())
    assert undisturbed(tmp_path / "threads.csv", executor=threads, batch_size=batch_size) == expected


@pytest.mark.parametrize(
    "options",
    [
        {"workers": 1},
        pytest.param({"workers": 2}, marks=pytest.mark.thorough),
        pytest.param({"workers": 2, "batch_size": 1}, marks=pytest.mark.thorough),
        pytest.param({"scheduler": "local", "workers": 2}, marks=pytest.mark.thorough),
    ],
    ids=str,
)
def test_table_is_the_same_from_processes_and_dask(tmp_path, options):
    expected = undisturbed(tmp_path / "immediate.csv", executor=Immediate())
    assert undisturbed(tmp_path / "other.csv", **options) == expected


# Batches


def test_batches_have_the_given_number_of_points():
    executor = Immediate()
    sweep(SMALL, {"x": range(17)}, functions.total, executor, batch_size=5)
    assert executor.sizes == [5, 5, 5, 2]


def test_batches_grow_with_quick_points_and_cover_all_points_once():
    executor = Immediate()
    sweep(SMALL, {"x": range(80), "y": range(3)}, functions.total, executor)
    assert executor.sizes[0] == 1
    assert max(executor.sizes) > 20
    assert sum(executor.sizes) == 240
    assert executor.sizes[-1] < max(executor.sizes)


def test_no_more_batches_are_in_flight_than_workers_can_use(shuffled):
    sweep(SMALL, {"x": range(30)}, functions.total, shuffled, batch_size=1)
    assert 3 <= shuffled.most_waiting <= 6
    with Shuffled() as other:
        sweep(SMALL, {"x": range(30)}, functions.total, other, batch_size=1, workers=1)
        assert other.most_waiting <= 2


def test_batch_ends_early_when_its_points_become_slow(monkeypatch):
    monkeypatch.setattr(evaluation, "LONGEST_BATCH", 0.05)
    told = []
    axes = {"x": range(60)}
    found = sweep(SMALL, axes, functions.slow_at_the_end, Immediate(), progress=lambda *counts: told.append(counts))
    assert found.column("v").tolist() == list(range(60))
    # Two points a batch, and two batches at a time, although there were batches of ten before.
    assert max(b - a for (a, _), (b, _) in pairwise(told) if a >= 44) <= 4


def test_progress_counts_to_the_number_of_points(shuffled):
    told = []
    sweep(SMALL, {"x": range(30)}, functions.total, shuffled, progress=lambda *counts: told.append(counts))
    assert told == sorted(told)
    assert told[-1] == (30, 30)
    assert {total for _, total in told} == {30}


MEMORY = """
import resource, sys
import sweep_functions
from pymunk_dragon.sweeps import computation, sweep
# Without a march at each point, which takes a millisecond.
computation.evaluate = lambda task, points: ([({"v": sum(point)}, None) for point in points], 1e-5 * len(points))
found = sweep(sweep_functions.SMALL, {"x": range(int(sys.argv[1])), "y": range(1000)}, sweep_functions.total,
              sweep_functions.Immediate(), "map.csv")
print(found.points, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""


@pytest.mark.thorough
def test_memory_grows_by_few_bytes_a_point(tmp_path):
    def peak(rows):
        done = subprocess.run(
            [sys.executable, "-c", MEMORY, str(rows)],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(Path(__file__).parent)},
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        )
        points, memory = map(int, done.stdout.split())
        assert points == rows * 1000
        return memory

    # Each point has a place of 8 bytes in an array, which is copied when it grows.
    assert peak(200) - peak(20) < 180_000 * 16 + 8e6


# Refinement


def refined(quantity, axes, count, **options):
    found = sweep(SMALL, axes, quantity, Immediate(), refine=count, **options)
    rows = [tuple(row) for row in found.rows()]
    first = math.prod(map(len, axes.values()))
    assert len(set(rows)) == len(rows) <= first + count
    return rows[:first], rows[first:]


SQUARE = {"x": np.linspace(-1, 1, 9), "y": np.linspace(-1, 1, 9)}


@pytest.mark.thorough
def test_new_points_lie_at_a_circle_and_locate_it():
    step = 0.25
    old, new = refined(functions.in_circle, SQUARE, 700)
    assert [row[:2] for row in old] == list(product(SQUARE["x"], SQUARE["y"]))
    assert len(new) > 300
    for x, y, *_ in new:
        assert abs(math.hypot(x, y) - 0.7) <= math.sqrt(2) * step
    # Three times halved, wherever one looks: a cell of that size has both sides.
    for angle in np.linspace(0, 2 * math.pi, 100):
        at = 0.7 * np.array([math.cos(angle), math.sin(angle)])
        for status in ("in", "out"):
            distances = [math.dist(at, row[:2]) for row in old + new if row[3] == status]
            assert min(distances) <= math.sqrt(2) * step / 8


def test_new_points_lie_at_a_diagonal():
    old, new = refined(functions.below_diagonal, SQUARE, 150)
    assert len(new) > 75
    for x, y, *_ in new:
        assert abs(y - x - 0.1) / math.sqrt(2) <= math.sqrt(2) * 0.25
    near = [row for row in old + new if abs(row[1] - row[0] - 0.1) < 0.05]
    assert len(near) > len(new) / 4


def test_boundary_on_one_axis_is_bisected():
    old, new = refined(functions.beyond, {"x": [0.0, 1.0, 2.0, 3.0]}, 20)
    assert len(new) == 20
    low = max(x for x, status, _ in old + new if status == "before")
    high = min(x for x, status, _ in old + new if status == "beyond")
    assert high - low == 2.0**-20


@pytest.mark.thorough
def test_boundary_of_three_axes_is_found():
    axes = dict.fromkeys("xyz", np.linspace(-1, 1, 5))
    _, new = refined(functions.in_ball, axes, 900)
    assert len(new) > 450
    for *point, _, _ in new:
        assert abs(math.hypot(*point) - 0.7) <= math.sqrt(3) * 0.5
    assert len({row[-2] for row in new}) == 2


def test_axis_of_whole_numbers_is_divided_down_to_them():
    _, new = refined(functions.many, {"n": [0, 100]}, 50)
    assert all(type(row[0]) is int for row in new)
    assert {37, 38} <= {row[0] for row in new}
    assert len(new) <= 8
    _, new = refined(functions.many, {"n": [30, 40], "x": [0.0, 4.0]}, 100)
    assert all(type(row[0]) is int for row in new)
    assert len({row[0] for row in new}) > 3


def test_axis_of_one_value_is_not_divided():
    _, new = refined(functions.in_circle, {"x": np.linspace(-1, 1, 5), "y": [0.3]}, 30)
    assert {row[1] for row in new} == {0.3}
    assert len(new) == 30


def test_region_without_boundary_is_not_divided():
    assert refined(functions.in_circle, {"x": [0.0, 0.1, 0.2], "y": [0.0, 0.1]}, 50)[1] == []


@pytest.mark.parametrize("count", [1, 5, 33, 100])
def test_refinement_keeps_to_its_number_of_points(count):
    _, new = refined(functions.in_circle, SQUARE, count)
    assert count / 2 <= len(new) <= count


@pytest.mark.thorough
def test_refined_points_are_the_same_whatever_the_order_of_completion(shuffled, tmp_path):
    options = {"refine": 60, "batch_size": 1}
    expected = sweep(SMALL, SQUARE, functions.in_circle, Immediate(), **options)
    found = sweep(SMALL, SQUARE, functions.in_circle, shuffled, **options)
    assert list(found.csv()) == list(expected.csv())
    # Interrupted in the grid, and in each round.
    for points in (40, 84, expected.points // 2 + 45, expected.points - 3):
        path = tmp_path / f"{points}.csv"
        with pytest.raises(KeyboardInterrupt):
            sweep(SMALL, SQUARE, functions.in_circle, Immediate(points), path, **options)
        resumed = sweep(SMALL, SQUARE, functions.in_circle, shuffled, path, resume=True, **options)
        assert points - 1 <= resumed.resumed <= points
        assert path.read_text().splitlines() == list(expected.csv())


# The journal


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

    def interrupt(self, points=4):
        """Finish this many points, whose numbers it returns, and no more."""
        with pytest.raises(KeyboardInterrupt):
            self.run(Immediate(points))
        finished = [json.loads(line)[0] for line in self.journal.read_bytes().splitlines()[1:]]
        assert len(finished) == points
        self.log.write_text("")
        return finished

    def evaluated(self):
        return sorted(map(float, self.log.read_text().split()))


@pytest.fixture
def case(tmp_path):
    return Case(tmp_path)


@pytest.fixture
def expected(tmp_path_factory):
    whole = Case(tmp_path_factory.mktemp("whole"))
    whole.run()
    return whole.out.read_bytes()


def test_journal_is_removed_when_the_table_is_written(case, expected):
    case.run()
    assert case.out.read_bytes() == expected
    assert names(case.out.parent) == ["map.csv"]


def test_interrupted_sweep_says_how_many_points_are_kept(case):
    with pytest.raises(KeyboardInterrupt, match=r"4 of 6 points are in .*map.csv.journal"):
        case.run(Immediate(4))
    assert names(case.out.parent) == ["map.csv.journal"]


def test_sweep_without_a_finished_point_leaves_no_journal(case):
    with pytest.raises(KeyboardInterrupt):
        case.run(Immediate(0))
    assert names(case.out.parent) == []


def test_journal_that_is_cut_anywhere_in_its_last_line_is_resumed(case, expected):
    finished = case.interrupt()
    content = case.journal.read_bytes()
    finished = [json.loads(line)[0] for line in content.splitlines()[1:]]
    last = content.rindex(b"\n", 0, -1) + 1
    for end in range(last, len(content) + 1):
        case.journal.write_bytes(content[:end])
        case.log.write_text("")
        kept = 4 if end == len(content) else 3
        # In another order than before: the bytes that were cut off are not those that are written.
        with Shuffled(end) as executor:
            assert case.run(executor, resume=True).resumed == kept
        assert case.evaluated() == sorted(set(X["x"]) - set(finished[:kept]))
        assert case.out.read_bytes() == expected
        assert names(case.out.parent) == ["map.csv"]


def test_journal_that_is_cut_in_its_first_line_begins_anew(case, expected):
    case.interrupt()
    first = case.journal.read_bytes().partition(b"\n")[0]
    for end in (0, 1, 2, 30, len(first) // 2, len(first) - 1, len(first)):
        for resume in (False, True):
            case.journal.write_bytes(first[:end])
            assert case.run(resume=resume).resumed == 0
            assert case.out.read_bytes() == expected


def test_longer_first_line_of_an_earlier_sweep_is_not_read_again(case, expected):
    # As of a sweep that was killed before its first point, of so many values that the file is a screen long.
    journal = Journal(case.journal, {"axis": {"x": list(range(500))}}, resume=False)
    journal.close()
    assert case.run().points == 6
    assert case.out.read_bytes() == expected


def test_interrupted_sweep_is_resumed_from_any_number_of_points(case, expected):
    for points in (2, 4):
        finished = case.interrupt(points)
        assert case.run(resume=True).resumed == points
        assert case.evaluated() == sorted(set(X["x"]) - set(finished))
        assert case.out.read_bytes() == expected


def test_whole_journal_without_a_table_needs_no_point(case, expected, monkeypatch):
    def full(path, columns, rows):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pymunk_dragon.sweeps.result.WRITERS", {".csv": full})
    with pytest.raises(DragonError, match=r"No space left.*6 of 6 points are in"):
        case.run()
    monkeypatch.undo()
    case.log.write_text("")
    assert case.run(Immediate(0), resume=True).resumed == 6
    assert case.evaluated() == []
    assert case.out.read_bytes() == expected


def test_resume_without_a_journal_is_a_new_sweep(case, expected):
    assert case.run(resume=True).resumed == 0
    assert case.out.read_bytes() == expected


def test_points_that_failed_are_finished(case):
    axes = {"k": range(4)}
    with pytest.raises(KeyboardInterrupt):
        sweep(SMALL, axes, functions.raising, Immediate(2), case.out, batch_size=1)
    found = sweep(SMALL, axes, functions.raising, Immediate(), case.out, resume=True)
    assert (found.resumed, found.failed) == (2, 4)


def test_existing_journal_is_not_lost_without_resume(case):
    case.interrupt()
    content = case.journal.read_bytes()
    with pytest.raises(ParameterError) as error:
        case.run()
    assert_says(Exception(str(error.value).replace(str(case.out.parent), "")), "4 finished points", "resume")
    assert case.journal.read_bytes() == content


DAMAGED = [
    b"garbage",
    b"",
    b"{}",
    b"[1,{}]",
    b'["1",{},null]',
    b"[1.0,{},null]",
    b"[1,5,null]",
    b"[1,null,5]",
    b"[-1,{},null]",
    b"[2000000000,{},null]",
    b"\xff\xfe",
    b"[" * 5000,
]


@pytest.mark.parametrize("line", DAMAGED, ids=lambda line: repr(line[:12]))
def test_damage_in_the_middle_of_a_journal_is_named_by_its_line(case, line):
    case.interrupt()
    lines = case.journal.read_bytes().split(b"\n")
    lines[2] = line
    case.journal.write_bytes(b"\n".join(lines))
    for resume in (True, False):
        with pytest.raises(FileFormatError, match="line 3 is damaged"):
            case.run(resume=resume)
    assert case.journal.read_bytes() == b"\n".join(lines)


@pytest.mark.parametrize("content", [b"my notes\n", b"my notes", b"\x00\x01", b"{\n}\n", b"{]\n[]\n"])
def test_file_that_is_no_journal_is_left_alone(case, content):
    case.journal.write_bytes(content)
    for resume in (True, False):
        with pytest.raises(FileFormatError, match="not a journal of a sweep"):
            case.run(resume=resume)
    assert case.journal.read_bytes() == content


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"scenario": {"width": 0.25}}, ["scenario width was 0.3, but is 0.25"]),
        ({"scenario": {"pause": 0.5}}, ["scenario pause was null, but is 0.5"]),
        ({"axes": {"x": [*X["x"], 9.0]}}, ["axis x was [0.0, ", "but is [0.0, "]),
        ({"axes": {"x": X["x"], "pause": [0.0]}}, ["axis pause was null, but is [0.0]"]),
        ({"axes": {"x": [0.0, 8.0]}, "samples": 4}, ["axis x was"]),
        ({"axes": {"x": range(1000)}}, ["axis x was", "1000 values from 0.0 to 999.0"]),
        ({"quantity": "sweep_functions:sleeping", "scenario": {"log": None}}, ["quantity name was", "sleeping"]),
        ({"refine": 5}, ["refine was 0, but is 5"]),
    ],
)
def test_other_sweep_is_not_resumed_and_the_change_is_named(case, changed, words):
    case.interrupt()
    content = case.journal.read_bytes()
    scenario = {**SMALL, "log": str(case.log), **changed.get("scenario", {})}
    scenario = {name: value for name, value in scenario.items() if value is not None}
    with pytest.raises(FileFormatError, match="of another sweep") as error:
        case.run(resume=True, **changed | {"scenario": scenario})
    for word in words:
        assert word in str(error.value)
    assert case.journal.read_bytes() == content
    assert case.evaluated() == []


def test_samples_are_resumed_only_with_their_seed_and_number(tmp_path):
    given = {"axes": {"x": [0.0, 1.0]}, "quantity": functions.total, "out": tmp_path / "map.csv", "batch_size": 1}
    with pytest.raises(KeyboardInterrupt):
        sweep(SMALL, samples=8, executor=Immediate(4), **given)
    for changed, words in (
        ({"samples": 9}, "axis samples was 8, but is 9"),
        ({"samples": 8, "seed": 1}, "axis seed was 0, but is 1"),
        ({"samples": 8, "sampling": "random"}, 'axis sampling was "sobol", but is "random"'),
    ):
        with pytest.raises(FileFormatError, match=words):
            sweep(SMALL, executor=Immediate(), resume=True, **changed, **given)
    assert sweep(SMALL, samples=8, executor=Immediate(), resume=True, **given).resumed == 4


def test_order_of_the_axes_is_part_of_a_sweep(tmp_path):
    path = tmp_path / "map.csv"
    axes = {"x": [0.0, 1.0], "y": [0.0, 1.0]}
    with pytest.raises(KeyboardInterrupt):
        sweep(SMALL, axes, functions.total, Immediate(2), path, batch_size=1)
    with pytest.raises(FileFormatError, match="the order of the axes differs"):
        sweep(SMALL, dict(reversed(axes.items())), functions.total, Immediate(), path, resume=True)


@pytest.mark.parametrize("quantity", ["max-speed", "sweep_functions:total"])
def test_order_of_the_values_of_a_scenario_is_not(tmp_path, quantity):
    path = tmp_path / "map.csv"
    scenario = {"benches": 4, "overhang": 0.2} | ({"x": 1, "y": 2} if ":" in quantity else {})
    axes = {"width": [0.2, 0.25, 0.3]}
    with pytest.raises(KeyboardInterrupt):
        sweep(scenario, axes, quantity, Immediate(2), path, batch_size=1)
    assert sweep(dict(reversed(scenario.items())), axes, quantity, Immediate(), path, resume=True).resumed == 2


def test_other_source_of_a_function_and_other_version_are_not_resumed(case, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    source = tmp_path / "changed_quantity.py"
    source.write_text("def f(march, *, x: float):\n    return {'v': x}\n")
    given = {"scenario": SMALL, "axes": X, "quantity": "changed_quantity:f", "out": case.out, "batch_size": 1}
    with pytest.raises(KeyboardInterrupt):
        sweep(executor=Immediate(2), **given)
    text = source.read_text()
    source.write_text(text.replace("x}", "-x}"))
    with pytest.raises(FileFormatError, match=r"quantity source was .*, but is"):
        sweep(executor=Immediate(), resume=True, **given)
    source.write_text(text)
    with monkeypatch.context() as other:
        for module in (plan, evaluation):
            other.setattr(module, "program_version", lambda: "9.9")
        with pytest.raises(FileFormatError, match=r'version was .*, but is "9\.9"'):
            sweep(executor=Immediate(), resume=True, **given)
    assert sweep(executor=Immediate(), resume=True, **given).resumed == 2


def test_worker_of_another_version_is_an_error(monkeypatch):
    monkeypatch.setattr(plan, "program_version", lambda: "9.9")
    with pytest.raises(DragonError, match=r"a worker has version .*, but the sweep 9.9"):
        sweep(SMALL, X, functions.total, Immediate())


def test_two_sweeps_do_not_write_one_table(case, expected):
    refused = []

    def second(done, total):
        if done == 2:
            for resume in (False, True):
                with pytest.raises(ParameterError, match="a table of no other running sweep") as error:
                    case.run(resume=resume)
                refused.append(error.value)

    case.run(progress=second)
    assert len(refused) == 2
    assert case.out.read_bytes() == expected
    assert case.evaluated() == X["x"]


def test_journal_that_was_removed_before_it_was_locked_is_not_used(tmp_path, monkeypatch):
    import fcntl

    path = tmp_path / "map.csv.journal"
    lock = fcntl.flock

    def late(descriptor, operation):
        # The sweep that had the file ends in between.
        path.unlink()
        lock(descriptor, operation)

    monkeypatch.setattr("pymunk_dragon.sweeps.journal.fcntl.flock", late)
    with pytest.raises(ParameterError, match="a table of no other running sweep"):
        Journal(path, {}, resume=False)


def test_results_of_many_sweeps_leave_no_file_open(tmp_path):
    folder = Path("/proc/self/fd")
    if not folder.exists():
        pytest.skip("has no /proc, which lists the open files")
    before = len(names(folder))
    for i in range(20):
        sweep(SMALL, {"x": [1.0]}, functions.total, Immediate(), tmp_path / "map.csv" if i % 2 else None)
    assert len(names(folder)) <= before + 2


def test_result_can_be_read_when_its_journal_is_gone(case, tmp_path):
    found = case.run()
    assert column(table(found), "square") == [str(x * x) for x in X["x"]]
    found.write(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == case.out.read_bytes()
    assert str(found).startswith("6 points of sweep_functions:logged over x")
    assert found.to_dict() == {"points": 6, "failed": 0, "resumed": 0, "seconds": found.seconds}


def test_executor_that_was_closed_is_an_error():
    executor = ThreadPoolExecutor(1)
    executor.shutdown()
    with pytest.raises(DragonError, match="shutdown"):
        sweep(SMALL, X, functions.total, executor)


# Time limits in threads


@pytest.mark.parametrize("quantity", [functions.spinning, functions.ignoring])
def test_point_that_exceeds_its_time_in_a_thread_fails_alone(threads, quantity):
    found = sweep(SMALL, X, quantity, threads, timeout=1.0)
    errors = [row[-1] for row in found.rows()]
    assert errors == [None] * 3 + ["takes longer than the time limit of 1 s"] + [None] * 2


def test_batches_that_wait_for_their_turn_are_not_too_late(monkeypatch, threads):
    # The last point waits for two batches that take longer than its time limit and the grace together.
    monkeypatch.setattr(computation, "GRACE", 0.05)
    monkeypatch.setattr(computation, "POLL", 0.1)
    scenario, axes = {**SMALL, "pause": 0.06}, {"x": range(40, 121)}
    found = sweep(scenario, axes, functions.slow_at_the_end, threads, timeout=2.0, batch_size=40)
    assert found.failed == 0


def test_time_limit_that_comes_at_the_end_of_a_point_harms_no_other(threads):
    def work():
        for _ in range(400):
            with contextlib.suppress(evaluation._TimeIsUp), evaluation.time_limit(0.001):
                end = time.perf_counter() + random.uniform(0.0008, 0.0012)
                while time.perf_counter() < end:
                    pass
        # An exception that is still to come would come within this time.
        for _ in range(30):
            time.sleep(0.01)
        return "unharmed"

    assert threads.submit(work).result(timeout=60) == "unharmed"
    assert not [thread for thread in threading.enumerate() if thread.name.endswith("(expire)")]


def test_quantities_have_names_columns_and_summaries():
    assert set(QUANTITIES) == {
        "contact-time",
        "nearest-gap",
        "min-pitch",
        "max-speed",
        "engine-contact-time",
        "engine-error",
    }
    for quantity in QUANTITIES.values():
        assert quantity.summary
        assert not set(quantity.columns) & (set(quantity.parameters) | {"error"})


@pytest.mark.thorough
def test_pool_of_the_users_is_neither_closed_nor_changed():
    from multiprocessing import get_context

    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert sweep(SMALL, X, functions.total, pool).failed == 0
        assert pool.submit(math.sqrt, 4.0).result() == 2.0
