"""The text of the page that plays a run, and what a notebook shows of results."""

import json
import zlib
from base64 import b64decode, b64encode
from dataclasses import replace
from hashlib import sha256
from html import unescape
from importlib import import_module
from io import BytesIO
from unittest.mock import Mock

import nbclient
import numpy as np
import pytest
from bs4 import BeautifulSoup
from conftest import LIMIT, assert_says, examples, refusal
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from marches import ARM, TRACTOR, U_TURN
from nbformat.v4 import new_code_cell, new_notebook
from PIL import Image
from PIL.ImageColor import getrgb
from shapely import LineString, points

from pymunk_dragon import Contact, Dragon, March, Run, first_contact, player_page, write_player
from pymunk_dragon._language import in_language
from pymunk_dragon.drawing.figures import figure
from pymunk_dragon.drawing.notebook import picture
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.model.contact import ContactEvent, ContactLog
from pymunk_dragon.player.data import (
    _contact_windows,
    _exact_offsets,
    _handle_vectors,
    pack,
)
from pymunk_dragon.web.curve import curve_points

SMALL = March(Dragon(benches=16), turns=8)
MARKUP = "</script><img src=http://127.0.0.1:9/x onerror=alert(1)><!--<script>{{style}}&amp;"
# Bytes of a page of the whole march.
MAX_PAGE = 2_000_000
COUNTS = 2**32


class Page:
    """Tags with their attributes, the text, and the contents of styles and scripts."""

    def __init__(self, text):
        soup = BeautifulSoup(text, "html.parser")
        self.tags = [(tag.name, tag.attrs) for tag in soup.find_all(True)]
        self.blocks = {
            tag.get("id", tag.name): tag.string or "" for tag in soup.find_all(["script", "style"])
        }
        self.text = " ".join(soup.get_text().split())
        self.payload = json.loads(self.blocks["payload"])


