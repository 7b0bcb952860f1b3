"""What happened in a session: inputs, from which it is played again, also as the run of a dragon."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pymunk
from PIL import Image

from pymunk_dragon._arguments import finite, whole
from pymunk_dragon._files import check_destination, read_text, written_in_place
from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.model.run import Run, position_errors
from pymunk_dragon.model.settings import engine_provenance
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.messages import INPUTS, MAX_INPUTS, checked
from pymunk_dragon.sessions.ready import planned
from pymunk_dragon.sessions.session import Session

RECORDING_ENDINGS = (".json", ".npz")
# Bytes of a recording with as many inputs as are kept.
_MAX_SIZE = 200 * MAX_INPUTS
# Steps of a recording, at most.
_MAX_STEPS = 100_000_000
# Frames a second of a run, and pixels of a picture.
_RUN_FPS, _SIZE = 30, (640, 480)


@dataclass(frozen=True, kw_only=True)
class Log:
    """What was done to a scene since it was built."""

    plan: Mapping[str, Any] | None
    values: Mapping[str, float]
    steps: int
    inputs: list[tuple[int, dict[str, Any]]]
    poses: list[list[float]]

    @classmethod
    def of(cls, session: Session) -> Log:
        """Return the log of a session that does not step at the moment."""
        inputs = [(step, message) for step, message in map(json.loads, session.inputs)]
        scene, plan, values = session.scene, session.source.plan, dict(session.values)
        return cls(plan=plan, values=values, steps=scene.steps, inputs=inputs, poses=scene.poses().tolist())

    @classmethod
    def load(cls, path: str | Path) -> Log:
        """Read the log in a file .json, as `record` and the page write it."""
        text = read_text(path, "replay", _MAX_SIZE)
        try:
            return cls._of(json.loads(text))
        except Exception as error:  # Whatever it is, the content is to blame.
            raise FileFormatError(path, "no recording of a live session, or a damaged one") from error

    @classmethod
    def _of(cls, notes: Mapping[str, Any]) -> Log:
        inputs = [(whole("step", step, 0, _MAX_STEPS), checked(message)) for step, message in notes["inputs"]]
        if any(message["do"] not in INPUTS for _, message in inputs):
            raise DragonError("it has inputs that change nothing")
        if notes["plan"] is not None:
            planned(notes["plan"])
        return cls(
            plan=notes["plan"],
            values={str(name): finite(name, value, -math.inf, math.inf, "") for name, value in notes["values"].items()},
            steps=whole("steps", notes["steps"], 0, _MAX_STEPS),
            inputs=inputs,
            poses=np.asarray(notes["poses"], dtype=float).reshape(-1, 3).tolist(),
        )

    def difference(self, poses: list[list[float]]) -> float:
        """Largest difference of coordinates, m, and angles, rad, of a replay's last poses from the recording's."""
        if len(poses) != len(self.poses):
            raise DragonError("the recording ends with another number of bodies than its replay")
        return float(np.abs(np.subtract(poses, self.poses)).max(initial=0.0))

    def to_json(self) -> str:
        """Return the log as JSON, which `load` reads."""
        return json.dumps(vars(self))


def record(session: Session, path: str | Path) -> None:
    """Write what happened in a session since its scene was built: inputs as .json, or a dragon's run as .npz.

    A run is that of a replay of the inputs. The session must not step meanwhile.
    """
    destination, log = check_destination(path, RECORDING_ENDINGS), Log.of(session)
    if destination.suffix == ".json":
        with written_in_place(destination) as draft:
            draft.write_text(log.to_json())
    else:
        again = Session(session.source)
        again.play_again(log)
        _run(again, log, session.scene.time - again.scene.time).save(destination)


def still(session: Session) -> bytes:
    """Return a picture of the present state, by Pymunk's debug drawing, as the bytes of a PNG."""
    scene, picture, file = session.scene, Image.new("RGB", _SIZE, "white"), io.BytesIO()
    options = PillowDrawOptions(picture, positive_y_is_up=not scene.play.y_down)
    options.flags = scene.drawn
    (x, y), (width, height) = scene.field["centre"], scene.field["size"]
    options.fit(pymunk.BB(x - width / 2, y - height / 2, x + width / 2, y + height / 2))
    with session.held:
        scene.space.debug_draw(options)
    picture.save(file, "png")
    return file.getvalue()


def _run(session: Session, log: Log, seconds: float) -> Run:
    """Return a replay of a dragon as a run, with errors against the exact model at the times of the march."""
    scene = session.scene
    if not isinstance(scene, DragonScene):
        raise ParameterError("record", ".npz", ".json: only a dragon's session is a run")
    frames = {}
    for due in scene.time + np.arange(math.ceil(seconds * _RUN_FPS) + 1) / _RUN_FPS:
        session.replay_until(due)
        frames[scene.time] = scene.march_time, scene.poses()
    times, (march_times, poses) = np.array(list(frames)), map(np.array, zip(*frames.values(), strict=True))
    errors = position_errors(scene.march.dragon, poses, scene.march.at(march_times).positions)
    span = {"start": float(times[0]), "until": float(times[-1])}
    notes = engine_provenance(scene.world.settings, guide="rails", substeps=log.steps, **span)
    return Run(march=scene.march, times=times, poses=poses, drift=errors, provenance=notes)
