"""Reports: every run in every format, nothing lost, nothing taken for markup, the same bytes every time."""

from __future__ import annotations

import csv
import io
import json
import re
import sys
import zipfile
from base64 import b64decode
from collections import Counter
from dataclasses import asdict, replace
from html.parser import HTMLParser
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import openpyxl
import pytest
from browser import needs_browser, opened
from conftest import DATA, assert_says, examples
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from marches import ARM, TRACTOR, U_TURN
from markdown_it import MarkdownIt
from sharing import shared

from pymunk_dragon._language import in_language
from pymunk_dragon.errors import MissingExtraError, OutputError, ParameterError, UnreachableError
from pymunk_dragon.model.contact import ContactLog
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate
from pymunk_dragon.reports import (
    REPORT_ENDINGS,
    json_schema,
    markdown_report,
    report,
    summarize,
    summary,
    tables,
    write_contact_table,
    write_tables,
    xlsx_report,
)
from pymunk_dragon.reports.html_report import html
from pymunk_dragon.reports.markdown_report import markdown

# Like the seed's 223 benches, these meet as 0 and 8; the head passes 9 and 11 on the way.
SMALL = March(Dragon(benches=16), turns=8)
# Texts that some format would make something of.
HOSTILE = [
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "=HYPERLINK(1)",
    "+1",
    "-1",
    "@SUM(A1)",
    "a|b",
    "[x](javascript:alert(1))",
    "*a* _b_ `c` ~~d~~ \\| # e",
    "line\nbreak\r\n| --- |",
    "{{ 7 * 7 }} {% raw %}",
    "]]> --> </style></title>",
    "nul \0 bell \a half \ud800",
    "&lt; &amp; &#x3c;",
    "龙头",
    "",
]


def hostile(run):
    labels = {text_: text_ for text_ in HOSTILE} | {"list": HOSTILE, "deep": {"er": {"still": HOSTILE[0]}}}
    return replace(run, provenance={"player": HOSTILE[0], "versions": {HOSTILE[1]: HOSTILE[2]}} | labels)


RUNS = {
    "contact and after": lambda run: run,
    "first contact": lambda run: simulate(SMALL, start=79.0),
    "no contact": lambda run: replace(run, events=ContactLog(), first_contact=None, outcome="clear"),
    "end of the curve": lambda run: replace(run, events=ContactLog(), first_contact=None, outcome="unreachable"),
    "unknown drift": lambda run: replace(run, drift=np.full_like(run.drift, np.nan)),
    "partly unknown drift": lambda run: replace(run, drift=np.where(run.drift > 1e-4, np.nan, run.drift)),
    "nobody on the path": lambda run: replace(run, provenance={**run.provenance, "guide": "none"}),
    "nothing known": lambda run: Run(march=SMALL, times=[1], poses=SMALL.at([1]).poses, drift=np.zeros((1, 16))),
    "exact": lambda run: Run.exact(SMALL, np.arange(5.0)),
    "exact, with a contact": lambda run: Run.exact(SMALL, np.arange(79.0, 83.0)),
    "exact, one frame before the start": lambda run: Run.exact(SMALL, [-3.5]),
    "hostile labels": hostile,
}


def contents(run):
    return summarize(run).to_dict()


def as_markdown(run):
    return markdown(summarize(run))


@pytest.fixture
def written(small_run):
    """A function that gives the bytes of the report on one of `RUNS`, written once for all tests."""
    return lambda name, ending: shared(
        f"report, {name}{ending}", lambda path: report(RUNS[name](small_run), path)
    ).read_bytes()


