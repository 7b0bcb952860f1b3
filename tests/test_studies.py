"""Studies: against many digits, against Shapely, against certificates, and where looking every so often goes wrong."""

from __future__ import annotations

import io
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import oracle
import pytest
import shapely
from conftest import NO_NUMBERS, assert_says
from PIL import Image

from pymunk_dragon.cli import cli, main
from pymunk_dragon.collision import first_contact, scan
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies import STUDIES, MinPitch, Sensitivity, Study, min_pitch, sensitivity, study
from pymunk_dragon.studies._gaps import SIZES, InwardMarch, gaps_of
from pymunk_dragon.studies._study import Option

SEED = {"width": 0.3, "overhang": 0.275, "head_spacing": 2.86, "body_spacing": 1.65, "pitch": 0.55}


@pytest.fixture(scope="module")
def answer() -> MinPitch:
    return min_pitch()


def march_at(pitch: float, **sizes: Any) -> March:
    return March(Dragon(**sizes), Spiral(pitch=pitch))


def inward_at(pitch: float, radius: float = 4.5, **sizes: Any) -> InwardMarch:
    return InwardMarch(dragon=Dragon(**sizes), pitch=pitch, turns=16.0, radius=radius)


def hit_at(pitch: float, radius: float = 4.5, **sizes: Any) -> Any:
    inward = inward_at(pitch, radius, **sizes)
    return first_contact(inward.march, until=inward.length)


def exact_sizes(**changed: Any) -> dict[str, Any]:
    return {name: oracle.exact(value) for name, value in (SEED | changed).items()}


# The smallest pitch


def test_the_smallest_pitch_is_that_of_fifty_digits(answer: MinPitch) -> None:
    assert answer.benches == (0, 19)
    assert answer.limit == "passing"
    # Beginning further away than the answers agree.
    time, pitch = oracle.grazing((0, 19), round(answer.distance, 6), exact_sizes(pitch=round(answer.pitch, 8)))
    assert abs(pitch - mp.mpf("0.450337393027195485")) < 1e-16
    assert abs(answer.pitch - pitch) < 1e-12
    assert abs(answer.distance - time) < 1e-6


def test_two_benches_touch_there_without_overlapping(answer: MinPitch) -> None:
    assert answer.gap is not None
    assert 0 <= answer.gap < 1e-12
    assert hit_at(answer.pitch).status == "clear"


def test_a_pitch_a_little_smaller_collides_and_one_a_little_larger_does_not(answer: MinPitch) -> None:
    below, above = hit_at(answer.pitch - 1e-8), hit_at(answer.pitch + 1e-8)
    assert (below.status, below.benches) == ("contact", (0, 19))
    assert above.status == "clear"
    least = min(above.near_misses, key=lambda miss: miss.gap)
    assert least.benches == (0, 19)
    assert least.gap == pytest.approx(1e-8, rel=0.01)


@pytest.mark.parametrize("pitch", [0.31, 0.36, 0.4, 0.42, 0.435, 0.445, 0.449, 0.4502, 0.45033])
def test_smaller_pitches_are_not_free(answer: MinPitch, pitch: float) -> None:
    assert hit_at(pitch).status in ("contact", "overlapping")


@pytest.mark.parametrize("pitch", [0.45034, 0.4505, 0.452, 0.46, 0.48, 0.52, 0.6, 0.9])
def test_larger_pitches_are_free(answer: MinPitch, pitch: float) -> None:
    assert hit_at(pitch).status == "clear"


