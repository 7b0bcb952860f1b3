"""The page that plays a run, as a text: what is in it, and what is not."""

from __future__ import annotations

import json
import re
import zlib
from base64 import b64decode, b64encode
from dataclasses import asdict, replace
from hashlib import sha256
from html.parser import HTMLParser
from importlib import import_module

import numpy as np
import pytest
from conftest import assert_says
from hypothesis import given
from hypothesis import strategies as st
from marches import ARM, TRACTOR, U_TURN
from shapely import LineString, points

import pymunk_dragon
from pymunk_dragon._language import in_language
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate
from pymunk_dragon.player import player_page, write_player
from pymunk_dragon.player.data import contact_windows, curve_points, exact_offsets, handle_vectors, pack
from pymunk_dragon.player.page import DARK, LIGHT
from pymunk_dragon.reports import summarize

SMALL = March(Dragon(benches=16), turns=4)
MARKUP = "</script><img src=http://127.0.0.1:9/x onerror=alert(1)><!--<script>{{style}}&amp;"
# Bytes of a page of the whole march.
MAX_PAGE = 2_000_000
COUNTS = 2**32


class Page(HTMLParser):
    """Tags with their attributes, the text, and the contents of styles and scripts."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts, self.blocks, self._open = [], [], {}, None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag in ("script", "style"):
            self._open = dict(attributes).get("id", tag)

    def handle_endtag(self, tag):
        self._open = None

    def handle_data(self, data):
        if self._open:
            self.blocks[self._open] = self.blocks.get(self._open, "") + data
        else:
            self.texts.append(data)

    @property
    def text(self):
        return " ".join("".join(self.texts).split())

    @property
    def policy(self):
        [content] = [found["content"] for tag, found in self.tags if "http-equiv" in found]
        return dict(part.split(" ", 1) for part in content.split("; "))

    @property
    def payload(self):
        return json.loads(self.blocks["payload"])


def unpacked(shape, text):
    """Vectors (F, H, 2) in m or m/s, one number after the other."""
    planes = zlib.decompress(b64decode(text))
    total = shape["frames"] * shape["points"] * 2
    assert len(planes) == 4 * total
    folded = [sum(planes[k * total + i] << (8 * k) for k in range(4)) for i in range(total)]
    places = np.empty((shape["points"], 2, shape["frames"]))
    for track in range(2 * shape["points"]):
        sums = [0] * shape["order"]
        for frame in range(shape["frames"]):
            number = folded[track * shape["frames"] + frame]
            change = -(number + 1) // 2 if number % 2 else number // 2
            for k in range(shape["order"]):
                change = sums[k] = sums[k] + change
            signed = (change + COUNTS // 2) % COUNTS - COUNTS // 2
            places[track // 2, track % 2, frame] = shape["origin"][track % 2] + shape["step"] * signed
    return places.transpose(2, 0, 1)


def page_vectors(page, name="handles"):
    return unpacked(page.payload[name], page.blocks[f"{name}-packed"])


def luminance(colour):
    share = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one, two):
    """Of WCAG 2.2: 4.5 for type, 3 for everything else that has to be seen."""
    dark, light = sorted((luminance(one), luminance(two)))
    return (light + 0.05) / (dark + 0.05)


@pytest.fixture(scope="module")
def run():
    return Run.exact(SMALL, np.linspace(0, 10, 101))


@pytest.fixture(scope="module")
def page(run):
    return Page(player_page(run))


@pytest.fixture(scope="module")
def seed_page():
    """A page of the seed's whole run, frames a tenth of a second apart."""
    return player_page(Run.exact(March(), np.arange(4125) / 10))


def test_places_come_back_as_near_as_the_page_says(run, page):
    front, rear = run.march.dragon.holes(run.poses)
    step = page.payload["handles"]["step"]
    places = page_vectors(page)
    np.testing.assert_allclose(places[:, :-1], front, rtol=0, atol=0.501 * step)
    np.testing.assert_allclose(places[:, 1:], rear, rtol=0, atol=0.501 * step)
    assert page.payload["errors"][0] == pytest.approx(step / np.sqrt(2), rel=1e-6)
    assert step == pytest.approx(0.2e-6)


