"""Lines, arcs, parts of curves, curves joined end to begin, and curves of a user's own."""

from __future__ import annotations

import math
import pickle

import mpmath as mp
import numpy as np
import pytest
from conftest import NO_NUMBERS, assert_says
from curve_checks import assert_is_a_curve
from exact_curves import DIGITS, arc, line, s_turn, spiral, u_turn, worst_errors
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import Arc, Composite, Curve, Line, Reversed, Section, Spiral, UTurn

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


class LogarithmicSpiral(Curve):
    """A user's own: r = s / sqrt(2), from a metre of arc length from its centre on, travelled outward."""

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


def logarithmic(s):
    """Its truth."""
    angle = mp.log(s)
    x, y = s / mp.sqrt(2) * mp.cos(angle), s / mp.sqrt(2) * mp.sin(angle)
    return x, y, mp.cos(angle + mp.pi / 4), mp.sin(angle + mp.pi / 4), 1 / s


LONGER = Composite([PATH, Line(start=(2, 8), stop=(2, 9))])
KINDS = {
    "line": (LINE, 0, LINE.end_s),
    "arc": (ARC, 0, ARC.end_s),
    "spiral": (Spiral(), -500, -1),
    "spiral outward": (Spiral(pitch=1.7, rotation=2, outward=True), 1, 500),
    "section": (Section(Spiral(), -400, -20), -400, -20),
    "section from infinity": (Section(Spiral(), -math.inf, -20), -400, -20),
    "reversed line": (Reversed(LINE), -LINE.end_s, 0),
    "reversed spiral": (Reversed(Spiral()), 1, 300),
    "composite": (PATH, 0, PATH.end_s, PATH.joints),
    "composite of one": (Composite([ARC]), 0, ARC.end_s),
    "composite of composites": (LONGER, 0, LONGER.end_s, [*PATH.joints, PATH.end_s]),
    "u-turn": (UTurn(), -100, 100, UTurn().joints),
    "reversed u-turn": (Reversed(UTurn(ratio=0.7)), -100, 100, [-joint for joint in UTurn(ratio=0.7).joints]),
    "a user's own": (LogarithmicSpiral(), 1, 200),
    "a user's own, in a composite": (Composite([Section(LogarithmicSpiral(), 1, 50)]), 0, 49),
}


@pytest.mark.parametrize("kind", KINDS)
def test_curve_is_consistent_in_itself(kind):
    assert_is_a_curve(*KINDS[kind])


@pytest.mark.parametrize(
    ("curve", "truth"),
    [
        (LINE, line((-3.5, 2.25), (40.0, -7.0))),
        (ARC, arc((1.5, -20.0), 7.3, 0.4, -9.1)),
        (Section(Reversed(ARC), -ARC.end_s, -1.0), lambda s: turned_back(arc((1.5, -20.0), 7.3, 0.4, -9.1), s)),
        (Section(LogarithmicSpiral(), 1.0, 300.0), logarithmic),
    ],
    ids=["line", "arc", "reversed arc", "logarithmic spiral"],
)
def test_curve_is_exact(curve, truth):
    places = np.linspace(curve.begin_s, curve.end_s, 41)
    assert max(worst_errors(curve, truth, places)) < 1e-12


def _u_turn(*sizes):
    return UTurn(**dict(zip(("pitch", "radius", "ratio"), sizes, strict=True))), u_turn(*sizes)


