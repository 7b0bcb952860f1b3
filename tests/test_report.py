"""Reports of all runs and formats: complete, escaped, the same bytes every time."""

import csv
import io
import json
import re
import sys
from dataclasses import asdict, replace
from itertools import chain
from xml.etree import ElementTree

import numpy as np
import openpyxl
import pytest
from browser import needs_browser, opened
from conftest import examples, refusal
from hypothesis import given
from hypothesis import strategies as st
from marches import ARM, TRACTOR, U_TURN
from markdown_it import MarkdownIt
from sharing import shared

from pymunk_dragon import ContactLog, Dragon, March, Run, pull, report, simulate
from pymunk_dragon._language import in_language
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.reports import document, formats, summarize, write_contact_table, write_tables
from pymunk_dragon.reports.formats import FORMATS

# Like the paper's 223 benches, these meet as 0 and 8; the head passes 9 and 11 on the way.
SMALL = March(Dragon(benches=16), turns=8)
# Texts that some format would make something of.
HOSTILE = [
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "a|b",
    "[x](javascript:alert(1))",
]
HOSTILE += [
    "*a* _b_ `c` ~~d~~ \\| # e",
    "line\nbreak\r\n| --- |",
    "{{ 7 * 7 }} {% raw %}",
    "]]> --> </style></title>",
]
HOSTILE += ["half \ud800", "&lt; &amp; &#x3c;", "龙头", ""]
LABELLED = {
    "player": HOSTILE[0],
    "versions": {HOSTILE[1]: HOSTILE[2]},
    "list": HOSTILE,
    "deep": {"er": HOSTILE},
}
RUNS = {
    "contact and after": lambda run: run,
    "first contact": lambda run: simulate(SMALL, start=79.0),
    "no contact": lambda run: replace(
        run, events=ContactLog(), first_contact=None, outcome="unreachable"
    ),
    "unknown drift": lambda run: replace(run, drift=np.where(run.drift > 1e-4, np.nan, run.drift)),
    "nobody on the path": lambda run: replace(run, provenance={**run.provenance, "free_from": 1}),
    "nothing known": lambda run: Run(
        march=SMALL, times=[1], poses=SMALL.at([1]).poses, drift=np.zeros((1, 16))
    ),
    "pulled": lambda run: pull(SMALL, until=4),
    "exact": lambda run: Run.exact(SMALL, np.arange(5.0)),
    "exact, with a contact": lambda run: Run.exact(SMALL, np.arange(79.0, 83.0)),
    "hostile labels": lambda run: replace(
        run, provenance={label: label for label in HOSTILE} | LABELLED
    ),
}
KEYS = [
    "schema",
    "version",
    "scenario",
    "player",
    "settings",
    "versions",
    "outcome",
    "first_contact",
    "exact",
]
KEYS += ["near_misses", "events", "windows", "drift"]
OTHERS = set(RUNS) - {"contact and after", "hostile labels", "exact"}


@pytest.fixture
def written(small_run):
    """A function that gives the file of the report on one of `RUNS`, written once for all tests."""
    return lambda name, ending: shared(
        f"report, {name}{ending}", lambda path: report(RUNS[name](small_run), path)
    )


def elements_of(page):
    """All elements of a page; an error where tags do not pair up."""
    closed = re.sub(r"<((?:meta|link|img)\b[^>]*)>", r"<\1/>", page.removeprefix("<!doctype html>"))
    return [*ElementTree.fromstring(closed).iter()]


def check_csv(content, run, found):
    """A row for all that happened, in the order of time."""
    rows = list(csv.DictReader(io.StringIO(content, newline=""), strict=True))
    contacts = [found["first_contact"], found["exact"] and found["exact"]["status"] == "contact"]
    assert len(rows) == len(run.events) + len(found["near_misses"] or ()) + sum(map(bool, contacts))
    assert content.count("\r\n") == content.count("\n") == len(rows) + 1
    assert [float(row["time_s"]) for row in rows] == sorted(float(row["time_s"]) for row in rows)


def check_markdown(content, sections):
    """No markup but the report's own, and so many sections."""
    tokens = (
        MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"]).parse(content)
    )
    assert {child.type for token in tokens for child in token.children or ()} <= {
        "text",
        "text_special",
        "softbreak",
    }
    blocks = {token.type.removesuffix("_open").removesuffix("_close") for token in tokens}
    assert blocks <= {"heading", "paragraph", "table", "thead", "tbody", "tr", "th", "td", "inline"}
    # A row with too few or too many cells would be filled up or cut, and its text be lost.
    for line in content.splitlines():
        assert not line.startswith("|") or len(re.findall(r"(?<!\\)(?:\\\\)*\|", line)) >= 3
    assert content.count("\n## ") == sections


