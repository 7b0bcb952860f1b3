"""The state of a chain is the one that continuous motion leads to, past jackknifes to a fold."""

import math
import pickle

import numpy as np
import pytest
from chain_follower import follow, random_path
from conftest import examples, refusal
from hypothesis import given
from hypothesis import strategies as st
from marches import DRAWN, bent
from test_curve_kinds import LogarithmicSpiral

from pymunk_dragon import (
    Arc,
    Composite,
    Dragon,
    Line,
    March,
    Run,
    Sampled,
    SpeedTable,
    Spiral,
    UnreachableError,
    UTurn,
    first_contact,
    scan,
    simulate,
)
from pymunk_dragon.model import chain

# Along the x axis, round and back above it at a height of 2 m, and up: a bench of 3 m stands on
# three of the lines.
HOOK = Composite(
    [
        Line(start=(-10, 0), stop=(0, 0)),
        Arc(centre=(0, 0.5), radius=0.5, begin_angle=-np.pi / 2, sweep=np.pi / 2),
        Line(start=(0.5, 0.5), stop=(0.5, 1.5)),
        Arc(centre=(0, 1.5), radius=0.5, begin_angle=0, sweep=np.pi / 2),
        Line(start=(0, 2), stop=(-2, 2)),
        Arc(centre=(-2, 2.5), radius=0.5, begin_angle=-np.pi / 2, sweep=-np.pi / 2),
        Line(start=(-2.5, 2.5), stop=(-2.5, 6)),
    ]
)
# Where the head is 2.5 m and then 3 m above the first line.
TOP = 10 + np.pi / 4 + 1 + np.pi / 4
RISE = TOP + 2 + np.pi / 4
BENCH = Dragon(benches=2, head_spacing=3.0, body_spacing=0.5, overhang=0.05, width=0.1)


def followed(march, heads, tolerance=1e-9):
    """States of a march, equal to those of small steps, and where small steps end."""
    states, end = follow(
        march.curve, march.motion_or_nan(0.0).handles_s[0], heads, march.dragon.spacings
    )
    ours = march.motion_or_nan(heads - march.head_start).handles_s
    assert len(states) > 10
    assert ours[: len(states)] == pytest.approx(states, abs=tolerance)
    # Small steps may miss the end by some of them.
    beyond = (heads - end) * np.sign(heads[-1] - heads[0]) > 0.02
    assert np.isnan(ours[beyond]).any(axis=1).all()
    return ours, end


@pytest.mark.parametrize(
    ("pitch", "ratio"),
    [(1.7, 3.0), *(pytest.param(1.7, ratio, marks=pytest.mark.thorough) for ratio in (2.5, 1 / 3))],
)
def test_a_head_bench_longer_than_the_turn_is_wide_jackknifes_and_goes_on(pitch, ratio):
    march = March(Dragon(benches=2), UTurn(pitch=pitch, ratio=ratio))
    heads = np.arange(1.0, 19.0)
    states, end = follow(
        march.curve, march.motion_or_nan(0.0).handles_s[0], heads, march.dragon.spacings, step=0.02
    )
    assert end == np.inf
    assert np.abs(march.motion_or_nan(heads).handles_s - states).max() < 1e-10
    assert np.any(np.diff(states[:, 1]) < 0)
    # Not where the first distance that grows all the way leads to.
    assert np.isnan(march.curve.chain(heads, march.dragon.spacings)).any()


def test_handle_is_pushed_back_and_motion_ends_for_good_where_the_closed_form_has_them():
    march = March(BENCH, HOOK, start_s=4.0)
    # On two parallel lines 2 m apart the bench keeps its direction.
    heads = np.linspace(TOP + 1e-9, TOP + 2, 9)
    assert march.motion_or_nan(heads - 4).handles_s[:, 1] == pytest.approx(
        TOP - heads - math.sqrt(5) + 10, abs=1e-11
    )
    # With the head h above the first line, its rear handle is sqrt(9 - h^2) behind it there.
    heights = np.linspace(2.5, 3 - 1e-9, 12)
    rear = -2.5 - np.sqrt(9 - heights**2) + 10
    assert march.motion_or_nan(RISE + heights - 2.5 - 4).handles_s[:, 1] == pytest.approx(
        rear, abs=1e-8
    )
    fold = RISE + 0.5 - 4
    march.at(fold - 1e-10)
    for late in (1e-10, 1e-3, 0.5, march.end - fold):
        error = refusal(march.at, [fold - 1, fold + late], error=UnreachableError)
        assert (error.time, error.handle) == (fold + late, 1)
    # Although other states exist there.
    assert not np.isnan(HOOK.chain([HOOK.end_s], [3.0])).any()


def test_a_handle_pushed_past_the_begin_of_the_curve_and_drawn_on_again_is_lost():
    # It begins 5.4 m further on.
    path = Composite([Line(start=(-4.6, 0), stop=(0, 0)), *HOOK.pieces[1:]])
    march = March(BENCH, path, start_s=4.0)
    _, end = followed(march, np.linspace(march.head_start, RISE - 5.4 + 0.45, 100)[1:])
    assert end < RISE - 5.4


