"""Dragons on any curve, of any benches, at any speed: held against places found by walking back in many digits."""

import mpmath as mp
import numpy as np
import pytest
from conftest import assert_says, refusal
from exact_curves import DIGITS, u_turn, walked_chain
from test_curve_kinds import LogarithmicSpiral

from pymunk_dragon import Dragon, March, SpeedTable, first_contact, simulate
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.curves import Arc, Composite, Line, Sampled, Section, Spiral, UTurn

TURN = March(curve=UTurn())
SMALL = Dragon(benches=12, head_spacing=0.5, body_spacing=0.3, overhang=0.05, width=0.1)


def bent(length, radius, sweep, onward):
    """Straight on, round to the left by an angle, and straight on."""
    arc = Arc(centre=(length, radius), radius=radius, begin_angle=-np.pi / 2, sweep=sweep)
    end, ahead = arc.point(arc.end_s), arc.tangent(arc.end_s)
    return Composite([Line(stop=(length, 0)), arc, Line(start=end, stop=end + onward * ahead)])


# Its legs are closer than a bench is long.
HAIRPIN = bent(10, 0.6, np.pi, 10)
# Points of a loop that a hand may have drawn.
DRAWN = Sampled(
    [(-12, 0), (-8, 0.3), (-4, -0.2), (0, 0), (3, 1), (4, 4), (1.5, 6), (-1, 4), (-1.5, 1), (-1, -3), (1, -7)]
)
TABLE = SpeedTable([0, 4, 9], [0.5, 2, 1])


@pytest.mark.parametrize("time", [14.1, *(pytest.param(t, marks=pytest.mark.thorough) for t in (-0.5, 7.5, 16.0))])
def test_handles_in_the_u_turn_are_where_many_digits_have_them(time):
    """Also while the chain lies over one, two or all three joints."""
    with mp.workdps(DIGITS):
        truth = u_turn()
        states = TURN.at(time, handles=10)
        places = walked_chain(truth, time, TURN.dragon.spacings[:9])
        for place, (x, y), ours in zip(places, states.positions[0].tolist(), states.handles_s[0].tolist(), strict=True):
            u, v = truth(place)[:2]
            assert mp.hypot(u - x, v - y) < 1e-10
            assert abs(place - ours) < 1e-10
        tiny = mp.mpf("1e-15")
        before, after = (walked_chain(truth, mp.mpf(time) + sign * tiny, TURN.dragon.spacings[:9]) for sign in (-1, 1))
        for one, other, speed in zip(before, after, states.speeds[0].tolist(), strict=True):
            assert abs((other - one) / (2 * tiny) - mp.mpf(speed)) < 1e-9


def test_the_next_handle_is_the_nearest_along_the_path_that_a_scan_sees():
    cases = [(HAIRPIN, s, 1.5) for s in (9.0, 10.0, 11.0, 11.7, 12.0, 13.0, 14.5)]
    cases += [(DRAWN, s, 1.1) for s in np.linspace(12, DRAWN.end_s, 8)]
    # Near the centre, from where the distance grows over more than a turn, and where it has its top within the first.
    cases += [(Spiral(), -s, 0.55 * share) for s in (0, 0.05, 0.095, 0.103, 0.3, 40) for share in (0.4, 0.99, 1.01)]
    for curve, s, spacing in cases:
        place = curve.chain([s], [spacing])[0, 1]
        ways = np.linspace(0, 5, 60_001)
        away = np.linalg.norm(curve.point(s - ways) - curve.point(s), axis=-1)
        falls = np.flatnonzero(np.diff(away) < 0)
        reached = np.flatnonzero(away >= spacing)
        if falls.size and falls[0] < reached[0]:
            # The bench would have to jump from one leg of the hairpin to the other.
            assert np.isnan(place)
        else:
            assert s - place == pytest.approx(ways[reached[0]], abs=1e-4)
            assert np.linalg.norm(curve.point(place) - curve.point(s)) == pytest.approx(spacing, abs=1e-12)


def test_places_before_the_begin_are_none_and_the_begin_itself_is_one():
    line = Line(stop=(10, 0))
    found = np.isnan(line.chain([1.0, 1.5, np.nan, 10.5], [1.5, 1.5])).tolist()
    assert found == [[False, True, True], [False, False, True], [True] * 3, [True] * 3]
    assert line.chain([1.5, 3.0], [1.5, 1.5])[1].tolist() == pytest.approx([3, 1.5, 0], abs=1e-15)
    assert line.chain(np.empty(0), [1.65]).shape == (0, 2)


