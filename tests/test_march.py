"""Exact kinematics: an independent solution in many digits, and what rigid benches demand."""

import warnings

import mpmath as mp
import numpy as np
import oracle
import pytest
from conftest import NO_NUMBERS, assert_says, refusal
from exact_curves import DIGITS, UnplaceableError, u_turn, walked_chain
from hypothesis import assume, given
from hypothesis import strategies as st
from marches import DRAWN, HAIRPIN
from test_curve_kinds import LogarithmicSpiral
from test_first_contact import marches

from pymunk_dragon import (
    Dragon,
    Line,
    March,
    Section,
    SpeedTable,
    Spiral,
    UTurn,
    first_contact,
    simulate,
)
from pymunk_dragon.errors import UnreachableError

# s. The last time at which the paper's dragon can be placed, to 1e-7 s; see the test that finds it.
LAST = 432.9179242
SMALL = Dragon(benches=12, head_spacing=0.5, body_spacing=0.3, overhang=0.05, width=0.1)
STATES = ("times", "handles_s", "positions", "velocities", "speeds", "poses", "pose_velocities")


def unreachable(march, times):
    """Time and handle which the march cannot place at `times`, and the message."""
    error = refusal(march.at, times, error=UnreachableError)
    return error.time, error.handle, str(error)


@pytest.mark.parametrize(
    ("march", "time", "speeds"),
    [
        (March(Dragon(benches=12)), 412.47, True),
        *(
            pytest.param(March(), time, time != LAST - 1e-6, marks=pytest.mark.thorough)
            for time in (412.47, LAST - 1e-6)
        ),
        (March(Dragon(benches=20)), -86_400, False),
        pytest.param(March(Dragon(benches=1000)), 50, False, marks=pytest.mark.thorough),
        (March(Dragon(benches=20), Spiral(pitch=0.31)), 100, True),
        # Turn 3.4 is 3.5 m wide where the head's bench lies across it.
        (March(Dragon(benches=12, head_spacing=3.45, body_spacing=3.4), turns=3.4), 0, True),
        # Close to the centre and at it.
        *(
            (March(SMALL, turns=1.5), time, True)
            for time in (2.5, March(SMALL, turns=1.5).end - 1e-3)
        ),
    ],
)
def test_every_handle_is_where_the_oracle_has_it(march, time, speeds):
    sizes = {
        name: getattr(march.dragon, name) for name in ("benches", "head_spacing", "body_spacing")
    }
    motion = {
        "pitch": march.curve.pitch,
        "turns": march.turns,
        "speed": march.speed,
        "difference": speeds,
    }
    positions, velocities = oracle.solve(time, **sizes, **motion)
    states = march.at(time)
    assert len(positions) == march.dragon.handles == states.positions.shape[1]
    for (x, y), ours in zip(positions, states.positions[0].tolist(), strict=True):
        assert mp.hypot(x - ours[0], y - ours[1]) < 1e-10
    if speeds:
        for (x, y), ours, speed in zip(
            velocities, states.velocities[0].tolist(), states.speeds[0], strict=True
        ):
            assert mp.hypot(x - ours[0], y - ours[1]) < 1e-9
            assert abs(mp.hypot(x, y) - float(speed)) < 1e-9


@given(marches(), st.floats(-100, 1))
def test_benches_keep_their_length_and_both_ends_go_along_with_them(march, when):
    gaps = np.diff(march.curve.angle(march.handles_s(0)[0]))
    # The handles follow each other outward, at most one turn apart.
    assert np.all(gaps > 0)
    assert np.all(gaps <= 2 * np.pi + 1e-12)
    try:
        states = march.at(when if when < 0 else when * 0.5 * march.end)
    except UnreachableError:
        assume(False)
    assert states.speeds[0, 0] == march.speed
    along = states.positions[0, :-1] - states.positions[0, 1:]
    # Either hole is where its place is, to a few last digits of the place.
    resolution = 8 * np.spacing(np.abs(states.handles_s).max())
    assert np.linalg.norm(along, axis=-1) == pytest.approx(
        march.dragon.spacings, rel=1e-12, abs=resolution
    )
    unit = along / march.dragon.spacings[:, None]
    front = np.sum(unit * states.velocities[0, :-1], axis=-1)
    rear = np.sum(unit * states.velocities[0, 1:], axis=-1)
    assert front == pytest.approx(rear, rel=1e-9, abs=1e-11)


