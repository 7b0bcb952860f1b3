"""MP4, as H.264 by the FFmpeg that imageio brings.

imageio's own writer starts it and feeds it the same way, but never asks whether it could write its file: FFmpeg writes
most of it at the very end, when a full disk would go unnoticed.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pymunk_dragon.errors import MissingExtraError
from pymunk_dragon.extras import library

__all__ = ["Mp4Stream", "ffmpeg"]

# x264: a quality at which no one sees a difference between frame and film, at a speed that keeps up with the drawing
# (8 ms a frame of 640 x 640 with 223 benches on 2 cores; the default preset takes 14 and saves a seventh). It looks 5
# frames ahead instead of 10, and works in one thread, beside the process that draws: both keep FFmpeg below 90 MB, and
# the file the same whatever the number of cores.
QUALITY = ["-crf", "18", "-preset", "veryfast", "-x264-params", "rc-lookahead=5", "-threads", "1"]
# Half the resolution in colour, as every player wants it; which numbers mean which colour is said, not guessed; the
# index stands in front, so that a browser can play before it has all; and nothing of the machine or the hour.
COLOURS = "scale=out_color_matrix=bt709:out_range=tv,setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709"
FORM = [
    "-pix_fmt",
    "yuv420p",
    "-vf",
    COLOURS,
    "-movflags",
    "+faststart",
    "-fflags",
    "+bitexact",
    "-flags:v",
    "+bitexact",
]


class Mp4Stream:
    """Writer of an MP4: a frame every 1 / `fps` s, the same one again while it stays.

    Parameters
    ----------
    path : Path
        File to write.
    size : tuple of int
        Width and height of the frames, pixels.
    table : ndarray of uint8, shape (256, 3)
        Red, green and blue of every index.
    fps : int
        Frames a second.
    """

    def __init__(self, path: Path, size: tuple[int, int], table: NDArray[np.uint8], fps: int) -> None:
        self._palette = table.tobytes()
        self._fps = fps
        self._written = 0
        # Colour at half the resolution takes an even number of pixels: an odd one is made even with its last row.
        width, height = size
        self._padding = ((0, height % 2), (0, width % 2), (0, 0))
        even = f"{width + width % 2}x{height + height % 2}"
        given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", even, "-r", str(fps), "-i", "-"]
        self._process: subprocess.Popen[Any] = subprocess.Popen(
            [ffmpeg(), "-v", "error", "-y", *given, "-c:v", "libx264", *QUALITY, *FORM, str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            # Ctrl-C is for the one who asked for the film, and ends this too.
            start_new_session=True,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self._finish()
        else:
            self._process.kill()
            self._process.communicate()

    def add(self, frame: Image.Image, end: float) -> None:
        """Show `frame`, palette indices (mode L), until `end` s of film."""
        coloured = Image.frombuffer("P", frame.size, frame.tobytes())
        coloured.putpalette(self._palette)
        pixels = np.pad(np.asarray(coloured.convert("RGB")), self._padding, mode="edge").tobytes()
        last = max(self._written + 1, round(end * self._fps))
        assert self._process.stdin is not None
        for _ in range(self._written, last):
            try:
                self._process.stdin.write(pixels)
            except BrokenPipeError:
                self._finish()
                raise
        self._written = last

    def _finish(self) -> None:
        """Let it come to its end; where that was no success, tell what it complained of first."""
        _, complaints = self._process.communicate()
        if self._process.returncode != 0:
            lines = complaints.decode("utf-8", "replace").splitlines()
            raise OSError(lines[0] if lines else f"FFmpeg ended with {self._process.returncode}")


def ffmpeg() -> str:
    """The program.

    Raises
    ------
    MissingExtraError
        If there is none.
    """
    try:
        program: str = library("imageio_ffmpeg").get_ffmpeg_exe()
        subprocess.run([program, "-version"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except (RuntimeError, OSError, subprocess.CalledProcessError) as error:
        raise MissingExtraError("an MP4", "mp4") from error
    return program
