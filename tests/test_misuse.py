"""Curves and speeds of a user's own class that return nonsense, and arguments of the wrong kind: one clear error."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from conftest import assert_says

from pymunk_dragon.collision import Grid, first_contact, scan
from pymunk_dragon.drawing import Camera, render
from pymunk_dragon.drawing.figures import figure
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.lessons._framework import check_language
from pymunk_dragon.model.curves import Composite, Curve, Reversed, Section, Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.speed import speed_of
from pymunk_dragon.physics import World, simulate
from pymunk_dragon.player import player_page
from pymunk_dragon.reports import report
from pymunk_dragon.studies import study

SMALL = Dragon(benches=4)


class Straight(Curve):
    """A user's own curve: the x axis, from 0 to 500 m."""

    begin_s, end_s = 0.0, 500.0

    def point(self, s):
        return np.stack([np.asarray(s), np.zeros(np.shape(s))], axis=-1)

    def tangent(self, s):
        return np.stack([np.ones(np.shape(s)), np.zeros(np.shape(s))], axis=-1)

    def curvature(self, s):
        return np.zeros(np.shape(s))

    def max_curvature(self, s, other):
        return 0.0


class Steady:
    """A user's own speed: 1 m/s."""

    def at(self, t):
        return np.ones(np.shape(t))

    def distance(self, t):
        return np.asarray(t, dtype=float)

    def time(self, way):
        return np.asarray(way, dtype=float)

    def fastest(self, t0, t1):
        return 1.0


def own(base, **members):
    """An object of a class of the user's own, called Mine."""
    return type("Mine", (base,), members)()


def of_shape(shape_of, value=1.0):
    """A method that returns an array of another shape than that of its first argument."""
    return lambda self, first, *others: np.full(shape_of(np.shape(first)), value)


WRONG = {
    "None": lambda self, *arguments: None,
    "a text": lambda self, *arguments: "1",
    "complex": lambda self, first, *others: np.ones(np.shape(first)) * 1j,
    "objects": lambda self, first, *others: np.full(np.shape(first), None),
    "ragged": lambda self, *arguments: [[1.0], [1.0, 2.0]],
    "three": of_shape(lambda shape: (3, 7)),
    "first axis": of_shape(lambda shape: (2, *shape)),
    "no axis": of_shape(lambda shape: shape[1:] or (9,)),
}
wrong = pytest.mark.parametrize("answer", WRONG.values(), ids=WRONG)


def test_curve_and_speed_of_a_users_own_work():
    march = March(SMALL, own(Straight), speed=own(Steady))
    run = simulate(march, until=0.2)
    np.testing.assert_allclose(march.at(0.2).positions[0, :, 0] - march.at(0.0).positions[0, :, 0], 0.2, atol=1e-12)
    assert run.max_drift < 1e-9
    assert first_contact(march, until=3.0).status == "clear"


@pytest.mark.parametrize("method", ["point", "tangent", "curvature", "max_curvature"])
@wrong
def test_curve_of_a_wrong_shape_is_refused_by_its_method(method, answer):
    curve = own(Straight, **{method: answer})
    for take in (
        lambda: March(SMALL, curve),
        lambda: Reversed(curve),
        lambda: Section(curve, 1, 2),
        lambda: Composite([curve]),
    ):
        with pytest.raises(ParameterError) as caught:
            take()
        shape = {"point": "(1, 3, 2)", "tangent": "(1, 3, 2)", "curvature": "(1, 3)", "max_curvature": "(1, 2)"}[method]
        assert_says(caught.value, f"Mine.{method}(s", f"{shape} for arguments of shape ({shape[1:5]}")


