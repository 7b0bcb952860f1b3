"""How fast the head goes: numbers, tables and functions."""

import itertools
import math
import pickle

import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says, refusal
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon import FileFormatError, March, SpeedTable

TABLE = SpeedTable((-50.0, 10.0, 20.0, 20.5, 300.0), (0.5, 1.0, 3.0, 0.2, 1.5))
speeds = st.floats(0.01, 20)


@st.composite
def tables(draw):
    times = draw(st.lists(st.floats(-500, 500), min_size=1, max_size=8, unique_by=lambda time: round(time, 3)))
    return SpeedTable(sorted(times), draw(st.lists(speeds, min_size=len(times), max_size=len(times))))


def test_a_number_is_a_constant_speed_and_what_is_none_is_refused():
    speed, times = March(speed=0.7).speed_profile, np.array([-3.0, 0.0, 412.473])
    assert (speed, March(speed=TABLE).speed_profile) == (SpeedTable([0], [0.7]), TABLE)
    assert speed.distance(times).tolist() == (0.7 * times).tolist()
    assert speed.time([1.0, -2.0]).tolist() == [1 / 0.7, -2 / 0.7]
    assert speed.at(times).tolist() == [0.7] * 3
    assert speed.fastest(0.0, 9.0) == 0.7
    for value in [*NO_NUMBERS, 1e-7, 20.1]:
        assert_says(refusal(March, speed=value), "speed is ", "from 1e-06 to 20 m/s")


def test_a_tables_way_is_the_integral_of_its_speed():
    assert TABLE.at([-1e6, -50, -20, 10, 15, 20.25, 300, 1e6]).tolist() == pytest.approx(
        [0.5, 0.5, 0.75, 1.0, 2.0, 1.6, 1.5, 1.5]
    )
    for time in (-300.0, -50.0, -7.3, 0.0, 9.999, 20.2, 123.4, 301.0, 900.0):
        knots = sorted({0.0, time, *(t for t in TABLE.times if min(0, time) < t < max(0, time))})
        exact = math.fsum((b - a) * (TABLE.at(a) + TABLE.at(b)) / 2 for a, b in itertools.pairwise(knots))
        assert TABLE.distance(time) == pytest.approx(math.copysign(exact, time), rel=1e-14, abs=1e-15)


@given(tables(), st.lists(st.floats(-2000, 2000), min_size=1))
def test_a_tables_time_is_the_inverse_of_its_way(table, times):
    found = table.time(table.distance(times))
    # A way is known to some units of its last place, and where the head is slow it stays there the longer.
    allowed = 1e-12 * (1 + np.abs(table.distance(times))) / table.at(times) + 1e-12 * np.abs(times)
    assert np.all(np.abs(found - times) <= allowed)


@given(tables(), st.floats(-600, 600), st.floats(0, 300))
def test_a_tables_bound_is_the_largest_speed_in_between(table, begin, length):
    most = table.at(np.linspace(begin, begin + length, 301)).max()
    entries = [v for t, v in zip(table.times, table.speeds, strict=True) if begin <= t <= begin + length]
    assert table.fastest(begin, begin + length) == pytest.approx(max([most, *entries]), rel=1e-12)


def test_impossible_tables_are_refused_with_the_entry():
    for times, values, words in (
        ([], [], "times is []"),
        ("12", [1, 2], "times is"),
        ([0, 1], [1], "speeds is (1.0,)"),
        ([0, 2, 2], [1, 1, 2], "times[2] is 2.0"),
        ([0, 2, 1], [1, 1, 2], "times[2] is 1.0"),
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
    for text in ("0,1\n10,2.5\n", "time,speed\r\n0, 1\r\n\r\n10 ,2.5", "\ufefft;v\n0,1\n10,2.5\n"):
        path.write_text(text, encoding="utf-8")
        assert SpeedTable.read(path) == SpeedTable((0, 10), (1, 2.5))
    for text, words in (
        ("t,v\n", "no line"),
        ("t,v\n0,1\n5,fast\n", "line 3"),
        ("0,1\n5\n", "line 2"),
        ("0,1,2\n", "line 1"),
        ("t,v\n\n0,1\n0,2\n", "line 4"),
        ("0,1\n5,-2\n", "line 2"),
    ):
        path.write_text(text)
        assert_says(refusal(SpeedTable.read, path, error=FileFormatError), "speed.csv", words)
    refusal(SpeedTable.read, tmp_path / "nowhere.csv")


def test_a_function_is_tabulated_in_equal_steps():
    table = SpeedTable.of(lambda t: 1 + 0.3 * math.sin(t), -20, 400.005)
    assert (table.times[0], table.times[-1], len(table.times)) == (-20, 400.005, 42_002)
    times = np.linspace(-20, 400, 999)
    # By a function's second derivative times step^2 / 8, and its integral over the whole time.
    assert np.abs(table.at(times) - 1 - 0.3 * np.sin(times)).max() < 0.3 * 0.01**2 / 8 * 1.001
    assert np.abs(table.distance(times) - times - 0.3 * (1 - np.cos(times))).max() < 1e-5
    assert SpeedTable.of(lambda t: 2, 0, 1, step=0.5) == SpeedTable([0, 0.5, 1], [2, 2, 2])
    for function in (lambda t: 1 / t, None, complex):
        assert refusal(SpeedTable.of, function, 0, 3).name == "function"
    assert refusal(SpeedTable.of, math.cos, 2, 3).name == "speeds[0]"
    for times, name in (((1, 1), "until"), ((0, math.inf), "until"), (("0", 1), "start"), ((0, 1, 0), "step")):
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
