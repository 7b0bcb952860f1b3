"""A session: a scene that is stepped in real time in a thread of its own, what was done to it, and who watches."""

from __future__ import annotations

import sys
import threading
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

import pymunk

from pymunk_dragon._checks import finite, whole, word
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.sessions.controls import Slider
from pymunk_dragon.sessions.log import MAX_INPUTS, InputLog
from pymunk_dragon.sessions.messages import INPUTS, without_nan
from pymunk_dragon.sessions.ready import SCENES, Ready, ready
from pymunk_dragon.sessions.recording import Frames

# Simulated over real time.
SPEEDS = 0.1, 20.0
# Frames a second that are made, at most.
_FRAME_RATE = 60.0
# s of real time: a computer that is slower than real time does not try to catch up with more than this.
_LARGEST_DEBT = 0.1
# s of real time after which the thread takes messages, even if further steps are due.
_LONGEST_TURN = 1 / _FRAME_RATE
# s between two checks for messages while the thread waits; and for Ctrl-C while another thread waits for it.
_TICK, PATIENCE = 0.002, 0.2
# s that `stop` waits for the thread, which a function of the user's may hold.
_LONGEST_STOP = 0.5
# s. Longest step of a program that makes the steps itself.
_MAX_LENGTH = 10.0
# Steps at once.
MAX_COUNT = 100_000
# s over which the rate is averaged, and between two values of the charts.
_RATE_TIME, _PLOT_TIME = 1.0, 0.1
# Share of a new value in the mean time of a step that is shown.
_SMOOTHING = 0.1
# Messages that wait for the thread; a client that floods loses the others.
_MAX_WAITING = 1000
# Events of a second that clients get; the others are counted.
_MAX_EVENTS = 20
# Lines of a traceback that the page shows.
_TRACE_LINES = 8
# Files that are not the user's.
_LIBRARIES = str(Path(__file__).parents[1]), str(Path(pymunk.__file__).parent)


class _StoppedError(Exception):
    """The session was stopped while a program held it."""


# Exceptions in callbacks of the present thread, while they are collected; and the hook that was there before.
_CAUGHT, _BEFORE = threading.local(), [sys.__unraisablehook__]


def _unraisable(raised: Any) -> None:
    """Collect an exception in a callback, which C calls, so that Python would only print it."""
    errors = getattr(_CAUGHT, "errors", None)
    if errors is not None and isinstance(raised.exc_value, Exception):
        errors.append(raised.exc_value)
    else:
        _BEFORE[0](raised)


@contextmanager
def _callbacks() -> Iterator[None]:
    """Context that raises the first exception of a callback in this thread at its end."""
    if sys.unraisablehook is not _unraisable:
        # It stays, as other threads may be in this context too.
        _BEFORE[0], sys.unraisablehook = sys.unraisablehook, _unraisable
    _CAUGHT.errors = []
    try:
        yield
        if _CAUGHT.errors:
            raise _CAUGHT.errors[0]
    finally:
        _CAUGHT.errors = None


class _Replay:
    """Inputs of a recording that are carried out again, each before a certain step, until the step `steps`."""

    def __init__(self, inputs: Sequence[tuple[int, dict[str, Any]]], steps: int) -> None:
        self.inputs, self.steps = deque(inputs), steps
        self.ended = threading.Event()
        self.poses: list[list[float]] | None = None
        self.error: str | None = None

    def end(self, *, poses: list[list[float]] | None = None, error: str | None = None) -> None:
        """End with the last poses, with an error, or with neither if the replay is cancelled; only once."""
        if not self.ended.is_set():
            self.poses, self.error = poses, error
            self.ended.set()


