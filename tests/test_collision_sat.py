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


@pytest.fixture(scope="module", params=[20_000, pytest.param(1_000_000, marks=pytest.mark.thorough)])
def many(request):
    """Many pairs of all kinds, what we say of them, and their distances by Shapely."""
    part = 1_000_000 // request.param
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
    assert len(one) == request.param
    return one, two, separation(one, two), shapely_distance(one, two)


# Against Shapely


def test_pairs_get_the_verdict_that_shapely_gives(many):
    first, second, found, truth = many
    decided = np.abs(found.distance) > UNDECIDED
    assert decided.mean() > 0.85
    assert 0.2 < (truth > 0).mean() < 0.8
    assert np.array_equal(found.distance[decided] <= 0, shapely_intersects(first[decided], second[decided]))
    assert np.array_equal(overlap(first, second), found.distance <= 0)


def test_distances_are_shapelys(many):
    *_, found, truth = many
    assert np.abs(np.maximum(found.distance, 0) - truth).max() < UNDECIDED


def test_depth_along_the_normal_parts_them_and_a_nanometre_less_does_not(many):
    first, second, found, _ = many
    deep = found.distance < -2 * UNDECIDED
    assert deep.mean() > 0.2
    one, two, depth, normal = first[deep], second[deep], -found.distance[deep][:, None], found.normal[deep]
    assert not shapely_intersects(one, moved(two, (depth + UNDECIDED) * normal)).any()
    assert shapely_intersects(one, moved(two, (depth - UNDECIDED) * normal)).all()


def test_no_shorter_way_out_leads_in_any_direction(many):
    first, second, found, _ = many
    deep = np.flatnonzero(found.distance < -1e-6)[:: 6 if len(first) < 100_000 else 300]
    assert deep.size > 500
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    steps = (-found.distance[deep] - UNDECIDED)[:, None, None] * ways
    one = np.broadcast_to(first[deep, None], (deep.size, 180, 4, 2))
    assert shapely_intersects(one, moved(second[deep, None], steps)).all()


def test_normals_are_unit_vectors_and_bring_those_that_are_apart_together(many):
    first, second, found, _ = many
    assert np.abs(np.linalg.norm(found.normal, axis=-1) - 1).max() < 1e-15
    apart = np.flatnonzero(found.distance > UNDECIDED)[::4]
    step = -found.distance[apart][:, None] * found.normal[apart]
    assert shapely_distance(first[apart], moved(second[apart], step)).max() < UNDECIDED


def test_points_lie_midway_between_the_two_once_overlaps_are_halved(many):
    first, second, found, _ = many
    some = slice(None, None, 4)
    half = found.distance[some, None] * found.normal[some] / 2
    point = shapely.points(found.point[some])
    for outline, way in ((first[some], half), (second[some], -half)):
        touching = shapely.linearrings(moved(outline, way))
        assert shapely.distance(point, touching).max() < UNDECIDED


# By hand


def test_distance_from_corner_to_corner_is_more_than_any_gap_shows():
    first, second = box(0, 0, 1, 1), box(2, 3, 4, 4)
    assert axis_gaps(first, second).tolist() == [1, 2, 1, 2]
    found = separation(first, second)
    assert found.distance == pytest.approx(np.sqrt(5), rel=1e-15)
    assert found.normal == pytest.approx(np.array([1, 2]) / np.sqrt(5), rel=1e-15)
    assert found.point.tolist() == [1.5, 2]


def test_edge_that_faces_a_corner_gives_the_edges_own_normal():
    found = separation(box(-5, -1, 5, 0), rectangles(2, 2, np.pi / 4, np.sqrt(2), np.sqrt(2)))
    assert found.distance == pytest.approx(1, rel=1e-14)
    assert found.normal == pytest.approx([0, 1], abs=1e-15)
    assert found.point == pytest.approx([2, 0.5], rel=1e-14)


