"""Recordings of a session: what was done, from which it is played again to the bit, and frames for films."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pymunk
from PIL import Image

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import whole
from pymunk_dragon._files import check_destination, read_text, written_in_place
from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.drawing.film import write_film
from pymunk_dragon.drawing.film.formats import WRITERS, Frames
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.model.run import Run, engine_provenance
from pymunk_dragon.model.run_file import opened_archive, write_archive
from pymunk_dragon.sessions.messages import INPUTS, checked
from pymunk_dragon.sessions.scenes import DragonScene, Scene, planned
from pymunk_dragon.sessions.session import MAX_INPUTS, Session

# Endings of files of recordings.
RECORDING_ENDINGS = (".npz", *WRITERS)
# Frames a second, and pixels of a film of a space that is no dragon.
FPS, SIZE = 20, (640, 480)
# Colours of such a film: one index means transparent.
COLOURS = 255
# Steps of a recording, at most.
MAX_STEPS = 100_000_000

Progress = Callable[[int, int], None]


@dataclass(frozen=True, kw_only=True)
class Log:
    """What was done to a scene since it was built.

    Attributes
    ----------
    plan : mapping or None
        As `Ready.plan`.
    values : mapping
        Values of parameters with which the scene was built.
    steps : int
        Number of steps.
    inputs : list of (int, dict)
        Numbers of the steps before which messages took effect, and these.
    digest : str
        Digest of all poses after the last step.
    """

    plan: Mapping[str, Any] | None
    values: Mapping[str, float]
    steps: int
    inputs: list[tuple[int, dict[str, Any]]]
    digest: str

    @classmethod
    def of(cls, session: Session) -> Log:
        """The log of a session that does not step at the moment."""
        return cls(
            plan=session.source.plan,
            values=dict(session.values),
            steps=session.scene.steps,
            inputs=list(session.inputs),
            digest=session.digest(),
        )

    @classmethod
    def load(cls, path: str | Path) -> Log:
        """Read the log in a file that `record` wrote as .npz, or that the page saved as .json.

        Raises
        ------
        ParameterError
            If there is no such file, or it cannot be read.
        FileFormatError
            If it is no recording, or a damaged one.
        """
        if str(path).endswith(".json"):
            text = read_text(path, "recording")
            try:
                return cls._of(json.loads(text))
            except Exception as error:  # Whatever it is, the content is to blame.
                raise FileFormatError(path, "no recording of a live session, or a damaged one") from error
        with opened_archive(path) as archive:
            return cls._of(archive.notes["provenance"]["live"])

    @classmethod
    def _of(cls, notes: Mapping[str, Any]) -> Log:
        inputs = [(whole("step", step, 0, MAX_STEPS), checked(message)) for step, message in notes["inputs"]]
        if len(inputs) > MAX_INPUTS or any(message["do"] not in INPUTS for _, message in inputs):
            raise DragonError("it has inputs that change nothing")
        if notes["plan"] is not None:
            planned(notes["plan"])
        return cls(
            plan=notes["plan"],
            values={str(name): float(value) for name, value in notes["values"].items()},
            steps=whole("steps", notes["steps"], 0, MAX_STEPS),
            inputs=inputs,
            digest=str(notes["digest"]),
        )

    def to_json(self) -> str:
        """The log as JSON, which `load` reads."""
        return json.dumps(asdict(self), allow_nan=False)


def record(session: Session, path: str | Path, progress: Progress | None = None) -> None:
    """Write what happened in a session since its scene was built: as .npz, or as a film.

    The .npz of a dragon is a run as well, which `Run.load` reads.

    Parameters
    ----------
    session : Session
        A session that does not step at the moment.
    path : path
        File to write, ending in .npz or as a film.
    progress : callable, optional
        Called with the number of pictures that are drawn, and of all.

    Raises
    ------
    ParameterError
        If the ending is another one, the file cannot be created, or a film would have a single frame.
    OutputError
        If writing fails.
    """
    destination = check_destination(path, RECORDING_ENDINGS)
    is_film = destination.suffix.lower() != ".npz"
    scene, frames = session.scene, list(session.frames)
    if not frames or frames[-1][0] < scene.time:
        frames.append((scene.time, scene.march_time, scene.poses().copy()))
    times, march_times, poses = (np.array(values) for values in zip(*frames, strict=True))
    if is_film and len(times) < 2:
        raise ParameterError("record", str(path), "a file of a session with at least two frames")
    log = asdict(Log.of(session))
    if isinstance(scene, DragonScene):
        run = _run(scene, times, march_times, poses, log)
        if is_film:
            write_film(run, destination, Film(speedup=1, fps=FPS), progress)
        else:
            run.save(destination)
    elif is_film:
        ends = np.append(times[1:], 2 * times[-1] - times[-2]) - times[0]
        table = _picture(scene, poses[0]).quantize(COLOURS)
        pictures = _indexed(scene, poses, table, progress)
        colours = np.zeros((256, 3), dtype=np.uint8)
        known = np.array(table.getpalette(), dtype=np.uint8).reshape(-1, 3)
        colours[: len(known)] = known
        with written_in_place(destination) as draft:
            film = Frames(pictures=pictures, ends=ends.tolist(), size=SIZE, colours=colours, fps=FPS)
            WRITERS[destination.suffix.lower()](draft, film)
    else:
        write_archive(destination, {"provenance": {"live": log}}, {"times": times, "poses": poses.ravel()})


def _run(scene: DragonScene, times: Array, march_times: Array, poses: Array, log: dict[str, Any]) -> Run:
    """The frames of a dragon as a run, with errors against the exact model at the times of the march."""
    march = scene.march
    exact = march.at(march_times).positions
    front, rear = march.dragon.holes(poses)
    errors = np.linalg.norm(front - exact[:, :-1], axis=-1), np.linalg.norm(rear - exact[:, 1:], axis=-1)
    span = {"start": float(times[0]), "until": float(times[-1])}
    notes = engine_provenance(scene.world.settings, guide="rails", substeps=scene.steps, **span)
    log = {**log, "march_times": march_times.tolist()}
    return Run(march=march, times=times, poses=poses, drift=np.maximum(*errors), provenance={**notes, "live": log})


def _indexed(scene: Scene, poses: Array, table: Image.Image, progress: Progress | None) -> Iterator[Image.Image]:
    """Pictures of the scene's bodies at `poses` (F, B, 3), as indices of the colours of `table`."""
    for done, frame in enumerate(poses, start=1):
        picture = _picture(scene, frame).quantize(palette=table, dither=Image.Dither.NONE)
        yield Image.frombytes("L", picture.size, picture.tobytes())
        if progress is not None:
            progress(done, len(poses))


def _picture(scene: Scene, poses: Array) -> Image.Image:
    """Picture of the scene's bodies at `poses` (B, 3) by Pymunk's debug drawing."""
    picture = Image.new("RGB", SIZE, "white")
    options = PillowDrawOptions(picture, positive_y_is_up=True)
    for body, (x, y, angle) in zip(scene.bodies, poses.tolist(), strict=True):
        body.position, body.angle = (x, y), angle
        scene.space.reindex_shapes_for_body(body)
    (x, y), (width, height) = scene.field["centre"], scene.field["size"]
    options.fit(pymunk.BB(x - width / 2, y - height / 2, x + width / 2, y + height / 2))
    scene.space.debug_draw(options)
    return picture
