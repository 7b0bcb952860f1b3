"""Nonsense from curves of a user's own, and arguments of the wrong kind: one clear error."""

import contextlib
import math
import warnings

import numpy as np
import pymunk
import pytest
from conftest import assert_says, refusal
from test_curve_kinds import LogarithmicSpiral

from pymunk_dragon import (
    Dragon,
    March,
    Run,
    Scenario,
    SpeedTable,
    World,
    first_contact,
    player_page,
    report,
    simulate,
)
from pymunk_dragon.collision import Grid, scan
from pymunk_dragon.drawing import Film, render
from pymunk_dragon.drawing.figures import figure
from pymunk_dragon.errors import DragonError
from pymunk_dragon.model.curves import (
    Arc,
    Composite,
    Curve,
    Line,
    Reversed,
    Sampled,
    Spiral,
    UTurn,
    check_curve,
)
from pymunk_dragon.model.dragon import bench_poses, outlines
from pymunk_dragon.reports import paper_tables, write_contact_table, write_tables
from pymunk_dragon.sessions import Button, Key, Slider, live
from pymunk_dragon.studies import max_speed, min_pitch, sensitivity, u_turn
from pymunk_dragon.sweeps import sweep

SMALL = Dragon(benches=4)


def own(base, **members):
    """An object of a class of the user's own, called Mine."""
    return type("Mine", (base,), members)()


METHODS = ("point", "tangent", "curvature", "max_curvature")
# What a method returns whatever its arguments, in every element of its result, and in a wrong
# shape.
WRONG = [
    *(lambda self, *arguments, value=value: value for value in (None, "1", [[1.0], [1.0, 2.0]])),
    *(
        lambda self, s, *other, value=value: np.full(np.shape(s), value)
        for value in (1j, None, math.nan, math.inf)
    ),
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
        return own(
            LogarithmicSpiral,
            **{method: lambda self, *s: change(getattr(LogarithmicSpiral, method)(self, *s))},
        )

    wrong = [own(LogarithmicSpiral, **{name: answer}) for name in METHODS for answer in WRONG]
    wrong += [
        of(name, change)
        for name in METHODS
        for change in (lambda x: x * 0.99, lambda x: np.where(x > 1, x, 1))
    ]
    wrong += [
        of("max_curvature", lambda x: 0 * x),
        *(own(LogarithmicSpiral, begin_s=begin) for begin in (0.5, 2.0)),
    ]
    wrong += [of(name, np.nan_to_num) for name in METHODS[:3]]
    wrong += [own(LogarithmicSpiral, normal_offset=value) for value in (1.0, None, "far")]
    for curve in wrong:
        assert "Mine" in refusal(check_curve, curve).name
    # A class that changes the points of a curve of the package inherits what does not fit them.
    moved = own(Spiral, point=lambda self, s: Spiral.point(self, s) + np.array([1.0, 0.0]))
    assert refusal(check_curve, moved, -300, -1).name == "Mine.frame(-300)"
    for ends in ((None, 1.0), (math.nan, 1.0), ("0", 1.0), (2.0, 1.0), (0.0, np.zeros(2))):
        curve = own(LogarithmicSpiral, begin_s=ends[0], end_s=ends[1])
        assert_says(refusal(check_curve, curve), "Mine.begin_s and end_s")
    for arguments in (
        (None,),
        (Spiral,),
        *((Spiral(), *ends) for ends in (("0",), (-300, 1), (-1, -300), (10**400,))),
    ):
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
NONSENSE = [
    None,
    "text",
    "",
    [],
    {},
    math.nan,
    -1,
    1.5,
    True,
    10**400,
    1e308,
    object(),
    [[1], [1, 2]],
    ["a"],
    1j,
]
NONSENSE += [
    [None],
    np.zeros((2, 5)),
    np.zeros((0, 3)),
    [10**400],
    np.array("x"),
    len,
    float,
    np.arange(4.0) * 1e300,
]
MARCH = March(SMALL)
POSES = np.zeros((4, 3))
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
    (
        Run,
        {
            "march": MARCH,
            "times": [0.0],
            "poses": POSES[None],
            "drift": np.zeros((1, 4)),
            "provenance": {},
        },
    ),
    (Composite, {"pieces": [Line(stop=(9, 1))]}),
    (Scenario.from_dict, {"values": {"benches": 5}}),
    (Scenario.read, {"path": "none.toml"}),
    (Curve.from_dict, {"values": {"kind": "spiral"}}),
    (SpeedTable([0], [1]).distance, {"t": 0}),
    (SpeedTable([0], [1]).time, {"distance": 0}),
]
PATH = Sampled([(0, 0), (3, 1), (6, 0), (9, 1)])
for curve in (Line(stop=(9, 1)), Spiral(), UTurn(), PATH, Reversed(Arc(radius=3, sweep=2))):
    CALLS += [
        (getattr(curve, name), {"s": 1.0})
        for name in ("point", "tangent", "curvature", "frame", "turns")
    ]
    CALLS += [
        (curve.max_curvature, {"s": 1.0, "other": 2.0}),
        (curve.foot, {"points": [[1.0, 2.0]], "near": [1.0]}),
    ]
    CALLS += [(curve.chain, {"s": 1.0, "spacings": [1.0]}), (curve.at_turn, {"turns": 3.0})]


