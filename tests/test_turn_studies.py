"""Questions 4 and 5: the turn and the speed limit, against many digits and brute force."""

import json
import sys

import mpmath as mp
import numpy as np
import openpyxl
import pytest
import shapely
from conftest import NO_NUMBERS, assert_says, refusal
from exact_curves import DIGITS, walked_chain
from exact_curves import u_turn as exact_turn
from study_answers import answer as shared_answer

from pymunk_dragon import Dragon, March, UnreachableError, UTurn, max_speed, u_turn


def searched():
    """The answer with the shortest turn, and the progress of the search."""
    shown = []
    return u_turn(progress=lambda done, total: shown.append((done, total))), shown


@pytest.fixture(scope="module")
def answer():
    return shared_answer("u-turn", searched)[0]


@pytest.fixture(scope="module")
def limit():
    return shared_answer("max-speed", max_speed)


def walked(curve, since, until):
    """Length in m of a path by many straight pieces, right to 1e-8 of it."""
    points = curve.point(np.linspace(since, until, 20_001))
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def scanned(dragon, curve, begin, end, step):
    """Largest speed over the head's in samples every `step` m, and the head's coordinate there."""
    ways = np.arange(begin, end, step)
    parts = np.array_split(ways, max(1, ways.size // 500))
    seen = np.concatenate([March(dragon, curve).at(part).speeds.max(axis=1) for part in parts])
    return float(seen.max()), float(ways[seen.argmax()])


def test_no_two_arcs_make_the_turn_shorter(answer):
    assert answer.turn == UTurn()
    for ratio in (0.25, 0.5, 1.0, 4.0):
        turn = UTurn(ratio=ratio)
        assert turn.length == pytest.approx(answer.turn.length, rel=1e-14)
        assert walked(turn, 0, turn.joints[-1]) == pytest.approx(turn.length, rel=1e-7)


@pytest.mark.thorough
def test_dragon_gets_round_both_turns_without_touching_itself(answer):
    for turn in (answer.contests, answer.shortest):
        assert turn.contact.status == "clear"
        assert turn.contact.time == 100
        # At one of the times every other metre, by somebody else's geometry.
        for poses in turn.march.at(np.arange(-10.0, 100.5, 2.0)).poses:
            benches = shapely.polygons(turn.march.dragon.outlines(poses))
            first, second = shapely.STRtree(benches).query(benches, predicate="intersects")
            assert np.abs(first - second).max() == 1


def test_the_ratios_are_the_largest_seen_and_the_shortest_turn_has_no_larger_one(answer):
    for turn in (answer.contests, answer.shortest):
        _, way = scanned(turn.march.dragon, turn.path, -3.0, 40.0, 0.05)
        _, way = scanned(turn.march.dragon, turn.path, way - 0.06, way + 0.06, 1e-3)
        near, _ = scanned(turn.march.dragon, turn.path, way - 2e-3, way + 2e-3, 4e-6)
        assert turn.excess <= 1e-11
        assert turn.ratio - 1e-5 < near <= turn.ratio * (1 + 1e-11)
    assert answer.shortest.ratio <= answer.contests.ratio
    assert answer.shortest.ratio == pytest.approx(answer.contests.ratio, rel=1e-3)


def test_the_largest_ratio_of_a_turn_is_no_sample_of_it():
    """A peak of millimetres: samples every 1.2 mm see 5.23 of 4.275 m, and 16.4 of 4.27 m."""
    for radius in (4.275, 4.27):
        found, certified = u_turn(radius=radius, search=False).contests, max_speed(radius=radius)
        assert found.ratio == certified.ratio
        assert found.excess == certified.excess
        ways = certified.distance + np.linspace(-1e-6, 1e-6, 101)
        seen = March(Dragon(benches=12), UTurn(radius=radius)).at(ways).speeds.max()
        assert found.ratio * (1 - 1e-4) < seen <= found.ratio * (1 + found.excess)
        assert found.to_dict()["peak_speed_ratio"] == found.ratio


def test_ratio_of_differing_benches_is_said_to_be_a_sample():
    found = u_turn(Dragon(body_spacing=[1.65, 1.5, 1.65]), search=False)
    assert found.contests.excess is None
    assert found.to_dict()["peak_speed_excess"] is None
    assert "at least 1.5967" in str(found)
    # Where the last bench of many may be the fastest, both ends of the enclosure are printed.
    wide = u_turn(Dragon(head_spacing=1.65), search=False)
    assert "1.1131 to 1.1322" in str(wide)


def test_shortest_turn_has_five_arcs_and_stays_in_the_circle(answer):
    short, path = answer.shortest, answer.shortest.path
    assert (len(path.pieces) - 2, short.length <= 10.5) == (5, True)
    assert walked(path, 0, path.joints[-1]) == pytest.approx(short.length, rel=1e-7)
    inside = path.point(np.linspace(0, short.length, 3001))
    assert np.hypot(*inside.T).max() <= 4.5 + 1e-12
    assert all(arc.radius >= 0.5 for arc in path.pieces[1:-1])
    # Entry and exit are those of the contest's turn.
    assert path.point([0, short.length]) == pytest.approx(
        answer.turn.tangent_points[[0, 2]], abs=1e-12
    )
    # The arcs of the answer, laid end to end, come to the exit with its tangent.
    point, heading = (complex(*part) for part in (path.point(0), path.tangent(0)))
    for arc in answer.to_dict()["shortest"]["arcs"]:
        turned = np.exp(1j * arc["curvature"] * arc["length"])
        point, heading = point + heading * (turned - 1) / (1j * arc["curvature"]), heading * turned
    assert [point, heading] == pytest.approx(
        [complex(*path.point(short.length)), complex(*path.tangent(0))], abs=1e-12
    )


def test_search_reports_its_progress_and_claims_no_proof(answer):
    _, shown = shared_answer("u-turn", searched)
    assert (len(shown) > 1, shown[-1][0]) == (True, shown[-1][1])
    assert "not proven" in str(answer)


def test_contests_sheet_has_all_times_from_before_the_circle_to_after_it(call, tmp_path):
    file = tmp_path / "result4.xlsx"
    status, out, _ = call("study", "u-turn", "--benches", "12", "--no-search", "-o", file, "--json")
    told = json.loads(out)
    assert status == 0
    assert told["shortest"] is None
    assert told["contact"]["status"] == "clear"
    assert {"length", "radii", "centres"} <= told.keys()
    assert told["length"] == pytest.approx(13.621245, abs=1e-6)
    book = openpyxl.load_workbook(file)
    positions, speeds = ([*book[name].iter_rows(values_only=True)] for name in ("位置", "速度"))
    assert positions[0] == speeds[0] == (None, *(f"{time} s" for time in range(-100, 101)))
    assert positions[1][101] == -2.711856
    assert positions[2][101] == -3.591078


# The speed limit


def test_the_ratio_at_the_limit_is_the_one_in_many_digits(limit):
    """And neither a millimetre before nor one after is it larger: the moment is right as well."""
    with mp.workdps(DIGITS):
        truth = exact_turn()
        spacings = limit.dragon.spacings[: limit.handle]
        tiny = mp.mpf("1e-15")

        def ratio(way):
            before, after = (
                walked_chain(truth, mp.mpf(way) + sign * tiny, spacings)[-1] for sign in (-1, 1)
            )
            return (after - before) / (2 * tiny)

        there = ratio(limit.distance)
        assert abs(there - mp.mpf(limit.ratio)) < 1e-11
        for away in (-1e-3, 1e-3):
            assert ratio(limit.distance + away) < there


def test_the_speed_is_the_limit_over_the_ratio(limit, answer):
    assert limit.speed * limit.ratio == pytest.approx(2, rel=1e-15)
    fast = March(curve=UTurn(), speed=limit.speed).at(limit.time).speeds[0]
    assert fast.max() == pytest.approx(2, abs=1e-8)
    assert fast[list(limit.handles)] == pytest.approx(np.full(len(limit.handles), 2.0), abs=1e-8)
    assert max_speed(limit=1.0).speed == pytest.approx(limit.speed / 2, rel=1e-15)
    assert answer.contests.ratio == limit.ratio


def test_nobody_is_faster_however_long_one_looks(limit):
    coarse, way = scanned(limit.dragon, limit.curve, -10.0, 40.0, 0.05)
    assert coarse <= limit.ratio * (1 + 1e-12)
    assert way == pytest.approx(limit.distance, abs=0.05)
    fine, _ = scanned(limit.dragon, limit.curve, limit.distance - 2e-3, limit.distance + 2e-3, 4e-6)
    assert limit.ratio - 1e-9 < fine <= limit.ratio * (1 + 1e-12)
    # The whole dragon's way through the turn, and long after.
    later, _ = scanned(limit.dragon, limit.curve, 40.0, 500.0, 1.0)
    assert later < limit.ratio - 0.4


def test_other_dragons_and_turns_are_as_fast_as_a_scan_sees():
    # Where the head bench is no longer than the others, those on the way out add to the speed
    # behind them.
    last_is_fastest = Dragon(benches=25, head_spacing=1.65)
    for dragon, sizes in (
        (last_is_fastest, {}),
        (Dragon(benches=8, head_spacing=1.0, body_spacing=2.0), {}),
        (Dragon(benches=2), {}),
        (Dragon(), {"pitch": 1.2, "radius": 5.0, "ratio": 1.5}),
    ):
        found = max_speed(dragon, **sizes)
        end = found.curve.joints[-1] + min(float(dragon.spacings.sum()), 60.0)
        coarse, way = scanned(dragon, found.curve, -3.0, end, 0.05)
        near, _ = scanned(dragon, found.curve, way - 0.06, way + 0.06, 1e-4)
        assert found.excess <= 1e-10, found
        assert found.ratio * (1 - 1e-6) < max(coarse, near, 1.0) <= found.ratio * (1 + 1e-11), found
        assert dragon is not last_is_fastest or found.handle == 25


def test_long_dragons_and_wide_turns_are_bounded_with_little_work(monkeypatch):
    search, counts = sys.modules["pymunk_dragon.studies.max_speed"]._Search, []
    ratios = search._ratios
    monkeypatch.setattr(
        search,
        "_ratios",
        lambda self, *chains: counts.append(len(chains[0])) or ratios(self, *chains),
    )
    # With 2.0 m the whole dragon was followed through the turn, for a minute and a half.
    for head_spacing in (1.9, 2.0):
        found = max_speed(Dragon(head_spacing=head_spacing))
        assert found.excess < 0.02
        assert sum(counts) < 5000
        counts.clear()
        seen, _ = scanned(
            found.dragon, found.curve, found.distance - 1.0, found.distance + 1.0, 0.05
        )
        assert seen <= found.ratio * (1 + found.excess)
    # On a turn gentler than the way out, the bound for the way out is the larger one.
    found = max_speed(Dragon(benches=20), radius=40.0)
    assert 1 <= found.ratio < 1.01
    seen, _ = scanned(found.dragon, found.curve, -10.0, found.curve.joints[-1] + 200.0, 1.0)
    assert seen <= found.ratio * (1 + found.excess)


def test_impossible_limits_turns_and_dragons_are_refused_by_name():
    short = Dragon(benches=4, head_spacing=0.51, body_spacing=0.47, overhang=0.01, width=0.05)
    for dragon, sizes, *words in (
        *(
            (None, {n: value}, f"{n} is ")
            for n in ("limit", "pitch", "radius", "ratio")
            for value in NO_NUMBERS
        ),
        (Dragon(body_spacing=[1.65, 1.5, 1.65]), {}, "alike"),
        (None, {"radius": 0.6}, "radius is 0.6"),
        # Handle 1 is pushed back all the way out.
        (None, {"radius": 4.0}, "radius is 4.0"),
        (short, {"pitch": 2.4, "radius": 0.632, "ratio": 0.185}, "radius is 0.632"),
    ):
        assert_says(refusal(max_speed, dragon, **sizes), *words)
    refusal(max_speed, radius=4.2, error=UnreachableError)
    for radius in (1.8, 4.0):
        assert_says(
            refusal(u_turn, Dragon(benches=12), radius=radius, search=False), f"radius is {radius}"
        )


def test_program_tells_the_limit(call, limit):
    told = json.loads(call("study", "max-speed", "--json")[1])
    assert told["speed"] == limit.speed
    assert told["handle"] == limit.handle
    assert told["time"] == limit.time


def test_contests_turn_is_the_best_where_the_search_finds_no_shorter_one(monkeypatch):
    monkeypatch.setattr(sys.modules["pymunk_dragon.studies.u_turn"], "_STEPS", 0)
    found = u_turn(Dragon(benches=4))
    assert found.shortest.path == found.turn
    assert "no turn" in str(found)