@pytest.mark.parametrize("method", ["point", "tangent", "curvature", "max_curvature"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_curve_that_is_not_finite_is_refused_by_its_method(method, value):
    with pytest.raises(ParameterError) as caught:
        March(SMALL, own(Straight, **{method: lambda self, *given: getattr(Straight, method)(self, *given) + value}))
    assert_says(caught.value, f"Mine.{method}(", str(value), "must be finite")


@pytest.mark.parametrize("method", ["point", "tangent"])
@pytest.mark.parametrize(
    "wrap", [lambda curve: curve, lambda curve: Composite([curve]), Reversed], ids=["itself", "composite", "reversed"]
)
def test_place_where_a_curve_is_not_finite_is_named_when_it_is_reached(method, wrap):
    def broken(self, s):
        answer = getattr(Straight, method)(self, s)
        return np.where((np.asarray(s) > 250)[..., None] & (np.asarray(s) < 260)[..., None], np.nan, answer)

    march = March(SMALL, wrap(own(Straight, **{method: broken})))
    with pytest.raises(ParameterError) as caught:
        march.at(np.arange(0.0, 400.0, 5.0))
    assert_says(caught.value, f"Mine.{method}(25", "must be finite from begin_s = 0 m to end_s = 500 m")


@pytest.mark.parametrize("ends", [(None, 1.0), (math.nan, 1.0), ("0", 1.0), (2.0, 1.0), (0.0, np.zeros(2))], ids=repr)
def test_curve_whose_ends_are_no_numbers_is_refused(ends):
    with pytest.raises(ParameterError) as caught:
        March(SMALL, own(Straight, begin_s=ends[0], end_s=ends[1]))
    assert_says(caught.value, "Mine.begin_s and end_s", "two numbers")


@pytest.mark.parametrize("ends", [(-math.inf, math.inf), (-math.inf, 3.0), (3.0, math.inf), (3.0, 3.001)])
def test_curve_is_tried_only_between_its_ends(ends):
    def point(self, s):
        assert (np.asarray(s) >= ends[0]).all()
        assert (np.asarray(s) <= ends[1]).all()
        return Straight.point(self, s)

    Reversed(own(Straight, begin_s=ends[0], end_s=ends[1], point=point))


def test_class_is_no_curve_and_no_speed():
    with pytest.raises(ParameterError, match="must be a Curve"):
        March(SMALL, Straight)
    with pytest.raises(ParameterError, match="not a class"):
        March(speed=Steady)


@pytest.mark.parametrize("method", ["at", "distance", "time", "fastest"])
@wrong
def test_speed_of_a_wrong_shape_is_refused_by_its_method(method, answer):
    speed = speed_of(own(Steady, **{method: answer}))
    with pytest.raises(ParameterError) as caught:
        getattr(speed, method)(*[np.zeros(5)] * (2 if method == "fastest" else 1))
    assert_says(caught.value, f"Mine.{method} is ", "(5,) for arguments of shape (5,)")


@pytest.mark.parametrize(
    ("method", "value"),
    [
        ("at", math.nan),
        ("at", 0.0),
        ("at", -1.0),
        ("at", 21.0),
        ("distance", math.nan),
        ("time", math.nan),
        ("fastest", math.nan),
        ("fastest", 0.0),
    ],
)
def test_speed_that_cannot_be_is_refused_by_its_method(method, value):
    speed = speed_of(own(Steady, **{method: of_shape(lambda shape: shape, value)}))
    with pytest.raises(ParameterError) as caught:
        getattr(speed, method)(*[np.array([7.5])] * (2 if method == "fastest" else 1))
    assert_says(caught.value, f"Mine.{method}(7.5", f"is {value}", "a number from")


FUNCTIONS = {
    "None": lambda t: None,
    "a text": lambda t: "1",
    "a word": lambda t: "fast",
    "complex": lambda t: 1 + 0j * t,
    "one complex": lambda t: 1j,
    "three": lambda t: np.ones(3),
    "a column": lambda t: np.ones((np.size(t), 1)),
}


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_function_that_returns_no_speed_is_refused_with_the_shape_wanted(function):
    with pytest.raises(ParameterError) as caught:
        March(speed=function)
    assert_says(caught.value, "speed(0) is", "a number in m/s, and for an array of T times an array of shape (T,)")


@pytest.mark.parametrize("rate", [1e4, 1e5, 1e7])
def test_function_that_varies_too_fast_is_refused_at_once(rate):
    with pytest.raises(ParameterError) as caught:
        March(speed=lambda t: 1 + 0.9 * np.sin(rate * t))
    assert_says(caught.value, "speed from t = 0 s to 2 s", "smooth but for some kinks: it varies within 0.002 s")


def test_function_that_varies_often_is_integrated_exactly():
    speed = speed_of(lambda t: 1 + 0.9 * np.sin(2e3 * t))
    times = np.linspace(-1, 3, 50)
    np.testing.assert_allclose(speed.distance(times), times + 0.9 / 2e3 * (1 - np.cos(2e3 * times)), atol=1e-12)


NONE = {
    "simulate": lambda none: simulate(none),
    "simulate until": lambda none: simulate(none, until=1.0),
    "first_contact": lambda none: first_contact(none),
    "scan": lambda none: scan(none, until=1.0),
    "Grid.of": Grid.of,
    "World": lambda none: World(none),
    "Run": lambda none: Run(march=none, times=[0], poses=[], drift=[]),
    "Run.exact": lambda none: Run.exact(none, [0.0]),
    "Scenario.of": Scenario.of,
    "render": lambda none: render(none, "film.gif"),
    "report": lambda none: report(none, "report.json"),
    "player_page": player_page,
}


@pytest.mark.parametrize("take", NONE.values(), ids=NONE)
@pytest.mark.parametrize("value", [None, SMALL, "march"], ids=["None", "a dragon", "a text"])
def test_what_is_no_march_is_refused(take, value, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ParameterError) as caught:
        take(value)
    assert caught.value.name in ("march", "run", "source")
    assert list(tmp_path.iterdir()) == []


A_RUN = Run.exact(March(SMALL), [0.0, 1.0])
WORDS = {
    "guide": lambda word: simulate(A_RUN.march, until=1.0, guide=word),
    "contacts": lambda word: simulate(A_RUN.march, until=1.0, contacts=word),
    "follow": lambda word: Camera(follow=word),
    "show": lambda word: render(A_RUN, "film.gif", show=(word,)),
    "outcome": lambda word: Run(
        march=A_RUN.march, times=[0], poses=A_RUN.poses[:1], drift=A_RUN.drift[:1], outcome=word
    ),
    "study": lambda word: study(word, {}),
    "figure": lambda word: figure(word),
    "language": check_language,
}


@pytest.mark.parametrize("name", WORDS)
@pytest.mark.parametrize(
    "value", [np.array(["rails", "stop"]), np.array("rails!"), None, 3, ["rails"], b"rails"], ids=repr
)
def test_what_is_no_word_is_refused(name, value):
    with pytest.raises(ParameterError) as caught:
        WORDS[name](value)
    assert caught.value.name == name
    assert_says(caught.value, "must be ")


class Shifted(Spiral):
    """A spiral that is moved by a metre: nothing that `Spiral` computes faster holds for it."""

    def point(self, s):
        return super().point(s) + np.array([1.0, 0.0])


def test_class_that_changes_the_points_of_a_curve_of_the_package_is_marched_on_as_changed():
    for curve in (Shifted(), type("Again", (Shifted,), {})()):
        states = March(SMALL, curve).at([0.0, 5.0])
        moved = states.positions - March(SMALL).at([0.0, 5.0]).positions
        np.testing.assert_allclose(moved, np.broadcast_to([1.0, 0.0], moved.shape), atol=1e-9)


def test_methods_of_a_mixin_are_checked_and_may_be_static():
    class Shape:
        begin_s, end_s = 0.0, 100.0
        tangent, curvature = Straight.tangent, Straight.curvature

        def point(self, s):
            return np.where(np.asarray(s)[..., None] > 30, np.nan, Straight.point(self, s))

        @staticmethod
        def max_curvature(s, other):
            return 0.0

    class Mine(Shape, Curve):
        pass

    with pytest.raises(ParameterError) as caught:
        March(SMALL, Mine()).at([0, 40])
    assert_says(caught.value, "Mine.point(", "must be finite")


def test_kind_of_a_curve_has_one_class(monkeypatch):
    monkeypatch.setattr(Curve, "kinds", dict(Curve.kinds))

    @dataclass(frozen=True, slots=True)
    class Slotted(Straight, kind="slotted"):
        size: list = field(default_factory=list)

    assert type(Curve.from_dict({"kind": "slotted"})) is Slotted
    for kind in ("spiral", 3):
        with pytest.raises(ParameterError) as caught:
            type("Other", (Straight,), {}, kind=kind)
        assert caught.value.name == "kind"
    type("Bare", (Straight,), {}, kind="bare")
    with pytest.raises(ParameterError):
        Curve.from_dict({"kind": "line", "bad": 1})
