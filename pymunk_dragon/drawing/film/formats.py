"""Writers of film files: Pillow's compression of frames for GIF, and FFmpeg for MP4.

Pillow's own writer of GIFs keeps all frames in memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from logging import ERROR, getLogger
from pathlib import Path

from PIL import GifImagePlugin, Image, ImageChops

from pymunk_dragon._extras import library
from pymunk_dragon._signals import signals_held
from pymunk_dragon.errors import MissingExtraError, ParameterError

# Frames per second in a GIF, whose delays are whole centiseconds: browsers replace a delay of one by ten.
_MAX_GIF_FPS = 50
# Index of an unchanged pixel in a GIF: tables of films have at most 255 colours.
_TRANSPARENT = 255
# GIF disposal method: the next frame is drawn over this one.
_KEEP = 1
# x264 options. CRF 18 has no visible loss. The preset "veryfast" takes 8 ms per frame of 640 x 640 pixels with 223
# benches on 2 cores; the default preset takes 14 ms and saves a seventh. One thread makes the file independent of the
# number of cores; a look-ahead of 5 frames saves memory.
_QUALITY = "-crf 18 -preset veryfast -x264-params rc-lookahead=5 -threads 1"
# FFmpeg filters: the colour space is BT.709 and is written to the file, so that players need not guess.
_FILTERS = "scale=out_color_matrix=bt709:out_range=tv"
_FILTERS += ",setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709"
# FFmpeg options: the index before the data, so that a browser can play an incomplete download; and no encoder version
# or date in the file.
_FORMAT = f"-vf {_FILTERS} -movflags +faststart -fflags +bitexact -flags:v +bitexact"


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames of a film, which can be read once.

    The F `pictures` (mode P) have one table of at most 255 colours, and are drawn while they are read; `ends` (F,) are
    the film times, s, until which they are shown. `size` is that of the film, pixels, for which pictures are cropped;
    `fps` is the number of frames per second.
    """

    pictures: Iterator[Image.Image]
    ends: Sequence[float]
    size: tuple[int, int]
    fps: int

    def durations(self, ticks: int) -> list[int]:
        """Return how long each frame is shown, in units of 1 / `ticks` s, such that rounding does not accumulate."""
        ends = [round(end * ticks) for end in self.ends]
        return [end - start for start, end in zip([0, *ends], ends, strict=False)]


def written_size(ending: str, size: tuple[int, int]) -> tuple[int, int]:
    """Return the size, pixels, of pictures of a size in a file with an ending.

    An MP4 has colours at half of the resolution, so its sizes are even.
    """
    if ending != ".mp4":
        return size
    width, height = size
    return width - width % 2, height - height % 2


def _write_gif(path: Path, frames: Frames) -> None:
    """Write a GIF: of each frame the pixels that differ from the one before. Two frames are in memory."""
    if frames.fps > _MAX_GIF_FPS:
        raise ParameterError("fps", frames.fps, f"at most {_MAX_GIF_FPS} in a GIF")
    before: Image.Image | None = None
    with path.open("wb") as file:
        for picture, delay in zip(frames.pictures, frames.durations(100), strict=True):
            shown, box = picture.copy(), (0, 0, *frames.size)
            if before is None:
                file.writelines(GifImagePlugin.getheader(shown, info={"loop": 0})[0])
            else:
                change = ImageChops.subtract_modulo(picture, before)
                shown.paste(_TRANSPARENT, mask=change.point([255, *(0,) * 255], "1"))
                # A frame that is equal is one pixel.
                box = change.getbbox() or (0, 0, 1, 1)
            # Pillow takes the delay in ms.
            options = {"transparency": _TRANSPARENT, "disposal": _KEEP, "duration": 10 * delay}
            file.writelines(GifImagePlugin.getdata(shown.crop(box), box[:2], **options))
            before = picture
        file.write(b";")


def _write_mp4(path: Path, frames: Frames) -> None:
    """Write an MP4 with a constant frame rate; one frame is in memory. A frame that is shown longer is repeated.

    A `MissingExtraError` is raised if FFmpeg is not found, an `OSError` if it does not write all frames.
    """
    ffmpeg, counts = library("imageio_ffmpeg"), [max(1, count) for count in frames.durations(frames.fps)]
    options = {"fps": frames.fps, "codec": "libx264", "quality": None, "macro_block_size": 1, "ffmpeg_timeout": 0}
    options |= {"ffmpeg_log_level": "quiet", "output_params": f"{_QUALITY} {_FORMAT}".split()}
    getLogger("imageio_ffmpeg").setLevel(ERROR)  # It warns of a film that was interrupted before its first frame.
    with closing(ffmpeg.write_frames(str(path), frames.size, **options)) as writer:
        try:
            with signals_held():  # Those of a fork cannot be raised.
                writer.send(None)
        except (RuntimeError, FileNotFoundError, PermissionError) as error:
            raise MissingExtraError("an MP4", "mp4") from error
        try:
            for picture, count in zip(frames.pictures, counts, strict=True):
                pixels = picture.crop((0, 0, *frames.size)).convert("RGB").tobytes()
                for _ in range(count):
                    writer.send(pixels)
            writer.close()
            # imageio does not check whether FFmpeg succeeded.
            whole = ffmpeg.count_frames_and_secs(str(path))[0] == sum(counts)
        except (OSError, RuntimeError) as error:
            # The message of imageio is long.
            raise OSError("FFmpeg failed") from error
    if not whole:
        raise OSError("FFmpeg failed")


# Writer of each format, by the ending of its files in lower case. A GIF repeats without end.
WRITERS: dict[str, Callable[[Path, Frames], None]] = {".gif": _write_gif, ".mp4": _write_mp4}