def unpacked(shape, text):
    """Vectors (F, H, 2) in m or m/s, one number after the other."""
    planes = np.frombuffer(zlib.decompress(b64decode(text)), dtype=np.uint8).astype(np.int64)
    folded = (planes.reshape(4, -1) << np.array([0, 8, 16, 24])[:, None]).sum(axis=0)
    change = np.where(folded % 2, -(folded + 1) // 2, folded // 2).reshape(
        shape["points"], 2, shape["frames"]
    )
    for _ in range(shape["order"]):
        change = np.cumsum(change, axis=-1) % COUNTS
    signed = (change + COUNTS // 2) % COUNTS - COUNTS // 2
    return np.array(shape["origin"]) + shape["step"] * signed.transpose(2, 0, 1)


def page_vectors(page, name="handles"):
    return unpacked(page.payload[name], page.blocks[f"{name}-packed"])


@pytest.fixture(scope="module")
def run():
    return Run.exact(SMALL, np.linspace(0, 10, 101))


@pytest.fixture(scope="module")
def page(run):
    return Page(player_page(run))


def test_places_and_velocities_come_back_as_near_as_the_page_says(run, page):
    front, rear = run.march.dragon.holes(run.poses)
    step = page.payload["handles"]["step"]
    places = page_vectors(page)
    np.testing.assert_allclose(places[:, :-1], front, rtol=0, atol=0.501 * step)
    np.testing.assert_allclose(places[:, 1:], rear, rtol=0, atol=0.501 * step)
    assert page.payload["errors"][0] == pytest.approx(step / np.sqrt(2), rel=1e-6)
    assert step == pytest.approx(0.2e-6)
    exact = run.march.at(run.times).velocities
    found, step = page_vectors(page, "velocities"), page.payload["velocities"]["step"]
    np.testing.assert_allclose(found, exact, rtol=0, atol=0.52 * step)
    # A cubic over 0.1 s is off by at most a quarter of that times the error of its velocities.
    assert 0.1 / 4 * step / 2 <= 0.51 * page.payload["handles"]["step"]
    # Velocities that a run does not have come from its frames.
    unknown = Page(player_page(replace(run, pose_velocities=None)))
    np.testing.assert_allclose(page_vectors(unknown, "velocities"), found, rtol=0, atol=1e-2)


@given(
    arrays(
        float, st.tuples(st.integers(1, 12), st.just(3), st.just(2)), elements=st.floats(-1e6, 1e6)
    ),
    st.booleans(),
)
@examples(50)
def test_any_jump_comes_back(places, far):
    # A double of 1e9 m is 1e-7 m wide.
    places = places + 1e9 * far
    shape, text = pack(places, 5e-6)
    np.testing.assert_allclose(
        unpacked(shape, text), places, rtol=0, atol=0.501 * shape["step"] + 5e-7
    )
    assert shape["step"] <= max(5e-6, np.ptp(places, axis=(0, 1)).max() / 2**31)


def test_seeds_whole_run_fits_into_2_megabytes_and_has_its_near_misses(seed_march):
    text = player_page(Run.exact(seed_march, np.arange(4125) / 10))
    assert len(text.encode()) <= MAX_PAGE
    payload = Page(text).payload
    assert payload["handles"]["step"] == pytest.approx(0.2e-6)
    assert [len(payload["times"]), payload["handles"]["points"]] == [4125, 224]
    misses = [
        (each["benches"], round(each["time"], 1), round(1e3 * each["gap"], 1))
        for each in payload["near_misses"]
    ]
    assert misses == [([0, 9], 406.8, 3.0), ([0, 11], 409.8, 0.9)]
    # The curve is drawn from the tail at the start to the centre.
    ends = [seed_march.at(0.0).positions[0, -1], [0, 0]]
    np.testing.assert_allclose(curve_points(seed_march, 0.0, 1.0)[[0, -1]], ends, atol=1e-4)
    # A dragon off its path has none of them.
    off = replace(
        Run.exact(seed_march, [409.0, 410.0]), provenance={"player": "pymunk", "free_from": 1}
    )
    assert Page(player_page(off)).payload["near_misses"] == []


@pytest.mark.parametrize(
    ("march", "begin", "end"),
    [(March(), 0.0, 1.0), (U_TURN, -20.0, 20.0), (TRACTOR, 0.0, 1.0), (ARM, 0.0, 1.0)],
    ids=["spiral", "u-turn", "tractor", "arm"],
)
def test_curve_is_drawn_all_along_within_a_tenth_of_a_millimetre(march, begin, end):
    drawn = LineString(curve_points(march, begin, end))
    first, last = march.span(begin, end)
    curve = march.curve.point(np.linspace(first, last, 5001)[1:-1])
    allowed = 1.1 * float(march.dragon.widths.min()) / 3000
    assert drawn.distance(points(curve)).max() < allowed
    # From far away the page takes only every so many points, and counts on the square of their
    # number.
    rough = LineString([*drawn.coords[:-1:3], drawn.coords[-1]])
    assert rough.distance(points(curve)).max() < allowed * 9
    np.testing.assert_allclose(
        [drawn.coords[0], drawn.coords[-1]], march.curve.point([first, last]), atol=1e-9
    )


def test_markup_in_titles_provenance_and_data_is_text(run, page, monkeypatch):
    odd = replace(
        run, provenance={"player": MARKUP, MARKUP: MARKUP, "versions": {MARKUP: [MARKUP]}}
    )
    for title in (None, MARKUP):
        found = Page(player_page(odd, title=title))
        assert {tag for tag, _ in found.tags} == {tag for tag, _ in page.tags}
        assert [tag for tag, _ in found.tags if tag == "script"] == ["script"] * 7
        assert MARKUP in found.text
        assert found.blocks["script"] == page.blocks["script"]
    module = import_module("pymunk_dragon.player.page")
    data = module.player_data
    monkeypatch.setattr(
        module,
        "player_data",
        lambda summary: (data(summary)[0] | {"note": MARKUP}, data(summary)[1]),
    )
    found = Page(player_page(run))
    assert found.tags == page.tags
    assert found.payload["note"] == MARKUP


def test_policy_allows_the_pages_own_script_and_style_and_nothing_else(page):
    [content] = [found["content"] for tag, found in page.tags if "http-equiv" in found]
    expected = {
        "default-src": "'none'",
        "img-src": "data:",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    for kind in ("script", "style"):
        digest = b64encode(sha256(page.blocks[kind].encode()).digest()).decode()
        expected[f"{kind}-src"] = f"'sha256-{digest}'"
    assert dict(part.split(" ", 1) for part in content.split("; ")) == expected
    # It stands before everything that it governs, and nothing carries a script, a style or an
    # address.
    tags = [tag if "http-equiv" not in found else "policy" for tag, found in page.tags]
    assert tags.index("policy") < min(tags.index(tag) for tag in ("link", "style", "script"))
    names = {name for _, found in page.tags for name in found}
    assert not [name for name in names if name.startswith("on")]
    assert not names & {"style", "src", "srcset", "action", "data", "poster"}
    assert {found["href"] for _, found in page.tags if "href" in found} == {"data:,"}
    for text in ("</script>", "<!--", "\r"):
        assert text not in page.blocks["script"] + page.blocks["style"]


def test_title_is_what_happened_unless_one_is_given(run, page, tmp_path):
    assert page.text.startswith("No contact from 0.000 s to 10.000 s")
    # The exact model has no first contact of benches that overlap at the start.
    overlapping = Run.exact(replace(SMALL, turns=4), [0.0, 1.0])
    assert Page(player_page(overlapping)).text.startswith("The dragon from 0.000 s to 1.000 s")
    assert Page(player_page(run, title="Lesson 1")).text.startswith("Lesson 1")
    write_player(run, tmp_path / "run.html", title="a\ud800b")
    assert "a?b" in (tmp_path / "run.html").read_text(encoding="utf-8")
    for title in (3, b"a", ["a"]):
        assert_says(refusal(player_page, run, title=title), "title")


def test_same_run_gives_the_same_file_which_is_whole_or_not_there(run, tmp_path, monkeypatch):
    path = tmp_path / "run.html"
    write_player(run, path)
    content = path.read_bytes()
    assert content == player_page(run).encode()
    with monkeypatch.context() as patched:
        patched.setattr(type(path), "write_bytes", Mock(side_effect=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            write_player(run, path, title="another")
    for name in ("run.htm", "run", "nowhere/run.html"):
        assert refusal(write_player, run, tmp_path / name).name == "output"
    assert path.read_bytes() == content
    assert list(tmp_path.iterdir()) == [path]


def test_windows_begin_at_the_first_contact(run, seed_march):
    # The exact model's contact is a window, and a frame of its own.
    payload = Page(player_page(Run.exact(seed_march, [412.0, 412.4, 412.6]))).payload
    [window] = payload["windows"]
    assert window["benches"] == [0, 8]
    assert window["end"] is None
    assert window["begin"] == pytest.approx(412.4738, abs=1e-4)
    assert payload["times"] == [412.0, 412.4, window["begin"], 412.6]

    def windows(events, time, benches=(0, 8)):
        first = Contact(
            time=time, raw_time=2.0, benches=benches, point=(0.0, 0.0), normal=(1.0, 0.0), depth=0.0
        )
        log = ContactLog(
            tuple(ContactEvent(time=at, phase=phase, benches=pair) for at, phase, pair in events)
        )
        found = _contact_windows(replace(run, events=log, first_contact=first))
        return [(each["benches"], each["begin"], each["end"]) for each in found]

    # An event of the engine has the time of the end of its substep.
    events = [(2.0, "begin", (0, 8)), (2.5, "separate", (0, 8)), (3.0, "begin", (0, 8))]
    assert windows(events, 1.993) == [((0, 8), 1.993, 2.5), ((0, 8), 3.0, None)]
    # A first contact that nobody logged lasts to the end.
    events = [(4.0, "begin", (1, 9)), (5.0, "separate", (1, 9))]
    assert windows(events, 1.993) == [((0, 8), 1.993, None), ((1, 9), 4.0, 5.0)]


def test_texts_of_the_page_and_of_its_run_are_in_both_languages(run, page):
    texts = json.loads(page.blocks["texts"])
    assert set(texts) == {"zh"}
    assert texts["zh"]["No contact from 0.000 s to 10.000 s"] == "0.000 s 至 10.000 s 没有碰撞"
    assert texts["zh"]["Scenario"] == "场景"
    with in_language("zh"):
        chinese = player_page(run)
    assert chinese.replace('lang="zh"', 'lang="en"', 1) == player_page(run)


def test_offsets_of_the_exact_model_come_back_within_half_a_micrometre(small_run, page):
    run = small_run
    offsets = run.march.at(run.times).positions - _handle_vectors(
        *run.march.dragon.holes(run.poses)
    )
    text = player_page(run)
    found = Page(text)
    assert found.payload["exact"]["step"] == pytest.approx(0.5e-6)
    np.testing.assert_allclose(page_vectors(found, "exact"), offsets, rtol=0, atol=0.26e-6)
    assert len(text) < 1.15 * len(player_page(replace(run, drift=run.drift + 1.0)))
    # Frames without a state of the model, and runs whose errors belong to other times, have none.
    drift = run.drift.copy()
    drift[10:] = np.nan
    assert _exact_offsets(replace(run, drift=drift)).shape == (10, 17, 2)
    assert _exact_offsets(replace(run, drift=drift * np.nan)) is None
    assert _exact_offsets(replace(run, times=run.times + 0.1)) is None
    assert page.payload["exact"] is None


# What a notebook shows of a run, a march, a figure and a first contact


def opened(png):
    return Image.open(BytesIO(png)).convert("RGB")


def has(picture, part):
    return np.any(np.all(np.asarray(picture) == getrgb(getattr(Palette(), part)), axis=-1))


def test_run_is_a_picture_of_its_end(run):
    assert not has(opened(picture(run)), "contact")
    contact = Contact(
        time=10.0, raw_time=10.0, benches=(0, 8), point=(1.0, 2.0), normal=(0.0, 1.0), depth=0.0
    )
    assert has(opened(picture(replace(run, first_contact=contact, outcome="contact"))), "contact")


def test_march_is_a_picture_of_its_start():
    assert all(has(opened(picture(SMALL)), part) for part in ("head", "body", "tail"))


@pytest.mark.thorough
def test_notebook_that_imports_march_alone_shows_marches_and_runs_as_pictures():
    cells = ["from pymunk_dragon import March\nMarch()"]
    cells += ["from pymunk_dragon import Run\nRun.exact(March(), [0.0, 60.0])"]
    notebook = new_notebook(cells=[new_code_cell(cell) for cell in cells])
    limits = dict.fromkeys(("timeout", "startup_timeout", "iopub_timeout"), LIMIT)
    nbclient.NotebookClient(notebook, **limits).execute()

    for cell, shown in zip(notebook.cells, (March(), Run.exact(March(), [0.0, 60.0])), strict=True):
        [output] = cell.outputs
        assert b64decode(output.data["image/png"]) == picture(shown)


def test_figures_of_marches_and_runs_are_pictures(run):
    for source in (SMALL, run):
        shown = opened(figure("trajectories", source)._repr_png_())
        assert shown.width == 560
        assert has(shown, "background")


def test_first_contact_is_its_text():
    found = first_contact(SMALL, until=1.0)
    assert unescape(found._repr_html_()) == f"<pre>{found}</pre>"
    assert str(found) == "no contact until t = 1 s"
