"""What the lessons on collisions say, against many digits, Shapely, and plain Python."""

from __future__ import annotations

import math
from functools import cache
from itertools import combinations, pairwise

import mpmath as mp
import numpy as np
import oracle
import pytest
import shapely
from lesson_runs import numbers, played

from pymunk_dragon import March
from pymunk_dragon.lessons import LESSONS

SIZES = {"width": "0.3", "overhang": "0.275", "head_spacing": "2.86", "body_spacing": "1.65", "pitch": "0.55"}


def sizes(**changed):
    return {name: mp.mpf(value) for name, value in (SIZES | changed).items()}


def gap(time, pair, **changed):
    """mm, in many digits."""
    with mp.workdps(oracle.DIGITS):
        return float(1000 * oracle.gap(mp.mpf(time), pair, sizes(**changed)))


def contact_time(time, pair, **changed):
    return float(oracle.touching(pair, time, sizes(**changed)))


@cache
def handles(time, count):
    """The foremost handles, as complex numbers with many digits."""
    found, _ = oracle.solve(
        time, benches=count - 1, head_spacing=2.86, body_spacing=1.65, pitch=0.55, turns=16, speed=1, difference=False
    )
    return [mp.mpc(x, y) for x, y in found]


def bench(front, rear, width=0.3):
    """A bench midway between two holes, which need not be quite as far apart as its own; for Shapely."""
    front, rear = complex(front), complex(rear)
    along = (front - rear) / abs(front - rear)
    middle, half = (front + rear) / 2, along * (3.41 if abs(front - rear) > 2 else 2.20) / 2
    ends = (middle + half, middle - half)
    sides = zip((*ends, *ends[::-1]), (1, 1, -1, -1), strict=True)
    corners = [end + side * 1j * along * width / 2 for end, side in sides]
    return shapely.Polygon([(corner.real, corner.imag) for corner in corners])


def lines(name):
    return played(name).printed.splitlines()


def said(name, part):
    return numbers(LESSONS[name].text(part))


# Four shadows


def two_benches(degrees, aside=1.6, ahead=0.9):
    lying = shapely.box(-1.1, -0.15, 1.1, 0.15)
    turned = shapely.affinity.rotate(lying, degrees, origin=(0, 0))
    return lying, shapely.affinity.translate(turned, aside, ahead)


def shadow_gaps(degrees, aside=1.6, ahead=0.9):
    """On the axes of the lying bench and then of the turned one, in plain Python."""
    found = []
    for angle in (0, 90, degrees, degrees + 90):
        x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        ends = []
        for shape in two_benches(degrees, aside, ahead):
            along = [x * u + y * v for u, v in shape.exterior.coords]
            ends.append((min(along), max(along)))
        (one, two), (three, four) = ends
        found.append(max(three - two, one - four))
    return found


def test_sat_prints_the_widest_shadow_gap_and_it_is_what_parts_the_benches():
    for line in lines("sat"):
        degrees, widest, found = numbers(line)
        first, second = two_benches(degrees)
        assert widest == pytest.approx(max(shadow_gaps(degrees)), abs=5.1e-5)
        if widest > 0:
            assert found == pytest.approx(first.distance(second), abs=5.1e-5)
        else:
            # Moved by as much and a little more it is free in some direction, by a little less in none.
            ways = [(math.cos(math.radians(a)), math.sin(math.radians(a))) for a in range(360)]
            for more, parts in ((1e-4, True), (-1e-4, False)):
                far = more - found
                moved = [shapely.affinity.translate(second, far * x, far * y) for x, y in ways]
                assert any(first.distance(each) > 0 for each in moved) == parts


# Cells


@pytest.fixture(scope="module")
def benches_in_cells():
    """Benches at the first contact, as Shapely has them, in cells to the right of and below the paper's origin."""
    holes = March().at(contact_time(412.4738, (0, 8))).positions[0]
    shapes = [bench(complex(*front), complex(*rear)) for front, rear in pairwise(holes)]
    return [shapely.affinity.affine_transform(each, [1 / 0.55, 0, 0, -1 / 0.55, 16, 16]) for each in shapes]


def filed(shape):
    """Cells that a shape touches, by asking all of those about it."""
    left, top, right, bottom = map(math.floor, shape.bounds)
    around = [(row, column) for row in range(top, bottom + 1) for column in range(left, right + 1)]
    return {(row, column) for row, column in around if shape.intersects(shapely.box(column, row, column + 1, row + 1))}


def test_grid_counts_the_pairs_that_share_a_cell(benches_in_cells):
    for line, count in zip(lines("grid")[-2:], (16, 223), strict=True):
        shapes = benches_in_cells[:count]
        cells = [filed(shape) for shape in shapes]
        apart = [(i, j) for i, j in combinations(range(count), 2) if j - i > 1]
        shared = [(i, j) for i, j in apart if cells[i] & cells[j]]
        touching = [(i, j) for i, j in apart if shapes[i].distance(shapes[j]) < 1e-9]
        assert touching == [(0, 8)]
        found = [count, len(apart), sum(map(len, cells)), len(shared), len(touching)]
        assert numbers(line) == found
        assert set(found[1:4]) - {144} <= {*said("grid", "question"), *said("grid", "answer")}


