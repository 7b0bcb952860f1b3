"""The spiral by itself: arc length, places, and the nearest place a chord back."""

from __future__ import annotations

import warnings

import mpmath as mp
import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from pymunk_dragon.curves import Curve, Spiral
from pymunk_dragon.errors import ParameterError

PITCH = 0.55
SPIRAL = Spiral(pitch=PITCH)
# rad. Turn 48 is the rim of a dragon of a thousand benches; the centre and its surroundings are drawn as often.
angles = st.one_of(st.floats(0, 300), st.floats(0, 3), st.floats(0.98, 1.0))

# Points of the dense scan of one turn back; the first one is the place itself.
SCAN = np.linspace(0, 2 * np.pi, 40_001)


def scanned(theta):
    """Straight distances in m from the place `theta` to those of the scan behind it, by their coordinates."""
    x = PITCH / (2 * np.pi) * (theta + SCAN) * np.cos(theta + SCAN)
    y = PITCH / (2 * np.pi) * (theta + SCAN) * np.sin(theta + SCAN)
    return np.hypot(x - x[0], y - y[0])


def first_top(distances):
    """Index of the first maximum: the last point of the scan where the distance grows all the way."""
    falls = np.flatnonzero(np.diff(distances) < 0)
    return int(falls[0]) if falls.size else distances.size - 1


def test_spiral_is_a_curve():
    assert isinstance(SPIRAL, Curve)


def test_turn_16_is_8_8_m_out():
    assert SPIRAL.point(SPIRAL.start(16)) == pytest.approx([8.8, 0], abs=1e-12)


def test_neighbouring_turns_are_a_pitch_apart():
    radii = np.linalg.norm(SPIRAL.point(1.2 + 2 * np.pi * np.arange(20)), axis=-1)
    assert np.diff(radii) == pytest.approx(np.full(19, PITCH))
    assert SPIRAL.turn_distance == PITCH


@pytest.mark.parametrize("value", [*NO_NUMBERS, 1e-9, 1000.001, 1e308], ids=repr)
def test_impossible_pitch_is_refused(value):
    with pytest.raises(ParameterError) as caught:
        Spiral(pitch=value)
    assert caught.value.name == "pitch"
    assert_says(caught.value, "pitch is ", "must be a number from 0.001 to 1000 m")


def test_pitch_of_a_numpy_kind_becomes_a_plain_float():
    assert type(Spiral(pitch=np.float32(0.5)).pitch) is float
    assert Spiral(pitch=np.int64(2)) == Spiral(pitch=2.0)


@pytest.mark.parametrize("theta", [0.0, 1e-6, 0.3, 1.0, 10.0, 100.53])
def test_remaining_length_is_the_integral_of_the_stretch(theta):
    k = mp.mpf(PITCH) / (2 * mp.pi)
    length = mp.quad(lambda u: k * mp.sqrt(u * u + 1), mp.linspace(0, theta, 20)) if theta else mp.mpf(0)
    assert float(SPIRAL.remaining(theta)) == pytest.approx(float(length), rel=1e-14, abs=0)


@given(angles, st.floats(-500, 500))
@example(0.0, 0.0)
@example(1e-9, -1e-9)
def test_advance_travels_exactly_the_distance(theta, distance):
    assume(distance <= SPIRAL.remaining(theta))
    there = SPIRAL.advance(theta, distance)
    assert float(SPIRAL.remaining(theta) - SPIRAL.remaining(there)) == pytest.approx(distance, abs=1e-11)


@given(angles, st.floats(1e-6, 1e6))
def test_nothing_lies_beyond_the_centre(theta, excess):
    assert np.isnan(SPIRAL.advance(theta, SPIRAL.remaining(theta) + excess))


@given(angles)
def test_tangent_and_stretch_are_the_derivative_of_the_point(theta):
    k = mp.mpf(PITCH) / (2 * mp.pi)
    with mp.workdps(40):
        slope = [mp.diff(lambda u, f=f: k * u * f(u), mp.mpf(theta)) for f in (mp.cos, mp.sin)]
    inward = [-float(part) for part in slope]
    assert (SPIRAL.tangent(theta) * SPIRAL.stretch(theta)).tolist() == pytest.approx(inward, abs=1e-11)
    assert np.linalg.norm(SPIRAL.tangent(theta)) == pytest.approx(1, abs=1e-15)


