"""A session: a scene that is stepped in real time, what was done to it, and its clients."""

from __future__ import annotations

import json
import math
import threading
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any, get_type_hints

import pymunk

from pymunk_dragon._arguments import MAX_COORDINATE, finite, whole, word
from pymunk_dragon.drawing.canvas import without_nan
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.physics.callbacks import callbacks_raise
from pymunk_dragon.sessions.controls import Slider
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.ready import SCENES, Ready, ready

if TYPE_CHECKING:
    from pymunk_dragon.sessions.recording import Log

# Inputs are actions of scenes, which are recorded; all other actions change no motion.
_INPUTS = "set contacts grab drag drop release hold cut obstacle remove press pointer"
_HINTS = {name: get_type_hints(getattr(DragonScene, name)) for name in _INPUTS.split()}
INPUTS = {name: {key: kind for key, kind in hints.items() if key != "return"} for name, hints in _HINTS.items()}
_PING: dict[str, dict[str, type]] = {"ping": {"id": int}}
_OTHERS: dict[str, dict[str, type]] = {"step": {"count": int}, "speed": {"value": float}, "scene": {"name": str}}
ACTIONS = INPUTS | _OTHERS | _PING | {name: {} for name in ("play", "pause", "reset", "until_contact")}
# A message that waits is replaced by a later one of these with the same name: of many resets, one is carried out.
_REPLACED = "set", "drag", "scene", "reset"
# Most inputs: two hours of a mouse that never rests; single steps; and events of a second that clients get.
MAX_INPUTS, _MAX_COUNT, _MAX_EVENTS = 500_000, 100_000, 20
# Simulated over real time.
_SPEEDS = 0.1, 20.0
# s. Longest step; time between frames, at least, and between values of charts; and that of the average rate.
MAX_STEP, _FRAME_TIME, _PLOT_TIME, _RATE_TIME = 10.0, 1 / 60, 0.1, 1.0
# s of real time: a computer that is slower than real time does not try to catch up with more than this.
_LARGEST_DEBT = 0.1
# s between two checks for messages, and for Ctrl-C; and to wait for a thread, which a function of the user's may hold.
_TICK, _PATIENCE, _LONGEST_STOP = 0.002, 0.2, 0.5
# Lines of a traceback that the page shows; and files that are not the user's.
_TRACE_LINES, _LIBRARIES = 8, (str(Path(__file__).parents[1]), str(Path(pymunk.__file__).parent))


