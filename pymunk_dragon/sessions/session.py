"""A session: a scene that is stepped in real time in a thread of its own, what was done to it, and who watches."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from time import perf_counter, sleep
from typing import Any

import numpy as np

from pymunk_dragon._checks import finite, whole, word
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.sessions.frames import Recorder
from pymunk_dragon.sessions.log import MAX_INPUTS, InputLog, as_text
from pymunk_dragon.sessions.messages import INPUTS
from pymunk_dragon.sessions.replay import PATIENCE, Replay
from pymunk_dragon.sessions.scenes import SCENES, Parameter, Ready, ready

# Simulated over real time.
SPEEDS = 0.1, 20.0
# Frames a second that are made, at most.
FRAME_RATE = 60.0
# s of real time: a computer that is slower than real time does not try to catch up with more than this.
LARGEST_DEBT = 0.1
# s of real time after which the thread takes messages, even if further steps are due.
LONGEST_TURN = 1 / FRAME_RATE
# s between two checks for messages while the thread waits.
TICK = 0.002
# Steps at once.
MAX_COUNT = 100_000
# s over which the rate is averaged.
RATE_TIME = 1.0
# Share of a new value in the mean time of a step that is shown.
SMOOTHING = 0.1
# Messages that wait for the thread; a client that floods loses the others.
MAX_WAITING = 1000
# Steps between two checks whether the bodies flew apart.
CHECKED = 10


class _StoppedError(Exception):
    """The session was stopped while a program held it."""


class Session:
    """A scene in motion.

    Parameters
    ----------
    source : Ready
        How the scene is made.
    record : bool
        Whether frames are kept from the beginning, in a temporary file.
    running : bool
        Whether time goes on from the beginning.

    Attributes
    ----------
    tell, show : callable
        Called from the session's thread with each message for all clients, a dict, and with each frame, bytes.
    clients : int
        Number of clients; without one, no frames are made.
    scene : Scene
        The scene. Only the session's thread changes it.
    running : bool
        Whether time goes on.
    speed : float
        Simulated over real time.
    inputs : InputLog
        What was done since the scene was built.
    recorder : Recorder
        Frames of the session, and the recording of a client.
    """

    def __init__(self, source: Ready, *, record: bool = False, running: bool = True) -> None:
        self.source = self._own = source
        self.tell: Callable[[dict[str, Any]], None] = lambda message: None
        self.show: Callable[[bytes], None] = lambda frame: None
        self.clients = 0
        self.running, self.speed = running, 1.0
        self.generation = 0
        self.recorder = Recorder(always=record)
        self._replay = Replay((), 0)
        self._waiting: deque[tuple[dict[str, Any], Callable[[str], None]]] = deque()
        self._calls: deque[Callable[[], None]] = deque()
        self._rate = self._step_seconds = 0.0
        self._stepping = threading.Lock()
        self._changed, self._ended = False, threading.Event()
        self._single_steps = 0
        self._rebuild({})
        self._thread = threading.Thread(target=self._run, name="pymunk-dragon live", daemon=True)

    # ---- from other threads

    def start(self) -> None:
        """Begin to step."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def post(
        self, message: dict[str, Any], answer: Callable[[str], None] = lambda error: None, *, always: bool = False
    ) -> None:
        """Have a message take effect before the next step; `answer` is called with the reason if it cannot.

        `always` is for a message that has to be taken even if too many wait.
        """
        if len(self._waiting) >= MAX_WAITING and not always:
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

    def description(self) -> dict[str, Any]:
        """What a client gets when it connects, and after each rebuild."""
        return self._description

    def state(self) -> dict[str, Any]:
        """What changes now and then."""
        recorded = self.recorder.recorded
        return {
            "kind": "state",
            "generation": self.generation,
            "running": self.running,
            "speed": self.speed,
            "recording": self.recorder.is_recording,
            "recorded": None if recorded is None else float(np.ptp(recorded.times)),
            "replaying": not self._replay.has_ended,
            "clients": self.clients,
            **self.scene.state(),
        }

    def wait(self) -> None:
        """Wait until the session is stopped from another thread."""
        while not self._ended.wait(PATIENCE):
            pass

    def wait_for_replay(self) -> str | None:
        """Wait for the end of a replay, and return its last poses, or None if it was cancelled.

        Raises
        ------
        DragonError
            If an input of the recording cannot be carried out.
        """
        return self._replay.wait()

    def play_again(self, inputs: Sequence[tuple[int, dict[str, Any]]], values: Mapping[str, float], steps: int) -> None:
        """Build the scene with these values, and carry out inputs before the steps of these numbers, up to `steps`.

        Only before `start` and after `stop`.
        """
        self._rebuild(values)
        self._replay = Replay(inputs, steps)
        self._go_on_with_replay()

    def step_to(self, time: float) -> None:
        """Make the steps of a replay up to this time, s, while the thread does not run."""
        while not self._replay.has_ended and self.scene.time < time - self.scene.step_length / 2:
            self._step()

    def touch(self) -> None:
        """Send the state again after the next step."""
        self._changed = True

    def poses(self) -> str:
        """The bodies' poses to the last bit, as text."""
        return as_text(self.scene.poses())

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
        debt, last, due = 0.0, perf_counter(), perf_counter()
        while not self._ended.is_set():
            with self._unheld():
                self._take_messages()
            now = perf_counter()
            passed, last = now - last, now
            # A step may be longer than the largest debt.
            most = max(LARGEST_DEBT * self.speed, self.scene.step_length)
            debt = min(debt + passed * self.speed, most) if self.running else 0.0
            begin, before = perf_counter(), self.scene.time
            stepped = False
            while self._single_steps or (self.running and debt >= self.scene.step_length):
                debt -= self.scene.step_length
                self._single_steps = max(self._single_steps - 1, 0)
                stepped = True
                with self._unheld():
                    self._step()
                if perf_counter() - begin > LONGEST_TURN or self._waiting:
                    break
            self._measure(self.scene.time - before, passed)
            if self._changed:
                self._changed = False
                self.tell(self.state())
            if self.clients and (now := perf_counter()) >= due:
                # At even intervals, but none is made up for.
                due = max(due, now - 1 / FRAME_RATE) + 1 / FRAME_RATE
                self._show()
            if not stepped:
                sleep(TICK)

    def _measure(self, simulated: float, passed: float) -> None:
        if passed > 0:
            self._rate += min(1.0, passed / RATE_TIME) * (simulated / passed - self._rate)

    def _show(self) -> None:
        with suppress(ValueError):
            self.show(self.scene.frame(self.generation, self._rate, self._step_seconds))

    def _step(self) -> None:
        """Make one step."""
        scene = self.scene
        begin = perf_counter()
        try:
            scene.advance()
            if scene.steps % CHECKED == 0 and not np.isfinite(scene.poses()).all():
                raise DragonError("the bodies flew apart: reset, and take shorter steps")
        except Exception as error:
            if self._replay.has_ended:
                self._pause()
                self._tell_error(str(error))
            else:
                self._fail_replay(f"the replay ends at step {scene.steps}: {error}")
            return
        self._step_seconds += SMOOTHING * (perf_counter() - begin - self._step_seconds)
        self._keep_frame()
        for text in scene.events:
            self.tell({"kind": "event", "time": scene.time, "text": text})
        scene.events.clear()
        if scene.stops:
            scene.stops = False
            # The recorded session went on after that.
            if self._replay.has_ended:
                self._pause()
        self._go_on_with_replay()

    def _go_on_with_replay(self) -> None:
        """Carry out the inputs of a replay that belong before the next step; after its last step it ends."""
        if self._replay.has_ended:
            return
        for step, message in self._replay.due(self.scene.steps):
            try:
                self._apply(message)
            except DragonError as error:
                self._fail_replay(f"the replay ends before step {step}, which has an input that is impossible: {error}")
                return
        if self.scene.steps >= self._replay.steps:
            self._pause()
            self._replay.end(poses=self.poses())

    def _fail_replay(self, reason: str) -> None:
        self._pause()
        self._tell_error(reason)
        self._replay.end(error=reason)

    def _tell_error(self, text: str) -> None:
        self.tell({"kind": "error", "text": text})

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
            except Exception as error:  # Such as of a scene of the user's own.
                answer(f"{type(error).__name__}: {error}")

    def _do(self, message: dict[str, Any]) -> None:
        """Carry out a message."""
        action = message["do"]
        if action in INPUTS:
            self._input(message)
        elif action == "play":
            self.running = True
        elif action == "pause":
            self._pause()
        elif action == "step":
            self._pause()
            self._single_steps = whole("count", message["count"], 1, MAX_COUNT)
        elif action == "speed":
            self.speed = finite("speed", message["value"], *SPEEDS, "times")
        elif action == "reset":
            self._rebuild(self.values)
        elif action == "scene":
            self._choose(message["name"])
            self.running = True
        elif action == "record":
            self.recorder.begin(self.scene)
        elif action == "finish":
            if not self.recorder.is_recording:
                raise ParameterError("message", action, "sent while a recording goes on")
            self.recorder.finish(self)
        self._changed = True

    def _input(self, message: dict[str, Any]) -> None:
        if not self._replay.has_ended:
            raise ParameterError("message", message["do"], "sent after the replay has ended")
        if message["do"] == "set":
            parameter = self._parameter(message["name"])
            if parameter.rebuilds:
                self._rebuild(self.scene.values | {parameter.name: parameter.checked(message["value"])})
                return
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
            parameter = self._parameter(message["name"])
            if parameter.rebuilds:
                raise ParameterError("name", parameter.name, "a parameter with which the scene does not begin anew")
            arguments["value"] = parameter.checked(message["value"])
        action(**arguments)
        self.inputs.append(self.scene.steps, message)

    def _parameter(self, name: str) -> Parameter:
        known = {each.name: each for each in self.scene.parameters}
        return known[word("name", name, list(known))]

    def _choose(self, name: str) -> None:
        """Show another scene: a ready one, or the session's own."""
        before = self.source
        self.source = self._own if name == self._own.name else ready(name)
        try:
            self._rebuild({})
        except DragonError:
            self.source = before
            raise

    def _rebuild(self, values: Mapping[str, float]) -> None:
        """Begin anew; the old scene stays if the new one cannot be built."""
        scene = self.source.build(values)
        self.scene, self.values = scene, dict(values)
        self.generation += 1
        self.inputs = InputLog()
        self._replay.end()
        self._single_steps = 0
        self._description = {
            "kind": "scene",
            "generation": self.generation,
            "name": self.source.name,
            "title": self.source.title,
            "text": self.source.text,
            "lesson": self.source.lesson,
            "scenes": self._choices(),
            **scene.to_dict(),
        }
        self.recorder.rebuilt(scene)
        self._keep_frame()
        self._changed = True
        self.tell(self._description)

    def _choices(self) -> list[dict[str, str]]:
        choices = {self._own.name: self._own} | SCENES
        return [{"name": name, "title": each.title} for name, each in choices.items()]

    def _keep_frame(self) -> None:
        for text in self.recorder.keep(self):
            self._tell_error(text)
            self._changed = True