class Page(HTMLParser):
    """Elements, attributes and texts of a page; fails where tags do not pair up."""

    ALONE = frozenset({"meta", "link", "img", "br"})

    def __init__(self, source):
        super().__init__()
        self.open, self.elements, self.texts, self.addresses = [], [], [], []
        self.feed(source)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.addresses += [value for name, value in attributes if name in ("src", "href", "xlink:href", "srcset")]
        assert not any(name.startswith("on") for name, _ in attributes)
        if tag not in self.ALONE:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)

    def of(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


def check_csv(content, run, found):
    """A table with a row for all that happened."""
    heads, *rows = csv.reader(io.StringIO(content, newline=""), strict=True)
    assert content.count("\r\n") == content.count("\n") == len(rows) + 1
    assert heads[:4] == ["time_s", "what", "bench_i", "bench_j"]
    assert {len(row) for row in rows} <= {len(heads)}
    what = Counter(row[1] for row in rows)
    assert what == Counter(event.phase for event in run.events) + Counter(
        near_miss=len(found["near_misses"] or ()),
        first_contact=int(found["first_contact"] is not None),
        exact_contact=int(found["exact"] is not None and found["exact"]["status"] == "contact"),
    )
    times = [float(row[0] or "inf") for row in rows]
    assert times == sorted(times)


def check_markdown(content):
    """No markup but the report's own."""
    tokens = MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"]).parse(content)
    inline = [child for token in tokens for child in token.children or ()]
    assert {token.type for token in inline} <= {"text", "text_special", "softbreak"}
    blocks = {token.type.removesuffix("_open").removesuffix("_close") for token in tokens}
    assert blocks <= {"heading", "paragraph", "table", "thead", "tbody", "tr", "th", "td", "inline"}
    # A row with too few or too many cells would be filled up or cut, and its text be lost.
    for line in content.splitlines():
        assert not line.startswith("|") or len(re.findall(r"(?<!\\)(?:\\\\)*\|", line)) >= 3
    headings = [tokens[i + 1].content for i, token in enumerate(tokens) if token.tag == "h2" and token.nesting == 1]
    assert len(headings) == 7


def check_page(content):
    """Whole, without scripts, and reaching for nothing."""
    found = Page(content)
    assert found.of("script") == []
    assert all(address.startswith("data:") for address in found.addresses)
    assert "url(" not in content
    assert "@import" not in content
    assert found.of("meta")[1]["content"].startswith("default-src 'none'")
    assert "nan" not in " ".join(found.texts).split()
    for picture in found.of("img"):
        assert b64decode(picture["src"].partition(",")[2]).startswith(b"\x89PNG")


def check_workbook(content, run, found):
    """All rows, and no formula."""
    book = openpyxl.load_workbook(io.BytesIO(content))
    assert book.sheetnames == ["Summary", "Near misses", "Events", "Windows", "Handles", "Drift"]
    assert {cell.data_type for sheet in book for row in sheet.rows for cell in row} <= {"s", "n"}
    assert book["Events"].max_row == len(run.events) + 1
    assert book["Windows"].max_row == len(run.events.windows()) + 1
    assert book["Drift"].max_row == len(found["drift"]["times"]) + 1
    assert len(book["Summary"]._images) == (2 if found["first_contact"] else 1)


QUICK = ("contact and after", "hostile labels", "exact")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.thorough] * (name not in QUICK)) for name in RUNS]
)
def test_report_on_any_run_is_whole_in_every_format(name, small_run, written):
    run = RUNS[name](small_run)
    found = contents(run)
    assert json.loads(written(name, ".json"), parse_constant=pytest.fail) == found
    Draft202012Validator(json_schema()).validate(found)
    check_csv(written(name, ".csv").decode(), run, found)
    check_markdown(written(name, ".md").decode())
    check_page(written(name, ".html").decode())
    check_workbook(written(name, ".xlsx"), run, found)


def test_report_on_the_same_run_has_the_same_bytes(small_run, written, tmp_path):
    small_run.save(tmp_path / "run.npz")
    again = replace(Run.load(tmp_path / "run.npz"), wall_seconds=3.0)
    for ending in REPORT_ENDINGS:
        steps = []
        report(again, tmp_path / f"again{ending}", progress=lambda *step, steps=steps: steps.append(step))
        assert (tmp_path / f"again{ending}").read_bytes() == written("contact and after", ending)
        assert steps == [(done, len(steps)) for done in range(1, len(steps) + 1)]


def test_schema_names_the_version_and_knows_every_key():
    schema = json_schema()
    Draft202012Validator.check_schema(schema)
    assert schema["properties"]["schema"]["const"] == summary.SCHEMA == "pymunk_dragon report"
    assert schema["properties"]["version"]["const"] == summary.VERSION == 1
    assert schema["additionalProperties"] is False
    assert schema["required"] == list(schema["properties"])


