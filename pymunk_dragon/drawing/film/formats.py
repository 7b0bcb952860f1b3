"""Writers of film files: Pillow's for GIF, APNG and WebP, and FFmpeg for MP4.

imageio's writer of MP4 does not check whether FFmpeg succeeded.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from pymunk_dragon._extras import library
from pymunk_dragon.errors import MissingExtraError, ParameterError

# Frames per second in a GIF, whose delays are whole centiseconds: browsers replace a delay of one by ten.
MAX_GIF_FPS = 50
# Pixels of all frames, which Pillow keeps in memory: 1 GB, or 5000 frames of the default size.
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
    """Write a GIF that repeats without end; all frames are in memory."""
    if frames.fps > MAX_GIF_FPS:
        raise ParameterError("fps", frames.fps, f"at most {MAX_GIF_FPS} in a GIF")
    # A frame is drawn over the one before, and lasts whole centiseconds.
    delays = [10 * delay for delay in frames.durations(100)]
    _save_all(path, frames, "GIF", delays, disposal=1, optimize=False)


def write_apng(path: Path, frames: Frames) -> None:
    """Write an animated PNG that repeats without end; all frames are in memory."""
    _save_all(path, frames, "PNG", frames.durations(1000))


def write_webp(path: Path, frames: Frames) -> None:
    """Write a lossless animated WebP that repeats without end, as fast as libwebp can; all frames are in memory."""
    _save_all(path, frames, "WEBP", frames.durations(1000), lossless=True, method=0, quality=0, kmin=0, kmax=0)


def _save_all(path: Path, frames: Frames, format: str, delays: list[int], **options: float) -> None:
    """Write a film with Pillow, which merges equal frames; a ParameterError if it is too large."""
    width, height = frames.size
    most = MAX_PIXELS // (width * height)
    if len(frames.ends) > most:
        bound = f"at most {most} in a file {path.suffix} of {width} x {height} pixels, or in an MP4"
        raise ParameterError("number of frames", len(frames.ends), bound)
    first, *others = frames
    # Pillow leaves a file open that it opened itself if Ctrl-C interrupts it.
    with path.open("wb") as file:
        first.save(file, format, save_all=True, append_images=others, duration=delays, loop=0, **options)


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
