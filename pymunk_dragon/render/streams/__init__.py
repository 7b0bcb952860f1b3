"""Films as files, by their endings; all are written as they come, and keep no more than two frames."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.render.streams.apng import ApngStream
from pymunk_dragon.render.streams.base import PatchStream, Stream
from pymunk_dragon.render.streams.gif import GifStream
from pymunk_dragon.render.streams.mp4 import Mp4Stream, ffmpeg
from pymunk_dragon.render.streams.webp import WebpStream

__all__ = ["FILM_ENDINGS", "Stream", "check_ending", "open_stream"]

PATCHED: dict[str, type[PatchStream]] = {".gif": GifStream, ".apng": ApngStream, ".webp": WebpStream}
VIDEO = ".mp4"
# A GIF's delays are whole centiseconds, and browsers show 1 centisecond as 10.
MAX_GIF_FPS = 50
FILM_ENDINGS = (*PATCHED, VIDEO)


def check_ending(path: Path, fps: int) -> None:
    """Make sure that a film of this ending can be written here, with `fps` frames a second.

    Raises
    ------
    ParameterError
        If it is a GIF with so many that browsers would slow it down.
    MissingExtraError
        If it is an MP4, and there is no FFmpeg.
    """
    ending = path.suffix.lower()
    if ending == ".gif" and fps > MAX_GIF_FPS:
        raise ParameterError("fps", fps, f"at most {MAX_GIF_FPS} in a GIF")
    if ending == VIDEO:
        ffmpeg()


@contextmanager
def open_stream(path: Path, size: tuple[int, int], table: NDArray[np.uint8], fps: int) -> Iterator[Stream]:
    """A film to add frames to, of `size` in pixels and the colours of `table` (256, 3)."""
    ending = path.suffix.lower()
    if ending == VIDEO:
        with Mp4Stream(path, size, table, fps) as video:
            yield video
    else:
        with path.open("wb") as file, PATCHED[ending](file, size, table) as stream:
            yield stream
