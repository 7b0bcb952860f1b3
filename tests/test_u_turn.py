"""Question 4: the turn against many digits, its march against Shapely, and the shortest turn against brute force."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import mpmath as mp
import numpy as np
import openpyxl
import pytest
import shapely
from arc_turns import largest_ratio, random_search
from conftest import NO_NUMBERS, assert_says
from exact_curves import DIGITS, s_turn

from pymunk_dragon.cli import main
from pymunk_dragon.errors import MissingExtraError, ParameterError
from pymunk_dragon.model.curves import Composite, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies import TurnResult, max_speed, u_turn
from pymunk_dragon.studies._shortest import shortest_turn
from pymunk_dragon.studies._turns import ArcPath, Turn

BASE = UTurn()


@pytest.fixture(scope="module")
def answer() -> TurnResult:
    return u_turn(arcs=3)


def walked(curve: Composite, since: float, until: float) -> float:
    """Length in m of a path by many straight pieces, right to 1e-8 of it."""
    points = curve.point(np.linspace(since, until, 20_001))
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def fastest(march: March, ways: np.ndarray) -> np.ndarray:
    """Highest speed of any handle over that of the head at each of the head's ways, from places a moment later."""
    moment = 1e-6
    now, later = march.handles_s_or_nan(march.time(ways)), march.handles_s_or_nan(march.time(ways + moment))
    return np.max(np.abs(later - now), axis=1) / moment


def test_turn_is_the_contests_to_the_last_digits(answer: TurnResult) -> None:
    with mp.workdps(DIGITS):
        radii, centres, sweeps, _, length = s_turn(mp.mpf("1.7"), mp.mpf("4.5"), mp.mpf(2))
        expected = [float(part) for part in (*radii, *sweeps, length)]
        middles = [[float(centre.real), float(centre.imag)] for centre in centres]
    assert [*answer.turn.radii, *answer.turn.sweeps, answer.turn.length] == pytest.approx(expected, abs=1e-12)
    assert answer.turn.centres.tolist() == [pytest.approx(middle, abs=1e-12) for middle in middles]


def test_no_two_arcs_make_the_turn_shorter(answer: TurnResult) -> None:
    for ratio, length in answer.lengths:
        turn = UTurn(ratio=ratio)
        assert walked(turn, 0, turn.joints[-1]) == pytest.approx(answer.turn.length, rel=1e-7)
        assert length == pytest.approx(answer.turn.length, rel=1e-14)
    assert len({ratio for ratio, _ in answer.lengths}) >= 5


@pytest.mark.thorough
def test_dragon_gets_round_both_turns_without_touching_itself(answer: TurnResult) -> None:
    for march, contact in ((answer.march, answer.contact), (answer.shortest_march, answer.shortest_contact)):
        assert (contact.status, contact.time) == ("clear", 100)
        # At one of the times every other metre, by somebody else's geometry.
        for poses in march.at(np.arange(-10.0, 100.5, 2.0)).poses:
            benches = shapely.polygons(march.dragon.outlines(poses))
            first, second = shapely.STRtree(benches).query(benches, predicate="intersects")
            assert np.abs(first - second).max() == 1


def test_no_handle_is_faster_than_is_certified(answer: TurnResult) -> None:
    ways = np.arange(-3, 40, 0.01)
    assert answer.shortest is not None
    for march, most in ((answer.march, answer.peak_speed_ratio), (answer.shortest_march, answer.shortest.ratio)):
        assert march is not None
        seen = fastest(march, ways)
        assert most.excess <= 1e-11
        assert seen.max() <= most.ratio + 1e-6
        assert seen.max() == pytest.approx(most.ratio, abs=1e-4)
        assert ways[seen.argmax()] == pytest.approx(most.distance, abs=0.02) or seen.max() - most.ratio < 1e-4
    assert answer.shortest.ratio.ratio <= answer.peak_speed_ratio.ratio
    assert answer.shortest.ratio.ratio == pytest.approx(answer.peak_speed_ratio.ratio, rel=1e-5)


def test_fastest_handle_is_the_one_that_limits_the_heads_speed(answer: TurnResult) -> None:
    # Enclosed there by branch and bound.
    largest = max_speed()
    assert (answer.peak_speed_ratio.ratio, answer.peak_speed_ratio.handle) == (largest.ratio, largest.handle)
    assert answer.peak_speed_ratio.distance == pytest.approx(largest.distance, abs=1e-5)


def test_shortest_turn_on_three_arcs_is_a_sixth_shorter_and_stays_in_the_circle(answer: TurnResult) -> None:
    assert answer.shortest is not None
    short = answer.shortest.turn
    # The closed form and the linear programming of an earlier version found this turn, too.
    assert short.length == pytest.approx(11.28054, abs=1e-4)
    assert walked(short.path, 0, short.path.joints[-1]) == pytest.approx(short.length, rel=1e-7)
    inside = short.path.point(np.linspace(0, short.length, 3001))
    assert np.hypot(*inside.T).max() <= 4.5 + 1e-12
    # Entry and exit are those of the contest's turn.
    ends = short.path.point([0, short.length])
    assert ends == pytest.approx(answer.turn.tangent_points[[0, 2]], abs=1e-12)