def test_corner_sunk_into_an_edge_has_its_point_halfway_in():
    found = separation(box(-5, -1, 5, 0), rectangles(2, 0.9, np.pi / 4, np.sqrt(2), np.sqrt(2)))
    assert found.distance == pytest.approx(-0.1, rel=1e-13)
    assert found.normal == pytest.approx([0, 1], abs=1e-15)
    assert found.point == pytest.approx([2, -0.05], rel=1e-13)


@pytest.mark.parametrize(
    "second", [box(1, 0, 2, 1), box(1, 1, 2, 2), box(-1, -1, 0, 0), box(0.25, 1, 0.5, 3), box(-7, 1, 9, 2)]
)
def test_touching_at_whole_numbers_is_exactly_zero(second):
    found = separation(box(0, 0, 1, 1), second)
    assert found.distance == 0
    assert overlap(box(0, 0, 1, 1), second)


def test_smallest_number_beside_an_edge_is_apart_and_has_a_normal():
    tiny = 5e-324
    found = separation(box(-1, -1, 0, 1), box(tiny, -1, 1, 1))
    assert found.distance >= 0
    assert found.normal.tolist() == [1, 0]


def test_identical_and_contained_rectangles_are_as_deep_as_their_shortest_way_out():
    assert separation(box(0, 0, 4, 1), box(0, 0, 4, 1)).distance == -1
    found = separation(box(0, 0, 10, 10), box(1, 4, 3, 6))
    assert (found.distance, found.normal.tolist()) == (-3, [-1, 0])


def test_crossing_bars_without_a_corner_in_each_other_overlap():
    assert separation(box(-5, -0.5, 5, 0.5), box(-0.5, -5, 0.5, 5)).distance == pytest.approx(-5.5)


def test_gaps_are_on_the_first_ones_length_and_width_and_then_the_second_ones():
    upright = box(0, 0, 4, 1)[[1, 2, 3, 0]]  # The same rectangle, with its length upward.
    assert axis_gaps(upright, box(6, 2, 7, 5)).tolist() == [1, 2, 2, 1]


def test_leading_shapes_broadcast():
    one, many = box(0, 0, 1, 1), np.stack([box(x, 0, x + 1, 1) for x in range(6)]).reshape(2, 3, 4, 2)
    found = separation(one, many)
    assert found.distance.tolist() == [[-1, 0, 1], [2, 3, 4]]
    assert (found.normal.shape, found.point.shape) == ((2, 3, 2), (2, 3, 2))
    assert separation(many, one).distance.tolist() == [[-1, 0, 1], [2, 3, 4]]
    assert separation(many[:, :1], many[:1]).distance.tolist() == [[-1, 0, 1], [2, 1, 0]]
    assert axis_gaps(one, many).shape == (2, 3, 4)
    assert overlap(one, many).tolist() == [[True, True, False], [False, False, False]]
    assert separation(many[:0], many[:0]).distance.shape == (0, 3)


