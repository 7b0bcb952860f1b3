"""Question 4: the turn against many digits, its march against Shapely, and the shortest turn against brute force."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path

import mpmath as mp
import numpy as np
import openpyxl
import pytest
import shapely
from conftest import NO_NUMBERS, assert_says
from exact_curves import DIGITS, s_turn

from pymunk_dragon.cli import main
from pymunk_dragon.curves import Composite, UTurn, chain
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.render.figures import answer_figure
from pymunk_dragon.studies import TurnAnswer, max_speed, u_turn
from pymunk_dragon.studies.shortest import hurry, shortest_turn
from pymunk_dragon.studies.turns import three_arcs

BASE = UTurn()


@pytest.fixture(scope="module")
def answer() -> TurnAnswer:
    return u_turn()


def walked(curve: Composite, since: float, until: float) -> float:
    """Length in m of a path by many straight pieces, right to 1e-8 of it."""
    points = curve.point(np.linspace(since, until, 20_001))
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def fastest(march: March, ways: np.ndarray) -> np.ndarray:
    """Highest speed of any handle over that of the head at each of the head's ways, from places a moment later."""
    moment = 1e-6
    now, later = march.places(march.time(ways)), march.places(march.time(ways + moment))
    return np.max(np.abs(later - now), axis=1) / moment


def test_turn_is_the_contests_to_the_last_digits(answer: TurnAnswer) -> None:
    with mp.workdps(DIGITS):
        radii, centres, sweeps, _, length = s_turn(mp.mpf("1.7"), mp.mpf("4.5"), mp.mpf(2))
        expected = [float(part) for part in (*radii, *sweeps, length)]
        middles = [[float(centre.real), float(centre.imag)] for centre in centres]
    assert [*answer.turn.radii, *answer.turn.sweeps, answer.turn.length] == pytest.approx(expected, abs=1e-12)
    assert answer.turn.centres.tolist() == [pytest.approx(middle, abs=1e-12) for middle in middles]


def test_no_two_arcs_make_the_turn_shorter(answer: TurnAnswer) -> None:
    for ratio, length in answer.lengths:
        turn = UTurn(ratio=ratio)
        assert walked(turn, 0, turn.joints[-1]) == pytest.approx(answer.turn.length, rel=1e-7)
        assert length == pytest.approx(answer.turn.length, rel=1e-14)
    assert len({ratio for ratio, _ in answer.lengths}) >= 5


@pytest.mark.thorough
def test_dragon_gets_round_both_turns_without_touching_itself(answer: TurnAnswer) -> None:
    for march, impact in ((answer.march, answer.impact), (answer.short_march, answer.short_impact)):
        assert (impact.status, impact.time) == ("clear", 100)
        # At one of the times every other metre, by somebody else's geometry.
        for poses in march.at(np.arange(-10.0, 100.5, 2.0)).poses:
            benches = shapely.polygons(march.dragon.outlines(poses))
            first, second = shapely.STRtree(benches).query(benches, predicate="intersects")
            assert np.abs(first - second).max() == 1


def test_nobody_has_to_hurry_more_than_is_said(answer: TurnAnswer) -> None:
    ways = np.arange(-3, 40, 0.01)
    for march, most in ((answer.march, answer.hurry), (answer.short_march, answer.short_hurry)):
        seen = fastest(march, ways)
        assert seen.max() <= most.factor + 1e-6
        assert seen.max() == pytest.approx(most.factor, abs=1e-4)
        assert ways[seen.argmax()] == pytest.approx(most.way, abs=0.02) or seen.max() - most.factor < 1e-4
    assert answer.short_hurry.factor == pytest.approx(answer.hurry.factor, rel=1e-6)


def test_fastest_handle_is_the_one_that_limits_the_heads_speed(answer: TurnAnswer) -> None:
    # Enclosed there by branch and bound.
    largest = max_speed()
    assert answer.hurry.factor == pytest.approx(largest.ratio, rel=1e-9)
    assert (answer.hurry.handle, answer.hurry.way) == (largest.handle, pytest.approx(largest.way, abs=1e-5))


def test_handles_speeds_are_those_of_the_march() -> None:
    turn = three_arcs(BASE, 1.4, 1.6, -0.02)
    assert turn is not None
    peaks, heads = hurry(turn.path, Dragon().spacings[:15], -3.0, 30.0)
    march = March(Dragon(benches=15), turn.path)
    for handle in (1, 4, 5, 6):
        speeds = march.at([heads[handle]]).speeds[0]
        assert speeds[handle] == pytest.approx(peaks[handle], rel=1e-9)
        assert march.at(np.linspace(-3, 30, 5001)).speeds[:, handle].max() <= peaks[handle] * (1 + 1e-9)


def test_shortest_turn_is_a_sixth_shorter_and_stays_in_the_circle(answer: TurnAnswer) -> None:
    short = answer.shortest.turn
    assert short.length == pytest.approx(11.28054, abs=1e-5)
    assert walked(short.path, 0, short.path.joints[-1]) == pytest.approx(short.length, rel=1e-7)
    inside = short.path.point(np.linspace(0, short.length, 3001))
    assert np.hypot(*inside.T).max() <= 4.5 + 1e-12
    # Entry and exit are those of the contest's turn.
    ends = short.path.point([0, short.length])
    assert ends == pytest.approx(answer.turn.tangent_points[[0, 2]], abs=1e-12)


