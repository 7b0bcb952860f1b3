"""Benches, holes, poses and outlines."""

from __future__ import annotations

import math
import pickle
from dataclasses import FrozenInstanceError, replace
from fractions import Fraction

import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon import errors
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon, bench_poses, interpolated, outlines

LENGTHS = ("head_spacing", "body_spacing", "overhang", "width")
coordinates = st.floats(-100, 100)
points = st.tuples(coordinates, coordinates)


def test_default_dragon_is_the_contests():
    dragon = Dragon()
    assert dragon.benches == 223
    assert dragon.handles == 224
    assert dragon.spacings.tolist() == [2.86] + [1.65] * 222
    assert dragon.lengths.tolist() == pytest.approx([3.41] + [2.20] * 222)
    assert dragon.width == 0.30


def test_sizes_cannot_be_changed_afterwards():
    dragon = Dragon()
    with pytest.raises(FrozenInstanceError):
        dragon.width = 1.0
    for array in (dragon.spacings, dragon.lengths):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@pytest.mark.parametrize("name", LENGTHS)
@pytest.mark.parametrize("value", [*NO_NUMBERS, 1e-9, 1e9, 100.001], ids=repr)
def test_impossible_length_is_refused_by_name(name, value):
    with pytest.raises(ParameterError) as caught:
        Dragon(benches=223, **{name: value})
    assert caught.value.name == name
    assert caught.value.value is value
    assert_says(caught.value, f"{name} is ", "must be a number from 0.001 to 100 m")


@pytest.mark.parametrize("value", [*NO_NUMBERS, 1, 10_001, 10**5000, 223.0, 2.5], ids=lambda value: repr(type(value)))
def test_impossible_number_of_benches_is_refused(value):
    with pytest.raises(ParameterError) as caught:
        Dragon(benches=value)
    assert caught.value.name == "benches"
    assert_says(caught.value, "benches is ", "must be a whole number from 2 to 10000")


@pytest.mark.parametrize("overhang", [0.825, 0.9, 50.0])
def test_overhang_of_half_a_spacing_is_refused(overhang):
    with pytest.raises(ParameterError, match=r"overhang is .* less than half the shortest spacing, 0.825 m") as caught:
        Dragon(overhang=overhang)
    assert_says(caught.value)


TRACTOR = {
    "head_spacing": 3.0,
    "body_spacing": [4.0, 2.5, 6],
    "overhang": [0.5, 0.3, 0.8, 1],
    "width": [2, 1.5, 2.2, 1.8],
}


def test_benches_may_differ():
    dragon = Dragon(**TRACTOR)
    assert dragon.benches == 4
    assert dragon.spacings.tolist() == [3.0, 4.0, 2.5, 6.0]
    assert dragon.overhangs.tolist() == [0.5, 0.3, 0.8, 1.0]
    assert dragon.widths.tolist() == [2.0, 1.5, 2.2, 1.8]
    assert dragon.lengths.tolist() == pytest.approx([4.0, 4.6, 4.1, 8.0])
    assert not dragon.alike
    with pytest.raises(ValueError, match="read-only"):
        dragon.widths[0] = 1.0


def test_dragons_of_lists_are_equal_and_hash_alike():
    dragon = Dragon(**TRACTOR)
    arrays = {name: np.array(TRACTOR[name]) for name in LENGTHS[1:]}
    same = Dragon(benches=4, head_spacing=3, **arrays)
    assert dragon == same
    assert hash(dragon) == hash(same)
    assert {type(size) for name in LENGTHS[1:] for size in getattr(dragon, name)} == {float}
    assert pickle.loads(pickle.dumps(dragon)) == dragon
    assert replace(dragon, width=0.5).width == 0.5


@pytest.mark.parametrize(
    ("sizes", "alike"),
    [
        ({}, True),
        ({"width": [0.5, 0.3, 0.3]}, True),
        ({"overhang": [0.1, 0.2, 0.2], "body_spacing": [1.65, 1.65]}, True),
        ({"width": [0.3, 0.3, 0.4]}, False),
        ({"overhang": [0.275, 0.275, 0.2]}, False),
        ({"body_spacing": [1.65, 1.7]}, False),
    ],
)
def test_benches_are_alike_where_all_but_the_head_have_the_same_sizes(sizes, alike):
    assert Dragon(**sizes).alike is alike


