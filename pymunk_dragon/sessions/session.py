"""A session: a scene that is stepped in real time in a thread of its own, what was done to it, and who watches."""

from __future__ import annotations

import io
import tempfile
import threading
import weakref
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from time import perf_counter, sleep
from typing import Any

import numpy as np

from pymunk_dragon._checks import finite, whole, word
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.sessions.log import MAX_INPUTS, Frames, InputLog, Recorded, as_text
from pymunk_dragon.sessions.messages import INPUTS
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
# Simulated s between recorded frames.
RECORDED = 1 / 30
# s between two moments at which a waiting thread takes notice of Ctrl-C.
PATIENCE = 0.2
# Steps between two checks whether the bodies flew apart.
CHECKED = 10
# Bytes of frames after which a recording that a client began ends: ten minutes of 223 benches.
MAX_RECORDED = 100_000_000


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
    frames : Frames or None
        Frames since the scene was built, if they are kept.
    recorded : Recorded or None
        What a client recorded last.
    """

    def __init__(self, source: Ready, *, record: bool = False, running: bool = True) -> None:
        self.source = self._own = source
        self.tell: Callable[[dict[str, Any]], None] = lambda message: None
        self.show: Callable[[bytes], None] = lambda frame: None
        self.clients = 0
        self.running, self.speed = running, 1.0
        self.generation = 0
        self.frames = self._frames_in_a_file() if record else None
        self.recorded: Recorded | None = None
        self._recording: Frames | None = None
        self.replay: deque[tuple[int, dict[str, Any]]] = deque()
        self.replayed_steps: int | None = None
        self._waiting: deque[tuple[dict[str, Any], Callable[[str], None]]] = deque()
        self._calls: deque[Callable[[], None]] = deque()
        self._replayed = threading.Event()
        self._replay_poses: str | None = None
        self._replay_error: str | None = None
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
        return {
            "kind": "state",
            "generation": self.generation,
            "running": self.running,
            "speed": self.speed,
            "recording": self._recording is not None,
            "recorded": None if self.recorded is None else float(np.ptp(self.recorded.times)),
            "replaying": self.replayed_steps is not None,
            "clients": self.clients,
            **self.scene.state(),
        }

    def wait(self) -> None:
        """Wait until the session is stopped from another thread."""
        while not self._ended.wait(PATIENCE):
            pass

    def wait_for_replay(self) -> str | None:
        """Wait for the end of a replay: its last poses, or None if it was ended before.

        Raises
        ------
        DragonError
            If an input of the recording cannot be carried out.
        """
        while not self._replayed.wait(PATIENCE):
            pass
        if self._replay_error is not None:
            raise DragonError(self._replay_error)
        return self._replay_poses

    def play_again(self, inputs: Sequence[tuple[int, dict[str, Any]]], values: Mapping[str, float], steps: int) -> None:
        """Build the scene with these values, and carry out inputs before the steps of these numbers, up to `steps`.

        Only before `start` and after `stop`.
        """
        self._rebuild(values)
        self.replay.extend(inputs)
        self.replayed_steps = steps
        self._replayed.clear()
        self._replay()

    def step_to(self, time: float) -> None:
        """Make the steps of a replay up to this time, s, while the thread does not run."""
        while self.replayed_steps is not None and self.scene.time < time - self.scene.step_length / 2:
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
            self._pause()
            if self.replayed_steps is None:
                self.tell({"kind": "error", "text": str(error)})
            else:
                self._fail_replay(f"the replay ends at step {scene.steps}: {error}")
            return
        self._step_seconds += SMOOTHING * (perf_counter() - begin - self._step_seconds)
        if scene.steps % self._steps_of_frame == 0:
            self._keep_frame()
        for text in scene.events:
            self.tell({"kind": "event", "time": scene.time, "text": text})
        scene.events.clear()
        if scene.stops:
            scene.stops = False
            # The recorded session went on after that.
            if self.replayed_steps is None:
                self._pause()
        self._replay()

    def _replay(self) -> None:
        """Carry out the inputs of a replay that belong before the next step; after its last step it ends."""
        if self.replayed_steps is None:
            return
        while self.replay and self.replay[0][0] <= self.scene.steps:
            step, message = self.replay.popleft()
            try:
                self._apply(message)
            except DragonError as error:
                self._fail_replay(f"the replay ends before step {step}, which has an input that is impossible: {error}")
                return
        if self.scene.steps >= self.replayed_steps:
            self._replay_poses = self.poses()
            self._end_replay()

    def _fail_replay(self, reason: str) -> None:
        self._replay_error = reason
        self.tell({"kind": "error", "text": reason})
        self._end_replay()

    def _end_replay(self) -> None:
        self.replay.clear()
        self.replayed_steps = None
        self._replayed.set()
        self._pause()

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
            self._recording = Frames(io.BytesIO(), MAX_RECORDED)
            self._recording.append(self.scene)
        elif action == "finish":
            self._finish()
        self._changed = True

    def _input(self, message: dict[str, Any]) -> None:
        if self.replayed_steps is not None:
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
        self.replay.clear()
        self.replayed_steps = None
        self._replayed.set()
        self._steps_of_frame = max(1, round(RECORDED / scene.step_length))
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
        for frames in self._kept():
            frames.clear()
        self._keep_frame()
        self._changed = True
        self.tell(self._description)

    def _choices(self) -> list[dict[str, str]]:
        choices = {self._own.name: self._own} | SCENES
        return [{"name": name, "title": each.title} for name, each in choices.items()]

    def _frames_in_a_file(self) -> Frames:
        """Frames in a file without a name, which is gone with the session."""
        file = tempfile.TemporaryFile()  # noqa: SIM115 (it is closed with the session)
        weakref.finalize(self, file.close)
        return Frames(file)

    def _kept(self) -> list[Frames]:
        """Where frames are kept at the moment."""
        return [frames for frames in (self.frames, self._recording) if frames is not None]

    def _keep_frame(self) -> None:
        try:
            for frames in self._kept():
                frames.append(self.scene)
        except OSError as error:
            self.frames = None
            self.tell({"kind": "error", "text": f"frames are no longer kept: {error.strerror}"})
        if self._recording is not None and self._recording.is_full:
            self._finish()
            self.tell({"kind": "error", "text": "the recording is full, and has ended"})

    def _finish(self) -> None:
        """End the recording that a client began."""
        if self._recording is None:
            raise ParameterError("message", "finish", "sent while a recording goes on")
        self.recorded, self._recording = Recorded.of(self, self._recording), None
        self._changed = True