def check_page(content):
    """Whole, without scripts, and reaching for nothing; gives whether it has a chart."""
    found = elements_of(content)
    assert "script" not in {each.tag for each in found}
    assert not [name for each in found for name in each.attrib if name.startswith("on")]
    [policy] = [each.attrib["content"] for each in found if "http-equiv" in each.attrib]
    assert policy == "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    addresses = [
        each.attrib[name]
        for each in found
        for name in ("src", "href", "srcset")
        if name in each.attrib
    ]
    assert all(address.startswith("data:") for address in addresses)
    assert "nan" not in " ".join(found[0].itertext()).split()
    kinds = [each.attrib["src"].partition(";")[0] for each in found if "src" in each.attrib]
    pictures = ["data:image/png"] * 2
    assert kinds in (pictures, [*pictures, "data:image/svg+xml"])
    return len(kinds) > 2


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.thorough] * (name in OTHERS)) for name in RUNS]
)
def test_report_on_any_run_is_whole_in_every_format(name, small_run, written):
    run = RUNS[name](small_run)
    found = summarize(run).to_dict()
    assert json.loads(written(name, ".json").read_bytes(), parse_constant=pytest.fail) == found
    check_csv(written(name, ".csv").read_bytes().decode(), run, found)
    # Near misses are those of benches on the path.
    check_markdown(written(name, ".md").read_text(), 6 - run.is_pulled)
    assert check_page(written(name, ".html").read_text()) == (
        run.max_drift > 0 and not run.is_pulled
    )


def test_report_has_the_same_bytes_each_time_and_in_chinese_the_same_numbers(
    small_run, written, tmp_path
):
    small_run.save(tmp_path / "run.npz")
    again = replace(Run.load(tmp_path / "run.npz"), wall_seconds=3.0)
    for ending in FORMATS:
        for language in ("en", "zh"):
            with in_language(language):
                report(again, tmp_path / f"{language}{ending}")
        found = [(tmp_path / f"{language}{ending}").read_bytes() for language in ("en", "zh")]
        assert found[0] == written("contact and after", ending).read_bytes()
        if ending in (".json", ".csv"):
            assert found[0] == found[1]
            continue
        english, chinese = (
            re.sub('<style.*?</style>|src=".*?"', "", each.decode(), flags=re.S) for each in found
        )
        assert len(re.findall("[\u4e00-\u9fff]", chinese)) > 150
        assert sorted(re.findall(r"\d+\.\d+", chinese)) == sorted(re.findall(r"\d+\.\d+", english))


def test_contents_tell_the_run(small_run):
    found, drift = summarize(small_run).to_dict(), small_run.drift
    assert list(found) == KEYS
    scenario = {
        "benches": 16,
        "head_spacing": 2.86,
        "body_spacing": 1.65,
        "overhang": 0.275,
        "width": 0.30,
    }
    assert found["scenario"] == scenario | {
        "curve": "Spiral",
        "pitch": 0.55,
        "turns": 8,
        "speed": 1,
    }
    assert found["player"] == "pymunk"
    assert found["settings"]["guide"] == "rails"
    assert found["versions"] == small_run.versions
    counts = {"frames": len(small_run.times), "events": len(small_run.events)}
    assert found["outcome"] == {"status": "contact", "start": 77.5, "until": 84.5} | counts
    assert found["first_contact"] == json.loads(json.dumps(asdict(small_run.first_contact)))
    assert found["events"] == json.loads(json.dumps([*map(asdict, small_run.events)]))
    windows = [(*window["benches"], window["end"] is None) for window in found["windows"]]
    assert windows == [(0, 8, False), (0, 10, True)]
    assert (found["drift"]["head"], found["drift"]["max"]) == (small_run.head_drift, drift.max())
    worst = found["drift"]["max_at"]
    assert drift[small_run.times == worst["time"], worst["bench"]] == drift.max()


def test_scenarios_of_other_marches_are_told():
    changing = {
        "width": [1.8, 2.2, 1.6, 2.4],
        "pitch": None,
        "turns": None,
        "speed": [[0, 0.5], [5, 2], [20, 1.5]],
    }
    for march, scenario in (
        (U_TURN, {"radius": 4.5, "ratio": 2.0}),
        (TRACTOR, changing),
        (ARM, {"length": pytest.approx(ARM.curve.end_s)}),
        (replace(TRACTOR, speed=1.0, start_s=20.0), {"start_s": 20.0}),
    ):
        found = summarize(Run.exact(march, [0.0, 0.5]))
        assert {name: found.scenario[name] for name in scenario} == scenario
        assert f"A dragon of {march.dragon.benches} benches" in FORMATS[".md"](found)


