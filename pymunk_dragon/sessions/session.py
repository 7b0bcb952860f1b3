"""A session: a scene that is stepped in real time, its clients, and the recording of inputs."""

from __future__ import annotations

import math
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

import pymunk

from pymunk_dragon._checks import finite
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.physics.contacts import callbacks_raise
from pymunk_dragon.sessions.client import Client, Clients
from pymunk_dragon.sessions.clock import Clock, EventLimit
from pymunk_dragon.sessions.holds import Holds
from pymunk_dragon.sessions.messages import (
    ChangeScene,
    Input,
    Message,
    Pause,
    Play,
    Reset,
    Set,
    Speed,
    Step,
    UntilContact,
    Waiting,
)
from pymunk_dragon.sessions.replay import MAX_INPUTS, Log, Recording, play_again
from pymunk_dragon.sessions.restore import callbacks, discard
from pymunk_dragon.sessions.scene import Scene
from pymunk_dragon.sessions.scenes import SCENES, SceneSource, named_scene
from pymunk_dragon.web.frames import without_nan

_Answer = Callable[[dict[str, Any]], object]

# Longest step that a program may make, s.
MAX_STEP = 10.0
# Messages that may wait: more than clients send while a large scene is built.
_MAX_WAITING = 1000
# Longest time that a thread waits at once, s: on Windows, Ctrl-C takes effect only between waits.
_MAX_WAIT = 0.1
# Longest wait for the end of the session's thread, s: a function of the user's may hold it.
_PATIENCE = 0.5
# Calls of a traceback that the page shows: the last ones of the user's.
_TRACE_CALLS = 3
# Whether no threads can be started: in WebAssembly, where the event loop of the page or of its
# worker makes the turns.
_WITHOUT_THREADS = sys.platform == "emscripten"
# Folders of files that are not the user's: this package's, and Pymunk's.
_PACKAGE = str(Path(__file__).parents[1])
_PYMUNK = str(Path(pymunk.__file__).parent)


