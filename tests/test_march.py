"""Exact kinematics: the paper's tables, an independent solution in many digits, and what rigid benches demand."""

from __future__ import annotations

import csv
import json
import math
import warnings
from decimal import ROUND_DOWN, Decimal
from pathlib import Path

import mpmath as mp
import numpy as np
import oracle
import pytest
from conftest import NO_NUMBERS, assert_says, examples
from hypothesis import assume, given
from hypothesis import strategies as st
from marches import ARM, TRACTOR, U_TURN

from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March

DATA = Path(__file__).parent / "data"
# s. The last time at which the paper's dragon can be placed, to 1e-7 s; see the test that finds it.
LAST = 432.9179242
SMALL = Dragon(benches=12, head_spacing=0.5, body_spacing=0.3, overhang=0.05, width=0.1)


def table(name):
    with (DATA / name).open(newline="") as file:
        return list(csv.DictReader(file))


def cut(value):
    """As the paper cuts: the exact value without what follows its third decimal.

    A double that is a hair short of such a decimal (8.8 m, 1 m/s, 0 m) is that decimal: the hair is 1e-11.
    """
    whole = Decimal(float(value) + math.copysign(1e-11, value)).quantize(Decimal("0.001"), ROUND_DOWN)
    return str(abs(whole) if whole == 0 else whole)


# Tables


@pytest.mark.parametrize("row", table("table1.csv"), ids=lambda row: f"{row['handle']}{row['axis']}")
def test_table_1_matches_to_the_digit(seed_march, row):
    times = [name for name in row if name.isdigit()]
    assert times == ["0", "60", "120", "180", "240", "300"]
    positions = seed_march.at([float(time) for time in times]).positions
    ours = positions[:, int(row["handle"]), "xy".index(row["axis"])]
    assert [cut(value) for value in ours] == [row[time] for time in times]


@pytest.mark.parametrize("row", table("table2.csv"), ids=lambda row: row["handle"])
def test_table_2_matches_to_the_digit(seed_march, row):
    times = [name for name in row if name.isdigit()]
    assert times == ["0", "60", "120", "180", "240", "300"]
    speeds = seed_march.at([float(time) for time in times]).speeds[:, int(row["handle"])]
    assert [cut(value) for value in speeds] == [row[time] for time in times]


def test_tables_1_and_2_have_126_entries():
    assert sum(len(row) - 2 for row in table("table1.csv")) + sum(len(row) - 1 for row in table("table2.csv")) == 126


def test_table_3_is_one_moment_close_to_412_47_seconds(seed_march):
    times = np.arange(412.465, 412.48, 1e-5)
    states = seed_march.at(times)
    matches = np.full(times.size, True)
    for row in table("table3.csv"):
        handle = int(row["handle"])
        ours = (*states.positions[:, handle].T, states.speeds[:, handle])
        for name, values in zip(("x", "y", "speed"), ours, strict=True):
            matches &= [cut(value) == row[name] for value in values]
    window = times[matches]
    assert window.size > 0
    assert window.max() - window.min() < 1e-3
    assert 412.473 < window.min() < window.max() < 412.475


# The independent solution


def assert_matches_oracle(march, time, *, speeds=True):
    dragon = march.dragon
    positions, velocities = oracle.solve(
        time,
        benches=dragon.benches,
        head_spacing=dragon.head_spacing,
        body_spacing=dragon.body_spacing,
        pitch=march.curve.pitch,
        turns=march.turns,
        speed=march.speed,
        difference=speeds,
    )
    states = march.at(time)
    assert len(positions) == dragon.handles == states.positions.shape[1]
    for (x, y), ours in zip(positions, states.positions[0].tolist(), strict=True):
        assert mp.hypot(x - ours[0], y - ours[1]) < 1e-10
    if speeds:
        for (x, y), ours, speed in zip(velocities, states.velocities[0].tolist(), states.speeds[0], strict=True):
            assert mp.hypot(x - ours[0], y - ours[1]) < 1e-9
            assert abs(mp.hypot(x, y) - float(speed)) < 1e-9


@pytest.mark.parametrize(
    "time",
    [412.47, *(pytest.param(time, marks=pytest.mark.thorough) for time in (0, 150, 300, 430, LAST - 1e-3, -100.5))],
)
def test_every_handle_is_where_the_oracle_has_it(seed_march, time):
    assert_matches_oracle(seed_march, time)


def test_positions_hold_a_microsecond_before_the_dragon_cannot_be_placed(seed_march):
    assert_matches_oracle(seed_march, LAST - 1e-6, speeds=False)


def test_positions_hold_a_day_before_the_start():
    assert_matches_oracle(March(Dragon(benches=20)), -86_400, speeds=False)


@pytest.mark.thorough
def test_pitch_barely_above_the_width_agrees_with_the_oracle():
    assert_matches_oracle(March(Dragon(benches=60), Spiral(pitch=0.31)), 100)


