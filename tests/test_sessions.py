"""Live sessions: pulls on a scene, replays equal to the bit, and a server with bad clients."""

from __future__ import annotations

import asyncio
import contextlib
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
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import fields
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
import numpy as np
import pymunk
import pytest
from conftest import assert_says, linux_only
from live_sessions import (
    PATIENCE,
    Listener,
    greeting,
    joined,
    played,
    replay_session,
    replayed,
    served,
)

from pymunk_dragon.errors import DragonError, MissingExtraError
from pymunk_dragon.lessons import LESSONS
from pymunk_dragon.model.curves import Line
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions import Slider, live
from pymunk_dragon.sessions.messages import KINDS, read_message
from pymunk_dragon.sessions.replay import load_log
from pymunk_dragon.sessions.scenes import add, march_scene, named_scene

SHORT = March(Dragon(benches=20))
# One message of each kind that controls a session.
EACH_MESSAGE = [
    {"do": "play"},
    {"do": "until_contact"},
    {"do": "pause"},
    {"do": "reset"},
    {"do": "step", "count": 3},
    {"do": "speed", "value": 2.0},
    {"do": "scene", "name": "boxes"},
    {"do": "set", "name": "iterations", "value": 17.0},
    {"do": "grab", "x": 0.0, "y": 1.0, "slip": 0.1},
    {"do": "drag", "x": 0.0, "y": 1.0},
    {"do": "drop"},
    {"do": "cut", "x": 0.0, "y": 1.0, "slip": 0.1},
    {"do": "obstacle", "shape": "round", "x": 0.0, "y": 1.0, "size": 0.5},
    {"do": "remove", "obstacle": 1},
    {"do": "press", "name": "a", "down": True},
    {"do": "pointer", "x": 0.0, "y": 1.0, "kind": "down", "button": 1},
    {"do": "click", "x": 0.0, "y": 1.0, "button": 2},
    {"do": "wheel", "right": 0.0, "up": 1.0},
    {"do": "contacts", "value": "stop"},
    {"do": "release", "bench": 2},
    {"do": "hold"},
]


