"""What happened in a session: inputs, from which it is played again, the run of a dragon, and films."""

from __future__ import annotations

import io
import json
import math
import tempfile
import weakref
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pymunk
from PIL import Image

from pymunk_dragon._checks import finite, whole
from pymunk_dragon._files import check_destination, read_text, written_in_place
from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.drawing.film import formats, render
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.model.run import Run, opened_archive
from pymunk_dragon.model.settings import engine_provenance
from pymunk_dragon.player.data import position_errors
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.messages import INPUTS, checked
from pymunk_dragon.sessions.ready import planned
from pymunk_dragon.sessions.scene import Scene

if TYPE_CHECKING:
    from pymunk_dragon.sessions.session import Session

RECORDING_ENDINGS = (".json", ".npz", *formats.WRITERS)
# Inputs that are kept: two hours of a mouse that never rests. Bytes of as many as JSON.
MAX_INPUTS = 500_000
_MAX_SIZE = 200 * MAX_INPUTS
# Steps of a recording, at most.
_MAX_STEPS = 100_000_000
# Simulated s between frames.
_INTERVAL = 1 / 30
# Frames a second of a film, and pixels of one by Pymunk's debug drawing.
_FPS, _SIZE = 20, (640, 480)
# Inputs whose effects a run does not show.
_NOT_IN_RUNS = {"cut", "obstacle"}
# Colours of such a film: one index means transparent. Pictures from which they are chosen.
_COLOURS, _SAMPLES = 255, 8


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
        """Read the log in a run that `record` wrote as .npz, or in .json, which the page saves too."""
        if str(path).endswith(".json"):
            text = read_text(path, "replay", _MAX_SIZE)
        else:
            with opened_archive(path, "replay") as (notes, _):
                text = json.dumps(notes["provenance"].get("live"))
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


class Frames:
    """Times and snapshots of a scene, in a file without a name, which is gone with the session."""

    def __init__(self, scene: Scene) -> None:
        self.times: list[float] = []
        self._file = tempfile.TemporaryFile()  # noqa: SIM115 (it is closed with the frames)
        weakref.finalize(self, self._file.close)
        self._steps_of_frame = max(1, round(_INTERVAL / scene.step_length))

    def keep(self, scene: Scene, *, last: bool = False) -> None:
        """Add the present state of the scene if a frame is due, or if it is the last one and not there yet."""
        if self.times[-1:] != [scene.time] if last else scene.steps % self._steps_of_frame == 0:
            self._file.write(json.dumps(scene.snapshot()).encode() + b"\n")
            self._file.flush()
            self.times.append(scene.time)

    def __iter__(self) -> Iterator[Any]:
        self._file.seek(0)
        yield from map(json.loads, self._file)


def record(session: Session, path: str | Path, progress: Callable[[int, int], None] | None = None) -> None:
    """Write what happened in a session since its scene was built: inputs as .json, a dragon's run as .npz, a film.

    The session must not step meanwhile.
    """
    destination = check_destination(path, RECORDING_ENDINGS)
    scene, log, ending = session.scene, Log.of(session), destination.suffix.lower()
    if ending == ".json":
        with written_in_place(destination) as draft:
            draft.write_text(log.to_json())
        return
    session.keep_frame(last=True)
    frames = session.frames
    if frames is None or (ending != ".npz" and len(frames.times) < 2):
        raise ParameterError("record", str(path), "a file of a session of which at least two frames were kept")
    done = {message["do"] for _, message in log.inputs}
    if ending == ".npz":
        _run(scene, log, frames).save(destination)
    elif isinstance(scene, DragonScene) and not scene.obstacles and _NOT_IN_RUNS.isdisjoint(done):
        render(_run(scene, log, frames), destination, progress=progress, speedup=1, fps=_FPS)
    else:
        _film(scene, frames, destination, progress)


def still(session: Session) -> bytes:
    """Return a picture of the present state as the bytes of a PNG."""
    file = io.BytesIO()
    with session.held:
        _picture(session.scene, session.scene.snapshot()).save(file, "png")
    return file.getvalue()


def _run(scene: Scene, log: Log, frames: Frames) -> Run:
    """Return frames of a dragon as a run, with errors against the exact model at the times of the march."""
    if not isinstance(scene, DragonScene):
        raise ParameterError("record", ".npz", ".json or a film: only a dragon's session is a run")
    times, snapshots = np.array(frames.times), list(frames)
    march_times = np.array([snapshot["march_time"] for snapshot in snapshots])
    poses = np.array([snapshot["poses"] for snapshot in snapshots])
    errors = position_errors(scene.march.dragon, poses, scene.march.at(march_times).positions)
    span = {"start": float(times[0]), "until": float(times[-1])}
    notes = engine_provenance(scene.world.settings, guide="rails", substeps=log.steps, **span)
    provenance = {**notes, "live": {**vars(log), "march_times": march_times.tolist()}}
    return Run(march=scene.march, times=times, poses=poses, drift=errors, provenance=provenance)


def _film(scene: Scene, frames: Frames, destination: Path, progress: Callable[[int, int], None] | None) -> None:
    """Write a film by Pymunk's debug drawing."""
    times = np.array(frames.times)
    samples = islice(frames, 0, None, max(1, len(times) // _SAMPLES))
    table = Image.fromarray(np.concatenate([np.asarray(_picture(scene, each)) for each in samples])).quantize(_COLOURS)

    def pictures() -> Iterator[Image.Image]:
        for done, snapshot in enumerate(frames, start=1):
            yield _picture(scene, snapshot).quantize(palette=table, dither=Image.Dither.NONE)
            if progress is not None:
                progress(done, len(times))

    ends = np.append(times[1:], 2 * times[-1] - times[-2]) - times[0]
    with written_in_place(destination) as draft:
        film = formats.Frames(pictures=pictures(), ends=ends.tolist(), size=_SIZE, fps=_FPS)
        formats.WRITERS[destination.suffix.lower()](draft, film)


def _picture(scene: Scene, snapshot: Any) -> Image.Image:
    """Return the picture of a snapshot by Pymunk's debug drawing."""
    picture = Image.new("RGB", _SIZE, "white")
    options = PillowDrawOptions(picture, positive_y_is_up=not scene.play.y_down)
    (x, y), (width, height) = scene.field["centre"], scene.field["size"]
    options.fit(pymunk.BB(x - width / 2, y - height / 2, x + width / 2, y + height / 2))
    with options:
        options.calls += scene.calls_of(snapshot)
    return picture