class Session:
    """A scene in motion, which a thread of its own steps, or a program by `step`."""

    def __init__(self, source: Ready, *, running: bool = True) -> None:
        self._own = source
        # Pages: `tell` sends one a text, `show` a frame, and `controls` is whether it may change anything.
        self.clients: tuple[Any, ...] = ()
        self._sharing = threading.Lock()
        # The client whose hand holds a body.
        self._holder: object = None
        self.running, self.speed, self.generation, self._single_steps = running, 1.0, 0, 0
        # The steps of a recording that is played again; and its last poses in the end.
        self._replay: Iterator[None] | None = None
        self._replayed: Future[list[list[float]] | None] = Future()
        # What is to be done between two steps, by keys.
        self._queue: dict[object, Callable[[], object]] = {}
        # What clients were told last: the scene, its state, and the error by which the session is paused.
        self._description: dict[str, Any] = {}
        self._told: dict[str, Any] | None = None
        self._failure: list[dict[str, Any]] = []
        # Real and simulated times of the frames of the last second.
        self._pace: deque[tuple[float, float]] = deque()
        self._due = self._frame_due = self._shown = perf_counter()
        self._step_seconds = self._plotted = 0.0
        # When the present second of events began, and their number.
        self._second, self._events = 0.0, 0
        # Held while a step is made or messages are taken: a program that holds it may change the space.
        self.held, self._ended = threading.RLock(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="pymunk-dragon live", daemon=True)
        self._build(source, {})

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
        self._run(1)

    def stop(self) -> None:
        """End the thread; one that is held by a function of the user's ends after it."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(_LONGEST_STOP)

    def wait(self) -> None:
        """Wait until the session is stopped from another thread."""
        while not self._ended.wait(_PATIENCE):
            pass

    def join(self, client: Any) -> None:
        """Have a client get what is told and shown: first the scene, and the error by which it is paused."""
        with self._sharing:
            self.clients = (*self.clients, client)
            self._told = None
            for message in (self._description, *self._failure):
                client.tell(message)

    def leave(self, client: Any) -> None:
        """Forget a client, and drop the body that it holds."""
        with self._sharing:
            self.clients = tuple(each for each in self.clients if each is not client)
        if self._holder is client:
            self.post({"do": "drop"})

    def receive(self, client: Any, text: str) -> None:
        """Take a text of a client, which gets an answer if it is not carried out."""
        try:
            message = checked(json.loads(text), ACTIONS if client.controls else _PING)
        except (ValueError, RecursionError) as error:
            client.tell({"kind": "error", "text": str(error)})
            return
        if message["do"] == "ping":
            client.tell({"kind": "pong", "id": message["id"]})
            return
        # One hand: a client that grabs another body takes the hand over.
        self._holder = {"grab": client, "drop": None}.get(message["do"], self._holder)
        self.post(message, client.tell)

    def post(self, message: dict[str, Any], answer: Callable[[Any], object] = lambda error: None) -> None:
        """Have a message take effect before the next step; `answer` is called with the error if it cannot."""
        key = (message["do"], message.get("name")) if message["do"] in _REPLACED else None
        self.call(partial(self._take, message, answer), key)

    def call(self, action: Callable[[], object], key: object = None) -> None:
        """Have something done in the session's thread, between two steps, in place of what waits with the same key."""
        with self._sharing:
            self._queue.pop(key, None)
            self._queue[key or object()] = action

    def tell(self, message: dict[str, Any]) -> None:
        """Send a text to all clients."""
        with self._sharing:
            for client in self.clients:
                client.tell(message)

    def state(self) -> dict[str, Any]:
        """Return what changes now and then."""
        own = {name: getattr(self, name) for name in ("generation", "running", "speed")}
        own |= {"kind": "state", "clients": len(self.clients), "replaying": self._replay is not None}
        return own | dict(without_nan(self.scene.state()))

    def play_again(self, log: Log) -> None:
        """Build the scene of a log, and carry out its inputs before the steps at which they came; before `start`."""
        self._build(self.source, log.values)
        self._replay = self._steps_of(log)

    def _steps_of(self, log: Log) -> Iterator[None]:
        """Make the steps of a log, each in a `next`, with the inputs before them, and those after the last one."""
        for step, message in [*log.inputs, (log.steps, None)]:
            while self.scene.steps < step:
                self.scene.advance()
                yield
            if message is not None:
                self._apply(message)
        self._pause()
        self._replay = None
        self._replayed.set_result(self.scene.poses().tolist())

    def replay_until(self, time: float) -> None:
        """Make the steps of a replay up to a time, as fast as they go, in place of the thread."""
        while self._replay is not None and self.scene.time < time:
            self._step()
        if self._replay is None:
            self._replayed.result()

    def wait_for_replay(self) -> list[list[float]] | None:
        """Wait for the end of a replay, and return its last poses, or None if it was cancelled."""
        while True:
            with suppress(TimeoutError):
                return self._replayed.result(_PATIENCE)

    # ---- in the thread that makes the steps

    def _run(self, steps: float = math.inf) -> None:
        """Take messages, and make frames, and so many steps when they are due."""
        while steps > 0 and not self._ended.is_set():
            with self.held:
                with self._sharing:
                    actions, self._queue = self._queue, {}
                for action in actions.values():
                    action()
                now = perf_counter()
                self._due = max(self._due, now - _LARGEST_DEBT) if self.running else now
                is_due = self._single_steps > 0 or (self.running and now >= self._due)
                # Steps that are due come before frames, for a while.
                if self.clients and now >= (self._shown + _FRAME_TIME if is_due else self._frame_due):
                    self._show(now)
                if is_due:
                    self._step()
                    steps -= 1
            if not is_due:
                sleep(_TICK)

    def _step(self) -> None:
        scene, begin = self.scene, perf_counter()
        self._single_steps = max(self._single_steps - 1, 0)
        with self._watched():
            if self._replay is None:
                scene.advance()
            else:
                next(self._replay, None)
            self._step_seconds = perf_counter() - begin
            self._tell_events(begin)
            # A recorded session went on after a stop.
            if scene.stops and self._replay is None:
                self._pause()
            scene.stops = False
        self._due += scene.step_length / self.speed

    def _pause(self) -> None:
        self.running, self._single_steps = False, 0

    @contextmanager
    def _watched(self, answer: Callable[[Any], object] | None = None) -> Iterator[None]:
        """Context in which an exception of the user's functions pauses the session, and is shown.

        An error of this package's is the answer to a message, if there is one.
        """
        try:
            with callbacks_raise():
                yield
        except Exception as error:
            failure = _described(error)
            if answer is not None and isinstance(error, DragonError):
                answer(failure)
                return
            self._pause()
            if self._replay is not None:
                self._replay = None
                self._replayed.set_exception(DragonError(f"the replay ends at step {self.scene.steps}: {error}"))
            # Not again in each frame of a session that is paused by it.
            if self._failure != [failure]:
                self._failure = [failure]
                self.tell(failure)

    def _show(self, now: float) -> None:
        """Send clients the state if it changed, and a frame with the rate of the last second and values for charts."""
        # At even intervals, but none is made up for.
        self._frame_due = max(self._frame_due + _FRAME_TIME, now)
        if (state := self.state()) != self._told:
            self._told = state
            self.tell(state)
        if not self.running:
            self._pace.clear()
        self._pace.append((now, self.scene.time))
        while now - self._pace[0][0] > _RATE_TIME:
            self._pace.popleft()
        passed, simulated = now - self._pace[0][0], self.scene.time - self._pace[0][1]
        # Not of the first moments after a pause.
        rate = simulated / passed if passed >= _RATE_TIME / 2 else None
        header: dict[str, Any] = {"generation": self.generation, "rate": rate, "step_time": self._step_seconds}
        with self._watched():
            if self.running and now >= self._plotted + _PLOT_TIME:
                self._plotted = now
                header["plots"] = list(self.scene.plots().values())
            frame = self.scene.frame(header)
            for client in self.clients:
                client.show(frame)
        self._shown = perf_counter()

    def _tell_events(self, now: float) -> None:
        """Tell what happened, but not more than clients can show; the rest is counted."""
        texts = self.scene.events
        if now - self._second >= 1:
            if (i := self._events - _MAX_EVENTS) > 0:
                texts.insert(0, f"{i} further events in a second")
            self._second, self._events = now, 0
        for text in texts:
            self._events += 1
            if self._events <= _MAX_EVENTS:
                self.tell({"kind": "event", "time": self.scene.time, "text": text})
        texts.clear()

    def _describe(self) -> None:
        """Tell clients of the scene, also those that come later."""
        about = {name: getattr(self.source, name) for name in ("name", "title", "text", "lesson")}
        scenes = [{"name": each.name, "title": each.title} for each in ({self._own.name: self._own} | SCENES).values()]
        session = {"kind": "scene", "role": "control", "generation": self.generation, "scenes": scenes}
        self._description = without_nan(session | about | self.scene.to_dict())
        self.tell(self._description)

    def _take(self, message: dict[str, Any], answer: Callable[[Any], object]) -> None:
        with self._watched(answer):
            if message["do"] in INPUTS and (self._replay is not None or len(self.inputs) >= MAX_INPUTS):
                raise ParameterError("message", message["do"], f"sent after a replay, and one of {MAX_INPUTS} inputs")
            if message["do"] in ("scene", "reset") and self.scene.play.step is None:
                raise ParameterError("message", message["do"], "another one: this program builds its space itself")
            match message:
                case {"do": "play"}:
                    self.running, self._failure = True, []
                case {"do": "pause"}:
                    self._pause()
                case {"do": "step", "count": count}:
                    self.running, self._single_steps = False, whole("count", count, 1, _MAX_COUNT)
                    self._failure = []
                case {"do": "until_contact"}:
                    self.running = self.scene.waits_for_contact = True
                case {"do": "speed", "value": value}:
                    self.speed = finite("speed", value, *_SPEEDS, "times")
                    self._pace.clear()
                case {"do": "scene", "name": name}:
                    self._build(self._own if name == self._own.name else ready(name), {})
                    self.running = True
                case {"do": "reset"}:
                    self._build(self.source, self.values)
                case {"do": "set", "name": name, "value": value} if self._slider(name).rebuilds:
                    self._build(self.source, {**self.scene.values, name: self._slider(name).checked(value)})
                case _:
                    self._apply(message)

    def _apply(self, message: dict[str, Any]) -> None:
        """Change the scene, and record the input."""
        arguments = {name: value for name, value in message.items() if name != "do"}
        action = getattr(self.scene, message["do"], None)
        if action is None:
            raise ParameterError("message", message["do"], "an action that this scene has")
        if message["do"] == "set":
            arguments["value"] = self._slider(message["name"]).checked(message["value"])
        action(**arguments)
        # As JSON, which takes less memory.
        self.inputs.append(json.dumps([self.scene.steps, message]))

    def _slider(self, name: str) -> Slider:
        known = self.scene.parameters
        return known[word("name", name, list(known))]

    def _build(self, source: Ready, values: Mapping[str, float]) -> None:
        """Begin anew; the old scene stays if the new one cannot be built."""
        self.tell({"kind": "building"})
        self._told = None
        try:
            scene = source.build(values)
        except Exception:
            self.tell(self._description)
            raise
        self.source, self.scene, self.values = source, scene, dict(values)
        self.inputs: list[str] = []
        self.generation += 1
        if self._replay is not None:
            self._replay = None
            self._replayed.set_result(None)
        self._single_steps, self._failure = 0, []
        # The time in which a scene is built is not played.
        self._due = perf_counter()
        self._pace.clear()
        self._describe()


