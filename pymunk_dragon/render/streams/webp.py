"""WebP, lossless (WebP container specification, section "Animation").

Pillow compresses each patch as a picture of its own; this module puts its data into the file. Pillow's own animations
keep all frames before the first is written, imageio's keep their compressed data. Encoding alone, 150 frames of
640 x 640 with 223 benches (Pillow 13, imageio 2.38 with PyAV 18, 2 cores):

====================================  ==========  =====  ======================================
way                                   ms a frame  MB     memory
====================================  ==========  =====  ======================================
this module                           9.1         3.9    two frames
imageio.v3, pyav, libwebp_anim        13          4.8    176 MB, grows with the film
====================================  ==========  =====  ======================================
"""

from __future__ import annotations

import struct
from io import BytesIO

from PIL import Image

from pymunk_dragon.render.palette import TRANSPARENT
from pymunk_dragon.render.streams.base import Box, Patch, PatchStream, Table

__all__ = ["WebpStream"]

# Flags of the header: there is an animation, and there is transparency.
ANIMATION, ALPHA = 0x02, 0x10
# libwebp's scales of effort, 0 to 6 and, where it is lossless, 0 to 100.
METHOD, EFFORT = 0, 0
# Bytes of "RIFF", the length and "WEBP".
RIFF = 12


class WebpStream(PatchStream):
    """Writer of an animated WebP that plays for ever."""

    TICKS_PER_SECOND = 1000
    MAX_DELAY = 0xFFFFFF
    # Places are stored as halves.
    GRID = 2

    @classmethod
    def _compressed(cls, pixels: Image.Image, box: Box, table: Table) -> bytes:
        """The chunk of a still WebP that holds the pixels."""
        coloured = Image.frombuffer("P", pixels.size, pixels.tobytes())
        coloured.putpalette(table.tobytes())
        coloured.info["transparency"] = TRANSPARENT
        file = BytesIO()
        coloured.convert("RGBA").save(file, "WEBP", lossless=True, method=METHOD, quality=EFFORT)
        return _chunk_of(file.getvalue(), b"VP8L")

    def _begin(self) -> None:
        width, height = self._size
        self._file.write(b"RIFF\x00\x00\x00\x00WEBP")
        self._chunk(b"VP8X", bytes([ANIMATION | ALPHA, 0, 0, 0]) + _uint24(width - 1) + _uint24(height - 1))
        # A transparent background, and as many rounds as the viewer likes.
        self._chunk(b"ANIM", struct.pack("<IH", 0, 0))

    def _write(self, patch: Patch, delay: int) -> None:
        left, top, right, bottom = patch.box
        place = left // self.GRID, top // self.GRID, right - left - 1, bottom - top - 1
        # A last byte of 0 is "blend, and leave the frame in place".
        head = b"".join(_uint24(number) for number in (*place, delay)) + b"\x00"
        self._chunk(b"ANMF", head + patch.data)

    def _end(self) -> None:
        length = self._file.tell() - RIFF + 4
        self._file.seek(4)
        self._file.write(struct.pack("<I", length))

    def _chunk(self, kind: bytes, data: bytes) -> None:
        # A chunk of an odd length is followed by a zero that the length does not count.
        self._file.write(kind + struct.pack("<I", len(data)) + data + b"\x00" * (len(data) % 2))


def _uint24(number: int) -> bytes:
    return number.to_bytes(3, "little")


def _chunk_of(picture: bytes, wanted: bytes) -> bytes:
    """One chunk of a WebP picture, its name and length included."""
    at = RIFF
    while at < len(picture):
        kind, length = struct.unpack_from("<4sI", picture, at)
        end = at + 8 + length + length % 2
        if kind == wanted:
            return picture[at:end]
        at = end
    raise RuntimeError(f"Pillow wrote a WebP picture without a {wanted.decode()} chunk")
