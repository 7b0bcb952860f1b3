"""Writers of film files, selected by the file's ending. Each writer keeps at most two frames in memory."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.drawing.streams.apng import ApngStream
from pymunk_dragon.drawing.streams.base import DirtyRectangleStream, Stream
from pymunk_dragon.drawing.streams.gif import GifStream
from pymunk_dragon.drawing.streams.mp4 import Mp4Stream, ffmpeg
from pymunk_dragon.drawing.streams.webp import WebpStream
from pymunk_dragon.errors import ParameterError

__all__ = ["FILM_ENDINGS", "Stream", "check_ending", "open_stream"]

# Writers that store only the dirty rectangle of each frame.
DIRTY_RECTANGLE_STREAMS: dict[str, type[DirtyRectangleStream]] = {
    ".gif": GifStream,
    ".apng": ApngStream,
    ".webp": WebpStream,
}
# Ending of a video, which FFmpeg encodes.
VIDEO = ".mp4"
# Frames per second: delays in a GIF are whole centiseconds, and browsers replace 1 centisecond by 10.
MAX_GIF_FPS = 50
# All endings of films, in lower case.
FILM_ENDINGS = (*DIRTY_RECTANGLE_STREAMS, VIDEO)


def check_ending(path: Path, fps: int) -> None:
    """Check that a film with the ending of `path` can be written at `fps` frames per second.

    Raises
    ------
    ParameterError
        If the film is a GIF and browsers would slow it down.
    MissingExtraError
        If the film is an MP4 and FFmpeg is not installed.
    """
    ending = path.suffix.lower()
    if ending == ".gif" and fps > MAX_GIF_FPS:
        raise ParameterError("fps", fps, f"at most {MAX_GIF_FPS} in a GIF")
    if ending == VIDEO:
        ffmpeg()


@contextmanager
def open_stream(path: Path, size: tuple[int, int], table: NDArray[np.uint8], fps: int) -> Iterator[Stream]:
    """Open a film file for writing. `size` is in pixels; `table` (256, 3) holds the colours."""
    ending = path.suffix.lower()
    if ending == VIDEO:
        with Mp4Stream(path, size, table, fps) as video:
            yield video
    else:
        with path.open("wb") as file, DIRTY_RECTANGLE_STREAMS[ending](file, size, table) as stream:
            yield stream
