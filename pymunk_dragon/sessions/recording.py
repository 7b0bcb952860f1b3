"""Files of what happened in a session: an .npz, which is a run if it was a dragon, and films."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import IO

import numpy as np
import pymunk
from PIL import Image

from pymunk_dragon._arrays import Array
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.drawing.film import formats, write_film
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run, engine_provenance
from pymunk_dragon.model.run_file import write_archive
from pymunk_dragon.sessions.log import Frames, Recorded
from pymunk_dragon.sessions.scenes import DragonScene, Scene
from pymunk_dragon.sessions.session import Session

# Endings of files of recordings.
RECORDING_ENDINGS = (".npz", *formats.WRITERS)
# Frames a second, and pixels of a film of a space that is no dragon.
FPS, SIZE = 20, (640, 480)
# Colours of such a film: one index means transparent.
COLOURS = 255

Progress = Callable[[int, int], None]


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
    recorded = Recorded.of(session, session.frames or Frames(io.BytesIO()))
    if destination.suffix.lower() == ".npz":
        save(recorded, destination)
    elif len(recorded.times) < 2:
        raise ParameterError("record", str(path), "a file of a session with at least two frames")
    elif isinstance(recorded.scene, DragonScene):
        write_film(_run(recorded), destination, Film(speedup=1, fps=FPS), progress)
    else:
        _film(recorded, destination, progress)


def save(recorded: Recorded, file: Path | IO[bytes]) -> None:
    """Write frames and log as .npz, to a path or an open file; those of a dragon are a run."""
    if isinstance(recorded.scene, DragonScene):
        _run(recorded).save(file)
    else:
        arrays = {"times": recorded.times, "poses": recorded.poses.ravel()}
        write_archive(file, {"provenance": {"live": asdict(recorded.log)}}, arrays)


def _run(recorded: Recorded) -> Run:
    """The frames of a dragon as a run, with errors against the exact model at the times of the march."""
    scene, log, times, poses = recorded.scene, recorded.log, recorded.times, recorded.poses
    assert isinstance(scene, DragonScene)
    exact = scene.march.at(recorded.march_times).positions
    front, rear = scene.march.dragon.holes(poses)
    errors = np.linalg.norm(front - exact[:, :-1], axis=-1), np.linalg.norm(rear - exact[:, 1:], axis=-1)
    span = {"start": float(times[0]), "until": float(times[-1])}
    notes = engine_provenance(scene.world.settings, guide="rails", substeps=log.steps, **span)
    live = {**asdict(log), "march_times": recorded.march_times.tolist()}
    return Run(
        march=scene.march, times=times, poses=poses, drift=np.maximum(*errors), provenance={**notes, "live": live}
    )


def _film(recorded: Recorded, destination: Path, progress: Progress | None) -> None:
    """Write a film of a space that is no dragon."""
    scene, times, poses = recorded.scene, recorded.times, recorded.poses
    ends = np.append(times[1:], 2 * times[-1] - times[-2]) - times[0]
    table = _picture(scene, poses[0]).quantize(COLOURS)
    colours = np.zeros((256, 3), dtype=np.uint8)
    known = np.array(table.getpalette(), dtype=np.uint8).reshape(-1, 3)
    colours[: len(known)] = known
    pictures = _indexed(scene, poses, table, progress)
    with written_in_place(destination) as draft:
        film = formats.Frames(pictures=pictures, ends=ends.tolist(), size=SIZE, colours=colours, fps=FPS)
        formats.WRITERS[destination.suffix.lower()](draft, film)


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
