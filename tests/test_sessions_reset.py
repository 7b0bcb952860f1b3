"""Start again: the state that a space gets back; and errors, which end no session."""

from __future__ import annotations

import gc
import math
import threading

import numpy as np
import pymunk
import pytest
from conftest import assert_says
from live_sessions import PATIENCE, Listener, greeting, played, replay_session, replayed

from pymunk_dragon import Button, DragonError, Key, ParameterError, Slider, live
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions.scene import PlaySettings
from pymunk_dragon.sessions.scenes import march_scene, named_scene, space_scene
from pymunk_dragon.sessions.session import Session

BOX = 0.5


def build(links=3, gravity=10.0):
    """Boxes in a row, as many as `links`."""
    space = pymunk.Space()
    space.gravity = 0, -gravity
    for link in range(links):
        body = pymunk.Body(1, 1)
        body.position = link, 0
        space.add(body, pymunk.Circle(body, 0.3))
    return space


SLIDERS = [Slider("links", 1, 9, rebuilds=True), Slider("gravity", 0, 30)]


@pytest.mark.parametrize(
    "order", [("links", "gravity"), ("gravity", "links"), ("gravity",), ("links",)]
)
def test_reset_of_a_built_space_has_the_first_values_of_all_sliders_in_whatever_order_they_were_set(
    order,
):
    with played(space_scene(build, PlaySettings(controls=SLIDERS))) as on:
        for name in order:
            assert on.do("set", name=name, value={"links": 7.0, "gravity": 20.0}[name]) is None
        # Where a slider rebuilds, the others stay as they are.
        links, gravity = 7 if "links" in order else 3, 20 if "gravity" in order else 10
        assert (len(on.scene.space.bodies), on.scene.space.gravity.y) == (links, -gravity)
        assert on.do("reset") is None
        assert (len(on.scene.space.bodies), on.scene.space.gravity.y) == (3, -10)
        assert {"links": 3, "gravity": 10}.items() <= on.session.state()["values"].items()
        assert on.session.log()["values"] == {}


@pytest.mark.parametrize(
    ("source", "changes"),
    [
        ("boxes", {"rows": 4.0, "gravity": 3.0, "iterations": 5.0}),
        ("sloppy-engine", {"pitch": 0.7, "step": 20.0, "drag": 4.0}),
        (march_scene(March(Dragon(benches=12))), {"benches": 9.0, "speed": 1.5, "width": 0.25}),
    ],
)
@pytest.mark.parametrize("backwards", [False, True])
def test_reset_of_a_built_in_scene_or_a_march_has_the_first_values_of_all_sliders(
    source, changes, backwards
):
    with played(named_scene(source) if isinstance(source, str) else source) as on:
        first = on.session.state()["values"]
        for name in sorted(changes, reverse=backwards):
            assert on.do("set", name=name, value=changes[name]) is None
        assert on.session.state()["values"] == first | changes
        on.step(3)
        log = on.session.log()
        assert on.do("reset") is None
        assert on.session.state()["values"] == first
    # What was recorded before is played again with the values that it had.
    poses, session = replayed(log) if log["plan"] is not None else (log["poses"], None)
    assert poses == log["poses"]
    if session is not None:
        assert session.state()["values"] == first | changes


def test_reset_after_a_replay_has_the_values_with_which_the_recording_began():
    with played(march_scene(March(Dragon(benches=12)))) as on:
        on.do("set", name="benches", value=9.0)
        on.do("set", name="drag", value=4.0)
        on.step(3)
        log = on.session.log()
    session, _ = replay_session(log)
    assert session.wait_for_replay() == 0
    begun = threading.Event()
    Listener(session, []).do("reset")
    session.call(begun.set)
    assert begun.wait(PATIENCE)
    session.stop()
    assert (session.scene.steps, session.state()["values"]["benches"]) == (0, 9)


