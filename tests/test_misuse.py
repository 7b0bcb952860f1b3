"""Curves and speeds of a user's own class that return nonsense, and arguments of the wrong kind: one clear error."""

from __future__ import annotations

import math

import numpy as np
from conftest import assert_says, refusal
from test_curve_kinds import LogarithmicSpiral

from pymunk_dragon.collision import Grid, first_contact, scan
from pymunk_dragon.drawing import render
from pymunk_dragon.model.curves import Composite, Reversed, Section, Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.speed import speed_of
from pymunk_dragon.physics import World, simulate
from pymunk_dragon.player import player_page
from pymunk_dragon.reports import report

SMALL = Dragon(benches=4)


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


def constant(value):
    """A method that returns a value in the shape of its first argument."""
    return lambda self, first, *others: np.full(np.shape(first), value)


WRONG = (
    lambda self, *arguments: None,
    lambda self, *arguments: "1",
    lambda self, *arguments: [[1.0], [1.0, 2.0]],
    constant(1j),
    constant(None),
    lambda self, first, *others: np.ones((2, *np.shape(first))),
)


def test_curve_and_speed_of_a_users_own_work():
    march = March(SMALL, own(LogarithmicSpiral), start_s=30.0, speed=own(Steady))
    assert simulate(march, until=0.2).max_drift < 1e-3
    assert first_contact(march, until=3.0).status == "clear"
    # The class of a user may change points of a curve of the package.
    moved = own(Spiral, point=lambda self, s: Spiral.point(self, s) + np.array([1.0, 0.0]))
    offset = March(SMALL, moved).at([0.0, 5.0]).positions - March(SMALL).at([0.0, 5.0]).positions
    np.testing.assert_allclose(offset, np.broadcast_to([1.0, 0.0], offset.shape), atol=1e-9)


def test_wrong_results_of_a_users_curve_are_refused_by_the_method():
    for method in ("point", "tangent", "curvature", "max_curvature"):
        for answer in (*WRONG, constant(math.nan), constant(math.inf)):
            curve = own(LogarithmicSpiral, **{method: answer})
            for take in (lambda: March(SMALL, curve), lambda: Section(curve, 1, 2), lambda: Composite([curve])):  # noqa: B023  # Called within the loop.
                assert_says(refusal(take), f"Mine.{method}(")
    for ends in ((None, 1.0), (math.nan, 1.0), ("0", 1.0), (2.0, 1.0), (0.0, np.zeros(2))):
        curve = own(LogarithmicSpiral, begin_s=ends[0], end_s=ends[1])
        assert_says(refusal(March, SMALL, curve), "Mine.begin_s and end_s")

    def broken(self, s):
        on = (np.asarray(s) > 250) & (np.asarray(s) < 260)
        return np.where(on[..., None], np.nan, LogarithmicSpiral.point(self, s))

    curve = own(LogarithmicSpiral, point=broken)
    for path in (curve, Composite([Section(curve, 1, 400)]), Reversed(Reversed(curve))):
        march = March(SMALL, path, start_s=30.0)
        assert_says(refusal(march.at, np.arange(0.0, 300.0, 5.0)), "Mine.point(25", "begin_s = 1 m")


def test_wrong_results_of_a_users_speed_are_refused_by_the_method():
    cases = [(method, answer) for method in ("at", "distance", "time", "fastest") for answer in WRONG]
    cases += [(method, constant(math.nan)) for method in ("at", "distance", "time", "fastest")]
    cases += [("at", constant(value)) for value in (0.0, -1.0, 21.0)]
    for method, answer in [*cases, ("fastest", constant(0.0))]:
        ask = getattr(speed_of(own(Steady, **{method: answer})), method)
        times = [np.array([7.5, 8.5])] * (2 if method == "fastest" else 1)
        assert_says(refusal(ask, *times), f"Mine.{method}")
    for function in (
        lambda t: None,
        lambda t: "1",
        lambda t: 1 + 0j * t,
        lambda t: np.ones(3),
        lambda t: np.ones((np.size(t), 1)),
    ):
        assert_says(refusal(March, speed=function), "speed(0) is")
    for kind in ({"curve": LogarithmicSpiral}, {"speed": Steady}):
        assert refusal(March, **kind).name in kind


def test_what_is_no_march_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for take in (
        simulate,
        first_contact,
        lambda none: scan(none, until=1.0),
        Grid.of,
        World,
        lambda none: Run(march=none, times=[0], poses=[], drift=[]),
        lambda none: Run.exact(none, [0.0]),
        Scenario.of,
        lambda none: render(none, "film.gif"),
        lambda none: report(none, "report.json"),
        player_page,
    ):
        for value in (None, SMALL, "march"):
            assert refusal(take, value).name in ("march", "run", "source")
    assert list(tmp_path.iterdir()) == []