@pytest.mark.parametrize(
    ("curve", "truth"),
    [
        (LINE, line((-3.5, 2.25), (40.0, -7.0))),
        (ARC, arc((1.5, -20.0), 7.3, 0.4, -9.1)),
        (Spiral(pitch=0.021), spiral(0.021)),
        (Spiral(pitch=0.5, rotation=1.3, outward=True), spiral(0.5, 1.3, outward=True)),
        _u_turn(1.7, 4.5, 2.0),
        _u_turn(0.55, 3.0, 0.3),
        _u_turn(2.5, 7.0, 4.0),
        _u_turn(0.7, 20.0, 1.0),
    ],
    ids=["line", "arc", "inward", "outward", "turn", "narrow turn", "wide turn", "large turn"],
)
def test_points_are_right_to_8_last_digits_of_the_largest_coordinate(curve, truth):
    """The certificate of a first contact rests on this (`collision/bounds.py`)."""
    rng = np.random.default_rng(0)
    ends = [end for piece in getattr(curve, "pieces", []) for end in (piece.begin_s, piece.end_s) if np.isfinite(end)]
    places = np.concatenate([rng.uniform(-1, 1, 60) * reach for reach in (3, 30, 300, 3000)])
    places = places[(places > curve.begin_s) & (places < curve.end_s)]
    with mp.workdps(DIGITS):
        for place, found in zip(places.tolist(), curve.point(places).tolist(), strict=True):
            x, y = truth(mp.mpf(place))[:2]
            error = mp.hypot(x - mp.mpf(found[0]), y - mp.mpf(found[1]))
            assert error < 8 * np.spacing(np.abs([place, *found, *ends]).max())


def turned_back(truth, s):
    x, y, dx, dy, bend = truth(-s)
    return x, y, -dx, -dy, -bend


def test_composite_is_exact():
    pieces = [
        line((0, 0), (10, 0)),
        lambda s: arc((10, 3), 3, -mp.pi / 2, 1)(s - 10),
        lambda s: line((10, 6), (4, 6))(s - 10 - 3 * mp.pi),
        lambda s: arc((4, 8), 2, -mp.pi / 2, -1)(s - 16 - 3 * mp.pi),
    ]

    def truth(s):
        return pieces[sum(s >= joint for joint in (10, 10 + 3 * mp.pi, 16 + 3 * mp.pi))](s)

    assert max(worst_errors(PATH, truth, np.linspace(0, PATH.end_s, 50))) < 1e-12


@pytest.mark.parametrize(
    "line",
    [
        {"stop": (0, 0)},
        {"stop": (0, 1e-4)},
        {"stop": (math.nan, 1)},
        {"stop": (1e6, 1)},
        {"stop": 3},
        {"stop": "ab"},
        {"stop": (1, 2, 3)},
        {"start": (math.inf, 0), "stop": (1, 1)},
        {"start": None, "stop": (1, 1)},
    ],
    ids=repr,
)
def test_impossible_lines_are_refused(line):
    with pytest.raises(ParameterError) as caught:
        Line(**line)
    assert caught.value.name == ("start" if "start" in line else "stop")
    assert_says(caught.value, "must be")


@pytest.mark.parametrize("radius", NO_NUMBERS, ids=repr)
def test_impossible_radii_are_refused(radius):
    with pytest.raises(ParameterError) as caught:
        Arc(radius=radius, sweep=1)
    assert_says(caught.value, "radius is", "from 0.001 to 100000 m")


@pytest.mark.parametrize("sweep", [0, 1e-12, -1e-12, math.nan, 1e5, "1"], ids=repr)
def test_impossible_sweeps_are_refused(sweep):
    with pytest.raises(ParameterError) as caught:
        Arc(radius=1, sweep=sweep)
    assert_says(caught.value, "sweep is", "rad")


def test_arc_goes_round_more_than_once():
    assert Arc(radius=2, sweep=5 * math.pi).point(4 * math.pi) == pytest.approx([2, 0], abs=1e-14)


@pytest.mark.parametrize(
    ("begin", "end", "name"),
    [
        (-1, 5, "begin_s"),
        (3, 3, "end_s"),
        (3, 2, "end_s"),
        (0, 100, "end_s"),
        (-math.inf, 5, "begin_s"),
        (0, math.inf, "end_s"),
        (math.nan, 5, "begin_s"),
        (0, math.nan, "end_s"),
        ("0", 5, "begin_s"),
    ],
)
def test_section_lies_on_its_curve(begin, end, name):
    with pytest.raises(ParameterError) as caught:
        Section(LINE, begin, end)
    assert caught.value.name == name
    assert_says(caught.value, "a coordinate on the curve")