def test_velocities_come_back_so_near_that_nothing_between_frames_is_further_off_than_at_them(run, page):
    exact = run.march.at(run.times).velocities
    found, step = page_vectors(page, "velocities"), page.payload["velocities"]["step"]
    np.testing.assert_allclose(found, exact, rtol=0, atol=0.501 * step)
    assert page.payload["errors"][1] == pytest.approx(step / np.sqrt(2), rel=1e-6)
    # A cubic over 0.1 s is off by at most a quarter of that times the error of its velocities.
    assert 0.1 / 4 * step / 2 <= 0.51 * page.payload["handles"]["step"]


def test_velocities_that_a_run_does_not_know_come_from_its_frames(run, page):
    unknown = replace(run, pose_velocities=None)
    found = page_vectors(Page(player_page(unknown)), "velocities")
    np.testing.assert_allclose(found, page_vectors(page, "velocities"), rtol=0, atol=1e-4)
    alone = Run.exact(SMALL, [1.0])
    assert page_vectors(Page(player_page(alone)), "velocities").shape == (1, 17, 2)
    assert Page(player_page(replace(alone, pose_velocities=None))).payload["velocities"] is None


@given(
    places=st.lists(
        st.lists(st.tuples(*[st.floats(-1e6, 1e6)] * 2), min_size=3, max_size=3), min_size=1, max_size=12
    ).map(np.array),
    offset=st.sampled_from([0.0, 1e9]),
)
def test_any_jump_comes_back(places, offset):
    kept = pack(places + offset, 5e-6)
    shape = asdict(kept)
    # A double of 1e9 m is 1e-7 m wide.
    np.testing.assert_allclose(unpacked(shape, kept.text), places + offset, rtol=0, atol=0.501 * kept.step + 5e-7)
    reach = np.ptp(places, axis=(0, 1)).max()
    assert kept.step <= max(5e-6, reach / 2**31)


def test_seeds_whole_run_fits_into_2_megabytes_finer_than_a_thousandth_of_a_millimetre(seed_page):
    assert len(seed_page.encode()) <= MAX_PAGE
    payload = Page(seed_page).payload
    assert payload["handles"]["step"] == pytest.approx(0.2e-6)
    assert [len(payload["times"]), payload["handles"]["points"]] == [4125, 224]


def test_joints_that_gape_have_their_handle_in_the_middle(run):
    poses = run.poses.copy()
    poses[:, 3, 0] += 0.002
    front, rear = SMALL.dragon.holes(poses)
    found = handle_vectors(front, rear)
    np.testing.assert_allclose(found[:, 3], (rear[:, 2] + front[:, 3]) / 2)
    np.testing.assert_allclose(found[:, 0], front[:, 0])
    np.testing.assert_allclose(found[:, 16], rear[:, 15])
    payload = Page(player_page(replace(run, poses=poses))).payload
    assert payload["errors"][0] == pytest.approx(0.001, rel=1e-3)


def test_curve_is_nowhere_further_off_than_a_tenth_of_a_millimetre():
    march = March()
    drawn = LineString(curve_points(march, 0.0, 1.0))
    tail = march.handles_s(0.0)[0, -1]
    curve = march.curve.point(np.linspace(tail, 0.0, 5000))
    assert drawn.distance(points(curve)).max() < 1.1e-4
    np.testing.assert_allclose(drawn.coords[0], march.at(0.0).positions[0, -1], atol=1e-9)
    np.testing.assert_allclose(drawn.coords[-1], [0, 0], atol=1e-4)


def test_curve_of_a_run_that_starts_early_begins_at_its_tail():
    tail = SMALL.at(-50.0).positions[0, -1]
    np.testing.assert_allclose(curve_points(SMALL, -50.0, 1.0)[0], tail, atol=1e-9)