def test_schema_refuses_what_is_no_report(small_run):
    changes = [
        lambda found: found.update(version=2),
        lambda found: found.update(colour="red"),
        lambda found: found.pop("drift"),
        lambda found: found["events"][0].update(benches=[1]),
        lambda found: found["events"][0].update(normal=[1.0, 0.0, 0.0]),
        lambda found: found["outcome"].update(status="victory"),
        lambda found: found["first_contact"].pop("point"),
        lambda found: found["handles"].update(contact="engine"),
    ]
    whole = json.dumps(contents(small_run))
    for i, change in enumerate(changes):
        found = json.loads(whole)
        change(found)
        assert not Draft202012Validator(json_schema()).is_valid(found), i


def test_contents_tell_the_run(small_run):
    found = contents(small_run)
    scenario = {"benches": 16, "head_spacing": 2.86, "body_spacing": 1.65, "overhang": 0.275, "width": 0.30}
    assert found["scenario"] == scenario | {"curve": "Spiral", "pitch": 0.55, "turns": 8, "speed": 1}
    assert found["player"] == "pymunk"
    assert found["settings"]["guide"] == "rails"
    assert found["versions"] == small_run.versions
    frames, events = len(small_run.times), len(small_run.events)
    assert found["outcome"] == {"status": "contact", "start": 77.5, "until": 84.5, "frames": frames, "events": events}
    assert found["first_contact"] == json.loads(json.dumps(asdict(small_run.first_contact)))
    assert found["events"] == json.loads(json.dumps([asdict(event) for event in small_run.events]))
    assert [window["benches"] for window in found["windows"]] == [[0, 8], [0, 10]]
    assert found["windows"][1]["end"] is None
    assert (found["drift"]["head"], found["drift"]["max"]) == (small_run.head_drift, small_run.max_drift)
    assert found["drift"]["max_over_time"] == small_run.drift.max(axis=1).tolist()
    worst = found["drift"]["max_at"]
    frame = small_run.times.tolist().index(worst["time"])
    assert small_run.drift[frame, worst["bench"]] == small_run.max_drift


def test_handles_are_those_of_the_papers_tables_digit_for_digit():
    def cut(value):  # to three decimals, as the paper does
        return np.trunc(np.asarray(value) * 1000) / 1000

    first, second, third = (
        np.genfromtxt(DATA / f"table{number}.csv", delimiter=",", skip_header=1) for number in (1, 2, 3)
    )
    found = contents(Run.exact(March(), [412, 413]))["handles"]
    assert found["numbers"] == [0, 1, 51, 101, 151, 201, 223]
    assert found["times"] == [0, 60, 120, 180, 240, 300, pytest.approx(412.473838, abs=1e-6)]
    positions, speeds = np.array(found["positions"]), np.array(found["speeds"])
    assert np.abs(cut(positions[:6].transpose(1, 2, 0).reshape(14, 6)) - first[:, 2:]).max() < 1e-9
    assert np.abs(cut(speeds[:6].T) - second[:, 1:]).max() < 1e-9
    assert np.abs(cut(np.column_stack([positions[6], speeds[6]])) - third[:, 1:]).max() < 1e-9


def test_handles_on_another_curve_are_told_at_times_of_the_run():
    found = contents(Run.exact(U_TURN, np.arange(-100.0, 101.0, 10)))["handles"]
    assert found["times"] == [-100, -50, 0, 50, 100]
    exact = U_TURN.at(found["times"]).positions[:, [0, 1, 30]]
    np.testing.assert_allclose(found["positions"], exact, rtol=0, atol=1e-9)


def test_scenarios_of_other_marches_are_told():
    changing = {"width": [1.8, 2.2, 1.6, 2.4], "pitch": None, "turns": None, "speed": [[0, 0.5], [5, 2], [20, 1.5]]}
    for march, scenario in (
        (U_TURN, {"radius": 4.5, "ratio": 2.0}),
        (TRACTOR, changing),
        (ARM, {"length": pytest.approx(ARM.curve.end_s)}),
        (replace(TRACTOR, speed=1.0, start_s=20.0), {"start_s": 20.0}),
        (March(speed=lambda t: 1 + np.sin(t) / 2), {"speed": None}),
    ):
        run = Run.exact(march, [0.0, 0.5])
        found = contents(run)
        Draft202012Validator(json_schema()).validate(found)
        assert {name: found["scenario"][name] for name in scenario} == scenario
        assert f"A dragon of {march.dragon.benches} benches" in as_markdown(run)


def first_said(run):
    """What a Markdown report says about the first contact, before the tables."""
    return as_markdown(run).partition("## First contact\n\n")[2].partition("\n\n")[0]


