"""Benches, holes, poses and outlines."""

import itertools
import math
import pickle
from dataclasses import FrozenInstanceError, replace
from fractions import Fraction

import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says, refusal
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon import (
    Dragon,
    FileFormatError,
    March,
    ParameterError,
    SpeedTable,
    errors,
    outlines,
)
from pymunk_dragon.model.dragon import bench_poses

LENGTHS = ("head_spacing", "body_spacing", "overhang", "width")
TRACTOR = {
    "head_spacing": 3.0,
    "body_spacing": [4.0, 2.5, 6],
    "overhang": [0.5, 0.3, 0.8, 1],
    "width": [2, 1.5, 2.2, 1.8],
}
coordinates = st.floats(-100, 100)


def test_default_dragon_is_the_contests_and_cannot_be_changed():
    dragon = Dragon()
    assert dragon.benches == 223
    assert dragon.handles == 224
    assert dragon.width == 0.30
    assert dragon.spacings.tolist() == [2.86] + [1.65] * 222
    assert dragon.lengths.tolist() == pytest.approx([3.41] + [2.20] * 222)
    with pytest.raises(FrozenInstanceError):
        dragon.width = 1.0
    for array in (dragon.spacings, dragon.lengths, dragon.widths):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    assert Dragon(benches=2).spacings.tolist() == [2.86, 1.65]


def test_impossible_sizes_are_refused_by_name():
    for name in LENGTHS:
        for value in [*NO_NUMBERS, 1e-9, 1e9, 100.001]:
            error = refusal(Dragon, benches=223, **{name: value})
            assert error.value is value
            assert_says(error, f"{name} is ", "0.001 to 100 m")
    for value in [
        *(value for value in NO_NUMBERS if value is not None),
        1,
        10_001,
        10**5000,
        223.0,
        2.5,
    ]:
        assert refusal(Dragon, benches=value).name == "benches"
    for overhang in (0.825, 0.9, 50.0):
        assert_says(refusal(Dragon, overhang=overhang), "overhang is ", "0.825 m")
    for name, *cases in (
        (
            "width",
            {"benches": 223, "width": [0.3, 0.3]},
            {"width": [0.3]},
            {"width": [0.3] * 10_001},
            {"width": "0.3"},
        ),
        ("overhang", {"body_spacing": [1.65] * 3, "overhang": [0.2] * 3}),
        ("body_spacing", {"body_spacing": []}),
        ("head_spacing", {"head_spacing": [2.86, 1.65]}),
        ("width[1]", {"width": [0.3, -1, 0.3]}, {"width": [0.3, [0.3], 0.3]}),
        (
            "overhang beside bench 2",
            {"overhang": [0.1, 0.5, 0.2, 0.5], "body_spacing": [1.0, 1.0, 1.0]},
        ),
    ):
        for sizes in cases:
            assert_says(refusal(Dragon, **sizes), f"{name} is ")


def test_benches_may_differ():
    dragon = Dragon(**TRACTOR)
    assert dragon.spacings.tolist() == [3.0, 4.0, 2.5, 6.0]
    assert dragon.lengths.tolist() == pytest.approx([4.0, 4.6, 4.1, 8.0])
    assert dragon.widths.tolist() == TRACTOR["width"]
    for sizes in (
        {},
        {"width": [0.5, 0.3, 0.3]},
        {"overhang": [0.1, 0.2, 0.2], "body_spacing": [1.65, 1.65]},
    ):
        assert Dragon(**sizes).has_equal_benches
    for sizes in (
        {"width": [0.3, 0.3, 0.4]},
        {"overhang": [0.275, 0.275, 0.2]},
        {"body_spacing": [1.65, 1.7]},
    ):
        assert not Dragon(**sizes).has_equal_benches