def test_benches_nearly_as_long_as_the_turn_is_wide_agree_with_the_oracle():
    # Turn 3.4 is 3.5 m wide where the head's bench lies across it.
    dragon = Dragon(benches=30, head_spacing=3.45, body_spacing=3.4)
    assert_matches_oracle(March(dragon, turns=3.4), 0)


@pytest.mark.parametrize("time", [0, 2.5])
def test_small_dragon_close_to_the_centre_agrees_with_the_oracle(time):
    assert_matches_oracle(March(SMALL, turns=1.5), time)


def test_head_at_the_very_centre_agrees_with_the_oracle():
    march = March(SMALL, turns=1.5)
    states = march.at([march.end - 1e-3])
    assert np.linalg.norm(states.positions[0, 0]) < 1.1e-3
    assert_matches_oracle(march, march.end - 1e-3)


@pytest.mark.thorough
def test_thousand_benches_agree_with_the_oracle():
    assert_matches_oracle(March(Dragon(benches=1000)), 50, speeds=False)


# What rigid benches demand

dragons = st.builds(
    Dragon,
    benches=st.integers(2, 40),
    head_spacing=st.floats(0.6, 4),
    body_spacing=st.floats(0.6, 4),
    overhang=st.just(0.1),
    width=st.just(0.3),
)


@st.composite
def marches(draw):
    try:
        return March(
            draw(dragons),
            Spiral(pitch=draw(st.floats(0.31, 2))),
            turns=draw(st.floats(1, 30)),
            speed=draw(st.floats(0.1, 5)),
        )
    except ParameterError:
        assume(False)


@given(marches(), st.floats(-100, 1))
def test_benches_keep_their_length_and_both_ends_go_along_with_them(march, when):
    time = when if when < 0 else when * 0.5 * march.end
    try:
        states = march.at(time)
    except UnreachableError:
        assume(False)
    along = states.positions[0, :-1] - states.positions[0, 1:]
    # Either hole is where its place is, to a few last digits of the place.
    resolution = 8 * np.spacing(np.abs(states.handles_s).max())
    assert np.linalg.norm(along, axis=-1) == pytest.approx(march.dragon.spacings, rel=1e-12, abs=resolution)
    unit = along / march.dragon.spacings[:, None]
    front = np.sum(unit * states.velocities[0, :-1], axis=-1)
    rear = np.sum(unit * states.velocities[0, 1:], axis=-1)
    assert front == pytest.approx(rear, rel=1e-9, abs=1e-11)


@given(marches())
def test_handles_follow_each_other_outward_and_at_most_one_turn_apart(march):
    gaps = np.diff(march.curve.angle(march.handles_s(0)[0]))
    assert np.all(gaps > 0)
    assert np.all(gaps <= 2 * np.pi + 1e-12)


def test_seed_benches_keep_their_length_to_the_last_digits(seed_march):
    states = seed_march.at(np.linspace(0, 432, 50))
    lengths = np.linalg.norm(np.diff(states.positions, axis=1), axis=-1)
    assert np.abs(lengths / seed_march.dragon.spacings - 1).max() < 1e-12


def test_head_speed_is_exactly_the_one_given():
    assert np.all(March(SMALL, speed=1.7).at(np.linspace(0, 100, 7)).speeds[:, 0] == 1.7)


def test_speed_is_the_length_of_the_velocity(seed_march):
    states = seed_march.at([0, 300, 430])
    assert np.linalg.norm(states.velocities, axis=-1) == pytest.approx(states.speeds, rel=1e-14)


def test_pose_velocities_are_the_rates_of_the_poses(seed_march):
    times = np.array([0, 100, 412.0])
    step = 1e-4
    before, after = seed_march.at(times - step).poses, seed_march.at(times + step).poses
    change = after - before
    change[..., 2] = (change[..., 2] + np.pi) % (2 * np.pi) - np.pi
    states = seed_march.at(times)
    assert states.pose_velocities.shape == states.poses.shape == (3, 223, 3)
    assert change / (2 * step) == pytest.approx(states.pose_velocities, abs=1e-7)


def test_faster_head_passes_the_same_places_sooner(seed_march):
    fast, slow = March(speed=4.0).at([50]), seed_march.at([200])
    assert fast.positions == pytest.approx(slow.positions, abs=1e-12)
    assert fast.velocities == pytest.approx(4 * slow.velocities, abs=1e-12)


def test_many_times_at_once_are_the_same_as_one_by_one(seed_march):
    times = np.array([-50, 0, 412.47, 299.9, 432.9, 17])
    together = seed_march.at(times)
    for row, time in enumerate(times):
        alone = seed_march.at(time)
        for name in ("times", "handles_s", "positions", "velocities", "speeds", "poses", "pose_velocities"):
            assert getattr(alone, name)[0] == pytest.approx(getattr(together, name)[row], rel=1e-12, abs=1e-12)


