"""The program as people and scripts use it."""

from __future__ import annotations

import csv
import itertools
import json
import math
import os
import pty
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import openpyxl
import psutil
import pytest
from conftest import assert_says, not_under_coverage
from PIL import Image

from pymunk_dragon.cli.options import SCENARIO_OPTIONS
from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.scenario import Scenario

PROGRAM = [sys.executable, "-m", "pymunk_dragon"]
SHORT = ["--from", "412.3"]
DATA = Path(__file__).parent / "data"


@pytest.fixture
def complaint(call):
    """Call the program with bad input: what it says, once it is sure that it was one line and exit code 2."""

    def complained(*arguments):
        code, out, err = call(*arguments)
        assert code == 2
        assert out == ""
        assert err.endswith("\n")
        assert_says(Exception(err[:-1]), "pymunk-dragon: ")
        return err

    return complained


# positions


def test_positions_prints_the_papers_table(call):
    code, out, err = call("positions")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert len(lines) == 1 + 6 * 7
    assert lines[1].split() == ["0", "0", "8.800000", "0.000000", "1.000000"]
    assert lines[-1].split()[:2] == ["300", "223"]


def test_positions_json_holds_positions_by_time_and_handle(call):
    code, out, _ = call("positions", "--times", "0,60", "--handles", "0,223", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["times"] == [0, 60]
    assert found["handles"] == [0, 223]
    states = March().at([0, 60])
    assert found["positions"] == states.positions[:, [0, 223]].tolist()
    assert found["speeds"] == states.speeds[:, [0, 223]].tolist()


def test_lists_include_both_ends(call):
    _, out, _ = call("positions", "--times", "0:1:0.1,5", "--handles", "0:3:1", "--json")
    found = json.loads(out)
    assert found["times"] == pytest.approx([*(i / 10 for i in range(11)), 5])
    assert found["handles"] == [0, 1, 2, 3]


def test_default_handles_fit_a_shorter_dragon(call):
    _, out, _ = call("positions", "--benches", "60", "--json")
    assert json.loads(out)["handles"] == [0, 1, 51, 60]


def test_positions_writes_csv_and_json_files(call, tmp_path):
    table, document = tmp_path / "p.csv", tmp_path / "p.json"
    for path in (table, document):
        assert call("positions", "--times", "0,60", "-o", path) == (0, "", "")
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert len(rows) == 14
    assert float(rows[0]["x_m"]) == March().at(0).positions[0, 0, 0]
    assert json.loads(document.read_text())["times"] == [0, 60]


# simulate, contact


def test_simulate_json_has_the_promised_keys_and_nothing_else_on_stdout(call):
    code, out, err = call("simulate", *SHORT, "--json")
    found = json.loads(out)
    assert (code, err) == (0, "")
    assert set(found["first_contact"]) == {"time", "raw_time", "benches", "point", "normal", "depth"}
    assert found["first_contact"]["benches"] == [0, 8]
    assert set(found["drift"]) == {"head", "max"}
    for key in ("substeps", "iterations", "wall_seconds", "realtime_factor", "driver_overhead"):
        assert found[key] > 0
    assert found["substeps"] == 9


def test_simulate_without_contact_says_null(call):
    _, out, _ = call("simulate", "--until", "0.2", "--json")
    found = json.loads(out)
    assert found["first_contact"] is None
    assert found["status"] == "clear"


def test_simulate_saves_a_run_and_render_films_it(call, tmp_path):
    run, film = tmp_path / "run.npz", tmp_path / "run.gif"
    code, out, err = call("simulate", *SHORT, "-o", run)
    assert (code, err) == (0, "")
    assert "benches 0 and 8" in out
    assert Run.load(run).first_contact.benches == (0, 8)
    assert call("render", run, "-o", film, "--camera", "head", "--size", "200x160", "--fps", "25") == (0, "", "")
    assert film.read_bytes()[:6] == b"GIF89a"
    assert sorted(os.listdir(tmp_path)) == ["run.gif", "run.npz"]


def test_report_mode_lists_the_contact_windows(call):
    _, out, _ = call("simulate", *SHORT, "--until", "412.6", "--contacts", "report")
    assert re.search(r"^ +0 +8 +412\.480 +the end$", out, re.MULTILINE)


def test_force_of_the_head_is_an_option_where_contacts_are_resolved(call, tmp_path):
    path = tmp_path / "run.npz"
    resolved = ["simulate", *SHORT, "--until", "412.6", "--contacts", "resolve"]
    assert call(*resolved, "--head-force", "300", "-o", path)[0] == 0
    assert Run.load(path).settings.head_force == 300
    code, _, err = call("simulate", *SHORT, "--until", "412.6", "--head-force", "300")
    assert (code, err.count("\n")) == (2, 1)


@pytest.mark.parametrize("method", ["exact", "grid", "engine"])
def test_contact_json_has_the_promised_keys(call, method):
    code, out, err = call("contact", *SHORT, "--method", method, "--json")
    found = json.loads(out)
    assert (code, err) == (0, "")
    assert {"status", "time", "benches", "point", "normal", "near_misses"} <= set(found)
    assert (found["method"], found["status"], found["benches"]) == (method, "contact", [0, 8])
    assert found["time"] == pytest.approx(412.473838, abs=2e-3)
    assert found["near_misses"] == ([] if method == "exact" else None)
    assert call("contact", *SHORT, "--method", method, "--json")[1] == out


def test_contact_is_exact_by_default_and_tells_of_near_misses(call):
    code, out, err = call("contact", "--from", "406")
    assert (code, err) == (0, "")
    assert out.splitlines()[0].startswith(
        "first contact at t = 412.473837682 s: benches 0 and 8 at (1.474395, 2.110665) m"
    )
    assert [line[:20] for line in out.splitlines()[1:]] == ["near miss at t = 406", "near miss at t = 409"]
    assert "0.865 mm apart" in out
    _, out, _ = call("contact", "--from", "406", "--json")
    misses = json.loads(out)["near_misses"]
    assert [set(miss) for miss in misses] == [{"time", "benches", "gap"}] * 2
    assert [miss["benches"] for miss in misses] == [[0, 9], [0, 11]]


def test_compare_puts_the_three_side_by_side(call, tmp_path):
    document = tmp_path / "c.json"
    code, out, err = call("contact", "--compare", "--from", "412", "--fine", "-o", document)
    assert (code, err) == (0, "")
    assert [line.split()[0] for line in out.splitlines()] == ["method", "exact", "grid", "engine"]
    exact, grid, engine = json.loads(document.read_text())["methods"]
    assert abs(grid["time"] - exact["time"]) < 1e-6
    assert abs(engine["time"] - exact["time"]) < 2e-3
    for answer in (exact, grid, engine):
        assert answer["benches"] == [0, 8]
        assert min(answer["samples"], answer["wall_seconds"]) > 0
    assert (grid["tests"] > 0, engine["tests"]) == (True, None)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--until", "10"], "no contact until t = 10 s"),
        (["--benches", "3", "--turns", "8"], "s, after which a handle has no position on the curve"),
        (["--pitch", "0.31"], "overlap at the start, t = 0.000000000 s"),
    ],
)
def test_other_endings_are_told(call, arguments, words):
    code, out, err = call("contact", *arguments)
    assert (code, err) == (0, "")
    assert words in out
    found = json.loads(call("contact", *arguments, "--json")[1])
    assert (found["time"] is None) == (found["benches"] is None) == ("no contact" in words or "no position" in words)


