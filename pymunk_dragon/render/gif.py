"""A GIF, written frame by frame as palette indices.

Pillow compresses each frame (`GifImagePlugin.getdata`); this module puts the blocks into the file. imageio reads the
films in the tests and writes the stills, but none of its ways to a GIF takes palette indices as a stream. Encoding
alone, 300 frames of 640 x 640 with 223 benches (Pillow 13, imageio 2.38, 2 cores):

=======================================  ==========  =====  ==================================================
way                                      ms a frame  MB     memory
=======================================  ==========  =====  ==================================================
this module                              3.0         7.4    two frames
imageio.v3.imopen, palette indices       31          10.2   188 MB, grows with the film
imageio.v3.imopen, RGB                   32          8.9    555 MB, grows with the film
imageio.v2, GIF-PIL (legacy), RGB        35          10.8   one frame, each with a palette and quantiser of its own
=======================================  ==========  =====  ==================================================
"""

from __future__ import annotations

import struct
from types import TracebackType
from typing import BinaryIO, Self

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image, ImageChops

__all__ = ["GifStream"]

Box = tuple[int, int, int, int]

# A delay is 16 bits of centiseconds.
MAX_DELAY = 0xFFFF
# "Leave the frame in place": the next one is drawn over it.
KEEP = 1
# Unchanged pixels side by side from which on they are left out, 2 to this power. Shorter runs of the transparent index
# between changed pixels break up patterns that LZW would have known: 16 made the film of the seed's march a seventh
# smaller than 1 did, and 8 and 32 were no better.
RUN_DOUBLINGS = 4


class GifStream:
    """Writer of a GIF that plays for ever; as a context manager it ends the file.

    Only the box that changed is stored, and in it only the pixels that did. A frame like the one before lengthens it.

    Parameters
    ----------
    file : binary file
        To write to.
    size : tuple of int
        Width and height, pixels.
    table : ndarray of uint8, shape (256, 3)
        Red, green and blue of every index.
    transparent : int
        An index that no frame uses.
    """

    def __init__(self, file: BinaryIO, size: tuple[int, int], table: NDArray[np.uint8], transparent: int) -> None:
        self._file = file
        self._transparent = transparent
        self._shown: Image.Image | None = None
        self._waiting: tuple[Image.Image, Box] | None = None
        self._delay = 0
        # Screen of `size`, a global table of 2^(7 + 1) colours, background 0, square pixels; then "loop for ever".
        file.write(b"GIF89a" + struct.pack("<HHBBB", *size, 0xF7, 0, 0) + table.tobytes())
        file.write(b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self._flush()
            self._file.write(b";")

    def add(self, frame: Image.Image, delay: int) -> None:
        """Show `frame`, an image of indices (mode L), for `delay` centiseconds. It must not change afterwards."""
        if self._shown is None:
            self._hold(frame, (0, 0, *frame.size), delay)
        else:
            change = ImageChops.difference(frame, self._shown)
            box = change.getbbox()
            if box:
                still = _long_runs(np.asarray(change.crop(box)) == 0)
                patch = np.where(still, np.uint8(self._transparent), np.asarray(frame.crop(box)))
                self._hold(Image.fromarray(patch), box, delay)
            elif self._delay + delay <= MAX_DELAY:
                self._delay += delay
            else:
                self._hold(frame.crop((0, 0, 1, 1)), (0, 0, 1, 1), delay)
        self._shown = frame

    def _hold(self, patch: Image.Image, box: Box, delay: int) -> None:
        """Write what waits, and let `patch` wait until its whole delay is known."""
        self._flush()
        self._waiting, self._delay = (patch, box), delay

    def _flush(self) -> None:
        if self._waiting is None:
            return
        patch, box = self._waiting
        options = {"transparency": self._transparent, "disposal": KEEP, "duration": 10 * self._delay}
        self._file.writelines(GifImagePlugin.getdata(patch, box[:2], **options))
        self._waiting = None


def _long_runs(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Only those true pixels of `mask` that stand in a horizontal run of at least 2^RUN_DOUBLINGS."""
    runs = mask.copy()
    steps = [2**i for i in range(RUN_DOUBLINGS)]
    for step in steps:
        # After these, a pixel is true where a whole run begins; a run would leave the picture at its right edge.
        runs[:, :-step] &= runs[:, step:]
        runs[:, -step:] = False
    for step in steps:
        runs[:, step:] |= runs[:, :-step]
    return runs
