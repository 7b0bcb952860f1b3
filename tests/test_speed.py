"""How fast the head goes: numbers, tables and functions."""

from __future__ import annotations

import itertools
import math
import pickle

import mpmath
import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon.errors import FileFormatError, ParameterError
from pymunk_dragon.model.speed import ConstantSpeed, Speed, SpeedTable, speed_of
from pymunk_dragon.model.speed.function import SpeedFunction

TABLE = SpeedTable((-50.0, 10.0, 20.0, 20.5, 300.0), (0.5, 1.0, 3.0, 0.2, 1.5))

speeds = st.floats(0.01, 20)


@st.composite
def tables(draw):
    times = draw(st.lists(st.floats(-500, 500), min_size=1, max_size=8, unique_by=lambda time: round(time, 3)))
    return SpeedTable(sorted(times), draw(st.lists(speeds, min_size=len(times), max_size=len(times))))


def test_a_number_a_table_and_a_function_are_speeds():
    for value in (1.5, TABLE, lambda t: 1 + 0 * t, SpeedFunction(math.exp)):
        assert isinstance(speed_of(value), Speed)
    assert speed_of(TABLE) is TABLE
    assert speed_of(2) == ConstantSpeed(2.0)


@pytest.mark.parametrize("value", [*NO_NUMBERS, 1e-7, 20.1], ids=repr)
def test_what_is_no_speed_is_refused(value):
    with pytest.raises(ParameterError) as caught:
        speed_of(value)
    assert caught.value.value is value
    assert_says(caught.value, "speed is ", "must be a number from 1e-06 to 20 m/s")


def test_a_constant_speed_is_exact():
    speed = speed_of(0.7)
    times = np.array([-3.0, 0.0, 412.473])
    assert speed.distance(times).tolist() == (0.7 * times).tolist()
    assert speed.time([1.0, -2.0]).tolist() == [1 / 0.7, -2 / 0.7]
    assert speed.at(times).tolist() == [0.7] * 3
    assert speed.fastest(0.0, 9.0) == 0.7


def test_a_table_goes_straight_from_entry_to_entry():
    assert TABLE.at([-1e6, -50, -20, 10, 15, 20.25, 300, 1e6]).tolist() == pytest.approx(
        [0.5, 0.5, 0.75, 1.0, 2.0, 1.6, 1.5, 1.5]
    )


@pytest.mark.parametrize("time", [-300.0, -50.0, -7.3, 0.0, 9.999, 20.2, 123.4, 301.0, 900.0])
def test_a_tables_way_is_the_integral_of_its_speed(time):
    knots = sorted({0.0, time, *(t for t in TABLE.times if min(0, time) < t < max(0, time))})
    exact = math.fsum((b - a) * (TABLE.at(a) + TABLE.at(b)) / 2 for a, b in itertools.pairwise(knots))
    assert TABLE.distance(time) == pytest.approx(math.copysign(exact, time), rel=1e-14, abs=1e-15)


@given(tables(), st.lists(st.floats(-2000, 2000), min_size=1))
def test_a_tables_time_is_the_inverse_of_its_way(table, times):
    found = table.time(table.distance(times))
    # A way is known to some units of its last place, and where the head is slow it stays there the longer.
    allowed = 1e-12 * (1 + np.abs(table.distance(times))) / table.at(times) + 1e-12 * np.abs(times)
    assert np.all(np.abs(found - times) <= allowed)


def test_a_table_that_hardly_changes_loses_no_places():
    table = SpeedTable((0.0, 1e6), (1.0, 1.0 + 1e-13))
    assert table.time(table.distance(777.77)) == pytest.approx(777.77, rel=1e-15)


@given(tables(), st.floats(-600, 600), st.floats(0, 300))
def test_a_tables_bound_is_the_largest_speed_in_between(table, begin, length):
    most = table.at(np.linspace(begin, begin + length, 301)).max()
    entries = [v for t, v in zip(table.times, table.speeds, strict=True) if begin <= t <= begin + length]
    assert table.fastest(begin, begin + length) == pytest.approx(max([most, *entries]), rel=1e-12)


def test_bounds_are_given_for_many_spans_at_once():
    begins, ends = np.array([-60.0, 15.0, 20.1, 400.0]), np.array([-55.0, 25.0, 20.2, 500.0])
    assert TABLE.fastest(begins, ends).tolist() == pytest.approx([0.5, 3.0, 3 - 0.1 * 5.6, 1.5])