def test_contact_writes_the_contests_sheet(call, complaint, tmp_path):
    path = tmp_path / "result2.xlsx"
    code, _, err = call("contact", *SHORT, "-o", path)
    assert (code, err) == (0, "")
    rows = list(openpyxl.load_workbook(path)["Sheet1"].iter_rows(values_only=True))
    assert rows[0] == (None, "横坐标x (m)", "纵坐标y (m)", "速度 (m/s)")
    assert rows[1] == ("龙头", 1.209931, 1.942784, 1)
    assert len(rows) == 225
    path.unlink()
    code, out, err = call("contact", "--until", "1", "-o", path)
    assert (code, out) == (1, "")
    assert_says(Exception(err[:-1]), "no contact until t = 1 s", "result2.xlsx was not written")
    assert os.listdir(tmp_path) == []


def test_paper_tables_are_the_papers_147_numbers(call):
    code, out, err = call("positions", "--paper")
    assert (code, err) == (0, "")
    tables = [block.splitlines()[2:] for block in out.split("\n\n")]
    told = [[line.split() for line in table] for table in tables]
    papers = []
    for name in ("table1", "table2", "table3"):
        with (DATA / f"{name}.csv").open(newline="") as file:
            papers.append(list(csv.reader(file))[1:])
    assert told == papers
    names = 2 * len(papers[0]) + len(papers[1]) + len(papers[2])
    assert sum(len(row) for table in told for row in table) - names == 147


def test_fine_is_a_substep_of_two_and_a_half_millimetres_at_any_speed(call, tmp_path):
    scenario = tmp_path / "fast.toml"
    scenario.write_text("speed = 2.0\n")
    _, out, _ = call("simulate", "--scenario", scenario, "--until", "0.1", "--fine", "--json")
    found = json.loads(out)
    assert found["substep"] == pytest.approx(1 / 800)
    assert found["iterations"] == 60