def chain(links=20):
    """A chain that falls from a horizontal line, without contacts."""
    space = pymunk.Space()
    before = None
    hole = (0.0, 0.0)
    space.gravity = 0, -9.81
    for link in range(links):
        body = pymunk.Body(1, 0.01)
        body.position = 0.1 + 0.2 * link, 0
        shape = pymunk.Segment(body, (-0.1, 0), (0.1, 0), 0.02)
        shape.filter = pymunk.ShapeFilter(group=1)
        space.add(
            body, shape, pymunk.PivotJoint(before or space.static_body, body, hole, (-0.1, 0))
        )
        before, hole = body, (0.1, 0.0)
    return space


def springs():
    """Bodies on springs, motors and limits, without contacts."""
    space = pymunk.Space()
    space.gravity = 0, -9.81
    bodies = [pymunk.Body(1, 0.1) for _ in range(4)]
    for number, body in enumerate(bodies):
        body.position = 2 * number, 0
        space.add(body, pymunk.Circle(body, 0.2))
    a, b, c, d = bodies
    space.add(
        pymunk.DampedSpring(space.static_body, a, (0, 2), (0, 0), 1, 40, 0.3),
        pymunk.SimpleMotor(a, b, 2.0),
        pymunk.SlideJoint(a, b, (0, 0), (0, 0), 1.0, 1.9),
        pymunk.RatchetJoint(b, c, 0.0, 0.4),
        pymunk.PinJoint(b, c),
        pymunk.GearJoint(c, d, 0.3, 2.0),
        pymunk.GrooveJoint(c, d, (1, -1), (2, 1), (0, 0)),
        pymunk.DampedRotarySpring(c, d, 0.5, 3.0, 0.1),
        pymunk.RotaryLimitJoint(a, d, -0.1, 0.1),
    )
    return space


@pytest.mark.parametrize("make", [chain, springs])
def test_reset_of_a_given_space_without_contacts_repeats_the_run_to_the_bit(make):
    with played(make()) as on:
        ends = []
        for _ in range(3):
            assert on.step(60) == 60
            ends.append(on.scene.poses().tolist())
            assert on.do("reset") is None
        assert ends[0] == ends[1] == ends[2]


def test_page_says_where_the_run_of_a_reset_may_differ():
    for source, given in ((build(), True), (build, False), (March(Dragon(benches=4)), False)):
        with played(source) as on:
            assert greeting(on)[0]["given"] is given


def test_given_space_that_flew_apart_begins_anew():
    with played(chain(3)) as on:
        next(iter(on.scene.space.bodies)).velocity = math.nan, 0
        assert on.step(10) < 10
        assert on.do("reset") is None
        assert on.step(10) == 10


def everything():
    """A space with a part of each kind, by names."""
    space = pymunk.Space()
    a = pymunk.Body(2, 3)
    b = pymunk.Body(1, 1)
    hook = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    fixed, heavy = pymunk.Body(body_type=pymunk.Body.STATIC), pymunk.Body()
    a.position = (1, 2)
    b.position = (9, 2)
    heavy.position = (5, 9)
    fixed.position = (30, 30)
    a.angle = 0.3
    a.center_of_gravity = 0.1, 0.2
    circle, segment = pymunk.Circle(a, 0.5, (0.1, 0)), pymunk.Segment(fixed, (0, 0), (1, 0), 0.1)
    polygon, ball = pymunk.Poly.create_box(b, (1, 1), 0.01), pymunk.Circle(heavy, 1)
    ball.density = 3
    circle.color, a.name = (1, 2, 3, 255), "first"
    joints = {
        "pin": pymunk.PinJoint(a, b),
        "slide": pymunk.SlideJoint(a, b, (0, 0), (0, 0), 1, 20),
        "pivot": pymunk.PivotJoint(hook, a, (0, 0), (0, 0)),
        "groove": pymunk.GrooveJoint(space.static_body, b, (0, 0), (1, 1), (0, 0)),
        "spring": pymunk.DampedSpring(a, b, (0, 0), (0, 0), 1, 2, 3),
        "rotary": pymunk.DampedRotarySpring(a, b, 1, 2, 3),
        "limit": pymunk.RotaryLimitJoint(a, b, -9, 9),
        "ratchet": pymunk.RatchetJoint(a, b, 0, 1),
        "gear": pymunk.GearJoint(a, b, 0, 1),
        "motor": pymunk.SimpleMotor(a, b, 1),
    }
    bodies = {
        "a": a,
        "b": b,
        "heavy": heavy,
        "fixed": fixed,
        "hook": hook,
        "ground": space.static_body,
    }
    shapes = {"circle": circle, "segment": segment, "polygon": polygon, "ball": ball}
    space.add(a, b, heavy, fixed, *shapes.values(), *joints.values())
    return {"space": space, **bodies, **shapes, **joints}


