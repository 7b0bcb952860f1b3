"""The spiral by itself: arc length, places, and the nearest place a chord back."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import examples
from hypothesis import example, given
from hypothesis import strategies as st

from pymunk_dragon.model.curves import Reversed, Spiral

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


def test_nothing_lies_beyond_the_centre_and_the_way_out_is_the_way_in_travelled_back():
    for spiral in (SPIRAL, Spiral(pitch=1.7, rotation=2.5, mirrored=True, outward=True)):
        beyond = (-1 if spiral.outward else 1) * np.array([1e-300, 1.0, 1e6])
        for method in (spiral.point, spiral.tangent, spiral.curvature, spiral.angle):
            assert np.isnan(method(beyond)).all()
        assert spiral.point(0.0).tolist() == [0, 0]
    back, s = Reversed(Spiral(outward=True)), np.linspace(-400, 0, 50)
    assert (back.begin_s, back.end_s) == (-np.inf, 0)
    for name in ("point", "tangent", "curvature"):
        assert getattr(back, name)(s) == pytest.approx(getattr(SPIRAL, name)(s), abs=1e-15)
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
    # The scan knows the height of the top to a few parts in 1e8. Next to the centre it grows over more than a turn.
    if share > 1 + 1e-7 and top < SCAN.size - 1:
        assert np.isnan(back)
    if share < 1 - 1e-7:
        assert 0 < back <= 2 * np.pi + 1e-12
        here, there = SPIRAL.point(SPIRAL.chain([place(theta)], [chord])[0])
        # A chain is accepted where chords are right to 64 last digits of a place.
        resolution = np.spacing(-place(theta + back))
        assert np.linalg.norm(here - there) == pytest.approx(chord, rel=1e-13, abs=64 * resolution)
        earlier = distances[: np.searchsorted(SCAN, back - 1e-9)]
        assert np.all(earlier < chord * (1 + 1e-12))
        assert back <= SCAN[top] + 1e-12


def test_a_chain_without_a_place_for_one_handle_has_none_for_those_behind():
    places = SPIRAL.chain([place(50.0), np.nan, place(2.0), 1.0], [1.65, 1.65])
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
