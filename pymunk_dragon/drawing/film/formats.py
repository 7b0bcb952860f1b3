"""Writers of film files.

imageio writes MP4, by FFmpeg, and WebP, by Pillow. GIFs are written here, with Pillow's compression
of single frames: imageio takes five times as long, and keeps all frames in memory.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, repeat
from logging import ERROR, getLogger
from pathlib import Path
from traceback import clear_frames
from typing import Any

import numpy as np
from PIL import GifImagePlugin, Image, ImageChops

from pymunk_dragon._extras import library
from pymunk_dragon.errors import MissingExtraError, ParameterError

# Frames per second in a GIF, whose delays are whole centiseconds: browsers replace a delay of one
# by ten.
_MAX_GIF_FPS = 50
# Index of an unchanged pixel in a GIF: tables of films have at most 255 colours.
_TRANSPARENT = 255
# GIF disposal method: the next frame is drawn over this one.
_KEEP = 1
# x264 options. CRF 18 has no visible loss. The preset "veryfast" takes 8 ms per frame of 640 x 640
# pixels with 223 benches on 2 cores; the default preset takes 14 ms and saves a seventh. One thread
# makes the file independent of the number of cores; a look-ahead of 5 frames saves memory.
_QUALITY = "-crf 18 -preset veryfast -x264-params rc-lookahead=5 -threads 1"
# FFmpeg filters: the colour space is BT.709 and is written to the file, so that players need not
# guess.
_FILTERS = "scale=out_color_matrix=bt709:out_range=tv"
_FILTERS += ",setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709"
# FFmpeg options: the index before the data, so that a browser can play an incomplete download; and
# no encoder version or date in the file.
_FORMAT = f"-vf {_FILTERS} -movflags +faststart -fflags +bitexact -flags:v +bitexact"
# imageio options of an MP4. imageio chooses neither the quality, which is among the x264 options,
# nor the size, which is even. Its plugin for PyAV has no parameter for the quality, and takes no
# iterator.
_MP4_OPTIONS: dict[str, Any] = {
    "plugin": "FFMPEG",
    "is_batch": True,
    "codec": "libx264",
    "quality": None,
    "macro_block_size": 1,
    "ffmpeg_log_level": "quiet",
    "output_params": f"{_QUALITY} {_FORMAT}".split(),
}
# Bytes: more than the index of an MP4 has, which needs less than 40 for each of 24,000 frames.
_MAX_INDEX = 4_000_000
# Bytes of memory for the frames of a WebP, all of which imageio and Pillow need at once: half of
# the memory of a small computer, or 1,100 frames of 440 x 501 pixels.
_MAX_WEBP_MEMORY = 1_000_000_000
# Bytes of memory per pixel of a WebP (mode RGBA).
_WEBP_PIXEL = 4
# Pixels: the largest width and height that the format has.
_MAX_WEBP_LENGTH = 16_383
# imageio options of a WebP: all pixels keep their colours. Method 1 with quality 25 (of a lossless
# file, this is the effort) takes 20 ms per frame of 640 x 734 pixels with 223 benches, and the file
# is an eighth smaller than the GIF; with less effort, it is larger than the GIF. Without key frames
# (kmin, kmax), a frame is encoded once, as the difference to the frame before. Loop 0 repeats
# without end.
_WEBP_OPTIONS: dict[str, Any] = {
    "is_batch": True,
    "lossless": True,
    "method": 1,
    "quality": 25,
    "kmin": 0,
    "kmax": 0,
    "loop": 0,
}


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames of a film, which can be read once.

    The F `pictures` (mode P) have one table of at most 255 colours, and are drawn while they are
    read; `ends` (F,) are the film times, s, until which they are shown. `size` is that of the film,
    pixels, for which pictures are cropped; `fps` is the number of frames per second.
    """

    pictures: Iterator[Image.Image]
    ends: Sequence[float]
    size: tuple[int, int]
    fps: int

    def pixels(self, mode: str) -> Iterator[np.ndarray[Any, Any]]:
        """Yield the pixels of each frame, cropped to the size, in a mode of Pillow."""
        for picture in self.pictures:
            cropped = picture.crop((0, 0, *self.size))
            yield np.asarray(cropped.convert(mode))

    def durations(self, ticks: int) -> list[int]:
        """Durations of the frames, in 1 / `ticks` s, whose rounding does not accumulate."""
        ends = [round(end * ticks) for end in self.ends]
        return np.diff(ends, prepend=0).tolist()


def written_size(ending: str, size: tuple[int, int]) -> tuple[int, int]:
    """Size, pixels, of pictures of a size in a file with an ending.

    An MP4 has colours at half of the resolution, so its sizes are even.
    """
    if ending != ".mp4":
        return size
    width, height = size
    return width - width % 2, height - height % 2