class Session:
    """A scene in motion."""

    def __init__(self, source: Ready, *, record: bool = False, running: bool = True) -> None:
        self.source = self._own = source
        # A server and widgets: `tell` sends a text to their clients, `show` a frame.
        self.audience: list[Any] = []
        self.clients = 0
        self.running, self.speed = running, 1.0
        self.generation = 0
        self.frames = Frames() if record else None
        self._replay = _Replay((), 0)
        self._replay.end()
        self._waiting: deque[tuple[dict[str, Any], Callable[[str], None]]] = deque()
        self._calls: deque[Callable[[], None]] = deque()
        self._wanted: tuple[Ready, Mapping[str, float]] | None = None
        self._rate = self._measured = self._step_seconds = self._plotted = 0.0
        self._second, self._events = 0.0, 0
        self._due = self._frame_due = self._stepped = perf_counter()
        self._failed: tuple[int, int, str] | None = None
        self._failure: list[dict[str, Any]] = []
        self._stepping = threading.RLock()
        self._changed, self._ended = False, threading.Event()
        self._single_steps = 0
        self._description: dict[str, Any] = {}
        self._build(source, {})
        self._thread = threading.Thread(target=self._run, name="pymunk-dragon live", daemon=True)

    def tell(self, message: dict[str, Any]) -> None:
        """Send a text to all clients."""
        for each in self.audience:
            each.tell(message)

    # ---- from other threads

    def start(self) -> None:
        """Begin to step, unless a program makes the steps."""
        if self.scene.play.step is not None:
            self._thread.start()

    def step(self, length: float) -> None:
        """Make a step of a program that makes the steps itself, when it is due: messages and frames go on meanwhile."""
        if self.scene.play.step is not None:
            raise ParameterError("step", self.scene.play.step, "None for a program that makes the steps itself")
        self.scene.step_length = finite("dt", length, 0, _MAX_LENGTH, "s")
        if not self.scene.steps:
            # Now the program has opened its window and filled its space.
            self.scene.fit()
            self._describe()
            self.tell(self._description)
        while not self._ended.is_set():
            with self._unheld():
                self._take_messages()
            now = perf_counter()
            if not self.running:
                self._due = now
            self._due = max(self._due, now - _LARGEST_DEBT)
            if self._single_steps or (self.running and now >= self._due):
                break
            self._refresh(now)
            sleep(_TICK)
        begin = self.scene.time
        self._single_steps = max(self._single_steps - 1, 0)
        self._step()
        self._due += length / self.speed
        now = perf_counter()
        self._measure(self.scene.time - begin, now - self._stepped)
        self._stepped = now
        self._refresh(now)

    def stop(self) -> None:
        """End the thread; one that is held by a function of the user's ends after it."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(_LONGEST_STOP)

    def post(
        self, message: dict[str, Any], answer: Callable[[str], None] = lambda error: None, *, always: bool = False
    ) -> None:
        """Have a message take effect before the next step; `answer` is called with the reason if it cannot.

        `always` is for a message that has to be taken even if too many wait.
        """
        if len(self._waiting) >= _MAX_WAITING and not always:
            answer("too many messages at once")
        else:
            self._waiting.append((message, answer))

    @contextmanager
    def held(self) -> Iterator[None]:
        """Context in which no step is made."""
        with self._stepping:
            yield

    def call(self, action: Callable[[], None]) -> None:
        """Have something done in the session's thread, between two steps."""
        self._calls.append(action)

    def greeting(self) -> list[dict[str, Any]]:
        """Return the messages for a client that connects: the scene, and the error by which it is paused."""
        return [self._description, *self._failure]

    def state(self) -> dict[str, Any]:
        """Return what changes now and then."""
        state: dict[str, Any] = without_nan(
            {
                "kind": "state",
                "generation": self.generation,
                "running": self.running,
                "speed": self.speed,
                "replaying": not self._replay.ended.is_set(),
                "clients": self.clients,
                **self.scene.state(),
            }
        )
        return state

    def wait(self) -> None:
        """Wait until the session is stopped from another thread."""
        while not self._ended.wait(PATIENCE):
            pass

    def wait_for_replay(self) -> list[list[float]] | None:
        """Wait for the end of a replay, and return its last poses, or None if it was cancelled."""
        while not self._replay.ended.wait(PATIENCE):
            pass
        if self._replay.error is not None:
            raise DragonError(self._replay.error)
        return self._replay.poses

    def play_again(self, inputs: Sequence[tuple[int, dict[str, Any]]], values: Mapping[str, float], steps: int) -> None:
        """Build the scene with these values, and carry out inputs before the steps of these numbers, up to `steps`.

        Only before `start`.
        """
        self._build(self.source, values)
        self._replay = _Replay(inputs, steps)
        self._go_on_with_replay()

    def touch(self) -> None:
        """Send the state again after the next step."""
        self._changed = True

    def poses(self) -> list[list[float]]:
        """Return the poses of the bodies."""
        poses: list[list[float]] = self.scene.poses().tolist()
        return poses

    # ---- the thread

    def _run(self) -> None:
        with suppress(_StoppedError):
            self._play()

    @contextmanager
    def _unheld(self) -> Iterator[None]:
        """Context in which a program does not change the space, even if it stops the session meanwhile."""
        while not self._stepping.acquire(timeout=PATIENCE):
            if self._ended.is_set():
                raise _StoppedError
        try:
            yield
        finally:
            self._stepping.release()

    def _play(self) -> None:
        """Step in time with the clock, and make frames."""
        debt, last = 0.0, perf_counter()
        while not self._ended.is_set():
            generation = self.generation
            with self._unheld():
                self._take_messages()
            # The time in which a scene is built is not played.
            now = perf_counter()
            passed, last = (0.0 if generation != self.generation else now - last), now
            # A step may be longer than the largest debt.
            most = max(_LARGEST_DEBT * self.speed, self.scene.step_length)
            debt = min(debt + passed * self.speed, most) if self.running else 0.0
            before = self.scene.time
            debt, stepped = self._turn(debt)
            self._measure(self.scene.time - before, passed)
            self._refresh(perf_counter())
            if not stepped:
                sleep(_TICK)

    def _refresh(self, now: float) -> None:
        """Send the state if it changed, and a frame if one is due."""
        if self._changed:
            self._changed = False
            self.tell(self.state())
        if self.clients and now >= self._frame_due:
            # At even intervals, but none is made up for.
            self._frame_due = max(self._frame_due, now - 1 / _FRAME_RATE) + 1 / _FRAME_RATE
            self._show(now)

    def _turn(self, debt: float) -> tuple[float, bool]:
        """Make the steps that are due, for a while, and return the debt that is left, and whether one was made."""
        begin, stepped = perf_counter(), False
        while self._single_steps or (self.running and debt >= self.scene.step_length):
            debt -= self.scene.step_length
            self._single_steps = max(self._single_steps - 1, 0)
            stepped = True
            with self._unheld():
                self._step()
            if perf_counter() - begin > _LONGEST_TURN or self._waiting:
                break
        return debt, stepped

    def _measure(self, simulated: float, passed: float) -> None:
        """Average the rate over the last second, or since time goes on."""
        if not self.running:
            self._measured = 0.0
        elif passed > 0:
            self._measured = min(self._measured + passed, _RATE_TIME)
            self._rate += passed / max(self._measured, passed) * (simulated / passed - self._rate)

    def _show(self, now: float) -> None:
        rate = self._rate if self._measured >= _RATE_TIME / 2 else None
        header: dict[str, Any] = {"generation": self.generation, "rate": rate, "step_time": self._step_seconds}
        with self._watched():
            if now >= self._plotted + _PLOT_TIME and self.running:
                self._plotted = now
                header["plots"] = list(self.scene.plots().values())
            frame = self.scene.frame(header)
            for each in self.audience:
                each.show(frame)

    @contextmanager
    def _watched(self) -> Iterator[None]:
        """Context in which an exception of the user's functions pauses the session, and is shown."""
        try:
            with _callbacks():
                yield
        except Exception as error:
            if self._replay.ended.is_set():
                self._pause()
                self._tell_error(error)
            else:
                self._fail_replay(f"the replay ends at step {self.scene.steps}: {error}")

    def _step(self) -> None:
        """Make one step."""
        scene, begin = self.scene, perf_counter()
        with self._watched():
            scene.advance()
            self._step_seconds += _SMOOTHING * (perf_counter() - begin - self._step_seconds)
            self._keep_frame()
            self._tell_events()
            if scene.stops:
                scene.stops = False
                # The recorded session went on after that.
                if self._replay.ended.is_set():
                    self._pause()
            self._go_on_with_replay()

    def _tell_events(self) -> None:
        """Tell what happened, but not more than clients can show; the rest is counted."""
        now = perf_counter()
        if now - self._second >= 1:
            if self._events > _MAX_EVENTS:
                i = self._events - _MAX_EVENTS
                self.tell({"kind": "event", "time": self.scene.time, "text": f"{i} further events in a second"})
            self._second, self._events = now, 0
        for text in self.scene.events:
            self._events += 1
            if self._events <= _MAX_EVENTS:
                self.tell({"kind": "event", "time": self.scene.time, "text": text})
        self.scene.events.clear()

    def _go_on_with_replay(self) -> None:
        """Carry out the inputs of a replay that belong before the next step; after its last step it ends."""
        replay = self._replay
        if replay.ended.is_set():
            return
        while replay.inputs and replay.inputs[0][0] <= self.scene.steps:
            step, message = replay.inputs.popleft()
            try:
                self._apply(message)
            except DragonError as error:
                self._fail_replay(f"the replay ends before step {step}, which has an input that is impossible: {error}")
                return
        if self.scene.steps >= replay.steps:
            self._pause()
            replay.end(poses=self.poses())

    def _fail_replay(self, reason: str) -> None:
        self._pause()
        self.tell({"kind": "error", "text": reason})
        self._replay.end(error=reason)

    def _tell_error(self, error: Exception) -> None:
        """Tell of an exception, but not again in each frame of a session that is paused by it."""
        now = self.generation, self.scene.steps, str(error)
        if now != self._failed:
            self._failed, self._failure = now, [_described(error)]
            self.tell(self._failure[0])

    def _pause(self) -> None:
        self.running, self._single_steps = False, 0
        self._changed = True

    def _take_messages(self) -> None:
        while self._calls:
            self._calls.popleft()()
        while self._waiting:
            message, answer = self._waiting.popleft()
            try:
                self._do(message)
            except DragonError as error:
                answer(str(error))
            except Exception as error:  # Of the user's own functions.
                self._pause()
                self._tell_error(error)
        with self._watched():
            self._build_wanted()

    def _do(self, message: dict[str, Any]) -> None:
        """Carry out a message."""
        action = message["do"]
        if self._rebuilds(message):
            self._changed = True
            return
        # Several wishes for a new scene are carried out as one.
        self._build_wanted()
        if action in INPUTS:
            self._input(message)
        elif action == "play":
            self.running, self._failure = True, []
        elif action == "pause":
            self._pause()
        elif action == "step":
            count = whole("count", message["count"], 1, MAX_COUNT)
            self._pause()
            self._single_steps = count
        elif action == "speed":
            self.speed = finite("speed", message["value"], *SPEEDS, "times")
        elif action == "until_contact":
            self.scene.until_contact()
            self.running = True
        # The place of the hand is in each frame.
        self._changed |= action != "drag"

    def _rebuilds(self, message: dict[str, Any]) -> bool:
        """Note the wish for a new scene, and return whether a message is one."""
        source, values = self._wanted or (self.source, self.values)
        if self.scene.play.step is None and message["do"] in ("scene", "reset"):
            raise ParameterError("message", message["do"], "another one: this program builds its space itself")
        if message["do"] == "scene":
            name = message["name"]
            self._wanted = (self._own if name == self._own.name else ready(name)), {}
            self.running = True
        elif message["do"] == "reset":
            self._wanted = source, values
        elif message["do"] == "set" and self._replay.ended.is_set():
            if source is not self.source:
                self._build_wanted()
                source, values = self.source, self.values
            slider = self._slider(message["name"])
            if not slider.rebuilds:
                return False
            values = self.scene.values if self._wanted is None else values
            self._wanted = source, {**values, slider.name: slider.checked(message["value"])}
        else:
            return False
        return True

    def _input(self, message: dict[str, Any]) -> None:
        if not self._replay.ended.is_set():
            raise ParameterError("message", message["do"], "sent after the replay has ended")
        if len(self.inputs) >= MAX_INPUTS:
            raise ParameterError("message", message["do"], f"one of at most {MAX_INPUTS} inputs: reset")
        self._apply(message)

    def _apply(self, message: dict[str, Any]) -> None:
        """Change the scene, and note the input."""
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
        self.inputs.append(self.scene.steps, message)

    def _slider(self, name: str) -> Slider:
        known = self.scene.parameters
        return known[word("name", name, list(known))]

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
        self.inputs = InputLog()
        self._replay.end()
        self._single_steps, self._rate, self._measured, self._failure = 0, 0.0, 0.0, []
        self._describe()
        if self.frames is not None:
            self.frames.begin(scene)
        self._keep_frame()
        self._changed = True

    def _describe(self) -> None:
        source = self.source
        self._description = without_nan(
            {
                "kind": "scene",
                "generation": self.generation,
                "name": source.name,
                "title": source.title,
                "text": source.text,
                "lesson": source.lesson,
                "scenes": [{"name": name, "title": each.title} for name, each in self._choices().items()],
                **self.scene.to_dict(),
            }
        )

    def _choices(self) -> dict[str, Ready]:
        return {self._own.name: self._own} | SCENES

    def _keep_frame(self) -> None:
        try:
            if self.frames is not None:
                self.frames.keep(self.scene)
        except OSError as error:
            self.frames = None
            self.tell({"kind": "error", "text": f"frames are no longer kept: {error.strerror}"})


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
