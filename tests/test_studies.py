"""Smallest pitch and sensitivity, against many digits, certificates and Shapely; studies' names."""

import io
import json
import sys
from dataclasses import replace

import mpmath as mp
import numpy as np
import oracle
import pytest
import shapely
from conftest import NO_NUMBERS, assert_says, refusal
from PIL import Image
from study_answers import answer as shared_answer

from pymunk_dragon import Dragon, March, Spiral, first_contact, min_pitch, sensitivity
from pymunk_dragon.studies import STUDIES, Result, Study

SEED = {"width": 0.3, "overhang": 0.275, "head_spacing": 2.86, "body_spacing": 1.65, "pitch": 0.55}


@pytest.fixture(scope="module")
def answer():
    return shared_answer("min-pitch", min_pitch)


def hit_at(pitch, radius=4.5, dragon=None):
    march = March(dragon or Dragon(), Spiral(pitch=pitch))
    return first_contact(march, until=march.curve.at_radius(radius) - march.head_start)


def exact_sizes(**changed):
    return {name: oracle.exact(value) for name, value in (SEED | changed).items()}


# The smallest pitch


def test_the_smallest_pitch_is_that_of_fifty_digits(answer):
    assert answer.benches == (0, 19)
    # Beginning further away than the answers agree.
    time, pitch = oracle.grazing(
        (0, 19), round(answer.distance, 3), exact_sizes(pitch=round(answer.pitch, 8))
    )
    assert abs(pitch - mp.mpf("0.450337393027195485")) < 1e-16
    assert abs(answer.pitch - pitch) < 1e-12
    # The gap is stationary there.
    assert abs(answer.distance - time) < 1e-5


def test_two_benches_touch_at_the_smallest_pitch_and_overlap_at_a_smaller_one(answer):
    at, below, above = (hit_at(answer.pitch + change) for change in (1e-13, -1e-8, 1e-8))
    assert at.status == above.status == "clear"
    assert below.status == "contact"
    assert below.benches == (0, 19)
    least = min(above.near_misses, key=lambda miss: miss.gap)
    assert least.benches == (0, 19)
    assert least.gap == pytest.approx(1e-8, rel=0.01)


def test_larger_pitches_are_free_and_smaller_ones_are_not(answer):
    for pitch in (0.31, 0.36, 0.42, 0.445, 0.4502, 0.45033, 0.45034, 0.4505, 0.46, 0.52, 0.6, 0.9):
        assert (hit_at(pitch).status == "clear") == (pitch > answer.pitch), pitch
    # The head's corners reach outwards, the middle of its edge inwards: at the largest pitch no two
    # turns meet.
    middle = np.sqrt(4.5**2 - 1.43**2)
    largest, least = answer.larger_pitches[0], answer.larger_pitches[-1]
    assert largest > np.hypot(1.43 + 0.275, middle + 0.15) - (middle - 0.15)
    assert answer.contact_pitch < answer.pitch < answer.clear_pitch < least < 1.07 * answer.pitch


def test_neither_the_speed_nor_benches_further_back_than_a_turn_matter(answer):
    shown = []
    slow = min_pitch(
        Dragon(benches=25), speed=0.5, progress=lambda done, total: shown.append(done / total)
    )
    assert slow.pitch == pytest.approx(answer.pitch, abs=1e-12)
    assert slow.march.time(slow.arrival_distance) == pytest.approx(2 * answer.arrival_distance)
    assert (min(shown) > 0, max(shown), shown[-1]) == (True, 1, 1)


@pytest.mark.thorough
def test_other_dragons_and_circles_touch_at_their_smallest_pitch(answer):
    wide = Dragon(benches=24, width=[0.3] * 3 + [0.4] + [0.3] * 20)
    for dragon, radius, first in (
        (Dragon(head_spacing=1.0, overhang=0.2), 4.5, 1),
        (Dragon(body_spacing=1.7), 4.5, 0),
        (Dragon(), 3.0, 0),
        (wide, 4.5, 3),
        # Benches 0 and 2 are 0.15 m apart on a line, half the width: no pitch makes their gap
        # larger.
        (Dragon(benches=60, body_spacing=0.7), 4.5, 0),
    ):
        found = min_pitch(dragon, radius=radius)
        assert found.benches[0] == first
        assert hit_at(found.pitch - 1e-8, radius, dragon).benches == found.benches
        assert hit_at(found.pitch + 1e-8, radius, dragon).status == "clear"


def test_where_nothing_is_in_the_way_the_head_starts_on_the_circle():
    found = min_pitch(radius=8.0)
    assert found.pitch == 0.5
    assert found.arrival_distance == 0.0
    assert found.benches is None
    assert found.contact_pitch is None
    assert "0.500000000000 m" in str(found)


def test_impossible_sizes_are_refused_by_name():
    for make, *words in (
        *(
            (lambda value=value: min_pitch(radius=value), "radius", "2.86 to 100 m")
            for value in NO_NUMBERS
        ),
        (lambda: min_pitch(turns=0.05, radius=60.0), "radius", "60", "2.86 to 50 m"),
        (lambda: min_pitch(Dragon(benches=2)), "benches", "2"),
        (lambda: min_pitch(Dragon(benches=3, body_spacing=0.7)), "run into itself"),
        (lambda: min_pitch(Dragon(body_spacing=0.56)), "body_spacing", "0.56"),
        (lambda: sensitivity(Dragon(benches=25), pitch=5.0), "pitch", "runs into itself"),
        (lambda: STUDIES["min-pitch"].answer({"ratio": 2}), "ratio", "radius"),
    ):
        assert_says(refusal(make), *words)


# Sensitivity


