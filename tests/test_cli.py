"""The program as people and scripts use it."""

import csv
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import openpyxl
import pytest
from conftest import DATA, assert_one_line
from PIL import Image

from pymunk_dragon import Dragon, March, Run, Scenario, render
from pymunk_dragon.cli import render as command
from pymunk_dragon.cli.options import SCENARIO_OPTIONS
from pymunk_dragon.drawing.figures import FIGURES
from pymunk_dragon.reports.contest_tables import paper_tables

SHORT = ["--from", "412.3"]


@pytest.fixture
def answer(call):
    """Call the program, which succeeds: its JSON object, or what it prints otherwise."""

    def answered(*arguments):
        code, out, err = call(*arguments)
        assert (code, err) == (0, ""), arguments
        return json.loads(out) if "--json" in arguments else out

    return answered


# positions


def test_positions_are_those_of_7_handles_each_minute_to_300_s(answer):
    _, *rows = [line.split() for line in answer("positions").splitlines()]
    assert len(rows) == 6 * 7
    assert rows[0] == ["0", "0", "8.800000", "0.000000", "1.000000"]
    assert rows[-1][:2] == ["300", "223"]


def test_positions_are_the_exact_models(answer):
    found = answer("positions", "--times", "0,60", "--handles", "0,223", "--json")
    states = March().at([0, 60])
    assert found["positions"] == states.positions[:, [0, 223]].tolist()
    assert found["speeds"] == states.speeds[:, [0, 223]].tolist()


def test_lists_of_times_have_both_ends_and_handles_are_those_of_the_dragon(answer):
    found = answer("positions", "--benches", "60", "--times", "0:1:0.1,5", "--json")
    assert found["times"] == pytest.approx([*(i / 10 for i in range(11)), 5])
    assert found["handles"] == [0, 1, 51, 60]


def test_positions_are_written_as_a_table(answer, tmp_path):
    table = tmp_path / "p.csv"
    assert answer("positions", "--times", "0,60", "-o", table) == ""
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert len(rows) == 14
    assert float(rows[0]["x_m"]) == March().at(0).positions[0, 0, 0]


def test_positions_are_written_as_json(answer, tmp_path):
    document = tmp_path / "p.json"
    assert answer("positions", "--times", "0,60", "-o", document) == ""
    assert json.loads(document.read_text())["times"] == [0, 60]


def test_positions_are_written_as_the_contests_sheet(answer, tmp_path):
    sheet = tmp_path / "p.xlsx"
    assert answer("positions", "--benches", "4", "--times", "0:2:1", "-o", sheet) == ""
    heads, first, *_ = openpyxl.load_workbook(sheet)["位置"].iter_rows(values_only=True)
    assert heads == (None, "0 s", "1 s", "2 s")
    assert first[:2] == ("龙头x (m)", 8.8)


@pytest.mark.parametrize("lang", ["en", "zh"])
def test_positions_are_written_as_tables_for_latex(answer, tmp_path, lang):
    file = tmp_path / "p.tex"
    times = [0, 1, 2, 3, 4, 5, 6]
    chosen = ["--times", "0:6:1", "--handles", "0,223"]
    assert answer("positions", *chosen, "--lang", lang, "-o", file) == ""
    states = March().at(times)
    # Six columns of times and then one, each with its positions and its speeds.
    tables = re.findall(
        r"\\begin{longtable}{@{}l\*{(\d)}{r}@{}}\n(.*?)\\end{longtable}",
        file.read_text(encoding="utf-8"),
        re.DOTALL,
    )
    assert [int(columns) for columns, _ in tables] == [6, 6, 1, 1]
    for (columns, body), quantity in zip(
        tables, 2 * [states.positions, states.speeds], strict=True
    ):
        head, rows = re.search(r"\\toprule\n(.*?)\\midrule.*\\endfoot\n(.*)", body, re.S).groups()
        shown = [int(time) for time in re.findall(r"(\d+)\\,s", head)]
        assert len(shown) == int(columns)
        values = [
            [float(cell.strip("$ \\")) for cell in row.split("&")[1:]] for row in rows.splitlines()
        ]
        expected = quantity[shown][:, [0, 223]].reshape(len(shown), -1).T
        np.testing.assert_allclose(values, expected, rtol=0, atol=5.01e-7)