def other(*_):
    return 1.0


# What a user may change, and other values.
CHANGES = {
    "space": {
        "gravity": (1, 2),
        "damping": 0.3,
        "iterations": 3,
        "collision_slop": 0.4,
        "collision_bias": 0.1,
    }
    | {"collision_persistence": 9, "sleep_time_threshold": 0.1, "idle_speed_threshold": 2},
    "a": {
        "mass": 9,
        "moment": 8,
        "center_of_gravity": (0, 0),
        "angle": 2,
        "position": (70, 70),
        "velocity": (3, 4),
    }
    | {
        "angular_velocity": 2,
        "force": (1, 1),
        "torque": 5,
        "velocity_func": other,
        "position_func": other,
        "name": 1,
    },
    "b": {"position": (math.nan, 0), "body_type": pymunk.Body.STATIC},
    "ball": {"density": 9},
    "heavy": {"mass": 4, "center_of_gravity": (1, 1), "position": (3, 3)},
    "fixed": {"position": (1, 1), "angle": 1},
    "hook": {"position": (4, 4), "velocity": (1, 1)},
    "ground": {"position": (2, 2)},
    "circle": {
        "friction": 7,
        "elasticity": 3,
        "sensor": True,
        "collision_type": 4,
        "surface_velocity": (1, 1),
    }
    | {"filter": pymunk.ShapeFilter(4, 5, 6), "color": (9, 9, 9, 255)},
    "pin": {
        "distance": 77,
        "anchor_a": (1, 1),
        "anchor_b": (2, 2),
        "max_force": 3,
        "error_bias": 0.5,
        "max_bias": 2,
    }
    | {"collide_bodies": False, "pre_solve": other, "post_solve": other},
    "slide": {"min": 2, "max": 3, "anchor_a": (1, 1), "anchor_b": (2, 2)},
    "pivot": {"anchor_a": (1, 1), "anchor_b": (2, 2), "max_force": 5},
    "groove": {"groove_a": (3, 3), "groove_b": (4, 5), "anchor_b": (6, 6)},
    "spring": {
        "rest_length": 9,
        "stiffness": 8,
        "damping": 7,
        "anchor_a": (1, 1),
        "force_func": other,
    },
    "rotary": {"rest_angle": 9, "stiffness": 8, "damping": 7, "torque_func": other},
    "limit": {"min": -1, "max": 1},
    "ratchet": {"angle": 3, "phase": 2, "ratchet": 5},
    "gear": {"phase": 2, "ratio": 5},
    "motor": {"rate": 9, "max_force": 1},
}


def state(parts):
    """All values of parts that can be read."""
    found = {
        (name, key): getattr(part, key)
        for name, part in parts.items()
        for key in (*dir(type(part)), "color", "name")
        if not key.startswith("_") and isinstance(getattr(type(part), key, property()), property)
        # Pymunk 7.3.1 turns the normal of a segment round where its ends are set.
        if hasattr(part, key) and key not in {"bb", "impulse", "normal"}
    }
    found["vertices"] = parts["polygon"].get_vertices()
    return {
        key: list(value) if hasattr(value, "mapping") else value for key, value in found.items()
    }