@pytest.mark.parametrize(
    ("sizes", "words"),
    [
        ({"benches": 223, "width": [0.3, 0.3]}, ["width is [0.3, 0.3]", "or 223 of them, one for each bench"]),
        ({"width": [0.3] * 3, "overhang": [0.2] * 4}, ["width is ", "or 4 of them"]),
        ({"body_spacing": [1.65] * 3, "overhang": [0.2] * 3}, ["overhang is ", "or 4 of them"]),
        ({"width": [0.3]}, ["width is [0.3]", "or 2 to 10000 of them"]),
        ({"body_spacing": []}, ["body_spacing is []", "or 1 to 9999 of them"]),
        ({"width": [0.3] * 10_001}, ["width is ", "or 2 to 10000 of them"]),
        ({"width": [0.3, -1, 0.3]}, ["width[1] is -1", "must be a number from 0.001 to 100 m"]),
        ({"width": [0.3, [0.3], 0.3]}, ["width[1] is [0.3]"]),
        ({"head_spacing": [2.86, 1.65]}, ["head_spacing is [2.86, 1.65]", "must be a number"]),
        ({"width": "0.3"}, ["width is '0.3'"]),
        (
            {"overhang": [0.1, 0.5, 0.2, 0.5], "body_spacing": [1.0, 1.0, 1.0]},
            ["overhang beside bench 2 is (0.5, 0.5)", "spacing of bench 2 between them, 1 m"],
        ),
    ],
)
def test_impossible_lists_are_refused_by_name(sizes, words):
    with pytest.raises(ParameterError) as caught:
        Dragon(**sizes)
    assert_says(caught.value, *words)


@given(st.lists(st.floats(0.01, 1.0), min_size=3, max_size=6), st.integers(0, 5))
def test_benches_before_and_after_one_never_meet_when_all_are_straight(overhangs, shortest):
    """The chain laid out straight: no bench may reach one that it shares no hole with."""
    benches, shortest = len(overhangs), shortest % len(overhangs)
    spacings = [5.0] * benches
    spacings[shortest] = 1.0
    ends = np.concatenate([[0.0], -np.cumsum(spacings)])
    front, rear = ends[:-1] + overhangs, ends[1:] - overhangs
    apart = all(rear[i] > front[i + 2] for i in range(benches - 2))
    # At the ends a bench has one neighbour only, and counts as its own second one.
    if shortest in (0, benches - 1):
        beside = overhangs[1] if shortest == 0 else overhangs[-2]
        apart = overhangs[shortest] + beside < 1.0
    try:
        Dragon(head_spacing=spacings[0], body_spacing=spacings[1:], overhang=overhangs)
    except ParameterError:
        assert not apart
    else:
        assert apart


def test_outlines_are_as_wide_and_long_as_each_bench():
    dragon = Dragon(**TRACTOR)
    corners = dragon.outlines(np.random.default_rng(3).normal(size=(5, 4, 3)))
    sides = np.linalg.norm(np.roll(corners, -1, axis=-2) - corners, axis=-1)
    assert sides == pytest.approx(
        np.tile(np.stack([dragon.lengths, dragon.widths], axis=-1), 2)[None].repeat(5, axis=0)
    )
    poses = [[1.0, 2.0, 0.5], [3.0, 4.0, 0.1]]
    assert np.array_equal(dragon.outlines(poses), outlines(poses, dragon.lengths[:2], dragon.widths[:2]))


def test_two_benches_are_the_shortest_dragon():
    assert Dragon(benches=2).spacings.tolist() == [2.86, 1.65]


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.float16, Fraction])
def test_numbers_of_other_kinds_become_plain_floats(kind):
    dragon = Dragon(benches=np.int64(7), width=kind(0.25), head_spacing=np.int32(3), body_spacing=2)
    assert dragon == Dragon(benches=7, width=0.25, head_spacing=3.0, body_spacing=2.0)
    assert type(dragon.benches) is int
    assert {type(getattr(dragon, name)) for name in LENGTHS} == {float}


def test_dragons_of_equal_sizes_are_equal_and_hash_alike():
    used = Dragon(benches=9)
    assert used.spacings.size == 9
    assert used == Dragon(benches=9)
    assert len({used, Dragon(benches=9), replace(used, benches=8)}) == 2


@given(st.lists(points, min_size=2, max_size=6))
def test_bench_lies_midway_between_its_holes_and_points_to_the_front_one(holes):
    handles = np.array(holes)
    for pose, front, rear in zip(bench_poses(handles), handles[:-1], handles[1:], strict=True):
        assert pose[:2] == pytest.approx((front + rear) / 2)
        reach = np.linalg.norm(front - rear)
        heading = np.array([math.cos(pose[2]), math.sin(pose[2])])
        assert rear + reach * heading == pytest.approx(front, abs=1e-12)