@pytest.mark.parametrize("march", [U_TURN, TRACTOR, ARM], ids=["u-turn", "tractor", "arm"])
def test_other_curves_are_drawn_all_along(march):
    begin, end = (-20.0, 20.0) if march is U_TURN else (0.0, 1.0)
    drawn = LineString(curve_points(march, begin, end))
    first, last = march.span(begin, end)
    curve = march.curve.point(np.linspace(first, last, 20_001)[1:-1])
    allowed = 1.2 * float(march.dragon.widths.min()) / 3000
    assert drawn.distance(points(curve)).max() < allowed
    # From far away the page takes only every so many points, and counts on the square of their number.
    for stride in (3, 10):
        rough = LineString([*drawn.coords[:-1:stride], drawn.coords[-1]])
        assert rough.distance(points(curve)).max() < allowed * stride**2
    assert drawn.length == pytest.approx(last - first, rel=1e-3)
    np.testing.assert_allclose(drawn.coords[0], march.curve.point(first), atol=1e-9)
    np.testing.assert_allclose(drawn.coords[-1], march.curve.point(last), atol=1e-9)


@pytest.mark.parametrize("given_title", [None, MARKUP])
def test_markup_in_title_and_provenance_is_text(run, given_title):
    odd = replace(run, provenance={"player": MARKUP, MARKUP: MARKUP, "versions": {MARKUP: [MARKUP]}})
    page = Page(player_page(odd, title=given_title))
    plain = Page(player_page(run))
    assert {tag for tag, _ in page.tags} == {tag for tag, _ in plain.tags}
    assert [tag for tag, _ in page.tags if tag == "script"] == ["script"] * 7
    assert MARKUP in page.text
    assert page.blocks["script"] == plain.blocks["script"]
    if given_title:
        assert page.text.startswith(MARKUP)


def test_markup_in_the_data_is_data(run, page, monkeypatch):
    # There are only numbers in it so far.
    module = import_module("pymunk_dragon.player.page")
    payload, packed = module.player_data(summarize(run))
    monkeypatch.setattr(module, "player_data", lambda _: ({**payload, "note": MARKUP}, packed))
    changed = Page(player_page(run))
    assert changed.tags == page.tags
    assert changed.payload["note"] == MARKUP


def test_policy_allows_the_pages_own_script_and_style_and_nothing_else(page):
    for kind in ("script", "style"):
        digest = b64encode(sha256(page.blocks[kind].encode()).digest()).decode()
        assert page.policy[f"{kind}-src"] == f"'sha256-{digest}'"
    rest = {name: value for name, value in page.policy.items() if name not in ("script-src", "style-src")}
    assert rest == {"default-src": "'none'", "img-src": "data:", "base-uri": "'none'", "form-action": "'none'"}


def test_policy_stands_before_everything_that_it_governs(page):
    tags = [tag if "http-equiv" not in found else "policy" for tag, found in page.tags]
    assert tags.index("policy") < min(tags.index(tag) for tag in ("link", "style", "script"))


def test_no_tag_carries_style_or_script_or_an_address(page):
    names = {name for _, found in page.tags for name in found}
    assert not {name for name in names if name.startswith("on")}
    assert not names & {"style", "src", "srcset", "action", "data", "poster"}
    assert {found["href"] for _, found in page.tags if "href" in found} == {"data:,"}


@pytest.mark.parametrize("text", ["</script>", "<!--"])
def test_script_holds_nothing_that_ends_it(page, text):
    assert text not in page.blocks["script"]
    assert "\r" not in page.blocks["script"] + page.blocks["style"]


def test_title_is_what_happened_unless_one_is_given(run):
    assert Page(player_page(run)).text.startswith("The dragon from 0.000 s to 10.000 s")
    assert Page(player_page(run, title="Lesson 1")).text.startswith("Lesson 1")