def test_reset_of_a_given_space_brings_back_all_that_pymunk_lets_a_user_change():
    parts = everything()
    space, before = parts["space"], state(parts)
    with played(space) as on:
        # The thread of the session draws frames meanwhile.
        with on.session.held:
            space.remove(parts["pin"], parts["circle"])
            for name, values in CHANGES.items():
                for key, value in values.items():
                    setattr(parts[name], key, value)
            parts["circle"].unsafe_set_radius(4)
            parts["circle"].unsafe_set_offset((4, 4))
            parts["segment"].unsafe_set_endpoints((4, 4), (5, 5))
            parts["segment"].unsafe_set_radius(4)
            parts["polygon"].unsafe_set_vertices([(0, 0), (4, 0), (0, 4)])
            parts["polygon"].unsafe_set_radius(4)
            parts["a"].added = 3
            newcomer = pymunk.Body(1, 1)
            space.add(
                newcomer, pymunk.Circle(newcomer, 1), pymunk.SimpleMotor(parts["a"], newcomer, 1)
            )
        assert on.do("obstacle", shape="round", x=0.0, y=0.0, size=1.0) is None
        changed = state(parts)
        for name, values in CHANGES.items():
            assert all(changed[name, key] != before[name, key] for key in values), name
        assert on.do("reset") is None
    assert state(parts) == before
    assert not hasattr(parts["a"], "added")
    assert newcomer.space is None


def falling(count=12):
    """Boxes that fall onto a floor, which the space is given."""
    space = pymunk.Space()
    space.gravity = 0, -9.81
    floor = pymunk.Segment(space.static_body, (-20, 0), (20, 0), 0.1)
    space.add(floor)
    for number in range(count):
        body = pymunk.Body(1, 0.04)
        body.position = number, 0.36
        space.add(body, pymunk.Poly.create_box(body, (BOX, BOX)))
    return space


def remove_bodies(arbiter, space, data):
    for shape in arbiter.shapes:
        if shape.body is not space.static_body:
            space.remove(shape, shape.body)


def test_given_space_whose_separate_callback_removes_a_body_begins_anew_again_and_again():
    space, called = falling(), []

    def separate(arbiter, space, data):
        called.append(data)
        remove_bodies(arbiter, space, data)

    space.on_collision(separate=separate, data="mine")
    with played(space) as on:
        for _ in range(3):
            assert on.step(20) == 20
            assert len(on.scene.poses()) == 12
            assert on.do("reset") is None
            assert (len(space.bodies), len(space.shapes), called) == (12, 13, [])
        # The callback is there again, with its data; what was added meanwhile is not.
        space.on_collision(1, 2, begin=fail)
        assert on.step(20) == 20
        for body in space.bodies:
            body.velocity = 0, 9
        on.step(1)
        assert set(called) == {"mine"}
        assert len(on.scene.poses()) == 0
        assert on.do("reset") is None
        assert len(on.scene.poses()) == 12
        assert on.errors == []


@pytest.mark.parametrize("change", ["remove", "add"])
def test_given_space_begins_anew_after_a_callback_removed_or_added_parts_twice(change):
    space, acts = falling(), []
    bodies = list(space.bodies)
    parts = [*bodies[:3], *[shape for body in bodies[:3] for shape in body.shapes]]

    def pre_solve(arbiter, space, data):
        if acts:
            getattr(space, change)(*parts)

    space.on_collision(pre_solve=pre_solve)
    with played(space) as on:
        for _ in range(2):
            acts.append(True)
            assert on.step(20) < 20
            acts.clear()
            assert on.do("reset") is None
            assert list(space.bodies) == bodies
            assert on.step(20) == 20
        assert len(on.errors) == 2


def test_first_run_of_a_given_space_is_that_of_the_space_itself():
    first, second = falling(), falling()
    for _ in range(30):
        first.step(1 / 60)
        second.step(1 / 60)
    with played(first) as on:
        assert on.step(30) == 30
        poses = on.scene.poses()
    for _ in range(30):
        second.step(1 / 60)
    assert poses.tolist() == [[*body.position, body.angle] for body in second.bodies]


def test_callbacks_of_a_built_space_are_not_called_when_it_is_built_again_or_the_session_ends():
    called = []

    def make(count=12):
        space = falling(count)
        space.on_collision(separate=lambda *_: called.append("separate"))
        return space

    with played(
        space_scene(make, PlaySettings(controls=[Slider("count", 1, 20, rebuilds=True)]))
    ) as on:
        for message in (
            {"do": "reset"},
            {"do": "set", "name": "count", "value": 5},
            {"do": "scene", "name": "space"},
        ):
            on.step(20)
            assert on.do(message.pop("do"), **message) is None
            gc.collect()
        on.step(20)
        on.wait_for_end()
        del on.session.scene
        gc.collect()
    assert called == []


