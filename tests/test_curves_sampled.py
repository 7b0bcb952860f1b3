"""A smooth path through points: held against the same spline in many digits, and against circles."""

import mpmath as mp
import numpy as np
import pytest
from exact_curves import DIGITS, spline, worst_errors
from hypothesis import assume, example, given
from hypothesis import strategies as st
from test_curve_kinds import CORNERS, WAVE

from pymunk_dragon import Line, ParameterError, Sampled


@pytest.mark.parametrize(
    ("points", "places"),
    [
        (CORNERS[:6], 4),
        pytest.param(CORNERS, 8, marks=pytest.mark.thorough),
        pytest.param(np.add(WAVE[:7], 300), 6, marks=pytest.mark.thorough),
    ],
    ids=["few corners", "corners", "far out"],
)
def test_path_is_the_spline_to_the_last_digits(points, places):
    path = Sampled(points)
    truth, length = spline(points)
    with mp.workdps(DIGITS):
        assert abs(float(mp.mpf(path.end_s) / length - 1)) < 1e-13
    assert max(worst_errors(path, truth, np.linspace(0, path.end_s, places)[:-1])) < 1e-12


def test_path_through_points_of_a_line_is_the_line():
    line = Line(start=(3, 4), stop=(-50, 60))
    path = Sampled(line.point(line.end_s * np.array([0, 0.1, 0.15, 0.5, 0.8, 1])))
    s = np.linspace(0, 70, 50)
    assert path.point(s) == pytest.approx(line.point(s), abs=1e-12)
    assert path.end_s == pytest.approx(line.end_s, rel=1e-15)
    assert path.max_curvature(0, 70) < 1e-12


headings = st.lists(st.tuples(st.floats(0.1, 3), st.floats(-1.5, 1.5)), min_size=4, max_size=12)


@given(headings, st.integers(0, 1000), st.integers(0, 1000))
@example([(1.0, 0.0)] * 5, 0, 1000)
@example([(0.1, 1.5), (3.0, -1.5), (0.1, 1.5), (3.0, -1.5)], 0, 1000)
def test_bound_on_the_bends_is_above_all_of_them_and_not_far_above(steps, first, last):
    ways, turns = np.transpose(steps)
    walk = np.cumsum(ways * np.exp(1j * np.cumsum(turns)))
    try:
        path = Sampled(np.stack([walk.real, walk.imag], axis=-1))
    except ParameterError as error:
        assume("nearly stops" not in str(error))
        raise
    s = np.linspace(0, path.end_s, 1001)
    low, high = s[min(first, last)], s[max(first, last)]
    bends = np.abs(path.curvature(np.linspace(low, high, 3001)))
    assert path.max_curvature(low, high) >= bends.max()
    everywhere = np.abs(path.curvature(np.linspace(0, path.end_s, 60_001))).max()
    assert path.max_curvature(0, path.end_s) <= 1.03 * everywhere + 1e-12
