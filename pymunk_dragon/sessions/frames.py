"""Frames of a session: since its scene was built, and while a client records."""

from __future__ import annotations

import io
import tempfile
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO, TYPE_CHECKING

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.sessions.log import Log
from pymunk_dragon.sessions.scenes import Scene

if TYPE_CHECKING:
    from pymunk_dragon.sessions.session import Session

# Before the poses of a frame: time, and time of the march.
TIMES = 2
# Simulated s between frames.
INTERVAL = 1 / 30
# Bytes of frames after which a recording that a client began ends: ten minutes of 223 benches.
MAX_RECORDED = 100_000_000


class Frames:
    """Times and poses of a scene, in a file.

    Parameters
    ----------
    file : binary file
        An empty file, for reading and writing.
    limit : float
        Size, bytes, after which it is full.
    """

    def __init__(self, file: IO[bytes], limit: float = np.inf) -> None:
        self._file, self._limit = file, limit

    def clear(self) -> None:
        """Forget all frames."""
        self._file.seek(0)
        self._file.truncate()

    def append(self, scene: Scene) -> None:
        """Add the present state of the scene."""
        self._file.write(_row(scene).tobytes())

    @property
    def is_full(self) -> bool:
        """Whether there is no room for another frame."""
        return self._file.tell() >= self._limit

    def arrays(self, scene: Scene) -> tuple[Array, Array, Array]:
        """Times (F,) and times of the march (F,), s, and poses (F, B, 3); the last are the present ones."""
        bodies = len(scene.bodies)
        self._file.seek(0)
        rows = np.frombuffer(self._file.read()).reshape(-1, TIMES + 3 * bodies)
        if not len(rows) or rows[-1, 0] < scene.time:
            rows = np.vstack([rows, _row(scene)])
        return rows[:, 0], rows[:, 1], rows[:, TIMES:].reshape(len(rows), bodies, 3)


def _row(scene: Scene) -> Array:
    return np.concatenate([[scene.time, scene.march_time], scene.poses().ravel()])


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """What happened in a session up to a moment.

    Attributes
    ----------
    scene : Scene
        The scene, which may have gone on since.
    log : Log
        What was done since the scene was built.
    times, march_times : ndarray, shape (F,)
        Times of the frames, and of the march, s.
    poses : ndarray, shape (F, B, 3)
        Poses of the bodies: m, m, rad.
    """

    scene: Scene
    log: Log
    times: Array
    march_times: Array
    poses: Array

    @classmethod
    def of(cls, session: Session, frames: Frames) -> Recorded:
        """Frames of a session that does not step at the moment."""
        times, march_times, poses = frames.arrays(session.scene)
        return cls(scene=session.scene, log=Log.of(session), times=times, march_times=march_times, poses=poses)


class Recorder:
    """Frames of a session, and the recording of a client.

    Parameters
    ----------
    always : bool
        Whether frames are kept even if no client records, in a temporary file.

    Attributes
    ----------
    frames : Frames or None
        Frames since the scene was built, if they are kept.
    recorded : Recorded or None
        What a client recorded last.
    """

    def __init__(self, *, always: bool) -> None:
        self.frames = self._in_a_file() if always else None
        self.recorded: Recorded | None = None
        self._recording: Frames | None = None
        self._steps_of_frame = 1

    @property
    def is_recording(self) -> bool:
        """Whether a client records at the moment."""
        return self._recording is not None

    def rebuilt(self, scene: Scene) -> None:
        """Begin anew with the session's new scene: remove all frames."""
        self._steps_of_frame = max(1, round(INTERVAL / scene.step_length))
        for frames in self._kept():
            frames.clear()

    def keep(self, session: Session) -> Iterator[str]:
        """Keep a frame of the present state if one is due, and yield a text for each error."""
        if session.scene.steps % self._steps_of_frame:
            return
        try:
            for frames in self._kept():
                frames.append(session.scene)
        except OSError as error:
            self.frames = None
            yield f"frames are no longer kept: {error.strerror}"
        if self._recording is not None and self._recording.is_full:
            self.finish(session)
            yield "the recording is full, and has ended"

    def begin(self, scene: Scene) -> None:
        """Begin the recording of a client."""
        self._recording = Frames(io.BytesIO(), MAX_RECORDED)
        self._recording.append(scene)

    def finish(self, session: Session) -> None:
        """End the recording of a client, if one goes on."""
        if self._recording is not None:
            self.recorded, self._recording = Recorded.of(session, self._recording), None

    def _kept(self) -> list[Frames]:
        return [frames for frames in (self.frames, self._recording) if frames is not None]

    def _in_a_file(self) -> Frames:
        """Frames in a file without a name, which is gone with the recorder."""
        file = tempfile.TemporaryFile()  # noqa: SIM115 (it is closed with the recorder)
        weakref.finalize(self, file.close)
        return Frames(file)