def test_lateness_of_the_run_is_that_against_the_exact_contact(small_run):
    found = contents(small_run)
    assert (found["exact"]["status"], found["exact"]["benches"]) == ("contact", [0, 8])
    assert [near["benches"] for near in found["near_misses"]] == [[0, 11]]
    assert (found["handles"]["times"][-1], found["handles"]["contact"]) == (found["exact"]["time"], "exact")
    late = 1e3 * (small_run.first_contact.time - found["exact"]["time"])
    assert f"{abs(late):.3f} ms {'late' if late > 0 else 'early'}" in first_said(small_run)
    assert "| closest near miss, benches 0 and 11 | 0.865 mm |" in as_markdown(small_run)


def test_contact_that_the_run_missed_or_has_alone_is_told(small_run):
    answer = "benches 0 and 8 touch at 80.691318 s"
    missed = replace(small_run, first_contact=None, events=ContactLog(), outcome="clear")
    other = replace(small_run, first_contact=replace(small_run.first_contact, benches=(0, 9)))
    for run in (missed, other):
        assert answer in first_said(run)
        assert "against the exact" not in as_markdown(run)
    off = simulate(SMALL, guide="none", until=30.0)
    assert contents(off)["exact"]["time"] <= 30.0
    assert "No guide kept this dragon on its path" in first_said(off)
    assert "against the exact" not in as_markdown(off)


def test_csv_brings_every_number_back(small_run, written):
    rows = list(csv.DictReader(io.StringIO(written("contact and after", ".csv").decode(), newline="")))
    miss, *contacts = rows[:3]
    callbacks = rows[3:]
    first, exact = sorted(contacts, key=lambda row: row["what"], reverse=True)
    assert [row["what"] for row in (miss, first, exact)] == ["near_miss", "first_contact", "exact_contact"]
    assert 0.0008 < float(miss["gap_m"]) < 0.0009
    assert float(first["time_s"]) == small_run.first_contact.time
    assert float(exact["time_s"]) == pytest.approx(small_run.first_contact.time, abs=1e-3)
    for row, event in zip(callbacks, small_run.events, strict=True):
        assert (float(row["time_s"]), row["what"]) == (event.time, event.phase)
        assert (int(row["bench_i"]), int(row["bench_j"])) == event.benches
        for name, vector in {
            "normal_{}": event.normal,
            "relative_velocity_{}_m_s": event.relative_velocity,
            "impulse_{}_N_s": event.impulse,
            "point1_{}_m": event.points[0] if event.points else None,
            "point2_{}_m": event.points[1] if len(event.points) > 1 else None,
        }.items():
            cells = [row[name.format(axis)] for axis in "xy"]
            assert cells == (["", ""] if vector is None else [str(part) for part in vector])
        assert row["depth_m"] == ("" if event.depth is None else str(event.depth))


def test_long_tables_are_cut_and_say_how_many_rows_there_are(small_run, monkeypatch):
    count = len(small_run.events)
    monkeypatch.setattr(tables, "MAX_SHOWN_ROWS", 100)
    for content in (as_markdown(small_run), html(summarize(small_run))):
        assert f"first 100 of {count} rows" in content
        assert len(re.findall(r"(?:begin|pre\\?_solve|separate)(?= \||</td>)", content)) == 100


def test_hostile_labels_are_shown_as_they_are(written):
    printable = [label.translate(summary.UNPRINTABLE) for label in HOSTILE]
    texts = Page(written("hostile labels", ".html").decode()).texts
    assert all(label in texts for label in printable if label)
    found = json.loads(written("hostile labels", ".json"))
    assert (found["settings"]["list"], found["player"]) == (printable, HOSTILE[0])
    book = written("hostile labels", ".xlsx")
    cells = {
        cell.value: cell.data_type for row in openpyxl.load_workbook(io.BytesIO(book))["Summary"].rows for cell in row
    }
    assert all(cells[label] == "s" for label in printable if label)
    with zipfile.ZipFile(io.BytesIO(book)) as archive:
        assert not [name for name in archive.namelist() if b"<f>" in archive.read(name) and "chart" not in name]