@pytest.mark.parametrize(
    "seed", [39, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in (5, 9))]
)
def test_random_paths_are_followed_to_where_small_steps_end(seed):
    rng = np.random.default_rng(seed)
    path = random_path(rng)
    sizes = {"head_spacing": rng.uniform(0.6, 2.5), "body_spacing": rng.uniform(0.4, 1.2)}
    march = March(Dragon(benches=int(rng.integers(2, 6)), overhang=0.05, width=0.05, **sizes), path)
    followed(march, np.linspace(march.head_start, path.end_s, 80)[1:-1], tolerance=1e-8)


@pytest.mark.thorough
def test_the_way_back_in_time_is_followed_as_well():
    march = March(BENCH, HOOK, start_s=HOOK.end_s)
    followed(march, np.linspace(march.head_start, 7.0, 60)[1:])


def test_states_do_not_depend_on_the_order_of_questions():
    curve, times = UTurn(ratio=3.0), np.array([1.0, 30.0, 12.0, -5.0, 14.5])
    marches = [
        March(dragon, curve)
        for dragon in (Dragon(benches=20), Dragon(benches=20, body_spacing=1.5))
    ]
    for march in (*marches, marches[0].at_unit_speed()):
        for time in times[::-1]:
            march.motion_or_nan(time)
        alone = March(march.dragon, curve)
        expected = alone.motion_or_nan(times).handles_s
        for same in (march, pickle.loads(pickle.dumps(alone))):
            assert np.array_equal(same.motion_or_nan(times).handles_s, expected)
        first, second = expected[:1], expected[1:2]
        assert np.array_equal(
            march.continuation.ranges(first, second), alone.continuation.ranges(first, second)
        )


MOVING = [
    March(Dragon(benches=3), bent(20, 1.3, np.pi, 20), start_s=23.0),
    March(Dragon(benches=6), UTurn(ratio=3.0)),
    March(Dragon(benches=4), DRAWN, start_s=20.0),
    March(Dragon(benches=3, head_spacing=2.0, body_spacing=1.0), Spiral(pitch=2.5), turns=2),
    March(BENCH, HOOK, start_s=RISE + 2),
    March(
        Dragon(benches=3, head_spacing=0.5, body_spacing=0.3, overhang=0.05, width=0.1),
        LogarithmicSpiral(),
    ),
]
# Coordinates, certificates and runs, at times around the start at which benches may be pushed back.
CALLS = {
    "at the start": lambda march: march.motion_or_nan(0.0),
    "later": lambda march: march.motion_or_nan([0.0, 0.3, 1.7]),
    "earlier": lambda march: march.motion_or_nan([-0.2, 0.0, -1.1]),
    "fewer": lambda march: march.motion_or_nan([1.1, 0.0], 2),
    "far": lambda march: march.motion_or_nan(3.3),
    "contact": lambda march: plain(first_contact, march, until=1.0),
    "scan": lambda march: plain(scan, march, until=1.0, step=0.3),
    "engine": lambda march: plain(simulate, march, until=0.2, contacts="report"),
}


def plain(function, march, **options):
    """Values of a result that are equal if all their digits are."""
    found = function(march, **options)
    return (
        [found.times, found.poses, found.drift]
        if isinstance(found, Run)
        else [repr(found.to_dict())]
    )