def _described(error: Exception) -> dict[str, Any]:
    """Return an exception as a message: of one in the user's functions also the end of the traceback, and the line."""
    if isinstance(error, DragonError):
        return {"kind": "error", "text": str(error)}
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith(_LIBRARIES)] or frames
    lines = "".join(traceback.format_list(own)).splitlines()
    place = f"{Path(own[-1].filename).name}, line {own[-1].lineno}: {own[-1].line}"
    text = f"{type(error).__name__}: {error}"
    return {"kind": "error", "text": text, "place": place, "trace": "\n".join(lines[-_TRACE_LINES:])}


def checked(found: Any, actions: Mapping[str, Mapping[str, type]]) -> dict[str, Any]:
    """Return a message that was read, if it has one of these actions, all its arguments, and nothing else."""
    kinds = actions.get(str(found.get("do"))) if isinstance(found, dict) else None
    if kinds is None or found.keys() != {"do", *kinds}:
        raise ParameterError("message", found, "an action with its arguments: do is one of " + ", ".join(actions))
    message = {"do": found["do"]}
    for name, kind in kinds.items():
        # Values of sliders have bounds of their own.
        value, most = found[name], math.inf if name == "value" else MAX_COORDINATE
        message[name] = finite(name, value, -most, most, "") if kind is float else value
        if type(message[name]) is not kind:
            raise ParameterError(name, value, f"a value of the type {kind.__name__}")
    return message
