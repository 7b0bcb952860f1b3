"""Lines, arcs, parts of curves, curves joined end to begin, u-turns, and curves of a user's own."""

import math

import mpmath as mp
import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says, refusal
from exact_curves import DIGITS, arc, line, s_turn, spiral, spline, u_turn, worst_errors
from hypothesis import assume, example, given
from hypothesis import strategies as st

from pymunk_dragon import (
    Arc,
    Composite,
    Curve,
    Line,
    Reversed,
    Sampled,
    Section,
    Spiral,
    UTurn,
    check_curve,
)
from pymunk_dragon.errors import ParameterError

LINE = Line(start=(-3.5, 2.25), stop=(40.0, -7.0))
ARC = Arc(centre=(1.5, -20.0), radius=7.3, begin_angle=0.4, sweep=-9.1)
# A stadium's half and a bit: straight, round to the left, straight, round to the right.
PATH = Composite(
    [
        Line(stop=(10, 0)),
        Arc(centre=(10, 3), radius=3, begin_angle=-math.pi / 2, sweep=math.pi),
        Line(start=(10, 6), stop=(4, 6)),
        Arc(centre=(4, 8), radius=2, begin_angle=-math.pi / 2, sweep=-math.pi / 2),
    ]
)
WAVE = np.stack([np.linspace(0, 20, 60), 3 * np.sin(np.linspace(0, 20, 60))], axis=-1)
CORNERS = [
    (0, 0),
    (1, 0.2),
    (3.5, -1),
    (4, 2),
    (3.2, 2.1),
    (3, 7),
    (9, 7.5),
    (8, 3),
    (20, 1),
    (21, 1.1),
    (21.5, -3),
]
LONGER = Composite([PATH, Line(start=(2, 8), stop=(2, 9))])
# Rounding puts its last parameter beyond the end of its last piece.
HAIRPIN = Composite(
    [
        Line(stop=(30, 0)),
        Arc(centre=(30, 2), radius=2, begin_angle=-math.pi / 2, sweep=math.pi),
        Line(start=(30, 4), stop=(-18, 4)),
    ]
)


class LogarithmicSpiral(Curve):
    """A curve of a user's own: r = s / sqrt(2), outward from a metre of arc length on."""

    begin_s = 1.0
    end_s = np.inf

    def __repr__(self):
        return "LogarithmicSpiral()"

    def point(self, s):
        s = self._on(s)
        return s[..., None] / np.sqrt(2) * np.stack([np.cos(np.log(s)), np.sin(np.log(s))], axis=-1)

    def tangent(self, s):
        angle = np.log(self._on(s)) + np.pi / 4
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def curvature(self, s):
        return 1 / self._on(s)

    def max_curvature(self, s, other):
        upper = np.maximum(s, other)
        return np.where(upper >= 1, 1 / np.maximum(np.minimum(s, other), 1), 0)

    def _on(self, s):
        return np.where(np.asarray(s) >= 1, s, np.nan)


CURVES = [
    LINE,
    ARC,
    Reversed(LINE),
    PATH,
    LONGER,
    HAIRPIN,
    UTurn(),
    Reversed(UTurn(ratio=0.7)),
    LogarithmicSpiral(),
]
CURVES += [Composite([Section(LogarithmicSpiral(), 1, 50)]), Sampled(WAVE), Sampled(CORNERS)]
PARTS = [
    (Spiral(), -500, -1),
    (Spiral(pitch=1.7, rotation=2, outward=True), 1, 500),
    (Section(Spiral(), -400, -20), -400, -20),
    (Section(Spiral(), -math.inf, -20), -400, -20),
    (Reversed(Spiral()), 1, 300),
]


@pytest.mark.parametrize(
    "arguments", [*((curve,) for curve in CURVES), *PARTS], ids=lambda part: repr(part[0])[:40]
)
def test_curve_is_consistent_in_itself(arguments):
    check_curve(*arguments)


