"""Files of what happened in a session: an .npz, which is a run if it was a dragon, and films."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import IO

import numpy as np
import pymunk
from PIL import Image

from pymunk_dragon._arrays import Array
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.drawing.film import formats, render
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run, write_archive
from pymunk_dragon.model.settings import engine_provenance
from pymunk_dragon.sessions.frames import Frames, Recorded
from pymunk_dragon.sessions.scenes import DragonScene, Scene
from pymunk_dragon.sessions.scenes.base import ANCHORS
from pymunk_dragon.sessions.session import Session

# Endings of files of recordings.
RECORDING_ENDINGS = (".npz", *formats.WRITERS)
# Frames a second of a film, and pixels of one by Pymunk's debug drawing.
FPS, SIZE = 20, (640, 480)
# Radius of the ends of a joint, pixels.
JOINT_SIZE = 3
# The area of a film is at most so many times as large as the scene's.
LARGEST_FIELD = 2.0
# Inputs whose effects a run does not show.
NOT_IN_RUNS = {"cut", "obstacle"}
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
    recorded = Recorded.of(session, session.recorder.frames or Frames(io.BytesIO()))
    if destination.suffix.lower() == ".npz":
        save(recorded, destination)
    elif len(recorded.times) < 2:
        raise ParameterError("record", str(path), "a file of a session with at least two frames")
    elif _is_march(recorded):
        render(_run(recorded), destination, progress=progress, speedup=1, fps=FPS)
    else:
        _film(session, recorded, destination, progress)


def _is_march(recorded: Recorded) -> bool:
    """Whether the film of a run shows all there was: it has neither obstacles nor joints that were cut."""
    scene = recorded.scene
    return (
        isinstance(scene, DragonScene)
        and not scene.obstacles
        and NOT_IN_RUNS.isdisjoint(message["do"] for _, message in recorded.log.inputs)
    )


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
    assert isinstance(scene, DragonScene)  # Only a dragon is saved as a run.
    exact = scene.march.at(recorded.march_times).positions
    front, rear = scene.march.dragon.holes(poses)
    errors = np.linalg.norm(front - exact[:, :-1], axis=-1), np.linalg.norm(rear - exact[:, 1:], axis=-1)
    span = {"start": float(times[0]), "until": float(times[-1])}
    notes = engine_provenance(scene.world.settings, guide="rails", substeps=log.steps, **span)
    live = {**asdict(log), "march_times": recorded.march_times.tolist()}
    return Run(
        march=scene.march, times=times, poses=poses, drift=np.maximum(*errors), provenance={**notes, "live": live}
    )


def _film(session: Session, recorded: Recorded, destination: Path, progress: Progress | None) -> None:
    """Write a film of a replay by Pymunk's debug drawing; at its end the session is where it was."""
    log, times = recorded.log, recorded.times
    field = _field(recorded)
    last = _picture(session.scene, field)
    session.play_again(log.inputs, log.values, log.steps)
    table = _table([_picture(session.scene, field), last, _obstacle()])
    ends = np.append(times[1:], 2 * times[-1] - times[-2]) - times[0]
    pictures = _pictures(session, field, times, table, progress)
    with written_in_place(destination) as draft:
        film = formats.Frames(pictures=pictures, ends=ends.tolist(), size=SIZE, fps=FPS)
        formats.WRITERS[destination.suffix.lower()](draft, film)


def _table(pictures: Sequence[Image.Image]) -> Image.Image:
    """An image with a table of the colours of all pictures."""
    return Image.fromarray(np.concatenate([np.asarray(picture) for picture in pictures])).quantize(COLOURS)


def _obstacle() -> Image.Image:
    """Picture of an obstacle, which may stand only for a while."""
    space = pymunk.Space()
    space.add(pymunk.Circle(space.static_body, 1))
    return _picture(Scene(space), pymunk.BB(-1, -1, 1, 1))


def _pictures(
    session: Session, field: pymunk.BB, times: Array, table: Image.Image, progress: Progress | None
) -> Iterator[Image.Image]:
    """Pictures of a session that is replayed, in the colours of `table`, at times (F,), s."""
    for done, time in enumerate(times, start=1):
        session.step_to(time)
        yield _picture(session.scene, field).quantize(palette=table, dither=Image.Dither.NONE)
        if progress is not None:
            progress(done, len(times))


def _field(recorded: Recorded) -> pymunk.BB:
    """The area where bodies and obstacles are, unless it is much larger than the scene's."""
    scene = recorded.scene
    centre, half = np.array(scene.field["centre"]), np.array(scene.field["size"]) / 2
    put = [message for _, message in recorded.log.inputs if message["do"] == "obstacle"] + [*scene.obstacles.values()]
    boxes = [(each["x"], each["y"], each["size"] / 2) for each in put]
    points = np.array([(x + side * size, y + side * size) for x, y, size in boxes for side in (-1, 1)])
    points = np.vstack([centre - half, centre + half, recorded.poses[..., :2].reshape(-1, 2), points.reshape(-1, 2)])
    points = np.clip(points, centre - LARGEST_FIELD * half.max(), centre + LARGEST_FIELD * half.max())
    return pymunk.BB(*points.min(axis=0), *points.max(axis=0))


def _picture(scene: Scene, field: pymunk.BB) -> Image.Image:
    """Picture of an area of the scene by Pymunk's debug drawing."""
    picture = Image.new("RGB", SIZE, "white")
    options = PillowDrawOptions(picture, positive_y_is_up=True)
    options.fit(field)
    options.flags &= ~options.DRAW_CONSTRAINTS
    scene.space.debug_draw(options)
    with options:
        for joint in scene.standing_joints():
            a, b = (
                body.local_to_world(getattr(joint, anchor, (0, 0)))
                for body, anchor in zip((joint.a, joint.b), ANCHORS, strict=True)
            )
            options.draw_segment(a, b, options.constraint_color)
            options.draw_dot(JOINT_SIZE, a, options.constraint_color)
            options.draw_dot(JOINT_SIZE, b, options.constraint_color)
    return picture
