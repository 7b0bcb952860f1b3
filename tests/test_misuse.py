"""Curves of a user's own class that return nonsense, and arguments of the wrong kind: one clear error."""

import contextlib
import math

import numpy as np
from conftest import assert_says, refusal
from test_curve_kinds import LogarithmicSpiral

from pymunk_dragon import Dragon, March, Run, Scenario, SpeedTable, World, first_contact, player_page, report, simulate
from pymunk_dragon.collision import Grid, scan
from pymunk_dragon.drawing import render
from pymunk_dragon.errors import DragonError
from pymunk_dragon.model.curves import Arc, Composite, Curve, Line, Reversed, Sampled, Spiral, UTurn, check_curve
from pymunk_dragon.model.dragon import bench_poses, outlines

SMALL = Dragon(benches=4)


def own(base, **members):
    """An object of a class of the user's own, called Mine."""
    return type("Mine", (base,), members)()


METHODS = ("point", "tangent", "curvature", "max_curvature")
# What a method returns whatever its arguments, in every element of its result, and in a wrong shape.
WRONG = [
    *(lambda self, *arguments, value=value: value for value in (None, "1", [[1.0], [1.0, 2.0]])),
    *(lambda self, s, *other, value=value: np.full(np.shape(s), value) for value in (1j, None, math.nan, math.inf)),
    lambda self, s, *other: np.ones((2, *np.shape(s))),
]


def test_curve_of_a_users_own_works_and_is_checked_when_its_author_wants_it():
    curve = own(LogarithmicSpiral)
    for right in (curve, UTurn()):  # The turn has no ends.
        check_curve(right)
    march = March(SMALL, curve, start_s=30.0)
    assert simulate(march, until=0.2).max_drift < 1e-3
    assert first_contact(march, until=3.0).status == "clear"

    def of(method, change):
        return own(LogarithmicSpiral, **{method: lambda self, *s: change(getattr(LogarithmicSpiral, method)(self, *s))})

    wrong = [own(LogarithmicSpiral, **{name: answer}) for name in METHODS for answer in WRONG]
    wrong += [of(name, change) for name in METHODS for change in (lambda x: x * 0.99, lambda x: np.where(x > 1, x, 1))]
    wrong += [of("max_curvature", lambda x: 0 * x), *(own(LogarithmicSpiral, begin_s=begin) for begin in (0.5, 2.0))]
    wrong += [of(name, np.nan_to_num) for name in METHODS[:3]]
    for curve in wrong:
        assert "Mine" in refusal(check_curve, curve).name
    # A class that changes the points of a curve of the package inherits what does not fit them.
    moved = own(Spiral, point=lambda self, s: Spiral.point(self, s) + np.array([1.0, 0.0]))
    assert refusal(check_curve, moved, -300, -1).name == "Mine.frame(-300)"
    for ends in ((None, 1.0), (math.nan, 1.0), ("0", 1.0), (2.0, 1.0), (0.0, np.zeros(2))):
        curve = own(LogarithmicSpiral, begin_s=ends[0], end_s=ends[1])
        assert_says(refusal(check_curve, curve), "Mine.begin_s and end_s")
    for arguments in ((None,), (Spiral,), *((Spiral(), *ends) for ends in (("0",), (-300, 1), (-1, -300), (10**400,)))):
        refusal(check_curve, *arguments)


def test_what_is_no_march_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for take in (
        *(simulate, first_contact, Grid.of, World, Scenario.of, player_page),
        lambda none: scan(none, until=1.0),
        lambda none: Run(march=none, times=[0], poses=[], drift=[]),
        lambda none: Run.exact(none, [0.0]),
        lambda none: render(none, "film.gif"),
        lambda none: report(none, "report.json"),
    ):
        for value in (None, SMALL, "march"):
            assert refusal(take, value).name in ("march", "run", "source")
    assert list(tmp_path.iterdir()) == []


# Arguments of the wrong kind, and public functions of the model with arguments that they take.
NONSENSE = [None, "text", "", [], {}, math.nan, -1, 1.5, True, 10**400, 1e308, object(), [[1], [1, 2]], ["a"], 1j]
NONSENSE += [[None], np.zeros((2, 5)), np.zeros((0, 3)), [10**400], np.array("x"), len, float, np.arange(4.0) * 1e300]
MARCH, POSES = March(SMALL), np.zeros((4, 3))
CALLS = [
    (MARCH.at, {"times": [0.0], "handles": 2}),
    (MARCH.motion_or_nan, {"times": [0.0], "handles": 2}),
    (MARCH.speeds_by_difference, {"times": [0.0], "step": 0.1}),
    (MARCH.span, {"start": 0.0, "until": 1.0}),
    (MARCH.distance, {"times": 0.0}),
    (MARCH.time, {"distances": 0.0}),
    (MARCH.at([0, 1]).to_dict, {"handles": [1]}),
    (SMALL.outlines, {"poses": POSES}),
    (SMALL.outlines_between, {"handles": np.arange(5)}),
    (SMALL.holes, {"poses": POSES}),
    (SMALL.hole_velocities, {"poses": POSES, "velocities": POSES}),
    (bench_poses, {"handles": np.zeros((5, 2))}),
    (outlines, {"poses": POSES, "lengths": np.ones(4), "width": 1.0}),
    (SpeedTable, {"times": [0], "speeds": [1]}),
    (SpeedTable.of, {"function": math.exp, "start": 0, "until": 1, "step": 0.1}),
    (SpeedTable.read, {"path": "none.csv"}),
    (Run.load, {"path": "none.npz"}),
    (Run.exact, {"march": MARCH, "times": [0]}),
    (Run.exact(MARCH, [0, 1]).poses_at, {"times": [0]}),
    (Run, {"march": MARCH, "times": [0.0], "poses": POSES[None], "drift": np.zeros((1, 4)), "provenance": {}}),
    (Composite, {"pieces": [Line(stop=(9, 1))]}),
    (Scenario.from_dict, {"values": {"benches": 5}}),
    (Scenario.read, {"path": "none.toml"}),
    (Curve.from_dict, {"values": {"kind": "spiral"}}),
    (SpeedTable([0], [1]).distance, {"t": 0}),
    (SpeedTable([0], [1]).time, {"distance": 0}),
]
PATH = Sampled([(0, 0), (3, 1), (6, 0), (9, 1)])
for curve in (Line(stop=(9, 1)), Spiral(), UTurn(), PATH, Reversed(Arc(radius=3, sweep=2))):
    CALLS += [(getattr(curve, name), {"s": 1.0}) for name in ("point", "tangent", "curvature", "frame", "turns")]
    CALLS += [(curve.max_curvature, {"s": 1.0, "other": 2.0}), (curve.foot, {"points": [[1.0, 2.0]], "near": [1.0]})]
    CALLS += [(curve.chain, {"s": 1.0, "spacings": [1.0]}), (curve.at_turn, {"turns": 3.0})]


def test_arguments_of_the_wrong_kind_raise_no_errors_of_the_code_inside():
    with np.errstate(all="ignore"):
        for call, arguments in CALLS:
            for name, value in [(name, value) for name in arguments for value in NONSENSE]:
                with contextlib.suppress(DragonError):
                    call(**arguments | {name: value})