def test_arguments_of_the_wrong_kind_raise_no_errors_of_the_code_inside():
    with np.errstate(all="ignore"):
        for call, arguments in CALLS:
            for name, value in [(name, value) for name in arguments for value in NONSENSE]:
                with contextlib.suppress(DragonError):
                    call(**arguments | {name: value})


TURNING = March(SMALL, UTurn())
# Calls with one wrong argument, and the name of that argument.
REFUSED = [
    *(
        (study, {"dragon": value}, "dragon")
        for study in (max_speed, min_pitch, sensitivity, u_turn)
        for value in (5, "x", 3, True, 0, "", [])
    ),
    (paper_tables, {"march": 3, "impact_time": None}, "march"),
    (write_tables, {"march": 3, "times": [0], "path": "new.xlsx"}, "march"),
    (write_tables, {"march": MARCH, "times": [10**400], "path": "new.xlsx"}, "times"),
    (
        write_contact_table,
        {"march": MARCH, "impact_time": 10**400, "path": "new.xlsx"},
        "impact_time",
    ),
    (figure, {"name": "gap", "source": 0}, "source"),
    (figure, {"name": "gap", "source": March(SMALL, turns=1e-300)}, "march"),
    (render, {"source": MARCH, "path": "new.png", "film": 0}, "film"),
    *((sweep, {"scenario": value, "axes": {"pitch": [0.5]}}, "scenario") for value in (0, "")),
    *(
        (
            Run,
            {
                "march": MARCH,
                "times": [0.0],
                "poses": POSES[None],
                "drift": np.zeros((1, 4)),
                name: value,
            },
            name,
        )
        for name, value in (("first_contact", 1.5), ("events", [None]), ("wall_seconds", "x"))
    ),
    (Film, {"start": "x"}, "start"),
    (Film, {"legend": 3}, "legend"),
    (Slider, {"name": "a", "low": 0, "high": 1, "value": 7}, "value"),
    (Slider, {"name": "a", "low": 0, "high": 1, "action": "x"}, "action"),
    (Button, {"name": 3, "action": 4}, "name"),
    (Button, {"name": "a", "action": 4}, "action"),
    (Key, {"name": "a", "action": print, "up": "x"}, "up"),
    (
        outlines,
        {"poses": POSES, "lengths": np.array([1.0, 0.0, 1.0, 1.0]), "width": 1.0},
        "lengths",
    ),
    (PATH.chain, {"s": [1.0], "spacings": [math.nan]}, "spacings"),
    (first_contact, {"march": MARCH, "until": 1.0, "progress": 3}, "progress"),
    # Also on a curve without end.
    *(
        (search, {"march": March(SMALL, UTurn()), "until": 1e300}, "until")
        for search in (first_contact, scan, simulate)
    ),
]


@pytest.mark.parametrize(("call", "arguments", "name"), REFUSED)
def test_a_wrong_argument_is_refused_by_the_call_that_receives_it(call, arguments, name, here):
    assert refusal(call, **arguments).name == name
    assert list(here.iterdir()) == []


@pytest.mark.parametrize("value", ["x" * 1000, [0.5] * 1000, np.eye(30), -(10**400)])
def test_message_does_not_repeat_a_long_value(value):
    assert repr(value) not in str(refusal(Spiral, pitch=value))


def test_what_does_not_apply_to_a_march_is_refused_by_a_live_session():
    others = {
        "on_step": print,
        "step": 0.1,
        "controls": [Button("a", print)],
        "plots": {"a": len},
        "y_down": True,
    }
    for name, value in others.items():
        assert refusal(live, MARCH, browser=False, **{name: value}).name == name
    for name, value in {
        "controls": "x",
        "on_step": 5,
        "plots": {"a": 1},
        "events": ["a", 3],
        "port": -1,
    }.items():
        assert name.rstrip("s") in str(
            refusal(live, pymunk.Space(), browser=False, **{name: value})
        )


def test_times_far_beyond_a_run_have_its_last_poses():
    run = Run.exact(MARCH, [0.0, 0.1])
    with warnings.catch_warnings(action="error"):
        assert np.array_equal(run.poses_at([1e308, -1e308]), run.poses_at([0.1, 0.0]))
        assert np.isnan(Spiral().point(-1e308)).all()
    assert refusal(run.poses_at, [math.nan]).name == "times"


def test_a_space_with_values_outside_the_ranges_of_the_sliders_is_shown():
    space = pymunk.Space()
    space.iterations, space.damping = 300, 1.5
    with live(space, browser=False) as session:
        assert session.address