def test_title_with_half_a_character_can_be_written(run, tmp_path):
    write_player(run, tmp_path / "run.html", title="a\ud800b")
    assert "a?b" in (tmp_path / "run.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("title", [3, b"a", ["a"]])
def test_title_that_is_no_text_is_bad_input(run, title):
    with pytest.raises(ParameterError) as caught:
        player_page(run, title=title)
    assert_says(caught.value, "title", "text")


def test_same_run_gives_the_same_file_and_the_same_text(run, tmp_path):
    steps = []
    write_player(run, tmp_path / "run.html", progress=lambda done, total: steps.append((done, total)))
    assert (tmp_path / "run.html").read_bytes() == player_page(run).encode()
    assert steps == [(1, 2), (2, 2)]


@pytest.mark.parametrize("name", ["run.htm", "run", "run.html.gz", "nowhere/run.html"])
def test_a_place_where_no_page_can_be_is_bad_input(run, tmp_path, name):
    with pytest.raises(ParameterError) as caught:
        write_player(run, tmp_path / name)
    assert_says(caught.value, "output")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("failure", [KeyboardInterrupt, RuntimeError])
def test_a_page_that_is_broken_off_leaves_the_old_one(run, tmp_path, failure):
    path = tmp_path / "run.html"
    path.write_bytes(b"old")

    def stop(done, total):
        raise failure

    with pytest.raises(failure):
        write_player(run, path, progress=stop)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_near_misses_are_the_exact_models(seed_page):
    near = Page(seed_page).payload["near_misses"]
    assert [(miss["benches"], round(miss["time"], 1), round(1e3 * miss["gap"], 1)) for miss in near] == [
        ([0, 9], 406.8, 3.0),
        ([0, 11], 409.8, 0.9),
    ]


def test_dragon_off_its_path_has_none_of_the_exact_models_near_misses():
    run = Run.exact(March(), [409.0, 410.0])
    assert len(Page(player_page(run)).payload["near_misses"]) == 1
    off = replace(run, provenance={"player": "pymunk", "guide": "none"})
    assert Page(player_page(off)).payload["near_misses"] == []


def test_exact_run_past_its_contact_has_it_as_a_window():
    run = Run.exact(March(), [412.0, 412.4, 412.6])
    payload = Page(player_page(run)).payload
    [window] = payload["windows"]
    assert window["benches"] == [0, 8]
    assert window["end"] is None
    assert window["begin"] == pytest.approx(412.4738, abs=1e-4)
    assert payload["times"] == [412.0, 412.4, window["begin"], 412.6]


def first(time, benches=(0, 8)):
    return Contact(time=time, raw_time=2.0, benches=benches, point=(0.0, 0.0), normal=(1.0, 0.0), depth=0.0)


def log(*events):
    return ContactLog(tuple(ContactEvent(time=time, phase=phase, benches=pair) for time, phase, pair in events))


def test_first_window_begins_at_the_first_contact_and_not_at_the_end_of_its_substep(run):
    events = log((2.0, "begin", (0, 8)), (2.5, "separate", (0, 8)), (3.0, "begin", (0, 8)))
    found = contact_windows(replace(run, events=events, first_contact=first(1.993)))
    assert [(window["begin"], window["end"]) for window in found] == [(1.993, 2.5), (3.0, None)]


def test_first_contact_that_nobody_logged_lasts_to_the_end(run):
    events = log((4.0, "begin", (1, 9)), (5.0, "separate", (1, 9)))
    found = contact_windows(replace(run, events=events, first_contact=first(1.993)))
    assert [(window["benches"], window["begin"], window["end"]) for window in found] == [
        ((0, 8), 1.993, None),
        ((1, 9), 4.0, 5.0),
    ]


def test_contacts_that_cannot_be_are_left_out(run):
    events = log((1.0, "begin", (1, 9)), (float("nan"), "begin", (2, 9)), (2.0, "begin", (3, 16)))
    changed = replace(run, events=events, first_contact=first(1.0, benches=(0, 99)))
    assert [window["benches"] for window in Page(player_page(changed)).payload["windows"]] == [[1, 9]]


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_numbers_and_outlines_of_benches_can_be_seen(palette):
    assert min(contrast(palette.ink, palette.head), contrast(palette.ink, palette.body)) > 4.5
    assert min(contrast(palette.background, palette.tail), contrast(palette.background, palette.contact)) > 4.5
    assert min(contrast(colour, palette.background) for colour in (palette.motion, palette.force)) > 3
    for bench in (palette.head, palette.body, palette.tail, palette.contact):
        assert max(contrast(bench, palette.background), contrast(palette.ink, palette.background)) > 3


@pytest.mark.parametrize("scheme", [0, 1])
def test_type_and_controls_can_be_seen(page, scheme):
    blocks = re.findall(r":root \{([^}]*)\}", page.blocks["style"])
    found = [dict(re.findall(r"--([a-z-]+): (#[0-9a-f]{6});", block)) for block in blocks]
    # Variables in the order light and dark, first the canvas's, then the page's.
    canvas, colours = found[scheme], found[scheme + 2]
    assert canvas["canvas-background"] == (LIGHT, DARK)[scheme].background
    for ground in (colours["ground"], colours["raised"]):
        assert min(contrast(colours[name], ground) for name in ("ink", "quiet")) > 4.5
        assert min(contrast(colours[name], ground) for name in ("any", "edge")) > 3
    assert contrast(colours["ink"], canvas["canvas-background"]) > 4.5


def test_player_is_there_at_the_top():
    assert pymunk_dragon.write_player is write_player
    assert pymunk_dragon.player_page is player_page


def test_page_has_its_texts_in_both_languages(page):
    texts = json.loads(page.blocks["texts"])
    assert set(texts) == {"zh"}
    assert texts["zh"]["Help"] == "帮助"


def test_title_and_provenance_of_the_run_are_translated_too(page):
    texts = json.loads(page.blocks["texts"])["zh"]
    assert texts["The dragon from 0.000 s to 10.000 s"] == "0.000 s 至 10.000 s 的板凳龙"
    assert texts["Head bench, hole to hole"] == "龙头两孔间距"
    [subtitle] = [chinese for english, chinese in texts.items() if english.startswith("A dragon of 16 benches")]
    assert subtitle == "16 节板凳，龙头速度 1 m/s，螺线，螺距 0.55 m，由精确模型计算"


def test_page_of_a_chinese_program_opens_in_chinese(run):
    with in_language("zh"):
        chinese = player_page(run)
    assert chinese.replace('lang="zh"', 'lang="en"', 1) == player_page(run)


@pytest.fixture(scope="module")
def engine_run():
    return simulate(March(Dragon(benches=16)), start=411.0)


def test_exact_models_offsets_come_back_within_half_a_micrometre(engine_run):
    exact = engine_run.march.at(engine_run.times).positions
    offsets = exact - handle_vectors(*engine_run.march.dragon.holes(engine_run.poses))
    page = Page(player_page(engine_run))
    assert page.payload["exact"]["step"] == pytest.approx(0.5e-6)
    np.testing.assert_allclose(page_vectors(page, "exact"), offsets, rtol=0, atol=0.26e-6)


def test_exact_models_offsets_take_little_of_the_page(engine_run):
    without = replace(engine_run, drift=engine_run.drift + 1.0)
    assert len(player_page(engine_run)) < 1.15 * len(player_page(without))


def test_dragon_without_a_guide_is_metres_away_from_the_exact_model():
    run = simulate(March(Dragon(benches=16), turns=8), guide="none", contacts="report", until=20.0)
    offsets = exact_offsets(run)
    assert np.linalg.norm(offsets, axis=-1).max() == pytest.approx(run.drift.max(), rel=0.01)
    assert run.drift.max() > 1
    page = Page(player_page(run))
    assert page.payload["exact"]["step"] == pytest.approx(1e-5 * np.abs(offsets).max())
    # The head is carried: its front handle has no error, and the page shows none.
    assert np.abs(page_vectors(page, "exact")[:, 0]).max() == 0


def test_frames_without_a_state_of_the_model_have_no_offsets(engine_run):
    drift = engine_run.drift.copy()
    drift[10:] = np.nan
    assert exact_offsets(replace(engine_run, drift=drift)).shape == (10, 17, 2)
    drift[:] = np.nan
    assert exact_offsets(replace(engine_run, drift=drift)) is None


def test_run_whose_errors_belong_to_other_times_has_no_offsets(engine_run):
    # As after a change of the speed in a live session.
    assert exact_offsets(replace(engine_run, times=engine_run.times + 0.1)) is None


def test_run_of_the_exact_model_has_no_offsets(page):
    assert page.payload["exact"] is None
    assert page.blocks.get("exact-packed", "") == ""
