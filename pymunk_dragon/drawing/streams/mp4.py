"""MP4 writer: H.264 by the FFmpeg of imageio.

imageio's own writer runs the same program but does not check its exit code. FFmpeg writes most of the file at the end,
so imageio's writer does not detect a full disk.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pymunk_dragon._extras import library
from pymunk_dragon.errors import MissingExtraError

__all__ = ["Mp4Stream", "ffmpeg"]

# x264 options. CRF 18 has no visible loss. The preset "veryfast" takes 8 ms per frame of 640 x 640 pixels with 223
# benches on 2 cores; the default preset takes 14 ms and saves a seventh. A look-ahead of 5 frames (default 10) and one
# thread keep FFmpeg below 90 MB of memory, and make the file independent of the number of cores.
QUALITY = ["-crf", "18", "-preset", "veryfast", "-x264-params", "rc-lookahead=5", "-threads", "1"]
# FFmpeg filter: the colour space is BT.709 and is written to the file, so that players need not guess.
COLOURS = "scale=out_color_matrix=bt709:out_range=tv,setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709"
# FFmpeg options: chroma at half resolution, which every player supports; the index before the data, so that a browser
# can play an incomplete download; and no encoder version or date in the file.
FORMAT = [
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
    """Writer of an MP4 with a constant frame rate. A frame that is shown longer is repeated.

    Parameters
    ----------
    path : Path
        File to write.
    size : tuple of int
        Width and height of the frames, pixels.
    table : ndarray of uint8, shape (256, 3)
        Red, green and blue of every index.
    fps : int
        Frames per second.
    """

    def __init__(self, path: Path, size: tuple[int, int], table: NDArray[np.uint8], fps: int) -> None:
        self._palette = table.tobytes()
        self._fps = fps
        self._written = 0
        # Chroma at half resolution needs even sizes, so an odd width or height repeats its last column or row.
        width, height = size
        self._padding = ((0, height % 2), (0, width % 2), (0, 0))
        even = f"{width + width % 2}x{height + height % 2}"
        source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", even, "-r", str(fps), "-i", "-"]
        self._process: subprocess.Popen[Any] = subprocess.Popen(
            [ffmpeg(), "-v", "error", "-y", *source, "-c:v", "libx264", *QUALITY, *FORMAT, str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            # Ctrl-C must not reach FFmpeg: this process handles the interrupt and then ends FFmpeg.
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
        """Add `frame`, palette indices (mode L), shown until `end` s of film."""
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
        """Wait for FFmpeg to end. If it failed, raise an error with the first line of its messages."""
        _, messages = self._process.communicate()
        if self._process.returncode != 0:
            lines = messages.decode("utf-8", "replace").splitlines()
            raise OSError(lines[0] if lines else f"FFmpeg ended with {self._process.returncode}")


def ffmpeg() -> str:
    """Return the path of the FFmpeg program.

    Raises
    ------
    MissingExtraError
        If FFmpeg is not installed or cannot be run.
    """
    try:
        program: str = library("imageio_ffmpeg").get_ffmpeg_exe()
        subprocess.run([program, "-version"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except (RuntimeError, OSError, subprocess.CalledProcessError) as error:
        raise MissingExtraError("an MP4", "mp4") from error
    return program