def test_dragons_of_the_same_sizes_are_equal_whatever_kind_of_numbers_they_are_given():
    dragon = Dragon(**TRACTOR)
    same = Dragon(
        benches=4, head_spacing=3, **{name: np.array(TRACTOR[name]) for name in LENGTHS[1:]}
    )
    assert pickle.loads(pickle.dumps(dragon)) == dragon == same
    assert (
        len(
            {
                dragon,
                same,
                Dragon(benches=9),
                Dragon(benches=9),
                replace(Dragon(benches=9), benches=8),
            }
        )
        == 3
    )
    assert {type(size) for name in LENGTHS[1:] for size in getattr(same, name)} == {float}
    for kind in (np.float64, np.float32, np.float16, Fraction):
        dragon = Dragon(
            benches=np.int64(7), width=kind(0.25), head_spacing=np.int32(3), body_spacing=2
        )
        assert dragon == Dragon(benches=7, width=0.25, head_spacing=3.0, body_spacing=2.0)
        assert [type(getattr(dragon, name)) for name in ("benches", *LENGTHS)] == [int] + [
            float
        ] * 4


@given(st.lists(st.tuples(coordinates, coordinates, st.floats(-10, 10)), min_size=4, max_size=4))
def test_holes_are_a_spacing_apart_and_give_their_poses_back(poses):
    dragon = Dragon(benches=4)
    given_poses = np.array(poses)
    front, rear = dragon.holes(given_poses)
    assert np.linalg.norm(front - rear, axis=-1) == pytest.approx(dragon.spacings)
    back = np.stack([bench_poses(pair)[0] for pair in zip(front, rear, strict=True)])
    assert back[:, :2] == pytest.approx(given_poses[:, :2])
    assert np.exp(1j * back[:, 2]) == pytest.approx(np.exp(1j * given_poses[:, 2]), abs=1e-9)


@given(coordinates, coordinates, st.floats(-10, 10), st.floats(0.01, 50), st.floats(0.01, 50))
def test_outline_is_a_counter_clockwise_rectangle_about_the_centre(x, y, angle, length, width):
    (corners,) = outlines([[x, y, angle]], [length], width)
    sides = np.roll(corners, -1, axis=0) - corners
    tolerance = 1e-12 * (abs(x) + abs(y) + length + width)
    assert corners.mean(axis=0) == pytest.approx([x, y], abs=tolerance)
    assert np.linalg.norm(sides, axis=1) == pytest.approx(
        [length, width, length, width], abs=tolerance
    )
    turns = sides[:, 0] * np.roll(sides[:, 1], -1) - sides[:, 1] * np.roll(sides[:, 0], -1)
    assert turns == pytest.approx(
        np.full(4, length * width), rel=1e-9, abs=10 * tolerance * max(length, width)
    )
    assert sides[0] / length == pytest.approx(
        [math.cos(angle), math.sin(angle)], abs=10 * tolerance / length
    )


def test_outlines_reach_an_overhang_beyond_the_holes_and_are_as_wide_and_long_as_each_bench():
    corners = Dragon(benches=3).outlines(bench_poses([[0, 0], [-2.86, 0], [-4.51, 0], [-6.16, 0]]))
    assert corners[..., 0].max(axis=1) == pytest.approx([0.275, -2.585, -4.235])
    assert corners[..., 0].min(axis=1) == pytest.approx([-3.135, -4.785, -6.435])
    assert np.abs(corners[..., 1]) == pytest.approx(np.full((3, 4), 0.15))
    dragon = Dragon(**TRACTOR)
    poses = np.random.default_rng(3).normal(size=(2, 5, 4, 3))
    together = dragon.outlines(poses)
    sides = np.linalg.norm(np.roll(together, -1, axis=-2) - together, axis=-1)
    expected = np.tile(np.stack([dragon.lengths, dragon.widths], axis=-1), 2)
    assert sides == pytest.approx(np.broadcast_to(expected, (2, 5, 4, 4)))
    # Of many times, and of the first benches only, they are those of each.
    assert np.array_equal(together[1, 2], dragon.outlines(poses[1, 2]))
    assert np.array_equal(together[1, 2, :2], dragon.outlines(poses[1, 2, :2]))


