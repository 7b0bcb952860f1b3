"""How fast the head goes: numbers, tables and functions."""

from __future__ import annotations

import itertools
import math
import pickle

import mpmath
import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says, refusal
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon.errors import FileFormatError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.speed import ConstantSpeed, SpeedTable, speed_of

TABLE = SpeedTable((-50.0, 10.0, 20.0, 20.5, 300.0), (0.5, 1.0, 3.0, 0.2, 1.5))
speeds = st.floats(0.01, 20)


@st.composite
def tables(draw):
    times = draw(st.lists(st.floats(-500, 500), min_size=1, max_size=8, unique_by=lambda time: round(time, 3)))
    return SpeedTable(sorted(times), draw(st.lists(speeds, min_size=len(times), max_size=len(times))))


def root(t):
    return mpmath.sign(t - 7) * abs(t - 7) ** mpmath.mpf(1.5) + mpmath.mpf(7) ** mpmath.mpf(1.5)


# Functions, and their exact integrals from 0.
WAVE = (lambda t: 1 + 0.3 * np.sin(t), lambda t: t + 0.3 * (1 - mpmath.cos(t)))
CLOSED = {
    "wave": WAVE,
    "scalars only": (lambda t: 1 + 0.3 * math.sin(t), WAVE[1]),
    "fast wave": (lambda t: 2 + np.cos(40 * t), lambda t: 2 * t + mpmath.sin(40 * t) / 40),
    "kink": (lambda t: 0.5 + np.abs(t - 3.3) / 40, lambda t: t / 2 + ((t - 3.3) * abs(t - 3.3) + 3.3**2) / 80),
    "bounded": (
        lambda t: np.minimum(0.5 + np.abs(t) / 100, 2.0),
        lambda t: t / 2 + t * abs(t) / 200 if abs(t) <= 150 else mpmath.sign(t) * (187.5 + 2 * (abs(t) - 150)),
    ),
    "root": (lambda t: 1 + np.sqrt(np.abs(t - 7)) / 5, lambda t: t + 2 / mpmath.mpf(15) * root(t)),
    "constant": (lambda t: 1.25, lambda t: mpmath.mpf(1.25) * t),
}


def test_a_number_is_a_constant_speed_and_what_is_none_is_refused():
    speed, times = speed_of(0.7), np.array([-3.0, 0.0, 412.473])
    assert (speed, speed_of(TABLE)) == (ConstantSpeed(0.7), TABLE)
    assert speed.distance(times).tolist() == (0.7 * times).tolist()
    assert speed.time([1.0, -2.0]).tolist() == [1 / 0.7, -2 / 0.7]
    assert speed.at(times).tolist() == [0.7] * 3
    assert speed.fastest(0.0, 9.0) == 0.7
    for value in [*NO_NUMBERS, 1e-7, 20.1]:
        assert_says(refusal(speed_of, value), "speed is ", "from 1e-06 to 20 m/s")


# Tables


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
        ("12", [1, 2], "times is '12'"),
        ([0, 1], [1], "speeds is (1.0,)"),
        ([0, 2, 2], [1, 1, 2], "times[2] is 2.0"),
        ([0, 2, 1], [1, 1, 2], "times[2] is 1.0"),
        ([0, math.nan], [1, 1], "times[1] is nan"),
        ([0, 1], [1, 0], "speeds[1] is 0"),
        ([0, 1], [-1, 1], "speeds[0] is -1"),
        ([0, 1], [1, "2"], "speeds[1] is '2'"),
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


# Functions

WRONG = (lambda: 1.0, lambda t, v: 1.0)


@pytest.mark.parametrize("name", CLOSED)
def test_a_functions_way_is_its_integral_and_its_time_the_inverse(name):
    function, integral = CLOSED[name]
    speed = speed_of(function)
    times = np.array([-400.3, -100.0, -1.0, 0.0, 1e-9, 3.3, 7.0, 99.99, 150.0, 412.473])
    exact = np.array([float(integral(mpmath.mpf(time))) for time in times])
    assert np.abs(speed.distance(times) - exact).max() < 1e-11
    times = np.linspace(-300, 500, 401)
    assert np.abs(speed.time(speed.distance(times)) - times).max() < 2e-12


