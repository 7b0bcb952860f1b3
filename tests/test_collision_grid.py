"""Broad phase: the walk of an edge held against fractions, and the pairs against Shapely's brute force."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np
import pytest
import shapely
from conftest import NO_NUMBERS, assert_says, examples
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon.collision import grid as module
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March

# A grid whose lines are the whole numbers, x to the right and y downward from (0, 0).
UNIT = Grid(cell=1.0, origin=(0.0, 0.0))


def as_set(cells):
    found = {(int(i), int(j)) for i, j in cells}
    assert len(found) == len(cells), "a cell comes twice"
    return found


def unit_box(left, top, right, bottom):
    """A rectangle of the unit grid, whose rows count downward."""
    return [(left, -bottom), (right, -bottom), (right, -top), (left, -top)]


BOX = unit_box(0, 0, 1, 1)


# The oracle: fractions, without any rounding


def touches(start, end, i, j, grid, margin):
    """Whether the edge meets the closed cell (i, j), widened by `margin` cells on every side."""
    cell, (x0, y0) = Fraction(grid.cell), map(Fraction, grid.origin)
    enter, leave = Fraction(0), Fraction(1)
    for a, b, low in (
        ((Fraction(start[0]) - x0) / cell, (Fraction(end[0]) - x0) / cell, j),
        ((y0 - Fraction(start[1])) / cell, (y0 - Fraction(end[1])) / cell, i),
    ):
        near, far = low - margin, low + 1 + margin
        if a == b:
            if not near <= a <= far:
                return False
            continue
        one, two = sorted(((near - a) / (b - a), (far - a) / (b - a)))
        enter, leave = max(enter, one), min(leave, two)
    return enter <= leave


def touched(start, end, grid, margin=Fraction(0)):
    """Every cell that the edge meets."""
    x, y = (np.array([start[k], end[k]]) for k in (0, 1))
    columns = np.floor((x - grid.origin[0]) / grid.cell).astype(int)
    rows = np.floor((grid.origin[1] - y) / grid.cell).astype(int)
    return {
        (i, j)
        for i in range(rows.min() - 2, rows.max() + 3)
        for j in range(columns.min() - 2, columns.max() + 3)
        if touches(start, end, i, j, grid, margin)
    }


cells = st.sampled_from([0.55, 0.1, 1.0, 0.25, 1 / 3, 1.7])
grids = st.builds(
    lambda cell, x, y: Grid(cell=cell, origin=(x, y)), cells, st.floats(-10, 10), st.sampled_from([8.8, 0.0, 1.1])
)


@st.composite
def edges(draw):
    """Edges of a few cells anywhere, often on lines and corners of the grid, or within a hair of them."""
    grid = draw(grids)
    hairs = st.sampled_from([0.0, 1e-16, -1e-16, 3e-15, -1e-14, 1e-9, -1e-7])
    places = st.one_of(st.floats(-6, 6), st.integers(-6, 6), st.integers(-24, 24).map(lambda n: n / 4))
    offset = draw(st.sampled_from([0, 0, 1000, -5000]))

    def point():
        u, v = (offset + draw(places) + draw(hairs) for _ in "uv")
        return grid.origin[0] + u * grid.cell, grid.origin[1] - v * grid.cell

    return grid, point(), point()


@examples(300)
@given(edges())
def test_walk_misses_no_cell_that_the_exact_edge_touches_and_adds_none_but_by_a_hair(example):
    grid, start, end = example
    walked = grid.walk(start, end)
    found = as_set(walked)
    assert found >= touched(start, end, grid)
    assert found <= touched(start, end, grid, Fraction(3 * module.SLACK))
    # From start to end, column by column.
    across, down = np.sign(end[0] - start[0]), -np.sign(end[1] - start[1])
    assert np.all(np.diff(walked[:, 1]) * (across or 1) >= 0)
    for (i, j), (next_i, next_j) in pairwise(walked.tolist()):
        assert next_j != j or next_i - i == (down or 1)


# By hand


def test_walks_are_those_found_by_hand():
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


def test_paper_grid_starts_at_the_upper_left_and_counts_down_and_right(seed_march):
    grid = Grid.of(seed_march)
    assert grid == Grid() == Grid(cell=0.55, origin=(-8.8, 8.8))
    assert grid.cell_of([-8.79, 8.79]).tolist() == [0, 0]
    assert grid.cell_of([[-8.0, 8.79], [-8.79, 8.0], [-8.8, 8.8]]).tolist() == [[0, 1], [1, 0], [0, 0]]
    assert grid.cell_of([8.79, -8.79]).tolist() == [31, 31]
    # The dragon is larger than the paper's frame of 32 cells.
    cells, _ = grid.file(seed_march.dragon.outlines(seed_march.at(0).poses[0]))
    assert cells.min() < 0
    assert cells.max() > 31
    assert Grid.of(March(Dragon(), Spiral(pitch=1.5), turns=10)) == Grid(cell=1.5, origin=(-15.0, 15.0))


# Filing


def rectangles(rng, n, spread, sizes):
    """Outlines (n, 4, 2) at random, a third of them along the axes with corners on quarters of a cell."""
    x, y, angle = rng.uniform(-spread, spread, n), rng.uniform(-spread, spread, n), rng.uniform(-4, 4, n)
    length, width = rng.choice(sizes, (2, n))
    square = rng.random(n) < 1 / 3
    x, y, length, width = (np.where(square, np.round(4 * value) / 4, value) for value in (x, y, length, width))
    length, width = np.maximum(length, 0.25), np.maximum(width, 0.25)
    x, y = (np.where(square, value + side / 2, value) for value, side in ((x, length), (y, width)))
    turn = np.where(square, 1, np.exp(1j * angle))
    corners = [
        x + 1j * y + turn * (ahead * length + 1j * left * width) / 2
        for ahead, left in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    stacked = np.stack(corners, axis=-1)
    return np.stack([stacked.real, stacked.imag], axis=-1)


def filed(grid, outlines):
    cells, benches = grid.file(outlines)
    assert np.all(np.diff(benches) >= 0)
    return [as_set(cells[benches == bench]) for bench in range(len(outlines))]


def test_benches_that_touch_or_lie_within_each_other_share_a_cell():
    small, large = unit_box(3.4, 2.4, 3.6, 2.6), unit_box(0.5, 0.5, 6.5, 6.5)
    assert filed(UNIT, np.array([small])) == [{(2, 3)}]
    assert UNIT.pairs([small, large], neighbours=0).tolist() == [[0, 1]]
    for two in (unit_box(1, 0, 2, 1), unit_box(0, 1, 1, 2), unit_box(1, 1, 2, 2), unit_box(-1, 1, 0, 2)):
        assert UNIT.pairs([BOX, two], neighbours=0).tolist() == [[0, 1]]


# Pairs against brute force


def touching_pairs(outlines, neighbours):
    polygons = shapely.polygons(outlines)
    one, two = shapely.STRtree(polygons).query(polygons, predicate="intersects")
    far = two - one > neighbours
    return set(zip(one[far].tolist(), two[far].tolist(), strict=True))


# The smallest cell of large benches takes seconds.
@pytest.mark.parametrize("cell", [pytest.param(0.25, marks=pytest.mark.thorough), 0.55, 3.0, 100.0])
def test_no_pair_that_overlaps_or_touches_is_missed(cell):
    grid = Grid(cell=cell, origin=(-2.0, 3.0))
    for sizes in ([0.3, 2.2], [0.01, 0.1], [0.25, 0.5, 1, 2], [5, 10], [0.02, 20]):
        rng = np.random.default_rng(413)
        for spread in (3, 8):
            outlines = rectangles(rng, 150, spread, sizes)
            truth = touching_pairs(outlines, 0)
            assert truth
            assert truth <= as_set(grid.pairs(outlines, neighbours=0))


@examples(200)
@given(st.lists(st.tuples(*[st.integers(-4, 4)] * 2, *[st.integers(1, 6)] * 2), min_size=2, max_size=8))
def test_no_pair_on_whole_numbers_is_missed_upright_or_slanted(boxes):
    upright = np.array([unit_box(x, y, x + length, y + width) for x, y, length, width in boxes], dtype=float)
    slanted = np.stack([upright[..., 0] - upright[..., 1], upright[..., 0] + upright[..., 1]], axis=-1)
    for outlines in (upright, slanted):
        for grid in (UNIT, Grid(cell=2.0, origin=(1.0, -1.0))):
            assert touching_pairs(outlines, 0) <= as_set(grid.pairs(outlines, neighbours=0))


@given(st.integers(0, 2**32), st.integers(1, 30), st.integers(0, 4))
def test_pairs_are_those_that_share_a_cell_each_once_in_order(seed, n, neighbours):
    outlines = rectangles(np.random.default_rng(seed), n, 3, [0.3, 0.55, 2.2])
    grid = Grid()
    found = grid.pairs(outlines, neighbours=neighbours).tolist()
    cells = filed(grid, outlines)
    expected = [[i, j] for i, j in combinations(range(n), 2) if j - i > neighbours and cells[i] & cells[j]]
    assert found == expected


def test_seed_march_misses_no_pair_at_any_time(seed_march):
    grid = Grid.of(seed_march)
    overlapping = 0
    for poses in seed_march.at(np.linspace(-10, 432.9, 40)).poses:
        outlines = seed_march.dragon.outlines(poses)
        truth, found = touching_pairs(outlines, 1), as_set(grid.pairs(outlines))
        assert truth <= found
        assert len(found) < 800
        overlapping += len(truth)
    assert overlapping > 0


def test_neighbours_are_left_out_and_come_back_when_asked_for(seed_march):
    outlines = seed_march.dragon.outlines(seed_march.at(0).poses[0])
    without, with_them = as_set(Grid().pairs(outlines)), as_set(Grid().pairs(outlines, neighbours=0))
    assert with_them - without == {(i, i + 1) for i in range(222)}


def test_far_from_the_origin_nothing_is_missed():
    rng = np.random.default_rng(2)
    outlines = rectangles(rng, 200, 3, [0.3, 2.2]) + np.array([0.54e6, -0.54e6])
    assert touching_pairs(outlines, 0) <= as_set(Grid().pairs(outlines, neighbours=0))


def test_few_benches_have_no_pairs_and_outlines_are_left_alone():
    assert Grid().pairs(np.empty((0, 4, 2))).shape == Grid().pairs([BOX]).shape == (0, 2)
    outlines = np.array([BOX, unit_box(0.5, 0, 2, 1)], dtype=float)
    outlines.flags.writeable = False
    UNIT.pairs(outlines)


# Bad input


def assert_refused(call, *words):
    with pytest.raises(ParameterError) as caught:
        call()
    assert_says(caught.value, *words)


def test_impossible_cells_origins_and_neighbours_are_refused_by_name():
    for value in (*NO_NUMBERS, 1e-4, 1001, 1e308):
        assert_refused(lambda value=value: Grid(cell=value), "cell is ", "0.001 to 1000 m")
    origins = [None, 1.0, (), (1.0,), (1.0, 2.0, 3.0), [0.0, 0.0], (np.nan, 0), (0, np.inf), ("0", 0), (1e10, 0)]
    for value in origins:
        assert_refused(lambda value=value: Grid(origin=value), "origin is ")
    for value in (-1, 1.0, True, None, "1", 10**9):
        assert_refused(lambda value=value: Grid().pairs([BOX], neighbours=value), "neighbours is ")


def test_what_are_no_outlines_or_points_is_refused():
    outlines = [None, "box", 1.0, [], BOX, [[BOX]], [BOX[:3]], [[1, 2], [3]], 1j * np.array([BOX])]
    for method in (Grid().file, Grid().pairs):
        for bad in outlines:
            assert_refused(lambda method=method, bad=bad: method(bad), "outlines is ")
    for bad in (None, 1.0, "here", [1.0], [1, 2, 3], [[0, 0], [1, 1]], [1j, 0]):
        assert_refused(lambda bad=bad: Grid().walk(bad, (0, 0)), "start")
        assert_refused(lambda bad=bad: Grid().walk((0, 0), bad), "end")
    for number in (np.nan, -np.inf, 1e6, -1e300):
        bad = np.array([BOX, BOX], dtype=float)
        bad[1, 2, 0] = number
        for method, *arguments in (
            (Grid().file, bad),
            (Grid().pairs, bad),
            (Grid().cell_of, [0, number]),
            (Grid().walk, (0, 0), (number, 0)),
            (Grid().walk, (0, number), (0, 0)),
        ):
            assert_refused(lambda method=method, arguments=arguments: method(*arguments), f" is {number!r}")


def test_cell_that_would_fill_the_memory_is_refused_before_it_does():
    large = [[(-90, -90), (90, -90), (90, 90), (-90, 90)]]
    assert_refused(lambda: Grid(cell=0.001).file(large), "cell is 0.001", "20,000,000 entries")
    many = np.broadcast_to(np.array(BOX, dtype=float), (7000, 4, 2))
    assert_refused(lambda: Grid(cell=1000.0).pairs(many), "cell is 1000", "20,000,000 entries")
