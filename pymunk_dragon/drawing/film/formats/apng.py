"""APNG writer: Pillow's. It keeps all frames in memory, so the size of a film is limited."""

from __future__ import annotations

from pathlib import Path

from pymunk_dragon.drawing.film.formats.frames import Frames
from pymunk_dragon.errors import ParameterError

# Pixels of all frames: Pillow keeps two bytes for each of them, so 2 GB. It is 5000 frames of the default size.
MAX_PIXELS = 1_000_000_000


def write_apng(path: Path, frames: Frames) -> None:
    """Write an animated PNG that repeats without end; all frames are in memory.

    Raises
    ------
    ParameterError
        If the frames have more than a billion pixels.
    """
    width, height = frames.size
    if len(frames.ends) * width * height > MAX_PIXELS:
        bound = (
            f"at most {MAX_PIXELS // (width * height)} in an APNG of {width} x {height} pixels, or in another format"
        )
        raise ParameterError("number of frames", len(frames.ends), bound)
    # ms; Pillow merges equal frames.
    durations = frames.durations(1000)
    first, *others = frames.coloured()
    first.save(path, "PNG", save_all=True, append_images=others, duration=durations, loop=0)