@pytest.mark.thorough
def test_no_bench_of_the_whole_dragon_overlaps_another_on_the_way_in_shapelys_eyes(answer: MinPitch) -> None:
    march = answer.march
    times = np.append(np.arange(0.0, answer.arrival_distance, 2.0), answer.distance)
    first, second = np.triu_indices(march.dragon.benches, 2)
    for time in times:
        benches = shapely.polygons(march.dragon.outlines(march.at(time).poses[0]))
        near = (
            np.hypot(
                *(
                    shapely.get_coordinates(shapely.centroid(benches))[first]
                    - shapely.get_coordinates(shapely.centroid(benches))[second]
                ).T
            )
            < 3.5
        )
        gaps = shapely.distance(benches[first[near]], benches[second[near]])
        assert gaps.min() > 1e-4 or time == answer.distance
    assert gaps.min() < 1e-12


@pytest.mark.thorough
def test_a_scan_every_second_finds_a_pitch_that_is_too_small(answer: MinPitch) -> None:
    blocked, free = 0.4495, 0.4505
    while free - blocked > 1e-6:
        middle = (blocked + free) / 2
        if scan(march_at(middle), step=1.0, until=inward_at(middle).length).status == "clear":
            free = middle
        else:
            blocked = middle
    assert free < answer.pitch - 1e-5
    assert hit_at(free).status == "contact"


def test_the_map_has_its_zero_where_the_answer_is(answer: MinPitch) -> None:
    known = answer.map
    assert answer.half_line
    assert np.all((known.gaps > 0) == (known.pitches > answer.pitch))
    assert known.pitches[0] == pytest.approx(0.3, rel=1e-5)
    assert known.pitches[-1] > 0.6
    assert np.interp(answer.pitch, known.pitches, known.gaps) == pytest.approx(0, abs=1e-4)


def test_gaps_near_zero_grow_with_the_pitch_on_the_same_circle(answer: MinPitch) -> None:
    assert answer.map.growth is not None
    least, most = answer.map.growth
    assert 0.4 < least < most < 1.5
    # The same by difference, of the head and of the bench that it passes, on a circle of 4.6 m.
    gaps = []
    for pitch in (0.4502, 0.4504):
        inward = inward_at(pitch, 4.6)
        gaps.append(gaps_of(inward, inward.length, (0, 19)).gaps[0])
    assert least < (gaps[1] - gaps[0]) / 2e-4 < most


def test_speed_changes_times_only(answer: MinPitch) -> None:
    slow = min_pitch(speed=0.5)
    assert slow.pitch == pytest.approx(answer.pitch, abs=1e-12)
    assert slow.march.time(slow.arrival_distance) == pytest.approx(2 * answer.arrival_distance)


def test_benches_further_back_than_a_turn_do_not_matter(answer: MinPitch) -> None:
    assert min_pitch(Dragon(benches=25)).pitch == pytest.approx(answer.pitch, abs=1e-12)


@pytest.mark.thorough
def test_a_long_body_meets_itself_before_its_short_head_does() -> None:
    found = min_pitch(Dragon(head_spacing=1.0, overhang=0.2))
    assert found.benches is not None
    assert found.benches[0] == 1
    assert hit_at(found.pitch - 1e-8, head_spacing=1.0, overhang=0.2).benches == found.benches
    assert hit_at(found.pitch + 1e-8, head_spacing=1.0, overhang=0.2).status == "clear"


def test_where_nothing_is_in_the_way_the_head_starts_on_the_circle() -> None:
    found = min_pitch(radius=8.0)
    assert (found.pitch, found.limit, found.arrival_distance) == (0.5, "circle", 0.0)
    assert (found.benches, found.gap, found.contact_pitch) == (None, None, None)


@pytest.mark.thorough
def test_a_smaller_circle_needs_a_larger_pitch(answer: MinPitch) -> None:
    found = min_pitch(radius=3.0)
    assert found.pitch > answer.pitch
    assert hit_at(found.pitch - 1e-8, radius=3.0).benches == found.benches
    assert hit_at(found.pitch, radius=3.0).status == "clear"


