"""GIF.

Pillow compresses each frame (`GifImagePlugin.getdata`); this module puts the blocks into the file. imageio reads the
films in the tests and writes the stills, but none of its ways to a GIF takes palette indices as a stream. Encoding
alone, 300 frames of 640 x 640 with 223 benches (Pillow 13, imageio 2.38, 2 cores):

=======================================  ==========  =====  ==================================================
way                                      ms a frame  MB     memory
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

from pymunk_dragon.render.palette import TRANSPARENT
from pymunk_dragon.render.streams.base import Box, Patch, PatchStream, Table

__all__ = ["GifStream"]

# "Leave the frame in place": the next one is drawn over it.
KEEP = 1
# Where the delay stands in what Pillow makes of a frame: a graphic control extension comes first.
DELAY = slice(4, 6)


class GifStream(PatchStream):
    """Writer of a GIF that plays for ever."""

    TICKS_PER_SECOND = 100
    MAX_DELAY = 0xFFFF

    @classmethod
    def _compressed(cls, pixels: Image.Image, box: Box, table: Table) -> bytes:
        return b"".join(GifImagePlugin.getdata(pixels, box[:2], transparency=TRANSPARENT, disposal=KEEP, duration=0))

    def _begin(self) -> None:
        # Screen of `size`, a global table of 2^(7 + 1) colours, background 0, square pixels; then "loop for ever".
        self._file.write(b"GIF89a" + struct.pack("<HHBBB", *self._size, 0xF7, 0, 0) + self.table.tobytes())
        self._file.write(b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00")

    def _write(self, patch: Patch, delay: int) -> None:
        data = bytearray(patch.data)
        data[DELAY] = struct.pack("<H", delay)
        self._file.write(data)

    def _end(self) -> None:
        self._file.write(b";")
