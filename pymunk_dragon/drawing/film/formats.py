"""Writers of film files: Pillow's for WebP and APNG, Pillow's compression of frames for GIF, and FFmpeg for MP4.

The GIFs of the gallery have 12 MB by `write_gif`, and 17 MB by Pillow's own writer, which makes every unchanged pixel
transparent. imageio's writer of MP4 does not check whether FFmpeg succeeded.
"""

from __future__ import annotations

import struct
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image, ImageChops

from pymunk_dragon._extras import library
from pymunk_dragon.errors import MissingExtraError, ParameterError

# Frames per second in a GIF, whose delays are whole centiseconds: browsers replace a delay of one by ten.
MAX_GIF_FPS = 50
# Centiseconds: longest delay, an unsigned number of 16 bits.
MAX_DELAY = 0xFFFF
# Index of an unchanged pixel in a GIF: tables of films have at most 255 colours.
TRANSPARENT = 255
# GIF disposal method: the next frame is drawn over this one.
KEEP = 1
# Flags of the screen descriptor: a global table of 2^(7 + 1) colours.
GLOBAL_TABLE = 0xF7
# Application extension: the film repeats without end.
REPEAT = b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"
# Base-2 logarithm of the shortest run of unchanged pixels that is stored as transparent. Shorter runs interrupt
# repeated patterns: with runs of 16 pixels the GIF of the reference scenario is a seventh smaller than with runs of 1.
RUN_DOUBLINGS = 4
# Pixels of all frames of a WebP or APNG, which Pillow keeps in memory: 1 GB, or 5000 frames of the default size.
MAX_PIXELS = 1_000_000_000
# x264 options. CRF 18 has no visible loss. The preset "veryfast" takes 8 ms per frame of 640 x 640 pixels with 223
# benches on 2 cores; the default preset takes 14 ms and saves a seventh. One thread makes the file independent of the
# number of cores; a look-ahead of 5 frames saves memory.
QUALITY = "-crf 18 -preset veryfast -x264-params rc-lookahead=5 -threads 1"
# FFmpeg filter: the colour space is BT.709 and is written to the file, so that players need not guess.
COLOURS = "scale=out_color_matrix=bt709:out_range=tv,setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709"
# FFmpeg options: chroma at half resolution, which every player supports; the index before the data, so that a browser
# can play an incomplete download; and no encoder version or date in the file.
FORMAT = f"-pix_fmt yuv420p -vf {COLOURS} -movflags +faststart -fflags +bitexact -flags:v +bitexact"


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames of a film, which can be read once.

    The F `pictures` (mode P) have one table of at most 255 colours, and are drawn while they are read; `ends` (F,) are
    the film times, s, until which they are shown. `size` is in pixels, `fps` the number of frames per second.
    `progress` is called with the number of pictures that were read, and of all.
    """

    pictures: Iterator[Image.Image]
    ends: Sequence[float]
    size: tuple[int, int]
    fps: int
    progress: Callable[[int, int], None] | None = None

    def __iter__(self) -> Iterator[Image.Image]:
        for done, picture in enumerate(self.pictures, start=1):
            if self.progress is not None:
                self.progress(done, len(self.ends))
            yield picture

    def durations(self, ticks: int) -> list[int]:
        """Return how long each frame is shown, in units of 1 / `ticks` s, such that rounding does not accumulate."""
        ends = [round(end * ticks) for end in self.ends]
        return [end - start for start, end in zip([0, *ends], ends, strict=False)]


def write_gif(path: Path, frames: Frames) -> None:
    """Write a GIF that repeats without end; two frames are in memory. A frame is shown at most 655 s."""
    if frames.fps > MAX_GIF_FPS:
        raise ParameterError("fps", frames.fps, f"at most {MAX_GIF_FPS} in a GIF")
    before: Image.Image | None = None
    with path.open("wb") as file:
        timed = zip(frames, frames.durations(100), strict=True)
        for _, equal in groupby(timed, lambda frame: frame[0].tobytes()):
            (picture, delay), *others = equal
            delay = min(delay + sum(more for _, more in others), MAX_DELAY)
            if before is None:
                table = bytes(picture.getpalette() or ()).ljust(3 * 256, b"\0")
                file.write(b"GIF89a" + struct.pack("<HHBBB", *frames.size, GLOBAL_TABLE, 0, 0) + table + REPEAT)
            pixels, corner = _change(picture, before)
            # Pillow takes the delay in ms.
            options = {"transparency": TRANSPARENT, "disposal": KEEP, "duration": 10 * delay}
            file.writelines(GifImagePlugin.getdata(pixels, corner, **options))
            before = picture
        file.write(b";")


def _change(picture: Image.Image, before: Image.Image | None) -> tuple[Image.Image, tuple[int, int]]:
    """Return the rectangle in which `picture` differs, with unchanged pixels transparent, and its upper left corner."""
    indices = Image.frombytes("L", picture.size, picture.tobytes())
    if before is None:
        return indices, (0, 0)
    old = Image.frombytes("L", before.size, before.tobytes())
    box = ImageChops.difference(indices, old).getbbox() or (0, 0, 1, 1)
    new = np.asarray(indices.crop(box))
    unchanged = _long_runs(new == np.asarray(old.crop(box)))
    return Image.fromarray((new & ~unchanged) | (np.uint8(TRANSPARENT) & unchanged)), box[:2]


def _long_runs(same: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return 255 where a pixel of `same` is in a run of at least 2^RUN_DOUBLINGS true pixels, 0 elsewhere.

    Runs continue from one line to the next. All pixels are bits of one large integer, which is shifted as a whole.
    """
    bits = np.packbits(same)
    runs = int.from_bytes(bits.tobytes())
    steps = [2**i for i in range(RUN_DOUBLINGS)]
    for step in steps:
        # After this loop, a bit is set where a long run begins.
        runs &= runs << step
    for step in steps:
        runs |= runs >> step
    # Discard the bits that were shifted beyond the picture.
    kept = (runs & ((1 << 8 * bits.size) - 1)).to_bytes(bits.size)
    return -np.unpackbits(np.frombuffer(kept, dtype=np.uint8), count=same.size).reshape(same.shape)


