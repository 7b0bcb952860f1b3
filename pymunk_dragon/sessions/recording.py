"""What happened in a session: inputs, from which it is played again, also as the run of a dragon."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pymunk_dragon._arguments import finite, whole
from pymunk_dragon._files import check_destination, read_text, written_in_place
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.model.run import Run, position_errors
from pymunk_dragon.model.settings import engine_provenance
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.ready import planned
from pymunk_dragon.sessions.session import INPUTS, MAX_INPUTS, Session, checked

RECORDING_ENDINGS = (".json", ".npz")
# Bytes of a recording with as many inputs as are kept; steps, at most; and frames a second of a run.
_MAX_SIZE, _MAX_STEPS, _RUN_FPS = 200 * MAX_INPUTS, 100_000_000, 30


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
            log = cls(**json.loads(text))
            if log.plan is not None:
                planned(log.plan)
            for step, message in [*log.inputs, (log.steps, {"do": "drop"})]:
                whole("step", step, 0, _MAX_STEPS)
                checked(message, INPUTS)
            for name, value in log.values.items():
                finite(name, value, -math.inf, math.inf, "")
            return replace(log, poses=np.asarray(log.poses, dtype=float).reshape(-1, 3).tolist())
        except Exception as error:  # Whatever it is, the content is to blame.
            raise FileFormatError(path, "no recording of a live session, or a damaged one") from error

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
    destination = check_destination(path, RECORDING_ENDINGS)
    if destination.suffix == ".npz":
        _run(session).save(destination)
        return
    with written_in_place(destination) as draft:
        draft.write_text(Log.of(session).to_json())


def _run(session: Session) -> Run:
    """Return a dragon's session as a run, with errors against the exact model at the times of the march."""
    if not isinstance(session.scene, DragonScene):
        raise ParameterError("record", ".npz", ".json: only a dragon's session is a run")
    log, again, frames = Log.of(session), Session(session.source), {}
    again.play_again(log)
    scene: Any = again.scene
    seconds = session.scene.time - scene.time
    for due in scene.time + np.arange(math.ceil(seconds * _RUN_FPS) + 1) / _RUN_FPS:
        again.replay_until(due)
        frames[scene.time] = scene.march_time, scene.poses()
    times, (march_times, poses) = np.array(list(frames)), map(np.array, zip(*frames.values(), strict=True))
    errors = position_errors(scene.march.dragon, poses, scene.march.at(march_times).positions)
    span = {"start": float(times[0]), "until": float(times[-1])}
    notes = engine_provenance(scene.world.settings, guide="rails", substeps=log.steps, **span)
    return Run(march=scene.march, times=times, poses=poses, drift=errors, provenance=notes)