@given(angles, st.floats(1e-3, 1.5))
@settings(max_examples=400)
@example(0.0, 0.5)
@example(0.0, 1.2)
@example(0.9858, 0.9999)
@example(0.987, 0.99999)
@example(0.99, 0.9999)
@example(0.99, 1.00002)
@example(0.995, 0.9999)
@example(0.995, 1.0001)
@example(1.0, 0.9999)
@example(1.0, 1.0005)
@example(1.0001, 1.0005)
def test_place_behind_is_the_first_intersection_and_none_lies_past_the_first_top(theta, share):
    distances = scanned(theta)
    top = first_top(distances)
    chord = share * distances[top]
    back = float(SPIRAL.behind(theta, chord)) - theta
    # The scan knows the height of the top to a few parts in 1e8.
    if share > 1 + 1e-7:
        assert np.isnan(back)
    if share < 1 - 1e-7:
        assert 0 < back <= 2 * np.pi + 1e-12
        here, there = SPIRAL.point([theta, theta + back])
        # A place is stored as an angle, and its last digit times the radius is how well the chord can be kept.
        resolution = np.spacing(theta + back) * np.linalg.norm(there)
        assert np.linalg.norm(here - there) == pytest.approx(chord, rel=1e-13, abs=4 * resolution + 1e-15)
        earlier = distances[: np.searchsorted(SCAN, back - 1e-9)]
        assert np.all(earlier < chord * (1 + 1e-12))
        assert back <= SCAN[top] + 1e-12


@pytest.mark.parametrize(
    ("theta", "dips"),
    [(0.5, False), (0.9, False), (0.985, False), (0.987, True), (0.999, True), (1.0, True), (1.001, True), (2.0, True)],
)
def test_distance_falls_somewhere_on_the_first_turn_back_but_not_from_within_0_986_rad_of_the_centre(theta, dips):
    # The boundary that `_first_maximum` speaks of, found by nothing but scanning.
    assert (first_top(scanned(theta)) < SCAN.size - 1) is dips


@pytest.mark.parametrize("theta", [0.987, 0.99, 0.995, 0.999, 1.0])
def test_nearest_of_three_intersections_is_taken_close_to_the_centre(theta):
    distances = scanned(theta)
    top = first_top(distances)
    valley = top + int(np.argmin(distances[top:]))
    chord = (distances[top] + distances[valley]) / 2
    crossings = SCAN[1:][np.diff(np.sign(distances - chord)) != 0]
    assert crossings.size == 3
    assert float(SPIRAL.behind(theta, chord)) - theta == pytest.approx(crossings[0], abs=2e-4)


def test_places_behind_keep_shape_and_carry_nan():
    theta = np.array([[1.0, 50.0, np.nan], [100.0, 0.0, 3.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        there = SPIRAL.behind(theta, 1.65)
    assert there.shape == (2, 3)
    assert np.isnan(there).tolist() == [[True, False, True], [False, True, True]]
    assert there[1, 0] == SPIRAL.behind(100.0, 1.65)
    assert SPIRAL.behind(np.empty(0), 1.65).shape == (0,)


# From two turns out, where a fifth of a pitch aside is still on the same side of the centre.
@given(st.floats(4 * np.pi, 300), st.floats(-3, 3), st.floats(-0.2, 0.2))
def test_foot_of_a_point_beside_the_path_is_on_the_turn_nearest_to_the_guess(theta, off, aside):
    point = SPIRAL.point(theta)
    beside = point + aside * PITCH * point / np.linalg.norm(point)
    place, foot, tangent = SPIRAL.foot(beside, theta + off)
    assert float(place) == pytest.approx(theta, abs=1e-12)
    assert foot == pytest.approx(point, abs=1e-11)
    assert tangent == pytest.approx(SPIRAL.tangent(theta), abs=1e-11)


def test_feet_of_many_points_are_those_of_each():
    theta = np.array([[20.0, 31.5, 40.0], [7.0, 8.0, 9.0]])
    points = 1.01 * SPIRAL.point(theta)
    together = SPIRAL.foot(points, theta)
    assert [part.shape for part in together] == [(2, 3), (2, 3, 2), (2, 3, 2)]
    for part, alone in zip(together, SPIRAL.foot(points[1, 2], theta[1, 2]), strict=True):
        assert np.array_equal(part[1, 2], alone)