@given(st.text(max_size=60))
@examples(200)
def test_markdown_gives_any_text_back_as_text(label):
    row = markdown_report._row((label, "end"))
    tokens = MarkdownIt("commonmark").enable("table").parse(f"| a | b |\n| --- | --- |\n{row}\n")
    cells = [tokens[i + 1] for i, token in enumerate(tokens) if token.type == "td_open"]
    assert len(cells) == 2
    assert {child.type for child in cells[0].children} <= {"text", "text_special"}
    shown = "".join(child.content for child in cells[0].children)
    assert shown.split() == label.replace("\0", "\N{REPLACEMENT CHARACTER}").split()


def test_interrupted_report_leaves_the_old_file_and_no_litter(small_run, tmp_path, monkeypatch):
    for i, ending in enumerate(REPORT_ENDINGS):
        file = tmp_path / f"report{ending}"
        file.write_bytes(b"old")
        failure = OSError(28, "No space left on device") if i % 2 else KeyboardInterrupt()
        writer = (xlsx_report, "_add_drift_chart") if ending == ".xlsx" else (Path, "write_bytes")
        with monkeypatch.context() as patch:
            patch.setattr(*writer, Mock(side_effect=failure))
            with pytest.raises(OutputError if i % 2 else KeyboardInterrupt):
                report(small_run, file)
        assert [path.name for path in tmp_path.iterdir()] == [file.name]
        assert file.read_bytes() == b"old"
        file.unlink()
    # So do the contest's tables.
    file = tmp_path / "table.xlsx"
    file.write_bytes(b"old")

    def stop(done, total):
        if done == 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_tables(SMALL, [0, 1], file, progress=stop)
    assert file.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [file]