def test_first_handles_alone_are_those_of_the_whole_dragon(seed_march):
    few, all_ = seed_march.at([0, 100], handles=5), seed_march.at([0, 100])
    assert few.positions.shape == (2, 5, 2)
    assert np.array_equal(few.velocities, all_.velocities[:, :5])
    assert seed_march.handles_s([0, 1, 2], handles=1).shape == (3, 1)


@pytest.mark.parametrize("handles", [0, -1, 225, 2.0, "2", True])
def test_impossible_number_of_handles_is_refused(seed_march, handles):
    with pytest.raises(ParameterError, match=r"handles is .* whole number from 1 to 224"):
        seed_march.at(0, handles=handles)


def test_no_times_give_no_states(seed_march):
    assert seed_march.at([]).positions.shape == (0, 224, 2)


def test_states_cannot_be_changed_and_do_not_hold_the_callers_times(seed_march):
    times = np.array([0.0, 1.0])
    states = seed_march.at(times)
    times[0] = 99
    assert states.times.tolist() == [0, 1]
    with pytest.raises(ValueError, match="read-only"):
        states.positions[0, 0, 0] = 1


def test_head_that_turns_square_to_its_bench_pushes_the_dragon_back_out(seed_march):
    states = seed_march.at([431.5, 432.8])
    onward = np.sum(states.velocities * seed_march.curve.tangent(states.handles_s), axis=-1)
    assert np.all(onward[0] > 0)
    assert onward[1, 0] == pytest.approx(1)
    assert np.all(onward[1, 1:] < 0)
    assert np.all(states.speeds > 0)


# The paper's finite difference


def test_speeds_by_difference_converge_to_the_exact_ones_at_first_order(seed_march):
    times = [0, 100, 300, 412]
    exact = seed_march.at(times).speeds
    steps = 0.1 / 2 ** np.arange(5)
    errors = [np.abs(seed_march.speeds_by_difference(times, step) - exact).max(axis=1) for step in steps]
    order = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all((order > 0.95) & (order < 1.05)), order
    assert np.all(errors[-1] < 1e-2)


@pytest.mark.parametrize("step", NO_NUMBERS, ids=repr)
def test_impossible_difference_step_is_refused(seed_march, step):
    with pytest.raises(ParameterError) as caught:
        seed_march.speeds_by_difference([0], step)
    assert_says(caught.value, "step is ", "a number above 0 and finite s")


# Where a dragon has no place


def test_seed_dragon_cannot_be_placed_from_432_918_seconds_on(seed_march):
    seed_march.handles_s(LAST)
    with pytest.raises(UnreachableError) as caught:
        seed_march.handles_s(LAST + 1e-7)
    assert caught.value.handle == 1
    with pytest.raises(oracle.UnplaceableError) as independent:
        oracle.solve(LAST + 1e-7, benches=1, head_spacing=2.86, body_spacing=1.65, pitch=0.55, turns=16, speed=1)
    assert independent.value.args == (1,)


def test_head_that_bends_too_tightly_is_named_with_its_time(seed_march):
    with pytest.raises(UnreachableError) as caught:
        seed_march.at([0, 433.5])
    assert (caught.value.time, caught.value.handle) == (433.5, 1)
    assert_says(caught.value, "handle 1 has no position at t = 433.5 s", "bends too tightly for a spacing of 2.86 m")


def test_end_of_the_curve_is_named_for_the_head(seed_march):
    assert seed_march.end == pytest.approx(442.590256432)
    with pytest.raises(UnreachableError) as caught:
        seed_march.at(443)
    assert (caught.value.time, caught.value.handle) == (443, 0)
    assert_says(caught.value, "handle 0 has no position at t = 443 s", "the curve ends at t = 442.59 s")


def test_earliest_of_unordered_times_is_named(seed_march):
    with pytest.raises(UnreachableError) as caught:
        seed_march.at([500, 100, 434, 1e308, 433, 450])
    assert (caught.value.time, caught.value.handle) == (433, 1)


def test_later_bench_that_bends_too_tightly_is_named():
    dragon = Dragon(benches=5, head_spacing=1, body_spacing=4, overhang=0.1)
    march = March(dragon, turns=8)
    with pytest.raises(UnreachableError) as caught:
        march.at(np.linspace(0, march.end, 2000))
    assert caught.value.handle == 2
    assert_says(caught.value, "for a spacing of 4 m")


# Bad input


