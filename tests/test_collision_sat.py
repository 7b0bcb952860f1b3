"""Narrow phase: the separating axis theorem and the distance of two rectangles, held against Shapely."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
import shapely
from conftest import assert_says
from hypothesis import assume, given
from hypothesis import strategies as st

from pymunk_dragon.collision.sat import axis_gaps, overlap, separation
from pymunk_dragon.errors import ParameterError

# m. Closer to touching than this Shapely's own rounding decides, and nothing is asked.
UNDECIDED = 1e-9


def rectangles(x, y, angle, length, width):
    """Outlines (..., 4, 2), made without the package."""
    centre, turn = np.asarray(x) + 1j * np.asarray(y), np.exp(1j * np.asarray(angle))
    corners = [
        centre + turn * (ahead * np.asarray(length) + 1j * left * np.asarray(width)) / 2
        for ahead, left in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    stacked = np.stack(corners, axis=-1)
    return np.stack([stacked.real, stacked.imag], axis=-1)


def box(left, bottom, right, top):
    return np.array([(left, bottom), (right, bottom), (right, top), (left, top)], dtype=float)


def scattered(rng, n, spread, lengths, widths):
    x, y = rng.uniform(-spread, spread, (2, n))
    return rectangles(x, y, rng.uniform(-4, 4, n), rng.choice(lengths, n), rng.choice(widths, n))


def moved(outlines, steps):
    return outlines + np.asarray(steps)[..., None, :]


def shapely_distance(first, second):
    return shapely.distance(shapely.polygons(first), shapely.polygons(second))


def shapely_intersects(first, second):
    # Unlike its distance, which is 1e-16 for some that overlap, this comes from exact predicates.
    return shapely.intersects(shapely.polygons(first), shapely.polygons(second))


def pairs_of_all_kinds(count):
    """Two arrays of `count` outlines."""
    part = 1_000_000 // count
    rng = np.random.default_rng(20240905)
    sizes, benches = 10 ** rng.uniform(-2, 1, 5000), [2.20, 3.41]
    first, second = [], []

    def add(one, two):
        first.append(one)
        second.append(two)

    # Of very different sizes and shapes; the contest's benches; both moved until they nearly touch.
    add(scattered(rng, 400_000 // part, 5, sizes, sizes), scattered(rng, 400_000 // part, 5, sizes, sizes))
    add(scattered(rng, 200_000 // part, 2, benches, [0.3]), scattered(rng, 200_000 // part, 2, benches, [0.3]))
    for one, two in list(zip(first, second, strict=True)):
        one, two = one[: 75_000 // part], two[: 75_000 // part]
        found = separation(one, two)
        near = rng.choice([0, *(sign * 10.0**k for sign in (-1, 1) for k in range(-15, -5))], len(one))
        add(one, moved(two, (near - found.distance)[:, None] * found.normal))
    # Parallel, square to each other, and along the axes at whole numbers, where many touch and some are the same.
    n = 50_000 // part
    for quarter in (rng.uniform(-4, 4, n), np.zeros(n)):
        x, y, length, width = rng.integers(-3, 4, (4, 2, n)) * 1.0
        turned = quarter + rng.integers(0, 4, (2, n)) * np.pi / 2
        add(*rectangles(x, y, turned, 1 + np.abs(length), 1 + np.abs(width)))
    # The second inside the first; and bars that cross with no corner of either inside the other.
    n = 75_000 // part
    x, y, angle = rng.uniform(-4, 4, (3, n))
    length, width = rng.uniform(1, 5, (2, n))
    aside, ahead = rng.uniform(-0.2, 0.2, (2, n))
    add(
        rectangles(x, y, angle, length, width),
        rectangles(x + aside, y + ahead, rng.uniform(-4, 4, n), length / 20, width / 20),
    )
    add(
        rectangles(x, y, angle, 3, width / 50),
        rectangles(x + aside, y + ahead, angle + np.pi / 2 + rng.uniform(-0.5, 0.5, n), 3, length / 50),
    )
    one, two = np.concatenate(first), np.concatenate(second)
    assert len(one) == count
    return one, two


@pytest.fixture(scope="module")
def many():
    first, second = pairs_of_all_kinds(20_000)
    return first, second, separation(first, second)


@pytest.mark.parametrize("count", [20_000, pytest.param(1_000_000, marks=pytest.mark.thorough)])
def test_verdicts_and_distances_are_those_of_shapely(count):
    first, second = pairs_of_all_kinds(count)
    found, truth = separation(first, second), shapely_distance(first, second)
    decided = np.abs(found.distance) > UNDECIDED
    assert decided.mean() > 0.85
    assert 0.2 < (truth > 0).mean() < 0.8
    assert np.array_equal(found.distance[decided] <= 0, shapely_intersects(first[decided], second[decided]))
    assert np.array_equal(overlap(first, second), found.distance <= 0)
    assert np.abs(np.maximum(found.distance, 0) - truth).max() < UNDECIDED


def test_depth_along_the_normal_parts_them_and_a_nanometre_less_does_not(many):
    first, second, found = many
    deep = found.distance < -2 * UNDECIDED
    assert deep.mean() > 0.2
    one, two, depth, normal = first[deep], second[deep], -found.distance[deep][:, None], found.normal[deep]
    assert not shapely_intersects(one, moved(two, (depth + UNDECIDED) * normal)).any()
    assert shapely_intersects(one, moved(two, (depth - UNDECIDED) * normal)).all()


def test_no_shorter_way_out_leads_in_any_direction(many):
    first, second, found = many
    deep = np.flatnonzero(found.distance < -1e-6)[::10]
    assert deep.size > 500
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    steps = (-found.distance[deep] - UNDECIDED)[:, None, None] * ways
    one = np.broadcast_to(first[deep, None], (deep.size, 180, 4, 2))
    assert shapely_intersects(one, moved(second[deep, None], steps)).all()


def test_normals_and_points_are_where_the_two_are_closest_or_would_touch(many):
    first, second, found = many
    assert np.abs(np.linalg.norm(found.normal, axis=-1) - 1).max() < 1e-15
    apart = np.flatnonzero(found.distance > UNDECIDED)[::4]
    step = -found.distance[apart][:, None] * found.normal[apart]
    assert shapely_distance(first[apart], moved(second[apart], step)).max() < UNDECIDED
    # Points lie midway between the two, or where both touch once each has moved by half the depth.
    some = slice(None, None, 4)
    half = found.distance[some, None] * found.normal[some] / 2
    for outline, way in ((first[some], half), (second[some], -half)):
        touching = shapely.linearrings(moved(outline, way))
        assert shapely.distance(shapely.points(found.point[some]), touching).max() < UNDECIDED


# Square to its diagonal, a corner downward.
RHOMB = (np.pi / 4, np.sqrt(2), np.sqrt(2))
UNIT = box(0, 0, 1, 1)


def test_separations_are_those_found_by_hand():
    # An edge that faces a corner gives the edge's own normal; a corner inside an edge has its point halfway in.
    for name, first, second, distance, normal, point in (
        ("corner to corner", UNIT, box(2, 3, 4, 4), np.sqrt(5), (5**-0.5, 2 * 5**-0.5), (1.5, 2)),
        ("edge to corner", box(-5, -1, 5, 0), rectangles(2, 2, *RHOMB), 1, (0, 1), (2, 0.5)),
        ("corner in edge", box(-5, -1, 5, 0), rectangles(2, 0.9, *RHOMB), -0.1, (0, 1), (2, -0.05)),
        ("inside", box(0, 0, 10, 10), box(1, 4, 3, 6), -3, (-1, 0), None),
        ("the same", box(0, 0, 4, 1), box(0, 0, 4, 1), -1, None, None),
        ("crossing", box(-5, -0.5, 5, 0.5), box(-0.5, -5, 0.5, 5), -5.5, None, None),
        ("a smallest number apart", box(-1, -1, 0, 1), box(5e-324, -1, 1, 1), 0, (1, 0), None),
    ):
        found = separation(first, second)
        assert found.distance == pytest.approx(distance, rel=1e-13, abs=1e-300), name
        assert normal is None or found.normal == pytest.approx(normal, abs=1e-15), name
        assert point is None or found.point == pytest.approx(point, rel=1e-13), name
    for second in (box(1, 0, 2, 1), box(1, 1, 2, 2), box(-1, -1, 0, 0), box(0.25, 1, 0.5, 3), box(-7, 1, 9, 2)):
        assert separation(UNIT, second).distance == 0
        assert overlap(UNIT, second)


def test_gaps_are_on_the_first_ones_length_and_width_and_then_the_second_ones():
    assert axis_gaps(UNIT, box(2, 3, 4, 4)).tolist() == [1, 2, 1, 2]
    upright = box(0, 0, 4, 1)[[1, 2, 3, 0]]  # The same rectangle, with its length upward.
    assert axis_gaps(upright, box(6, 2, 7, 5)).tolist() == [1, 2, 2, 1]


def test_leading_shapes_broadcast_and_many_pairs_are_as_one_by_one(many):
    row = np.stack([box(x, 0, x + 1, 1) for x in range(6)]).reshape(2, 3, 4, 2)
    found = separation(UNIT, row)
    assert found.distance.tolist() == separation(row, UNIT).distance.tolist() == [[-1, 0, 1], [2, 3, 4]]
    assert (found.normal.shape, found.point.shape) == ((2, 3, 2), (2, 3, 2))
    assert separation(row[:, :1], row[:1]).distance.tolist() == [[-1, 0, 1], [2, 1, 0]]
    assert axis_gaps(UNIT, row).shape == (2, 3, 4)
    assert overlap(UNIT, row).tolist() == [[True, True, False], [False, False, False]]
    assert separation(row[:0], row[:0]).distance.shape == (0, 3)
    first, second, together = many
    for k in range(8000, 12000, 81):
        alone = separation(first[k], second[k])
        for name in ("distance", "normal", "point"):
            assert getattr(alone, name) == pytest.approx(getattr(together, name)[k], abs=1e-12)


def test_answer_is_a_value_that_cannot_be_changed():
    pair = np.stack([box(3, 0, 4, 1), box(2, 0, 3, 1)])
    found = separation(UNIT, pair)
    with pytest.raises(FrozenInstanceError):
        found.distance = 0
    with pytest.raises(ValueError, match="read-only"):
        found.normal[0] = 0
    assert found == separation(UNIT, pair)
    assert hash(found) == hash(separation(UNIT, pair))
    assert found != separation(UNIT, pair[::-1])
    assert "2 pairs" in repr(found)
    assert "0 pairs" in repr(separation(np.empty((0, 4, 2)), UNIT))


coordinates = st.floats(-10, 10)
sides = st.floats(0.01, 10)
angles = st.floats(-7, 7)
any_rectangle = st.builds(rectangles, coordinates, coordinates, angles, sides, sides)


@given(any_rectangle, any_rectangle, coordinates, coordinates, angles)
def test_swapping_or_moving_the_two_turns_the_answer_with_them(first, second, x, y, angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    found, back = separation(first, second), separation(second, first)
    there = separation(first @ turn + [x, y], second @ turn + [x, y])
    assert back.distance == pytest.approx(found.distance, abs=1e-13)
    assert there.distance == pytest.approx(found.distance, abs=1e-12)
    gaps = np.sort(axis_gaps(first, second))
    assert gaps[3] <= found.distance
    assert found.distance > 0 or gaps[3] == found.distance
    # Where another way to part the two is as short, either may be given.
    aside = (second - first).mean(axis=0) @ found.normal
    assume(found.distance > 1e-3 or (gaps[3] - gaps[2] > 1e-9 and aside > 1e-9))
    assert back.normal == pytest.approx(-found.normal, abs=1e-9)
    assert there.normal == pytest.approx(found.normal @ turn, abs=1e-9)


def test_bad_outlines_are_refused_by_name():
    shapes = [None, "box", 1.0, [], UNIT[:3], UNIT.T, [[1, 2], [3]], np.zeros((4, 3)), 1j * UNIT, [[10**400, 0]] * 4]
    nowhere = []
    for corner, number in enumerate((np.nan, -np.inf, 1e10, -1e300)):
        nowhere.append(np.stack([UNIT, UNIT]))
        nowhere[-1][1, corner, 1] = number
    # Clockwise, or without an area.
    flat = [UNIT[::-1], np.zeros((4, 2)), box(0, 0, 1, 0), box(0, 0, 0, 1), box(2, 0, 1, 1)]
    for function in (separation, overlap, axis_gaps):
        for bad in (*shapes, *nowhere, *flat):
            for name, pair in (("first", (bad, UNIT)), ("second", (UNIT, bad))):
                with pytest.raises(ParameterError) as caught:
                    function(*pair)
                assert caught.value.name == name
                assert_says(caught.value, f"{name} is ")
    with pytest.raises(ParameterError) as caught:
        separation([UNIT] * 2, [UNIT] * 3)
    assert_says(caught.value, "(3, 4, 2)", "(2, 4, 2)")