def test_render_films_a_march_and_draws_a_picture(call, tmp_path):
    film, picture = tmp_path / "m.gif", tmp_path / "m.png"
    code, out, _ = call("render", "-o", film, "--until", "2", "--size", "120", "--speedup", "10", "--json")
    assert code == 0
    assert json.loads(out)["bytes"] == film.stat().st_size
    assert call("render", "-o", picture, "--until", "2", "--size", "120")[0] == 0
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_render_sets_runs_side_by_side_with_their_marks_and_words(call, tmp_path):
    run, picture = tmp_path / "r.npz", tmp_path / "p.png"
    call("simulate", *SHORT, "--until", "412.4", "-o", run)

    def size(*arguments):
        assert call("render", *arguments, "-o", picture, "--size", "120")[0] == 0
        with Image.open(picture) as image:
            return image.size, image.tobytes()

    (width, height), plain = size(run)
    assert (width, height) == (120, 120)
    (width, height), _ = size(run, run)
    assert width == 2 * 120 + 2
    (width, height), _ = size(run, "--exact", "--title", "Both", "--caption", "The engine and the exact model.")
    assert width == 2 * 120 + 2
    assert height > 120 + 60
    pictures = {plain}
    for flags in (["--velocities"], ["--impulses"], ["--grid"], ["--velocities", "--grid"]):
        pictures.add(size(run, *flags, "--camera", "head")[1])
    assert len(pictures) == 5


def test_film_of_a_march_ends_with_its_first_contact(call, tmp_path, monkeypatch):
    noted = []
    monkeypatch.setattr("pymunk_dragon.cli.render.wrote", lambda path, *facts: noted.append((path.suffix, *facts)))
    assert call("render", "--benches", "16", "-o", tmp_path / "m.gif", "--size", "64")[0] == 0
    assert call("render", "--benches", "16", "-o", tmp_path / "m.gif", "--size", "64", "--until", "60")[0] == 0
    assert call("render", "--benches", "16", "-o", tmp_path / "m.png", "--size", "64")[0] == 0
    # The last 74 s before the contact at 412.47 s.
    assert noted == [
        (".gif", "171 frames", "11.0 s", "from t = 338 s"),
        (".gif", "111 frames", "8.0 s", "from t = 0 s"),
        (".png",),
    ]


def test_render_writes_texts_in_a_language_and_with_a_legend(call, tmp_path):
    picture = tmp_path / "p.png"

    def image(*arguments):
        assert call("render", "-o", picture, "--until", "2", "--size", "320", *arguments)[0] == 0
        with Image.open(picture) as opened:
            return opened.size, opened.tobytes()

    (width, height), english = image()
    assert width == 320
    assert height > 320
    assert image("--no-legend")[0] == (320, 320)
    assert image("--lang", "zh")[1] != english


@pytest.mark.parametrize("ending", ["mp4", "apng", "webp"])
def test_render_takes_the_format_from_the_ending(call, ending, tmp_path):
    film = tmp_path / f"film.{ending}"
    assert call("render", "-o", film, "--until", "2", "--size", "120", "--fps", "30")[0] == 0
    signature = {"mp4": (4, b"ftyp"), "apng": (817, b"acTL"), "webp": (8, b"WEBPVP8X")}
    at, expected = signature[ending]
    assert film.read_bytes()[at : at + len(expected)] == expected


@pytest.fixture(scope="module")
def run_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.npz"
    Run.exact(March(Dragon(benches=16), turns=8), [79, 82]).save(path)
    return path


def test_report_tells_of_a_run_in_the_format_of_its_ending(call, run_file, tmp_path):
    page, data = tmp_path / "r.html", tmp_path / "r.json"
    assert call("report", run_file, "-o", page) == (0, "", "")
    assert "<h1>Benches 0 and 8 touch at 80.691318 s</h1>" in page.read_text(encoding="utf-8")
    code, out, err = call("report", run_file, "-o", data, "--json")
    assert (code, err) == (0, "")
    assert json.loads(out) == {"output": str(data), "bytes": data.stat().st_size}
    assert json.loads(data.read_text())["first_contact"]["benches"] == [0, 8]