@pytest.mark.parametrize("curve", [UTurn(), HAIRPIN, Section(Spiral(), -300, -10), LogarithmicSpiral()], ids=repr)
def test_the_foot_of_a_point_beside_the_path_is_where_it_was_set_off(curve):
    s = np.linspace(max(curve.begin_s + 0.1, -290.0), min(curve.end_s - 0.1, 40.0), 60)
    points, tangents = curve.frame(s)
    left = np.stack([-tangents[:, 1], tangents[:, 0]], axis=-1)
    for aside, off in ((1e-3, 0.05), (-1e-4, 0.01), (0, 1e-3)):
        places, feet, directions = curve.foot(points + aside * left, s + off)
        assert places == pytest.approx(s, abs=1e-8)
        assert feet == pytest.approx(points, abs=1e-9)
        assert directions == pytest.approx(tangents, abs=2e-5)


# Where a march starts and ends


def test_a_dragon_starts_with_its_tail_at_the_begin_of_the_curve_or_its_head_at_its_zero():
    march = March(SMALL, HAIRPIN)
    assert march.motion_or_nan(0.0).handles_s[0, -1] == pytest.approx(0, abs=2e-9)
    assert not np.isnan(march.motion_or_nan(0.0).handles_s).any()
    error = refusal(march.at, -1e-3, error=UnreachableError)
    assert (error.time, error.handle) == (-1e-3, 12)
    assert TURN.head_start == 0
    assert March(curve=Spiral(), start_s=-100.0).motion_or_nan(0.0).handles_s[0, 0] == -100


def test_a_march_or_a_search_that_cannot_start_is_refused_by_name():
    for settings, name in (
        ({"curve": Line(stop=(100, 0))}, "curve"),
        ({"curve": HAIRPIN, "dragon": Dragon(benches=7)}, "curve"),
        ({"curve": UTurn(), "turns": 16}, "turns"),
        ({"start_s": -400.0, "turns": 16}, "turns"),
        ({"curve": HAIRPIN, "dragon": SMALL, "start_s": 40.0}, "start_s"),
        ({"curve": HAIRPIN, "dragon": SMALL, "start_s": 1.0}, "start_s"),
        ({"start_s": 3.0}, "start_s"),
        ({"start_s": "here"}, "start_s"),
        ({"curve": UTurn(pitch=0.1, radius=4.5)}, "pitch"),
    ):
        assert refusal(March, **settings).name == name, settings
    short = March(Dragon(benches=4, head_spacing=1.0, body_spacing=1.0), Line(stop=(10, 0)), start_s=5.0)
    for ask in (first_contact, simulate):
        assert refusal(ask, TURN).name == "until"
        assert refusal(ask, short, start=100.0).name == "start"
    for time, words in ((-2.5, "begins less than a spacing"), (-6, "begins at t = -5 s"), (6, "ends at t = 5 s")):
        assert_says(refusal(short.at, time, error=UnreachableError), words)


# Speeds


def test_where_the_dragon_is_depends_on_the_way_alone():
    table = SpeedTable([0, 10, 20], [1.0, 2.0, 0.5])
    changing, steady = March(SMALL, speed=table), March(SMALL)
    times = np.array([-3.0, 0, 4, 15, 33.3])
    ways = changing.distance(times)
    assert ways.tolist() == pytest.approx([-3, 0, 4 + 0.8, 15 + 2 * 5 - 1.5 / 20 * 25, 27.5 + 13.3 * 0.5])
    there, same = changing.at(times), steady.at(ways)
    assert there.positions == pytest.approx(same.positions, abs=1e-12)
    assert there.speeds == pytest.approx(same.speeds * table.at(times)[:, None], abs=1e-12)
    assert changing.time(ways) == pytest.approx(times, abs=1e-12)
    wave = SpeedTable.of(lambda t: 1 + 0.5 * np.sin(t), -5, 5)
    march, step = March(SMALL, UTurn(pitch=0.8, radius=1.5), speed=wave), 1e-5
    # Between entries of the table.
    times = np.array([-2.003, 0.502, 2.503, 4.003])
    before, after = march.at(times - step).positions, march.at(times + step).positions
    assert march.at(times).velocities == pytest.approx((after - before) / (2 * step), abs=1e-8)


def test_the_first_contact_is_at_the_same_place_however_fast_the_head_goes(seed_march):
    plain = first_contact(seed_march, start=400)
    march = March(speed=SpeedTable.of(lambda t: 1 + 0.3 * np.sin(t / 7), -10, 500, step=0.1))
    hit = first_contact(march, start=float(march.time(400.0)))
    assert hit.benches == (0, 8)
    assert hit.time == pytest.approx(float(march.time(plain.time)), abs=1e-10)
    assert hit.point == pytest.approx(plain.point, abs=1e-11)
    assert [miss.gap for miss in hit.near_misses] == pytest.approx([miss.gap for miss in plain.near_misses], abs=1e-12)


def test_the_end_of_a_curve_is_reached_whatever_rounding_does():
    dragon = Dragon(benches=3, head_spacing=1.0, body_spacing=0.5, overhang=0.1)
    for speed in np.linspace(0.5, 1.5, 40):
        march = March(dragon, Line(stop=(7.7, 0.3)), speed=speed)
        hit = first_contact(march)
        assert (hit.status, hit.time) == ("clear", march.end)