class Session:
    """A scene in motion, with its clients.

    `turn` makes all progress. A thread calls it after `start`; a program with a loop of its own
    calls `step`, which calls `turn`; without threads, call `turn` again after the time that it
    returns, or when a client has sent a message.

    The lock `held` is held while a turn is made: a program that holds it may change the space.
    `Clients` and `Waiting` each have a lock of their own; no other lock is taken while one of these
    two is held.
    """

    def __init__(
        self,
        source: SceneSource,
        *,
        running: bool = True,
        log: Log | None = None,
        now: Callable[[], float] = perf_counter,
    ) -> None:
        self._own = source
        # Values of sliders with which the scene `source` begins.
        self._first = dict(log["values"]) if log else {}
        self.clients = Clients()
        self.generation = 0
        self.clock = Clock(now, running=running)

        self.held = threading.RLock()
        self._waiting = Waiting()
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

        self._holds = Holds()
        self._event_limit = EventLimit()
        # Whether a step was made, for a program that makes the steps itself.
        self._step_made = False
        # Time that the last step took, s.
        self._step_seconds = 0.0

        # Makes the steps of a replay.
        self._replay: Iterator[float | None] | None = None
        # The result of the replay; None if it does not come to its end, or there is none.
        self._replayed: Future[float | None] = Future()
        # Prepares the space of the scene for being freed.
        self._discard: Callable[[], None] = _nothing

        self._build(source, self._first)
        if log:
            self._replay = play_again(log, self.scene, self._recording)
        else:
            self._replayed.set_result(None)

    # ---- from any thread

    def start(self) -> None:
        """Call `turn` in a thread, or in the running event loop where there are no threads.

        A program that makes the steps itself calls `step` instead.
        """
        if self.scene.manual:
            return
        if _WITHOUT_THREADS:
            self._turn_later(0.0)
        else:
            self._thread = threading.Thread(
                target=self._run, name="pymunk-dragon live", daemon=True
            )
            self._thread.start()

    def step(self, length: float) -> None:
        """Make a step of a program that makes the steps itself, when the step is due.

        Messages and frames go on meanwhile. An error in the step is raised here, and does not
        pause the session, which nobody might resume.
        """
        scene = self.scene
        if not scene.manual:
            bound = "None for a program that makes the steps itself"
            raise ParameterError("step", scene.settings.step, bound)
        scene.step_length = finite("dt", length, 0, MAX_STEP, "s")
        if not scene.steps:
            # Now the program has opened its window and filled its space.
            scene.fit()
            self._describe()

        self._step_made = False
        while not self._ended.is_set():
            seconds = self.turn()
            if self._step_made:
                break
            self._wait(seconds)

    def stop(self) -> None:
        """End the thread, and what clients see.

        A thread that a function of the user's holds ends when that function returns.
        """
        self._ended.set()
        self.call(_nothing)
        if self._thread is None:
            if not self.scene.manual:
                self._discard()
        elif self._thread is not threading.current_thread():
            self._thread.join(_PATIENCE)
        for client in self.clients:
            client.stop()

    def goes_on(self, seconds: float = 0.0) -> bool:
        """Whether a thread makes the steps: after `seconds`, or as soon as it has ended."""
        if self._thread is None:
            return False
        self._thread.join(seconds)
        return self._thread.is_alive()

    def join(self, client: Client) -> None:
        """Send a client all messages and frames from now on.

        First come the scene, and the error by which it is paused.
        """
        self.clients.join(client)
        self.call(_nothing)
        if self._ended.is_set():
            client.stop()

    def leave(self, client: Client) -> None:
        """Forget a client, and let go of what it holds."""
        self.clients.leave(client)
        self.call(partial(self._let_go, client))

    def receive(self, client: Client, message: Message) -> None:
        """Have a message take effect before the next step, or send the client the error."""
        if len(self._waiting) >= _MAX_WAITING:
            bound = f"sent while fewer than {_MAX_WAITING} wait"
            raise ParameterError("message", message.do, bound)
        action = partial(self._take, message, client.tell, client)
        self._waiting.add(action, message.key())

    def call(self, action: Callable[[], object]) -> None:
        """Have something done in the session's thread, between two steps."""
        self._waiting.add(action)

    def state(self) -> dict[str, Any]:
        """What changes now and then."""
        own = {
            "generation": self.generation,
            "running": self.clock.running,
            "speed": self.clock.speed,
            "kind": "state",
            "clients": len(self.clients),
            "replaying": self._replay is not None,
        }
        return own | dict(without_nan(self.scene.state()))

    def log(self) -> Log:
        """What was done since the scene was built."""
        with self.held:
            return self._recording.log(self.scene)

    def wait_for_replay(self) -> float | None:
        """Wait for the end of a replay, and return the difference of its last poses, m or rad.

        The result is None if the replay does not come to its end.
        """
        while True:
            with suppress(TimeoutError):
                return self._replayed.result(_MAX_WAIT)

    # ---- in the thread that makes the steps

    def turn(self) -> float:
        """Take the messages that wait, and make a picture and a step if they are due.

        Returns
        -------
        float
            Time, s, after which something is due if no message comes: 0 for at once, inf if nothing
            is due.
        """
        with self.held:
            for action in self._waiting.take():
                action()
            if self._ended.is_set():
                return math.inf

            now = self.clock.read()
            step_is_due = self.clock.step_is_due(now)
            # A picture that is due shows the state before the step.
            if self.clients and self.clock.frame_is_due(now, before_step=step_is_due):
                self._show(now)
            if step_is_due:
                self._step()
            return self.clock.wait(with_frames=bool(self.clients))

    def _run(self) -> None:
        """Take turns until the session is stopped, also by `sys.exit` in the user's code."""
        try:
            with suppress(SystemExit):
                while not self._ended.is_set():
                    self._wait(self.turn())
        finally:
            if not self._ended.is_set():
                self.stop()
            with self.held:
                self._discard()

    def _turn_later(self, seconds: float) -> None:
        """Take a turn in so many s by the running event loop, and others afterwards."""
        # Not needed where there are threads.
        from asyncio import get_running_loop

        if not self._ended.is_set():
            get_running_loop().call_later(min(seconds, _MAX_WAIT), self._turn_in_loop)

    def _turn_in_loop(self) -> None:
        """Take a turn, and the next one when it is due; `sys.exit` in the user's code ends them."""
        try:
            self._turn_later(self.turn())
        except SystemExit:
            self.stop()

    def _wait(self, seconds: float) -> None:
        """Wait so many s, or for a message."""
        # Without this pause, a program that waits for `held` would get it late, or never.
        sleep(0)
        self._waiting.wait(min(seconds, _MAX_WAIT))

    def _step(self) -> None:
        scene = self.scene
        begin = self.clock.read()
        try:
            with self._watched(raises=scene.manual):
                self._advance()
                self._step_seconds = self.clock.read() - begin
                self._tell_events(begin)
        finally:
            self.clock.step_was_made(scene.step_length)
            self._step_made = True

    def _advance(self) -> None:
        """Make a step of the scene or of a replay, and pause where it stops."""
        scene = self.scene
        if self._replay is None:
            scene.advance()
            if scene.stops:
                self.clock.pause()
        else:
            # A replay does not pause where the scene stops: the recorded session went on there.
            difference = next(self._replay)
            if difference is not None:
                self.clock.pause()
                self._end_replay(difference)
        scene.stops = False

    def _end_replay(self, result: float | DragonError | None) -> None:
        """End a replay, if there is one, with the difference of its last poses or an error."""
        if self._replay is None:
            return
        self._replay = None
        if isinstance(result, DragonError):
            self._replayed.set_exception(result)
        else:
            self._replayed.set_result(result)

    @contextmanager
    def _watched(self, answer: _Answer | None = None, raises: bool = False) -> Iterator[None]:
        """Context in which an error pauses the session, and is shown to clients.

        An error of this package's goes to `answer`, if there is one. An error that
        `raises` is also raised, in a step of a program that makes the steps itself.
        """
        try:
            with callbacks_raise():
                yield
        except Exception as error:
            failure = described(error)
            if answer is not None and isinstance(error, DragonError):
                answer(failure)
            # An error is sent once, and not again in each frame of a session that it paused; one in
            # what a client does is sent each time.
            elif self.clients.tell_failure(failure, again=answer is not None):
                self._fail(error)
            if raises:
                raise

    def _fail(self, error: Exception) -> None:
        """Pause at an error, and end a replay."""
        # A program that makes the steps itself would wait for ever.
        if not self.scene.manual:
            self.clock.pause()
        self._end_replay(DragonError(f"the replay ends at step {self.scene.steps}: {error}"))

    def _show(self, now: float) -> None:
        """Send clients the state if it changed, values for charts if they are due, and a frame."""
        self.clients.tell_state(self.state())
        header: dict[str, Any] = {
            "generation": self.generation,
            "clock": now,
            "step_time": self._step_seconds,
            "focus": None,
        }
        with self._watched():
            try:
                header["focus"] = self.scene.focus()
                self.scene.draw()
                if self.clock.plot_is_due(now):
                    values = [*self.scene.plots().values()]
                    about = {"kind": "plots", "time": self.scene.time, "values": values}
                    # Not in a frame: a client need not get all of these.
                    self.clients.tell(without_nan(about))
            finally:
                shows = [client.shows_contacts for client in self.clients]
                self.scene.shows_contacts = any(shows)
                frame = self.scene.frame(header)
                for client in self.clients:
                    client.show(frame, self.scene.outlines)
        self.clock.frame_was_made()

    def _tell_events(self, now: float) -> None:
        """Send the events of the last step, but not more than clients can show."""
        events: list[Any] = self.scene.events
        found = events[:]
        del events[: len(found)]

        texts = [each for each in found if isinstance(each, str)]
        for text in self._event_limit.passed(texts, now):
            self.clients.tell({"kind": "event", "time": self.scene.time, "text": text})
        if len(found) > len(texts):
            raise ParameterError("events", found, "a list of texts")

    def _describe(self) -> None:
        """Send clients what describes the scene, also those that join later."""
        source = self.source
        known = {self._own.name: self._own} | SCENES
        about = {
            "kind": "scene",
            "role": "control",
            "generation": self.generation,
            "scenes": [{"name": each.name, "title": each.title} for each in known.values()],
            "replays": source.saved_as is not None,
            "resets": not self.scene.manual,
            "given": source.given,
            "name": source.name,
            "title": source.title,
            "text": source.text,
            "lesson": source.lesson,
            "show": self.scene.shown if source.show is None else source.show,
        }
        self.clients.tell_scene(without_nan(about | self.scene.to_dict()))

    def _let_go(self, client: Client) -> None:
        """Release what a client holds that has left; nobody gets an error of it."""
        for message in self._holds.leave(client):
            self._take(message, _ignored, client)

    def _take(self, message: Message, answer: _Answer, client: Client) -> None:
        """Have a message take effect; `answer` is called with the error if it cannot."""
        with self._watched(answer):
            self._check(message)
            match message:
                case Play():
                    self.clock.play()
                    self.clients.forget_failure()
                    self.scene.waits_for_contact |= isinstance(message, UntilContact)
                case Pause():
                    self.clock.pause()
                case Step():
                    self.clock.step(message.count)
                    self.clients.forget_failure()
                case Speed():
                    self.clock.speed = message.value
                case ChangeScene():
                    is_own = message.name == self._own.name
                    self._begin(self._own if is_own else named_scene(message.name))
                    self.clock.play()
                case Reset():
                    self._begin(self.source)
                case Set() if self.scene.rebuilds(message.name):
                    value = self.scene.parameters[message.name].checked(message.value)
                    self._build(self.source, self._recording.values | {message.name: value})
                case Input():
                    if self._holds.allows(client, message):
                        self._recording.apply(self.scene, message)
                    self._holds.note(client, message)

    def _check(self, message: Message) -> None:
        """Raise an error if a message cannot take effect in this session."""
        if isinstance(message, Input) and (self._replay is not None or self._recording.is_full):
            bound = f"sent after a replay, and one of {MAX_INPUTS} inputs"
            raise ParameterError("message", message.do, bound)
        if isinstance(message, ChangeScene | Reset) and self.scene.manual:
            bound = "another one: this program builds its space itself"
            raise ParameterError("message", message.do, bound)

    def _begin(self, source: SceneSource) -> None:
        """Begin anew, with the first values of all sliders."""
        self._build(source, self._first if source is self._own else {})

    def _build(self, source: SceneSource, values: Mapping[str, float]) -> None:
        """Begin anew with values of sliders; the old scene stays if the new one cannot be built."""
        self.clients.tell({"kind": "building"})
        try:
            scene = source.build(values)
        except Exception:
            self.clients.tell_scene()
            raise
        self._discard_old_scene(source, scene)

        self.source = source
        self.scene = scene
        self._recording = Recording(source.saved_as, values)
        self.generation += 1

        self._end_replay(None)
        self.clock.single_steps = 0
        self.clients.forget_failure()
        # Events of the old scene that were not sent are not counted.
        self._event_limit.forget()
        self._describe()

    def _discard_old_scene(self, source: SceneSource, scene: Scene) -> None:
        """Prepare the space of the old scene for being freed, if the new one has another space."""
        if self.generation and self.scene.space is not scene.space:
            self._discard()
        if source.given:
            # The space belongs to the user, whose program may go on with it.
            self._discard = _nothing
        else:
            self._discard = partial(discard, scene.space, callbacks(scene.space))


def _nothing() -> None:
    """Do nothing: an action that only ends a wait."""


def _ignored(error: dict[str, Any]) -> None:
    """Take no notice of an error."""


def described(error: BaseException) -> dict[str, Any]:
    """An exception as a message.

    One that passes through a function of the user's has its line and the end of the traceback in
    addition.
    """
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith((_PACKAGE, _PYMUNK))]
    if isinstance(error, DragonError) and not own:
        return {"kind": "error", "text": str(error)}

    own = own or frames
    last = own[-1]
    place = f"{Path(last.filename).name}, line {last.lineno}: {last.line}"
    trace = "".join(traceback.format_list(own[-_TRACE_CALLS:]))

    text = str(error) if isinstance(error, DragonError) else f"{type(error).__name__}: {error}"
    for note in getattr(error, "__notes__", ()):
        text += f" ({note})"
    return {"kind": "error", "text": text, "place": place, "trace": trace}