@pytest.mark.parametrize(
    ("curve", "truth"),
    [
        (LINE, line((-3.5, 2.25), (40.0, -7.0))),
        (ARC, arc((1.5, -20.0), 7.3, 0.4, -9.1)),
        (Spiral(pitch=0.021), spiral(0.021)),
        (Spiral(pitch=0.5, rotation=1.3, outward=True), spiral(0.5, 1.3, outward=True)),
        (Spiral(pitch=1.7, rotation=-2.5), spiral(1.7, -2.5)),
        *(
            (UTurn(pitch=pitch, radius=radius, ratio=ratio), u_turn(pitch, radius, ratio))
            for pitch, radius, ratio in (
                (1.7, 4.5, 2.0),
                (0.55, 3.0, 0.3),
                (2.5, 7.0, 4.0),
                (0.7, 20.0, 1.0),
            )
        ),
    ],
    ids=[
        "line",
        "arc",
        "inward",
        "outward",
        "turned",
        "turn",
        "narrow turn",
        "wide turn",
        "large turn",
    ],
)
def test_points_are_right_to_8_last_digits_of_the_largest_coordinate(curve, truth):
    """The certificate of a first contact rests on this (`collision/bounds.py`)."""
    rng = np.random.default_rng(0)
    ends = [
        end
        for piece in getattr(curve, "pieces", [])
        for end in (piece.begin_s, piece.end_s)
        if np.isfinite(end)
    ]
    places = np.concatenate(
        [rng.uniform(-1, 1, 60) * reach for reach in (3, 30, 300, 3000, 30_000)]
    )
    places = places[(places > curve.begin_s) & (places < curve.end_s)]
    with mp.workdps(DIGITS):
        for place, found in zip(places.tolist(), curve.point(places).tolist(), strict=True):
            x, y = truth(mp.mpf(place))[:2]
            error = mp.hypot(x - mp.mpf(found[0]), y - mp.mpf(found[1]))
            # Closer to a spiral's centre than 0.1 m, rounding is that of its angle.
            assert error < 8 * np.spacing(np.abs([0.1, place, *found, *ends]).max())
    near = [s for s in (-1e-9, 1e-9) if curve.begin_s < s < curve.end_s]
    assert max(worst_errors(curve, truth, [*near, *places[:30]])) < 1e-12


def test_impossible_curves_are_refused_by_the_name_of_the_parameter():
    points = np.stack([np.arange(6.0), np.zeros(6)], axis=-1)

    def path_with(row, point):
        return Sampled([*points[:row], point, *points[row + 1 :]])

    for make, name, bound, values in (
        (lambda value: Line(stop=value), "stop", "m", [(0, 0), (0, 1e-4), (math.nan, 1), (1e6, 1)]),
        (lambda value: Line(stop=value), "stop", "m", [3, "ab", (1, 2, 3), [[], 0]]),
        (lambda value: Line(start=value, stop=(1, 1)), "start", "m", [(math.inf, 0), None]),
        (lambda value: Arc(radius=value, sweep=1), "radius", "0.001 to 100000 m", NO_NUMBERS),
        (lambda value: Arc(radius=1, sweep=value), "sweep", "rad", [0, 1e-12, math.nan, 1e5, "1"]),
        (lambda value: UTurn(pitch=value), "pitch", "0.001 to 1000 m", NO_NUMBERS),
        (lambda value: UTurn(radius=value), "radius", "0.1 to 100 m", NO_NUMBERS),
        (lambda value: UTurn(ratio=value), "ratio", "0.02 to 50", NO_NUMBERS),
        (
            lambda value: Spiral(pitch=value),
            "pitch",
            "0.001 to 1000 m",
            [*NO_NUMBERS, 1e-9, 1000.001, 1e308],
        ),
        (
            lambda value: Spiral(rotation=value),
            "rotation",
            "-1000 to 1000 rad",
            [math.nan, 10**400, "1", True, 1j],
        ),
        (lambda value: Spiral(outward=value), "outward", "True or False", [1]),
        (lambda value: Section(LINE, value, 5), "begin_s", "m", [-1, math.nan]),
        (lambda value: Section(LINE, 3, value), "end_s", "m", [3, math.inf]),
        (lambda value: Section(value, 0, 1), "curve", "Curve", [3]),
        (Reversed, "curve", "Curve", [3]),
        (Composite, "pieces", "Curve", [[], None, 3, LINE, "ab", [LINE, None], np.array(1)]),
        # Their inner ends are not finite.
        (
            Composite,
            "pieces",
            "piece 1",
            [[Spiral(outward=True), LINE], [LINE, Spiral()], [UTurn(), UTurn()]],
        ),
        (
            Sampled,
            "points",
            "",
            [None, 3, "abc", [], points[:3], [(0, 0, 0)] * 5, np.zeros((60_000, 2))],
        ),
        (
            Sampled,
            "points",
            "",
            [[(0, 0), (1,), (2, 2), (3, 3)], [(0, 0), (1, "x"), (2, 2), (3, 3)]],
        ),
        (
            lambda value: path_with(2, value),
            "point 3",
            "100000 m",
            [(math.nan, 0), (0, math.inf), (0, 2e5)],
        ),
        (lambda value: path_with(3, value), "point 4", "0.001 m", [(2, 0)]),
        # The path would nearly stop there.
        (lambda value: path_with(3, value), "point 1", "cusp", [(1, 0)]),
    ):
        for value in values:
            error = refusal(make, value)
            assert error.name == name, value
            assert bound in error.bound, value