def _write_gif(path: Path, frames: Frames) -> None:
    """Write a GIF that repeats without end: of each frame the pixels that differ from before.

    Two frames are in memory.
    """
    if frames.fps > _MAX_GIF_FPS:
        raise ParameterError("fps", frames.fps, f"at most {_MAX_GIF_FPS} in a GIF")
    before: Image.Image | None = None
    with path.open("wb") as file:
        for picture, delay in zip(frames.pictures, frames.durations(100), strict=True):
            shown = picture.copy()
            box = (0, 0, *frames.size)
            if before is None:
                file.writelines(GifImagePlugin.getheader(shown, info={"loop": 0})[0])
            else:
                change = ImageChops.subtract_modulo(picture, before)
                unchanged = change.point([255, *(0,) * 255], "1")
                shown.paste(_TRANSPARENT, mask=unchanged)
                # A frame that is equal is one pixel.
                box = change.getbbox() or (0, 0, 1, 1)
            # Pillow takes the delay in ms.
            options = {"transparency": _TRANSPARENT, "disposal": _KEEP, "duration": 10 * delay}
            file.writelines(GifImagePlugin.getdata(shown.crop(box), box[:2], **options))
            before = picture
        file.write(b";")


def _write_mp4(path: Path, frames: Frames) -> None:
    """Write an MP4 with a constant frame rate. A frame that is shown longer is repeated.

    One frame is in memory.

    A `MissingExtraError` is raised if FFmpeg is not found, an `OSError` if it does not write all
    frames.
    """
    library("imageio_ffmpeg")

    # Here, because it takes 25 ms, and most uses of `drawing` write no film.
    from imageio import v3 as iio

    counts = [max(1, count) for count in frames.durations(frames.fps)]
    # imageio takes an iterator, but its annotations do not say so.
    pixels: Any = chain.from_iterable(map(repeat, frames.pixels("RGB"), counts))

    # imageio_ffmpeg warns of an FFmpeg that has ended early, which is an error here.
    getLogger("imageio_ffmpeg").setLevel(ERROR)
    try:
        iio.imwrite(path, pixels, fps=frames.fps, **_MP4_OPTIONS)
    except (RuntimeError, FileNotFoundError, PermissionError) as error:
        raise MissingExtraError("an MP4", "mp4") from error
    except OSError as error:
        # The message of imageio is long.
        raise OSError("FFmpeg failed") from error
    except BaseException as error:
        # After an error of a frame, imageio ends FFmpeg when nothing refers to its writer any more.
        clear_frames(error.__traceback__)
        raise
    # imageio does not check whether FFmpeg succeeded.
    if _frame_count(path) != sum(counts):
        raise OSError("FFmpeg failed")


def _frame_count(path: Path) -> int:
    """Number of frames in the index of an MP4; 0 if the file is not complete.

    FFmpeg writes the index last, although it is before the data. So an index before complete data
    proves that FFmpeg succeeded, and no frame needs to be decoded.
    """
    with path.open("rb") as file:
        content = file.read(_MAX_INDEX)
    # A box begins with its size and its name, of 4 bytes each; "stsz" has the number of frames.
    index = content.find(b"stsz")
    data = content.find(b"mdat") - 4
    size = int.from_bytes(content[data : data + 4])
    if size == 1:
        # Data of 4 GB or more.
        size = int.from_bytes(content[data + 8 : data + 16])
    if not 0 <= index < data or data + size != path.stat().st_size:
        return 0
    # The version and the size that all frames share are before the number.
    return int.from_bytes(content[index + 12 : index + 16])


def _write_webp(path: Path, frames: Frames) -> None:
    """Write an animated WebP that repeats without end. All frames are in memory."""
    from imageio import v3 as iio

    count = len(frames.ends)
    width, height = frames.size
    if max(frames.size) > _MAX_WEBP_LENGTH:
        bound = f"at most {_MAX_WEBP_LENGTH} pixels wide and high in a WebP"
        raise ParameterError("size", frames.size, bound)
    if count * width * height * _WEBP_PIXEL > _MAX_WEBP_MEMORY:
        limit = f"at most {_MAX_WEBP_MEMORY / 1e9:g} GB of memory"
        bound = f"such that the {count} frames of a WebP need {limit}"
        raise ParameterError("size", frames.size, bound)

    pixels = np.empty((count, height, width, _WEBP_PIXEL), np.uint8)
    for kept, drawn in zip(pixels, frames.pixels("RGBA"), strict=True):
        kept[:] = drawn

    writer = iio.imopen("<bytes>", "w", plugin="pillow", extension=".webp")
    try:
        content: Any = writer.write(pixels, duration=frames.durations(1000), **_WEBP_OPTIONS)
    finally:
        # After an interruption, imageio would encode these frames again when it closes its file.
        writer.images_to_write.clear()
        writer.close()
    path.write_bytes(content)


# Writer of each format, by the ending of its files in lower case.
WRITERS: dict[str, Callable[[Path, Frames], None]] = {
    ".gif": _write_gif,
    ".mp4": _write_mp4,
    ".webp": _write_webp,
}