def test_subclasses_of_pymunks_classes_get_their_state_back_without_their_constructors():
    class Ball(pymunk.Body):
        def __init__(self, space, x):
            super().__init__(1, 1)
            self.position = x, 0
            space.add(self, pymunk.Circle(self, 0.2))

    class Rope(pymunk.PinJoint):
        def __init__(self, space):
            super().__init__(Ball(space, 0), Ball(space, 1))
            self.rest = 3
            space.add(self)

    space = pymunk.Space()
    rope = Rope(space)
    with played(space) as on:
        rope.distance = 3
        rope.rest = 4
        rope.a.position = (9, 9)
        assert on.do("reset") is None
        assert (rope.distance, rope.rest, rope.a.position) == (1, 3, (0, 0))
        assert len(space.bodies) == 2


def asleep(space):
    return [body.is_sleeping for body in space.bodies]


def sleeping_stack(rows=3):
    """A stack of boxes that sleeps."""
    space = pymunk.Space()
    space.gravity, space.sleep_time_threshold = (0, -9.81), 0.3
    floor = pymunk.Segment(space.static_body, (-20, -0.1), (20, -0.1), 0.1)
    floor.friction = 1
    space.add(floor)
    for row in range(rows):
        body = pymunk.Body(1, 1 / 6)
        body.position = 0, 0.5 + row
        shape = pymunk.Poly.create_box(body, (1, 1))
        shape.friction = 1
        space.add(body, shape)
    for _ in range(300):
        space.step(1 / 60)
    assert all(asleep(space))
    return space


@pytest.mark.parametrize("shape", ["round", "square"])
def test_obstacle_on_a_sleeping_body_pushes_it_away_and_removed_lets_it_fall(shape):
    with played(sleeping_stack()) as on:
        assert on.do("obstacle", shape=shape, x=0.6, y=0.5, size=0.8) is None
        assert not any(asleep(on.scene.space))
        on.run(4.0)
        lowest = next(iter(on.scene.space.bodies))
        # The obstacle reaches to 0.2, and half of the box is 0.5.
        assert lowest.position.x == pytest.approx(-0.3, abs=0.15)
        assert on.do("reset") is None
        assert all(asleep(on.scene.space))
        assert on.do("obstacle", shape=shape, x=9.0, y=0.5, size=0.8) is None
        assert all(asleep(on.scene.space))
    space = sleeping_stack(1)
    body = next(iter(space.bodies))
    with played(space) as on:
        body.position = 5, 2.4
        assert on.do("obstacle", shape="square", x=5.0, y=1.5, size=1.0) is None
        on.run(3.0)
        assert (body.is_sleeping, body.position.y) == (True, pytest.approx(2.5, abs=0.1))
        assert on.do("remove", obstacle=1) is None
        on.run(3.0)
        assert body.position.y == pytest.approx(0.5, abs=0.1)


def friction(space, value):
    for shape in space.static_body.shapes:
        shape.surface_velocity = value, 0


def open_floor(space):
    for shape in space.static_body.shapes:
        shape.filter = pymunk.ShapeFilter(mask=0)


def test_controls_take_effect_on_a_sleeping_stack_and_a_cut_joint_lets_a_sleeping_body_fall():
    controls = [
        Slider("belt", -9, 9, 0, action=friction),
        Button("Open", open_floor),
        Key("o", print, open_floor),
    ]
    for action in (
        {"do": "set", "name": "gravity", "value": 2.0},
        {"do": "set", "name": "belt", "value": 3.0},
        {"do": "press", "name": "Open", "down": True},
        {"do": "press", "name": "o", "down": False},
    ):
        with played(space_scene(sleeping_stack, PlaySettings(controls=controls))) as on:
            assert on.do(action.pop("do"), **action) is None
            assert not any(asleep(on.scene.space)), action
    space = sleeping_stack(1)
    body = pymunk.Body(1, 1)
    body.position = 5, 3
    space.add(
        body, pymunk.Circle(body, 0.2), pymunk.PinJoint(space.static_body, body, (5, 5), (0, 0))
    )
    with played(space) as on:
        on.run(2.0)
        assert body.is_sleeping
        assert on.do("cut", x=5.0, y=4.0, slip=0.1) is None
        on.run(2.0)
        assert body.position.y < 1