@pytest.mark.thorough
def test_no_shorter_turn_of_a_coarse_grid_keeps_to_the_limit(answer: TurnAnswer) -> None:
    # `tests/bench/bench_turns.py` does the same on a fine one.
    radii, bends, kept = np.arange(0.3, 3.0, 0.3), (-0.1, 0.0, 0.1), (0.0, 0.4)
    spacings, tried = Dragon().spacings[:8], 0
    for first, second, bend, late, early in product(radii, radii, bends, kept, kept):
        turn = three_arcs(BASE, first, second, bend, late=late, early=early)
        if turn is None or turn.length >= answer.shortest.turn.length:
            continue
        tried += 1
        heads = np.arange(0, turn.length + 3, 0.2)
        places = chain(turn.path, heads, spacings)
        # A dragon that gets stuck has no place; others are looked at.
        assert np.isnan(places).any() or _seen(turn.path, places) > answer.allowed
    assert tried > 100


def _seen(path: Composite, places: np.ndarray) -> float:
    points, tangents = path.point(places), path.tangent(places)
    along = points[:, :-1] - points[:, 1:]
    lags = np.sum(tangents[:, :-1] * along, axis=-1) / np.sum(tangents[:, 1:] * along, axis=-1)
    return float(np.abs(np.cumprod(lags, axis=1)).max())


@pytest.mark.thorough
def test_nothing_close_to_the_shortest_turn_is_shorter_and_keeps_to_the_limit(answer: TurnAnswer) -> None:
    short, spacings = answer.shortest.turn, Dragon().spacings[:12]
    beside = (
        (1e-3, 0, 0),
        (0, 1e-3, 0),
        (0, 0, 1e-3),
        (1e-3, 1e-3, 0),
        (1e-3, -1e-3, 0),
        (1e-3, 0, 5e-3),
        (0, 1e-3, 5e-3),
    )
    for step in beside:
        for side in (1, -1):
            radii = [radius + side * part for radius, part in zip(short.radii, step, strict=False)]
            turn = three_arcs(BASE, *radii, short.bend + side * step[2])
            assert turn is not None
            peaks, _ = hurry(turn.path, spacings, -3.0, 30.0)
            assert turn.length > short.length - 1e-5 or peaks.max() > answer.allowed * (1 + 1e-5)


@pytest.mark.thorough
def test_search_from_elsewhere_ends_at_the_same_turn(answer: TurnAnswer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pymunk_dragon.studies.shortest.FIRST_GUESS", 0.38)
    again = shortest_turn(BASE, Dragon().spacings, answer.allowed)
    assert again.turn.length == pytest.approx(answer.shortest.turn.length, abs=1e-5)
    assert again.sure
    assert again.turn.radii == pytest.approx(answer.shortest.turn.radii, abs=1e-3)


def test_leaving_the_spirals_later_makes_the_turn_longer(answer: TurnAnswer) -> None:
    # Both were found as well by searching again with a tenth of a metre of a spiral kept.
    assert answer.shortest.late == pytest.approx(0.935, abs=0.01)
    assert answer.shortest.early == pytest.approx(0.953, abs=0.01)


@pytest.mark.parametrize("bend", [0.0, 1e-4, -0.1, 0.1])
def test_three_arcs_are_tangent_and_as_long_as_they_say(bend: float) -> None:
    turn = three_arcs(BASE, 1.3, 1.7, bend, late=0.2, early=0.1)
    assert turn is not None
    assert turn.length == pytest.approx(walked(turn.path, -0.2, turn.length - 0.2), rel=1e-7)
    # Its place 0 is where the first spiral is left, 0.2 m inside the circle.
    assert turn.path.joints[-1] + 0.2 + 0.1 == pytest.approx(turn.length, abs=1e-12)
    ends = turn.path.point([-0.2, turn.length - 0.2])
    assert ends == pytest.approx(BASE.tangent_points[[0, 2]], abs=1e-9)
    assert turn.path.curvature([0, turn.path.joints[-1] - 1e-9]) == pytest.approx([-1 / 1.3, 1 / 1.7])
    assert turn.path.curvature(turn.path.joints[1]) == pytest.approx(bend)


@pytest.mark.parametrize("radii", [(3, 3), (0.5, 9)])
def test_arcs_that_do_not_fit_are_no_turn(radii: tuple[float, float]) -> None:
    assert three_arcs(BASE, *radii) is None


def test_contests_sheet_has_all_times_from_before_the_circle_to_after_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "result4.xlsx"
    with pytest.raises(SystemExit) as stop:
        main(["study", "u-turn", "--benches", "12", "-o", str(file), "--json"])
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


def test_picture_shows_both_turns_and_who_hurries(answer: TurnAnswer) -> None:
    drawn = answer_figure(answer)
    two, three, below = drawn.axes
    lines = {line.get_gid(): line for line in below.get_lines()}
    for axes, march in ((two, answer.march), (three, answer.short_march)):
        joints = next(line for line in axes.get_lines() if line.get_gid() == "joints")
        assert joints.get_xydata() == pytest.approx(march.curve.point(march.curve.joints))
    for gid in ("speeds", "short-speeds"):
        assert lines[gid].get_ydata().max() == pytest.approx(answer.allowed, abs=0.01)


@pytest.mark.parametrize("value", [*(value for value in NO_NUMBERS if value is not None), 1.0, 5.1], ids=repr)
def test_impossible_limits_are_refused(value: object) -> None:
    with pytest.raises(ParameterError) as caught:
        u_turn(fastest=value)
    assert_says(caught.value, "fastest is", "from 1.01 to 5")


@pytest.mark.thorough
def test_a_limit_that_no_turn_keeps_to_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        shortest_turn(BASE, Dragon().spacings, 1.05)
    assert_says(caught.value, "fastest is 1.05, but must be higher")


def test_a_circle_in_which_the_dragon_gets_stuck_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        u_turn(Dragon(benches=12), radius=1.8)
    assert_says(caught.value, "radius is 1.8, but must be large enough")