@pytest.mark.parametrize("make", [Reversed, lambda curve: Section(curve, 0, 1), lambda curve: Composite([LINE, curve])])
def test_what_is_no_curve_is_refused(make):
    with pytest.raises(ParameterError, match="Curve"):
        make(3)


def test_section_keeps_the_places_of_its_curve():
    part = Section(LINE, 5, 8)
    assert part.point(6.5).tolist() == LINE.point(6.5).tolist()
    assert np.isnan(part.point([4.99, 8.01])).all()


def test_reversed_twice_is_the_curve_itself():
    s = np.linspace(0, ARC.end_s, 20)
    again = Reversed(Reversed(ARC))
    assert (again.begin_s, again.end_s) == (0, ARC.end_s)
    assert again.tangent(s).tolist() == ARC.tangent(s).tolist()
    assert again.curvature(s).tolist() == ARC.curvature(s).tolist()


def test_composite_begins_at_0_or_where_the_piece_from_infinity_ends():
    assert (PATH.begin_s, PATH.joints) == (0, (10, 10 + 3 * math.pi, 16 + 3 * math.pi))
    turn = UTurn()
    assert turn.begin_s == -math.inf
    assert turn.joints[0] == 0
    shifted = Composite([Section(LINE, 5, 8)])
    assert (shifted.begin_s, shifted.end_s) == (0, 3)
    assert shifted.point(0).tolist() == LINE.point(5).tolist()


def test_at_a_joint_the_curvature_is_that_of_the_later_piece():
    assert PATH.curvature(PATH.joints).tolist() == [1 / 3, 0, -1 / 2]


def test_bound_on_the_bends_is_that_of_the_pieces_between():
    bounds = PATH.max_curvature([0, 0, 0, 21, 11, 10], [9, 11, PATH.end_s, 22, 12, 9])
    assert bounds.tolist() == [0, 1 / 3, 1 / 2, 0, 1 / 3, 1 / 3]


@pytest.mark.parametrize(
    ("gap", "angle", "fits"),
    [(0, 0, True), (9e-10, 0, True), (0, 9e-10, True), (1.2e-9, 0, False), (0, 1.2e-9, False), (0, math.pi, False)],
)
def test_pieces_have_to_meet_without_gap_and_kink(gap, angle, fits):
    after = Line(start=(2, gap), stop=(2 + math.cos(angle), gap + math.sin(angle)))
    pieces = [Line(stop=(1, 0)), Line(start=(1, 0), stop=(2, 0)), after]
    if fits:
        Composite(pieces)
        return
    with pytest.raises(ParameterError) as caught:
        Composite(pieces)
    assert caught.value.name == "pieces"
    words = f"{gap:.3g} m and {angle:.3g} rad ({math.degrees(angle):.3g} degrees) apart"
    assert_says(caught.value, "at joint 2 piece 2 (Line) and piece 3 (Line) are", words)


@pytest.mark.parametrize("pieces", [[], None, 3, LINE, "ab", [LINE, None]], ids=repr)
def test_composite_needs_curves(pieces):
    with pytest.raises(ParameterError) as caught:
        Composite(pieces)
    assert_says(caught.value, "pieces is", "one Curve or more")


@pytest.mark.parametrize(
    "pieces", [[Spiral(outward=True), LINE], [LINE, Spiral()], [UTurn(), UTurn()]], ids=["end_s", "begin_s", "both"]
)
def test_inner_ends_of_a_composite_are_finite(pieces):
    with pytest.raises(ParameterError) as caught:
        Composite(pieces)
    assert_says(caught.value, "finite where they meet: piece 1", "piece 2")