def test_report_to_an_impossible_place_is_refused(small_run, tmp_path):
    for name in ("report", "report.pdf", "report.npz", "none/report.html", "."):
        with pytest.raises(ParameterError, match="output is") as caught:
            report(small_run, tmp_path / name)
        assert_says(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_missing_library_is_named(small_run, tmp_path, monkeypatch):
    for library in ("jinja2", "xlsxwriter"):
        monkeypatch.setitem(sys.modules, library, None)
    with monkeypatch.context() as patch:
        patch.setattr("pymunk_dragon.reports.summarize", None)
        for ending in (".html", ".xlsx"):
            with pytest.raises(MissingExtraError, match=r"pip install 'pymunk-dragon\[report\]'"):
                report(small_run, tmp_path / f"report{ending}")
    with pytest.raises(MissingExtraError, match="XLSX"):
        write_tables(SMALL, [0], tmp_path / "table.xlsx")
    assert list(tmp_path.iterdir()) == []


def read_sheet(file, name):
    """First row, first column and the numbers between them."""
    heads, *rows = openpyxl.load_workbook(file)[name].iter_rows(values_only=True)
    assert heads[0] is None
    return list(heads[1:]), [row[0] for row in rows], np.array([row[1:] for row in rows])


def assert_six_decimals(found, wanted):
    assert found.dtype == float
    assert np.array_equal(found, np.round(wanted, 6))
    assert not np.any(np.signbit(found) & (found == 0))


def test_first_contest_table_is_the_templates(seed_march, tmp_path):
    rows = []
    write_tables(seed_march, np.arange(0, 301, 25), tmp_path / "result1.xlsx", progress=lambda *row: rows.append(row))
    states = seed_march.at(np.arange(0, 301, 25))
    assert openpyxl.load_workbook(tmp_path / "result1.xlsx").sheetnames == ["位置", "速度"]
    heads, names, places = read_sheet(tmp_path / "result1.xlsx", "位置")
    assert heads == [f"{time} s" for time in range(0, 301, 25)]
    assert names[:4] == ["龙头x (m)", "龙头y (m)", "第1节龙身x (m)", "第1节龙身y (m)"]
    assert names[-5:] == ["第221节龙身y (m)", "龙尾x (m)", "龙尾y (m)", "龙尾（后）x (m)", "龙尾（后）y (m)"]
    assert len(names) == 448
    assert_six_decimals(places[::2].T, states.positions[..., 0])
    assert_six_decimals(places[1::2].T, states.positions[..., 1])
    heads, names, speeds = read_sheet(tmp_path / "result1.xlsx", "速度")
    assert heads[-1] == "300 s"
    assert names[:2] == ["龙头 (m/s)", "第1节龙身  (m/s)"]
    assert names[-3:] == ["第221节龙身  (m/s)", "龙尾  (m/s)", "龙尾（后） (m/s)"]
    assert len(names) == 224
    assert_six_decimals(speeds.T, states.speeds)
    assert rows == [(done, 672) for done in range(1, 673)]


def test_second_contest_table_is_the_templates(seed_march, tmp_path):
    write_contact_table(seed_march, 412.4738377, tmp_path / "result2.xlsx")
    assert openpyxl.load_workbook(tmp_path / "result2.xlsx").sheetnames == ["Sheet1"]
    heads, names, values = read_sheet(tmp_path / "result2.xlsx", "Sheet1")
    assert heads == ["横坐标x (m)", "纵坐标y (m)", "速度 (m/s)"]
    assert names[:2] == ["龙头", "第1节龙身"]
    assert names[-3:] == ["第221节龙身", "龙尾", "龙尾（后）"]
    assert len(names) == 224
    states = seed_march.at([412.4738377])
    assert_six_decimals(values[:, :2], states.positions[0])
    assert_six_decimals(values[:, 2], states.speeds[0])


def test_contest_table_is_the_same_file_every_time_and_has_no_minus_zero(tmp_path):
    for name in ("a.xlsx", "b.xlsx"):
        write_tables(SMALL, [0, 1e-9], tmp_path / name)
    assert (tmp_path / "a.xlsx").read_bytes() == (tmp_path / "b.xlsx").read_bytes()
    # Handle 0 starts on the x axis and goes down: a microsecond later y is -1e-9.
    assert SMALL.at([1e-9]).positions[0, 0, 1] < 0
    _, _, places = read_sheet(tmp_path / "a.xlsx", "位置")
    assert places[1].tolist() == [0, 0]
    assert not np.signbit(places[1]).any()


def test_contest_table_of_impossible_times_leaves_nothing(tmp_path):
    for times in ([], np.zeros(16384), [0, 1000.0], [0, np.nan]):
        with pytest.raises((UnreachableError, ParameterError)) as caught:
            write_tables(SMALL, times, tmp_path / "table.xlsx")
        assert_says(caught.value)
    for time in (1000.0, np.nan):
        with pytest.raises((UnreachableError, ParameterError)):
            write_contact_table(SMALL, time, tmp_path / "table.xlsx")
    assert list(tmp_path.iterdir()) == []


def test_report_in_chinese_has_the_same_numbers_and_its_data_are_the_same(small_run, written, tmp_path):
    for ending in REPORT_ENDINGS:
        with in_language("zh"):
            report(small_run, tmp_path / f"report{ending}")
        found = [(tmp_path / f"report{ending}").read_bytes(), written("contact and after", ending)]
        if ending in (".json", ".csv"):
            assert found[0] == found[1]
        elif ending in (".md", ".html"):
            chinese, english = (re.sub("<style>.*</style>", "", each.decode(), flags=re.S) for each in found)
            assert len(re.findall("[\u4e00-\u9fff]", chinese)) > 150
            assert sorted(re.findall(r"\d+\.\d+", chinese)) == sorted(re.findall(r"\d+\.\d+", english))


LABEL = "<img src=http://127.0.0.1:9/picture onerror=alert(1)><script>alert(2)</script>"


@pytest.mark.thorough
@needs_browser
def test_report_in_a_browser_fits_the_window_and_runs_and_asks_for_nothing(browser):
    def write(path):
        run = simulate(SMALL, start=80.0, until=100.0, contacts="report")
        report(replace(run, provenance={**run.provenance, LABEL: LABEL}), path)

    address = shared("browser.html", write).as_uri()
    # A4 without its margins is 688 pixels wide.
    for media, width in (("screen", 1280), ("screen", 390), ("print", 688)):
        with opened(browser, address, width, 900, is_mobile=width < 600) as seen:
            page = seen.page
            page.emulate_media(media=media)
            assert page.evaluate("innerWidth") == width
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert seen.complaints == seen.boxes == []
            assert {url for url in seen.addresses if not url.startswith("data:")} == {address}
            sizes = page.evaluate("[...document.images].map(image => [image.naturalWidth, image.width])")
            assert [natural for natural, _ in sizes] == [880, 880]
            assert all(150 < shown <= width for _, shown in sizes)
            # A label with markup is shown as text.
            assert LABEL in page.evaluate("document.querySelector('#provenance').textContent")
            assert page.evaluate("document.scripts.length") == 0