@examples(30)
@given(
    st.sampled_from(MOVING),
    st.sampled_from(sorted(CALLS)),
    st.lists(st.sampled_from(sorted(CALLS)), max_size=4),
)
def test_no_digit_depends_on_earlier_calls(march, name, earlier):
    fresh, used = (March(march.dragon, march.curve, start_s=march.head_start) for _ in range(2))
    for call in earlier:
        CALLS[call](used)
    for found, expected in zip(CALLS[name](used), CALLS[name](fresh), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_ranges_near_the_centre_of_a_spiral_contain_a_handle_that_reverses_there():
    march = March(Dragon(benches=3, head_spacing=2.0, body_spacing=1.0), Spiral(pitch=2.5), turns=2)
    between = march.handles_s(np.linspace(march.end - 3, march.end, 3001))
    assert np.diff(between[:, 1]).min() < -1e-3
    assert between[:, 1].max() > between[[0, -1], 1].max() + 0.1
    lows, highs = march.continuation.ranges(between[:1], between[-1:])
    assert np.all(lows <= between + 1e-12)
    assert np.all(highs >= between - 1e-12)


def test_the_state_at_the_start_is_the_one_along_the_path():
    """Also where the path is curved more than a circle with the bench as its diameter."""
    march = March(BENCH, HOOK, start_s=RISE + 2)
    expected = HOOK.chain([RISE + 2], BENCH.spacings)
    assert RISE + 2 - expected[0, 1] > 3.5
    assert march.motion_or_nan([-0.1, 0.0]).handles_s[1:] == pytest.approx(expected, abs=1e-12)
    # There is none in the middle of a jackknife.
    assert refusal(March, BENCH, HOOK, start_s=TOP + 1).name == "start_s"


# The equations of rigid chains against finite differences of positions, on curves of several kinds

SPACINGS = np.array([2.86, 1.65, 1.65, 1.2])
# Curves with a coordinate of the head, m, at which all handles are on one piece.
CURVES = {
    "line": (Line(stop=(40, 5)), 20.0),
    "arc": (Arc(radius=6, sweep=-5), 20.0),
    "spiral": (Spiral(), Spiral().at_turn(5)),
    "outward spiral": (Spiral(pitch=1.7, outward=True), 120.0),
    "spline": (Sampled([(0, 0), (10, 3), (20, -2), (30, 4), (40, 0)]), 25.0),
    "u-turn": (UTurn(), 1.0),
}
# s: central differences lose as much to rounding as to curvature.
STEP = 2e-5


FOUR = Dragon(body_spacing=SPACINGS[1:])
MARCHES = {
    name: (March(FOUR, curve, start_s=head), [0.0]) for name, (curve, head) in CURVES.items()
}
MARCHES["the paper's"] = March(), [0, 100, 300, 412]
# Handles go back.
MARCHES["jackknife"] = March(Dragon(benches=4), UTurn(ratio=3.0)), range(10, 20)
# Between entries of the table of speeds.
WAVE = SpeedTable.of(lambda t: 1 + 0.5 * np.sin(t), -5, 5)
MARCHES["changing speed"] = (
    March(Dragon(benches=4), UTurn(), speed=WAVE),
    [-2.003, 0.502, 2.503, 4.003],
)


@pytest.mark.parametrize(("march", "times"), MARCHES.values(), ids=MARCHES)
def test_velocities_are_the_rates_of_coordinates_positions_and_poses(march, times):
    now, before, after = (march.at(np.add(times, late)) for late in (0, -STEP, STEP))
    coordinates, positions, poses = (
        (getattr(after, name) - getattr(before, name)) / (2 * STEP)
        for name in ("handles_s", "positions", "poses")
    )
    poses[..., 2] = (poses[..., 2] + np.pi / 2 / STEP) % (np.pi / STEP) - np.pi / 2 / STEP
    assert now.speeds == pytest.approx(np.abs(coordinates), abs=2e-8)
    assert now.speeds == pytest.approx(np.linalg.norm(now.velocities, axis=-1), rel=1e-14)
    assert now.velocities == pytest.approx(positions, abs=2e-8)
    assert now.pose_velocities == pytest.approx(poses, abs=2e-8)


@pytest.mark.parametrize(("curve", "head"), CURVES.values(), ids=CURVES)
def test_bounds_hold_for_the_rates_and_their_changes(curve, head):
    """With the curvature's own bound; the changes are differences between heads a step apart."""
    handles_s = curve.chain(head + np.linspace(-0.5, 0.5, 201), SPACINGS)
    front, rear = chain.angles(*curve.frame(handles_s), SPACINGS)
    ratio, omega = front.real / rear.real, chain.angular_rates(front, rear, SPACINGS)
    curvature = curve.max_curvature(handles_s[:, 1:].min(axis=0), handles_s[:, :-1].max(axis=0))
    sines = np.abs(front.imag).max(axis=0), np.abs(rear.imag).max(axis=0)
    bounds = chain.rate_bounds(
        sines, np.abs(ratio).max(axis=0), rear.real.min(axis=0), curvature, SPACINGS
    )
    along = np.diff(handles_s[:, :-1], axis=0)
    for measured, bound in (
        (ratio, bounds.ratio),
        (np.diff(ratio, axis=0) / along, bounds.ratio_change),
        (omega, bounds.omega),
        (np.diff(omega, axis=0) / along, bounds.omega_change),
    ):
        assert (np.abs(measured) <= bound + 1e-9).all()


def test_whole_chains_never_end_on_another_turn(monkeypatch):
    """Newton's method from an estimate on another turn finds other handles: they are refused."""
    spiral = Spiral(pitch=0.3)
    heads = np.array([spiral.at_turn(turns) for turns in (3, 5, 9)])
    spacings = np.array([1.65, 1.65])
    expected = spiral.chain(heads, spacings)
    # Only a wrong estimate leads there, so that of the spiral is replaced.
    near = spiral._estimate(heads, spiral._parameter(heads), spacings[:, None])
    for back in (0.3, 0.5, 0.99, 1.0, 1.01, 2.0):
        estimate = near - back * 2 * np.pi * np.array([[0], [1], [1]])
        monkeypatch.setattr(
            Spiral, "_estimate", lambda self, *arguments, estimate=estimate: estimate.copy()
        )
        np.testing.assert_allclose(spiral.chain(heads, spacings), expected, rtol=0, atol=1e-11)
