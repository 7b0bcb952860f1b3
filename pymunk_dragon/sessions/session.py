"""A session: a scene that is stepped in real time, its clients, and the log of what they did to it."""

from __future__ import annotations

import json
import math
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from time import perf_counter, sleep
from typing import Any, get_type_hints

import numpy as np
import pymunk

from pymunk_dragon._arguments import MAX_COORDINATE, finite, whole, word
from pymunk_dragon._files import read_text
from pymunk_dragon.drawing.canvas import without_nan
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.physics.callbacks import callbacks_raise
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.holds import Holds
from pymunk_dragon.sessions.restore import callbacks, discard
from pymunk_dragon.sessions.scene import Scene
from pymunk_dragon.sessions.scenes import SCENES, SceneSource, named_scene, recorded_scene

# What was done to a scene since it was built, as it is written as JSON: `inputs` with the number of steps before each.
Log = dict[str, Any]
_Answer = Callable[[Any], object]
# Inputs are actions of scenes, which are recorded; all other actions change no motion.
_INPUTS = "set contacts grab drag drop release hold cut obstacle remove press pointer wheel"
_HINTS = {name: get_type_hints(getattr(DragonScene, name)) for name in _INPUTS.split()}
INPUTS = {name: {key: kind for key, kind in hints.items() if key != "return"} for name, hints in _HINTS.items()}
_PING: dict[str, dict[str, type]] = {"ping": {"id": int}}
_OTHERS: dict[str, dict[str, type]] = {"step": {"count": int}, "speed": {"value": float}, "scene": {"name": str}}
ACTIONS = INPUTS | _OTHERS | _PING | {name: {} for name in ("play", "pause", "reset", "until_contact")}
# A message that waits is replaced by a later one of these with the same name: of many resets, one is carried out.
_REPLACED = "set", "drag", "scene", "reset"
# Most inputs: two hours of a mouse that never rests; bytes of a file with them, and its steps.
_MAX_INPUTS, _MAX_SIZE, _MAX_STEPS = 500_000, 100_000_000, 100_000_000
# Most messages that wait, single steps, and events of a second that clients get; speeds, simulated over real time.
_MAX_WAITING, _MAX_COUNT, _MAX_EVENTS, _SPEEDS = 1000, 100_000, 20, (0.1, 20.0)
# s. Longest step; time between frames, at least, and between values of charts; most that a slow computer makes up for.
MAX_STEP, _FRAME_TIME, _PLOT_TIME, _LARGEST_DEBT = 10.0, 1 / 60, 0.1, 0.1
# s between two checks for messages; and to wait for a thread, which a function of the user's may hold.
_TICK, _PATIENCE = 0.002, 0.5
# Calls in a traceback that the page shows; and files that are not the user's.
_TRACE_CALLS, _LIBRARIES = 3, (str(Path(__file__).parents[1]), str(Path(pymunk.__file__).parent))


