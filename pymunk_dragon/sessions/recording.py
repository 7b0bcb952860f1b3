"""Frames of a session, and files of what happened: inputs as .json, the run of a dragon as .npz, films."""

from __future__ import annotations

import io
import struct
import tempfile
import weakref
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pymunk
from PIL import Image

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.drawing.film import formats, render
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run
from pymunk_dragon.model.settings import engine_provenance
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.log import Log
from pymunk_dragon.sessions.messages import from_binary
from pymunk_dragon.sessions.scene import Scene

if TYPE_CHECKING:
    from pymunk_dragon.sessions.session import Session

RECORDING_ENDINGS = (".json", ".npz", *formats.WRITERS)
# Simulated s between frames.
INTERVAL = 1 / 30
# Frames a second of a film, and pixels of one by Pymunk's debug drawing.
FPS, SIZE = 20, (640, 480)
# Inputs whose effects a run does not show.
_NOT_IN_RUNS = {"cut", "obstacle"}
# Colours of such a film: one index means transparent. Pictures from which they are chosen.
COLOURS, SAMPLES = 255, 8

# Before each snapshot: its time, s, and its length, bytes.
_FRAME = struct.Struct("<dI")

Progress = Callable[[int, int], None]


class Frames:
    """Times and snapshots of a scene, in a file without a name, which is gone with the session."""

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile()  # noqa: SIM115 (it is closed with the frames)
        weakref.finalize(self, self._file.close)
        self._steps_of_frame = 1

    def begin(self, scene: Scene) -> None:
        """Forget all frames, and keep those of a new scene."""
        self._file.seek(0)
        self._file.truncate()
        self._steps_of_frame = max(1, round(INTERVAL / scene.step_length))

    def keep(self, scene: Scene) -> None:
        """Add the present state of the scene if a frame is due."""
        if scene.steps % self._steps_of_frame == 0:
            snapshot = scene.snapshot()
            self._file.write(_FRAME.pack(scene.time, len(snapshot)) + snapshot)

    def __iter__(self) -> Iterator[tuple[float, bytes]]:
        end = self._file.tell()
        self._file.seek(0)
        while self._file.tell() < end:
            time, length = _FRAME.unpack(self._file.read(_FRAME.size))
            yield time, self._file.read(length)


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """What happened in a session up to a moment."""

    scene: Scene
    log: Log
    times: list[float]
    snapshots: list[bytes]

    @classmethod
    def of(cls, session: Session) -> Recorded:
        """Return the frames of a session that does not step at the moment; the last is the present one."""
        scene, found = session.scene, list(session.frames or ())
        if not found or found[-1][0] < scene.time:
            found.append((scene.time, scene.snapshot()))
        times, snapshots = map(list, zip(*found, strict=True))
        return cls(scene=scene, log=Log.of(session), times=times, snapshots=snapshots)

    @property
    def is_run(self) -> bool:
        """Whether the film of a run shows all there was: it has neither obstacles nor joints that were cut."""
        done = {message["do"] for _, message in self.log.inputs}
        return isinstance(self.scene, DragonScene) and not self.scene.obstacles and _NOT_IN_RUNS.isdisjoint(done)

    def run(self) -> Run:
        """Return the frames of a dragon as a run, with errors against the exact model at the times of the march."""
        scene, log, times = self.scene, self.log, np.array(self.times)
        if not isinstance(scene, DragonScene):
            raise ParameterError("record", ".npz", ".json or a film: only a dragon's session is a run")
        states = [from_binary(snapshot, "<f8") for snapshot in self.snapshots]
        march_times = np.array([header["march_time"] for header, _ in states])
        poses = np.array([arrays["poses"].reshape(-1, 3) for _, arrays in states])
        exact = scene.march.at(march_times).positions
        front, rear = scene.march.dragon.holes(poses)
        errors = np.linalg.norm(front - exact[:, :-1], axis=-1), np.linalg.norm(rear - exact[:, 1:], axis=-1)
        span = {"start": float(times[0]), "until": float(times[-1])}
        notes = engine_provenance(scene.world.settings, guide="rails", substeps=log.steps, **span)
        live = {**asdict(log), "march_times": march_times.tolist()}
        provenance = {**notes, "live": live}
        return Run(march=scene.march, times=times, poses=poses, drift=np.maximum(*errors), provenance=provenance)


def record(session: Session, path: str | Path, progress: Progress | None = None) -> None:
    """Write what happened in a session since its scene was built: inputs as .json, a dragon's run as .npz, a film."""
    destination = check_destination(path, RECORDING_ENDINGS)
    ending = destination.suffix.lower()
    if ending == ".json":
        with written_in_place(destination) as draft:
            draft.write_text(Log.of(session).to_json())
        return
    recorded = Recorded.of(session)
    if ending == ".npz":
        recorded.run().save(destination)
    elif len(recorded.times) < 2:
        raise ParameterError("record", str(path), "a file of a session with at least two frames")
    elif recorded.is_run:
        render(recorded.run(), destination, progress=progress, speedup=1, fps=FPS)
    else:
        _film(recorded, destination, progress)


def still(session: Session) -> bytes:
    """Return a picture of the present state as the bytes of a PNG."""
    with session.held():
        picture = _picture(session.scene, session.scene.snapshot())
    file = io.BytesIO()
    picture.save(file, "png")
    return file.getvalue()


def _film(recorded: Recorded, destination: Path, progress: Progress | None) -> None:
    """Write a film by Pymunk's debug drawing."""
    scene, times, snapshots = recorded.scene, np.array(recorded.times), recorded.snapshots
    every = snapshots[:: max(1, len(snapshots) // SAMPLES)]
    table = Image.fromarray(np.concatenate([np.asarray(_picture(scene, each)) for each in every])).quantize(COLOURS)

    def pictures() -> Iterator[Image.Image]:
        for done, snapshot in enumerate(snapshots, start=1):
            yield _picture(scene, snapshot).quantize(palette=table, dither=Image.Dither.NONE)
            if progress is not None:
                progress(done, len(snapshots))

    ends = np.append(times[1:], 2 * times[-1] - times[-2]) - times[0]
    with written_in_place(destination) as draft:
        film = formats.Frames(pictures=pictures(), ends=ends.tolist(), size=SIZE, fps=FPS)
        formats.WRITERS[destination.suffix.lower()](draft, film)


def _picture(scene: Scene, snapshot: bytes) -> Image.Image:
    """Return the picture of a snapshot by Pymunk's debug drawing."""
    picture = Image.new("RGB", SIZE, "white")
    options = PillowDrawOptions(picture, positive_y_is_up=not scene.play.y_down)
    (x, y), (width, height) = scene.field["centre"], scene.field["size"]
    options.fit(pymunk.BB(x - width / 2, y - height / 2, x + width / 2, y + height / 2))
    with options:
        options.calls += scene.calls_of(snapshot)
    return picture