@pytest.mark.thorough
def test_where_the_search_looks_past_a_limit_certificates_find_it(
    answer: MinPitch, monkeypatch: pytest.MonkeyPatch
) -> None:
    # So few samples contain no gap of the head's that is smallest in between.
    monkeypatch.setattr("pymunk_dragon.studies._gaps.SAMPLES_PER_SPACING", 0.02)
    assert min_pitch(Dragon(benches=25)).pitch == pytest.approx(answer.pitch, abs=2e-9)


@pytest.mark.parametrize("value", NO_NUMBERS)
def test_a_radius_that_is_no_length_is_refused(value: Any) -> None:
    with pytest.raises(ParameterError) as caught:
        min_pitch(radius=value)
    assert_says(caught.value, "radius", "2.86 to 100 m")


def test_a_circle_larger_than_any_start_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        min_pitch(turns=0.05, radius=60.0)
    assert_says(caught.value, "radius", "60", "2.86 to 50 m")


def test_a_dragon_too_short_to_pass_itself_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        min_pitch(Dragon(benches=5))
    assert_says(caught.value, "benches", "5")


# Sensitivity


@pytest.fixture(scope="module")
def sensed() -> Sensitivity:
    return sensitivity()


def contact_time(sizes: dict[str, Any], time: float) -> Any:
    """When the gap of benches 0 and 8 closes, by Newton's method on differences."""
    t, step = mp.mpf(time), mp.mpf("1e-15")
    for _ in range(5):
        gap = oracle.gap(t, (0, 8), sizes)
        t -= gap * step / (oracle.gap(t + step, (0, 8), sizes) - gap)
    return t


@pytest.mark.parametrize("name", SIZES)
def test_slopes_of_the_contact_time_are_those_of_fifty_digits(sensed: Sensitivity, name: str) -> None:
    assert sensed.benches == (0, 8)
    with mp.workdps(oracle.DIGITS):
        sizes, step = exact_sizes(), mp.mpf("1e-12")
        less, more = (contact_time(sizes | {name: sizes[name] + change}, sensed.time) for change in (-step, step))
        slope = (more - less) / (2 * step)
    found = next(each for each in sensed.times if each.size == name)
    assert abs(found.slope - slope) < 1e-9 * abs(slope)
    assert found.value == SEED[name]


def test_slopes_of_the_smallest_pitch_are_those_of_fifty_digits(sensed: Sensitivity) -> None:
    # At a smallest gap it does not matter how far the head has gone, so one place does for all.
    way, pair = sensed.smallest.distance, (0, 19)
    with mp.workdps(oracle.DIGITS):
        sizes, step = exact_sizes(pitch=sensed.smallest.pitch), mp.mpf("1e-12")

        def slope(name: str) -> Any:
            less, more = (oracle.gap(way, pair, sizes | {name: sizes[name] + change}) for change in (-step, step))
            return (more - less) / (2 * step)

        by_pitch = slope("pitch")
        slopes = {name: -slope(name) / by_pitch for name in SIZES if name != "pitch"}
    assert [found.size for found in sensed.pitches] == list(slopes)
    for found in sensed.pitches:
        assert abs(found.slope - slopes[found.size]) < 1e-7 * abs(slopes[found.size])


@pytest.mark.thorough
def test_the_smallest_pitch_of_wider_benches_is_where_the_slope_says(sensed: Sensitivity) -> None:
    changes = {"width": 1e-6, "overhang": 1e-6, "head_spacing": 1e-5, "body_spacing": 1e-5}
    for found, (name, change) in zip(sensed.pitches, changes.items(), strict=True):
        assert found.size == name
        other = min_pitch(Dragon(**{name: SEED[name] + change})).pitch
        assert (other - sensed.smallest.pitch) / change == pytest.approx(found.slope, rel=1e-3)