@given(st.lists(st.tuples(coordinates, coordinates, st.floats(-10, 10)), min_size=4, max_size=4))
def test_holes_are_a_spacing_apart_and_give_their_poses_back(poses):
    dragon = Dragon(benches=4)
    given_poses = np.array(poses)
    front, rear = dragon.holes(given_poses)
    assert np.linalg.norm(front - rear, axis=-1) == pytest.approx(dragon.spacings)
    for i in range(4):
        (back,) = bench_poses([front[i], rear[i]])
        assert back[:2] == pytest.approx(given_poses[i, :2])
        assert math.remainder(back[2] - given_poses[i, 2], 2 * math.pi) == pytest.approx(0, abs=1e-9)


def test_outline_of_a_bench_along_x_is_the_hand_drawn_one():
    corners = outlines([[10.0, 5.0, 0.0]], [4.0], 2.0)
    assert corners.tolist() == [[[8, 4], [12, 4], [12, 6], [8, 6]]]


def test_outline_of_a_bench_along_y_is_the_hand_drawn_one():
    corners = outlines([[10.0, 5.0, math.pi / 2]], [4.0], 2.0)
    assert corners[0] == pytest.approx(np.array([[11, 3], [11, 7], [9, 7], [9, 3]]))


@given(coordinates, coordinates, st.floats(-10, 10), st.floats(0.01, 50), st.floats(0.01, 50))
def test_outline_is_a_counter_clockwise_rectangle_about_the_centre(x, y, angle, length, width):
    (corners,) = outlines([[x, y, angle]], [length], width)
    sides = np.roll(corners, -1, axis=0) - corners
    tolerance = 1e-12 * (abs(x) + abs(y) + length + width)
    assert corners.mean(axis=0) == pytest.approx([x, y], abs=tolerance)
    assert np.linalg.norm(sides, axis=1) == pytest.approx([length, width, length, width], abs=tolerance)
    turns = sides[:, 0] * np.roll(sides[:, 1], -1) - sides[:, 1] * np.roll(sides[:, 0], -1)
    assert turns == pytest.approx(np.full(4, length * width), rel=1e-9, abs=10 * tolerance * max(length, width))
    assert sides[0] / length == pytest.approx([math.cos(angle), math.sin(angle)], abs=10 * tolerance / length)


def test_outlines_reach_an_overhang_beyond_the_holes():
    dragon = Dragon(benches=3)
    poses = bench_poses([[0, 0], [-2.86, 0], [-4.51, 0], [-6.16, 0]])
    corners = dragon.outlines(poses)
    assert corners.shape == (3, 4, 2)
    assert corners[..., 0].max(axis=1) == pytest.approx([0.275, -2.585, -4.235])
    assert corners[..., 0].min(axis=1) == pytest.approx([-3.135, -4.785, -6.435])
    assert np.abs(corners[..., 1]) == pytest.approx(np.full((3, 4), 0.15))


def test_outlines_of_many_times_are_those_of_each():
    dragon = Dragon(benches=3)
    poses = np.random.default_rng(1).normal(size=(2, 5, 3, 3))
    together = dragon.outlines(poses)
    assert together.shape == (2, 5, 3, 4, 2)
    assert np.array_equal(together[1, 2], dragon.outlines(poses[1, 2]))


@given(st.floats(-10, 10), st.floats(-3.1, 3.1), st.floats(0, 1))
def test_interpolated_pose_turns_the_shorter_way(angle, turn, share):
    before = np.array([1.0, 2.0, angle])
    after = np.array([3.0, -2.0, math.remainder(angle + turn, 2 * math.pi)])
    pose = interpolated(before, after, share)
    assert pose[:2] == pytest.approx([1 + 2 * share, 2 - 4 * share])
    assert math.remainder(pose[2] - angle - share * turn, 2 * math.pi) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    "error",
    [
        ParameterError("width", -1.0, "positive"),
        errors.UnreachableError(433.0, 1, "the curve bends"),
        errors.FileFormatError("run.npz", "damaged"),
        errors.OutputError("run.npz", "disk full"),
        errors.MissingExtraError("sweep", "sweep"),
        errors.DragonError("no luck"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_errors_pass_between_processes(error):
    back = pickle.loads(pickle.dumps(error))
    assert type(back) is type(error)
    assert str(back) == str(error)
    assert vars(back) == vars(error)
    assert isinstance(error, errors.DragonError)


def test_message_is_one_line_even_where_the_value_is_not():
    assert str(ParameterError("a\nb", "c\nd", "e\n  f")) == r"a b is 'c\nd', but must be e f"