def test_states_of_many_times_and_of_the_first_handles_are_those_of_each(seed_march):
    times = np.array([-50, 0, 412.47, 299.9, 432.9, 17])
    together = seed_march.at(times)
    few = seed_march.at(times, handles=5)
    times[0] = 99
    assert together.times[0] == -50
    for row, time in enumerate(together.times):
        alone = seed_march.at(time)
        for name in STATES:
            assert getattr(alone, name)[0] == pytest.approx(
                getattr(together, name)[row], rel=1e-12, abs=1e-12
            )
    assert few.velocities == pytest.approx(together.velocities[:, :5], rel=1e-12, abs=1e-12)
    assert seed_march.handles_s([0, 1, 2], handles=1).shape == (3, 1)
    assert seed_march.at([]).positions.shape == (0, 224, 2)


def test_speeds_by_difference_converge_to_the_exact_ones_at_first_order(seed_march):
    times = [0, 100, 300, 412]
    exact = seed_march.at(times).speeds
    steps = 0.1 / 2 ** np.arange(5)
    errors = [
        np.abs(seed_march.speeds_by_difference(times, step) - exact).max(axis=1) for step in steps
    ]
    order = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all((order > 0.95) & (order < 1.05)), order
    assert np.all(errors[-1] < 1e-2)


def test_seed_dragon_cannot_be_placed_from_432_918_seconds_on(seed_march):
    seed_march.handles_s(LAST)
    assert unreachable(seed_march, LAST + 1e-7)[1] == 1
    with pytest.raises(UnplaceableError) as independent:
        oracle.solve(
            LAST + 1e-7,
            benches=1,
            head_spacing=2.86,
            body_spacing=1.65,
            pitch=0.55,
            turns=16,
            speed=1,
        )
    assert independent.value.args == (1,)


def test_first_time_and_handle_without_a_place_are_named(seed_march):
    assert seed_march.end == pytest.approx(442.590256432)
    for times, time, handle, words in (
        ([0, 433.5], 433.5, 1, "bends too tightly for a spacing of 2.86 m"),
        (443, 443, 0, "ends at t = 442.59 s"),
        ([500, 100, 434, 1e308, 433, 450], 433, 1, "t = 433 s"),
    ):
        found = unreachable(seed_march, times)
        assert found[:2] == (time, handle)
        assert words in found[2]
    march = March(Dragon(benches=5, head_spacing=1, body_spacing=4, overhang=0.1), turns=8)
    assert unreachable(march, np.linspace(0, march.end, 2000))[1] == 2


def test_impossible_marches_are_refused_by_name():
    for name, bound in (("turns", "above 0 and at most 1000"), ("speed", "from 1e-06 to 20 m/s")):
        for value in [*NO_NUMBERS, 1001, 1e308, -1e-6, *([1e-7, 20.1] if name == "speed" else [])]:
            if (name, value is None) != ("turns", True):  # without turns it is the contest's
                assert_says(refusal(March, **{name: value}), f"{name} is ", bound)
    for value in (None, "spiral", 3, Dragon, [Dragon()]):
        assert refusal(March, value).name == "dragon"
        assert refusal(March, Dragon(), value).name == "curve"
    assert refusal(March, Dragon(), Spiral(pitch=0.3)).name == "pitch"
    # Benches too long for the first turn.
    for settings, name, value in (
        ({"turns": 2}, "head_spacing", 2.86),
        (
            {"dragon": Dragon(head_spacing=0.7, body_spacing=5.0, overhang=0.1), "turns": 2},
            "body_spacing",
            5.0,
        ),
    ):
        error = refusal(March, **settings)
        assert error.name == name
        assert error.value == value
    wide = March(Dragon(benches=3), Spiral(pitch=100), turns=1e-9)
    assert np.linalg.norm(wide.at(0).positions[0, 1]) == pytest.approx(2.86, abs=1e-6)
    march = March(turns=np.float32(16), speed=np.int64(1))
    assert (march, type(march.turns), type(march.speed)) == (March(), float, float)


def test_impossible_questions_are_refused_by_name(seed_march):
    for bad in (float("nan"), float("inf"), float("-inf"), "noon", None, 1j, -1e308, -1e6, 10**400):
        for times in (bad, [0, bad]):
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                assert refusal(seed_march.at, times).name == "times"
    for handles in (0, -1, 225, 2.0, "2", True):
        assert refusal(seed_march.at, 0, handles=handles).name == "handles"
    for step in NO_NUMBERS:
        assert refusal(seed_march.speeds_by_difference, [0], step).name == "step"


# Dragons on any curve, of any benches, at any speed: against coordinates found by walking back in
# many digits

TURN = March(curve=UTurn())