class Session:
    """A scene in motion, which a thread of its own steps, or a program by `step`; with a log, its replay."""

    # The steps of a log that is played again; how far its last poses are from those of the log, or what ended it.
    _replay: Iterator[None] | None = None
    _replayed: float | DragonError | None = None

    def __init__(self, source: SceneSource, *, running: bool = True, log: Log | None = None) -> None:
        self._own = source
        # Values of sliders with which the scene of one's own begins.
        self._first = dict(log["values"]) if log else {}
        # Pages: `tell` sends a text, `show` a frame, `stop` ends one, and `controls` is whether it may change anything.
        self.clients: tuple[Any, ...] = ()
        self._sharing = threading.Lock()
        self._holds = Holds()
        self.running, self.speed, self.generation, self._single_steps = running, 1.0, 0, 0
        # What is to be done between two steps, by keys.
        self._queue: dict[object, Callable[[], object]] = {}
        # What clients were sent last: the scene, its state, and the error by which the session is paused.
        self._description: dict[str, Any] = {}
        self._told: dict[str, Any] | None = None
        self._failure: list[dict[str, Any]] = []
        # The error of the last step of a program that makes the steps itself.
        self._error: Exception | None = None
        self._due = self._frame_due = self._plotted = self._step_seconds = 0.0
        # When the present second of events began, and their number.
        self._second, self._events = 0.0, 0
        # Held while a step is made or messages are taken: a program that holds it may change the space.
        self.held, self._ended = threading.RLock(), threading.Event()
        self._thread = threading.Thread(target=self._run_to_the_end, name="pymunk-dragon live", daemon=True)
        # Prepares the space of the scene for being freed.
        self._discard: Callable[[], None] = lambda: None
        self._build(source, self._first)
        self._replay = self._steps_of(log) if log else None

    # ---- from other threads

    def start(self) -> None:
        """Begin to step, unless a program makes the steps."""
        if self.scene.settings.step is not None:
            self._thread.start()

    def step(self, length: float) -> None:
        """Make a step of a program that makes the steps itself, when it is due: messages and frames go on meanwhile.

        An error in the step is raised here, and does not pause the session, which nobody might resume.
        """
        if self.scene.settings.step is not None:
            raise ParameterError("step", self.scene.settings.step, "None for a program that makes the steps itself")
        self.scene.step_length = finite("dt", length, 0, MAX_STEP, "s")
        if not self.scene.steps:
            # Now the program has opened its window and filled its space.
            self.scene.fit()
            self._describe()
        self._run(1)

        error, self._error = self._error, None
        if error is not None:
            raise error

    def stop(self) -> None:
        """End the thread, and what clients see; a thread that a function of the user's holds ends after it."""
        self._ended.set()
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(_PATIENCE)
        for client in self.clients:
            client.stop()

    def join(self, client: Any) -> None:
        """Send a client all messages and frames from now on: first the scene, and the error by which it is paused."""
        with self._sharing:
            self.clients = (*self.clients, client)
            self._told = None
            for message in (self._description, *self._failure):
                client.tell(message)
        if self._ended.is_set():
            client.stop()

    def leave(self, client: Any) -> None:
        """Forget a client, and let go of what it holds."""
        with self._sharing:
            self.clients = tuple(each for each in self.clients if each is not client)
        self.call(partial(self._let_go, client))

    def receive(self, client: Any, text: str) -> None:
        """Take a text of a client, which gets an answer if it is not carried out."""
        try:
            message = checked(json.loads(text), ACTIONS if client.controls else _PING)
            if message["do"] == "ping":
                client.tell({"kind": "pong", "id": message["id"]})
                return
            if len(self._queue) >= _MAX_WAITING:
                raise ParameterError("message", message["do"], f"sent while fewer than {_MAX_WAITING} wait")
        except (ValueError, RecursionError) as error:
            client.tell({"kind": "error", "text": str(error)})
            return
        self.post(message, client.tell, client)

    def post(self, message: dict[str, Any], answer: _Answer = lambda error: None, client: object = None) -> None:
        """Have a message take effect before the next step; `answer` is called with the error if it cannot."""
        key = (message["do"], message.get("name")) if message["do"] in _REPLACED else None
        self.call(partial(self._take, message, answer, client), key)

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

    def log(self) -> Log:
        """Return what was done since the scene was built."""
        with self.held:
            about = {"plan": self.source.saved_as, "values": self.values, "steps": self.scene.steps}
            inputs = [json.loads(each) for each in self.inputs]
            return about | {"inputs": inputs, "poses": self.scene.poses().tolist()}

    def wait_for_replay(self) -> float | None:
        """Wait for the end of a replay; return the difference of its last poses, m or rad, or None without an end."""
        while self._replay is not None:
            sleep(_TICK)
        if isinstance(self._replayed, DragonError):
            raise self._replayed
        return self._replayed

    # ---- in the thread that makes the steps

    def _run_to_the_end(self) -> None:
        """Make steps until the session is stopped, also by `sys.exit` in a function of the user's."""
        try:
            with suppress(SystemExit):
                self._run()
        finally:
            if not self._ended.is_set():
                self.stop()
            with self.held:
                self._discard()

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
                # A step that is due comes before a frame, unless that waits.
                if self.clients and now >= self._frame_due + _FRAME_TIME * is_due:
                    self._show(now)
                if is_due:
                    self._step()
                    steps -= 1
            # At least for a moment: a program that waits for `held` would get it late, or never.
            sleep(0 if is_due else _TICK)

    def _step(self) -> None:
        scene, begin = self.scene, perf_counter()
        self._single_steps = max(self._single_steps - 1, 0)
        with self._watched(own_step=scene.settings.step is None):
            if self._replay is not None:
                # A replay goes on after a stop, as the recorded session did.
                next(self._replay, None)
            else:
                scene.advance()
                if scene.stops:
                    self._pause()
            scene.stops = False
            self._step_seconds = perf_counter() - begin
            self._tell_events(begin)
        self._due += scene.step_length / self.speed

    def _steps_of(self, log: Log) -> Iterator[None]:
        """Make the steps of a log, each in a `next`, with the inputs before them, and those after the last one."""
        for step, message in [*log["inputs"], (log["steps"], None)]:
            while self.scene.steps < step:
                self.scene.advance()
                yield
            if message is not None:
                self._apply(message)
        self._pause()
        poses = self.scene.poses().tolist()
        if len(poses) != len(log["poses"]):
            raise DragonError("the recording has another number of bodies")
        self._end_replay(float(np.abs(np.subtract(poses, log["poses"])).max(initial=0.0)))

    def _end_replay(self, result: float | DragonError | None) -> None:
        if self._replay is not None:
            self._replayed, self._replay = result, None

    def _pause(self) -> None:
        self.running, self._single_steps = False, 0

    @contextmanager
    def _watched(self, answer: Callable[[Any], object] | None = None, own_step: bool = False) -> Iterator[None]:
        """Context in which an error pauses the session, and is shown; one of this package's is a message's answer.

        In a step of a program that makes the steps itself, it is kept for that program.
        """
        try:
            with callbacks_raise():
                yield
        except Exception as error:
            failure = _described(error)
            if own_step:
                self._error = error
            if answer is not None and isinstance(error, DragonError):
                answer(failure)
            # An error is sent once, and not again in each frame of a session that it paused.
            elif self._failure != [failure]:
                self._failure = [failure]
                self._fail(error)
                self.tell(failure)

    def _fail(self, error: Exception) -> None:
        """Pause at an error, and end a replay; a program that makes the steps itself would wait for ever."""
        if self.scene.settings.step is not None:
            self._pause()
        self._end_replay(DragonError(f"the replay ends at step {self.scene.steps}: {error}"))

    def _show(self, now: float) -> None:
        """Send clients the state if it changed, and a frame, now and then with values for charts."""
        if (state := self.state()) != self._told:
            self._told = state
            self.tell(state)
        header: dict[str, Any] = {"generation": self.generation, "clock": now, "step_time": self._step_seconds}
        with self._watched():
            if self.running and now >= self._plotted + _PLOT_TIME:
                self._plotted = now
                header["plots"] = list(self.scene.plots().values())
            frame = self.scene.frame(header)
            for client in self.clients:
                client.show(frame)
        # At even intervals, but none is made up for.
        self._frame_due = max(self._frame_due + _FRAME_TIME, perf_counter())

    def _tell_events(self, now: float) -> None:
        """Send the events of the last step, but not more than clients can show; the rest is counted."""
        events: list[Any] = self.scene.events
        found = events[:]
        del events[: len(found)]
        texts = [each for each in found if isinstance(each, str)]
        i = self._events - _MAX_EVENTS
        if now - self._second >= 1:
            self._second, self._events = now, 0
            if i > 0:
                texts = [f"{i} further events in a second", *texts]
        for text in texts[: max(_MAX_EVENTS - self._events, 0)]:
            self.tell({"kind": "event", "time": self.scene.time, "text": text})
        self._events += len(texts)
        if len(found) > len(texts):
            raise ParameterError("events", found, "a list of texts")

    def _describe(self) -> None:
        """Send clients what describes the scene, also those that join later."""
        about = {name: getattr(self.source, name) for name in ("name", "title", "text", "lesson")}
        scenes = [{"name": each.name, "title": each.title} for each in ({self._own.name: self._own} | SCENES).values()]
        session = {"kind": "scene", "role": "control", "generation": self.generation, "scenes": scenes}
        session |= {"replays": self.source.saved_as is not None, "resets": self.scene.settings.step is not None}
        session["given"] = self.source.given
        self._description = without_nan(session | about | self.scene.to_dict())
        self.tell(self._description)

    def _let_go(self, client: object) -> None:
        for message in self._holds.leave(client):
            self._take(message, lambda error: None)

    def _take(self, message: dict[str, Any], answer: _Answer, client: object = None) -> None:
        with self._watched(answer):
            if message["do"] in INPUTS and (self._replay is not None or len(self.inputs) >= _MAX_INPUTS):
                raise ParameterError("message", message["do"], f"sent after a replay, and one of {_MAX_INPUTS} inputs")
            if message["do"] in ("scene", "reset") and self.scene.settings.step is None:
                raise ParameterError("message", message["do"], "another one: this program builds its space itself")
            match message:
                case {"do": "play" | "until_contact" as action}:
                    self.running, self._failure = True, []
                    self.scene.waits_for_contact |= action == "until_contact"
                case {"do": "pause"}:
                    self._pause()
                case {"do": "step", "count": count}:
                    self._single_steps = whole("count", count, 1, _MAX_COUNT)
                    self.running, self._failure = False, []
                case {"do": "speed", "value": value}:
                    self.speed = finite("speed", value, *_SPEEDS, "times")
                case {"do": "scene", "name": name}:
                    self._begin(self._own if name == self._own.name else named_scene(name))
                    self.running = True
                case {"do": "reset"}:
                    self._begin(self.source)
                case _:
                    if self._holds.allows(client, message):
                        self._apply(message)
                    self._holds.note(client, message)

    def _apply(self, message: dict[str, Any]) -> None:
        """Change the scene, and record the input."""
        arguments = {name: value for name, value in message.items() if name != "do"}
        action = getattr(self.scene, message["do"], None)
        if action is None:
            raise ParameterError("message", message["do"], "an action that this scene has")
        if message["do"] == "set":
            slider = self.scene.parameters[word("name", message["name"], self.scene.parameters)]
            arguments["value"] = slider.checked(message["value"])
            if slider.rebuilds and self._replay is None:
                self._build(self.source, {**self._chosen, slider.name: arguments["value"]})
                return
        action(**arguments)
        if message["do"] == "set":
            self._chosen[message["name"]] = arguments["value"]
        # As JSON, which takes less memory.
        self.inputs.append(json.dumps([self.scene.steps, message]))

    def _begin(self, source: SceneSource) -> None:
        """Begin anew, with the first values of all sliders."""
        self._build(source, self._first if source is self._own else {})

    def _build(self, source: SceneSource, values: Mapping[str, float]) -> None:
        """Begin anew with values of sliders; the old scene stays if the new one cannot be built."""
        self.tell({"kind": "building"})
        self._told = None
        try:
            scene = source.build(values)
        except Exception:
            self.tell(self._description)
            raise
        self._discard_old_scene(source, scene)
        self.source, self.scene, self.values = source, scene, dict(values)
        # Values that sliders were given since the scene's first moment.
        self._chosen = dict(values)
        self.inputs: list[str] = []
        self.generation += 1
        self._end_replay(None)
        self._single_steps, self._failure = 0, []
        # Events of the old scene that were not sent are not counted.
        self._events = min(self._events, _MAX_EVENTS)
        self._describe()

    def _discard_old_scene(self, source: SceneSource, scene: Scene) -> None:
        """Prepare the space of the scene before this one for being freed, if this one has another."""
        if self.generation and self.scene.space is not scene.space:
            self._discard()
        if source.given:
            # It belongs to the user, whose program may go on with it.
            self._discard = lambda: None
        else:
            self._discard = partial(discard, scene.space, callbacks(scene.space))


