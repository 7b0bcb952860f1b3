"""The equations of rigid chains against finite differences of positions, on curves of several kinds."""

import numpy as np
import pytest

from pymunk_dragon import Arc, Composite, Line, Sampled, Spiral, UTurn
from pymunk_dragon.model import chain

SPACINGS = np.array([2.86, 1.65, 1.65, 1.2])
# Curves with a coordinate of the head, m, at which all handles are on one piece.
CURVES = {
    "line": (Line(stop=(40, 5)), 20.0),
    "arc": (Arc(radius=6, sweep=-5), 20.0),
    "spiral": (Spiral(), Spiral().at_turn(5)),
    "outward spiral": (Spiral(pitch=1.7, outward=True), 120.0),
    "spline": (Sampled([(0, 0), (10, 3), (20, -2), (30, 4), (40, 0)]), 25.0),
    "u-turn": (UTurn(), 1.0),
}
# m of the head: central differences lose as much to rounding as to curvature.
STEP = 1e-4
on_every_curve = pytest.mark.parametrize(("curve", "head"), CURVES.values(), ids=CURVES)


def bench_angles(curve, heads):
    """Coordinates of the handles (T, H), and e^(i alpha), e^(i beta) of the benches (T, N)."""
    handles_s = curve.chain(heads, SPACINGS)
    return handles_s, *chain.angles(*curve.frame(handles_s), SPACINGS)


@on_every_curve
def test_velocity_ratios_and_angular_rates_are_the_derivatives_of_coordinates_and_angles(curve, head):
    handles_s, front, rear = bench_angles(curve, np.array([head - STEP, head, head + STEP]))
    expected = (handles_s[2] - handles_s[0]) / (2 * STEP)
    np.testing.assert_allclose(chain.velocity_ratios(front.real, rear.real)[1], expected, atol=1e-7)
    points = curve.point(handles_s)
    heading = np.unwrap(np.arctan2(*np.moveaxis(points[:, :-1] - points[:, 1:], -1, 0)[::-1]), axis=0)
    expected = (heading[2] - heading[0]) / (handles_s[2, :-1] - handles_s[0, :-1])
    np.testing.assert_allclose(chain.angular_rates(front, rear, SPACINGS)[1], expected, atol=1e-7)


@on_every_curve
def test_bounds_hold_for_the_rates_and_their_changes(curve, head):
    """With the curvature's own bound; the changes are differences between heads a step apart."""
    handles_s, front, rear = bench_angles(curve, head + np.linspace(-0.5, 0.5, 201))
    ratio, omega = front.real / rear.real, chain.angular_rates(front, rear, SPACINGS)
    curvature = curve.max_curvature(handles_s[:, 1:].min(axis=0), handles_s[:, :-1].max(axis=0))
    sines = np.abs(front.imag).max(axis=0), np.abs(rear.imag).max(axis=0)
    bounds = chain.rate_bounds(sines, np.abs(ratio).max(axis=0), rear.real.min(axis=0), curvature, SPACINGS)
    along = np.diff(handles_s[:, :-1], axis=0)
    for measured, bound in (
        (ratio, bounds.ratio),
        (np.diff(ratio, axis=0) / along, bounds.ratio_change),
        (omega, bounds.omega),
        (np.diff(omega, axis=0) / along, bounds.omega_change),
    ):
        assert (np.abs(measured) <= bound + 1e-9).all()


@on_every_curve
def test_whole_chains_are_those_laid_out_bench_by_bench(curve, head):
    heads, spacings = head + np.linspace(-0.9, 0.9, 41), np.tile(SPACINGS, 2)
    motion, succeeded = chain._whole_chains(curve, heads, spacings)
    assert succeeded.all()
    expected = chain._bench_by_bench(curve, heads, spacings)
    np.testing.assert_allclose(motion.handles_s, expected, rtol=0, atol=1e-11)
    for part, other in zip(motion, chain.chain_motion(curve, expected, spacings), strict=True):
        np.testing.assert_allclose(part, other, rtol=0, atol=1e-11)


def test_whole_chains_never_end_on_another_turn(monkeypatch):
    """From an estimate on another turn Newton's method finds other handles at the same distances: they are refused."""
    spiral = Spiral(pitch=0.3)
    heads, spacings = np.array([spiral.at_turn(turns) for turns in (3, 5, 9)]), np.array([1.65, 1.65])
    expected, near = (
        chain._bench_by_bench(spiral, heads, spacings),
        spiral._estimate(heads, spiral._parameter(heads), spacings[:, None]),
    )
    for back in (0.3, 0.5, 0.99, 1.0, 1.01, 2.0):
        estimate = near - back * 2 * np.pi * np.array([[0], [1], [1]])
        monkeypatch.setattr(Spiral, "_estimate", lambda self, *arguments, estimate=estimate: estimate.copy())
        found, succeeded = chain._whole_chains(spiral, heads, spacings)
        np.testing.assert_allclose(found.handles_s[succeeded], expected[succeeded], rtol=0, atol=1e-11)
        np.testing.assert_allclose(spiral.chain(heads, spacings), expected, rtol=0, atol=1e-11)


def test_chains_that_cannot_be_computed_as_a_whole_are_computed_bench_by_bench():
    """A bench across a hairpin is nearly perpendicular to the path, and one before the path's begin has no handle."""
    hairpin = Composite([Line(stop=(10, 0)), Arc(centre=(10, 0.6), radius=0.6, begin_angle=-np.pi / 2, sweep=np.pi)])
    heads, spacings = np.linspace(1.0, hairpin.end_s, 60), np.array([1.1, 0.9])
    _, succeeded = chain._whole_chains(hairpin, heads, spacings)
    assert 0 < succeeded.sum() < heads.size
    expected = chain._bench_by_bench(hairpin, heads, spacings)
    np.testing.assert_allclose(hairpin.chain(heads, spacings), expected, rtol=0, atol=1e-11)
    assert np.isnan(expected).any()