@pytest.mark.parametrize(
    "time", [14.1, *(pytest.param(t, marks=pytest.mark.thorough) for t in (-0.5, 7.5, 16.0))]
)
def test_handles_in_the_u_turn_are_where_many_digits_have_them(time):
    """Also while the chain lies over one, two or all three joints."""
    with mp.workdps(DIGITS):
        truth = u_turn()
        states = TURN.at(time, handles=10)
        places = walked_chain(truth, time, TURN.dragon.spacings[:9])
        for place, (x, y), ours in zip(
            places, states.positions[0].tolist(), states.handles_s[0].tolist(), strict=True
        ):
            u, v = truth(place)[:2]
            assert mp.hypot(u - x, v - y) < 1e-10
            assert abs(place - ours) < 1e-10
        tiny = mp.mpf("1e-15")
        before, after = (
            walked_chain(truth, mp.mpf(time) + sign * tiny, TURN.dragon.spacings[:9])
            for sign in (-1, 1)
        )
        for one, other, speed in zip(before, after, states.speeds[0].tolist(), strict=True):
            assert abs((other - one) / (2 * tiny) - mp.mpf(speed)) < 1e-9


def test_the_next_handle_is_the_nearest_along_the_path_that_a_scan_sees():
    cases = [(HAIRPIN, s, 1.5) for s in (9.0, 10.0, 11.0, 11.7, 12.0, 13.0, 14.5)]
    cases += [(DRAWN, s, 1.1) for s in np.linspace(12, DRAWN.end_s, 8)]
    # Near the centre, from where the distance grows over more than a turn, and where it has its top
    # within the first.
    cases += [
        (Spiral(), -s, 0.55 * share)
        for s in (0, 0.05, 0.095, 0.103, 0.3, 40)
        for share in (0.4, 0.99, 1.01)
    ]
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
            assert np.linalg.norm(curve.point(place) - curve.point(s)) == pytest.approx(
                spacing, abs=1e-12
            )


def test_places_before_the_begin_are_none_and_the_begin_itself_is_one():
    line = Line(stop=(10, 0))
    found = np.isnan(line.chain([1.0, 1.5, np.nan, 10.5], [1.5, 1.5])).tolist()
    assert found == [[False, True, True], [False, False, True], [True] * 3, [True] * 3]
    assert line.chain([1.5, 3.0], [1.5, 1.5])[1].tolist() == pytest.approx([3, 1.5, 0], abs=1e-15)
    assert line.chain(np.empty(0), [1.65]).shape == (0, 2)


@pytest.mark.parametrize(
    "curve", [UTurn(), HAIRPIN, Section(Spiral(), -300, -10), LogarithmicSpiral()], ids=repr
)
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
    assert error.time == -1e-3
    assert error.handle == 12
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
    short = March(
        Dragon(benches=4, head_spacing=1.0, body_spacing=1.0), Line(stop=(10, 0)), start_s=5.0
    )
    for ask in (first_contact, simulate):
        assert refusal(ask, TURN).name == "until"
        assert refusal(ask, short, start=100.0).name == "start"
    for time, words in (
        (-2.5, "begins less than a spacing"),
        (-6, "begins at t = -5 s"),
        (6, "ends at t = 5 s"),
    ):
        assert_says(refusal(short.at, time, error=UnreachableError), words)


# Speeds


def test_where_the_dragon_is_depends_on_the_way_alone():
    table = SpeedTable([0, 10, 20], [1.0, 2.0, 0.5])
    changing, steady = March(SMALL, speed=table), March(SMALL)
    times = np.array([-3.0, 0, 4, 15, 33.3])
    ways = changing.distance(times)
    assert ways.tolist() == pytest.approx(
        [-3, 0, 4 + 0.8, 15 + 2 * 5 - 1.5 / 20 * 25, 27.5 + 13.3 * 0.5]
    )
    there, same = changing.at(times), steady.at(ways)
    assert there.positions == pytest.approx(same.positions, abs=1e-12)
    assert there.speeds == pytest.approx(same.speeds * table.at(times)[:, None], abs=1e-12)
    assert changing.time(ways) == pytest.approx(times, abs=1e-12)


def test_the_first_contact_is_at_the_same_place_however_fast_the_head_goes(seed_march):
    plain = first_contact(seed_march, start=400)
    march = March(speed=SpeedTable.of(lambda t: 1 + 0.3 * np.sin(t / 7), -10, 500, step=0.1))
    hit = first_contact(march, start=float(march.time(400.0)))
    assert hit.benches == (0, 8)
    assert hit.time == pytest.approx(float(march.time(plain.time)), abs=1e-10)
    assert hit.point == pytest.approx(plain.point, abs=1e-11)
    assert [miss.gap for miss in hit.near_misses] == pytest.approx(
        [miss.gap for miss in plain.near_misses], abs=1e-12
    )


def test_the_end_of_a_curve_is_reached_whatever_rounding_does():
    dragon = Dragon(benches=3, head_spacing=1.0, body_spacing=0.5, overhang=0.1)
    for speed in np.linspace(0.5, 1.5, 40):
        march = March(dragon, Line(stop=(7.7, 0.3)), speed=speed)
        hit = first_contact(march)
        assert hit.status == "clear"
        assert hit.time == march.end
