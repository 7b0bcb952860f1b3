"""Benches, holes, poses and outlines."""

import math
import pickle
from dataclasses import FrozenInstanceError, replace
from fractions import Fraction

import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says, refusal
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon import Dragon, ParameterError, errors, outlines
from pymunk_dragon.model.dragon import bench_poses

LENGTHS = ("head_spacing", "body_spacing", "overhang", "width")
TRACTOR = {
    "head_spacing": 3.0,
    "body_spacing": [4.0, 2.5, 6],
    "overhang": [0.5, 0.3, 0.8, 1],
    "width": [2, 1.5, 2.2, 1.8],
}
coordinates = st.floats(-100, 100)
points = st.tuples(coordinates, coordinates)


def test_default_dragon_is_the_contests_and_cannot_be_changed():
    dragon = Dragon()
    assert (dragon.benches, dragon.handles, dragon.width) == (223, 224, 0.30)
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
    for value in [*(value for value in NO_NUMBERS if value is not None), 1, 10_001, 10**5000, 223.0, 2.5]:
        assert refusal(Dragon, benches=value).name == "benches"
    for overhang in (0.825, 0.9, 50.0):
        assert_says(refusal(Dragon, overhang=overhang), "overhang is ", "0.825 m")
    for name, *cases in (
        ("width", {"benches": 223, "width": [0.3, 0.3]}, {"width": [0.3]}, {"width": [0.3] * 10_001}, {"width": "0.3"}),
        ("overhang", {"body_spacing": [1.65] * 3, "overhang": [0.2] * 3}),
        ("body_spacing", {"body_spacing": []}),
        ("head_spacing", {"head_spacing": [2.86, 1.65]}),
        ("width[1]", {"width": [0.3, -1, 0.3]}, {"width": [0.3, [0.3], 0.3]}),
        ("overhang beside bench 2", {"overhang": [0.1, 0.5, 0.2, 0.5], "body_spacing": [1.0, 1.0, 1.0]}),
    ):
        for sizes in cases:
            assert_says(refusal(Dragon, **sizes), f"{name} is ")


def test_benches_may_differ():
    dragon = Dragon(**TRACTOR)
    assert dragon.spacings.tolist() == [3.0, 4.0, 2.5, 6.0]
    assert dragon.lengths.tolist() == pytest.approx([4.0, 4.6, 4.1, 8.0])
    assert dragon.widths.tolist() == TRACTOR["width"]
    for sizes in ({}, {"width": [0.5, 0.3, 0.3]}, {"overhang": [0.1, 0.2, 0.2], "body_spacing": [1.65, 1.65]}):
        assert Dragon(**sizes).alike
    for sizes in ({"width": [0.3, 0.3, 0.4]}, {"overhang": [0.275, 0.275, 0.2]}, {"body_spacing": [1.65, 1.7]}):
        assert not Dragon(**sizes).alike


def test_dragons_of_the_same_sizes_are_equal_whatever_kind_of_numbers_they_are_given():
    dragon = Dragon(**TRACTOR)
    same = Dragon(benches=4, head_spacing=3, **{name: np.array(TRACTOR[name]) for name in LENGTHS[1:]})
    assert pickle.loads(pickle.dumps(dragon)) == dragon == same
    assert len({dragon, same, Dragon(benches=9), Dragon(benches=9), replace(Dragon(benches=9), benches=8)}) == 3
    assert {type(size) for name in LENGTHS[1:] for size in getattr(same, name)} == {float}
    for kind in (np.float64, np.float32, np.float16, Fraction):
        dragon = Dragon(benches=np.int64(7), width=kind(0.25), head_spacing=np.int32(3), body_spacing=2)
        assert dragon == Dragon(benches=7, width=0.25, head_spacing=3.0, body_spacing=2.0)
        assert [type(getattr(dragon, name)) for name in ("benches", *LENGTHS)] == [int] + [float] * 4


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
    assert np.linalg.norm(sides, axis=1) == pytest.approx([length, width, length, width], abs=tolerance)
    turns = sides[:, 0] * np.roll(sides[:, 1], -1) - sides[:, 1] * np.roll(sides[:, 0], -1)
    assert turns == pytest.approx(np.full(4, length * width), rel=1e-9, abs=10 * tolerance * max(length, width))
    assert sides[0] / length == pytest.approx([math.cos(angle), math.sin(angle)], abs=10 * tolerance / length)


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
    others = errors.FileFormatError("run.npz", "damaged"), errors.OutputError("run.npz", "disk full")
    others += errors.UnreachableError(433.0, 1, "the curve bends"), errors.MissingExtraError("sweep", "sweep")
    for error in (ParameterError("width", -1.0, "positive"), errors.DragonError("no luck"), *others):
        back = pickle.loads(pickle.dumps(error))
        assert (type(back), str(back), vars(back)) == (type(error), str(error), vars(error))
        assert isinstance(error, errors.DragonError)
    assert str(ParameterError("a\nb", "c\nd", "e\n  f")) == r"a b is 'c\nd', but must be e f"