def test_errors_pass_between_processes_and_are_one_line():
    others = (
        errors.FileFormatError("run.npz", "damaged"),
        errors.OutputError("run.npz", "disk full"),
    )
    others += (
        errors.UnreachableError(433.0, 1, "the curve bends"),
        errors.MissingExtraError("sweep", "sweep"),
    )
    for error in (
        ParameterError("width", -1.0, "positive"),
        errors.DragonError("no luck"),
        *others,
    ):
        back = pickle.loads(pickle.dumps(error))
        assert (type(back), str(back), vars(back)) == (type(error), str(error), vars(error))
        assert isinstance(error, errors.DragonError)
    assert str(ParameterError("a\nb", "c\nd", "e\n  f")) == r"a b is 'c\nd', but must be e f"


# How fast the head goes: numbers, tables and functions

TABLE = SpeedTable((-50.0, 10.0, 20.0, 20.5, 300.0), (0.5, 1.0, 3.0, 0.2, 1.5))
speeds = st.floats(0.01, 20)


@st.composite
def tables(draw):
    times = draw(
        st.lists(
            st.floats(-500, 500), min_size=1, max_size=8, unique_by=lambda time: round(time, 3)
        )
    )
    return SpeedTable(
        sorted(times), draw(st.lists(speeds, min_size=len(times), max_size=len(times)))
    )


def test_a_number_is_a_constant_speed():
    speed, times = March(speed=0.7).speed_profile, np.array([-3.0, 0.0, 412.473])
    assert (speed, March(speed=TABLE).speed_profile) == (SpeedTable([0], [0.7]), TABLE)
    assert speed.distance(times).tolist() == (0.7 * times).tolist()
    assert speed.time([1.0, -2.0]).tolist() == [1 / 0.7, -2 / 0.7]
    assert speed.at(times).tolist() == [0.7] * 3
    assert speed.fastest(0.0, 9.0) == 0.7


def test_a_tables_way_is_the_integral_of_its_speed():
    speeds = [0.5, 0.5, 0.75, 1.0, 2.0, 1.6, 1.5, 1.5]
    assert TABLE.at([-1e6, -50, -20, 10, 15, 20.25, 300, 1e6]).tolist() == pytest.approx(speeds)
    for time in (-300.0, -50.0, -7.3, 0.0, 9.999, 20.2, 123.4, 301.0, 900.0):
        knots = sorted({0.0, time, *(t for t in TABLE.times if min(0, time) < t < max(0, time))})
        exact = math.fsum(
            (b - a) * (TABLE.at(a) + TABLE.at(b)) / 2 for a, b in itertools.pairwise(knots)
        )
        assert TABLE.distance(time) == pytest.approx(
            math.copysign(exact, time), rel=1e-14, abs=1e-15
        )


@given(tables(), st.lists(st.floats(-2000, 2000), min_size=1))
def test_a_tables_time_is_the_inverse_of_its_way(table, times):
    found = table.time(table.distance(times))
    # A way is known to some units of its last place, and where the head is slow it stays there the
    # longer.
    allowed = 1e-12 * (1 + np.abs(table.distance(times))) / table.at(times) + 1e-12 * np.abs(times)
    assert np.all(np.abs(found - times) <= allowed)


@given(tables(), st.floats(-600, 600), st.floats(0, 300))
def test_a_tables_bound_is_the_largest_speed_in_between(table, begin, length):
    most = table.at(np.linspace(begin, begin + length, 301)).max()
    entries = [
        v for t, v in zip(table.times, table.speeds, strict=True) if begin <= t <= begin + length
    ]
    assert table.fastest(begin, begin + length) == pytest.approx(max([most, *entries]), rel=1e-12)


