"""Writers of film files: Pillow's for WebP and APNG, Pillow's compression of frames for GIF, and FFmpeg for MP4.

The GIFs of the gallery have 12 MB by `_write_gif`, and 17 MB by Pillow's own writer, which makes every unchanged pixel
transparent. imageio's writer of MP4 does not check whether FFmpeg succeeded.
"""

from __future__ import annotations

import struct
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image

from pymunk_dragon._extras import library
from pymunk_dragon.errors import MissingExtraError, ParameterError

# Frames per second in a GIF, whose delays are whole centiseconds: browsers replace a delay of one by ten.
_MAX_GIF_FPS = 50
# Centiseconds: longest delay, an unsigned number of 16 bits.
_MAX_DELAY = 0xFFFF
# Index of an unchanged pixel in a GIF: tables of films have at most 255 colours.
_TRANSPARENT = 255
# GIF disposal method: the next frame is drawn over this one.
_KEEP = 1
# Flags of the screen descriptor: a global table of 2^(7 + 1) colours.
_GLOBAL_TABLE = 0xF7
# Application extension: the film repeats without end.
_REPEAT = b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"
# Pixels: shortest run of unchanged pixels that is stored as transparent. Shorter runs interrupt repeated patterns: with
# runs of 16 pixels the GIF of the reference scenario is a seventh smaller than with runs of 1.
_SHORTEST_RUN = 16
# Pixels of all frames of a WebP or APNG, which Pillow keeps in memory: 1 GB, or 5000 frames of the default size.
_MAX_PIXELS = 1_000_000_000
# x264 options. CRF 18 has no visible loss. The preset "veryfast" takes 8 ms per frame of 640 x 640 pixels with 223
# benches on 2 cores; the default preset takes 14 ms and saves a seventh. One thread makes the file independent of the
# number of cores; a look-ahead of 5 frames saves memory.
_QUALITY = "-crf 18 -preset veryfast -x264-params rc-lookahead=5 -threads 1"
# FFmpeg filter: the colour space is BT.709 and is written to the file, so that players need not guess.
_COLOURS = "scale=out_color_matrix=bt709:out_range=tv,setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709"
# FFmpeg options: chroma at half resolution, which every player supports; the index before the data, so that a browser
# can play an incomplete download; and no encoder version or date in the file.
_FORMAT = f"-pix_fmt yuv420p -vf {_COLOURS} -movflags +faststart -fflags +bitexact -flags:v +bitexact"


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames of a film, which can be read once.

    The F `pictures` (mode P) have one table of at most 255 colours, and are drawn while they are read; `ends` (F,) are
    the film times, s, until which they are shown. `size` is in pixels, `fps` the number of frames per second.
    """

    pictures: Iterator[Image.Image]
    ends: Sequence[float]
    size: tuple[int, int]
    fps: int

    def durations(self, ticks: int) -> list[int]:
        """Return how long each frame is shown, in units of 1 / `ticks` s, such that rounding does not accumulate."""
        ends = [round(end * ticks) for end in self.ends]
        return [end - start for start, end in zip([0, *ends], ends, strict=False)]


def _write_gif(path: Path, frames: Frames) -> None:
    """Write a GIF; two frames are in memory. A frame is shown at most 655 s."""
    if frames.fps > _MAX_GIF_FPS:
        raise ParameterError("fps", frames.fps, f"at most {_MAX_GIF_FPS} in a GIF")
    before: Image.Image | None = None
    with path.open("wb") as file:
        timed = zip(frames.pictures, frames.durations(100), strict=True)
        for _, equal in groupby(timed, lambda frame: frame[0].tobytes()):
            (picture, delay), *others = equal
            delay = min(delay + sum(more for _, more in others), _MAX_DELAY)
            if before is None:
                table = bytes(picture.getpalette() or ()).ljust(3 * 256, b"\0")
                file.write(b"GIF89a" + struct.pack("<HHBBB", *frames.size, _GLOBAL_TABLE, 0, 0) + table + _REPEAT)
            pixels, corner = _change(picture, before)
            # Pillow takes the delay in ms.
            options = {"transparency": _TRANSPARENT, "disposal": _KEEP, "duration": 10 * delay}
            file.writelines(GifImagePlugin.getdata(pixels, corner, **options))
            before = picture
        file.write(b";")


def _change(picture: Image.Image, before: Image.Image | None) -> tuple[Image.Image, tuple[int, int]]:
    """Return the rectangle in which `picture` differs, with unchanged pixels transparent, and its upper left corner."""
    indices = np.asarray(picture)
    if before is None:
        return Image.fromarray(indices), (0, 0)
    difference = Image.fromarray(indices ^ np.asarray(before))
    left, top, right, bottom = box = difference.getbbox() or (0, 0, 1, 1)
    unchanged = _long_runs(np.asarray(difference.crop(box)) == 0)
    # The maximum, because the index of an unchanged pixel is the largest one.
    return Image.fromarray(np.maximum(indices[top:bottom, left:right], _TRANSPARENT * unchanged)), box[:2]


def _long_runs(same: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return 1 for each pixel in a long run of true pixels of `same`, else 0; runs continue on the next line."""
    pixels = same.ravel()
    begins = np.flatnonzero(np.diff(pixels, prepend=~pixels[0]))
    lengths = np.diff(begins, append=pixels.size)
    return np.repeat(pixels[begins] & (lengths >= _SHORTEST_RUN), lengths).reshape(same.shape).view(np.uint8)