def write_apng(path: Path, frames: Frames) -> None:
    """Write an animated PNG that repeats without end; all frames are in memory."""
    _save_all(path, frames, "PNG")


def write_webp(path: Path, frames: Frames) -> None:
    """Write a lossless animated WebP that repeats without end, as fast as libwebp can; all frames are in memory."""
    _save_all(path, frames, "WEBP", lossless=True, method=0, quality=0, kmin=0, kmax=0)


def _save_all(path: Path, frames: Frames, format: str, **options: float) -> None:
    """Write a film with Pillow, which merges equal frames; a ParameterError if it is too large."""
    width, height = frames.size
    most = MAX_PIXELS // (width * height)
    if len(frames.ends) > most:
        bound = f"at most {most} in a file {path.suffix} of {width} x {height} pixels, or in a GIF or MP4"
        raise ParameterError("number of frames", len(frames.ends), bound)
    first, *others = frames
    # Pillow leaves a file open that it opened itself if Ctrl-C interrupts it.
    with path.open("wb") as file:
        first.save(
            file, format, save_all=True, append_images=others, duration=frames.durations(1000), loop=0, **options
        )


def write_mp4(path: Path, frames: Frames) -> None:
    """Write an MP4 with a constant frame rate; one frame is in memory. A frame that is shown longer is repeated.

    A `MissingExtraError` is raised if FFmpeg cannot be run, an `OSError` with its first message if it fails.
    """
    # Chroma at half resolution needs even sizes, so an odd width or height repeats its last column or row.
    width, height = frames.size
    padding = ((0, height % 2), (0, width % 2), (0, 0))
    source = f"-f rawvideo -pix_fmt rgb24 -s {width + width % 2}x{height + height % 2} -r {frames.fps} -i -"
    options = f"-v error -y {source} -c:v libx264 {QUALITY} {FORMAT}".split()
    with subprocess.Popen(
        [_ffmpeg(), *options, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        # Ctrl-C must not reach FFmpeg: this process handles the interrupt and then ends FFmpeg.
        start_new_session=True,
    ) as process:
        assert process.stdin is not None  # It is a pipe.
        try:
            # FFmpeg closes its input only if it fails, and its messages tell why.
            with suppress(BrokenPipeError):
                for picture, count in zip(frames, frames.durations(frames.fps), strict=True):
                    pixels = np.pad(np.asarray(picture.convert("RGB")), padding, mode="edge").tobytes()
                    for _ in range(max(1, count)):
                        process.stdin.write(pixels)
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


# Writer of each format, by the ending of its files in lower case.
WRITERS: dict[str, Callable[[Path, Frames], None]] = {
    ".gif": write_gif,
    ".apng": write_apng,
    ".webp": write_webp,
    ".mp4": write_mp4,
}