@pytest.mark.thorough
def test_a_contact_holds_as_far_as_is_told_and_another_pair_meets_beyond(sensed: Sensitivity) -> None:
    for found in sensed.times:
        for reach in (found.less, found.more):
            assert reach is not None
            hits = [
                first_contact(inward_at(0.55).changed(found.size, change).march)
                for change in (reach.unchanged, reach.changed)
                if change is not None
            ]
            assert hits[0].benches == (0, 8)
            assert len(hits) == 1 or hits[1].benches != (0, 8)
            if reach.by == "another pair":
                assert hits[1].benches == reach.benches == (0, 11)
            if reach.changed is not None:
                assert abs(reach.changed - reach.unchanged) < 0.003 * abs(reach.changed)


def test_benches_a_millimetre_wider_meet_bench_11_instead(sensed: Sensitivity) -> None:
    width = sensed.times[0]
    assert width.size == "width"
    assert width.more is not None
    assert width.more.changed is not None
    assert width.more.unchanged < 0.0009741 < width.more.changed


@pytest.mark.thorough
def test_another_pair_limits_the_pitch_beyond_what_is_told(sensed: Sensitivity) -> None:
    head = sensed.pitches[2]
    assert head.size == "head_spacing"
    assert head.less is not None
    assert head.less.changed is not None
    spacings = [2.86 + head.less.unchanged, 2.86 + head.less.changed]
    assert [min_pitch(Dragon(head_spacing=spacing)).benches for spacing in spacings] == [(0, 19), head.less.benches]


@pytest.mark.thorough
def test_a_pitch_that_is_limited_at_the_arrival_has_slopes_too() -> None:
    dragon = Dragon(body_spacing=1.625, benches=30)
    found = sensitivity(dragon)
    assert found.smallest.limit == "arrival"
    width = found.pitches[0]
    wider = min_pitch(replace(dragon, width=0.300001))
    assert (wider.pitch - found.smallest.pitch) / 1e-6 == pytest.approx(width.slope, rel=1e-4)
    assert width.less is width.more is None


@pytest.mark.thorough
def test_times_at_half_the_speed_move_twice_as_much(sensed: Sensitivity) -> None:
    slow = sensitivity(Dragon(benches=30), speed=0.5)
    for found, other in zip(sensed.times, slow.times, strict=True):
        assert other.slope == pytest.approx(2 * found.slope, rel=1e-6)


def test_a_dragon_that_never_meets_itself_has_no_contact_to_move() -> None:
    with pytest.raises(ParameterError) as caught:
        sensitivity(Dragon(benches=2))
    assert_says(caught.value, "pitch", "runs into itself")


# Studies by name, and on the command line


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stopped:
        main(["study", *arguments])
    out, err = capsys.readouterr()
    assert isinstance(stopped.value.code, int)
    return stopped.value.code, out, err


def test_without_a_name_the_studies_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys)
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == list(STUDIES)
    _, out, _ = run(capsys, "--json")
    assert set(json.loads(out)["studies"]) == set(STUDIES)


def test_json_holds_the_answer_and_its_evidence(capsys: pytest.CaptureFixture[str], answer: MinPitch) -> None:
    status, out, err = run(capsys, "min-pitch", "--json")
    found = json.loads(out)
    assert (status, err) == (0, "")
    assert found["pitch"] == answer.pitch
    assert found["benches"] == [0, 19]
    assert found["contact_pitch"] < found["pitch"] < found["clear_pitch"]
    assert found["half_line"] is True
    assert len(found["map"]["pitches"]) == len(found["map"]["gaps"])