def test_slider_of_gravity_in_a_space_without_points_down_on_the_screen():
    for y_down, sign in ((True, 1), (False, -1)):
        source = space_scene(
            lambda: pymunk.Space(),
            PlaySettings(controls=[Slider("gravity", -9, 9, 0)], y_down=y_down),
        )
        with played(source) as on:
            for value in (5.0, 0.0, -3.0, 4.0):
                assert on.do("set", name="gravity", value=value) is None
                assert on.scene.space.gravity == (0, sign * value)


def fail(*_):
    return 1 / 0


class Failing:
    """A function that fails when it is told to."""

    def __init__(self, result=None):
        self.fails, self.result = False, result

    def __call__(self, *_):
        if self.fails:
            return 1 / 0
        return self.result() if self.result else None


def test_session_goes_on_after_an_error_in_each_function_of_the_users():
    builds = Failing(lambda: falling(2))
    steps = Failing()
    presses = Failing()
    moves = Failing()
    ups = Failing()
    begins = Failing()
    plots = Failing(lambda: 3.0)
    events = []

    def make():
        space = builds()
        space.on_collision(pre_solve=lambda *_: begins())
        return space

    controls = [
        Button("b", lambda space: presses()),
        Slider("s", 0, 9, action=lambda space, value: moves()),
    ]
    controls.append(Key("k", print, lambda space: ups()))
    play = PlaySettings(
        on_step=steps, controls=controls, plots={"p": lambda space: plots()}, events=events
    )
    with played(space_scene(make, play)) as on:
        for failing, action, arguments in (
            (builds, "reset", {}),
            (steps, "step", {"count": 1}),
            (begins, "step", {"count": 20}),
            (plots, "play", {}),
            (presses, "press", {"name": "b", "down": True}),
            (moves, "set", {"name": "s", "value": 3.0}),
            (ups, "press", {"name": "k", "down": False}),
        ):
            on.told.clear()
            failing.fails = True
            on.do(action, **arguments)
            while not on.errors or on.session.clock.running or on.session.clock.single_steps:
                on.settle()
            assert ["ZeroDivisionError" in error for error in on.errors] == [True]
            failing.fails = False
            for _ in range(2):
                assert on.step(3) == 3
                assert on.do("reset") is None
        on.told.clear()
        events += ["one", 3, None]
        on.step(3)
        assert_says(ValueError(on.errors[0]), "events")
        assert (on.events, events) == (["one"], [])
        assert on.step(3) == 3


@pytest.mark.parametrize(
    "result", [None, 3, [pymunk.Space()]], ids=lambda value: type(value).__name__
)
def test_function_that_builds_no_space_at_a_reset_is_named_and_the_old_scene_goes_on(result):
    spaces = [falling(2), result, falling(3)]
    with played(space_scene(lambda: spaces.pop(0), PlaySettings())) as on:
        assert_says(ValueError(on.do("reset")), "build")
        assert on.step(3) == 3
        assert len(on.scene.poses()) == 2
        assert on.do("reset") is None
        assert len(on.scene.poses()) == 3