@pytest.mark.parametrize(
    ("times", "values", "words"),
    [
        ([], [], ["times is []", "at least one number"]),
        ("12", [1, 2], ["times is '12'"]),
        ([0, 1], [1], ["speeds is (1.0,)", "as many as the times, 2"]),
        ([0, 2, 2], [1, 1, 2], ["times[2] is 2.0", "later than the time before it, 2 s"]),
        ([0, 2, 1], [1, 1, 2], ["times[2] is 1.0", "later than the time before it, 2 s"]),
        ([0, math.nan], [1, 1], ["times[1] is nan"]),
        ([0, math.inf], [1, 1], ["times[1] is inf"]),
        ([0, 1], [1, 0], ["speeds[1] is 0", "from 1e-06 to 20 m/s"]),
        ([0, 1], [-1, 1], ["speeds[0] is -1"]),
        ([0, 1], [1, "2"], ["speeds[1] is '2'"]),
        ([0, 1], [1, math.nan], ["speeds[1] is nan"]),
        ([0, 1], [1, 21], ["speeds[1] is 21"]),
    ],
)
def test_an_impossible_table_is_refused_with_the_entry(times, values, words):
    with pytest.raises(ParameterError) as caught:
        SpeedTable(times, values)
    assert_says(caught.value, *words)


def test_tables_of_the_same_entries_are_the_same():
    assert SpeedTable([0, 1], np.array([1.0, 2.0])) == SpeedTable((0.0, 1.0), [1, 2])
    assert hash(pickle.loads(pickle.dumps(TABLE))) == hash(TABLE)


@pytest.mark.parametrize("text", ["0,1\n10,2.5\n", "time,speed\r\n0, 1\r\n\r\n10 ,2.5", "\ufefft;v\n0,1\n10,2.5\n"])
def test_a_table_is_read_from_a_file(tmp_path, text):
    path = tmp_path / "speed.csv"
    path.write_text(text, encoding="utf-8")
    assert SpeedTable.read(path) == SpeedTable((0, 10), (1, 2.5))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["no line holds a time in s and a speed in m/s"]),
        ("t,v\n", ["no line holds"]),
        ("t,v\n0,1\n5,fast\n", ["line 3 must hold a time in s and a speed in m/s, not '5,fast'"]),
        ("0,1\n5\n", ["line 2 must hold"]),
        ("0,1,2\n", ["line 1 must hold"]),
        ("t,v\n\n0,1\n0,2\n", ["line 4", "times[1] is 0.0", "later than"]),
        ("0,1\n5,-2\n", ["line 2", "speeds[1] is -2.0", "from 1e-06 to 20 m/s"]),
        ("0,1\n5,nan\n", ["line 2", "speeds[1] is nan"]),
    ],
)
def test_a_wrong_file_is_refused_with_the_line(tmp_path, text, words):
    path = tmp_path / "speed.csv"
    path.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        SpeedTable.read(path)
    assert_says(caught.value, "speed.csv", *words)


def test_a_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="readable file"):
        SpeedTable.read(tmp_path / "nowhere.csv")
    (tmp_path / "film.csv").write_bytes(bytes(range(128, 256)))
    with pytest.raises(FileFormatError, match="not a text file"):
        SpeedTable.read(tmp_path / "film.csv")


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
    "root": (lambda t: 1 + np.sqrt(np.abs(t - 7)) / 5, lambda t: t + 2 / mpmath.mpf(15) * _root(t)),
    "saturation": (
        lambda t: 1.5 + np.tanh((t - 20) / 3),
        lambda t: 1.5 * t + 3 * mpmath.log(mpmath.cosh((t - 20) / 3) / mpmath.cosh(mpmath.mpf(20) / 3)),
    ),
    "constant": (lambda t: 1.25, lambda t: mpmath.mpf(1.25) * t),
}


def _root(t):
    return mpmath.sign(t - 7) * abs(t - 7) ** mpmath.mpf(1.5) + mpmath.mpf(7) ** mpmath.mpf(1.5)


@pytest.mark.parametrize("name", CLOSED)
def test_a_functions_way_is_its_integral(name):
    function, integral = CLOSED[name]
    times = np.array([-400.3, -100.0, -1.0, 0.0, 1e-9, 3.3, 7.0, 99.99, 150.0, 412.473])
    exact = np.array([float(integral(mpmath.mpf(time))) for time in times])
    assert np.abs(speed_of(function).distance(times) - exact).max() < 1e-11


def test_a_functions_way_agrees_with_another_quadrature():
    speed = speed_of(lambda t: np.exp(np.sin(t)) / (1 + 0.1 * np.cos(3 * t)))
    steps = mpmath.linspace(0, 60, 61)
    exact = mpmath.quad(lambda t: mpmath.exp(mpmath.sin(t)) / (1 + mpmath.cos(3 * t) / 10), steps)
    assert float(speed.distance(60.0)) == pytest.approx(float(exact), abs=1e-12)


@pytest.mark.parametrize("name", CLOSED)
def test_a_functions_time_is_the_inverse_of_its_way(name):
    speed = speed_of(CLOSED[name][0])
    times = np.linspace(-300, 500, 4001)
    assert np.abs(speed.time(speed.distance(times)) - times).max() < 2e-12
    assert speed.at(times).shape == times.shape