@pytest.mark.parametrize(("pitch", "radius", "ratio"), [(1.7, 4.5, 2.0), (1.7, 4.5, 0.3), (0.55, 8.0, 1.0), (3, 1, 5)])
def test_u_turn_is_the_one_that_tangency_demands(pitch, radius, ratio):
    turn = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    with mp.workdps(DIGITS):
        truth = s_turn(*(mp.mpf(value) for value in (pitch, radius, ratio)))
        radii, centres, sweeps, points, length = truth
        expected = [*radii, *(part for z in (*centres, *points) for part in (z.real, z.imag)), *sweeps, length]
    found = [*turn.radii, *turn.centres.ravel(), *turn.tangent_points.ravel(), *turn.sweeps, turn.length]
    assert found == pytest.approx([float(value) for value in expected], abs=1e-12)


def test_u_turn_of_the_contest_has_the_published_numbers():
    turn = UTurn()
    assert turn.length == pytest.approx(13.621245, abs=5e-7)
    assert turn.radii == pytest.approx([3.005418, 1.502709], abs=5e-7)
    assert turn.centres == pytest.approx(np.array([[-0.760009, -1.305726], [1.735932, 2.448402]]), abs=5e-7)
    assert turn.tangent_points[0] == pytest.approx([-2.711856, -3.591078], abs=5e-7)


def test_u_turn_is_exact_everywhere():
    turn = UTurn()
    with mp.workdps(DIGITS):
        radii, centres, sweeps, points, length = s_turn(mp.mpf(1.7), mp.mpf(4.5), mp.mpf(2))
        angles = [mp.arg(points[0] - centres[0]), mp.arg(points[1] - centres[1])]
        arcs = [
            arc((centre.real, centre.imag), *rest) for centre, *rest in zip(centres, radii, angles, sweeps, strict=True)
        ]
        k = mp.mpf(1.7) / (2 * mp.pi)
        theta = mp.mpf(4.5) / k
        along = k / 2 * (theta * mp.sqrt(theta**2 + 1) + mp.asinh(theta))
        halfway = radii[0] * abs(sweeps[0])
        inward, outward = spiral(1.7), spiral(1.7, mp.pi, outward=True)

    def truth(s):
        if s < 0:
            return inward(s - along)
        if s < halfway:
            return arcs[0](s)
        return arcs[1](s - halfway) if s < length else outward(s - length + along)

    assert max(worst_errors(turn, truth, np.linspace(-100, 114, 80))) < 1e-12


@given(st.floats(0.2, 3), st.floats(1, 20), st.floats(0.05, 20))
def test_length_of_the_u_turn_does_not_depend_on_the_ratio(pitch, radius, ratio):
    turn = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    assert turn.length == pytest.approx(UTurn(pitch=pitch, radius=radius).length, rel=1e-14)
    assert turn.joints[2] == pytest.approx(turn.length, rel=1e-14)
    assert turn.radii[0] == pytest.approx(ratio * turn.radii[1])


@pytest.mark.parametrize(
    ("name", "bound"), [("pitch", "0.001 to 1000 m"), ("radius", "0.1 to 100 m"), ("ratio", "0.02 to 50")]
)
@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_impossible_u_turns_are_refused(name, bound, value):
    with pytest.raises(ParameterError) as caught:
        UTurn(**{name: value})
    assert caught.value.name == name
    assert_says(caught.value, bound)


@pytest.mark.parametrize(
    ("pitch", "radius", "ratio"),
    [(0.1, 100, 0.02), (1000, 100, 50), (1000, 0.1, 50), (0.001, 0.1, 50), (0.001, 1, 2)],
)
def test_extreme_u_turns_are_joined(pitch, radius, ratio):
    turn = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    assert np.isfinite(turn.point(turn.joints)).all()


@pytest.mark.parametrize("kind", ["line", "composite", "u-turn", "reversed spiral"])
def test_equal_curves_are_equal_and_can_be_sent_to_another_process(kind):
    curve = KINDS[kind][0]
    again = pickle.loads(pickle.dumps(curve))
    assert again == curve
    assert again.point(1.0).tolist() == curve.point(1.0).tolist()


def test_u_turns_of_different_ratios_are_not_equal():
    assert UTurn(ratio=2) != UTurn(ratio=3)
    assert repr(UTurn()) == "UTurn(pitch=1.7, radius=4.5, ratio=2.0)"
