"""Live programs of users: functions that build spaces, controls, charts, and their errors."""

from __future__ import annotations

import math

import numpy as np
import pymunk
import pytest
from conftest import assert_says
from live_sessions import Listener, greeting, played

from pymunk_dragon import Button, DragonError, Key, ParameterError, Slider, live
from pymunk_dragon.sessions.scene import PlaySettings
from pymunk_dragon.sessions.scenes import space_scene


def build(gravity=900.0, links=3):
    """A chain of links below a hook, and a ball above a floor."""
    space = pymunk.Space()
    space.gravity = 0, gravity
    before, anchor = space.static_body, (100.0, 0.0)
    for link in range(links):
        body = pymunk.Body(1.0, 100.0)
        body.position = 110.0 + 20 * link, 0.0
        shape = pymunk.Segment(body, (-10, 0), (10, 0), 2)
        shape.filter = pymunk.ShapeFilter(group=1)
        space.add(body, shape, pymunk.PivotJoint(before, body, anchor, (-10, 0)))
        before, anchor = body, (10.0, 0.0)
    ball = pymunk.Body(2.0, 50.0)
    ball.position = 0.0, 0.0
    space.add(
        ball, pymunk.Circle(ball, 10.0), pymunk.Segment(space.static_body, (-50, 60), (50, 60), 5.0)
    )
    return space


def balls(space):
    return [shape.body for shape in space.shapes if isinstance(shape, pymunk.Circle)]


def rain(space, time):
    """A new ball at each tenth step; each lives for 20 steps."""
    step = round(60 * time)
    if step % 10 == 0:
        body = pymunk.Body(1.0, 10.0)
        body.position = -30.0 + step % 7, -50.0
        body.born = step
        space.add(body, pymunk.Circle(body, 4.0))
    for body in balls(space):
        if getattr(body, "born", step) < step - 20:
            space.remove(body, *body.shapes)


def test_reset_repeats_the_run_of_a_built_space_to_the_bit_while_bodies_come_and_go():
    with played(space_scene(build, PlaySettings(on_step=rain))) as on:
        counts, ends = set(), []
        for _ in range(2):
            for _ in range(12):
                on.step(10)
                counts.add(len(on.scene.poses()))
            on.do("grab", x=0.0, y=float(balls(on.scene.space)[0].position.y), slip=5.0)
            on.do("drag", x=40.0, y=0.0)
            on.step(30)
            ends.append(on.scene.poses().tolist())
            assert on.do("reset") is None
            assert on.scene.steps == 0
        assert ends[0] == ends[1]
        assert len(counts) > 1


def test_controls_reach_the_space_and_values_outlast_a_rebuild():
    pressed = []
    controls = [
        Slider("gravity", 0, 2000),
        Slider("links", 1, 9, rebuilds=True),
        Slider("iterations", 1, 50),
        Slider(
            "mass", 1, 50, 2, action=lambda space, value: setattr(balls(space)[0], "mass", value)
        ),
        Button("Kick", lambda space: balls(space)[0].apply_impulse_at_local_point((0, -500))),
        Key("ArrowLeft", lambda space: pressed.append("down"), lambda space: pressed.append("up")),
        Key("x", lambda space: pressed.append("x")),
    ]
    with played(space_scene(build, PlaySettings(controls=controls))) as on:
        assert {"gravity": 900, "links": 3, "mass": 2}.items() <= on.session.state()[
            "values"
        ].items()
        for name, value in (("gravity", 450.0), ("mass", 7.0), ("iterations", 20.0)):
            assert on.do("set", name=name, value=value) is None
        assert on.scene.space.gravity == (0, 450)
        assert balls(on.scene.space)[0].mass == 7
        on.do("press", name="Kick", down=True)
        assert balls(on.scene.space)[0].velocity == pytest.approx((0, -500 / 7))
        for name in ("ArrowLeft", "x"):
            for down in (True, False):
                assert on.do("press", name=name, down=down) is None
        assert pressed == ["down", "up", "x"]
        assert on.do("set", name="links", value=5.0) is None
        assert (len(on.scene.joints()), on.scene.space.gravity) == (5, (0, 450))
        assert (balls(on.scene.space)[0].mass, on.scene.space.iterations) == (7, 20)
        assert_says(ValueError(on.do("set", name="links", value=2.5)), "links")