def test_paper_tables_are_the_papers_numbers(answer):
    papers = []
    for name in ("table1", "table2", "table3"):
        with (DATA / f"{name}.csv").open(newline="") as file:
            papers.append(list(csv.reader(file))[1:])

    def rows(shown):
        return [[line.split() for line in block.splitlines()[2:]] for block in shown.split("\n\n")]

    assert rows(answer("positions", "--paper")) == papers
    # Its third table is that of one moment: a millisecond before or later it has other digits.
    for near in (412.472838, 412.474838):
        first, second, third = rows(paper_tables(March(), near))
        assert first == papers[0]
        assert second == papers[1]
        assert third != papers[2]


def test_scenario_comes_from_files_and_flags_win(answer, tmp_path):
    scenario = tmp_path / "s.toml"
    path = tmp_path / "path.csv"
    speed = tmp_path / "speed.csv"
    scenario.write_text("benches = 16\npitch = 0.6\n")
    found = answer("positions", "--scenario", scenario, "--pitch", "0.7", "--times", "0", "--json")
    assert found["handles"][-1] == 16
    assert found["positions"][0][0][0] == pytest.approx(16 * 0.7)
    path.write_text("x,y\n" + "".join(f"{10 * x},{x % 3}\n" for x in range(8)))
    speed.write_text("0,1\n10,3\n")
    files = ["--curve", path, "--speed", speed, "--benches", "4"]
    found = answer("positions", *files, "--times", "0,10", "--handles", "0,4", "--json")
    assert [speeds[0] for speeds in found["speeds"]] == pytest.approx([1, 3])
    assert 19 < math.dist(found["positions"][0][0], found["positions"][1][0]) < 20


def test_u_turn_has_the_contests_positions(answer):
    # The contest's question 4: the circle of 4.5 m is entered at 0 s.
    for times in (["--times", "-100:100:100"], ["--times=-100:100:100"]):
        found = answer("positions", "--curve", "u-turn", *times, "--handles", "0", "--json")
        assert found["times"] == [-100, 0, 100]
        radii = [math.hypot(*place) for [place] in found["positions"]]
        assert radii[1] == pytest.approx(4.5, abs=1e-9)
        assert radii[0] > radii[2] > 4.5
    assert (
        answer("contact", "--curve", "u-turn", "--from", "-100", "--until", "-90", "--json")[
            "status"
        ]
        == "clear"
    )
    found = answer(
        "simulate", "--curve", "u-turn", "--benches", "8", "--from", "-2", "--until", "-1", "--json"
    )
    assert found["start"] == -2
    assert found["until"] == -1


def test_help_tells_the_true_defaults(answer):
    for name, (kind, text) in SCENARIO_OPTIONS.items():
        assert kind(text.split("[")[1].rstrip("]")) == Scenario().values()[name]
    shown = " ".join(answer("positions", "--help").split())
    for name, curves in {
        "pitch": ("spiral", "u-turn"),
        "radius": ("u-turn",),
        "ratio": ("u-turn",),
    }.items():
        for curve in curves:
            assert f"[{Scenario(curve=curve).values()[name]:g} of a {curve}]" in shown


# contact, simulate


def test_contact_is_the_same_by_three_methods(answer, tmp_path):
    document = tmp_path / "c.json"
    for method, tolerance, misses in (
        ("exact", 1e-6, []),
        ("grid", 1e-6, None),
        ("engine", 2e-3, None),
    ):
        found = answer("contact", *SHORT, "--method", method, "--json", "-o", document)
        assert found == json.loads(document.read_text())
        assert {"status", "time", "benches", "point", "normal", "near_misses"} <= set(found)
        assert found["method"] == method
        assert found["status"] == "contact"
        assert found["benches"] == [0, 8]
        assert found["time"] == pytest.approx(412.473838, abs=tolerance)
        assert (found["near_misses"], found["samples"] > 0) == (misses, True)


def test_contact_tells_of_near_misses_and_other_endings(answer):
    lines = answer("contact", "--from", "406").splitlines()
    assert "t = 412.473837682 s: benches 0 and 8 at (1.474395, 2.110665) m" in lines[0]
    assert [line[:20] for line in lines[1:]] == ["near miss at t = 406", "near miss at t = 409"]
    assert "0.865 mm" in lines[2]
    misses = answer("contact", "--from", "406", "--json")["near_misses"]
    assert [set(miss) for miss in misses] == [{"time", "benches", "gap"}] * 2
    assert [miss["benches"] for miss in misses] == [[0, 9], [0, 11]]
    for arguments, words, touch in (
        ("--until 10", "no contact until t = 10 s", False),
        ("--benches 3 --turns 3", "no position on the curve", False),
        ("--pitch 0.31", "overlap at the start, t = 0.000000000 s", True),
    ):
        assert words in answer("contact", *arguments.split())
        found = answer("contact", *arguments.split(), "--json")
        assert [found["time"] is not None, found["benches"] is not None] == [touch, touch]


