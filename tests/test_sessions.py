"""Live sessions: what a hand does to a scene, replays to the bit, and a server that clients cannot bring down."""

from __future__ import annotations

import asyncio
import errno
import json
import math
import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
import numpy as np
import pymunk
import pytest
from conftest import assert_says
from live_sessions import joined, played, replayed, served
from PIL import Image

from pymunk_dragon.errors import DragonError, MissingExtraError
from pymunk_dragon.model.curves import Line
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate
from pymunk_dragon.sessions import live
from pymunk_dragon.sessions.log import InputLog, Log, as_text
from pymunk_dragon.sessions.messages import ACTIONS
from pymunk_dragon.sessions.recording import record, save
from pymunk_dragon.sessions.scenes import SCENES, dragon, planned, ready
from pymunk_dragon.sessions.session import SPEEDS, Session

SHORT = March(Dragon(benches=20))
# Measurements of time, of which one must be within its limit: another program may take the processor.
ATTEMPTS = range(3)


# ---- replays


def touch_a_dragon(on):
    """Everything that a hand can do to a dragon, between some steps."""
    head = on.scene.poses()[0]
    other = on.scene.poses()[9]
    for action, arguments in (
        ("grab", {"body": 0, "x": head[0], "y": head[1] + 0.1}),
        ("drag", {"x": head[0] + 0.5, "y": head[1] + 0.7}),
        ("drag", {"x": head[0] - 0.25, "y": head[1] + 1 / 3}),
        ("drop", {}),
        ("set", {"name": "iterations", "value": 17.0}),
        ("set", {"name": "step", "value": 7.3}),
        ("set", {"name": "drag", "value": 4.4}),
        ("set", {"name": "speed", "value": 1.3}),
        ("release", {"bench": 8}),
        ("grab", {"body": 9, "x": other[0], "y": other[1]}),
        ("drag", {"x": other[0] + 2.0, "y": other[1] - 1.0}),
        ("obstacle", {"shape": "round", "x": head[0], "y": head[1] + 1.5, "size": 0.4}),
        ("obstacle", {"shape": "square", "x": head[0] + 2, "y": head[1] - 1, "size": 0.7}),
        ("contacts", {"value": "report"}),
        ("remove", {"obstacle": 1}),
        ("contacts", {"value": "resolve"}),
        ("cut", {"joint": 13}),
        ("drop", {}),
        ("hold", {}),
    ):
        assert on.do(action, **arguments) is None, action
        on.step(23)


def touch_a_space(on):
    """Everything that a hand can do to another space."""
    body = len(on.scene.bodies) - 1
    x, y, _ = on.scene.poses()[body].tolist()
    for action, arguments in (
        ("grab", {"body": body, "x": x, "y": y}),
        ("drag", {"x": x + 1.0, "y": y + 1.5}),
        ("obstacle", {"shape": "round", "x": x + 0.3, "y": y - 2.0, "size": 0.5}),
        ("set", {"name": "gravity", "value": 0.5}),
        ("set", {"name": "damping", "value": 0.9}),
        ("set", {"name": "iterations", "value": 5.0}),
        ("drag", {"x": x - 3.0, "y": y - 0.5}),
        ("obstacle", {"shape": "square", "x": x - 2.0, "y": y - 2.0, "size": 0.5}),
        ("set", {"name": "step", "value": 6.0}),
        ("drop", {}),
        ("remove", {"obstacle": 1}),
    ):
        assert on.do(action, **arguments) is None, action
        on.step(31)
    if on.scene.joints:
        assert on.do("cut", joint=1) is None
        on.step(50)