def _write_with_pillow(path: Path, frames: Frames, *, format: str, **options: float) -> None:
    """Write a film whose frames are all in memory; Pillow merges equal ones. A ParameterError if it is too large."""
    width, height = frames.size
    most = _MAX_PIXELS // (width * height)
    if len(frames.ends) > most:
        bound = f"at most {most} in a file {path.suffix} of {width} x {height} pixels, or in a GIF or MP4"
        raise ParameterError("number of frames", len(frames.ends), bound)
    first, *others = frames.pictures
    options |= {"save_all": True, "loop": 0}
    # Pillow leaves a file open that it opened itself if Ctrl-C interrupts it.
    with path.open("wb") as file:
        first.save(file, format, append_images=others, duration=frames.durations(1000), **options)


def _write_mp4(path: Path, frames: Frames) -> None:
    """Write an MP4 with a constant frame rate; one frame is in memory. A frame that is shown longer is repeated.

    A `MissingExtraError` is raised if FFmpeg is not found, an `OSError` with its first message if it fails.
    """
    # Chroma at half resolution needs even sizes, so an odd width or height repeats its last column or row.
    width, height = frames.size
    padding = ((0, height % 2), (0, width % 2), (0, 0))
    source = f"-f rawvideo -pix_fmt rgb24 -s {width + width % 2}x{height + height % 2} -r {frames.fps} -i -"
    options = f"-v error -y {source} -c:v libx264 {_QUALITY} {_FORMAT}".split()
    try:
        command, pipe = [library("imageio_ffmpeg").get_ffmpeg_exe(), *options, str(path)], subprocess.PIPE
        # In a session of its own, Ctrl-C does not reach FFmpeg: this process handles it and then ends FFmpeg.
        process = subprocess.Popen(command, stdin=pipe, stderr=pipe, start_new_session=True)
    except (RuntimeError, OSError) as error:
        raise MissingExtraError("an MP4", "mp4") from error
    with process:
        assert process.stdin is not None  # It is a pipe.
        try:
            # FFmpeg closes its input only if it fails, and its messages tell why.
            with suppress(BrokenPipeError):
                for picture, count in zip(frames.pictures, frames.durations(frames.fps), strict=True):
                    pixels = np.pad(np.asarray(picture.convert("RGB")), padding, mode="edge").tobytes()
                    process.stdin.writelines([pixels] * max(1, count))
            _, messages = process.communicate()
        except BaseException:
            process.kill()
            process.communicate()
            raise
    if process.returncode != 0:
        lines = messages.decode("utf-8", "replace").splitlines()
        raise OSError(lines[0] if lines else f"FFmpeg ended with {process.returncode}")


# Writer of each format, by the ending of its files in lower case. Films repeat without end. WebP is lossless, and
# written as fast as libwebp can.
WRITERS: dict[str, Callable[[Path, Frames], None]] = {
    ".gif": _write_gif,
    ".apng": partial(_write_with_pillow, format="PNG"),
    ".webp": partial(_write_with_pillow, format="WEBP", lossless=True, method=0, quality=0, kmin=0, kmax=0),
    ".mp4": _write_mp4,
}