def test_impossible_tables_are_refused_with_the_entry():
    for times, values, words in (
        ([], [], "times is []"),
        ([0, 1], [1], "speeds is (1.0,)"),
        ([0, 2, 2], [1, 1, 2], "times[2] is 2.0"),
        ([0, math.nan], [1, 1], "times[1] is nan"),
        ([0, 1], [1, 0], "speeds[1] is 0"),
        ([0, 1], [-1, 1], "speeds[0] is -1"),
        ([0, 1], [1, "2"], "speeds is"),
        ([0, 1], [1, 21], "speeds[1] is 21"),
    ):
        assert_says(refusal(SpeedTable, times, values), words)
    same = SpeedTable([0, 1], np.array([1.0, 2.0]))
    assert same == SpeedTable((0.0, 1.0), [1, 2])
    assert hash(pickle.loads(pickle.dumps(same))) == hash(same)


def test_a_table_is_read_from_a_file_and_a_wrong_one_is_refused_with_the_line(tmp_path):
    path = tmp_path / "speed.csv"
    for head in ("", "time,speed\r\n", "\ufefft;v\n", "t\n", " t , v ,z\n", "t,\n", '"t","v"\n'):
        path.write_text(f'{head}0, 1\r\n\r\n"10" ,2.5', encoding="utf-8")
        assert SpeedTable.read(path) == SpeedTable((0, 10), (1, 2.5))
    for text, words in (
        ("t,v\n", "no line"),
        ("t,v\n0,1\n5,fast\n", "line 3"),
        ("0,1\n5\n", "line 2"),
        *((f"{first}\n0,1\n", "line 1 ") for first in ("t,1", "1,v", "1", "0,1,2", "0,1,v", ",1")),
        ("t,v\n\n0,1\n0,2\n", "line 4"),
        ("0,1\n5,-2\n", "line 2"),
    ):
        path.write_text(text)
        assert_says(refusal(SpeedTable.read, path, error=FileFormatError), "speed.csv", words)
    refusal(SpeedTable.read, tmp_path / "nowhere.csv")


def test_a_function_is_tabulated_in_equal_steps():
    table = SpeedTable.of(lambda t: 1 + 0.3 * math.sin(t), -20, 400.005)
    assert table.times[0] == -20
    assert table.times[-1] == 400.005
    assert len(table.times) == 42_002
    times = np.linspace(-20, 400, 999)
    # By a function's second derivative times step^2 / 8, and its integral over the whole time.
    assert np.abs(table.at(times) - 1 - 0.3 * np.sin(times)).max() < 0.3 * 0.01**2 / 8 * 1.001
    assert np.abs(table.distance(times) - times - 0.3 * (1 - np.cos(times))).max() < 1e-5
    assert SpeedTable.of(lambda t: 2, 0, 1, step=0.5) == SpeedTable([0, 0.5, 1], [2, 2, 2])
    for function in (lambda t: 1 / t, None, complex):
        assert refusal(SpeedTable.of, function, 0, 3).name == "function"
    assert refusal(SpeedTable.of, math.cos, 2, 3).name == "speeds[0]"
    for times, name in (
        ((1, 1), "until"),
        ((0, math.inf), "until"),
        (("0", 1), "start"),
        ((0, 1, 0), "step"),
    ):
        assert refusal(SpeedTable.of, math.exp, *times).name == name
    # A march takes tables only.
    assert refusal(March, speed=math.exp).name == "speed"


@pytest.mark.parametrize("value", [0.5, TABLE], ids=["number", "table"])
def test_shapes_are_kept_and_what_is_infinite_or_nan_stays_so(value):
    speed = March(speed=value).speed_profile
    for shape in ((), (0,), (3,), (2, 3)):
        zeros = np.zeros(shape)
        for answer in (speed.at(zeros), speed.distance(zeros), speed.time(zeros)):
            assert np.shape(answer) == shape
    ends = [-math.inf, math.inf, math.nan]
    np.testing.assert_array_equal(speed.distance(ends), ends)
    np.testing.assert_array_equal(speed.time(ends), ends)