def run(coroutine):
    """`asyncio.run` in a thread: a browser of another test may have a loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, coroutine).result()


@pytest.fixture(scope="module", params=["dragon", "pendulum", "boxes"])
def touched(request):
    """A log of a session in which everything was done, and the session."""
    source = dragon(SHORT) if request.param == "dragon" else ready(request.param)
    with played(source, record=True) as on:
        (touch_a_dragon if request.param == "dragon" else touch_a_space)(on)
    return Log.of(on.session), on.session


def test_replay_ends_in_the_same_state_to_the_bit(touched):
    log, _ = touched
    poses, session = replayed(log)
    assert poses == log.poses
    assert list(session.inputs) == log.inputs


def test_replay_of_other_inputs_ends_elsewhere(touched):
    log, _ = touched
    step, message = log.inputs[1]
    log.inputs[1] = step, {**message, "x": message["x"] + 1e-6}
    poses, _ = replayed(log)
    log.inputs[1] = step, message
    assert poses != log.poses


def test_recordings_as_npz_and_json_are_the_same_log(touched, tmp_path):
    log, session = touched
    record(session, tmp_path / "session.npz")
    (tmp_path / "session.json").write_text(log.to_json())
    for name in ("session.npz", "session.json"):
        read = Log.load(tmp_path / name)
        assert json.loads(read.to_json()) == json.loads(log.to_json())
        assert replayed(read)[0] == log.poses


def test_inputs_after_the_last_step_are_replayed_too_and_the_session_can_be_touched_afterwards():
    with played(dragon(SHORT)) as on:
        on.step(5)
        on.do("cut", joint=3)
        log = Log.of(on.session)
    poses, session = replayed(log)
    assert poses == log.poses
    assert session.scene.cuts == [3]
    assert not session.state()["replaying"]


def test_replay_without_steps_ends_at_once():
    with played(dragon(SHORT)) as on:
        on.do("obstacle", shape="round", x=1.0, y=2.0, size=0.3)
        log = Log.of(on.session)
    assert log.steps == 0
    poses, session = replayed(log)
    assert poses == log.poses
    assert len(session.scene.obstacles) == 1


@pytest.mark.parametrize(
    "message",
    [{"do": "cut", "joint": 10**6}, {"do": "set", "name": "benches", "value": 3.0}, {"do": "remove", "obstacle": 7}],
    ids=lambda message: message["do"],
)
def test_replay_with_an_impossible_input_ends_and_tells_which(message):
    with played(dragon(SHORT)) as on:
        on.step(20)
        log = Log.of(on.session)
    log.inputs.append((7, message))
    on_replay = []
    session = replay_session(log, on_replay)
    with pytest.raises(DragonError, match="before step 7"):
        session.wait_for_replay()
    session.stop()
    assert not session.state()["replaying"]
    [error] = [told["text"] for told in on_replay if told["kind"] == "error"]
    assert_says(DragonError(error), "before step 7")


def test_replay_goes_on_where_the_recorded_session_paused_at_a_contact():
    march = March(Dragon(benches=12), Line(start=(-30.0, 0.0), stop=(30.0, 0.0)), start_s=28.0)
    with played(dragon(march, contacts="stop")) as on:
        on.do("obstacle", shape="square", x=2.0, y=0.1, size=1.0)
        assert on.step(1000) < 1000
        assert on.step(50) == 50
        log = Log.of(on.session)
    assert replayed(log)[0] == log.poses


def test_replay_in_which_bodies_fly_apart_ends_with_an_error():
    with played("pendulum") as on:
        on.step(40)
        log = Log.of(on.session)
    session = Session(planned(log.plan))
    session.play_again(log.inputs, log.values, log.steps)
    session.scene.bodies[0].velocity = math.nan, 0.0
    session.start()
    with pytest.raises(DragonError, match="flew apart"):
        session.wait_for_replay()
    session.stop()


def replay_session(log, told):
    session = Session(planned(log.plan))
    session.tell = told.append
    session.speed = 20.0
    session.play_again(log.inputs, log.values, log.steps)
    session.start()
    return session


def test_inputs_are_refused_during_a_replay_and_change_nothing():
    with played(dragon(SHORT)) as on:
        on.step(300)
        on.do("cut", joint=5)
        on.step(1)
        log = Log.of(on.session)
    session = replay_session(log, [])
    errors = []
    session.post({"do": "cut", "joint": 2}, errors.append)
    assert session.wait_for_replay() == log.poses
    session.stop()
    assert len(errors) == 1
    assert session.scene.cuts == [5]


def test_another_scene_ends_a_replay():
    with played(dragon(SHORT)) as on:
        on.step(3000)
        on.do("cut", joint=5)
        log = Log.of(on.session)
    session = replay_session(log, [])
    session.post({"do": "scene", "name": "pendulum"})
    assert session.wait_for_replay() is None
    session.stop()
    assert session.source.name == "pendulum"
    assert not session.state()["replaying"]


def test_space_of_ones_own_has_no_plan_to_replay():
    space = pymunk.Space()
    with played(space) as on:
        on.step(3)
    assert Log.of(on.session).plan is None


# ---- the dragon


def test_position_error_of_the_untouched_dragon_stays_below_a_hundredth_of_a_millimetre():
    with played("dragon") as on:
        for _ in range(10):
            on.run(1.0)
            assert on.frame().errors.max() < 1e-5
        assert on.frame().time == pytest.approx(10.0)
        assert on.frame().march_time == pytest.approx(10.0)


def test_without_dancers_bench_1_meets_bench_28_at_the_time_of_simulate_and_the_session_pauses():
    with played("unguided") as on:
        made = on.step(2000)
        assert made < 2000
        assert on.events == ["benches 1 and 28 touch"]
        assert on.scene.time == pytest.approx(10.894, abs=0.05)
        assert not on.session.state()["running"]
        frame = on.frame()
        assert {tuple(sorted(pair)) for pair in frame.contacts[:, :2].tolist()} == {(1, 28)}


def test_tail_behind_a_cut_joint_stays_while_the_head_goes_on():
    with played("dragon") as on:
        on.run(1.0)
        assert on.do("cut", joint=100) is None
        on.run(2.0)
        before = on.frame()
        on.run(0.5)
        after = on.frame()
        speeds = np.hypot(*(after.poses - before.poses)[:, :2].T) / (after.time - before.time)
        assert speeds[101:].max() < 0.01
        assert speeds[:100].min() > 0.5
        assert on.session.state()["cuts"] == [100]
        assert after.forces[100] == 0


def test_dancers_who_come_back_bring_every_bench_to_the_exact_model():
    with played("dragon") as on:
        on.run(0.5)
        assert on.do("release", bench=1) is None
        assert on.session.state()["free_from"] == 1
        on.run(3.0)
        assert on.frame().errors.max() > 0.01
        assert on.do("hold") is None
        on.run(10.0)
        assert on.session.state()["free_from"] is None
        assert on.frame().errors.max() < 0.01


@pytest.mark.parametrize("contacts", ["resolve", "report", "stop"])
def test_obstacle_in_the_way_stops_the_march_only_if_contacts_push_apart(contacts):
    with played("jam") as on:
        assert on.do("contacts", value=contacts) is None
        on.run(4.0)
        march_time, x = on.frame().march_time, on.frame().poses[0, 0]
        touches = [event for event in on.events if "obstacle" in event]
        assert touches[0] == "bench 0 and an obstacle touch"
        if contacts == "stop":
            assert not on.session.running
            assert len(touches) == 1
            assert on.scene.time < 11
            return
        on.run(3.0)
        moved, marched = on.frame().poses[0, 0] - x, on.frame().march_time - march_time
        if contacts == "resolve":
            assert abs(moved) < 0.01
            assert marched < 0.1
        else:
            assert moved == pytest.approx(3.0, abs=0.02)
            assert marched == pytest.approx(3.0, abs=0.02)


def test_march_goes_on_when_the_obstacle_is_removed():
    with played("jam") as on:
        on.run(12.0)
        march_time = on.frame().march_time
        assert on.do("remove", obstacle=1) is None
        on.run(4.0)
        assert on.frame().march_time > march_time + 2
        assert on.frame().errors.max() < 0.001


# ---- hands and sliders


def test_held_rod_follows_the_hand():
    with played("pendulum") as on:
        x, y, _ = on.scene.poses()[0].tolist()
        assert on.do("grab", body=0, x=x + 0.5, y=y) is None
        assert on.do("drag", x=0.6, y=0.8) is None
        on.run(2.0)
        _, anchor_x, anchor_y, target_x, target_y = on.frame().held
        assert (anchor_x, anchor_y) == pytest.approx((0.5, 0.0))
        assert (target_x, target_y) == pytest.approx((0.6, 0.8))
        end = on.scene.bodies[0].local_to_world((0.5, 0.0))
        assert end.get_distance((0.6, 0.8)) < 0.02
        assert on.do("drop") is None
        assert on.frame().held is None


def test_hand_pulls_with_at_most_1000_newtons_per_kilogram():
    space = pymunk.Space()
    body = pymunk.Body(3.0, 1.0)
    space.add(body, pymunk.Circle(body, 0.5))
    with played(space) as on:
        on.do("grab", body=0, x=0.0, y=0.0)
        on.do("drag", x=1e6, y=-1e6)
        on.step(1)
        assert body.velocity.length == pytest.approx(1000 * on.scene.step_length, rel=1e-6)
        on.step(30)
        assert body.velocity.length <= 1000 * on.scene.time * (1 + 1e-9)


def test_only_dynamic_bodies_can_be_held():
    space = pymunk.Space()
    mover = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    space.add(mover, pymunk.Circle(mover, 1))
    with played(space) as on:
        assert_says(ValueError(on.do("grab", body=0, x=0.0, y=0.0)), "body")
        assert_says(ValueError(on.do("grab", body=1, x=0.0, y=0.0)), "body")
        assert_says(ValueError(on.do("grab", body=-1, x=0.0, y=0.0)), "body")
        assert list(space.constraints) == []


@pytest.mark.parametrize(("name", "value"), [("benches", 12.0), ("pitch", 0.7), ("width", 0.25)])
def test_sliders_that_rebuild_begin_anew_with_their_value(name, value):
    with played(dragon(SHORT)) as on:
        on.step(10)
        generation = on.session.generation
        assert on.do("set", name=name, value=value) is None
        assert on.session.generation == generation + 1
        assert on.scene.steps == 0
        assert on.session.state()["values"][name] == value
        described = on.session.description()
        if name == "benches":
            assert len(described["bodies"]) == len(described["dragon"]["lengths"]) == 12
        if name == "width":
            assert set(described["dragon"]["widths"]) == {0.25}
        on.run(0.5)
        assert on.frame().errors.max() < 1e-4
        log = Log.of(on.session)
    assert replayed(log)[0] == log.poses


def test_values_out_of_range_are_refused_with_one_line_and_change_nothing():
    for source in (dragon(SHORT), ready("boxes")):
        with played(source) as on:
            on.step(3)
            before, log = on.session.state(), Log.of(on.session)
            for each in on.scene.parameters:
                for value in (each.low - 1.0, each.high + 1.0, math.nan, math.inf, -math.inf, 1e308, -1e308):
                    assert_says(ValueError(on.do("set", name=each.name, value=value)), each.name)
                if each.whole:
                    assert_says(ValueError(on.do("set", name=each.name, value=each.low + 0.5)), each.name)
            assert_says(ValueError(on.do("set", name="shoe size", value=1.0)), "name")
            assert on.session.state() == before
            assert Log.of(on.session) == log


IMPOSSIBLE = [
    ("cut", {"joint": -1}),
    ("cut", {"joint": 10**9}),
    ("remove", {"obstacle": 1}),
    ("contacts", {"value": "x"}),
    ("release", {"bench": 0}),
    ("release", {"bench": 20}),
    ("obstacle", {"shape": "star", "x": 0.0, "y": 0.0, "size": 1.0}),
    ("obstacle", {"shape": "round", "x": math.nan, "y": 0.0, "size": 1.0}),
    ("obstacle", {"shape": "round", "x": 0.0, "y": 0.0, "size": 0.0}),
    ("grab", {"body": 0, "x": math.inf, "y": 0.0}),
    ("drag", {"x": 1e300, "y": 0.0}),
    ("step", {"count": 0}),
    ("speed", {"value": 0.0}),
    ("speed", {"value": 1e9}),
    ("speed", {"value": math.nan}),
    ("scene", {"name": "../etc"}),
]


@pytest.mark.parametrize("source", [dragon(SHORT), ready("boxes")], ids=["dragon", "boxes"])
def test_messages_for_things_that_do_not_exist_are_refused_with_one_line(source):
    with played(source) as on:
        before = on.session.state()
        for action, arguments in IMPOSSIBLE:
            assert_says(ValueError(on.do(action, **arguments)))
        assert on.session.state() == before
        assert list(on.session.inputs) == []


def test_reset_undoes_everything():
    with played(dragon(SHORT)) as on:
        fresh = on.session.state(), on.session.poses()
        touch_a_dragon(on)
        assert on.do("reset") is None
        state = on.session.state()
        assert state.pop("generation") == fresh[0].pop("generation") + 1
        assert (state, on.session.poses()) == fresh
        assert (on.scene.steps, on.scene.time, list(on.session.inputs)) == (0, 0.0, [])


def test_reset_undoes_everything_in_a_space_of_ones_own():
    space = pymunk.Space()
    space.gravity = 0, -10
    before = space.static_body
    for link in range(2):
        body = pymunk.Body(1.0, 0.1)
        body.position = link + 0.5, 0
        space.add(body, pymunk.Circle(body, 0.3), pymunk.PivotJoint(before, body, (link, 0)))
        before = body
    with played(space) as on:
        fresh, poses = on.session.state(), on.session.poses()
        touch_a_space(on)
        on.do("grab", body=0, x=0.5, y=0.0)
        on.step(7)
        assert on.do("reset") is None
        state = on.session.state()
        assert state.pop("generation") == fresh.pop("generation") + 1
        assert (state, on.session.poses()) == (fresh, poses)
        assert len(space.shapes) == 2
        assert len(space.constraints) == 2
        assert space.gravity == (0, -10)
        assert all(joint.max_force == math.inf for joint in space.constraints)
        assert all(body.velocity == (0, 0) for body in space.bodies)
        on.run(0.5)
        assert on.scene.joints[0].impulse > 0
        assert on.scene.bodies[0].position.length == pytest.approx(0.5, abs=0.02)


def test_time_goes_on_at_each_speed_with_each_step_that_a_slider_offers():
    for name in ("boxes", "sloppy-engine", "robot-arm"):
        session = Session(SCENES[name])
        step = next(each for each in session.scene.parameters if each.name == "step")
        session.start()
        session.post({"do": "speed", "value": 2 * SPEEDS[0]})
        session.post({"do": "set", "name": "step", "value": step.high})
        for _ in range(1000):
            if session.scene.steps:
                break
            time.sleep(0.01)
        session.stop()
        assert session.scene.steps > 0, name


@pytest.mark.parametrize("name", ["pendulum", "cradle"])
def test_bodies_that_swing_stay_in_the_field_that_is_shown_at_first(name):
    with played(name) as on:
        centre, size = (np.array(on.scene.field[key]) for key in ("centre", "size"))
        for _ in range(60):
            on.run(0.05)
            away = np.abs(on.scene.poses()[:, :2] - centre)
            assert (away <= size / 2).all()


# ---- messages


def any_json(dice, depth=0):
    """A random JSON value, nan and infinities included."""
    kind = dice.randrange(12 if depth < 4 else 9)
    if kind >= 9:
        values = [any_json(dice, depth + 1) for _ in range(dice.randrange(4))]
        return values if kind == 9 else {dice.choice(["do", "x", "y", "value", "", "\u2028"]): each for each in values}
    return dice.choice(
        [None, True, False, 0, -1, 10**400, 2**63, 1e308, math.nan, math.inf, -math.inf, "", "a" * 99, "\ud800", 0.5]
    )


def valid(dice, bodies):
    """A message that is formed as it should be, with random arguments."""
    action = dice.choice([name for name in ACTIONS if name not in ("scene", "ping")])
    number = dice.choice([0.0, -0.0, 1.5, -3.0, 1e-300, 1e6, 1e308, math.nan, math.inf, dice.gauss(0, 5)])
    values = {
        int: dice.choice([0, 1, -1, 3, dice.randrange(bodies), 10**18, -(10**30)]),
        float: number,
        str: dice.choice(["", "step", "iterations", "drag", "speed", "stop", "report", "resolve", "round", "square"]),
        bool: dice.random() < 0.5,
    }
    return {"do": action} | {name: values[kind] for name, kind in ACTIONS[action].items()}


def malformed(dice, bodies):
    """A text that is no message."""
    kind = dice.randrange(6)
    message = valid(dice, bodies)
    if kind == 0:
        text = json.dumps(any_json(dice))
        return text if text not in ('{"do": "play"}',) else "{}"
    if kind == 1:
        return dice.choice(
            ["", "{", "[" * 4000, '{"do":' * 600, "\x00", "nan", '{"do": "play"} x', "9" * 4096, "\ufeff{}"]
        )
    if kind == 2:
        return "x" * 4097
    if kind == 3:
        return json.dumps({**message, "more": any_json(dice)})
    if kind == 4:
        return json.dumps(
            {**message, "do": dice.choice(["__init__", "advance", "PLAY", "", "eval", "_rebuild", "to_dict"])}
        )
    name = dice.choice([*message])
    return json.dumps({key: value for key, value in message.items() if key != name} | {name: [None]})


@pytest.mark.parametrize("clients", [3, pytest.param(21, marks=pytest.mark.thorough)])
def test_random_messages_crash_nothing_and_each_malformed_one_is_answered(clients, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failures = []
    monkeypatch.setattr(threading, "excepthook", failures.append)

    async def attack(session, seed):
        dice = random.Random(seed)
        watches = seed % 2 == 1
        async with joined(session.watch_address if watches else session.address) as client:
            bad = 0
            # A client may send 500 in a second.
            for _ in range(480):
                if dice.random() < 0.6:
                    bad += 1
                    await client.socket.send_str(malformed(dice, 20))
                elif dice.random() < 0.2:
                    bad += 1
                    await client.socket.send_bytes(dice.randbytes(dice.randrange(100)))
                else:
                    message = valid(dice, 20)
                    # Who watches may do nothing else.
                    bad += watches and message["do"] != "ping"
                    await client.socket.send_str(json.dumps(message))
            await client.send("ping", id=-1)
            await client.told("pong", id=-1)
            # Who controls may also be answered that a body or a joint does not exist.
            assert client.errors == bad or (client.errors > bad and not watches)

    async def all_attacks(session):
        await asyncio.gather(*(attack(session, seed) for seed in range(clients)))
        async with joined(session.address) as client:
            # Messages of before may still wait.
            for _ in range(100):
                await client.send("scene", name="pendulum")
                answer = await client.get(lambda found: isinstance(found, dict) and found["kind"] in ("scene", "error"))
                if answer.get("name") == "pendulum":
                    break
                await asyncio.sleep(0.1)
            await client.send("reset")
            await client.send("play")
            await client.send("speed", value=1.0)
            first = await client.shown(lambda frame: frame.rate > 0)
            await client.shown(lambda frame: frame.time > first.time + 0.3)

    with served(dragon(SHORT)) as session:
        run(all_attacks(session))
    assert failures == []
    assert list(tmp_path.iterdir()) == []


def test_too_large_a_message_closes_its_connection_only():
    async def talk(address):
        async with joined(address) as client, joined(address) as other:
            await client.socket.send_str("x" * 100_000)
            with pytest.raises(ConnectionError):
                await client.told("pong")
            await other.send("ping", id=3)
            await other.told("pong", id=3)

    with served() as session:
        run(talk(session.address))


# ---- who may connect


def test_requests_without_the_token_of_other_hosts_and_of_other_pages_are_refused():
    async def ask(address, host, origin, token):
        page = address.partition("?")[0]
        headers = {} if host is None else {"Host": host}
        if origin is not None:
            headers["Origin"] = origin
        query = "" if token is None else f"?token={token}"
        found = set()
        async with aiohttp.ClientSession() as http:
            for path in ("", "inputs", "run"):
                async with http.get(f"{page}{path}{query}", headers=headers) as answer:
                    found.add(answer.status)
            try:
                async with http.ws_connect(f"{page}socket{query}", headers=headers):
                    found.add(200)
            except aiohttp.WSServerHandshakeError as error:
                found.add(error.status)
        [status] = found
        return status

    with served(allow_hosts=["Hub.example"]) as session:
        session._session.post({"do": "record"})
        session._session.post({"do": "finish"})
        address, token = session.address, session.address.partition("token=")[2]
        watch = session.watch_address.partition("token=")[2]
        own = address.partition("//")[2].partition("/")[0]
        for host, origin, given, status in (
            (None, None, token, 200),
            (None, None, watch, 200),
            (None, f"http://{own}", token, 200),
            ("localhost", None, token, 200),
            ("hub.example", "https://hub.example", token, 200),
            ("hub.example:443", None, token, 200),
            # A proxy that replaces the host and keeps the origin.
            (None, "https://hub.example", token, 200),
            (None, "https://hub.example", None, 403),
            (None, None, None, 403),
            (None, None, "", 403),
            (None, None, "x", 403),
            (None, None, "%C3%A9%00", 403),
            (None, None, token[:-1], 403),
            (None, None, token + "&token=x", 200),
            (None, None, "x&token=" + token, 403),
            ("evil.example", None, token, 403),
            ("127.0.0.1.evil.example", None, token, 403),
            ("evil.example:" + own.partition(":")[2], "http://evil.example", token, 403),
            ("192.0.2.7", None, token, 403),
            ("[", None, token, 403),
            ("a@[:1", None, token, 403),
            (None, "http://evil.example", token, 403),
            (None, "http://hub.example.evil.example", token, 403),
            (None, "null", token, 403),
            (None, "http://[", token, 403),
            (None, f"http://{own}.evil.example", token, 403),
            (None, "http://127.0.0.1:1", token, 403),
        ):
            assert run(ask(address, host, origin, given)) == status, (host, origin, given)


def test_page_has_a_policy_without_unsafe_inline_and_is_not_stored():
    async def ask(address):
        async with aiohttp.ClientSession() as http, http.get(address) as answer:
            return answer.headers, await answer.text()

    with served() as session:
        headers, page = run(ask(session.address))
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe" not in policy
    assert headers["Cache-Control"] == "no-store"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "http://" not in page.replace("http://www.w3.org/", "")
    assert "{{" not in page


def test_watchers_control_nothing():
    async def talk(session):
        async with joined(session.watch_address) as client:
            assert (await client.told("scene"))["role"] == "watch"
            before = await client.told("state")
            for action, arguments in (
                ("pause", {}),
                ("reset", {}),
                ("cut", {"joint": 1}),
                ("speed", {"value": 5.0}),
                ("scene", {"name": "boxes"}),
                ("grab", {"body": 0, "x": 0.0, "y": 0.0}),
                ("set", {"name": "gravity", "value": 0.0}),
            ):
                await client.send(action, **arguments)
                assert (await client.told("error"))["text"] == "this address only watches"
            await client.send("ping", id=1)
            await client.told("pong", id=1)
        async with joined(session.address) as client:
            assert (await client.told("scene"))["role"] == "control"
            after = await client.told("state", clients=1)
            assert after == before
            await client.send("pause")
            await client.told("state", running=False)

    with served() as session:
        run(talk(session))


def test_body_is_dropped_even_if_too_many_messages_wait():
    session = Session(ready("pendulum"))
    errors = []
    session.post({"do": "grab", "body": 0, "x": 0.5, "y": 0.0})
    for _ in range(2000):
        session.post({"do": "drag", "x": 1.0, "y": 0.0}, errors.append)
    session.post({"do": "drop"}, always=True)
    assert set(errors) == {"too many messages at once"}
    session.start()
    while not session.scene.steps:
        time.sleep(0.01)
    session.stop()
    assert list(session.inputs)[-1] == (0, {"do": "drop"})


# ---- many clients


def test_20_clients_watch_and_see_the_same_motion():
    async def watch(address):
        async with joined(address) as client:
            scene = await client.told("scene")
            await client.told("state", clients=20)
            first = await client.shown()
            last = await client.shown(lambda frame: frame.time >= first.time + 0.5)
            assert first.generation == last.generation == scene["generation"]
            assert not np.array_equal(first.poses, last.poses)

    async def all_watch(address):
        await asyncio.gather(*(watch(address) for _ in range(20)))

    with served() as session:
        run(all_watch(session.watch_address))


def connected(address):
    """A socket that has become a WebSocket, and is not read."""
    url = urlsplit(address)
    found = socket.create_connection((url.hostname, url.port))
    found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    found.sendall(
        f"GET /socket?{url.query} HTTP/1.1\r\nHost: {url.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    return found


def test_clients_that_never_read_slow_neither_physics_nor_others_nor_the_end():
    async def watch(address):
        async with joined(address) as client:
            first = await client.shown(lambda frame: frame.time > 0.2)
            begin = time.monotonic()
            frames = 0
            while True:
                frame = await client.shown()
                frames += 1
                if frame.time > first.time + 1.0:
                    return frames, time.monotonic() - begin

    def is_fast(attempt):
        with ExitStack() as stack:
            session = stack.enter_context(served("dragon"))
            for _ in range(8):
                stack.enter_context(connected(session.address))
            frames, passed = run(watch(session.address))
            begin = time.monotonic()
            session.stop()
            end = time.monotonic() - begin
        print(attempt, frames, passed, end)
        return frames > 20 and passed < 2.0 and end < 2.0

    assert any(map(is_fast, ATTEMPTS))


def test_client_that_floods_does_not_stop_others():
    async def flood(address, done):
        async with joined(address) as client:

            async def read():
                while not done.is_set():
                    await client.get(lambda found: True)

            reading = asyncio.create_task(read())
            while not done.is_set():
                for _ in range(100):
                    await client.send("drag", x=1.0, y=2.0)
                await asyncio.sleep(0)
            await reading

    async def talk(address):
        done = asyncio.Event()
        flooding = asyncio.create_task(flood(address, done))
        async with joined(address) as client:
            first = await client.shown(lambda frame: frame.time > 0.1)
            begin = time.monotonic()
            for number in range(20):
                await client.send("ping", id=number)
                await client.told("pong", id=number)
            await client.send("cut", joint=2)
            await client.told("state", cuts=[2])
            last = await client.shown(lambda frame: frame.time > first.time + 1.0)
            passed = time.monotonic() - begin
        done.set()
        await flooding
        return passed, last.rate

    def is_fast(attempt):
        with served() as session:
            passed, rate = run(talk(session.address))
        print(attempt, passed, rate)
        return passed < 3.0 and rate > 0.5

    assert any(map(is_fast, ATTEMPTS))


def test_body_is_dropped_when_its_holder_disconnects_and_only_then():
    async def talk(address):
        async with joined(address) as client:
            async with joined(address) as first:
                await first.send("grab", body=0, x=0.5, y=0.0)
                await client.shown(lambda frame: frame.held and frame.held[0] == 0)
            await client.shown(lambda frame: frame.held is None)
            async with joined(address) as first:
                await first.send("grab", body=0, x=0.5, y=0.0)
                await client.shown(lambda frame: frame.held and frame.held[0] == 0)
                await client.send("grab", body=2, x=2.0, y=0.0)
                await client.shown(lambda frame: frame.held and frame.held[0] == 2)
            await client.told("state", clients=1)
            await client.send("ping", id=1)
            await client.told("pong", id=1)
            last = await client.shown()
            frame = await client.shown(lambda frame: frame.steps > last.steps + 10)
            assert frame.held[0] == 2

    with served() as session:
        run(talk(session.address))


# ---- beginning and end


def test_stop_leaves_no_thread_and_frees_the_port():
    before = set(threading.enumerate())
    for _ in range(2):
        with served() as session:
            assert len(set(threading.enumerate()) - before) == 2
            port = urlsplit(session.address).port
        session.stop()
        assert set(threading.enumerate()) == before
        with socket.create_server(("127.0.0.1", port)):
            pass


def test_stop_with_clients_leaves_no_thread():
    async def talk(session):
        async with joined(session.address) as client:
            await client.shown()
            await asyncio.to_thread(session.stop)
            with pytest.raises(ConnectionError):
                await client.told("pong")

    before = set(threading.enumerate())
    with served() as session:
        run(talk(session))
    assert {thread for thread in threading.enumerate() if "pymunk" in thread.name} <= before


def test_port_in_use_and_addresses_that_cannot_be_used_are_told_in_one_line(call):
    before = set(threading.enumerate())
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, out, err = call("live", "pendulum", "--no-browser", "--port", port)
    assert (code, out) == (2, "")
    assert_says(ValueError(err.strip()), "--port", str(port))
    for host in ("192.0.2.1", "a..b", "a" * 64, "no.such.host.invalid"):
        code, out, err = call("live", "pendulum", "--no-browser", "--host", host)
        assert (code, out) == (2, ""), host
        assert_says(ValueError(err.strip()), host[:20])
    for port in (-1, 65536):
        assert call("live", "pendulum", "--no-browser", "--port", port)[:2] == (2, "")
    assert set(threading.enumerate()) == before


def test_without_aiohttp_the_extra_is_named_before_any_work(call, monkeypatch):
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    monkeypatch.delitem(sys.modules, "pymunk_dragon.sessions.server", raising=False)
    monkeypatch.setattr("pymunk_dragon.sessions.session.Session.__init__", lambda *a, **b: pytest.fail("works"))
    code, out, err = call("live", "--no-browser")
    assert (code, out) == (2, "")
    assert_says(ValueError(err.strip()), "pymunk-dragon[live]")
    with pytest.raises(MissingExtraError, match=r"pymunk-dragon\[live\]"):
        live(browser=False)


@contextmanager
def program(*arguments):
    """The program in a process of its own, when it has printed its address."""
    command = [sys.executable, "-m", "pymunk_dragon", "live", *map(str, arguments), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def seconds_after_ctrl_c(path):
    """How long the program takes to end, with clients that never read, after some steps of a recorded session."""

    async def watch(address):
        async with joined(address) as client:
            await client.shown(lambda frame: frame.time > 0.2)

    with program("pendulum", "--record", path) as process, ExitStack() as stack:
        address = process.stdout.readline().split()[1]
        for _ in range(6):
            stack.enter_context(connected(address))
        run(watch(address))
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
        passed = time.monotonic() - begin
    assert process.returncode == 130
    assert [line for line in err.splitlines() if "wrote" not in line] == ["pymunk-dragon: interrupted"]
    log = Log.load(path)
    assert log.steps > 20
    assert replayed(log)[0] == log.poses
    return passed


def test_ctrl_c_ends_the_program_within_2_s_and_writes_the_recording(tmp_path):
    assert any(seconds_after_ctrl_c(tmp_path / f"{attempt}.npz") < 2.0 for attempt in ATTEMPTS)


def test_replay_at_the_command_line_tells_that_it_is_equal(tmp_path):
    path = tmp_path / "session.json"
    with played("pendulum") as on:
        touch_a_space(on)
    path.write_text(Log.of(on.session).to_json())
    with program("--replay", path) as process:
        lines = [process.stdout.readline() for _ in range(3)]
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
    assert lines[2] == f"replay:  {on.scene.steps} steps, equal to the recording to the bit\n"
    assert process.returncode == 130


def test_replay_that_ends_elsewhere_is_written_and_says_how_far(call, tmp_path):
    with played("pendulum") as on:
        touch_a_space(on)
    log = Log.of(on.session)
    poses = on.scene.poses()
    poses[0, 0] += 0.125
    poses[-1, 2] -= 0.25
    (tmp_path / "session.json").write_text(replace(log, poses=as_text(poses)).to_json())
    code, out, err = call("live", "--exit", "--replay", tmp_path / "session.json", "-o", tmp_path / "session.npz")
    assert (code, err) == (0, "")
    assert out == f"replay:  {log.steps} steps, poses within 2.5e-01 m and rad of the recording\n"
    assert Log.load(tmp_path / "session.npz").poses == log.poses


# Names of features in versions of NumPy; it ignores others.
@pytest.mark.parametrize("features", ["", "X86_V4 AVX512_SKX", "X86_V4 X86_V3 AVX512_SKX AVX2 FMA3"])
def test_recording_of_the_film_in_the_readme_can_be_replayed_on_any_processor(features, tmp_path):
    recording = Path(__file__).parents[1] / "renders" / "live.json"
    command = [sys.executable, "-m", "pymunk_dragon", "live", "--replay", recording, "--exit"]
    environment = os.environ | {"NPY_DISABLE_CPU_FEATURES": features}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    steps, _, end = done.stdout.partition(", ")
    assert steps == "replay:  1000 steps"
    found = re.fullmatch(r"equal to the recording to the bit\n|poses within (\S+) m and rad of the recording\n", end)
    assert float(found[1] or 0) < 1e-9


TAMPERED = {
    "poses of another scene": (1, lambda log: log.update(poses="0" * 64)),
    "odd poses": (2, lambda log: log.update(poses="0")),
    "impossible input": (1, lambda log: log["inputs"].append([3, {"do": "cut", "joint": 99}])),
    "huge setting": (1, lambda log: log["inputs"].insert(0, [0, {"do": "set", "name": "iterations", "value": 1e300}])),
    "no input": (2, lambda log: log["inputs"].append([3, {"do": "quit"}])),
    "nothing": (2, lambda log: log.clear()),
    "unknown scene": (2, lambda log: log.update(plan={"scene": "x"})),
    "plan of another kind": (2, lambda log: log.update(plan=7)),
    "plan with unknown options": (2, lambda log: log.update(plan={"scenario": {}, "x": 1})),
    "plan that is no scenario": (2, lambda log: log.update(plan={"scenario": 3})),
    "plan with odd contacts": (2, lambda log: log.update(plan={"scenario": {}, "contacts": [1]})),
    "plan with an odd start": (2, lambda log: log.update(plan={"scenario": {}, "start": "x"})),
    "odd values": (2, lambda log: log.update(plan={"scenario": {}}, values={"benches": 1e300})),
    "odd step": (2, lambda log: log.update(plan={"scenario": {}}, values={"step": -1.0})),
    "no plan": (2, lambda log: log.update(plan=None)),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_tampered_recording_fails_with_one_line(name, call, tmp_path):
    with played("pendulum") as on:
        on.do("grab", body=0, x=0.5, y=0.0)
        on.do("drag", x=1.0, y=1.0)
        on.step(20)
    log = json.loads(Log.of(on.session).to_json())
    expected, change = TAMPERED[name]
    change(log)
    (tmp_path / "session.json").write_text(json.dumps(log))
    code, _, err = call("live", "--no-browser", "--replay", tmp_path / "session.json")
    assert code == expected
    assert_says(ValueError(err.strip()))
    assert err.startswith("pymunk-dragon: ")


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("absent.npz", " is 'absent.npz', but must be a readable file (No such file or directory)"),
        ("absent.json", " is 'absent.json', but must be a readable file (No such file or directory)"),
        ("run.npz", " run.npz: no recording of a live session, or a damaged one"),
    ],
)
def test_file_that_is_no_recording_is_named_with_the_option(file, reason, call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    simulate(SHORT, until=1).save("run.npz")
    code, _, err = call("live", "--exit", "--replay", file)
    assert (code, err) == (2, f"pymunk-dragon: --replay{reason}\n")


# ---- films


@pytest.mark.parametrize("name", ["dragon", "pendulum"])
def test_recorded_session_becomes_a_film(name, tmp_path):
    with played(dragon(SHORT) if name == "dragon" else ready(name), record=True) as on:
        on.run(1.0)
    record(on.session, tmp_path / "session.gif")
    with Image.open(tmp_path / "session.gif") as film:
        assert film.n_frames > 20
        assert len({film.seek(frame) or film.convert("RGB").tobytes() for frame in range(film.n_frames)}) > 15
        film.seek(0)
        lasts = sum(film.seek(frame) or film.info["duration"] for frame in range(film.n_frames))
    # The film of a dragon shows its end for 2.5 seconds more.
    assert lasts / 1000 == pytest.approx(3.5 if name == "dragon" else 1.0, abs=0.15)


def test_film_shows_an_obstacle_from_when_it_was_put_until_it_was_removed(tmp_path):
    with played(dragon(SHORT), record=True) as on:
        on.run(0.5)
        on.do("obstacle", shape="square", x=0.0, y=0.0, size=2.0)
        on.run(0.5)
        on.do("remove", obstacle=1)
        on.run(0.5)
        poses = on.session.poses()
    record(on.session, tmp_path / "session.gif")
    assert on.session.poses() == poses
    with Image.open(tmp_path / "session.gif") as film:
        colours = []
        for frame in range(film.n_frames):
            film.seek(frame)
            colours.append(film.convert("RGB").getcolors(1000))
    # Most of the pixels that are not white are the obstacle's.
    white = [{colour: count for count, colour in found}[255, 255, 255] for found in colours]
    assert white[len(white) // 2] < white[0] - 2000
    assert white[-1] == pytest.approx(white[0], abs=1000)


def test_recorded_dragon_is_a_run(tmp_path):
    with played(dragon(SHORT), record=True) as on:
        on.run(1.0)
    record(on.session, tmp_path / "session.npz")
    run = Run.load(tmp_path / "session.npz")
    assert run.march.dragon.benches == 20
    assert (run.times[0], run.times[-1]) == pytest.approx((0.0, 1.0))
    np.testing.assert_array_equal(run.poses[-1], on.scene.poses())
    assert run.drift.max() < 1e-5


def test_client_records_a_span_as_a_run(tmp_path):
    with played(dragon(SHORT)) as on:
        assert_says(ValueError(on.do("finish")))
        on.run(0.5)
        assert on.do("record") is None
        assert on.session.state()["recording"]
        on.run(1.0)
        on.do("cut", joint=3)
        assert on.do("finish") is None
        state = on.session.state()
        on.run(0.5)
    assert (state["recording"], state["recorded"]) == (False, pytest.approx(1.0))
    with (tmp_path / "run.npz").open("wb") as file:
        save(on.session.recorder.recorded, file)
    run = Run.load(tmp_path / "run.npz")
    assert (run.times[0], run.times[-1]) == pytest.approx((0.5, 1.5))
    assert len(run.times) == pytest.approx(33, abs=3)
    log = on.session.recorder.recorded.log
    assert log.inputs == [(log.steps, {"do": "cut", "joint": 3})]
    assert replayed(log)[0] == log.poses


def test_recording_of_a_client_ends_when_it_is_full(monkeypatch):
    monkeypatch.setattr("pymunk_dragon.sessions.frames.MAX_RECORDED", 20_000)
    with played(dragon(SHORT)) as on:
        on.do("record")
        on.run(5.0)
        assert not on.session.state()["recording"]
    assert on.errors == ["the recording is full, and has ended"]
    assert on.session.recorder.recorded.poses.nbytes < 25_000


def test_full_disk_ends_the_frames_and_not_the_session(monkeypatch):
    with played(dragon(SHORT), record=True) as on:
        on.run(0.1)
        monkeypatch.setattr(on.session.recorder.frames, "append", full_disk)
        on.run(1.0)
    assert on.errors == ["frames are no longer kept: No space left on device"]
    assert on.scene.time == pytest.approx(1.1)


def full_disk(scene):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_inputs_are_kept_in_some_ten_bytes_and_movements_before_the_same_step_are_one():
    log = InputLog()
    rng = np.random.default_rng(3)
    kept = []
    for step in range(20_000):
        for _ in range(2):
            x, y = (float(f"{value:.6g}") for value in rng.uniform(-9, 9, 2))
            log.append(step, {"do": "drag", "x": x, "y": y})
        kept.append((step, {"do": "drag", "x": x, "y": y}))
    log.append(step, {"do": "drop"})
    assert list(log) == [*kept, (step, {"do": "drop"})]
    assert len(log) == 20_001
    assert len(log._packed) < 12 * len(log)


# ---- odd spaces


def odd_spaces():
    """Spaces of odd kinds by their names."""
    empty, ground, bare = pymunk.Space(), pymunk.Space(), pymunk.Space()
    ground.add(pymunk.Segment(ground.static_body, (0, 0), (1, 0), 0.1))
    body = pymunk.Body(1, 1)
    bare.add(body, pymunk.PinJoint(bare.static_body, body, (0, 1)))
    far, weightless = pymunk.Space(), pymunk.Space()
    there = pymunk.Body(1, 1)
    there.position = 1e40, -1e40
    far.add(there, pymunk.Circle(there, 1))
    nothing = pymunk.Body()
    weightless.add(nothing)
    motors = pymunk.Space()
    wheels = [pymunk.Body(1, 1) for _ in range(2)]
    motors.add(*wheels, pymunk.SimpleMotor(*wheels, 1.0), pymunk.GrooveJoint(*wheels, (0, 0), (1, 0), (0, 0)))
    return {"empty": empty, "ground": ground, "bare": bare, "far": far, "weightless": weightless,
            "motors": motors}  # fmt: skip


ODD = ["empty", "ground", "bare", "far", "weightless", "motors"]


@pytest.mark.parametrize("name", ODD)
def test_odd_spaces_are_shown_touched_and_begin_anew(name):
    async def talk(address):
        async with joined(address) as client:
            await client.told("scene")
            await client.shown()
            for action, arguments in (
                ("grab", {"body": 0, "x": 0.0, "y": 0.0}),
                ("drag", {"x": 1e6, "y": -1e6}),
                ("obstacle", {"shape": "round", "x": 0.0, "y": 0.0, "size": 1.0}),
                ("cut", {"joint": 0}),
                ("step", {"count": 30}),
            ):
                await client.send(action, **arguments)
                await client.send("ping", id=1)
                await client.told("pong", id=1)
                await client.shown()
            await client.send("reset")
            generation = (await client.told("scene"))["generation"]
            await client.shown(lambda frame: frame.generation == generation)

    with served(odd_spaces()[name]) as session:
        run(talk(session.address))


def test_space_may_be_changed_while_it_is_paused():
    space = pymunk.Space()
    body, other = pymunk.Body(1, 1), pymunk.Body(1, 1)
    joint = pymunk.PinJoint(body, other)
    space.add(body, other, pymunk.Circle(body, 1), joint)

    async def talk(session):
        async with joined(session.address) as client:
            await client.shown(lambda frame: frame.steps > 3)
            with session.paused():
                space.remove(joint, other)
            await client.send("cut", joint=0)
            await client.send("grab", body=1, x=0.0, y=0.0)
            frame = await client.shown()
            await client.send("drop")
            await client.send("play")
            await client.shown(lambda later: later.steps > frame.steps + 3)
            await client.send("reset")
            assert len((await client.told("scene"))["bodies"]) == 1

    with served(space) as session:
        run(talk(session))


def test_session_can_be_stopped_while_it_is_paused():
    with served("pendulum") as session, session.paused():
        session.stop()
    assert not session._session._thread.is_alive()


def test_bodies_that_fly_apart_pause_the_session_and_reset_brings_them_back():
    with played("pendulum") as on:
        on.scene.bodies[1].velocity = math.nan, 0.0
        assert on.step(100) <= 10
        assert len(on.errors) == 1
        assert_says(ValueError(on.errors[0]), "reset")
        on.frame()
        assert on.do("reset") is None
        assert on.step(100) == 100
        assert np.isfinite(on.scene.poses()).all()


def test_frames_are_of_the_scene_that_was_described_before_them():
    async def talk(address):
        async with joined(address) as client:
            bodies = {}
            names = ["boxes", "pendulum", "cradle", "robot-arm"]
            for turn in range(24):
                await client.send("scene", name=names[turn % 4])
                if turn % 4 == 3:
                    await client.send("set", name="pitch", value=0.35)
            await client.send("ping", id=1)

            def note(found):
                if isinstance(found, dict):
                    if found["kind"] == "scene":
                        bodies[found["generation"]] = len(found["bodies"])
                    return False
                assert len(found.poses) == bodies[found.generation]
                return found.generation == max(bodies) >= 24

            await client.get(note)

    with served() as session:
        run(talk(session.address))


def test_events_have_the_texts_that_are_translated():
    with played(dragon(March(Dragon(benches=40)), contacts="report", free_from=1, start=0.0)) as session:
        session.run(14.0)
        assert session.events
        assert {re.sub(r"\d+", "#", text) for text in session.events} == {"benches # and # touch"}