@pytest.mark.parametrize("name", CLOSED)
def test_a_functions_bound_holds_and_is_tight(name):
    function = CLOSED[name][0]
    speed = speed_of(function)
    random = np.random.default_rng(7)
    begins = random.uniform(-30, 30, 40)
    ends = begins + 10 ** random.uniform(-6, 1.3, 40)
    bounds = speed.fastest(begins, ends)
    for begin, end, bound in zip(begins, ends, bounds, strict=True):
        most = speed.at(np.linspace(begin, end, 2001)).max()
        nearby = speed.at(np.linspace(begin - 0.1, end + 0.1, 2001)).max()
        assert most <= bound * (1 + 1e-12)
        assert bound <= nearby * 1.03


def test_the_answer_does_not_depend_on_what_was_asked_before():
    times = [300.0, -200.0, 5.0, 0.5, -7.0]
    ways = {time: speed_of(WAVE[0]).distance(time).item() for time in times}
    speed = speed_of(WAVE[0])
    speed.time(-20.0)
    assert [speed.distance(time).item() for time in times] == list(ways.values())
    assert speed.distance(times).tolist() == list(ways.values())


def test_only_the_time_that_is_asked_about_is_looked_at():
    speed = speed_of(lambda t: np.sqrt(101 - t) / 10)
    exact = (101**1.5 - 3**1.5) / 15
    assert speed.distance(98.0) == pytest.approx(exact, abs=1e-12)
    assert speed.time(exact) == pytest.approx(98.0, abs=1e-10)
    with pytest.raises(ParameterError, match="speed at t = 1"):
        speed.distance(110.0)


@pytest.mark.parametrize(
    ("function", "at", "words"),
    [
        (lambda t: 1 - t / 100, 99.99, ["number from 1e-06 to 20 m/s"]),
        (lambda t: np.cos(t), 1.57, ["number from 1e-06 to 20 m/s"]),
        (lambda t: 0 * t, 0.0, ["is 0.0"]),
        (lambda t: np.where(t < 5, 1.0, 2.0), 5.0, ["(1.0, 2.0)", "must not jump"]),
        (lambda t: 1.0 if t < math.pi else 2.0, math.pi, ["(1.0, 2.0)", "must not jump"]),
        (lambda t: 1 + np.floor(t) / 50, 1.0, ["(1.0, 1.02)", "must not jump"]),
        (lambda t: 1 / t, 0.0, ["speed at t = 0 s is "]),
        (lambda t: 1 / math.sqrt(9 - t), 9.0, []),
    ],
)
def test_a_function_that_is_no_speed_is_refused_with_the_time(function, at, words):
    with pytest.raises(ParameterError) as caught:
        speed_of(function).distance([0.0, 120.0])
    assert_says(caught.value, "speed", *words)
    if "at t = " in str(caught.value):
        assert float(str(caught.value).split("at t = ")[1].split()[0]) == pytest.approx(at, abs=0.15)
    else:
        assert f"at {at:g} s" in str(caught.value) or not words


def test_noise_is_refused():
    with pytest.raises(ParameterError, match=r"speed from t = 0 s to 2 s .*smooth but for some kinks"):
        speed_of(lambda t: 1 + 1e-3 * np.sin(1e9 * t)).distance(1.0)


@pytest.mark.parametrize("function", [lambda: 1.0, lambda t, v: 1.0])
def test_what_is_no_function_of_time_is_refused(function):
    with pytest.raises(ParameterError) as caught:
        speed_of(function).distance(1.0)
    assert_says(caught.value, "speed is ", "a function from s to m/s")


def test_times_and_distances_out_of_reach_are_refused(monkeypatch):
    with pytest.raises(ParameterError, match="time is 1000000"):
        speed_of(WAVE[0]).distance(1e6)
    monkeypatch.setattr("pymunk_dragon.model.speed.function.MAX_TIME", 1e3)
    with pytest.raises(ParameterError, match=r"distance is -2001\.0, .*within the 2000 m that are travelled"):
        speed_of(lambda t: 2.0 + 0 * t).time(-2001.0)


@pytest.mark.parametrize("value", [0.5, TABLE, WAVE[0]], ids=["number", "table", "function"])
def test_for_ever_is_gone_in_for_ever(value):
    speed = speed_of(value)
    for sign in (-math.inf, math.inf):
        assert speed.distance(sign) == sign
        assert speed.time(sign) == sign
    assert math.isnan(speed.distance(math.nan))
    assert math.isnan(speed.time(math.nan))


@pytest.mark.parametrize("value", [0.5, TABLE, WAVE[0]], ids=["number", "table", "function"])
def test_shapes_are_kept(value):
    speed = speed_of(value)
    for shape in ((), (0,), (3,), (2, 3)):
        zeros = np.zeros(shape)
        for answer in (speed.at(zeros), speed.distance(zeros), speed.time(zeros), speed.fastest(zeros, zeros)):
            assert np.shape(answer) == shape