# As many benches as the smallest pitch depends on.
SHORT = 20


@pytest.fixture(scope="module")
def sensed():
    return shared_answer("sensitivity", lambda: sensitivity(Dragon(benches=SHORT)))


@pytest.mark.thorough
def test_slopes_are_those_of_fifty_digits(sensed):
    assert sensed.contact.benches == (0, 8)
    with mp.workdps(oracle.DIGITS):
        sizes, step = exact_sizes(), mp.mpf("1e-12")
        for name, slope in sensed.times.items():
            changed = [sizes | {name: sizes[name] + side} for side in (-step, step)]
            less, more = (oracle.touching((0, 8), sensed.contact.time, each) for each in changed)
            assert abs(slope - (more - less) / (2 * step)) < 1e-5, name
        # At a smallest gap it does not matter how far the head has gone, so one place does for all.
        sizes = exact_sizes(pitch=sensed.smallest.pitch)
        way, _ = oracle.grazing((0, 19), sensed.smallest.distance, sizes)

        def growth(name):
            less, more = (
                oracle.gap(way, (0, 19), sizes | {name: sizes[name] + side})
                for side in (-step, step)
            )
            return (more - less) / (2 * step)

        for name, slope in sensed.pitches.items():
            assert abs(slope + growth(name) / growth("pitch")) < 1e-8, name
    assert f"{sensed.pitches['width']:+.7f}" in str(sensed)


@pytest.mark.thorough
def test_where_other_benches_touch_within_a_step_there_is_no_derivative():
    narrower = Dragon(benches=SHORT, width=0.3009735)
    wider = replace(narrower, width=0.3009745)
    assert first_contact(March(narrower)).benches == (0, 8)
    assert first_contact(March(wider)).benches == (0, 11)
    assert sensitivity(narrower).times["width"] is None


@pytest.mark.thorough
def test_where_the_smallest_pitch_is_limited_as_the_head_arrives_its_slope_is_that_of_differences():
    dragon = Dragon(body_spacing=1.625, benches=30)
    found = sensitivity(dragon)
    assert found.times.keys() == found.pitches.keys()
    assert found.smallest.distance == pytest.approx(found.smallest.arrival_distance, abs=1e-5)
    wider = min_pitch(replace(dragon, width=0.300001))
    assert (wider.pitch - found.smallest.pitch) / 1e-6 == pytest.approx(
        found.pitches["width"], rel=1e-4
    )


# Studies by name, and on the command line


@pytest.fixture
def known(monkeypatch, answer):
    """The study of the smallest pitch with the known answer, which is not computed again."""
    found = replace(STUDIES["min-pitch"], run=lambda dragon, progress: answer)
    monkeypatch.setitem(STUDIES, "min-pitch", found)


def test_the_program_answers_in_words_and_in_json(call, answer, known):
    assert [line.split()[0] for line in call("study")[1].splitlines()] == list(STUDIES)
    assert set(json.loads(call("study", "--json")[1])["studies"]) == set(STUDIES)
    assert call("study", "min-pitch")[1] == f"{answer}\n"
    assert str(answer).startswith("smallest pitch 0.450337393027 m")
    status, out, err = call("study", "min-pitch", "--json")
    found = json.loads(out)
    assert status == 0
    assert err == ""
    assert found["benches"] == [0, 19]
    assert found["contact_pitch"] < found["pitch"] == answer.pitch < found["clear_pitch"]


def test_a_study_brings_its_options_and_its_formats(call, monkeypatch):
    class Deepest(Result):
        def __init__(self, depth):
            self.depth = depth

        def to_dict(self):
            return {"depth": self.depth}

        def _lines(self):
            return [f"{self.depth} m"]

    added = Study(
        name="deepest",
        summary="a study of the tests",
        run=lambda dragon, *, depth=1.0, progress: Deepest(depth * dragon.width),
        flags={"depth": "how deep, m.  [1]"},
        formats=(".json",),
    )
    monkeypatch.setitem(STUDIES, "deepest", added)
    monkeypatch.delitem(
        sys.modules, "pymunk_dragon.cli.study", raising=False
    )  # It reads the registry once.
    assert (
        json.loads(call("study", "deepest", "--width", "0.2", "--depth", "3", "--json")[1])["depth"]
        == 3 * 0.2
    )
    assert Deepest(1.0)._repr_html_() == "<pre>1.0 m</pre>"
    status, _, err = call("study", "deepest", "-o", "deepest.png")
    assert (status, ".json" in err) == (2, True)
    assert "--depth FLOAT" in call("study", "--help")[1]
    status, _, err = call("study", "min-pitch", "--depth", "3")
    assert (status, "min-pitch" in err) == (2, True)


def test_picture_shows_the_two_that_touch(answer):
    artists = {part.get_gid(): part for part in answer.plot().findobj()}
    corners = [artists[f"bench-{bench}"].get_xy()[:4] for bench in (0, 19)]
    assert shapely.distance(*map(shapely.Polygon, corners)) < 1e-12
    assert tuple(artists["contact"].get_xydata()[0]) == answer.point
    with Image.open(io.BytesIO(answer.plot()._repr_png_())) as opened:
        assert opened.width == 800


def test_the_command_writes_what_the_ending_says(call, known, answer, tmp_path):
    for ending, sign in ((".svg", b"<svg"), (".png", b"PNG"), (".pdf", b"%PDF")):
        file = tmp_path / f"answer{ending}"
        assert call("study", "min-pitch", "-o", file)[0] == 0
        content = file.read_bytes()
        assert sign in content
        # The same again has the same bytes.
        answer.write_figure(file)
        assert file.read_bytes() == content
