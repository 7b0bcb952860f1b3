"""A session that no thread steps: the caller makes its turns, on a clock of its own."""

from __future__ import annotations

import asyncio
import math
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pymunk
import pytest
from live_sessions import Listener, decoded

from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.sessions.controls import Button, Slider
from pymunk_dragon.sessions.scene import PlaySettings
from pymunk_dragon.sessions.scenes import march_scene, named_scene, recorded_scene, space_scene
from pymunk_dragon.sessions.session import Session

STEP = 1 / 100


class Page(Listener):
    """A client that keeps its pictures, too."""

    def __init__(self, session):
        super().__init__(session, [])
        self.frames = []

    def show(self, frame, outlines):
        self.frames.append(decoded(frame))

    def texts(self, kind):
        return [message["text"] for message in self.told if message["kind"] == kind]


class Turns:
    """A session with a page, and the time, which passes only where a test lets it."""

    def __init__(self, source, **options):
        self.time = 1000.0
        self.session = Session(source, now=lambda: self.time, **options)
        self.page = Page(self.session)
        self.session.join(self.page)

    @property
    def scene(self):
        return self.session.scene

    def turn(self):
        """Make turns as long as something is due; the time until the next one."""
        while (seconds := self.session.turn()) == 0:
            pass
        return seconds

    def run(self, seconds):
        """Let time pass, in turns made when they are due."""
        end = self.time + seconds
        wait = self.turn()
        while self.time + wait <= end:
            # A moment later, as times are rounded.
            self.time += wait + 1e-9
            wait = self.turn()
        self.time = max(self.time, end)

    def do(self, action, **arguments):
        """Send a message, which a turn takes; the errors that the page was sent."""
        before = len(self.page.texts("error"))
        self.page.do(action, **arguments)
        self.turn()
        return self.page.texts("error")[before:]


def falling(**arguments):
    """A ball above a floor."""
    space = pymunk.Space()
    space.gravity = 0, -9.81
    ball = pymunk.Body(1, 1)
    ball.position = 0, 5
    space.add(
        ball, pymunk.Circle(ball, 0.5), pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0.1)
    )
    return space


def ball_scene(**settings):
    return space_scene(falling, PlaySettings(step=STEP, **settings))


@pytest.fixture(autouse=True)
def _no_thread():
    """A session that is not started has no thread."""
    before = set(threading.enumerate())
    yield
    assert set(threading.enumerate()) <= before


def test_steps_and_pictures_are_made_when_they_are_due_and_no_others():
    on = Turns(ball_scene())
    on.run(1.0)
    assert on.scene.steps == pytest.approx(100, abs=1)
    assert len(on.page.frames) == pytest.approx(60, abs=1)
    assert [frame.step for frame in on.page.frames] == sorted(
        {frame.step for frame in on.page.frames}
    )
    assert on.page.told[0]["kind"] == "scene"

    on.do("speed", value=0.5)
    before = on.scene.steps
    on.run(1.0)
    assert on.scene.steps - before == pytest.approx(50, abs=2)


def test_turn_returns_the_time_until_something_is_due():
    on = Turns(ball_scene())
    on.session.leave(on.page)
    assert on.turn() == pytest.approx(STEP)
    on.time += 0.4 * STEP
    assert on.turn() == pytest.approx(0.6 * STEP)
    assert on.scene.steps == 1
    on.page.do("pause")
    # Nothing is due before the next message, as nobody watches.
    assert on.turn() == math.inf
    on.session.join(on.page)
    assert 0 <= on.session.turn() <= 1 / 60


def test_slow_computer_makes_up_for_a_tenth_of_a_second_at_most():
    on = Turns(ball_scene())
    on.run(0.1)
    before = on.scene.steps
    on.time += 5.0
    on.turn()
    assert on.scene.steps - before == pytest.approx(10, abs=1)


def test_pause_single_steps_and_play():
    on = Turns(ball_scene(), running=False)
    on.run(0.5)
    assert on.scene.steps == 0
    # Pictures go on: somebody may move an obstacle.
    assert len(on.page.frames) == pytest.approx(30, abs=1)

    assert on.do("step", count=7) == []
    assert on.scene.steps == 7
    on.do("play")
    on.run(0.1)
    on.do("pause")
    before = on.scene.steps
    on.run(1.0)
    assert before > 7
    assert on.scene.steps == before

    assert on.do("until_contact") == []
    on.run(10.0)
    assert not on.session.state()["running"]
    assert next(iter(on.scene.space.bodies)).position.y < 1