def unknowns(turn: Turn) -> np.ndarray:
    return np.array([*turn.curvatures, *turn.lengths])


def assert_tangent_in_many_digits(turn: Turn) -> None:
    """Arcs laid end to end in 34 digits come to the exit with its tangent."""
    with mp.workdps(DIGITS):
        entry = mp.mpf("4.5") * mp.expj(2 * mp.pi * mp.mpf("4.5") / mp.mpf("1.7"))
        angle = mp.arg(entry) + mp.atan(2 * mp.pi * mp.mpf("4.5") / mp.mpf("1.7")) - mp.pi
        point, heading = entry, angle
        for curvature, length in zip(turn.curvatures, turn.lengths, strict=True):
            k, way = mp.mpf(curvature), mp.mpf(length)
            point += way * mp.expj(heading) if k == 0 else (mp.expj(heading + k * way) - mp.expj(heading)) / (1j * k)
            heading += k * way
        assert abs(point + entry) < 1e-12
        assert abs(heading - angle) < 1e-12


def test_arcs_of_the_shortest_turn_are_tangent_in_many_digits(answer: TurnResult) -> None:
    assert answer.shortest is not None
    assert_tangent_in_many_digits(answer.shortest.turn)


@pytest.mark.parametrize("count", [3, 7])
def test_derivatives_of_a_path_are_those_of_differences(count: int) -> None:
    rng = np.random.default_rng(count)
    x = np.concatenate([rng.uniform(-1, 1, count), rng.uniform(0.5, 2, count)])
    # A straight arc, and a short one.
    x[1], x[-1] = 1e-9, 0.03
    s = np.linspace(-2.0, x[count:].sum() + 3, 40)
    path = ArcPath(BASE, x)
    slopes, turns = path.partials(s, *path.at(s))
    error, of_error = path.end_error()
    radii, of_radii = path.squared_radii()
    for k, unit in enumerate(np.eye(2 * count)):
        one, other = (ArcPath(BASE, x + side * 1e-6 * unit) for side in (1, -1))
        _, tangents, _ = path.at(s)
        changed = (one.at(s)[0] - other.at(s)[0]) / 2e-6
        assert slopes[:, k] == pytest.approx(changed, abs=1e-7)
        assert turns[:, k] == pytest.approx(((one.at(s)[1] - other.at(s)[1]) / 2e-6 / tangents).imag, abs=1e-7)
        assert of_error[:, k] == pytest.approx((one.end_error()[0] - other.end_error()[0]) / 2e-6, abs=1e-7)
        assert of_radii[:, k] == pytest.approx((one.squared_radii()[0] - other.squared_radii()[0]) / 2e-6, abs=1e-6)
    assert error.shape == (3,)
    assert radii.shape == (2 * count - 1,)


def test_brute_force_sees_the_same_largest_speed(answer: TurnResult) -> None:
    assert answer.shortest is not None
    (first, second), angle = answer.turn.radii, answer.turn.sweeps[1]
    contests = [-1 / first, 1 / second, first * angle, second * angle]
    assert largest_ratio(contests) == pytest.approx(answer.peak_speed_ratio.ratio, abs=1e-3)
    assert largest_ratio(unknowns(answer.shortest.turn)) == pytest.approx(answer.shortest.ratio.ratio, abs=2e-3)


@pytest.mark.thorough
def test_no_random_turn_near_the_shortest_one_is_shorter_and_keeps_to_the_limit(answer: TurnResult) -> None:
    assert answer.shortest is not None
    # What brute force sees of a speed is right to 0.001; the length changes by about 5 m for a unit of it.
    length, _ = random_search(3, answer.max_ratio - 1e-3, 40, start=unknowns(answer.shortest.turn))
    assert length >= answer.shortest.turn.length - 0.01


@pytest.mark.thorough
def test_more_arcs_make_the_turn_shorter() -> None:
    """On five arcs it is 8 % shorter than on three, and without a contact; a random search finds no shorter one."""
    found = u_turn(arcs=7)
    assert found.shortest is not None
    assert found.shortest_contact is not None
    assert found.shortest_march is not None
    (_, three), (_, five), (_, seven) = found.shortest.lengths
    assert three == pytest.approx(11.2805, abs=1e-3)
    assert five < 10.51
    assert seven < 10.35
    assert found.shortest_contact.status == "clear"
    assert found.shortest.ratio.ratio <= found.max_ratio
    assert_tangent_in_many_digits(found.shortest.turn)
    assert fastest(found.shortest_march, np.arange(-3, 40, 0.01)).max() <= found.max_ratio + 1e-6
    assert random_search(5, found.max_ratio, 300)[0] > five - 0.01