@pytest.mark.parametrize("watched", [False, True])
def test_program_with_a_loop_of_its_own_gets_its_errors_and_goes_on(watched, capfd):
    space, called = falling(2), []

    def begin(arbiter, space, data):
        called.append(1)
        raise KeyError("mine")

    space.on_collision(begin=begin)
    plots, told = {"p": fail}, []
    session = Session(
        space_scene(
            lambda: space, PlaySettings(step=None, plots=plots, controls=[Button("b", fail)])
        )
    )
    if watched:
        session.join(Listener(session, told))
        assert not told[0]["resets"]
    Listener(session, []).do("press", name="b", down=True)
    errors = []
    for _ in range(60):
        try:
            session.step(1 / 60)
        except KeyError as error:
            errors += error.args
    # Both bodies begin to touch the floor.
    assert (set(errors), len(called)) == ({"mine"}, 2)
    kinds = {message["text"].split(":")[0] for message in told if message["kind"] == "error"}
    assert kinds == ({"KeyError", "ZeroDivisionError"} if watched else set())
    assert capfd.readouterr().err == ""
    session.stop()


def test_exit_in_a_function_of_the_users_ends_the_session_and_what_its_clients_see():
    def leave(space):
        raise SystemExit

    ended = threading.Event()
    with played(space_scene(build, PlaySettings(controls=[Button("Quit", leave)]))) as on:
        client = Listener(on.session, [])
        client.stop = ended.set
        on.session.join(client)
        client.do("press", name="Quit", down=True)
        assert ended.wait(PATIENCE)


@pytest.mark.parametrize(
    "value",
    [None, "3 m", [1.0], np.zeros(2), np.zeros(1), 1j, pymunk.Vec2d(1, 2)],
    ids=lambda value: repr(value),
)
def test_message_about_a_chart_without_a_number_names_the_chart_and_the_value(value):
    with played(
        space_scene(build, PlaySettings(plots={"Height of the ball": lambda space: value}))
    ) as on:
        with pytest.raises(ParameterError) as raised:
            on.scene.plots()
        assert_says(raised.value, "Height of the ball", repr(value)[:5])


def test_message_about_a_chart_that_fails_names_the_chart_and_the_line():
    with played(space_scene(build, PlaySettings(plots={"Height of the ball": fail}))) as on:
        on.do("play")
        while not on.errors:
            on.settle()
        [error] = [message for message in on.told if message["kind"] == "error"]
        assert "Height of the ball" in error["text"]
        assert error["place"].endswith("return 1 / 0")


def test_charts_take_all_kinds_of_numbers():
    values = {
        "a": 3,
        "b": True,
        "c": np.float32(2),
        "d": np.True_,
        "e": math.nan,
        "f": 10**400,
        "g": np.int8(4),
    }
    plots = {name: lambda space, value=value: value for name, value in values.items()}
    with played(space_scene(build, PlaySettings(plots=plots))) as on:
        found = [on.scene.plots()[name] for name in plots]
        assert found == [3, 1, 2, 1, pytest.approx(math.nan, nan_ok=True), math.inf, 4]
        assert on.frame()


@pytest.mark.parametrize(
    "keywords",
    [{"on_step": 5}, {"plots": {"a": 3}}, {"plots": ["a"]}, {"events": ("a",)}, {"events": "a"}],
    ids=lambda keywords: repr(keywords),
)
def test_functions_that_cannot_be_called_and_events_that_are_no_list_are_refused(keywords):
    with pytest.raises(DragonError) as raised:
        live(build, browser=False, **keywords)
    assert_says(raised.value, *keywords)


def resting():
    """A ball that hangs on a pivot and falls asleep."""
    space = pymunk.Space()
    space.gravity = 0, -9.81
    space.sleep_time_threshold = 0.1
    ball = pymunk.Body(1, 1)
    ball.position = 0, -1
    space.add(ball, pymunk.Circle(ball, 0.1), pymunk.PinJoint(space.static_body, ball))
    return space


def test_no_body_sleeps_in_a_space_that_is_discarded():
    # Pymunk 7.3.1 reads memory that was freed where a body with a joint does.
    with played(resting) as on:
        discarded = []
        for _ in range(2):
            on.step(30)
            discarded.append(on.scene.space)
            assert all(body.is_sleeping for body in discarded[-1].bodies)
            on.do("reset")
            assert not any(body.is_sleeping for body in discarded[-1].bodies)
        on.step(30)
        discarded.append(on.scene.space)
        on.wait_for_end()
    assert not any(body.is_sleeping for body in discarded[-1].bodies)
