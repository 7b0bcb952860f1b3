"""Recordings of what was done to a scene: made, read from a file and checked, and played again."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pymunk_dragon._checks import finite, whole
from pymunk_dragon._files import read_text
from pymunk_dragon.errors import DragonError, FileFormatError
from pymunk_dragon.sessions.messages import Input, Set, read_input
from pymunk_dragon.sessions.scene import Scene
from pymunk_dragon.sessions.scenes import recorded_scene

# A recording as JSON: the scene (`plan`), first values of sliders, `inputs` with the number of
# steps before each, and the number of steps and the poses at the end.
Log = dict[str, Any]

# Inputs of a recording: two hours of a mouse that never rests.
MAX_INPUTS = 500_000
# Bytes of a file with so many inputs.
_MAX_SIZE = 100_000_000
# Steps of a recording: a week of steps of 6 ms.
_MAX_STEPS = 100_000_000


class Recording:
    """Inputs of a scene since it was built with `values` of sliders."""

    def __init__(self, saved_as: Mapping[str, Any] | None, values: Mapping[str, float]) -> None:
        self._saved_as = saved_as
        self._first = dict(values)
        # Inputs as JSON texts, which take less memory.
        self._inputs: list[str] = []
        # Values that sliders have now, of those that were set.
        self.values = dict(values)

    @property
    def is_full(self) -> bool:
        """Whether no further input can be recorded."""
        return len(self._inputs) >= MAX_INPUTS

    def apply(self, scene: Scene, message: Input) -> None:
        """Change the scene, and record the input if that succeeds."""
        message.apply(scene)
        if isinstance(message, Set):
            self.values[message.name] = scene.values[message.name]
        self._inputs.append(json.dumps([scene.steps, message.to_dict()]))

    def log(self, scene: Scene) -> Log:
        """The recording, which ends at the present state of the scene."""
        return {
            "plan": self._saved_as,
            "values": self._first,
            "steps": scene.steps,
            "inputs": [json.loads(each) for each in self._inputs],
            "poses": scene.poses().tolist(),
        }


def play_again(log: Log, scene: Scene, recording: Recording) -> Iterator[float | None]:
    """Make the inputs and the steps of a log again; yields after each step.

    In the end the largest difference of the poses from those of the log is yielded, m or rad.
    """
    for steps, message in log["inputs"]:
        while scene.steps < steps:
            scene.advance()
            yield None
        recording.apply(scene, read_input(message))
    while scene.steps < log["steps"]:
        scene.advance()
        yield None

    poses = scene.poses().tolist()
    if len(poses) != len(log["poses"]):
        raise DragonError("the recording has another number of bodies")
    yield float(np.abs(np.subtract(poses, log["poses"])).max(initial=0.0))


def load_log(path: str | Path) -> Log:
    """Read a log from a file that the program or the page wrote."""
    text = read_text(path, "replay", _MAX_SIZE)
    try:
        log: Log = json.loads(text)
        _check(log)
    except Exception as error:  # Whatever it is, the content is to blame.
        message = "no recording of a built-in scene or of a march, or a damaged one"
        raise FileFormatError(path, message) from error
    return log


def _check(log: Log) -> None:
    """Raise an error if a log cannot be played again."""
    recorded_scene(log["plan"])
    whole("steps", log["steps"], 0, _MAX_STEPS)

    for step, message in log["inputs"]:
        whole("step", step, 0, _MAX_STEPS)
        read_input(message)

    for name, value in log["values"].items():
        finite(name, value)

    poses = np.array(log["poses"], dtype=float).reshape(len(log["poses"]), 3)
    if not np.isfinite(poses).all():
        raise ValueError("a pose is not finite")