def run(coroutine):
    """`asyncio.run` in a thread: a browser of another test may have a loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, coroutine).result()


def joint_at(on, number):
    """Where joint `number` is now."""
    joint = on.scene.joints()[number]
    x, y = joint.a.local_to_world(joint.anchor_a)
    return {"x": x, "y": y, "slip": 0.05}


def touch(on, steps):
    """Everything that a hand can do to a scene, with some steps after each action."""
    (head_x, head_y, _), (x, y, _) = on.scene.poses()[[0, -1]].tolist()
    actions = {
        "grab": [{"x": x, "y": y, "slip": 0.1}],
        "drag": [{"x": x + 1.0, "y": y + 1 / 3}, {"x": x - 0.25, "y": y + 0.7}],
        "obstacle": [
            {"shape": shape, "x": head_x, "y": head_y + 2, "size": 0.4}
            for shape in ("round", "square")
        ],
        "remove": [{"obstacle": 1}],
        "drop": [{}],
        "set": [{"name": "iterations", "value": 17.0}, {"name": "step", "value": 6.3}],
    }
    if on.scene.state()["contacts"]:
        actions["set"] += [{"name": "drag", "value": 4.4}, {"name": "speed", "value": 1.3}]
        actions |= {
            "release": [{"bench": 8}],
            "contacts": [{"value": "report"}, {"value": "resolve"}],
            "hold": [{}],
        }
    else:
        actions["set"] += [{"name": "gravity", "value": 5.0}, {"name": "damping", "value": 0.9}]
    if on.scene.joints():
        actions["cut"] = [None]
    for action, many in actions.items():
        for arguments in many:
            # Joints have moved meanwhile.
            assert on.do(action, **(joint_at(on, 1) if arguments is None else arguments)) is None, (
                action
            )
            on.step(steps)


def without_generation(session):
    return session.state() | {"generation": None}, session.scene.poses().tolist()


def test_messages_are_read_from_json_and_written_as_they_were():
    assert {message["do"] for message in EACH_MESSAGE} == {*KINDS} - {"ping", "show"}
    for message in EACH_MESSAGE:
        assert read_message(message).to_dict() == message
        for wrong in (message | {"more": 1}, message | {"do": "advance"}, {**message, "do": None}):
            with pytest.raises(ValueError, match="message"):
                read_message(wrong)
        for name in message.keys() - {"do"}:
            for value in (None, [], math.nan, 10**400):
                with pytest.raises(ValueError, match=r"\w"):
                    read_message(message | {name: value})
            with pytest.raises(ValueError, match="message"):
                read_message({key: value for key, value in message.items() if key != name})


@pytest.mark.parametrize("name", ["dragon", "pendulum", "boxes"])
def test_replay_of_a_saved_session_ends_in_the_same_state_to_the_bit_and_reset_undoes_everything(
    name, tmp_path
):
    with played(march_scene(SHORT) if name == "dragon" else named_scene(name)) as on:
        fresh = without_generation(on.session)
        touch(on, 13)
        # After the last step.
        assert on.do("obstacle", shape="round", x=0.0, y=0.0, size=0.3) is None
        log = on.session.log()
        (tmp_path / "session.json").write_text(json.dumps(log))
        assert on.do("reset") is None
        assert without_generation(on.session) == fresh
        assert (on.scene.steps, on.scene.time, on.session.log()["inputs"]) == (0, 0.0, [])
    read = load_log(tmp_path / "session.json")
    assert read == json.loads(json.dumps(log))
    poses, session = replayed(read)
    assert poses == log["poses"]
    assert session.log()["inputs"] == log["inputs"]
    # The replay of other inputs ends elsewhere.
    step, message = read["inputs"][1]
    read["inputs"][1] = step, {**message, "x": message["x"] + 1e-6}
    assert replayed(read)[0] != log["poses"]


def test_head_at_the_end_of_its_path_stays_there():
    march = March(Dragon(benches=6), Line(start=(-30.0, 0.0), stop=(3.0, 0.0)), start_s=32.0)
    with played(march_scene(march)) as on:
        on.do("obstacle", shape="square", x=2.5, y=0.1, size=1.0)
        on.do("contacts", value="report")
        while "the head is at the end of its path" not in on.events:
            assert on.step(100)
        # The engine's head may be a little ahead.
        next(iter(on.scene.space.bodies)).position += 0.01, 0.0
        for _ in range(20):
            assert on.step(1) == 1
        assert on.errors == []
        assert on.frame().march_time == pytest.approx(march.end, abs=0.02)


def test_replay_goes_on_where_the_recorded_session_paused_at_a_contact():
    march = March(Dragon(benches=12), Line(start=(-30.0, 0.0), stop=(30.0, 0.0)), start_s=28.0)
    with played(march_scene(march)) as on:
        on.do("contacts", value="stop")
        on.do("obstacle", shape="square", x=2.0, y=0.1, size=1.0)
        assert on.step(1000) < 1000
        assert on.step(50) == 50
        log = on.session.log()
    assert replayed(log)[0] == log["poses"]


def test_bodies_that_fly_apart_pause_the_session_and_come_back_with_reset():
    with played("pendulum") as on:
        list(on.scene.space.bodies)[1].velocity = math.nan, 0.0
        assert on.step(100) <= 10
        assert ["reset" in error for error in on.errors] == [True]
        on.frame()
        assert on.do("reset") is None
        assert on.step(20) == 20
        assert np.isfinite(on.scene.poses()).all()


def test_events_and_messages_that_wait_are_bounded_and_a_new_scene_begins_without_those_before():
    time = [100.0]
    with played("pendulum", now=lambda: time[0]) as on:
        on.session.call(lambda: on.scene.events.extend(["x"] * 100))
        on.step(1)
        assert on.events == ["x"] * 20
        on.do("reset")
        on.session.call(lambda: on.scene.events.append("y"))
        # A second passes.
        time[0] += 1.0
        on.step(1)
        assert on.events[20:] == ["y"]
        answers = []
        with on.session.held:
            for _ in range(1500):
                Listener(on.session, answers).do("drop")
        assert len(answers) == 500


def test_inputs_are_refused_during_a_replay_and_another_scene_ends_it():
    with played(march_scene(SHORT)) as on:
        on.step(30)
        on.do("cut", **joint_at(on, 5))
        on.step(1)
        log = on.session.log()
    errors = []
    session, _ = replay_session(
        log, lambda session: Listener(session, errors).do("release", bench=2)
    )
    assert session.wait_for_replay() == 0
    session.stop()
    assert (len(errors), session.state()["cuts"], session.state()["free_from"]) == (1, [5], None)
    session, _ = replay_session(
        log, lambda session: Listener(session, []).do("scene", name="pendulum")
    )
    assert session.wait_for_replay() is None
    session.stop()
    assert session.source.name == "pendulum"
    assert not session.state()["replaying"]


@pytest.mark.thorough
def test_dragon_keeps_to_the_exact_model():
    with played("dragon") as on:
        for _ in range(10):
            on.run(1.0)
            assert on.frame().errors.max() < 1e-5
        assert on.frame().time == pytest.approx(10.0)
        assert on.frame().march_time == pytest.approx(10.0)


@pytest.mark.thorough
def test_bench_1_without_dancers_meets_bench_28_where_simulate_says():
    with played("unguided") as on:
        on.do("release", bench=1)
        assert on.step(2000) < 2000
        assert on.events == ["benches 1 and 28 touch"]
        assert on.scene.time == pytest.approx(10.894, abs=0.05)
        assert not on.session.state()["running"]
        assert on.frame().touching == [1, 28]


def test_scenes_of_lessons_tell_the_calls_of_a_contact_and_the_force_that_drags_at_a_chain():
    for name in ("callbacks", "tension"):
        add(**LESSONS[name].scene())
    with played("callbacks") as on:
        on.run(2.0)
        assert [event.split("   ")[1] for event in on.events] == [
            "begin",
            *3 * ["pre_solve", "post_solve"],
            "separate",
        ]
        assert on.events[2].startswith("impulse 3.29 N s")
    with played("tension") as on:
        assert "from 1 to 50 ms" in on.do("set", name="step", value=80)
        on.do("set", name="dancers", value=12)
        on.run(10.0)
        assert on.scene.plots()["Force in the first joint (N)"] == pytest.approx(
            12 * 10 * (1 - 0.5**0.01) / 0.01
        )


def test_dragon_keeps_its_place_where_the_time_step_changes():
    with played("sloppy-engine") as on:
        on.run(1.0)
        on.do("set", name="step", value=30.0)
        on.run(1.0)
        # The dancers' forces once balanced the drag of the longer step: 20 mm.
        assert on.frame().errors.max() < 2e-3


def test_tail_behind_a_cut_joint_stays_while_the_head_goes_on():
    with played(march_scene(March(Dragon(benches=60)))) as on:
        on.run(1.0)
        before = on.frame()
        np.testing.assert_allclose(before.poses, on.scene.poses(), rtol=1e-6)
        assert before.errors.max() < 1e-5
        assert on.do("cut", **joint_at(on, 30)) is None
        on.run(2.0)
        before = on.frame()
        on.run(0.5)
        after = on.frame()
        speeds = np.hypot(*(after.poses - before.poses)[:, :2].T) / (after.time - before.time)
        assert speeds[31:].max() < 0.01
        assert speeds[:30].min() > 0.5
        assert on.session.state()["cuts"] == [30]
        assert after.forces[30] == 0


def test_dancers_who_come_back_bring_every_bench_to_the_exact_model():
    with played(march_scene(March(Dragon(benches=40)))) as on:
        on.run(0.5)
        assert on.do("release", bench=1) is None
        assert on.session.state()["free_from"] == 1
        on.run(3.0)
        assert on.frame().errors.max() > 0.01
        assert on.do("hold") is None
        on.run(10.0)
        assert on.session.state()["free_from"] is None
        assert on.frame().errors.max() < 0.01


def test_dancers_who_come_back_hold_an_arm_that_goes_far_in_a_step_again():
    with played("robot-arm") as on:
        on.run(4.0)
        assert on.do("release", bench=1) is None
        on.run(0.5)
        assert on.do("hold") is None
        on.run(10.0)
        assert on.session.state()["free_from"] is None
        assert on.frame().errors.max() < 0.002


@pytest.mark.parametrize(
    ("bench", "move"), [(0, 0.4j), (3, -0.7)]
)  # The tip over its links, and links backwards.
def test_dancers_carry_back_an_arm_that_was_pulled_far_off_its_path(bench, move):
    with played("robot-arm") as on:
        on.run(1.0)
        x, y, angle = on.scene.poses()[bench].tolist()
        goal = complex(x, y) + move * np.exp(1j * angle)
        on.do("grab", x=x, y=y, slip=0.01)
        on.do("drag", x=goal.real, y=goal.imag)
        on.run(3.0)
        assert on.frame().errors.max() > 0.3
        on.do("drop")
        on.run(10.0)
        assert on.frame().errors.max() < 0.002


def test_obstacle_in_the_way_stops_the_march_only_if_contacts_push_apart_and_until_it_is_removed():
    with played("jam") as on:
        for contacts in ("resolve", "report", "stop"):
            on.do("reset")
            on.told.clear()
            assert on.do("contacts", value=contacts) is None
            on.run(4.0)
            assert (
                next(event for event in on.events if "obstacle" in event)
                == "bench 0 and an obstacle touch"
            )
            if contacts == "stop":
                assert not on.session.clock.running
                assert on.scene.time < 4
                continue
            march_time, x = on.frame().march_time, on.frame().poses[0, 0]
            on.run(3.0)
            moved, marched = on.frame().poses[0, 0] - x, on.frame().march_time - march_time
            if contacts == "resolve":
                assert abs(moved) < 0.01
                assert marched < 0.1
                assert on.do("remove", obstacle=1) is None
                on.run(4.0)
                assert on.frame().march_time > march_time + 2
                assert on.frame().errors.max() < 0.001
            else:
                assert (moved, marched) == pytest.approx((3.0, 3.0), abs=0.02)


def test_hand_pulls_dynamic_bodies_only_with_at_most_1000_newtons_per_kilogram():
    with played("pendulum") as on:
        x, y, _ = on.scene.poses()[0].tolist()
        assert on.do("grab", x=x + 0.3, y=y, slip=0.0) is None
        assert on.do("drag", x=0.48, y=0.64) is None
        on.run(2.0)
        assert on.frame().held[2:] == pytest.approx((0.48, 0.64))
        assert (
            next(iter(on.scene.space.bodies)).local_to_world((0.3, 0.0)).get_distance((0.48, 0.64))
            < 0.02
        )
        assert on.do("drop") is None
        assert on.frame().held is None
    space = pymunk.Space()
    body, mover = pymunk.Body(3.0, 1.0), pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    mover.position = 4, 0
    space.add(body, pymunk.Circle(body, 0.5), mover, pymunk.Circle(mover, 1))
    with played(space) as on:
        for x in (4.0, 2.0, -9.0):
            assert_says(ValueError(on.do("grab", x=x, y=0.0, slip=0.1)), "body")
        assert on.do("grab", x=0.55, y=0.0, slip=0.1) is None
        on.do("drag", x=1e6, y=-1e6)
        on.step(1)
        assert body.velocity.length == pytest.approx(1000 * on.scene.step_length, rel=1e-6)
        on.session.call(lambda: space.remove(body, *body.shapes))
        assert on.frame().held is None


def test_sliders_that_rebuild_begin_anew_with_their_value():
    with played(march_scene(SHORT)) as on:
        for name, value in (("pitch", 0.7), ("width", 0.25), ("benches", 12.0)):
            on.step(10)
            generation = on.session.generation
            assert on.do("set", name=name, value=value) is None
            assert (on.session.generation, on.scene.steps) == (generation + 1, 0)
            assert on.session.state()["values"][name] == value
        [described] = greeting(on)
        assert len(described["dragon"]["lengths"]) == 12
        assert set(described["dragon"]["widths"]) == {0.25}
        on.run(0.5)
        assert on.frame().errors.max() < 1e-4
        log = on.session.log()
    assert replayed(log)[0] == log["poses"]


def test_values_out_of_range_and_things_that_do_not_exist_are_refused_and_change_nothing():
    shape = {"shape": "round", "x": 0.0, "y": 0.0, "size": 1.0}
    impossible = {
        "cut": [{"x": 1e5, "y": 0.0, "slip": 1.0}, {"x": 0.0, "y": 0.0, "slip": -1.0}],
        "remove": [{"obstacle": 1}],
        "contacts": [{"value": "x"}],
        "release": [{"bench": 0}, {"bench": 20}],
        "obstacle": [shape | {"shape": "star"}, shape | {"x": math.nan}, shape | {"size": 0.0}],
        "grab": [{"x": math.inf, "y": 0.0, "slip": 1.0}, {"x": 1e5, "y": 0.0, "slip": 1.0}],
        "press": [{"name": "x", "down": True}],
        "drag": [{"x": 1e300, "y": 0.0}],
        "step": [{"count": 0}],
        "speed": [{"value": 0.0}, {"value": 1e9}, {"value": math.nan}],
        "scene": [{"name": "../etc"}],
        "set": [{"name": "shoe size", "value": 1.0}],
    }
    for source in (march_scene(SHORT), named_scene("boxes")):
        with played(source) as on:
            on.step(3)
            before = on.session.state(), on.session.log()
            for action, many in impossible.items():
                for arguments in many:
                    assert_says(ValueError(on.do(action, **arguments)))
            for each in on.scene.parameters.values():
                values = [each.low - 1.0, each.high + 1.0, math.nan, math.inf, -math.inf, 1e308]
                for value in values + [each.low + 0.5] * each.whole:
                    error = ValueError(on.do("set", name=each.name, value=value))
                    assert_says(error, each.name if math.isfinite(value) else "value")
            assert (on.session.state(), on.session.log()) == before


def test_reset_puts_a_space_of_ones_own_back():
    space, body = pymunk.Space(), pymunk.Body(1.0, 0.1)
    space.gravity, body.position = (0, -10), (0.5, 0)
    space.add(
        body,
        pymunk.Circle(body, 0.3),
        *(pymunk.PivotJoint(space.static_body, body, (0, 0)) for _ in range(2)),
    )
    with played(space) as on:
        fresh = without_generation(on.session)
        touch(on, 7)
        on.do("grab", x=body.position.x, y=body.position.y, slip=0.0)
        on.step(7)
        assert on.do("reset") is None
        assert without_generation(on.session) == fresh
        assert (len(space.shapes), len(space.constraints), space.gravity) == (1, 2, (0, -10))
        assert body.velocity == (0, 0)


def random_message(dice):
    """A text or bytes, and whether it is a message, whose arguments may be impossible."""
    action = dice.choice([name for name in KINDS if name not in ("scene", "ping")])
    values = {
        "int": dice.choice([0, 1, -1, 3, dice.randrange(20), 10**18, -(10**30)]),
        "float": dice.choice(
            [0.0, -0.0, 1.5, 1e-300, 1e6, 1e308, math.nan, math.inf, dice.gauss(0, 5)]
        ),
        "str": dice.choice(
            [
                "",
                "step",
                "iterations",
                "drag",
                "speed",
                "stop",
                "report",
                "resolve",
                "round",
                "square",
            ]
        ),
        "bool": True,
    }
    message = {"do": action} | {each.name: values[each.type] for each in fields(KINDS[action])}
    odd = dice.choice([None, True, 0, 10**400, math.nan, "", "\ud800", [[]], {"do": {}}])
    objects = (
        odd,
        {**message, "more": odd},
        {**message, "do": "advance"},
        {**message, dice.choice([*message]): [None]},
    )
    texts = (
        "",
        "{",
        "[" * 4000,
        '{"do":' * 600,
        "\x00",
        "nan",
        '{"do": "play"} x',
        "9" * 4096,
        "x" * 4097,
    )
    malformed = [*map(json.dumps, objects), dice.choice(texts), dice.randbytes(dice.randrange(100))]
    return (json.dumps(message), True) if dice.random() < 0.3 else (dice.choice(malformed), False)


@pytest.mark.parametrize(
    ("clients", "count"), [(2, 150), pytest.param(12, 480, marks=pytest.mark.thorough)]
)
def test_random_messages_crash_nothing_and_each_malformed_one_is_answered(
    clients, count, monkeypatch
):
    failures = []
    monkeypatch.setattr(threading, "excepthook", failures.append)

    async def attack(session, seed):
        dice = random.Random(seed)
        watches = seed % 2 == 1
        async with joined(session.watch_address if watches else session.address) as client:
            bad = 0
            for _ in range(count):
                message, is_message = random_message(dice)
                # Who watches may change nothing.
                changes = '"do": "show"' not in str(message)
                bad += not is_message or (watches and changes)
                await (
                    client.socket.send_bytes
                    if isinstance(message, bytes)
                    else client.socket.send_str
                )(message)
            await client.send("ping", id=-1)
            await client.told("pong", id=-1)
            # Who controls may also be answered that a body or a joint does not exist.
            assert client.errors == bad or (client.errors > bad and not watches)

    async def all_attacks(session):
        async with joined(session.address) as client:
            await client.socket.send_str("x" * 100_000)
            with pytest.raises(ConnectionError):
                await client.told("pong")
        await asyncio.gather(*(attack(session, seed) for seed in range(clients)))
        async with asyncio.timeout(PATIENCE), joined(session.address) as client:
            answer = {}
            # Messages of before may still wait.
            while answer.get("name") != "pendulum":
                await client.send("scene", name="pendulum")
                answer = await client.get(
                    lambda found: isinstance(found, dict) and found["kind"] in ("scene", "error")
                )
            for action, arguments in (("reset", {}), ("play", {}), ("speed", {"value": 1.0})):
                await client.send(action, **arguments)
            first = await client.shown(lambda frame: frame.generation > answer["generation"])
            await client.shown(lambda frame: frame.time > first.time + 0.1)

    with served(march_scene(SHORT)) as session:
        run(all_attacks(session))
    assert failures == []


def test_requests_without_the_token_of_other_hosts_and_of_other_pages_are_refused():
    async def ask(http, page, host, origin, token):
        headers = {
            name: value
            for name, value in {"Host": host, "Origin": origin}.items()
            if value is not None
        }
        query = "" if token is None else f"?token={token}"
        found = []
        for path in ("", "inputs", "socket"):
            async with http.get(f"{page}{path}{query}", headers=headers) as answer:
                found.append(answer.status)
        return found

    async def ask_all(page, rows):
        async with aiohttp.ClientSession() as http:
            for host, origin, token, status in rows:
                # A socket is opened in another way.
                expected = [status, status, 400 if status == 200 else status]
                assert await ask(http, page, host, origin, token) == expected, (host, origin, token)

    with served(allow_hosts=["Hub.example"]) as session:
        page, token = session.address.split("?token=")
        watch = session.watch_address.partition("token=")[2]
        own = urlsplit(page).netloc
        rows = [
            (None, None, watch, 200),
            (None, f"http://{own}", token, 200),
            ("localhost", None, token, 200),
            ("hub.example", "https://hub.example", token, 200),
            ("hub.example:443", None, token, 200),
            # A proxy that replaces the host and keeps the origin.
            (None, "https://hub.example", token, 200),
            (None, "https://hub.example", None, 403),
            ("evil.example:" + own.partition(":")[2], "http://evil.example", token, 403),
            (None, None, token + "&token=x", 200),
        ]
        for wrong in (None, "", "x", "%C3%A9%00", token[:-1], "x&token=" + token):
            rows.append((None, None, wrong, 403))
        for host in ("evil.example", "127.0.0.1.evil.example", "192.0.2.7", "[", "a@[:1"):
            rows.append((host, None, token, 403))
        for origin in (
            "evil.example",
            "hub.example.evil.example",
            "[",
            f"{own}.evil.example",
            "127.0.0.1:1",
        ):
            rows.append((None, f"http://{origin}", token, 403))
        rows.append((None, "null", token, 403))
        run(ask_all(page, rows))


def test_page_has_a_policy_without_unsafe_inline_and_is_not_stored():
    async def ask(method, address):
        async with aiohttp.ClientSession() as http, http.request(method, address) as answer:
            return answer.status, answer.headers, await answer.text()

    with served() as session:
        _, headers, page = run(ask("GET", session.address))
        refused = [
            run(ask("GET", session.address.replace("/?", "/nowhere?"))),
            run(ask("POST", session.address)),
        ]
    assert headers["Content-Security-Policy"].startswith("default-src 'none'; ")
    assert "unsafe" not in headers["Content-Security-Policy"]
    assert [status for status, _, _ in refused] == [404, 405]
    names = ("Cache-Control", "Referrer-Policy", "X-Content-Type-Options")
    for found in (headers, *(found for _, found, _ in refused)):
        assert [found[name] for name in names] == ["no-store", "no-referrer", "nosniff"]
    assert "http://" not in page.replace("http://www.w3.org/", "")
    assert "{{" not in page


def test_watchers_control_nothing():
    async def talk(session):
        async with joined(session.watch_address) as client:
            assert (await client.told("scene"))["role"] == "watch"
            before = await client.told("state")
            for message in EACH_MESSAGE:
                await client.socket.send_str(json.dumps(message))
                await client.told("error")
        async with joined(session.address) as client:
            assert (await client.told("scene"))["role"] == "control"
            assert await client.told("state", clients=1) == before
            await client.send("pause")
            await client.told("state", running=False)

    with served() as session:
        run(talk(session))


def test_20_clients_see_the_motion_of_the_scene_that_was_described_before():
    last = 11

    async def watch(session):
        async with joined(session.watch_address) as client:
            benches = {}

            def note(found):
                if isinstance(found, dict):
                    if found["kind"] == "scene":
                        benches[found["generation"]] = (
                            len(found["dragon"]["lengths"]) if found["dragon"] else 0
                        )
                    return False
                assert len(getattr(found, "poses", [])) == benches[found.generation]
                return found.generation == max(benches) == last

            first = await client.get(note)
            later = await client.shown(lambda frame: frame.time > first.time + 0.1)
            assert not np.array_equal(first.poses, later.poses)

    async def change(session):
        async with joined(session.address) as client:
            await client.told("state", clients=21)
            for generation, name in enumerate(["boxes", "pendulum", "robot-arm"] * 3, start=2):
                await client.send("scene", name=name)
                await client.told("scene", generation=generation)
            await client.send("set", name="pitch", value=0.35)
            await client.told("scene", generation=last)

    async def all_watch(session):
        await asyncio.gather(change(session), *(watch(session) for _ in range(20)))

    with served() as session:
        run(all_watch(session))


def connected(address):
    """A socket that has become a WebSocket, and is not read."""
    url = urlsplit(address)
    found = socket.create_connection((url.hostname, url.port))
    found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    found.sendall(
        f"GET /socket?{url.query} HTTP/1.1\r\nHost: {url.netloc}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    return found


@pytest.mark.thorough
def test_clients_that_never_read_or_that_flood_do_not_stop_others():
    async def flood(address):
        # Reading from it stops, and in the end it is disconnected.
        async with joined(address) as client:
            with contextlib.suppress(ConnectionError, aiohttp.ClientError):
                while not client.socket.closed:
                    await client.send("drag", x=1.0, y=2.0)
                    await asyncio.sleep(0)

    async def talk(session):
        async with asyncio.timeout(2 * PATIENCE), joined(session.address) as client:
            first = await client.shown()
            # More than sockets hold.
            for _ in range(60):
                session.session.clients.tell({"kind": "event", "time": 0.0, "text": "x" * 100_000})
            flooding = asyncio.create_task(flood(session.address))
            for number in range(20):
                await client.send("ping", id=number)
                await client.told("pong", id=number)
            await client.send("obstacle", shape="round", x=0.0, y=0.0, size=0.1)
            await client.get(lambda found: isinstance(found, dict) and found.get("obstacles"))
            await client.shown(lambda frame: frame.time > first.time + 0.3)
            await flooding

    with served() as session, ExitStack() as stack:
        for _ in range(8):
            stack.enter_context(connected(session.address))
        run(talk(session))


def test_body_is_dropped_when_its_holder_disconnects_and_only_then():
    async def talk(address):
        def holds(frame, x):
            return frame.held is not None and abs(frame.held[2] - x) < 1e-3

        async with joined(address) as client:
            async with joined(address) as first:
                await first.send("grab", x=-0.402, y=0.0, slip=0.1)
                await client.shown(lambda frame: holds(frame, -0.402))
            await client.shown(lambda frame: frame.held is None)
            async with joined(address) as first:
                await first.send("grab", x=-0.402, y=0.0, slip=0.1)
                await client.shown(lambda frame: holds(frame, -0.402))
                await client.send("grab", x=0.0, y=0.0, slip=0.1)
                await client.shown(lambda frame: holds(frame, 0.0))
            await client.told("state", clients=1)
            await client.send("ping", id=1)
            await client.told("pong", id=1)
            last = await client.shown()
            frame = await client.shown(lambda frame: frame.step > last.step + 10)
            assert holds(frame, 0.0)

    with served("cradle") as session:
        run(talk(session.address))


def test_stop_leaves_no_thread_and_frees_the_port_even_with_clients_and_while_it_is_paused():
    async def talk(session):
        async with joined(session.address) as client:
            await client.shown(lambda frame: frame.time > 0.1)
            await asyncio.to_thread(session.stop)
            with pytest.raises(ConnectionError):
                await client.told("pong")

    before = set(threading.enumerate())
    for way in ("alone", "by its own thread", "paused", "with a client"):
        with served() as session:
            port = urlsplit(session.address).port
            if way == "by its own thread":
                # As the action of a button does.
                stopped = threading.Event()
                session.session.call(
                    lambda session=session, stopped=stopped: (session.stop(), stopped.set())
                )
                assert stopped.wait(PATIENCE)
            if way == "paused":
                with session.paused():
                    session.stop()
            elif way == "with a client":
                # It never reads.
                with connected(session.address):
                    run(talk(session))
        for thread in set(threading.enumerate()) - before:
            # One that was paused goes on for a moment.
            thread.join(PATIENCE)
        assert {thread for thread in threading.enumerate() if "pymunk" in thread.name} <= before, (
            way
        )
        with socket.create_server(("127.0.0.1", port)):
            pass


def test_port_in_use_addresses_that_cannot_be_used_and_a_missing_extra_are_told_in_one_line(
    call, monkeypatch
):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        for flag, value in (
            ("--port", port),
            ("--host", "192.0.2.1"),
            ("--host", "a..b"),
            ("--port", 65536),
        ):
            code, out, err = call("live", "pendulum", "--no-browser", flag, value)
            assert (code, out) == (2, "")
            assert_says(ValueError(err.strip()), flag, str(value))
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    monkeypatch.delitem(sys.modules, "pymunk_dragon.sessions.server", raising=False)
    code, out, err = call("live", "--no-browser")
    assert (code, out) == (2, "")
    assert_says(ValueError(err.strip()), "pymunk-dragon[live]")
    with pytest.raises(MissingExtraError, match=r"pymunk-dragon\[live\]"):
        live(browser=False)


@linux_only
def test_ctrl_c_ends_the_program_with_130_and_writes_a_recording_whose_replay_is_equal(
    call, tmp_path
):
    async def watch(address):
        async with joined(address) as client:
            await client.shown(lambda frame: frame.time > 0.1)

    path = tmp_path / "session.json"
    command = [sys.executable, "-m", "pymunk_dragon", "live", "--record", path, "--no-browser"]
    pipe = subprocess.PIPE
    with (
        subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process,
        ExitStack() as stack,
    ):
        stack.callback(process.kill)
        address = process.stdout.readline().split()[1]
        stack.enter_context(connected(address))
        run(watch(address))
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert [line for line in err.splitlines() if "wrote" not in line] == [
        "pymunk-dragon: interrupted"
    ]
    log = load_log(path)
    assert log["plan"] == {"scene": "dragon"}
    assert log["steps"] > 10
    line = f"replay:  {log['steps']} steps, equal to the recording to the bit\n"
    assert call("live", "--exit", "--replay", path) == (0, line, "")
    # Poses that differ are not: the program says how far, and writes those of the replay.
    _, session = replayed(log)
    poses = session.scene.poses() + np.array([0.125, 0.0, -0.25])
    (tmp_path / "other.json").write_text(json.dumps(log | {"poses": poses.tolist()}))
    code, out, err = call(
        "live", "--exit", "--replay", tmp_path / "other.json", "-o", tmp_path / "written.json"
    )
    assert (code, err) == (0, "")
    assert (
        out == f"replay:  {log['steps']} steps, poses within 2.5e-01 m and rad of the recording\n"
    )
    assert load_log(tmp_path / "written.json")["poses"] == log["poses"]
    with ThreadPoolExecutor(1) as other, session.held:
        written = other.submit(session.log)  # Between two steps.
        session.scene.steps += 1
    assert written.result()["steps"] == log["steps"] + 1


@pytest.mark.thorough
def test_recording_of_the_film_in_the_readme_can_be_replayed_on_any_processor():
    recording = Path(__file__).parents[1] / "renders" / "live.json"
    command = [sys.executable, "-m", "pymunk_dragon", "live", "--replay", recording, "--exit"]
    # Names of features in versions of NumPy; it ignores others.
    for features in ("", "X86_V4 X86_V3 AVX512_SKX AVX2 FMA3"):
        environment = os.environ | {"NPY_DISABLE_CPU_FEATURES": features}
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        found = re.fullmatch(
            r"replay:  1000 steps, (?:equal to .*|poses within (\S+) m .*)\n", done.stdout
        )
        assert float(found[1] or 0) < 1e-9, features


def test_recording_that_is_tampered_with_or_none_is_refused_in_one_line(call, tmp_path, small_run):
    with played("pendulum") as on:
        on.do("grab", x=0.5, y=0.0, slip=0.1)
        on.do("drag", x=1.0, y=1.0)
        on.step(20)
    log = on.session.log()
    small = {"scenario": {"dragon": {"benches": 4}}}
    enormous = [0, {"do": "set", "name": "iterations", "value": 1e300}]
    for expected, changes in (
        (1, {"poses": [[0, 0, 0]]}),
        (1, {"inputs": [*log["inputs"], [3, {"do": "remove", "obstacle": 99}]]}),
        (1, {"inputs": [enormous, *log["inputs"]]}),
        (2, {"inputs": [[0, {"do": "drag", "x": math.nan, "y": 0.0}]]}),
        (2, {"values": {"rows": math.inf}}),
        (2, {"poses": [[math.nan, 0, 0], *log["poses"][1:]]}),
        (2, {"inputs": [*log["inputs"], [3, {"do": "quit"}]]}),
        (2, {"plan": {"scene": "x"}}),
        (2, {"plan": 7}),
        (2, {"plan": small}),
        (2, {"plan": small | {"start": "x"}}),
        (2, {"plan": small | {"start": 0.0}, "values": {"step": -1.0}}),
        (2, {"plan": None}),
    ):
        (tmp_path / "changed.json").write_text(json.dumps(log | changes))
        code, _, err = call("live", "--no-browser", "--replay", tmp_path / "changed.json")
        assert (code, err.count("\n")) == (expected, 1), changes
    (tmp_path / "empty.json").write_text("{}")
    small_run.save(tmp_path / "run.npz")
    for name in ("empty.json", "run.npz", "absent.npz", "absent.json"):
        code, _, err = call("live", "--exit", "--replay", tmp_path / name)
        assert (code, err.count("\n")) == (2, 1), name
        assert name in err


def odd_spaces():
    """Spaces without a body, far away, without a shape, and with joints that have no anchors."""
    ground, far, weightless, motors = (pymunk.Space() for _ in range(4))
    ground.add(pymunk.Segment(ground.static_body, (0, 0), (1, 0), 0.1))
    there, *wheels = (pymunk.Body(1, 1) for _ in range(3))
    there.position = 1e40, -1e40
    far.add(there, pymunk.Circle(there, 1))
    weightless.add(pymunk.Body())
    motors.add(
        *wheels,
        pymunk.SimpleMotor(*wheels, 1.0),
        pymunk.GrooveJoint(*wheels, (0, 0), (1, 0), (0, 0)),
    )
    return pymunk.Space(), ground, far, weightless, motors


def test_live_plays_any_space_which_is_touched_and_begins_anew():
    async def talk(session, space):
        async with joined(session.address) as client:
            assert (await client.told("scene"))["parameters"][0]["high"] == 9
            await client.shown()
            for action, arguments in (
                ("grab", {"x": 0.0, "y": 0.0, "slip": 9.0}),
                ("drag", {"x": 1e6, "y": -1e6}),
                ("obstacle", {"shape": "round", "x": 0.0, "y": 0.0, "size": 1.0}),
                ("cut", {"x": 0.0, "y": 0.0, "slip": 9.0}),
                ("step", {"count": 10}),
            ):
                await client.send(action, **arguments)
            await client.send("reset")
            generation = (await client.told("scene"))["generation"]
            await client.shown(lambda frame: frame.generation == generation)
            if joints := space.constraints:
                # A program may change the space in between.
                with session.paused():
                    space.remove(*joints)
                frame = await client.shown()
                await client.send("play")
                await client.shown(lambda later: later.step > frame.step)

    # Numbers of NumPy become JSON too.
    slider = Slider("wind", np.int64(1), np.int64(9), np.int64(3), action=lambda space, value: None)
    for space in odd_spaces():
        with live(space, controls=[slider], browser=False) as session:
            run(talk(session, space))
    with pytest.raises(DragonError, match="what is 3"):
        live(3, browser=False)
