"""What was done in a session, from which it is played again."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._checks import finite, whole
from pymunk_dragon._files import read_text
from pymunk_dragon.errors import DragonError, FileFormatError
from pymunk_dragon.model.run import opened_archive
from pymunk_dragon.sessions.messages import INPUTS, checked
from pymunk_dragon.sessions.ready import planned

if TYPE_CHECKING:
    from pymunk_dragon.sessions.session import Session

# Inputs that are kept: some hours of a mouse that never rests.
MAX_INPUTS = 1_000_000
# Bytes of as many inputs as JSON.
MAX_SIZE = 100 * MAX_INPUTS
# Steps of a recording, at most.
MAX_STEPS = 100_000_000


class InputLog:
    """Inputs, packed: a movement of a hand takes some ten bytes."""

    def __init__(self) -> None:
        self._packer = zlib.compressobj()
        self._packed = bytearray()
        self._last: tuple[int, dict[str, Any]] | None = None
        self._count = 0

    def append(self, step: int, message: dict[str, Any]) -> None:
        """Add a message that acted before this step."""
        last = self._last
        # The hand is where it was put last when the step begins.
        moves_on = last is not None and last[0] == step and last[1]["do"] == message["do"] == "drag"
        if last is not None and not moves_on:
            self._packed += self._packer.compress(_line(*last))
        self._last = step, message
        self._count += not moves_on

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[tuple[int, dict[str, Any]]]:
        if self._last is None:
            return
        text = zlib.decompressobj().decompress(bytes(self._packed) + self._packer.copy().flush()) + _line(*self._last)
        for line in text.splitlines():
            step, message = json.loads(line)
            yield step, message


def _line(step: int, message: dict[str, Any]) -> bytes:
    return json.dumps([step, message]).encode() + b"\n"


@dataclass(frozen=True, kw_only=True)
class Log:
    """What was done to a scene since it was built."""

    plan: Mapping[str, Any] | None
    values: Mapping[str, float]
    steps: int
    inputs: list[tuple[int, dict[str, Any]]]
    # Of the bodies after the last step. JSON of Python has numbers to the last bit, and NaN.
    poses: list[list[float]]

    @classmethod
    def of(cls, session: Session) -> Log:
        """The log of a session that does not step at the moment."""
        return cls(
            plan=session.source.plan,
            values=dict(session.values),
            steps=session.scene.steps,
            inputs=list(session.inputs),
            poses=session.poses(),
        )

    @classmethod
    def load(cls, path: str | Path) -> Log:
        """Read the log in a run that `record` wrote as .npz, or in .json, which the page saves too."""
        if str(path).endswith(".json"):
            text = read_text(path, "replay", MAX_SIZE)
        else:
            with opened_archive(path, "replay") as (notes, _):
                text = json.dumps(notes["provenance"].get("live"))
        try:
            return cls._of(json.loads(text))
        except Exception as error:  # Whatever it is, the content is to blame.
            raise FileFormatError(path, "no recording of a live session, or a damaged one") from error

    @classmethod
    def _of(cls, notes: Mapping[str, Any]) -> Log:
        inputs = [(whole("step", step, 0, MAX_STEPS), checked(message)) for step, message in notes["inputs"]]
        if len(inputs) > MAX_INPUTS or any(message["do"] not in INPUTS for _, message in inputs):
            raise DragonError("it has inputs that change nothing")
        if notes["plan"] is not None:
            planned(notes["plan"])
        return cls(
            plan=notes["plan"],
            values={str(name): finite(name, value, -math.inf, math.inf, "") for name, value in notes["values"].items()},
            steps=whole("steps", notes["steps"], 0, MAX_STEPS),
            inputs=inputs,
            poses=np.asarray(notes["poses"], dtype=float).reshape(-1, 3).tolist(),
        )

    def difference(self, poses: list[list[float]]) -> float:
        """Largest difference of coordinates, m, and angles, rad, of a replay's last poses from the recording's."""
        if len(poses) != len(self.poses):
            raise DragonError("the recording ends with another number of bodies than its replay")
        return float(np.abs(np.subtract(poses, self.poses)).max(initial=0.0))

    def to_json(self) -> str:
        """The log as JSON, which `load` reads."""
        return json.dumps(asdict(self))