def test_run_is_compared_with_the_exact_contact_if_a_guide_kept_it_on_its_path(small_run):
    found = summarize(small_run).to_dict()
    assert found["exact"]["status"] == "contact"
    assert found["exact"]["benches"] == [0, 8]
    assert [near["benches"] for near in found["near_misses"]] == [[0, 11]]
    late = 1e3 * (small_run.first_contact.time - found["exact"]["time"])
    said = FORMATS[".md"](summarize(small_run))
    assert said.count(f"{abs(late):.3f} ms {'late' if late > 0 else 'early'}") == 1
    other = replace(small_run, first_contact=replace(small_run.first_contact, benches=(0, 9)))
    off = RUNS["nobody on the path"](small_run)
    for run in (RUNS["no contact"](small_run), other, off):
        said = FORMATS[".md"](summarize(run))
        assert "t = 80.691317692 s: benches 0 and 8 " in said
        assert "The same benches" not in said
        assert ("No guide kept this dragon on its path" in said) == (run is off)
    half = replace(small_run, provenance={**small_run.provenance, "free_from": 9})
    said = FORMATS[".md"](summarize(half))
    assert "benches from 9 to the tail" in said
    assert "The same benches" not in said


def test_headline_tells_the_engines_time_of_contact_from_the_exact_one(small_run):
    found = summarize(small_run)
    engines, exact = small_run.first_contact.time, found.exact_contact.time
    assert abs(engines - exact) > 1e-6
    for language in ("en", "zh"):
        with in_language(language):
            assert f"{engines:.6f} s" in document.headline(found)
            told = document.subtitle(found)
            assert f"{engines:.6f} s" in told
            assert f"{exact:.9f} s" in told
            [table] = document.sections(found)[0].tables.values()
            times = [value for _, value in table.rows if value.endswith(" s")]
            assert times[:2] == [f"{engines:.6f} s", f"{exact:.9f} s"]
    # A run of the exact model, one off the path and one with another contact have no such error.
    other = replace(small_run, first_contact=replace(small_run.first_contact, benches=(0, 9)))
    for run in (Run.exact(SMALL, [79.0, 83.0]), RUNS["nobody on the path"](small_run), other):
        assert f"{exact:.9f}" not in document.subtitle(summarize(run))


def test_csv_brings_every_number_back(small_run, written):
    _, miss, *rows = csv.reader(
        io.StringIO(written("contact and after", ".csv").read_bytes().decode(), newline="")
    )
    assert miss[1:4] == ["near_miss", "0", "11"]
    assert float(miss[-1]) == pytest.approx(0.865e-3, abs=1e-6)
    first = small_run.first_contact.time
    contacts = {row[1]: float(row[0]) for row in rows[:2]}
    assert contacts == {"first_contact": first, "exact_contact": pytest.approx(first, abs=1e-3)}
    none = (None, None)
    for row, event in zip(rows[2:], small_run.events, strict=True):
        points = [*event.points, none, none][:2]
        values = [
            event.time,
            event.phase,
            *event.benches,
            *chain(*points),
            *(event.normal or none),
            event.depth,
        ]
        values += [*(event.relative_velocity or none), *(event.impulse or none), None]
        assert row == ["" if value is None else str(value) for value in values]


def test_long_tables_are_cut_and_say_how_many_rows_there_are(small_run, monkeypatch):
    monkeypatch.setattr(document, "_MAX_ROWS", 100)
    for write in (FORMATS[".md"], FORMATS[".html"]):
        content = write(summarize(small_run))
        assert f"first 100 of {len(small_run.events)} rows" in content
        assert len(re.findall(r"(?:begin|pre\\?_solve|separate)(?= \||</td>)", content)) == 100


def test_hostile_labels_are_shown_as_they_are(written):
    printable = [label.replace("\ud800", "?") for label in HOSTILE]
    page = elements_of(written("hostile labels", ".html").read_bytes().decode())
    # A reader of HTML or XML takes every end of a line for \n.
    assert {label.replace("\r\n", "\n") for label in printable} - {""} <= {*page[0].itertext()}
    found = json.loads(written("hostile labels", ".json").read_text())
    assert found["settings"]["list"] == printable
    assert found["player"] == HOSTILE[0]


