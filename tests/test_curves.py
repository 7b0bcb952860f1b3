"""The spiral by itself: arc length, places, and the nearest place a chord back."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says, examples, refusal
from hypothesis import example, given
from hypothesis import strategies as st

from pymunk_dragon.model.curves import Reversed, Spiral

PITCH = 0.55
SPIRAL = Spiral(pitch=PITCH)
SPIRALS = [
    Spiral(pitch=pitch, rotation=rotation, mirrored=mirrored, outward=outward)
    for pitch, rotation in ((0.55, 0.0), (1.7, 2.5))
    for mirrored in (False, True)
    for outward in (False, True)
]
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


def place(theta):
    """The place on the spiral at a polar angle, m."""
    k = PITCH / (2 * np.pi)
    return -k / 2 * (theta * np.hypot(theta, 1) + np.arcsinh(theta))


def behind(theta, chord):
    """How far back, in rad, the next handle is."""
    return float(SPIRAL.angle(SPIRAL.chain([place(theta)], [chord])[0, 1])) - theta


def test_turns_and_radii_are_where_the_contest_has_them():
    assert SPIRAL.point(SPIRAL.at_turn(16)) == pytest.approx([8.8, 0], abs=1e-12)
    radii = np.linalg.norm(SPIRAL.point([SPIRAL.at_turn(0.2 + turn) for turn in range(20)]), axis=-1)
    assert np.diff(radii) == pytest.approx(np.full(19, PITCH))
    wide = Spiral(pitch=1.7)
    assert np.linalg.norm(wide.point(wide.at_radius(4.5))) == pytest.approx(4.5, abs=1e-14)
    assert wide.at_radius(4.5) == pytest.approx(wide.at_turn(4.5 / 1.7), abs=1e-13)


def test_arc_length_is_the_integral_of_the_speed():
    k = PITCH / (2 * np.pi)
    for theta in (0.3, 2.3, 16.63, 100.53):
        length = mp.quad(lambda v: k * mp.sqrt(v * v + 1), mp.linspace(0, theta, 20))
        assert -place(theta) == pytest.approx(float(length), rel=1e-14)


def test_impossible_spirals_are_refused():
    for name, bound, values in (
        ("pitch", "0.001 to 1000 m", [*NO_NUMBERS, 1e-9, 1000.001, 1e308]),
        ("rotation", "-1000 to 1000 rad", [float("nan"), float("inf"), 10**400, "1", True, None, 1j, [1.0], 1001]),
        ("mirrored", "True or False", [1]),
        ("outward", "True or False", [1]),
    ):
        for value in values:
            assert_says(refusal(Spiral, **{name: value}), f"{name} is ", bound)
    assert type(Spiral(pitch=np.float32(0.5)).pitch) is float


@pytest.mark.parametrize("spiral", SPIRALS, ids=repr)
def test_a_spiral_is_what_its_formula_says_to_1e_12(spiral):
    with mp.workdps(50):
        k = mp.mpf(spiral.pitch) / (2 * mp.pi)
        sign = -1 if spiral.mirrored else 1
        ahead = 1 if spiral.outward else -1
        turn = mp.expj(mp.mpf(spiral.rotation))
        for theta in (0.0, 1e-6, 0.3, 1.0, 2.3, 2.4, 10.0, 16.63, 100.53, 700.0):
            u = mp.mpf(theta)
            length = k / 2 * (u * mp.sqrt(u * u + 1) + mp.asinh(u))
            # The double next to the true place is a place of its own.
            s = float(ahead * length)
            u = mp.findroot(lambda v, s=s: k / 2 * (v * mp.sqrt(v * v + 1) + mp.asinh(v)) - mp.mpf(ahead * s), u)
            first = k * (1 + sign * 1j * u) * mp.expj(sign * u) * turn
            second = k * (sign * 2j - u) * mp.expj(sign * u) * turn
            tangent = ahead * first / abs(first)
            bend = ahead * mp.im(mp.conj(first) * second) / abs(first) ** 3
            # A place 20 km out is itself known to a few picometres only.
            exact = max(1e-12, 2 * np.spacing(abs(s)))
            assert abs(mp.mpc(*spiral.point(s)) - k * u * mp.expj(sign * u) * turn) < exact
            assert abs(mp.mpc(*spiral.tangent(s)) - tangent) < 1e-12
            assert abs(float(spiral.curvature(s)) - bend) < 1e-12 * abs(bend)
            assert abs(float(spiral.angle(s)) - u) < 1e-12
            assert spiral.max_curvature(s, 1.01 * s) == pytest.approx(abs(float(bend)), rel=1e-12)


def test_nothing_lies_beyond_the_centre_and_the_way_out_is_the_way_in_travelled_back():
    for spiral in SPIRALS:
        beyond = (-1 if spiral.outward else 1) * np.array([1e-300, 1.0, 1e6])
        for answer in (spiral.point(beyond), spiral.tangent(beyond), spiral.curvature(beyond), spiral.angle(beyond)):
            assert np.isnan(answer).all()
        assert spiral.point(0.0).tolist() == [0, 0]
    back = Reversed(Spiral(outward=True))
    s = np.linspace(-400, 0, 50)
    assert (back.begin_s, back.end_s) == (-np.inf, 0)
    assert np.array_equal(back.point(s), SPIRAL.point(s))
    assert back.tangent(s) == pytest.approx(SPIRAL.tangent(s), abs=1e-15)
    assert np.array_equal(back.curvature(s), SPIRAL.curvature(s))
    assert np.array_equal(back.max_curvature(s, s - 1), SPIRAL.max_curvature(s, s - 1))


@given(angles, st.floats(1e-3, 1.5))
@examples(400)
@example(0.0, 0.5)
@example(0.0, 1.2)
@example(0.9858, 0.9999)
@example(0.987, 0.99999)
@example(0.99, 0.9999)
@example(0.99, 1.00002)
@example(1.0, 0.9999)
@example(1.0, 1.0005)
@example(280.5777257371152, 0.228515625)
def test_place_behind_is_the_first_intersection_and_none_lies_past_the_first_top(theta, share):
    distances = scanned(theta)
    top = first_top(distances)
    chord = share * distances[top]
    back = behind(theta, chord)
    # The scan knows the height of the top to a few parts in 1e8.
    if share > 1 + 1e-7:
        assert np.isnan(back)
    if share < 1 - 1e-7:
        assert 0 < back <= 2 * np.pi + 1e-12
        here, there = SPIRAL.point(SPIRAL.chain([place(theta)], [chord])[0])
        # The last digit of a place is how well the chord can be kept.
        resolution = np.spacing(-place(theta + back))
        assert np.linalg.norm(here - there) == pytest.approx(chord, rel=1e-13, abs=8 * resolution + 1e-15)
        earlier = distances[: np.searchsorted(SCAN, back - 1e-9)]
        assert np.all(earlier < chord * (1 + 1e-12))
        assert back <= SCAN[top] + 1e-12


def test_a_chain_without_a_place_for_one_handle_has_none_for_those_behind():
    places = SPIRAL.chain([place(50.0), np.nan, place(0.5), 1.0], [1.65, 1.65])
    assert np.isnan(places).tolist() == [[False] * 3, [True] * 3, [False, True, True], [True] * 3]
    assert SPIRAL.chain(np.empty(0), [1.65]).shape == (0, 2)


# From two turns out, where a fifth of a pitch aside is still on the same side of the centre.
@given(st.floats(4 * np.pi, 300), st.floats(-2.7, 2.7), st.floats(-0.2, 0.2))
def test_foot_of_a_point_beside_the_path_is_on_the_turn_nearest_to_the_guess(theta, off, aside):
    s = place(theta)
    point = SPIRAL.point(s)
    beside = point + aside * PITCH * point / np.linalg.norm(point)
    found, at, tangent = SPIRAL.foot(beside, place(theta + off))
    assert float(found) == pytest.approx(s, abs=1e-10)
    assert at == pytest.approx(point, abs=1e-11)
    assert tangent == pytest.approx(SPIRAL.tangent(s), abs=1e-11)
    # One of many points has the same foot.
    together = SPIRAL.foot(np.stack([point, beside]), np.array([s, place(theta + off)]))
    for part, alone in zip(together, (found, at, tangent), strict=True):
        assert part[1] == pytest.approx(alone, rel=0, abs=1e-15)