def test_grid_walks_through_the_cells_of_the_edge_in_its_order(benches_in_cells):
    corners = np.array(benches_in_cells[8].exterior.coords)
    # The longer edge that the head is on.
    head = benches_in_cells[0]
    edges = [shapely.LineString(corners[i : i + 2]) for i in range(4)]
    edge = min((each for each in edges if each.length > 1), key=head.distance)
    points = np.array([edge.interpolate(share, normalized=True).coords[0] for share in np.linspace(0, 1, 100_001)])
    walked = dict.fromkeys((math.floor(row), math.floor(column)) for column, row in points)
    printed = [[f"({row}, {column})" for row, column in way] for way in (walked, reversed(walked))]
    first, second = lines("grid")[1:3]
    assert first.removeprefix("our walk  ") in map(" ".join, printed)
    assert second.removeprefix("Grid.walk ") == first.removeprefix("our walk  ")


# Near misses


@pytest.mark.thorough
def test_near_misses_are_those_of_many_digits():
    for line, near in zip(lines("near-miss")[:2], (406.8, 409.8), strict=True):
        time, first, second, printed = numbers(line)
        pair = (int(first), int(second))
        least = min(gap(near + k / 1000, pair) for k in range(0, 100, 4))
        assert printed == pytest.approx(least, abs=5.1e-4)
        assert gap(time, pair) == pytest.approx(least, abs=1e-4)
        assert printed in said("near-miss", "answer")
    assert numbers(lines("near-miss")[2])[0] == round(contact_time(412.4738, (0, 8)), 3) == 412.474
    assert lines("near-miss")[3].split()[3:] == lines("near-miss")[2].split()[1:]


def test_near_miss_check_is_a_corners_distance_from_a_line():
    (cx, cy), (ax, ay), (bx, by) = (numbers(line) for line in lines("near-miss")[-3:])
    by_hand = abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 1.65 - 0.15
    assert f"{1000 * by_hand:.3f}" == "0.865"
    exact = handles(numbers(lines("near-miss")[1])[0], 13)
    for point, (x, y) in zip(exact[11:13], ((ax, ay), (bx, by)), strict=True):
        assert abs(complex(point) - complex(x, y)) < 6e-4


def test_positions_cut_to_a_millimetre_let_the_head_hit_bench_11():
    time = numbers(lines("near-miss")[4])[1]
    assert time in said("near-miss", "answer")
    hits = []
    for moment in (time - 0.001, time):
        exact = handles(round(moment, 3), 13)
        cut = [complex(int(1000 * z.real), int(1000 * z.imag)) / 1000 for z in exact]
        assert not bench(*exact[:2]).intersects(bench(*exact[11:13]))
        hits.append(bench(*cut[:2]).intersects(bench(*cut[11:13])))
    assert hits == [False, True]


# The missed window

WIDER = {"width": "0.301"}


@pytest.mark.thorough
def test_window_is_that_of_many_digits():
    begin = contact_time(409.7759, (0, 11), **WIDER)
    end = contact_time(409.8845, (0, 11), **WIDER)
    depth = -min(gap(409.82 + k / 1000, (0, 11), **WIDER) for k in range(20))
    seconds, certified, search, window = (numbers(line) for line in lines("missed-window"))
    assert certified[0] == search[0] == round(begin, 6)
    assert search[1] == round(begin, 5)
    assert window[:2] == [round(end - begin, 3), round(depth, 3)]
    # Bisection stops a microsecond behind it.
    assert seconds[0] == pytest.approx(contact_time(412.4422, (0, 8), **WIDER), abs=2e-6)
    assert {round(begin, 3), *window[:2]} <= set(said("missed-window", "answer"))


# The smallest pitch


def test_smallest_pitch_and_the_time_of_its_touch_are_those_of_many_digits():
    time, pitch = oracle.grazing((0, 19), 216.338, sizes(pitch="0.45033739"))
    printed = numbers(lines("pitch")[0])
    assert printed == [round(float(pitch), 9), 0, 19, round(float(time), 3)]
    assert printed[0] == said("pitch", "answer")[0]


@pytest.mark.thorough
def test_pitch_of_looks_each_second_is_where_one_of_them_sees_no_gap():
    with mp.workdps(oracle.DIGITS):
        pitch = mp.findroot(
            lambda p: oracle.gap(mp.mpf(216), (0, 19), sizes(pitch=p)), (mp.mpf("0.4502"), mp.mpf("0.4503")), tol=1e-30
        )
    seen, truth = (numbers(line) for line in lines("pitch")[2:])
    assert seen[-2] == truth[-2] == round(float(pitch), 6)
    deepest = min(gap(216.2 + k / 100, (0, 19), pitch=mp.nstr(pitch, 20)) for k in range(15))
    assert truth[-1] == round(deepest, 3)
    assert {seen[-2], -truth[-1]} <= set(said("pitch", "answer"))


def test_pitch_check_is_the_way_in_along_circles():
    pitch, way = numbers(lines("pitch")[0])[0], numbers(lines("pitch")[1])
    exact = oracle.arc_length(32 * mp.pi, pitch) - oracle.arc_length(2 * mp.pi * 4.5 / pitch, pitch)
    assert way == [round(16 * pitch, 6), 4.5, round(float(exact), 3)]
    turns = 16 - 4.5 / 0.450337
    circles = turns * 2 * math.pi * (7.205398 + 4.5) / 2
    assert {way[-1], round(turns, 6), round(circles, 3)} <= set(said("pitch", "check"))
