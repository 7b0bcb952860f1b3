"""Writers of film files, selected by the file's ending.

A format is one module with a function that writes `Frames` to a file, and one line in `WRITERS`.

imageio writes the stills, and its FFmpeg encodes the MP4. It writes no other film, because its writers take a list of
RGB frames (1 GB of memory for 300 frames of 640 x 640 pixels, and 36 ms a frame for a GIF); for WebP and APNG they call
the writers of Pillow that `webp` and `apng` call directly.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from pymunk_dragon.drawing.film.formats.apng import write_apng
from pymunk_dragon.drawing.film.formats.frames import Frames
from pymunk_dragon.drawing.film.formats.gif import write_gif
from pymunk_dragon.drawing.film.formats.mp4 import write_mp4
from pymunk_dragon.drawing.film.formats.webp import write_webp

__all__ = ["WRITERS", "Frames"]

# Writer of each format, by the ending of its files in lower case.
WRITERS: dict[str, Callable[[Path, Frames], None]] = {
    ".gif": write_gif,
    ".apng": write_apng,
    ".webp": write_webp,
    ".mp4": write_mp4,
}