def test_words_tell_the_answer_and_what_certifies_it(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run(capsys, "min-pitch")
    assert out.startswith("smallest pitch 0.450337393027 m")
    assert "benches 0 and 19" in out
    assert "certified" in out
    assert max(map(len, out.splitlines())) < 130


@pytest.mark.thorough
def test_a_scenario_gives_the_dragon_and_flags_win(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    file.write_text("pitch = 0.6\nwidth = 0.2\nbenches = 30\n", encoding="utf-8")
    _, out, _ = run(capsys, "min-pitch", "--scenario", str(file), "--json")
    assert json.loads(out)["pitch"] == min_pitch(Dragon(width=0.2, benches=30)).pitch
    _, out, _ = run(capsys, "min-pitch", "--scenario", str(file), "--width", "0.3", "--json")
    assert json.loads(out)["pitch"] == min_pitch(Dragon(benches=30)).pitch


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["min-pitch", "--radius", "1"], ("radius", "2.86 to 100 m")),
        (["min-pitch", "--radius", "nan"], ("radius", "nan")),
        (["min-pitch", "--radius", "many"], ("radius", "many")),
        (["min-pitch", "--pitch", "0.5"], ("pitch", "left out")),
        (["min-pitch", "--benches", "5"], ("benches", "5")),
        (["min-pitch", "-o", "answer.gif"], ("-o is", "answer.gif", ".json or .png or .svg or .pdf")),
        (["nothing"], ("study", "nothing", "min-pitch")),
    ],
)
def test_bad_input_gets_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: tuple[str, ...]
) -> None:
    status, out, err = run(capsys, *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert all(word in err for word in words)


def test_json_of_sensitivity_has_a_slope_for_each_size(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, sensed: Sensitivity
) -> None:
    monkeypatch.setitem(STUDIES, "sensitivity", replace(STUDIES["sensitivity"], run=lambda dragon, progress: sensed))
    _, out, _ = run(capsys, "sensitivity", "--json")
    found = json.loads(out)
    assert found["contact"]["time"] == sensed.time
    assert list(found["contact"]["slopes"]) == list(SIZES)
    assert found["contact"]["slopes"]["width"]["slope"] == sensed.times[0].slope
    assert found["smallest_pitch"]["slopes"]["overhang"]["more"]["changed"] is None
    _, out, _ = run(capsys, "sensitivity")
    assert "-0.0320404" in out
    assert max(map(len, out.splitlines())) < 120


def test_a_result_is_what_the_program_prints(capsys: pytest.CaptureFixture[str], answer: MinPitch) -> None:
    _, out, _ = run(capsys, "min-pitch")
    assert out == f"{answer}\n"
    _, out, _ = run(capsys, "min-pitch", "--json")
    assert json.loads(out) == json.loads(json.dumps(answer.to_dict()))
    assert repr(answer).startswith("<MinPitch: smallest pitch 0.450337393027 m")
    assert "\n" not in repr(answer)


def test_equal_studies_have_equal_results() -> None:
    one, two, other = (min_pitch(Dragon(benches=benches)) for benches in (25, 25, 26))
    assert one == two
    assert one != other


def test_a_study_brings_its_options_and_its_formats(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, answer: MinPitch
) -> None:
    def deepest(dragon: Dragon, *, depth: float = 1.0, progress: Any) -> MinPitch:
        return replace(answer, pitch=depth * dragon.width)

    added = Study(
        name="deepest",
        summary="a study of the tests",
        run=deepest,
        options={"depth": Option(kind=float, metavar="M", text="how deep, m.  [1]")},
    )
    monkeypatch.setattr(cli.commands["study"], "params", cli.commands["study"].params.copy())
    monkeypatch.setitem(STUDIES, "deepest", added)
    assert json.loads(run(capsys, "deepest", "--width", "0.2", "--depth", "3", "--json")[1])["pitch"] == 3 * 0.2
    assert "--depth M" in run(capsys, "--help")[1]
    status, _, err = run(capsys, "min-pitch", "--depth", "3")
    assert (status, "left out: min-pitch takes" in err) == (2, True)


# Pictures


def artist(drawing: Any, gid: str) -> Any:
    [found] = drawing.findobj(lambda part: part.get_gid() == gid)
    return found


def test_the_pitch_s_picture_shows_the_zero_and_the_two_that_touch(answer: MinPitch) -> None:
    drawing = answer.plot()
    (x,), (y,) = artist(drawing, "answer").get_data()
    assert (x, y) == (answer.pitch, 0)
    _, gaps = artist(drawing, "gap-over-pitch").get_data()
    np.testing.assert_allclose(gaps, 1e3 * answer.map.gaps)
    corners = [artist(drawing, f"bench-{bench}").get_xy()[:4] for bench in (0, 19)]
    assert shapely.distance(*map(shapely.Polygon, corners)) < 1e-12


def test_the_picture_of_slopes_shows_each_of_them(sensed: Sensitivity) -> None:
    drawing = sensed.plot()
    found = drawing.findobj(lambda part: str(part.get_gid()).startswith("slope-"))
    assert len(found) == len(sensed.times) + len(sensed.pitches)
    assert found[0].get_xdata()[0] == pytest.approx(abs(sensed.times[0].slope) / 1e3)


@pytest.mark.parametrize("ending", [".png", ".svg", ".pdf"])
def test_pictures_are_written(answer: MinPitch, sensed: Sensitivity, tmp_path: Path, ending: str) -> None:
    for found in (answer, sensed, min_pitch(radius=8.0)):
        file = tmp_path / f"answer{ending}"
        found.write_figure(file)
        if ending == ".png":
            with Image.open(file) as picture:
                assert picture.width == 1600
        assert file.stat().st_size < 300_000
        content = file.read_bytes()
        found.write_figure(file)
        assert file.read_bytes() == content


def test_the_command_writes_what_the_ending_says(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, answer: MinPitch, tmp_path: Path
) -> None:
    monkeypatch.setitem(STUDIES, "min-pitch", replace(STUDIES["min-pitch"], run=lambda dragon, progress: answer))
    for ending in (".json", ".png", ".svg", ".pdf"):
        assert run(capsys, "min-pitch", "-o", str(tmp_path / f"answer{ending}"))[0] == 0
    assert json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))["pitch"] == answer.pitch
    assert (tmp_path / "answer.png").read_bytes()[:4] == b"\x89PNG"
    assert b"<svg" in (tmp_path / "answer.svg").read_bytes()