def test_search_reports_its_progress() -> None:
    shown: list[tuple[float, float]] = []
    u_turn(Dragon(benches=12), arcs=3, progress=lambda done, total: shown.append((done, total)))
    assert shown[-1][0] == shown[-1][1]
    assert len(shown) > 1


def test_without_the_search_nothing_is_searched(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["study", "u-turn", "--no-search", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told["shortest"] is None
    assert told["contact"]["status"] == "clear"


def test_answer_in_words_names_the_family_and_claims_no_proof(answer: TurnResult) -> None:
    text = " ".join(str(answer).split())
    assert "best found, not proven to be the shortest" in text
    assert "radii of at least 0.5 m" in text
    assert "11.2805 m on 3" in text


def test_missing_scipy_is_named_before_any_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    monkeypatch.setattr(sys.modules["pymunk_dragon.studies.u_turn"], "largest_ratio", None)
    with pytest.raises(MissingExtraError) as caught:
        u_turn()
    assert_says(caught.value, "the search for the shortest turn", "pymunk-dragon[studies]")


@pytest.mark.parametrize("value", [*NO_NUMBERS, 0.01, 4.6], ids=repr)
def test_impossible_least_radii_are_refused(value: object) -> None:
    with pytest.raises(ParameterError) as caught:
        u_turn(min_radius=value)
    assert_says(caught.value, "min_radius is", "0.05 to 4.5 m")


@pytest.mark.parametrize("value", [2, 4, 17, 3.0, True, "7"], ids=repr)
def test_impossible_numbers_of_arcs_are_refused(value: object) -> None:
    with pytest.raises(ParameterError) as caught:
        u_turn(arcs=value)
    assert_says(caught.value, "arcs is", "3 to 15")


def test_contests_sheet_has_all_times_from_before_the_circle_to_after_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "result4.xlsx"
    with pytest.raises(SystemExit) as stop:
        main(["study", "u-turn", "--benches", "12", "--arcs", "3", "-o", str(file), "--json"])
    assert stop.value.code in (0, None)
    told = json.loads(capsys.readouterr().out)
    assert {"length", "radii", "centres"} <= told.keys()
    assert told["length"] == pytest.approx(13.621245, abs=1e-6)
    assert told["contact"]["status"] == told["shortest"]["contact"]["status"] == "clear"
    book = openpyxl.load_workbook(file)
    places, speeds = ([*book[name].iter_rows(values_only=True)] for name in ("位置", "速度"))
    assert places[0] == (None, *(f"{time} s" for time in range(-100, 101)))
    assert speeds[0] == places[0]
    assert [row[0] for row in places[1:3]] == ["龙头x (m)", "龙头y (m)"]
    assert (len(places), len(speeds)) == (1 + 2 * 13, 1 + 13)
    assert (places[1][101], places[2][101]) == (-2.711856, -3.591078)
    assert set(speeds[1][1:]) == {1.0}
    march = March(Dragon(benches=12), UTurn())
    states = march.at([-100.0, 14.0, 100.0])
    for column, at in ((1, 0), (115, 1), (201, 2)):
        found = np.array([row[column] for row in places[1:]]).reshape(-1, 2)
        assert found == pytest.approx(states.positions[at], abs=6e-7)
        assert [row[column] for row in speeds[1:]] == pytest.approx(states.speeds[at].tolist(), abs=6e-7)


def test_picture_shows_both_turns_and_who_hurries(answer: TurnResult) -> None:
    drawn = answer.plot()
    two, three, below = drawn.axes
    lines = {line.get_gid(): line for line in below.get_lines()}
    for axes, march in ((two, answer.march), (three, answer.shortest_march)):
        joints = next(line for line in axes.get_lines() if line.get_gid() == "joints")
        assert joints.get_xydata() == pytest.approx(march.curve.point(march.curve.joints))
    for gid in ("speeds", "short-speeds"):
        assert lines[gid].get_ydata().max() == pytest.approx(answer.max_ratio, abs=0.01)


@pytest.mark.parametrize("value", [*(value for value in NO_NUMBERS if value is not None), 1.0, 5.1], ids=repr)
def test_impossible_limits_are_refused(value: object) -> None:
    with pytest.raises(ParameterError) as caught:
        u_turn(fastest=value)
    assert_says(caught.value, "fastest is", "from 1.01 to 5")


@pytest.mark.thorough
def test_a_limit_that_no_turn_keeps_to_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        shortest_turn(BASE, Dragon(), 1.05, 3, 0.5)
    assert_says(caught.value, "fastest is 1.05, but must be higher")


def test_a_circle_in_which_the_dragon_gets_stuck_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        u_turn(Dragon(benches=12), radius=1.8)
    assert_says(caught.value, "radius is 1.8, but must be large enough")
