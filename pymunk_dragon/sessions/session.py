"""A session: a scene that is stepped in real time, what was done to it, and who watches."""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from functools import partial
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any

from pymunk_dragon._arguments import finite, whole, word
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.sessions.controls import Slider
from pymunk_dragon.sessions.messages import INPUTS, MAX_INPUTS, MAX_MESSAGE, parsed, without_nan
from pymunk_dragon.sessions.ready import SCENES, Ready, ready
from pymunk_dragon.sessions.user_code import callbacks_raise, described

if TYPE_CHECKING:
    from pymunk_dragon.sessions.recording import Log

# Simulated over real time.
SPEEDS = 0.1, 20.0
# s between frames, at least.
_FRAME_TIME = 1 / 60
# s of real time: a computer that is slower than real time does not try to catch up with more than this.
_LARGEST_DEBT = 0.1
# s between two checks for messages while the thread waits; and for Ctrl-C while another thread waits.
_TICK, PATIENCE = 0.002, 0.2
# s that `stop` waits for the thread, which a function of the user's may hold.
_LONGEST_STOP = 0.5
# s. Longest step.
MAX_STEP = 10.0
# s over which the rate is averaged, and between two values of the charts.
_RATE_TIME, _PLOT_TIME = 1.0, 0.1
# Steps at once; messages that wait for the thread, and events of a second that clients get: others are only counted.
_MAX_COUNT, _MAX_WAITING, _MAX_EVENTS = 100_000, 1000, 20