def test_pieces_have_to_meet_without_gap_and_kink():
    for gap, angle in ((9e-10, 0), (0, 9e-10), (1.2e-9, 0), (0, 1.2e-9), (0, math.pi)):
        after = Line(start=(2, gap), stop=(2 + math.cos(angle), gap + math.sin(angle)))
        pieces = [Line(stop=(1, 0)), Line(start=(1, 0), stop=(2, 0)), after]
        if max(gap, angle) < 1e-9:
            Composite(pieces)
        else:
            assert_says(
                refusal(Composite, pieces),
                "joint 2",
                f"{gap:.3g} m",
                f"{math.degrees(angle):.3g} degrees",
            )


def test_composite_begins_at_0_and_bends_as_its_pieces():
    assert (PATH.begin_s, PATH.joints) == (0, (10, 10 + 3 * math.pi, 16 + 3 * math.pi))
    # But where the piece from infinity ends, if there is one.
    assert (UTurn().begin_s, UTurn().joints[0]) == (-math.inf, 0)
    shifted = Composite([Section(LINE, 5, 8)])
    assert (shifted.begin_s, shifted.end_s) == (0, 3)
    assert shifted.point(0).tolist() == LINE.point(5).tolist()
    # At a joint the curvature is that of the later piece.
    assert PATH.curvature(PATH.joints).tolist() == [1 / 3, 0, -1 / 2]
    bounds = PATH.max_curvature([0, 0, 0, 21, 11, 10], [9, 11, PATH.end_s, 22, 12, 9])
    assert bounds.tolist() == [0, 1 / 3, 1 / 2, 0, 1 / 3, 1 / 3]


def test_u_turn_is_the_one_that_tangency_demands():
    for sizes in ((1.7, 4.5, 2.0), (1.7, 4.5, 0.3), (0.55, 8.0, 1.0), (3, 1, 5)):
        turn = UTurn(pitch=sizes[0], radius=sizes[1], ratio=sizes[2])
        with mp.workdps(DIGITS):
            radii, centres, sweeps, points, length = s_turn(*map(mp.mpf, sizes))
            expected = [
                *radii,
                *(part for z in (*centres, *points) for part in (z.real, z.imag)),
                *sweeps,
                length,
            ]
        found = [
            *turn.radii,
            *turn.centres.ravel(),
            *turn.tangent_points.ravel(),
            *turn.sweeps,
            turn.length,
        ]
        assert found == pytest.approx([float(value) for value in expected], abs=1e-12)
    for sizes in (
        (0.1, 100, 0.02),
        (1000, 100, 50),
        (1000, 0.1, 50),
        (0.001, 0.1, 50),
        (0.001, 1, 2),
    ):
        turn = UTurn(pitch=sizes[0], radius=sizes[1], ratio=sizes[2])
        assert np.isfinite(turn.point(turn.joints)).all(), sizes


# From two turns out, where a fifth of a pitch aside is still on the same side of the centre.
@given(st.floats(4 * np.pi, 300), st.floats(-2.7, 2.7), st.floats(-0.2, 0.2))
def test_foot_of_a_point_beside_a_spiral_is_on_the_turn_nearest_to_the_guess(theta, off, aside):
    spiral = Spiral()
    s, guess = (spiral.at_turn(angle / (2 * np.pi)) for angle in (theta, theta + off))
    point = spiral.point(s)
    beside = point + aside * spiral.pitch * point / np.linalg.norm(point)
    found, at, tangent = spiral.foot(np.stack([point, beside]), np.array([s, guess]))
    assert found == pytest.approx([s, s], abs=1e-10)
    assert at == pytest.approx(np.stack([point, point]), abs=1e-11)
    assert tangent == pytest.approx(spiral.tangent([s, s]), abs=1e-11)


# Smooth paths through points


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