def test_without_matplotlib_nothing_is_asked(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(STUDIES, "min-pitch", replace(STUDIES["min-pitch"], run=None))
    status, _, err = run(capsys, "min-pitch", "-o", str(tmp_path / "answer.png"))
    assert status == 2
    assert "pymunk-dragon[figures]" in err
    assert not list(tmp_path.iterdir())


def test_a_notebook_shows_the_picture_of_a_result_where_it_can_be_drawn(
    answer: MinPitch, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = answer._repr_png_()
    assert picture is not None
    with Image.open(io.BytesIO(picture)) as opened:
        assert opened.width == 800
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert answer._repr_png_() is None


def test_a_number_that_a_study_does_not_take_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        study("min-pitch", {"ratio": 2})
    assert_says(caught.value, "ratio", "left out", "radius")


@pytest.mark.parametrize("name", ["max-speed", "min-pitch"])
def test_studies_report_their_progress(name: str) -> None:
    shown: list[tuple[float, float]] = []
    study(name, {}, lambda done, total: shown.append((done, total)))
    assert shown
    assert shown[-1][0] == shown[-1][1]
    assert all(0 <= done <= total for done, total in shown)


def test_a_study_shows_its_progress_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    with pytest.raises(SystemExit):
        main(["study", "max-speed"])
    assert "max-speed" in screen.getvalue()
    assert "100%" in screen.getvalue()


def test_benches_whose_ends_are_close_on_a_straight_line_have_a_smallest_pitch() -> None:
    """Benches 0 and 2 are 0.15 m apart on a line, half the width: no pitch makes their gap larger."""
    found = min_pitch(Dragon(benches=60, body_spacing=0.7))
    assert first_contact(found.march, until=found.arrival_distance).status == "clear"
    assert 0 < found.map.gaps[-1] < 0.15
    with pytest.raises(ParameterError, match="run into itself"):
        min_pitch(Dragon(benches=3, body_spacing=0.7))