def test_contact_writes_the_contests_sheet(answer, call, tmp_path):
    path = tmp_path / "result2.xlsx"
    answer("contact", *SHORT, "-o", path)
    rows = list(openpyxl.load_workbook(path)["Sheet1"].iter_rows(values_only=True))
    assert rows[0] == (None, "横坐标x (m)", "纵坐标y (m)", "速度 (m/s)")
    assert rows[1] == ("龙头", 1.209931, 1.942784, 1)
    assert len(rows) == 225
    path.unlink()
    code, out, err = call("contact", "--until", "1", "-o", path)
    assert code == 1
    assert out == ""
    assert_one_line(err, "no contact until t = 1 s", "result2.xlsx")
    assert os.listdir(tmp_path) == []


def test_simulated_run_is_told_saved_and_filmed(answer, here):
    found = answer("simulate", *SHORT, "--json", "-o", "run.npz")
    assert set(found["first_contact"]) == {
        "time",
        "raw_time",
        "benches",
        "point",
        "normal",
        "depth",
    }
    assert found["first_contact"]["benches"] == [0, 8]
    assert set(found["drift"]) == {"head", "max"}
    assert all(
        found[key] > 0
        for key in ("iterations", "wall_seconds", "realtime_factor", "driver_overhead")
    )
    assert found["substeps"] == 9
    assert Run.load("run.npz").first_contact.benches == (0, 8)
    # A file without a name has that of the run.
    assert answer("render", "run.npz", "--camera", "head", "--size", "80x64", "--fps", "25") == ""
    assert Path("run.gif").read_bytes()[:6] == b"GIF89a"
    assert sorted(os.listdir()) == ["run.gif", "run.npz"]


def test_contacts_of_a_simulation_are_reported_or_resolved(answer, here):
    small = ["--benches", "16", "--turns", "8", "--from", "80.5", "--until", "81"]
    out = answer("simulate", *small, "--contacts", "report")
    assert re.search(r"^ +0 +8 +80\.700 +the end$", out, re.MULTILINE)
    answer("simulate", *small, "--contacts", "resolve", "--head-force", "300", "-o", "run.npz")
    assert Run.load("run.npz").settings.head_force == 300
    given = ["--substep", "0.01", "--iterations", "60"]
    found = answer("simulate", "--benches", "9", "--until", "0.2", *given, "--json")
    assert found["first_contact"] is None
    assert found["status"] == "clear"
    assert found["substep"] == 0.01
    assert found["iterations"] == 60
    assert "benches 27 and 49 overlap at the start" in answer(
        "simulate", "--benches", "60", "--pitch", "0.32"
    )


# render, report, figure


@pytest.mark.parametrize(
    ("ending", "begin"), [("gif", b"GIF89a"), ("webp", b"RIFF"), ("png", b"\x89PNG\r\n\x1a\n")]
)
def test_render_takes_the_format_from_the_ending(answer, tmp_path, ending, begin):
    path = tmp_path / f"film.{ending}"
    options = ["--size", "120"]
    if ending != "png":
        options += ["--fps", "10", "--speedup", "10"]
    found = answer("render", "--until", "2", *options, "-o", path, "--json")
    assert found["bytes"] == path.stat().st_size
    assert path.read_bytes().startswith(begin)


def test_render_writes_a_page_and_report_reports_in_html_and_json(answer, here):
    Run.exact(March(Dragon(benches=16), turns=8), [79, 82]).save("run.npz")
    assert answer("render", "run.npz", "-o", "page.html") == ""
    assert Path("page.html").read_bytes().startswith(b"<!doctype html>")
    assert answer("report", "run.npz") == ""
    content = Path("run.html").read_text(encoding="utf-8")
    assert "Benches 0 and 8 touch at 80.691318 s</h1>" in content
    assert answer("report", "run.npz", "-o", "r.json", "--json")["output"] == "r.json"
    assert json.loads(Path("r.json").read_text())["first_contact"]["benches"] == [0, 8]


