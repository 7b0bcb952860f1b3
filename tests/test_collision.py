"""Separations of rectangles against Shapely, edges against walks by hand, pairs by brute force."""

from itertools import combinations

import numpy as np
import pytest
import shapely
from conftest import NO_NUMBERS, assert_says, refusal
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon import Dragon, Grid, March, Spiral, separation

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
    add(
        scattered(rng, 400_000 // part, 5, sizes, sizes),
        scattered(rng, 400_000 // part, 5, sizes, sizes),
    )
    add(
        scattered(rng, 200_000 // part, 2, benches, [0.3]),
        scattered(rng, 200_000 // part, 2, benches, [0.3]),
    )
    for one, two in list(zip(first, second, strict=True)):
        one, two = one[: 75_000 // part], two[: 75_000 // part]
        found = separation(one, two)
        near = rng.choice(
            [0, *(sign * 10.0**k for sign in (-1, 1) for k in range(-15, -5))], len(one)
        )
        add(one, moved(two, (near - found.distance)[:, None] * found.normal))
    # Parallel, square to each other, and along the axes at whole numbers, where many touch and some
    # are the same.
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
    inner = rectangles(x + aside, y + ahead, rng.uniform(-4, 4, n), length / 20, width / 20)
    add(rectangles(x, y, angle, length, width), inner)
    across = angle + np.pi / 2 + rng.uniform(-0.5, 0.5, n)
    add(
        rectangles(x, y, angle, 3, width / 50),
        rectangles(x + aside, y + ahead, across, 3, length / 50),
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
    assert np.array_equal(
        found.distance[decided] <= 0, shapely_intersects(first[decided], second[decided])
    )
    assert np.abs(np.maximum(found.distance, 0) - truth).max() < UNDECIDED


def test_depth_along_the_normal_parts_two_and_no_shorter_step_in_any_direction_does(many):
    first, second, found = many
    deep = found.distance < -2 * UNDECIDED
    assert deep.mean() > 0.2
    one = first[deep]
    two = second[deep]
    depth = -found.distance[deep][:, None]
    normal = found.normal[deep]
    assert not shapely_intersects(one, moved(two, (depth + UNDECIDED) * normal)).any()
    assert shapely_intersects(one, moved(two, (depth - UNDECIDED) * normal)).all()
    some = np.flatnonzero(depth[:, 0] > 1e-6)[::10]
    assert some.size > 500
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    steps = (depth[some] - UNDECIDED)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    one = np.broadcast_to(one[some, None], (some.size, 180, 4, 2))
    assert shapely_intersects(one, moved(two[some, None], steps)).all()


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
SQUARE = box(0, 0, 1, 1)


def test_separations_are_those_found_by_hand():
    # An edge that faces a corner gives the edge's own normal; a corner inside an edge has its point
    # halfway in.
    for name, first, second, distance, normal, point in (
        ("corner to corner", SQUARE, box(2, 3, 4, 4), np.sqrt(5), (5**-0.5, 2 * 5**-0.5), (1.5, 2)),
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
    for second in (
        box(1, 0, 2, 1),
        box(1, 1, 2, 2),
        box(-1, -1, 0, 0),
        box(0.25, 1, 0.5, 3),
        box(-7, 1, 9, 2),
    ):
        assert separation(SQUARE, second).distance == 0


def test_leading_shapes_broadcast_and_many_pairs_are_as_one_by_one(many):
    row = np.stack([box(x, 0, x + 1, 1) for x in range(6)]).reshape(2, 3, 4, 2)
    found = separation(SQUARE, row)
    assert (
        found.distance.tolist()
        == separation(row, SQUARE).distance.tolist()
        == [[-1, 0, 1], [2, 3, 4]]
    )
    assert found.normal.shape == (2, 3, 2)
    assert found.point.shape == (2, 3, 2)
    assert separation(row[:, :1], row[:1]).distance.tolist() == [[-1, 0, 1], [2, 1, 0]]
    for none in (row[:0], row[0, :0]):
        assert separation(none, SQUARE).normal.shape == (*none.shape[:-2], 2)
    with pytest.raises(ValueError, match="read-only"):
        found.normal[0] = 0
    first, second, together = many
    for k in range(8000, 12000, 81):
        alone = separation(first[k], second[k])
        for name in ("distance", "normal", "point"):
            assert getattr(alone, name) == pytest.approx(getattr(together, name)[k], abs=1e-12)


def test_what_are_no_outlines_is_refused_by_name():
    shapes = [
        None,
        "box",
        1.0,
        [],
        SQUARE[:3],
        SQUARE.T,
        [[1, 2], [3]],
        1j * SQUARE,
        [[10**400, 0]] * 4,
    ]
    shapes.append([[[-(2**63), 0]] * 4] * 2)
    nowhere = []
    for corner, number in enumerate((np.nan, -np.inf, 1e10, -1e300)):
        nowhere.append(np.stack([SQUARE, SQUARE]))
        nowhere[-1][1, corner, 1] = number
    # Clockwise, or without an area.
    flat = [SQUARE[::-1], np.zeros((3, 4, 2)), box(0, 0, 1, 0), box(0, 0, 0, 1), box(2, 0, 1, 1)]
    for bad in (*shapes, *nowhere, *flat):
        assert refusal(separation, bad, SQUARE).name == "first"
        assert refusal(separation, SQUARE, bad).name == "second"
    assert_says(refusal(separation, [SQUARE] * 2, [SQUARE] * 3), "(3, 4, 2)", "(2, 4, 2)")
    for bad in (*shapes, *nowhere, SQUARE, [[SQUARE]]):
        for method in (Grid().file, Grid().pairs):
            assert refusal(method, bad).name == "outlines"


# Broad phase

# A grid whose lines are the whole numbers, x to the right and y downward from (0, 0).
UNIT = Grid(cell=1.0, origin=(0.0, 0.0))


def as_set(cells):
    found = {(int(i), int(j)) for i, j in cells}
    assert len(found) == len(cells), "a cell comes twice"
    return found


def pairs_with_neighbours(grid, outlines):
    """Pairs that share a cell. A far box between each two lets no two of them be neighbours."""
    far = np.broadcast_to(box(400, 400, 401, 401), np.shape(outlines))
    found = grid.pairs(np.stack([outlines, far], axis=1).reshape(-1, 4, 2))
    return as_set(found[(found % 2 == 0).all(axis=1)] // 2)


def touching_pairs(outlines, least=1):
    """Pairs that Shapely finds to touch, with numbers that differ by `least` or more."""
    polygons = shapely.polygons(outlines)
    one, two = shapely.STRtree(polygons).query(polygons, predicate="intersects")
    apart = two - one >= least
    return set(zip(one[apart].tolist(), two[apart].tolist(), strict=True))


def test_walks_and_shared_cells_are_those_found_by_hand():
    four = {(i, j) for i in (0, 1) for j in (0, 1)}
    for name, start, end, expected in (
        ("along a line: on both sides", (0.5, -1), (1.5, -1), four),
        ("along a line, downward", (2, -0.5), (2, -1.5), {(i, j) for i in (0, 1) for j in (1, 2)}),
        ("through a corner: all four cells", (0.5, -0.5), (1.5, -1.5), four),
        ("a point on a corner", (0, 0), (0, 0), {(i, j) for i in (-1, 0) for j in (-1, 0)}),
    ):
        assert as_set(UNIT.walk(start, end)) == expected, name
    assert UNIT.walk((3.25, -7.5), (3.75, -7.25)).tolist() == [[7, 3]]
    assert UNIT.walk((0.5, -0.4), (2.5, -1.4)).tolist() == [[0, 0], [0, 1], [1, 1], [1, 2]]
    assert UNIT.walk((2.5, -1.4), (0.5, -0.4)).tolist() == [[1, 2], [1, 1], [0, 1], [0, 0]]
    assert UNIT.walk((0.5, 2.5), (0.5, 0.5)).tolist() == [[-3, 0], [-2, 0], [-1, 0]]
    # Benches that touch or lie within each other share a cell.
    within = box(3.4, -2.6, 3.6, -2.4)
    assert UNIT.file([within])[0].tolist() == [[2, 3]]
    pairs = [(within, box(0.5, -6.5, 6.5, -0.5))]
    pairs += [
        (SQUARE, other)
        for other in (box(1, 0, 2, 1), box(0, 1, 1, 2), box(1, 1, 2, 2), box(-1, 1, 0, 2))
    ]
    for two in pairs:
        assert pairs_with_neighbours(UNIT, two) == {(0, 1)}


def test_paper_grid_starts_at_the_upper_left_and_counts_down_and_right(seed_march):
    grid = Grid.of(seed_march)
    assert grid == Grid() == Grid(cell=0.55, origin=(-8.8, 8.8))
    for point, cell in (
        ((-8.79, 8.79), [0, 0]),
        ((-8, 8.79), [0, 1]),
        ((-8.79, 8), [1, 0]),
        ((8.79, -8.79), [31, 31]),
    ):
        assert grid.walk(point, point).tolist() == [cell]
    # The dragon is larger than the paper's frame of 32 cells.
    outlines = seed_march.dragon.outlines(seed_march.at(0).poses[0])
    cells, _ = grid.file(outlines)
    assert touching_pairs(outlines, 2) <= as_set(grid.pairs(outlines))
    assert len(grid.pairs(outlines)) < 800
    assert (cells.min() < 0, cells.max() > 31) == (True, True)
    assert Grid.of(March(Dragon(), Spiral(pitch=1.5), turns=10)) == Grid(
        cell=1.5, origin=(-15.0, 15.0)
    )


def on_quarters(rng, n, spread, sizes):
    """Random outlines (n, 4, 2); a third lie along the axes, with corners on quarters of a cell."""
    x = rng.uniform(-spread, spread, n)
    y = rng.uniform(-spread, spread, n)
    angle = rng.uniform(-4, 4, n)
    length, width = np.maximum(rng.choice(sizes, (2, n)), 0.25)
    square = rng.random(n) < 1 / 3
    x, y, length, width = (
        np.where(square, np.round(4 * value) / 4, value) for value in (x, y, length, width)
    )
    x, y = (np.where(square, value + side / 2, value) for value, side in ((x, length), (y, width)))
    return rectangles(x, y, np.where(square, 0, angle), length, width)


# The smallest cell of large benches takes seconds.
@pytest.mark.parametrize("cell", [pytest.param(0.25, marks=pytest.mark.thorough), 0.55, 3.0, 100.0])
def test_no_pair_that_overlaps_or_touches_is_missed(cell):
    grid = Grid(cell=cell, origin=(-2.0, 3.0))
    for sizes in ([0.3, 2.2], [0.01, 0.1], [0.25, 0.5, 1, 2], [5, 10], [0.02, 20]):
        rng = np.random.default_rng(413)
        for spread in (3, 8):
            outlines = on_quarters(rng, 150, spread, sizes)
            truth = touching_pairs(outlines)
            assert truth
            assert truth <= pairs_with_neighbours(grid, outlines)


@given(st.integers(0, 2**32), st.integers(0, 30))
def test_pairs_are_those_that_share_a_cell_but_neighbours_each_once_in_order(seed, n):
    outlines = on_quarters(np.random.default_rng(seed), n, 3, [0.3, 0.55, 2.2])
    outlines.flags.writeable = False
    cells, benches = Grid().file(outlines)
    assert np.all(np.diff(benches) >= 0)
    filed = [as_set(cells[benches == bench]) for bench in range(n)]
    expected = [[i, j] for i, j in combinations(range(n), 2) if j - i > 1 and filed[i] & filed[j]]
    assert Grid().pairs(outlines).tolist() == expected


def test_impossible_cells_origins_and_points_are_refused_by_name():
    for value in (*NO_NUMBERS, 1e-4, 1001, 1e308):
        assert_says(refusal(lambda value=value: Grid(cell=value)), "cell is ", "0.001 to 1000 m")
    for value in (
        None,
        1.0,
        (),
        (1.0,),
        (1.0, 2.0, 3.0),
        (np.nan, 0),
        (0, np.inf),
        ("0", 0),
        (1e10, 0),
        (10**400, 0),
    ):
        assert refusal(lambda value=value: Grid(origin=value)).name == "origin"
    points = (
        None,
        1.0,
        "here",
        [1.0],
        [1, 2, 3],
        [[0, 0], [1, 1]],
        [1j, 0],
        (np.nan, 0),
        (0, -np.inf),
        (0, 1e6),
    )
    for bad in points:
        assert refusal(Grid().walk, bad, (0, 0)).name == "start"
        assert refusal(Grid().walk, (0, 0), bad).name == "end"


def test_cell_that_would_fill_the_memory_is_refused_before_it_does():
    large = [box(-90, -90, 90, 90)]
    assert_says(refusal(Grid(cell=0.001).file, large), "cell is 0.001", "20,000,000 entries")
    many = np.broadcast_to(SQUARE, (7000, 4, 2))
    assert_says(refusal(Grid(cell=1000.0).pairs, many), "cell is 1000", "20,000,000 entries")
