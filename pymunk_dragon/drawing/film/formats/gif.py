"""GIF writer.

Pillow compresses each frame (`GifImagePlugin.getdata`); this module writes the blocks to the file. Pillow's own writer
of animations keeps all frames in memory. It also makes single unchanged pixels transparent, which compresses worse than
long runs (see `RUN_DOUBLINGS`). Time to encode 300 frames of 640 x 640 pixels with 223 benches (Pillow 13, imageio
2.38, 2 cores):

=======================================  ==========  =====  ==================================================
encoder                                  ms a frame  MB     memory
=======================================  ==========  =====  ==================================================
this module                              2.1         7.4    two frames
Pillow, `save_all`                       3.6         9.0    175 MB, grows with the film
imageio.v3.imopen, palette indices       31          10.2   188 MB, grows with the film
imageio.v3.imopen, RGB                   32          8.9    555 MB, grows with the film
imageio.v2, GIF-PIL (legacy), RGB        35          10.8   one frame, each with a palette and quantiser of its own
=======================================  ==========  =====  ==================================================
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image, ImageChops

from pymunk_dragon.drawing.film.formats.frames import Frames
from pymunk_dragon.drawing.palette import TRANSPARENT
from pymunk_dragon.errors import ParameterError

# Ticks per second: delays in a GIF are whole centiseconds.
TICKS = 100
# Frames per second: browsers replace a delay of 1 centisecond by 10.
MAX_FPS = 50
# Ticks: longest delay, an unsigned number of 16 bits.
MAX_DELAY = 0xFFFF
# GIF disposal method: the next frame is drawn over this one.
KEEP = 1
# Bytes of the delay in a frame from Pillow, which begins with the graphic control extension.
DELAY = slice(4, 6)
# Flags of the screen descriptor: a global table of 2^(7 + 1) colours.
GLOBAL_TABLE = 0xF7
# Application extension: the film repeats without end.
REPEAT = b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"
# Base-2 logarithm of the shortest run of unchanged pixels that is stored as transparent. Shorter runs interrupt
# repeated patterns and compress worse: with runs of 16 pixels the GIF of the reference scenario is a seventh smaller
# than with runs of 1; 8 and 32 pixels gave no further gain.
RUN_DOUBLINGS = 4


def write_gif(path: Path, frames: Frames) -> None:
    """Write a GIF that repeats without end; two frames are in memory.

    Raises
    ------
    ParameterError
        If browsers would slow the film down.
    """
    if frames.fps > MAX_FPS:
        raise ParameterError("fps", frames.fps, f"at most {MAX_FPS} in a GIF")
    with path.open("wb") as file:
        file.write(
            b"GIF89a" + struct.pack("<HHBBB", *frames.size, GLOBAL_TABLE, 0, 0) + frames.colours.tobytes() + REPEAT
        )
        for change, delay in _timed_changes(frames):
            change[DELAY] = struct.pack("<H", delay)
            file.write(change)
        file.write(b";")


def _timed_changes(frames: Frames) -> Iterator[tuple[bytearray, int]]:
    """Yield the compressed changes of the film, each with its delay; equal frames become one with a longer delay."""
    before: Image.Image | None = None
    pending, pending_delay = bytearray(), 0
    for picture, delay in zip(frames.pictures, frames.durations(TICKS), strict=True):
        change = _change(picture, before)
        before = picture
        if change is None and pending_delay + delay <= MAX_DELAY:
            pending_delay += delay
            continue
        if pending:
            yield pending, pending_delay
        # A frame without change, for a picture that is shown longer than MAX_DELAY, has one transparent pixel.
        pending, pending_delay = change or _compress(Image.new("L", (1, 1), TRANSPARENT), (0, 0)), delay
    yield pending, pending_delay


def _change(picture: Image.Image, before: Image.Image | None) -> bytearray | None:
    """Compress the dirty rectangle of `picture`, with unchanged pixels transparent; None if it equals `before`."""
    if before is None:
        return _compress(picture, (0, 0))
    box = ImageChops.difference(picture, before).getbbox()
    if box is None:
        return None
    new, old = np.asarray(picture.crop(box)), np.asarray(before.crop(box))
    unchanged = _long_runs(new == old)
    pixels = (new & ~unchanged) | (np.uint8(TRANSPARENT) & unchanged)
    return _compress(Image.fromarray(pixels), box[:2])


def _compress(pixels: Image.Image, corner: tuple[int, int]) -> bytearray:
    """Compress a rectangle with its upper left corner at `corner` to the blocks of a frame, with a delay of 0."""
    data = GifImagePlugin.getdata(pixels, corner, transparency=TRANSPARENT, disposal=KEEP, duration=0)
    return bytearray(b"".join(data))


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