def _described(error: Exception) -> dict[str, Any]:
    """Return an exception as a message: of one in the user's functions also the end of the traceback, and the line."""
    if isinstance(error, DragonError):
        return {"kind": "error", "text": str(error)}
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith(_LIBRARIES)] or frames
    place = f"{Path(own[-1].filename).name}, line {own[-1].lineno}: {own[-1].line}"
    trace = "".join(traceback.format_list(own[-_TRACE_CALLS:]))
    text = f"{type(error).__name__}: {error}" + "".join(f" ({note})" for note in getattr(error, "__notes__", ()))
    return {"kind": "error", "text": text, "place": place, "trace": trace}


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


def load_log(path: str | Path) -> Log:
    """Read a log from a file that the program or the page wrote."""
    text = read_text(path, "replay", _MAX_SIZE)
    try:
        log: Log = json.loads(text)
        recorded_scene(log["plan"])
        for step, message in [*log["inputs"], (log["steps"], {"do": "drop"})]:
            whole("step", step, 0, _MAX_STEPS)
            checked(message, INPUTS)
        for name, value in log["values"].items():
            finite(name, value, -math.inf, math.inf, "")
        if not np.isfinite(np.array(log["poses"], dtype=float).reshape(len(log["poses"]), 3)).all():
            raise ValueError("a pose is not finite")
    except Exception as error:  # Whatever it is, the content is to blame.
        raise FileFormatError(path, "no recording of a built-in scene or of a march, or a damaged one") from error
    return log
