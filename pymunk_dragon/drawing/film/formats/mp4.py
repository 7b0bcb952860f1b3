"""MP4 writer: H.264 by the FFmpeg of imageio.

imageio's own writer runs the same program but does not check its exit code. FFmpeg writes most of the file at the end,
so imageio's writer does not detect a full disk.
"""

from __future__ import annotations

import subprocess
from contextlib import suppress
from pathlib import Path

import numpy as np

from pymunk_dragon._extras import library
from pymunk_dragon.drawing.film.formats.frames import Frames
from pymunk_dragon.errors import MissingExtraError

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


def write_mp4(path: Path, frames: Frames) -> None:
    """Write an MP4 with a constant frame rate; one frame is in memory. A frame that is shown longer is repeated.

    Raises
    ------
    MissingExtraError
        If FFmpeg is not installed or cannot be run.
    OSError
        If FFmpeg fails; the message is the first line of FFmpeg's messages.
    """
    # Chroma at half resolution needs even sizes, so an odd width or height repeats its last column or row.
    width, height = frames.size
    padding = ((0, height % 2), (0, width % 2), (0, 0))
    size = f"{width + width % 2}x{height + height % 2}"
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(frames.fps), "-i", "-"]
    with subprocess.Popen(
        [_ffmpeg(), "-v", "error", "-y", *source, "-c:v", "libx264", *QUALITY, *FORMAT, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        # Ctrl-C must not reach FFmpeg: this process handles the interrupt and then ends FFmpeg.
        start_new_session=True,
    ) as process:
        assert process.stdin is not None  # It is a pipe.
        try:
            written = 0
            # FFmpeg closes its input only if it fails, and its messages tell why.
            with suppress(BrokenPipeError):
                for picture, end in zip(frames.coloured(), frames.ends, strict=True):
                    pixels = np.pad(np.asarray(picture.convert("RGB")), padding, mode="edge").tobytes()
                    last = max(written + 1, round(end * frames.fps))
                    for _ in range(written, last):
                        process.stdin.write(pixels)
                    written = last
            _, messages = process.communicate()
        except BaseException:
            process.kill()
            process.communicate()
            raise
        if process.returncode != 0:
            lines = messages.decode("utf-8", "replace").splitlines()
            raise OSError(lines[0] if lines else f"FFmpeg ended with {process.returncode}")


def _ffmpeg() -> str:
    """Return the path of the FFmpeg program."""
    try:
        program: str = library("imageio_ffmpeg").get_ffmpeg_exe()
        subprocess.run([program, "-version"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except (RuntimeError, OSError, subprocess.CalledProcessError) as error:
        raise MissingExtraError("an MP4", "mp4") from error
    return program