@given(st.text(max_size=60))
@examples(200)
def test_markdown_gives_any_text_back_as_text(label):
    content = f"| a | b |\n| --- | --- |\n| {formats._escaped(label)} | end |\n"
    tokens = MarkdownIt("commonmark").enable("table").parse(content)
    cell, _ = [tokens[i + 1] for i, token in enumerate(tokens) if token.type == "td_open"]
    assert {child.type for child in cell.children} <= {"text", "text_special"}
    shown = "".join(child.content for child in cell.children)
    assert shown.split() == label.replace("\0", "\N{REPLACEMENT CHARACTER}").split()


def test_impossible_files_and_times_are_refused_and_without_matplotlib_is_no_chart(
    small_run, tmp_path, monkeypatch
):
    sheet = tmp_path / "table.xlsx"
    calls = [
        (report, small_run, tmp_path / name)
        for name in ("report", "report.pdf", "none/report.html", ".")
    ]
    calls += [
        (write_tables, SMALL, times, sheet)
        for times in ([], np.zeros(16384), [0, 1000.0], [0, np.nan])
    ]
    calls += [(write_contact_table, SMALL, time, sheet) for time in (1000.0, np.nan)]
    for write, *arguments in calls:
        refusal(write, *arguments, error=(ParameterError, UnreachableError))
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert not check_page(FORMATS[".html"](summarize(small_run)))
    assert list(tmp_path.iterdir()) == []


def check_sheet(file, name, labels, names, values):
    """First row, first column and the numbers between them, with six decimals and no minus zero."""
    heads, *rows = openpyxl.load_workbook(file)[name].iter_rows(values_only=True)
    assert heads == (None, *labels)
    found = [row[0] for row in rows]
    assert [*found[: len(names) - 3], *found[-3:]] == names
    numbers = np.array([row[1:] for row in rows])
    assert np.array_equal(numbers, np.round(values, 6))
    assert not np.any(np.signbit(numbers) & (numbers == 0))


def test_contest_tables_are_the_templates_and_the_same_files_every_time(seed_march, tmp_path):
    times = [0, 1e-9, 25, 300]  # A nanosecond after the start handle 0 has a y of -1e-9 m.
    first, again, second = (tmp_path / f"result{number}.xlsx" for number in (1, 4, 2))
    write_tables(seed_march, times, first)
    write_tables(seed_march, times, again)
    assert first.read_bytes() == again.read_bytes()
    states, labels = seed_march.at(times), ["0 s", "1e-09 s", "25 s", "300 s"]
    assert openpyxl.load_workbook(first).sheetnames == ["位置", "速度"]
    names = [
        "龙头x (m)",
        "龙头y (m)",
        "第1节龙身x (m)",
        "龙尾y (m)",
        "龙尾（后）x (m)",
        "龙尾（后）y (m)",
    ]
    check_sheet(first, "位置", labels, names, states.positions.reshape(4, -1).T)
    names = [
        "龙头 (m/s)",
        "第1节龙身  (m/s)",
        "第221节龙身  (m/s)",
        "龙尾  (m/s)",
        "龙尾（后） (m/s)",
    ]
    check_sheet(first, "速度", labels, names, states.speeds.T)
    write_contact_table(seed_march, 412.4738377, second)
    states, labels = seed_march.at([412.4738377]), ["横坐标x (m)", "纵坐标y (m)", "速度 (m/s)"]
    names = ["龙头", "第1节龙身", "第221节龙身", "龙尾", "龙尾（后）"]
    check_sheet(
        second, "Sheet1", labels, names, np.column_stack([states.positions[0], states.speeds[0]])
    )


@pytest.mark.thorough
@needs_browser
def test_report_in_a_browser_fits_the_window_and_runs_and_asks_for_nothing(browser, small_run):
    label = "<img src=http://127.0.0.1:9/picture onerror=alert(1)><script>alert(2)</script>"
    labelled = replace(small_run, provenance={**small_run.provenance, label: label})
    address = shared("browser.html", lambda path: report(labelled, path)).as_uri()
    # A4 without its margins is 688 pixels wide.
    for media, width in (("screen", 1280), ("screen", 390), ("print", 688)):
        with opened(browser, address, width, 900, is_mobile=width < 600) as seen:
            seen.page.emulate_media(media=media)
            assert seen.page.evaluate("document.documentElement.scrollWidth") <= width
            assert seen.complaints == seen.boxes == []
            assert {url for url in seen.addresses if not url.startswith("data:")} == {address}
            widths = seen.page.evaluate(
                "[...document.querySelectorAll('img')].map((each) => each.clientWidth)"
            )
            assert len(widths) == 3
            for size in widths:
                assert 150 < size <= max(width, 600)
            assert label in seen.page.evaluate("document.querySelector('#provenance').textContent")
