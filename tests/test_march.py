"""Exact kinematics: an independent solution in many digits, and what rigid benches demand."""

import warnings

import mpmath as mp
import numpy as np
import oracle
import pytest
from conftest import NO_NUMBERS, assert_says, refusal
from exact_curves import UnplaceableError
from hypothesis import assume, given
from hypothesis import strategies as st
from test_first_contact import marches

from pymunk_dragon import Dragon, March, Spiral, UnreachableError

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
        *((March(SMALL, turns=1.5), time, True) for time in (2.5, March(SMALL, turns=1.5).end - 1e-3)),
    ],
)
def test_every_handle_is_where_the_oracle_has_it(march, time, speeds):
    sizes = {name: getattr(march.dragon, name) for name in ("benches", "head_spacing", "body_spacing")}
    motion = {"pitch": march.curve.pitch, "turns": march.turns, "speed": march.speed, "difference": speeds}
    positions, velocities = oracle.solve(time, **sizes, **motion)
    states = march.at(time)
    assert len(positions) == march.dragon.handles == states.positions.shape[1]
    for (x, y), ours in zip(positions, states.positions[0].tolist(), strict=True):
        assert mp.hypot(x - ours[0], y - ours[1]) < 1e-10
    if speeds:
        for (x, y), ours, speed in zip(velocities, states.velocities[0].tolist(), states.speeds[0], strict=True):
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
    assert np.linalg.norm(along, axis=-1) == pytest.approx(march.dragon.spacings, rel=1e-12, abs=resolution)
    unit = along / march.dragon.spacings[:, None]
    front = np.sum(unit * states.velocities[0, :-1], axis=-1)
    rear = np.sum(unit * states.velocities[0, 1:], axis=-1)
    assert front == pytest.approx(rear, rel=1e-9, abs=1e-11)


def test_velocities_are_the_rates_of_the_poses_of_rigid_benches(seed_march):
    times, step = np.array([0, 100, 300, 412.0, 430]), 1e-4
    states, before, after = seed_march.at(times), seed_march.at(times - step), seed_march.at(times + step)
    lengths = np.linalg.norm(np.diff(states.positions, axis=1), axis=-1)
    assert np.abs(lengths / seed_march.dragon.spacings - 1).max() < 1e-12
    assert np.linalg.norm(states.velocities, axis=-1) == pytest.approx(states.speeds, rel=1e-14)
    change = (after.poses - before.poses)[:4]
    change[..., 2] = (change[..., 2] + np.pi) % (2 * np.pi) - np.pi
    assert change / (2 * step) == pytest.approx(states.pose_velocities[:4], abs=1e-7)


def test_states_of_many_times_and_of_the_first_handles_are_those_of_each(seed_march):
    times = np.array([-50, 0, 412.47, 299.9, 432.9, 17])
    together = seed_march.at(times)
    few = seed_march.at(times, handles=5)
    times[0] = 99
    assert together.times[0] == -50
    for row, time in enumerate(together.times):
        alone = seed_march.at(time)
        for name in STATES:
            assert getattr(alone, name)[0] == pytest.approx(getattr(together, name)[row], rel=1e-12, abs=1e-12)
    assert np.array_equal(few.velocities, together.velocities[:, :5])
    assert seed_march.handles_s([0, 1, 2], handles=1).shape == (3, 1)
    assert seed_march.at([]).positions.shape == (0, 224, 2)


def test_speeds_by_difference_converge_to_the_exact_ones_at_first_order(seed_march):
    times = [0, 100, 300, 412]
    exact = seed_march.at(times).speeds
    steps = 0.1 / 2 ** np.arange(5)
    errors = [np.abs(seed_march.speeds_by_difference(times, step) - exact).max(axis=1) for step in steps]
    order = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all((order > 0.95) & (order < 1.05)), order
    assert np.all(errors[-1] < 1e-2)


def test_seed_dragon_cannot_be_placed_from_432_918_seconds_on(seed_march):
    seed_march.handles_s(LAST)
    assert unreachable(seed_march, LAST + 1e-7)[1] == 1
    with pytest.raises(UnplaceableError) as independent:
        oracle.solve(LAST + 1e-7, benches=1, head_spacing=2.86, body_spacing=1.65, pitch=0.55, turns=16, speed=1)
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
        for value in [*NO_NUMBERS, 1001, 1e308, -1e-6]:
            if (name, value is None) != ("turns", True):  # without turns it is the contest's
                assert_says(refusal(March, **{name: value}), f"{name} is ", bound)
    for value in (None, "spiral", 3, Dragon, [Dragon()]):
        assert refusal(March, value).name == "dragon"
        assert refusal(March, Dragon(), value).name == "curve"
    assert refusal(March, Dragon(), Spiral(pitch=0.3)).name == "pitch"
    # Benches too long for the first turn.
    for settings, name, value in (
        ({"turns": 2}, "head_spacing", 2.86),
        ({"dragon": Dragon(head_spacing=0.7, body_spacing=5.0, overhang=0.1), "turns": 2}, "body_spacing", 5.0),
    ):
        error = refusal(March, **settings)
        assert (error.name, error.value) == (name, value)
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