class Session:
    """A scene in motion, which a thread of its own steps, or a program by `step`."""

    def __init__(self, source: Ready, *, running: bool = True) -> None:
        self.source = self._own = source
        # Pages: `tell` sends one a text, `show` a frame, and `controls` is whether it may change anything.
        self.clients: tuple[Any, ...] = ()
        self._telling = threading.Lock()
        # The client whose hand holds a body.
        self._holder: object = None
        self.running, self.speed, self.generation = running, 1.0, 0
        # Inputs of a recording that wait for their steps, and the step after which the replay ends.
        self._replay: deque[tuple[int, dict[str, Any]]] | None = None
        self._replay_end = 0
        self._replayed: Future[list[list[float]] | None] = Future()
        self._queue: deque[Callable[[], object]] = deque()
        self._wanted: tuple[Ready, Mapping[str, float]] | None = None
        # Real and simulated times of the frames of the last second.
        self._pace: deque[tuple[float, float]] = deque()
        self._due = self._frame_due = self._shown = perf_counter()
        self._step_seconds = self._plotted = 0.0
        self._second, self._events = 0.0, 0
        self._failure: list[dict[str, Any]] = []
        # Held while a step is made or messages are taken: a program that holds it may change the space.
        self.held, self._ended = threading.RLock(), threading.Event()
        self._changed, self._single_steps = False, 0
        self._build(source, {})
        self._thread = threading.Thread(target=self._run, name="pymunk-dragon live", daemon=True)

    # ---- from other threads

    def start(self) -> None:
        """Begin to step, unless a program makes the steps."""
        if self.scene.play.step is not None:
            self._thread.start()

    def step(self, length: float) -> None:
        """Make a step of a program that makes the steps itself, when it is due: messages and frames go on meanwhile."""
        if self.scene.play.step is not None:
            raise ParameterError("step", self.scene.play.step, "None for a program that makes the steps itself")
        self.scene.step_length = finite("dt", length, 0, MAX_STEP, "s")
        if not self.scene.steps:
            # Now the program has opened its window and filled its space.
            self.scene.fit()
            self._describe()
            self.tell(self._description)
        self._wait_for_step()
        self._step()

    def stop(self) -> None:
        """End the thread; one that is held by a function of the user's ends after it."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(_LONGEST_STOP)

    def wait(self) -> None:
        """Wait until the session is stopped from another thread."""
        while not self._ended.wait(PATIENCE):
            pass

    def join(self, client: Any) -> None:
        """Have a client get what is told and shown: first the scene, and the error by which it is paused."""
        with self._telling:
            self.clients = (*self.clients, client)
            for message in (self._description, *self._failure):
                client.tell(message)
        self._changed = True

    def leave(self, client: Any) -> None:
        """Forget a client, and drop the body that it holds."""
        with self._telling:
            self.clients = tuple(each for each in self.clients if each is not client)
        if self._holder is client:
            self.post({"do": "drop"})
        self._changed = True

    def receive(self, client: Any, text: str) -> None:
        """Take a text of a client, which gets an answer if it is not carried out."""
        try:
            message = parsed(text)
            action = message["do"]
            if action == "ping":
                client.tell({"kind": "pong", "id": message["id"]})
                return
            if not client.controls:
                raise ParameterError("message", action, "sent from the other address: this one only watches")
            if len(self._queue) >= _MAX_WAITING:
                raise ParameterError("message", action, "sent later: too many wait")
        except ParameterError as error:
            client.tell({"kind": "error", "text": str(error)[:MAX_MESSAGE]})
            return
        # One hand: who grabs another body takes it over.
        self._holder = {"grab": client, "drop": None}.get(action, self._holder)
        self.post(message, lambda reason: client.tell({"kind": "error", "text": reason}))

    def post(self, message: dict[str, Any], answer: Callable[[str], None] = lambda error: None) -> None:
        """Have a message take effect before the next step; `answer` is called with the reason if it cannot."""
        self.call(partial(self._take, message, answer))

    def call(self, action: Callable[[], object]) -> None:
        """Have something done in the session's thread, between two steps."""
        self._queue.append(action)

    def tell(self, message: dict[str, Any]) -> None:
        """Send a text to all clients."""
        with self._telling:
            for client in self.clients:
                client.tell(message)

    def state(self) -> dict[str, Any]:
        """Return what changes now and then."""
        own = {name: getattr(self, name) for name in ("generation", "running", "speed")}
        own |= {"clients": len(self.clients), "replaying": self.replaying}
        return dict(without_nan({"kind": "state", **own, **self.scene.state()}))

    # ---- replays

    @property
    def replaying(self) -> bool:
        """Whether a replay goes on."""
        return self._replay is not None

    def play_again(self, log: Log) -> None:
        """Build the scene of a log, and carry out its inputs before the steps at which they came; before `start`."""
        self._build(self.source, log.values)
        self._replay, self._replay_end = deque(log.inputs), log.steps
        with self._watched():
            self._go_on_with_replay()

    def replay_until(self, time: float) -> None:
        """Make the steps of a replay up to a time, as fast as they go, in place of the thread."""
        while self.replaying and self.scene.time < time:
            self._step()
        if not self.replaying:
            self._replayed.result()

    def wait_for_replay(self) -> list[list[float]] | None:
        """Wait for the end of a replay, and return its last poses, or None if it was cancelled."""
        while True:
            with suppress(TimeoutError):
                return self._replayed.result(PATIENCE)

    def _go_on_with_replay(self) -> None:
        """Carry out the inputs of a replay that belong before the next step; after its last step it ends."""
        while self._replay and self._replay[0][0] <= self.scene.steps:
            self._apply(self._replay.popleft()[1])
        if self.replaying and self.scene.steps >= self._replay_end:
            self._pause()
            self._replay = None
            self._replayed.set_result(self.scene.poses().tolist())

    # ---- time

    def _run(self) -> None:
        while self._wait_for_step():
            self._step()

    def _wait_for_step(self) -> bool:
        """Take messages and make frames until a step is due; return whether the session goes on."""
        while not self._ended.is_set():
            with self.held:
                while self._queue:
                    self._queue.popleft()()
                with self._watched():
                    self._build_wanted()
                now = perf_counter()
                if not self.running:
                    self._due = now
                    self._pace.clear()
                self._due = max(self._due, now - _LARGEST_DEBT)
                is_due = self._single_steps > 0 or (self.running and now >= self._due)
                self._refresh(now, is_due)
                if is_due:
                    return True
            sleep(_TICK)
        return False

    def _step(self) -> None:
        """Make one step."""
        scene, begin = self.scene, perf_counter()
        self._single_steps = max(self._single_steps - 1, 0)
        with self.held, self._watched():
            scene.advance()
            self._step_seconds = perf_counter() - begin
            self._tell_events()
            # A recorded session went on after a stop.
            if scene.stops and not self.replaying:
                self._pause()
            scene.stops = False
            self._go_on_with_replay()
        self._due += scene.step_length / self.speed

    def _pause(self) -> None:
        self.running, self._single_steps = False, 0
        self._changed = True

    @contextmanager
    def _watched(self, answer: Callable[[str], None] | None = None) -> Iterator[None]:
        """Context in which an exception of the user's functions pauses the session, and is shown.

        An error of this package's is the answer to a message, if there is one.
        """
        try:
            with callbacks_raise():
                yield
        except Exception as error:
            if answer is not None and isinstance(error, DragonError):
                answer(str(error))
                return
            self._pause()
            failure = described(error)
            if self.replaying:
                self._replay = None
                self._replayed.set_exception(DragonError(f"the replay ends at step {self.scene.steps}: {error}"))
            # Not again in each frame of a session that is paused by it.
            if self._failure != [failure]:
                self._failure = [failure]
                self.tell(failure)

    # ---- what clients get

    def _refresh(self, now: float, step_is_due: bool) -> None:
        """Send the state if it changed, and a frame if one is due; steps that are due come first, for a while."""
        if self._changed:
            self._changed = False
            self.tell(self.state())
        if self.clients and now >= self._frame_due and not (step_is_due and now < self._shown + _FRAME_TIME):
            # At even intervals, but none is made up for.
            self._frame_due = max(self._frame_due + _FRAME_TIME, now)
            with self._watched():
                frame = self.scene.frame(self._header(now))
                for client in self.clients:
                    client.show(frame)
            self._shown = perf_counter()

    def _header(self, now: float) -> dict[str, Any]:
        """Return the session's part of a frame: the rate of the last second, times, and values for the charts."""
        self._pace.append((now, self.scene.time))
        while now - self._pace[0][0] > _RATE_TIME:
            self._pace.popleft()
        passed = now - self._pace[0][0]
        # Not of the first moments after a pause.
        rate = (self.scene.time - self._pace[0][1]) / passed if passed >= _RATE_TIME / 2 else None
        header: dict[str, Any] = {"generation": self.generation, "rate": rate, "step_time": self._step_seconds}
        if self.running and now >= self._plotted + _PLOT_TIME:
            self._plotted = now
            header["plots"] = list(self.scene.plots().values())
        return header

    def _tell_events(self) -> None:
        """Tell what happened, but not more than clients can show; the rest is counted."""
        now, texts = perf_counter(), list(self.scene.events)
        self.scene.events.clear()
        # What happened may have changed a slider.
        self._changed |= bool(texts)
        if now - self._second >= 1:
            if (i := self._events - _MAX_EVENTS) > 0:
                texts.insert(0, f"{i} further events in a second")
            self._second, self._events = now, 0
        for text in texts[: max(_MAX_EVENTS - self._events, 0)]:
            self.tell({"kind": "event", "time": self.scene.time, "text": text})
        self._events += len(texts)

    def _describe(self) -> None:
        source, choices = self.source, {self._own.name: self._own} | SCENES
        own = {name: getattr(source, name) for name in ("name", "title", "text", "lesson")}
        scenes = [{"name": name, "title": each.title} for name, each in choices.items()]
        session = {"kind": "scene", "role": "control", "generation": self.generation, "scenes": scenes}
        self._description = without_nan({**session, **own, **self.scene.to_dict()})

    # ---- messages

    def _take(self, message: dict[str, Any], answer: Callable[[str], None]) -> None:
        """Carry out a message, or note the wish for a new scene: wishes that wait together are carried out as one."""
        with self._watched(answer):
            action = message["do"]
            # The place of the hand is in each frame.
            self._changed |= action != "drag"
            if action in ("scene", "reset") and self.scene.play.step is None:
                raise ParameterError("message", action, "another one: this program builds its space itself")
            if action == "scene":
                name = message["name"]
                self._wanted = (self._own if name == self._own.name else ready(name)), {}
                self.running = True
            elif action == "reset":
                self._wanted = self._wanted or (self.source, self.values)
            elif action != "set" or self.replaying or not self._wishes_value(message):
                self._build_wanted()
                self._act(action, message)

    def _wishes_value(self, message: dict[str, Any]) -> bool:
        """Note the wish for a scene with another value of a slider, if the slider rebuilds."""
        if self._wanted is not None and self._wanted[0] is not self.source:
            # It has other sliders.
            self._build_wanted()
        slider = self._slider(message["name"])
        if slider.rebuilds:
            values = self.scene.values if self._wanted is None else self._wanted[1]
            self._wanted = self.source, {**values, slider.name: slider.checked(message["value"])}
        return slider.rebuilds

    def _act(self, action: str, message: dict[str, Any]) -> None:
        """Carry out a message that needs no new scene."""
        if action in INPUTS:
            if self.replaying or len(self.inputs) >= MAX_INPUTS:
                bound = f"sent after a replay, and one of at most {MAX_INPUTS} inputs until a reset"
                raise ParameterError("message", action, bound)
            self._apply(message)
        elif action == "play":
            self.running, self._failure = True, []
        elif action == "pause":
            self._pause()
        elif action == "step":
            count = whole("count", message["count"], 1, _MAX_COUNT)
            self._pause()
            self._single_steps, self._failure = count, []
        elif action == "speed":
            self.speed = finite("speed", message["value"], *SPEEDS, "times")
            self._pace.clear()
        elif action == "until_contact":
            self.running = self.scene.waits_for_contact = True

    def _apply(self, message: dict[str, Any]) -> None:
        """Change the scene, and log the input."""
        arguments = {name: value for name, value in message.items() if name != "do"}
        action = getattr(self.scene, message["do"], None)
        if action is None:
            raise ParameterError("message", message["do"], "an action that this scene has")
        if message["do"] == "set":
            slider = self._slider(message["name"])
            if slider.rebuilds:
                raise ParameterError("name", slider.name, "a slider with which the scene does not begin anew")
            arguments["value"] = slider.checked(message["value"])
        action(**arguments)
        # As JSON, which takes less memory.
        self.inputs.append(json.dumps([self.scene.steps, message]))

    def _slider(self, name: str) -> Slider:
        known = self.scene.parameters
        return known[word("name", name, list(known))]

    # ---- scenes

    def _build_wanted(self) -> None:
        if self._wanted is not None:
            (source, values), self._wanted = self._wanted, None
            self.tell({"kind": "building"})
            try:
                self._build(source, values)
            finally:
                self.tell(self._description)
                self._changed = True

    def _build(self, source: Ready, values: Mapping[str, float]) -> None:
        """Begin anew; the old scene stays if the new one cannot be built."""
        scene = source.build(values)
        self.source, self.scene, self.values = source, scene, dict(values)
        self.generation += 1
        self.inputs: list[str] = []
        if self.replaying:
            self._replay = None
            self._replayed.set_result(None)
        self._single_steps, self._failure = 0, []
        # The time in which a scene is built is not played.
        self._due = perf_counter()
        self._pace.clear()
        self._describe()
        self._changed = True
