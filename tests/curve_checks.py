"""What every curve has to keep, checked from outside: for the curves of the suite, and for one of your own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pymunk_dragon.model.curves import Curve

# m. Central differences over it are off by its square, and rounding by a double's last digit over it.
STEP = 1e-4
# Of a unit vector, and of a curvature times a metre, for coordinates of some 100 m and a radius of 1 m.
TOLERANCE = 3e-7
# m beyond an end that are no rounding.
BEYOND = 1e-6
PLACES = 2001
# Share of a bound: what is found together with other places may differ from what is found alone by its last digits.
ROUNDING = 1e-12


def assert_is_a_curve(
    curve: Curve, low: float, high: float, joints: Sequence[float] = (), *, tolerance: float = TOLERANCE
) -> None:
    """Check a curve between two places, both within its ends, and what it says beyond its ends.

    Points must have the tangent as their derivative, and tangents the curvature, but for `joints` where that jumps;
    `max_curvature` must be above all curvatures; shapes must follow those of the places; beyond the ends is nan.
    """
    assert isinstance(curve, Curve)
    assert curve.begin_s <= low < high <= curve.end_s
    s = np.linspace(low, high, PLACES)
    _check_derivatives(curve, s, joints, tolerance)
    _check_max_curvature(curve, s)
    _check_shapes(curve, s)
    _check_ends(curve, low, high)


def _check_derivatives(curve, s, joints, tolerance):
    inner = s[(s - STEP >= curve.begin_s) & (s + STEP <= curve.end_s)]
    for joint in joints:
        inner = inner[np.abs(inner - joint) > 2 * STEP]
    tangents, bends = curve.tangent(inner), curve.curvature(inner)
    assert np.abs(np.hypot(*tangents.T) - 1).max() < 1e-14
    moved = (curve.point(inner + STEP) - curve.point(inner - STEP)) / (2 * STEP)
    size = 1 + np.abs(bends).max() ** 2
    assert np.abs(moved - tangents).max() < tolerance * size
    turned = (curve.tangent(inner + STEP) - curve.tangent(inner - STEP)) / (2 * STEP)
    normals = np.stack([-tangents[:, 1], tangents[:, 0]], axis=-1)
    assert np.abs(turned - bends[:, None] * normals).max() < tolerance * size**1.5


def _check_max_curvature(curve, s):
    bends = np.abs(curve.curvature(s))
    starts = np.arange(0, s.size, 7)
    for width in (0, 1, 2, 5, 40, s.size // 3, s.size):
        stops = np.minimum(starts + width, s.size - 1)
        bound = curve.max_curvature(s[starts], s[stops])
        assert np.all(bound == curve.max_curvature(s[stops], s[starts]))
        assert np.all(bound * (1 + ROUNDING) >= [bends[a : b + 1].max() for a, b in zip(starts, stops, strict=True)])


def _check_shapes(curve, s):
    grid = s[:6].reshape(2, 3)
    for method, tail in ((curve.point, (2,)), (curve.tangent, (2,)), (curve.curvature, ())):
        assert method(grid).shape == (2, 3, *tail)
        assert method(np.empty((0, 4))).shape == (0, 4, *tail)
        # One by one, in a list, and in any order: the same, to rounding.
        assert np.allclose(method(s[::-37].tolist()), np.array([method(place) for place in s[::-37]]), 0, 1e-12)
    assert curve.max_curvature(s[:3], s[:2, None]).shape == (2, 3)


def _check_ends(curve, low, high):
    for place in (curve.begin_s, curve.end_s):
        if np.isfinite(place):
            assert np.isfinite(curve.point(place)).all()
            assert np.isfinite(curve.tangent(place)).all()
            assert np.isfinite(curve.curvature(place))
    outside = [np.nan]
    if np.isfinite(curve.begin_s):
        before = curve.begin_s - np.array([BEYOND, 1.0, 1e9, np.inf])
        outside += before.tolist()
        assert curve.max_curvature(before[0], before[2]) == 0
        assert np.isclose(curve.max_curvature(before[1], high), curve.max_curvature(curve.begin_s, high), ROUNDING, 0)
    if np.isfinite(curve.end_s):
        after = curve.end_s + np.array([BEYOND, 1.0, 1e9, np.inf])
        outside += after.tolist()
        assert curve.max_curvature(after[0], after[2]) == 0
        assert np.isclose(curve.max_curvature(low, after[1]), curve.max_curvature(low, curve.end_s), ROUNDING, 0)
    mixed = np.array([*outside, low, high])
    for method in (curve.point, curve.tangent, curve.curvature):
        answer = method(mixed)
        assert np.isnan(answer[: len(outside)]).all()
        assert np.isfinite(answer[len(outside) :]).all()