def test_controls_and_functions_that_cannot_work_are_refused():
    for what, keywords in (
        (build, {"controls": [3]}),
        (build, {"controls": [Slider("colour", 0, 1)]}),
        (build, {"controls": [Slider("colour", 0, 1, rebuilds=True)]}),
        (build, {"controls": [Slider("links", 4, 9, rebuilds=True)]}),
        (build, {"step": math.nan}),
        (build, {"host": None}),
        (build, {"allow_hosts": "example.org"}),
        (lambda: 3, {}),
        (3, {}),
    ):
        with pytest.raises(DragonError) as raised:
            live(what, browser=False, **keywords)
        assert_says(raised.value)
    with pytest.raises(ParameterError):
        Slider("links", 2, 2)


def fail(*_):
    return 1 / 0


def paint(space, time):
    balls(space)[0].shapes.copy().pop().color = "red"


def build_failing():
    space = build()
    space.on_collision(begin=fail)
    return space


@pytest.mark.parametrize("kind", ["on_step", "callback", "chart", "colour", "button"])
def test_exception_in_a_users_function_pauses_once_shows_its_line_and_the_session_goes_on(
    kind, capfd
):
    play = {
        "on_step": PlaySettings(on_step=fail),
        "callback": PlaySettings(),
        "chart": PlaySettings(plots={"q": fail}),
        "colour": PlaySettings(on_step=paint),
        "button": PlaySettings(controls=[Button("Fail", fail)]),
    }[kind]
    with played(space_scene(build_failing if kind == "callback" else build, play)) as on:
        on.do("play")
        if kind == "button":
            on.do("press", name="Fail", down=True)
        while on.session.clock.running or not [
            message for message in on.told if message["kind"] == "error"
        ]:
            on.settle()
        for _ in range(20):
            on.settle()
        [error] = [message for message in on.told if message["kind"] == "error"]
        if kind != "colour":
            assert error["text"].startswith("ZeroDivisionError: division by zero")
            assert error["place"].endswith("return 1 / 0")
            assert "in fail" in error["trace"]
        # Who connects later sees it too, until the scene begins anew.
        assert greeting(on)[1:] == [error]
        assert on.do("reset") is None
        assert [message["generation"] for message in greeting(on)] == [on.session.generation]
    assert capfd.readouterr().err == ""


def test_charts_have_energy_and_momentum_and_the_quantities_of_the_user():
    with played(
        space_scene(
            build,
            PlaySettings(units="px", plots={"Height": lambda space: balls(space)[0].position.y}),
        )
    ) as on:
        on.step(10)
        height, kinetic, total, momentum = on.scene.plots().values()
        ball = balls(on.scene.space)[0]
        bodies = on.scene.space.bodies
        doubled = sum(
            body.mass * body.velocity.length**2 + body.moment * body.angular_velocity**2
            for body in bodies
        )
        assert kinetic == pytest.approx(doubled / 2)
        assert total - kinetic == pytest.approx(
            -900 * sum(body.mass * body.position.y for body in bodies)
        )
        assert momentum == pytest.approx(
            np.hypot(*sum(body.mass * np.array(body.velocity) for body in bodies))
        )
        assert height == ball.position.y


def test_session_pauses_after_the_step_in_which_the_next_pair_touches():
    with played(space_scene(build, PlaySettings(step=1 / 600))) as on:
        assert on.do("until_contact") is None
        while on.session.clock.running:
            on.settle()
        # The ball falls 45 px to the floor.
        assert on.scene.time == pytest.approx(math.sqrt(2 * 45 / 900), abs=2 / 600)
        assert len(on.frame().contacts) == 1
        # Time goes on when the step changes, by the lengths of steps that approach the chosen one.
        before = on.scene.time
        assert on.do("set", name="step", value=2.0) is None
        on.step(2)
        assert on.scene.time == pytest.approx(before + (1.01 + 1.01**2) / 600)
        on.step(100)
        assert on.scene.space.current_time_step == 0.002


def test_sliders_that_rebuild_are_all_taken_when_they_wait_together():
    controls = [Slider("links", 1, 9, rebuilds=True), Slider("gravity", 0, 2000, rebuilds=True)]
    with played(space_scene(build, PlaySettings(controls=controls))) as on:
        errors = []
        with on.session.held:
            for name, value in (("links", 4.0), ("gravity", 100.0), ("links", 6.0)):
                Listener(on.session, errors).do("set", name=name, value=value)
        on.settle()
        assert errors == []
        assert (len(on.scene.joints()), on.scene.space.gravity) == (6, (0, 100))


def test_steps_and_charts_make_no_buffers_as_pymunk_never_frees_them(monkeypatch):
    with played(space_scene(build, PlaySettings())) as on:
        monkeypatch.setattr("pymunk.batch.Buffer", None)
        assert on.step(50) == 50
        assert on.scene.plots()
        assert on.frame().step == 50