def test_interrupted_report_leaves_the_old_file_and_exits_with_130(call, run_file, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    page = tmp_path / "r.html"
    page.write_text("old")
    monkeypatch.setattr("pymunk_dragon.reports.graphics.still_png", interrupted)
    code, out, err = call("report", run_file, "-o", page)
    assert (code, out, err.strip()) == (130, "", "pymunk-dragon: interrupted")
    assert os.listdir(tmp_path) == ["r.html"]
    assert page.read_text() == "old"


@pytest.mark.parametrize(("ending", "library"), [(".html", "jinja2"), (".xlsx", "xlsxwriter")])
def test_missing_extra_is_named(complaint, ending, library, run_file, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    if ending == ".xlsx":
        assert "pymunk-dragon[report]" in complaint("contact", "-o", tmp_path / "c.xlsx")
        assert "pymunk-dragon[report]" in complaint("positions", "-o", tmp_path / "p.xlsx")
    assert "pymunk-dragon[report]" in complaint("report", run_file, "-o", tmp_path / f"r{ending}")
    assert os.listdir(tmp_path) == []


def test_positions_writes_the_contests_sheets(call, tmp_path):
    path = tmp_path / "result1.xlsx"
    assert call("positions", "--benches", "4", "--times", "0:2:1", "-o", path) == (0, "", "")
    places = openpyxl.load_workbook(path)["位置"]
    heads, first, *_ = places.iter_rows(values_only=True)
    assert heads == (None, "0 s", "1 s", "2 s")
    assert first[:2] == ("龙头x (m)", 8.8)


def test_flags_win_over_the_scenario_file(call, tmp_path):
    scenario = tmp_path / "s.toml"
    scenario.write_text("benches = 16\npitch = 0.6\n")
    _, out, _ = call("positions", "--scenario", scenario, "--pitch", "0.7", "--times", "0", "--json")
    found = json.loads(out)
    assert found["handles"][-1] == 16
    assert found["positions"][0][0][0] == pytest.approx(16 * 0.7)


def test_help_tells_the_true_defaults():
    for name, (kind, _, text) in SCENARIO_OPTIONS.items():
        told, *others = text.split("[")[1].rstrip("]").split(", or ")
        curve = "u-turn" if name in ("radius", "ratio") else None
        assert kind(told) == getattr(Scenario(curve=curve), name)
        for other in others:
            value, _, curve = other.partition(" of a ")
            assert kind(value) == getattr(Scenario(curve=curve), name)


# Other curves, speeds that change, benches that differ


def test_u_turn_has_the_contests_positions(call):
    # The contest's question 4: the circle of 4.5 m is entered at 0 s.
    for times in (["--times", "-100:100:100"], ["--times=-100:100:100"]):
        code, out, _ = call("positions", "--curve", "u-turn", *times, "--handles", "0", "--json")
        found = json.loads(out)
        assert code == 0
        assert found["times"] == [-100, 0, 100]
        radii = [math.hypot(*place) for [place] in found["positions"]]
        assert radii[1] == pytest.approx(4.5, abs=1e-9)
        # Handle 0 has 100 m of spiral before it, and less of it behind the turn.
        k = 1.7 / math.tau
        before, after = (k / 2 * (u * math.hypot(u, 1) + math.asinh(u)) for u in (radii[0] / k, 4.5 / k))
        assert before - after == pytest.approx(100)
        assert radii[0] > radii[2] > 4.5


def test_first_time_may_be_negative(call, tmp_path):
    _, out, _ = call("contact", "--curve", "u-turn", "--from", "-100", "--until", "-90", "--json")
    assert json.loads(out)["status"] == "clear"
    small = ["--curve", "u-turn", "--benches", "8", "--from", "-2", "--until", "-1"]
    code, _, _ = call("simulate", *small, "-o", tmp_path / "run.npz")
    assert code == 0
    run = Run.load(tmp_path / "run.npz")
    assert run.times[[0, -1]].tolist() == [-2, -1]
    assert run.march.curve == UTurn()
    assert call("render", tmp_path / "run.npz", "-o", tmp_path / "film.gif", "--size", "120")[0] == 0
    assert call("render", *small, "-o", tmp_path / "film.gif", "--size", "120")[0] == 0
    assert call("report", tmp_path / "run.npz", "-o", tmp_path / "report.html")[0] == 0


def test_path_and_speed_may_be_files(call, tmp_path):
    path, speed = tmp_path / "path.csv", tmp_path / "speed.csv"
    path.write_text("x,y\n" + "".join(f"{10 * x},{x % 3}\n" for x in range(8)))
    speed.write_text("0,1\n10,3\n")
    _, out, _ = call(
        "positions",
        "--curve",
        path,
        "--speed",
        speed,
        "--benches",
        "4",
        "--times",
        "0,10",
        "--handles",
        "0,4",
        "--json",
    )
    found = json.loads(out)
    assert [speeds[0] for speeds in found["speeds"]] == pytest.approx([1, 3])
    # 20 m along the path are a little less than that between their ends.
    (begin, _), (end, _) = found["positions"]
    assert 19 < math.dist(begin, end) < 20


def test_sizes_of_single_benches_stand_in_a_file(call, tmp_path):
    scenario = tmp_path / "s.toml"
    scenario.write_text("body_spacing = [1.65, 3.0]\nwidth = [0.2, 0.3, 0.4]\n")
    _, out, _ = call("positions", "--scenario", scenario, "--times", "0", "--handles", "0:3:1", "--json")
    [places] = json.loads(out)["positions"]
    assert [math.dist(*pair) for pair in itertools.pairwise(places)] == pytest.approx([2.86, 1.65, 3.0])


# Bad input


@pytest.mark.parametrize("name", SCENARIO_OPTIONS)
@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "0", "-1", "1e300", "abc", ""])
def test_every_scenario_option_refuses_what_it_cannot_be(complaint, name, value):
    flag = "--" + name.replace("_", "-")
    said = complaint("positions", flag, value)
    assert name in said.replace("-", "_")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["positions", "--pitch", "0.25"], ["pitch", "0.25", "width"]),
        (["positions", "--ratio", "1"], ["--ratio is 1.0", "absent on a spiral curve; kinds with it: u-turn"]),
        (["positions", "--curve", "u-turn", "--turns", "3"], ["--turns is 3.0", "only a Spiral has turns"]),
        (["positions", "--curve", "circle"], ["--curve is 'circle'", "spiral or u-turn", ".csv"]),
        (["positions", "--curve", "nowhere.csv"], ["--curve is 'nowhere.csv'", "readable file"]),
        (["positions", "--speed", "nowhere.csv"], ["--speed is 'nowhere.csv'", "readable file"]),
        (["positions", "--speed", "fast"], ["--speed", "'fast'", "neither a number nor a file"]),
        (["contact", "--curve", "u-turn"], ["until", "a curve without end"]),
        (["simulate", "--curve", "u-turn"], ["until", "a curve without end"]),
        (["positions", "--benches", "1"], ["benches", "1", "2"]),
        (["positions", "--head-spacing", "30"], ["--head-spacing is 30.0"]),
        (["positions", "--turns", "0.2"], ["spacing"]),
        (["positions", "--times", "0:1"], ["--times is '0:1'", "0:300:1"]),
        (["positions", "--times", "1,x"], ["times", "1,x"]),
        (["positions", "--times", "nan"], ["times", "nan"]),
        (["positions", "--times", "0:1e9:0.001"], ["times"]),
        (["positions", "--times", "3:0:1"], ["times"]),
        (["positions", "--times", "443"], ["443", "handle 0"]),
        (["positions", "--handles", "224"], ["--handles is '224'", "223"]),
        (["positions", "--handles", "1.5"], ["handles", "1.5"]),
        (["positions", "--scenario", "nowhere.toml"], ["--scenario is 'nowhere.toml'"]),
        (["simulate", "--from", "441"], ["441", "handle 1"]),
        (["simulate", "--from", "2", "--until", "1"], ["--until is 1.0"]),
        (["simulate", "--from", "nan"], ["--from is nan"]),
        (["contact", "--from", "1e300"], ["--from is 1e+300"]),
        (["render", "--from", "-1e9", "-o", "film.gif"], ["--from is -1"]),
        (["render", "-o", "f.gif", "--from", "nan"], ["--from is nan"]),
        (["render", "-o", "f.gif", "--from", "5", "--until", "1"], ["--until is 1.0"]),
        (["positions", "-o", "f.txt"], ["-o is 'f.txt'"]),
        (["demo", "--lang", "fr"], ["--lang is 'fr'"]),
        (["positions", "--scenario", "/dev/zero"], ["--scenario /dev/zero: no TOML file: larger than 4 MB"]),
        (["simulate", "--guide", "ropes"], ["--guide is 'ropes'", "rails"]),
        (["simulate", "--contacts", "no"], ["--contacts is 'no'", "stop"]),
        (["simulate", "--substep", "5"], ["--substep is 5.0"]),
        (["simulate", "--iterations", "0"], ["iterations", "0"]),
        (["simulate", "--fine", "--iterations", "9"], ["--fine", "--iterations"]),
        (["render", "nowhere.npz", "-o", "f.gif"], ["nowhere.npz"]),
        (["render", "-o", "f.png", "--from", "5"], ["picture", "--from"]),
        (["render", "-o", "f.png", "--fps", "20"], ["picture", "--fps"]),
        (["render", "-o", "f.html", "--speedup", "2"], ["page", "--speedup"]),
        (["render", "-o", "f.html", "--grid"], ["page", "--grid"]),
        (["render", "-o", "f.gif", "--title", "\u677f\u51f3\u9f99"], ["title", "lacks", "\u677f"]),
        (["render", "-o", "f.gif", "--title", "x", "--font", "nowhere.ttf"], ["font", "nowhere.ttf"]),
        (["figure", "nothing", "-o", "f.png"], ["figure", "nothing", "spiral"]),
        (["figure", "collision", "-o", "f.svg"], ["f.svg", ".png"]),
        (["figure", "drift", "-o", "f.png"], ["run", "engine"]),
        (["render", "-o", "f.gif", "--exact"], ["--exact", "run"]),
        (["render", "-o", "f.gif", "--impulses"], ["--impulses must be left out", "engine"]),
        (["render", "-o", "f.gif", "--workers", "-1"], ["--workers is -1"]),
        (["render", "-o", "f.gif", "--title", "x" * 501], ["title", "500"]),
        (["render", "-o", "f.gif", "--fps", "51"], ["--fps is 51", "50"]),
        (["render", "-o", "f.gif", "--size", "big"], ["--size is 'big'"]),
        (["render", "-o", "f.gif", "--size", "1x2x3"], ["size", "1x2x3"]),
        (["render", "-o", "f.gif", "--camera", "tail"], ["--camera is 'tail'", "head"]),
        (["render", "-o", "f.gif", "--lang", "de"], ["--lang is 'de'", "en, zh"]),
        (["render", "-o", "f.gif", "--speedup", "0"], ["--speedup is 0.0"]),
        (["render", "run.npz", "--pitch", "1", "-o", "f.gif"], ["scenario"]),
        (["report", "nowhere.npz", "-o", "r.html"], ["nowhere.npz"]),
        (["report", "-o", "r.html"], ["RUN.npz"]),
        (["positions", "--handles", "0", "-o", "r.xlsx"], ["--handles"]),
        (["march"], ["march"]),
        (["positions", "--colour", "red"], ["--colour"]),
        (["contact", "--method", "guess"], ["method", "guess"]),
        (["contact", "--step", "2"], ["--step", "--method grid"]),
        (["contact", "--method", "grid", "--fine"], ["--fine", "--method engine"]),
        (["contact", "--method", "grid", "--step", "0"], ["--step is 0.0"]),
        (["contact", "--method", "grid", "--tolerance", "-1"], ["--tolerance is -1.0"]),
        (["contact", "--from", "435"], ["handle", "435"]),
        (["contact", "--from", "3", "--until", "2"], ["--until is 2.0"]),
        (["contact", "-o", "c.csv"], ["c.csv", ".xlsx"]),
        (["positions", "--paper", "--times", "3"], ["--paper", "--times"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_bad_input_is_named_in_one_line(complaint, arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = complaint(*arguments)
    for word in words:
        assert word in said
    assert os.listdir(tmp_path) == []


def test_value_of_a_scenario_file_is_named_as_it_stands_there(complaint, tmp_path):
    scenario = tmp_path / "s.toml"
    scenario.write_text("head_spacing = 30\n")
    assert "pymunk-dragon: head_spacing is 30.0, " in complaint("positions", "--scenario", scenario)
    assert "pymunk-dragon: --head-spacing is 31.0, " in complaint(
        "positions", "--scenario", scenario, "--head-spacing", "31"
    )
    (tmp_path / "v.csv").write_text("0,1\n1\n")
    assert f"--speed {tmp_path / 'v.csv'}: line 2 must" in complaint("positions", "--speed", tmp_path / "v.csv")


@pytest.mark.parametrize(
    ("command", "ending"), [("positions", ".csv"), ("contact", ".json"), ("simulate", ".npz"), ("render", ".gif")]
)
def test_output_that_cannot_be_written_is_refused_before_the_work(complaint, command, ending, tmp_path, monkeypatch):
    monkeypatch.setattr(March, "at", None)  # Any work would fail on it.
    monkeypatch.chdir(tmp_path)
    assert "nowhere" in complaint(command, "-o", f"nowhere/x{ending}")
    assert ".docx" in complaint(command, "-o", "x.docx")
    folder = Path(f"folder{ending}")
    folder.mkdir()
    assert "not a folder" in complaint(command, "-o", folder)
    assert os.listdir() == [folder.name]


def test_full_disk_is_exit_code_1_and_leaves_nothing(call, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numpy.savez_compressed", lambda *_, **__: full())
    code, out, err = call("simulate", *SHORT, "-o", tmp_path / "run.npz")
    assert (code, out) == (1, "")
    assert_says(Exception(err[:-1]), "cannot write", "No space left on device")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"GIF89a", os.urandom(200)])
def test_foreign_run_files_are_named_in_one_line(complaint, content, tmp_path):
    path = tmp_path / "run.npz"
    path.write_bytes(content)
    assert str(path) in complaint("render", path, "-o", tmp_path / "f.gif")
    assert str(path) in complaint("report", path, "-o", tmp_path / "r.html")
    assert os.listdir(tmp_path) == ["run.npz"]


# As a process


# Libraries, and parts of the standard library, that take longest to import.
DRAWING = ("PIL", "imageio", "matplotlib", "multiprocessing", "pymunk_dragon.drawing")
HEAVY = (*DRAWING, "pymunk", "scipy", "json", "tomllib", "numpy.polynomial", "pymunk_dragon.reports")
NO_NUMBERS = (*HEAVY, "numpy", "email", "importlib.metadata", "pymunk_dragon.model")


@not_under_coverage  # It imports some of these itself.
@pytest.mark.parametrize(
    ("arguments", "absent"),
    [
        ("--version", NO_NUMBERS),
        ("--help", NO_NUMBERS),
        ("contact --help", (*HEAVY, "pymunk_dragon.cli.render")),
        ("positions --times 0", (*HEAVY, "pymunk_dragon.collision", "pymunk_dragon.studies")),
        ("contact --until 1", (*HEAVY, "pymunk_dragon.studies")),
        ("sweep --help", ("PIL", "matplotlib", "pymunk", "scipy", "pymunk_dragon.drawing", "pymunk_dragon.reports")),
        ("study", HEAVY),
        ("study min-pitch --benches 30", HEAVY),
        ("simulate --until 0.01", (*DRAWING, "scipy", "matplotlib", "pymunk_dragon.studies")),
    ],
)
def test_command_imports_only_what_it_uses(arguments, absent):
    command = [sys.executable, "-X", "importtime", *PROGRAM[1:], *arguments.split()]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    imported = {line.rpartition("|")[2].strip() for line in told.splitlines() if line.startswith("import time:")}
    assert "pymunk_dragon.cli" in imported
    assert imported.isdisjoint(absent)


def test_help_names_the_commands():
    told = subprocess.run([*PROGRAM, "--help"], capture_output=True, text=True, check=True)
    for command in ("positions", "contact", "simulate", "render", "report", "sweep"):
        assert command in told.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["simulat"], ["simulat", "did you mean simulate?"]),
        (["frobnicate"], ["frobnicate", "positions"]),
        (["simulate", "--dt", "0.1"], ["--dt", "use --substep"]),
        (["simulate", "--to", "3"], ["--to", "use --until"]),
        (["demo", "99"], ["99", "1 to 15"]),
    ],
)
def test_wrong_word_gets_the_right_one(complaint, arguments, words):
    said = complaint(*arguments)
    assert all(word in said for word in words)


