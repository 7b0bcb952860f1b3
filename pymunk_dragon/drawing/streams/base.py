"""Base classes of film writers, and the dirty rectangles that most formats store."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from types import TracebackType
from typing import BinaryIO, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageChops

from pymunk_dragon.drawing.palette import TRANSPARENT

__all__ = ["Box", "DirtyRectangle", "DirtyRectangleStream", "Stream", "Table"]

# Left, top, right, bottom, pixels.
Box = tuple[int, int, int, int]
# Red, green and blue of every palette index, (256, 3).
Table = NDArray[np.uint8]

# Base-2 logarithm of the shortest run of unchanged pixels that is stored as transparent. Shorter runs interrupt
# repeated patterns and compress worse: with runs of 16 pixels the GIF of the reference scenario is a seventh smaller
# than with runs of 1; 8 and 32 pixels gave no further gain.
RUN_DOUBLINGS = 4


class Stream(Protocol):
    """Interface of a film writer. Leaving its context completes the file."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None: ...

    def add(self, frame: Image.Image, end: float) -> None:
        """Add `frame`, palette indices (mode L), shown until `end` s of film. The caller must not modify it later."""
        ...


@dataclass(frozen=True)
class DirtyRectangle:
    """Change from one frame to the next: a box, and its pixels in the compression of the container."""

    box: Box
    data: bytes


class DirtyRectangleStream(ABC):
    """Film writer that stores the dirty rectangle of each frame, with the unchanged pixels in it transparent.

    A frame that equals the previous frame extends the previous frame's delay. Subclasses compress the rectangles and
    write the container.

    Parameters
    ----------
    file : binary file
        Seekable file at position 0. Some containers complete their header at the end.
    size : tuple of int
        Width and height, pixels.
    table : ndarray of uint8, shape (256, 3)
        Red, green and blue of every index.
    """

    # Ticks per second: the container stores delays as whole ticks.
    TICKS_PER_SECOND: ClassVar[int]
    # Longest delay that the container can store, ticks.
    MAX_DELAY: ClassVar[int]
    # Pixels: the container stores box offsets in multiples of this.
    ALIGNMENT: ClassVar[int] = 1

    def __init__(self, file: BinaryIO, size: tuple[int, int], table: Table) -> None:
        self._file = file
        self._size = size
        self.table = table
        self._previous: Image.Image | None = None
        self._pending: DirtyRectangle | None = None
        self._delay = self._now = 0
        self._begin()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self._flush()
            self._end()

    def add(self, frame: Image.Image, end: float) -> None:
        """Add `frame`, palette indices (mode L), shown until `end` s of film. The caller must not modify it later."""
        self.put(self.encode(frame, self._previous, self.table), end)
        self._previous = frame

    @classmethod
    def encode(cls, frame: Image.Image, before: Image.Image | None, table: Table) -> DirtyRectangle | None:
        """Encode the change from the frame `before` to `frame`, palette indices (mode L). None if they are equal."""
        if before is None:
            whole = (0, 0, *frame.size)
            return DirtyRectangle(whole, cls._compress(frame, whole, table))
        changed = ImageChops.difference(frame, before).getbbox()
        if changed is None:
            return None
        left, top, right, bottom = changed
        box = (left - left % cls.ALIGNMENT, top - top % cls.ALIGNMENT, right, bottom)
        new, old = np.asarray(frame.crop(box)), np.asarray(before.crop(box))
        unchanged = _long_runs(new == old)
        pixels = (new & ~unchanged) | (np.uint8(TRANSPARENT) & unchanged)
        return DirtyRectangle(box, cls._compress(Image.fromarray(pixels), box, table))

    def put(self, change: DirtyRectangle | None, end: float) -> None:
        """Add a frame as the change from the previous frame (None: no change), shown until `end` s of film."""
        # Times are rounded, not delays, so that rounding errors do not accumulate.
        end_ticks = round(end * self.TICKS_PER_SECOND)
        delay, self._now = end_ticks - self._now, end_ticks
        if change is None and self._delay + delay <= self.MAX_DELAY:
            self._delay += delay
            return
        self._flush()
        self._pending, self._delay = change or self._unchanged(), delay

    @classmethod
    @abstractmethod
    def _compress(cls, pixels: Image.Image, box: Box, table: Table) -> bytes:
        """Compress `pixels`, palette indices (mode L) in `box`, to the container's data."""

    @abstractmethod
    def _begin(self) -> None:
        """Write the header."""

    @abstractmethod
    def _write(self, change: DirtyRectangle, delay: int) -> None:
        """Write one frame with a delay in ticks."""

    @abstractmethod
    def _end(self) -> None:
        """Write the trailer."""

    def _unchanged(self) -> DirtyRectangle:
        """Return a rectangle without change, for a frame that is shown longer than `MAX_DELAY`."""
        box = (0, 0, 1, 1)
        return DirtyRectangle(box, self._compress(Image.new("L", (1, 1), TRANSPARENT), box, self.table))

    def _flush(self) -> None:
        """Write the pending frame, whose delay is now known."""
        if self._pending is not None:
            self._write(self._pending, self._delay)
            self._pending = None


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