@pytest.mark.parametrize(
    ("name", "value"),
    [
        (name, value)
        for name in ("turns", "speed")
        for value in [*NO_NUMBERS, 1001, 1e308, -1e-6]
        if (name, value is None) != ("turns", True)  # without turns it is the contest's
    ],
    ids=repr,
)
def test_impossible_turns_and_speed_are_refused(name, value):
    with pytest.raises(ParameterError) as caught:
        March(**{name: value})
    assert caught.value.name == name
    allowed = {"turns": "a number above 0 and at most 1000", "speed": "a number from 1e-06 to 20 m/s"}
    assert_says(caught.value, f"{name} is ", f"must be {allowed[name]}")


@pytest.mark.parametrize("value", [None, "spiral", 3, Dragon, [Dragon()]], ids=repr)
def test_what_is_no_dragon_or_no_curve_is_refused(value):
    with pytest.raises(ParameterError, match=r"^dragon is .* a Dragon$"):
        March(value)
    with pytest.raises(ParameterError, match=r"^curve is .* a Curve$"):
        March(Dragon(), value)


@pytest.mark.parametrize("pitch", [0.3, 0.2999, 0.001])
def test_pitch_of_the_width_or_less_is_refused(pitch):
    with pytest.raises(ParameterError, match=r"more than the width, 0.3 m") as caught:
        March(Dragon(), Spiral(pitch=pitch))
    assert caught.value.name == "pitch"
    assert_says(caught.value)


def test_head_too_long_for_its_first_turn_is_refused_at_the_start():
    with pytest.raises(ParameterError, match="short enough for the curve at turn 2: handle 1") as caught:
        March(turns=2)
    assert (caught.value.name, caught.value.value) == ("head_spacing", 2.86)
    assert_says(caught.value)


def test_body_too_long_for_its_first_turn_is_refused_at_the_start():
    with pytest.raises(ParameterError, match="short enough for the curve at turn 2: handle 2") as caught:
        March(Dragon(head_spacing=0.7, body_spacing=5.0, overhang=0.1), turns=2)
    assert (caught.value.name, caught.value.value) == ("body_spacing", 5.0)


def test_start_next_to_the_centre_is_refused_for_the_seed_dragon_and_taken_by_one_that_fits():
    with pytest.raises(ParameterError, match="head_spacing"):
        March(turns=1e-9)
    wide = March(Dragon(benches=3), Spiral(pitch=100), turns=1e-9)
    assert np.linalg.norm(wide.at(0).positions[0, 1]) == pytest.approx(2.86, abs=1e-6)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), float("-inf"), "noon", None, 1j, -1e308, -1e6, 10**400])
def test_impossible_time_is_refused(seed_march, bad):
    for times in (bad, [0, bad]):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(ParameterError) as caught:
                seed_march.at(times)
        assert caught.value.name == "times"
        assert_says(caught.value, "times is ", "finite numbers")


def test_numpy_scalars_become_plain_numbers():
    march = March(turns=np.float32(16), speed=np.int64(1))
    assert march == March()
    assert (type(march.turns), type(march.speed)) == (float, float)


@examples(50)
@given(st.floats(min_value=1e-6, max_value=1e-2))
def test_snails_pace_is_a_pace(speed):
    march = March(SMALL, speed=speed)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        states = march.at([-3, 0, 1])
    assert np.all(np.isfinite(states.positions))
    assert np.all(states.speeds[:, 0] == speed)


# What is worth looking at


def test_span_of_a_spiral_goes_from_the_tail_to_the_centre(seed_march):
    tail, early = seed_march.handles_s([0.0, -50.0])[:, -1]
    assert seed_march.span(0.0, 100.0) == pytest.approx((tail, 0.0))
    assert seed_march.span(-50.0, -40.0) == pytest.approx((early, 0.0))


def test_span_of_a_curve_with_two_ends_is_all_of_it():
    for march in (TRACTOR, ARM):
        assert march.span(3.0, 5.0) == (march.curve.begin_s, march.curve.end_s)


def test_span_of_a_curve_without_ends_is_as_far_as_the_dragon_goes():
    assert U_TURN.span(-20.0, 30.0) == pytest.approx((U_TURN.handles_s(-20.0)[0, -1], 30.0))


def test_states_are_printed_and_given_as_json_values_for_chosen_handles():
    states = March(Dragon(benches=4)).at([0.0, 60.0])
    found = json.loads(json.dumps(states.to_dict([0, 4])))
    assert (found["times"], found["handles"]) == ([0, 60], [0, 4])
    assert found["positions"] == states.positions[:, [0, 4]].tolist()
    assert found["speeds"] == states.speeds[:, [0, 4]].tolist()
    assert states.rows([4])[1] == (60.0, 4, *states.positions[1, 4], states.speeds[1, 4])
    heads, first, *others = str(states).splitlines()
    assert heads.split() == ["t", "(s)", "handle", "x", "(m)", "y", "(m)", "speed", "(m/s)"]
    assert first.split() == ["0", "0", "8.800000", "0.000000", "1.000000"]
    assert len(others) == 9