def test_many_pairs_at_once_are_the_same_as_one_by_one(many):
    first, second, found, _ = many
    contests = range(4 * len(first) // 10, 6 * len(first) // 10, len(first) // 250 + 1)
    for k in contests:
        alone = separation(first[k], second[k])
        for name in ("distance", "normal", "point"):
            assert getattr(alone, name) == pytest.approx(getattr(found, name)[k], abs=1e-12)


def test_answer_cannot_be_changed_and_outlines_are_left_alone():
    first, second = box(0, 0, 1, 1), box(0.5, 0, 1.5, 1)
    found = separation(first, second)
    with pytest.raises(FrozenInstanceError):
        found.distance = 0
    with pytest.raises(ValueError, match="read-only"):
        found.normal[0] = 0
    assert np.array_equal(first, box(0, 0, 1, 1))
    assert np.array_equal(second, box(0.5, 0, 1.5, 1))


# Whatever the pair

coordinates = st.floats(-10, 10)
sides = st.floats(0.01, 10)
angles = st.floats(-7, 7)
any_rectangle = st.builds(rectangles, coordinates, coordinates, angles, sides, sides)


def one_way_out(first, second):
    """Whether no other way to part the two, or to bring them together, is as short as the one that is given."""
    found, gaps = separation(first, second), np.sort(axis_gaps(first, second))
    aside = (second - first).mean(axis=0) @ found.normal
    return found.distance > 1e-3 or (gaps[3] - gaps[2] > 1e-9 and aside > 1e-9)


@given(any_rectangle, any_rectangle)
def test_swapping_the_two_keeps_the_distance_and_flips_the_normal(first, second):
    found, back = separation(first, second), separation(second, first)
    assert back.distance == pytest.approx(found.distance, abs=1e-13)
    assume(one_way_out(first, second))
    assert back.normal == pytest.approx(-found.normal, abs=1e-9)


@given(any_rectangle, any_rectangle, coordinates, coordinates, angles)
def test_moving_both_moves_the_answer_with_them(first, second, x, y, angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    found, there = separation(first, second), separation(first @ turn + [x, y], second @ turn + [x, y])
    assert there.distance == pytest.approx(found.distance, abs=1e-12)
    assume(one_way_out(first, second))
    assert there.normal == pytest.approx(found.normal @ turn, abs=1e-9)


@given(any_rectangle, any_rectangle)
def test_widest_gap_is_never_more_than_the_distance_and_is_the_depth(first, second):
    gap, distance = axis_gaps(first, second).max(), separation(first, second).distance
    assert gap <= distance
    assert distance > 0 or gap == distance


# Bad input

SQUARE = box(0, 0, 1, 1)


@pytest.mark.parametrize("function", [separation, overlap, axis_gaps])
@pytest.mark.parametrize(
    "bad",
    [None, "box", 1.0, [], SQUARE[:3], SQUARE.T, [[1, 2], [3]], np.zeros((4, 3)), 1j * SQUARE, [[10**400, 0]] * 4],
    ids=lambda bad: f"{type(bad).__name__} {np.size(bad) if not isinstance(bad, list) else len(bad)}",
)
def test_what_is_no_outline_is_refused_by_name(function, bad):
    for name, pair in (("first", (bad, SQUARE)), ("second", (SQUARE, bad))):
        with pytest.raises(ParameterError) as caught:
            function(*pair)
        assert caught.value.name == name
        assert_says(caught.value, f"{name} is ", "(..., 4, 2) in m")


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e10, -1e300])
def test_corner_that_is_nowhere_is_refused(number):
    for corner in range(4):
        bad = np.stack([SQUARE, SQUARE])
        bad[1, corner, 1] = number
        with pytest.raises(ParameterError) as caught:
            separation(SQUARE, bad)
        assert_says(caught.value, f"second is {number!r}", "finite and within 1e+09 m")


@pytest.mark.parametrize("bad", [SQUARE[::-1], np.zeros((4, 2)), box(0, 0, 1, 0), box(0, 0, 0, 1), box(2, 0, 1, 1)])
def test_outline_that_is_clockwise_or_has_no_area_is_refused(bad):
    for name, pair in (("first", (bad, SQUARE)), ("second", (SQUARE, bad))):
        with pytest.raises(ParameterError) as caught:
            separation(*pair)
        assert_says(caught.value, f"{name} is [", "rectangles with an area, counter-clockwise")


def test_shapes_that_do_not_broadcast_are_refused():
    with pytest.raises(ParameterError) as caught:
        separation([SQUARE] * 2, [SQUARE] * 3)
    assert_says(caught.value, "second is 'of shape (3, 4, 2)'", "goes with (2, 4, 2)")


def test_separations_are_equal_where_their_numbers_are_and_show_themselves_in_a_line():
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    apart = corners + np.array([[[2, 0]], [[3, 0]]])
    found = separation(corners, apart)
    assert found == separation(corners, apart)
    assert hash(found) == hash(separation(corners, apart))
    assert found != separation(corners, apart[::-1])
    assert found != separation(corners, apart[0])
    assert repr(found) == "Separation(2 pairs, distance from 1 m to 2 m)"
    assert repr(separation(corners, apart[0])) == "Separation(1 pairs, distance from 1 m to 1 m)"
    assert repr(separation(np.empty((0, 4, 2)), corners)) == "Separation(0 pairs)"