def test_size_of_a_film_that_is_not_the_one_given_is_said(call, here):
    small = ["render", "--benches", "5", "--until", "1", "--fps", "2", "--speedup", "1"]
    code, out, err = call(*small, "--size", "121x77", "-o", "f.mp4")
    assert code == 0
    assert out == ""
    assert err.count("\n") == 1
    assert "120 x 76" in err
    for arguments in (["--size", "120x76", "-o", "f.mp4"], ["--size", "121x77", "-o", "f.gif"]):
        assert call(*small, *arguments) == (0, "", "")


def test_film_that_loses_a_row_by_the_height_of_its_texts_says_its_size(call, here):
    small = [
        "render",
        "--benches",
        "5",
        "--until",
        "1",
        "--fps",
        "2",
        "--speedup",
        "1",
        "--size",
        "120x76",
    ]
    losses = set()
    for texts in ([], ["--title", "T"], ["--caption", "C"], ["--title", "T", "--caption", "C"]):
        _, _, err = call(*small, *texts, "-o", "f.mp4")
        call(*small, *texts, "-o", "f.gif")
        with Image.open("f.gif") as picture:
            drawn = picture.size
        written = iio.immeta("f.mp4")["size"]
        assert (f"{written[0]} x {written[1]} " in err) == (written != drawn) == bool(err)
        losses.add(written != drawn)
    assert losses == {True, False}


def test_render_sets_runs_side_by_side_with_their_marks_and_words(answer, small_run, tmp_path):
    run, picture = tmp_path / "r.npz", tmp_path / "p.png"
    small_run.save(run)

    def drawn(*arguments):
        answer("render", "--size", "120", *arguments, "-o", picture)
        with Image.open(picture) as image:
            return image.size, image.tobytes()

    size, plain = drawn(run)
    assert size == (120, 120)
    assert drawn(run, run)[0][0] == 2 * 120 + 2
    (width, height), _ = drawn(
        run, "--exact", "--title", "Both", "--caption", "The engine and the exact model."
    )
    assert width == 2 * 120 + 2
    assert height > 120 + 60
    pictures = {plain}
    for flags in (["--velocities"], ["--forces"], ["--grid"], ["--velocities", "--grid"]):
        pictures.add(drawn(run, *flags, "--camera", "head")[1])
    assert len(pictures) == 5
    assert (
        drawn(run, "--size", "320", "--no-legend")[0] != drawn(run, "--size", "320", "--legend")[0]
    )


@pytest.mark.thorough
def test_film_of_a_march_ends_with_its_first_contact(answer, tmp_path, monkeypatch):
    timings = []

    def recorded(*given):
        timings.append(render(*given))
        return timings[-1]

    monkeypatch.setattr(command, "render_film", recorded)
    for path in (tmp_path / "m.gif", tmp_path / "m.png"):
        answer("render", "--benches", "16", "--size", "64", "-o", path)
    # The last 74 s before the contact at 412.47 s, in 11 s.
    assert timings[0].times[[0, -1]] == pytest.approx([338.2, 412.5], abs=0.5)
    assert len(timings[0].times) == 171
    assert timings[0].ends[-1] == pytest.approx(11.0, abs=0.1)
    assert timings[1].times.tolist() == timings[0].times[-1:].tolist()


def test_figure_has_a_name_and_the_language_of_a_flag_or_the_environment(answer, here, monkeypatch):
    assert [*answer("figure", "--json")["figures"]] == [*FIGURES]
    answer("figure", "inward")
    answer("figure", "inward", "--lang", "zh", "-o", "flag.png")
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    answer("figure", "inward", "-o", "environment.png")
    english, flag, environment = (
        Path(f"{name}.png").read_bytes() for name in ("inward", "flag", "environment")
    )
    assert flag == environment != english


@pytest.mark.thorough
def test_pdf_has_the_same_bytes_in_each_process(tmp_path):
    for lang in ("en", "zh"):
        contents = set()
        for seed in ("1", "2"):
            file = tmp_path / f"{seed}.pdf"
            command = [
                sys.executable,
                "-m",
                "pymunk_dragon",
                "figure",
                "speeds",
                "--lang",
                lang,
                "-o",
                str(file),
            ]
            subprocess.run(command, check=True, env=os.environ | {"PYTHONHASHSEED": seed})
            contents.add(file.read_bytes())
        [content] = contents
        assert content.startswith(b"%PDF")
        assert (b"NotoSansSC" in content) == (lang == "zh")