def test_version_has_a_short_flag(call):
    assert call("-V") == call("--version")


def test_file_without_a_name_is_named_after_the_run(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call("simulate", *SHORT, "-o", "run.npz")[0] == 0
    for command, name in ((["render", "run.npz", "--size", "64"], "run.gif"), (["report", "run.npz"], "run.html")):
        assert call(*command) == (0, "", "")
        assert Path(name).stat().st_size
    assert call("figure", "grid") == (0, "", "")
    assert Path("grid.png").stat().st_size


def test_dragon_that_overlaps_at_the_start_is_told_to(call):
    code, out, _ = call("simulate", "--benches", "60", "--pitch", "0.32")
    assert code == 0
    assert out.startswith("benches 27 and 49 overlap at the start")


def test_lesson_is_chosen_by_its_number(call):
    assert call("demo", "list") == call("demo")
    assert json.loads(call("demo", "1", "--json")[1])["lesson"] == "spiral"


def test_no_arguments_show_the_help_and_fail():
    told = subprocess.run(PROGRAM, capture_output=True, text=True)
    assert told.returncode == 2
    assert "Commands:" in told.stderr


def test_no_progress_bar_where_stderr_is_no_terminal(call):
    assert call("simulate", *SHORT)[2] == ""


def test_terminal_sees_the_simulated_time_and_the_time_left():
    mine, theirs = pty.openpty()
    command = [*PROGRAM, "simulate", "--until", "150"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=theirs) as process:
        os.close(theirs)
        seen = b""
        try:
            while part := os.read(mine, 4096):
                seen += part
        except OSError:  # Linux says so when the other side is closed.
            pass
    os.close(mine)
    assert process.returncode == 0
    assert re.search(rb"t = \d+\.\d s, 150 s at the latest .*%.*\d\d:\d\d:\d\d", seen)


def test_ctrl_c_leaves_no_file_and_exits_with_130(tmp_path):
    path = tmp_path / "run.npz"
    path.write_bytes(b"old")
    command = [*PROGRAM, "simulate", "-o", str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(3)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert (out, err.strip()) == ("", "pymunk-dragon: interrupted")
    assert os.listdir(tmp_path) == ["run.npz"]
    assert path.read_bytes() == b"old"


def test_closed_pipe_is_no_traceback():
    command = " ".join(PROGRAM) + " positions --times 0:300:0.1 | head -1"
    told = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert told.stdout.startswith("     t (s)")
    assert told.stderr == ""


# Films by several processes, and by FFmpeg

LONG_FILM = [*PROGRAM, "render", "--until", "400", "--speedup", "0.5", "--size", "640", "--workers", "1"]


def members(session):
    """Numbers of the processes of a session that still run."""
    found = subprocess.run(["ps", "-s", str(session), "-o", "pid=,stat="], capture_output=True, text=True).stdout
    return [int(pid) for pid, state in map(str.split, found.splitlines()) if not state.startswith("Z")]


def all_gone(session):
    """Wait a while until no process of a session is left."""
    for _ in range(100):
        if not members(session):
            return True
        time.sleep(0.1)
    return False


def helper_of(session):
    """Number of the other process that draws, once there is one."""
    for _ in range(1000):
        found = subprocess.run(["pgrep", "-s", str(session), "-f", "spawn_main"], capture_output=True, text=True)
        if found.stdout:
            return int(found.stdout.split()[-1])
        time.sleep(0.01)
    raise AssertionError("no other process was started")


@pytest.fixture
def filming(tmp_path):
    """A long film that is being made, in a session of its own and by two processes; and the other one's number."""
    if shutil.which("pgrep") is None:
        pytest.skip("no pgrep (Debian's procps) to find the other processes with")
    with subprocess.Popen(
        [*LONG_FILM, "-o", str(tmp_path / "film.gif")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        yield process, helper_of(process.pid)


# Seconds after the start of the other process, which at first loads what it needs.
@pytest.mark.thorough
@pytest.mark.parametrize("patience", [0.0, 0.15, 2.0])
def test_ctrl_c_ends_all_processes_of_a_film_with_one_line(filming, tmp_path, patience):
    process, _ = filming
    time.sleep(patience)
    # A terminal sends it to all of them.
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err.strip()) == (130, "", "pymunk-dragon: interrupted")
    assert list(tmp_path.iterdir()) == []
    assert all_gone(process.pid)


@pytest.mark.thorough
def test_processes_of_a_film_do_not_outlive_the_one_that_asked_for_them(filming):
    process, helper = filming
    time.sleep(2.0)
    assert helper in members(process.pid)
    process.kill()
    process.communicate(timeout=60)
    assert all_gone(process.pid)


@pytest.mark.thorough
def test_a_film_whose_other_process_was_ended_fails_with_one_line(filming, tmp_path):
    process, helper = filming
    # It draws: its imports take less.
    while psutil.Process(helper).cpu_times().user < 3.0:
        time.sleep(0.1)
    os.kill(helper, signal.SIGKILL)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (1, "")
    assert_says(Exception(err[:-1]), "pymunk-dragon: ", "ended from outside")
    assert list(tmp_path.iterdir()) == []


def test_a_film_takes_no_more_processes_than_have_work(call, tmp_path, monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(96)))
    assert call("render", "-o", tmp_path / "film.gif", "--until", "1", "--size", "64") == (0, "", "")


@not_under_coverage
def test_a_video_that_does_not_fit_on_the_disk_leaves_the_old_one(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"old")
    # All of such a short film is written at its very end.
    command = ["bash", "-c", 'ulimit -f 30; exec "$@"', "-", *PROGRAM, "render", "-o", str(path), "--until", "6"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert_says(Exception(ended.stderr[:-1]), "pymunk-dragon: cannot write ")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_video_without_a_usable_ffmpeg_names_the_extra(complaint, tmp_path, monkeypatch):
    monkeypatch.setattr("imageio_ffmpeg.get_ffmpeg_exe", lambda: str(tmp_path / "nothing"))
    assert "pymunk-dragon[mp4]" in complaint("render", "-o", tmp_path / "film.mp4")
    assert list(tmp_path.iterdir()) == []