@pytest.mark.parametrize("name", [name for name in CLOSED if name != "scalars only"])
def test_a_functions_bound_holds_and_is_tight(name):
    speed = speed_of(CLOSED[name][0])
    random = np.random.default_rng(7)
    begins = random.uniform(-30, 30, 20)
    ends = begins + 10 ** random.uniform(-6, 1.3, 20)
    for begin, end, bound in zip(begins, ends, speed.fastest(begins, ends), strict=True):
        most = speed.at(np.linspace(begin, end, 1001)).max()
        nearby = speed.at(np.linspace(begin - 0.1, end + 0.1, 1001)).max()
        assert most <= bound * (1 + 1e-12)
        assert bound <= nearby * 1.03


def test_the_answer_does_not_depend_on_what_was_asked_before():
    times = [300.0, -200.0, 5.0, 0.5, -7.0]
    ways = [speed_of(WAVE[0]).distance(time).item() for time in times]
    speed = speed_of(WAVE[0])
    speed.time(-20.0)
    assert [speed.distance(time).item() for time in times] == ways == speed.distance(times).tolist()
    # And it looks only at the times that it needs.
    limited, exact = speed_of(lambda t: np.sqrt(101 - t) / 10), (101**1.5 - 3**1.5) / 15
    assert limited.distance(98.0) == pytest.approx(exact, abs=1e-12)
    assert limited.time(exact) == pytest.approx(98.0, abs=1e-10)
    assert_says(refusal(limited.distance, 110.0), "speed at t = 1")


def test_a_function_that_is_no_speed_is_refused_with_the_time():
    for function, at, bound in (
        (lambda t: 1 - t / 100, 99.99, "from 1e-06 to 20 m/s"),
        (lambda t: np.cos(t), 1.57, "from 1e-06 to 20 m/s"),
        (lambda t: 1 / t, 0.0, "from 1e-06 to 20 m/s"),
        (lambda t: np.where(t < 5, 1.0, 2.0), 5.0, "must not jump"),
        (lambda t: 1.0 if t < math.pi else 2.0, math.pi, "must not jump"),
        (lambda t: 1 + np.floor(t) / 50, 1.0, "must not jump"),
    ):
        message = str(refusal(speed_of(function).distance, [0.0, 120.0]))
        assert bound in message
        assert float(message.split("at t = ")[1].split()[0]) == pytest.approx(at, abs=0.15)
    refusal(speed_of(lambda t: 1 / math.sqrt(9 - t)).distance, 120.0)
    for rate in (1e5, 1e9):
        assert_says(refusal(lambda rate: March(speed=lambda t: 1 + 0.9 * np.sin(rate * t)), rate), "0.002 s")
    for function in WRONG:
        assert_says(refusal(speed_of(function).distance, 1.0), "speed is ", "a function from s to m/s")


def test_times_and_distances_out_of_reach_are_refused(monkeypatch):
    assert refusal(speed_of(WAVE[0]).distance, 1e6).name == "time"
    monkeypatch.setattr("pymunk_dragon.model.speed.function.MAX_TIME", 1e3)
    error = refusal(speed_of(lambda t: 2.0 + 0 * t).time, -2001.0)
    assert error.name == "distance"
    assert_says(error, "2000 m")


@pytest.mark.parametrize("value", [0.5, TABLE, WAVE[0]], ids=["number", "table", "function"])
def test_shapes_are_kept_and_what_is_infinite_or_nan_stays_so(value):
    speed = speed_of(value)
    for shape in ((), (0,), (3,), (2, 3)):
        zeros = np.zeros(shape)
        for answer in (speed.at(zeros), speed.distance(zeros), speed.time(zeros), speed.fastest(zeros, zeros)):
            assert np.shape(answer) == shape
    ends = [-math.inf, math.inf, math.nan]
    np.testing.assert_array_equal(speed.distance(ends), ends)
    np.testing.assert_array_equal(speed.time(ends), ends)