def test_reset_rebuilds_and_other_scenes_begin():
    controls = [Slider("height", 1, 9, 5, action=lambda space, value: None)]
    on = Turns(ball_scene(controls=controls))
    on.do("set", name="height", value=7.0)
    on.run(0.3)
    on.do("reset")
    assert (on.scene.steps, on.session.state()["values"]["height"]) == (0, 5)
    on.do("scene", name="boxes")
    on.do("set", name="rows", value=3)
    assert (on.session.source.name, len(on.scene.space.bodies)) == ("boxes", 6)
    assert [each["generation"] for each in on.page.told if each["kind"] == "scene"] == [1, 2, 3, 4]
    assert len(on.do("grab", x=1e5, y=0.0, slip=0.1)) == 1


@pytest.mark.parametrize("where", ["on_step", "button", "chart"])
def test_error_in_a_function_of_the_users_pauses_and_is_sent_once(where):
    fails = [True]

    def fail(*_):
        if fails[0]:
            return 1 / 0
        return 1.0

    settings = {
        "on_step": {"on_step": fail},
        "button": {"controls": [Button("b", fail)]},
        "chart": {"plots": {"c": fail}},
    }
    on = Turns(ball_scene(**settings[where]))
    if where == "button":
        on.do("press", name="b", down=True)
    on.run(0.5)
    assert ["ZeroDivisionError" in text for text in on.page.texts("error")] == [True]
    assert not on.session.state()["running"]
    fails[0] = False
    on.do("play")
    before = on.scene.steps
    on.run(0.5)
    assert on.scene.steps > before
    assert len(on.page.texts("error")) == 1


def test_error_of_what_a_client_does_again_is_sent_again():
    def build(balls=3):
        return falling() if balls < 5 else 1 / 0

    controls = [Slider("balls", 1, 9, rebuilds=True), Button("b", lambda space: 1 / 0)]
    on = Turns(space_scene(build, PlaySettings(step=STEP, controls=controls)))
    for _ in range(2):
        # The page that hears of a scene again shows no error.
        assert len(on.do("set", name="balls", value=5)) == 1
    for _ in range(2):
        assert len(on.do("press", name="b", down=True)) == 1


def test_session_is_stopped_by_its_own_button():
    on = Turns(ball_scene(controls=[Button("Stop", lambda space: on.session.stop())]))
    on.run(0.1)
    before = on.scene.steps
    on.page.do("press", name="Stop", down=True)
    assert on.session.turn() == math.inf
    on.time += 1.0
    assert on.session.turn() == math.inf
    assert on.scene.steps == before


@pytest.mark.parametrize("name", ["dragon", "pendulum"])
def test_recording_is_replayed_to_the_bit(name):
    source = march_scene(March(Dragon(benches=12))) if name == "dragon" else named_scene(name)
    on = Turns(source)
    x, y, _ = on.scene.poses()[-1].tolist()
    for action, arguments in (
        ("grab", {"x": x, "y": y, "slip": 0.1}),
        ("drag", {"x": x + 1.0, "y": y + 1 / 3}),
        ("set", {"name": "iterations", "value": 17.0}),
        ("obstacle", {"shape": "square", "x": x, "y": y + 3.0, "size": 0.4}),
        ("drop", {}),
    ):
        assert on.do(action, **arguments) == []
        on.run(0.11)
    log = on.session.log()
    assert [message["do"] for _, message in log["inputs"]] == [
        "grab",
        "drag",
        "set",
        "obstacle",
        "drop",
    ]

    again = Turns(recorded_scene(log["plan"]), log=log)
    assert again.do("drop") != []
    # As fast as possible, from the next step on.
    again.session.clock.speed = math.inf
    again.run(1.0)
    assert not again.session.state()["replaying"]
    assert again.session.wait_for_replay() == 0
    assert again.session.log() == log


def test_event_loop_makes_the_turns_where_there_are_no_threads(monkeypatch):
    monkeypatch.setattr("pymunk_dragon.sessions.session._WITHOUT_THREADS", True)
    threads = threading.active_count()
    session = Session(space_scene(pymunk.Space, PlaySettings(step=STEP)))

    async def play():
        session.start()
        while session.scene.steps < 3:
            await asyncio.sleep(0)
        session.call(sys.exit)
        while not session._ended.is_set():
            await asyncio.sleep(0)

    with ThreadPoolExecutor(1) as other:
        # A browser of another test may have a loop in this thread.
        other.submit(lambda: asyncio.run(play())).result()
    assert threading.active_count() == threads
