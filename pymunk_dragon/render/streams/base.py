"""Films that are written as they come, and the patches that most of them are made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from types import TracebackType
from typing import BinaryIO, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageChops

from pymunk_dragon.render.palette import TRANSPARENT

__all__ = ["Box", "Patch", "PatchStream", "Stream", "Table"]

Box = tuple[int, int, int, int]
Table = NDArray[np.uint8]

# Unchanged pixels side by side from which on they are left out, 2 to this power. Shorter runs of the transparent index
# between changed pixels break up patterns that the compression would have known: 16 made the GIF of the seed's march a
# seventh smaller than 1 did, and 8 and 32 were no better.
RUN_DOUBLINGS = 4


class Stream(Protocol):
    """A film that is being written; as a context manager it ends the file."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None: ...

    def add(self, frame: Image.Image, end: float) -> None:
        """Show `frame`, palette indices (mode L), until `end` s of film. It must not change afterwards."""
        ...


@dataclass(frozen=True)
class Patch:
    """What changes from one frame to the next: pixels in a box, as the container keeps them."""

    box: Box
    data: bytes


class PatchStream(ABC):
    """A film of which only what changes is stored: of each frame the box that changed, and in it the pixels that did.

    A frame like the one before lengthens it. Subclasses compress the patches and write the container.

    Parameters
    ----------
    file : binary file
        To write to, at its beginning; some containers go back there at their end.
    size : tuple of int
        Width and height, pixels.
    table : ndarray of uint8, shape (256, 3)
        Red, green and blue of every index.
    """

    # Of the container: the unit of its delays, how many fit into one, and a whole number that divides a box's place.
    TICKS_PER_SECOND: ClassVar[int]
    MAX_DELAY: ClassVar[int]
    GRID: ClassVar[int] = 1

    def __init__(self, file: BinaryIO, size: tuple[int, int], table: Table) -> None:
        self._file = file
        self._size = size
        self.table = table
        self._shown: Image.Image | None = None
        self._waiting: Patch | None = None
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
        """Show `frame`, palette indices (mode L), until `end` s of film. It must not change afterwards."""
        self.put(self.patch(frame, self._shown, self.table), end)
        self._shown = frame

    @classmethod
    def patch(cls, frame: Image.Image, before: Image.Image | None, table: Table) -> Patch | None:
        """What turns the frame `before` into `frame`, both palette indices (mode L); None where nothing has to."""
        if before is None:
            whole = (0, 0, *frame.size)
            return Patch(whole, cls._compressed(frame, whole, table))
        changed = ImageChops.difference(frame, before).getbbox()
        if changed is None:
            return None
        left, top, right, bottom = changed
        box = (left - left % cls.GRID, top - top % cls.GRID, right, bottom)
        new, old = np.asarray(frame.crop(box)), np.asarray(before.crop(box))
        still = _long_runs(new == old)
        pixels = (new & ~still) | (np.uint8(TRANSPARENT) & still)
        return Patch(box, cls._compressed(Image.fromarray(pixels), box, table))

    def put(self, patch: Patch | None, end: float) -> None:
        """Show what `patch` makes of the frame before, or the same once more, until `end` s of film."""
        # Times are rounded, not delays: however many frames, the film is as long as it should be.
        then = round(end * self.TICKS_PER_SECOND)
        delay, self._now = then - self._now, then
        if patch is None and self._delay + delay <= self.MAX_DELAY:
            self._delay += delay
            return
        self._flush()
        self._waiting, self._delay = patch or self._nothing(), delay

    @classmethod
    @abstractmethod
    def _compressed(cls, pixels: Image.Image, box: Box, table: Table) -> bytes:
        """The container's data for `pixels`, palette indices (mode L), over `box`."""

    @abstractmethod
    def _begin(self) -> None:
        """Write what comes before the frames."""

    @abstractmethod
    def _write(self, patch: Patch, delay: int) -> None:
        """Write one frame that stays for `delay` ticks."""

    @abstractmethod
    def _end(self) -> None:
        """Write what comes after the frames."""

    def _nothing(self) -> Patch:
        """A patch that changes nothing, for a frame that stays longer than one delay can say."""
        box = (0, 0, 1, 1)
        return Patch(box, self._compressed(Image.new("L", (1, 1), TRANSPARENT), box, self.table))

    def _flush(self) -> None:
        """Write what waits until its whole delay is known."""
        if self._waiting is not None:
            self._write(self._waiting, self._delay)
            self._waiting = None


def _long_runs(same: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """255 where a pixel of `same` is one of 2^RUN_DOUBLINGS or more true ones in a row, 0 elsewhere.

    A row goes on in the next line. All pixels are the bits of one number, which is shifted and compared as a whole.
    """
    bits = np.packbits(same)
    runs = int.from_bytes(bits.tobytes())
    steps = [2**i for i in range(RUN_DOUBLINGS)]
    for step in steps:
        # After these, a bit is set where a whole run begins.
        runs &= runs << step
    for step in steps:
        runs |= runs >> step
    # What was shifted out at the upper end is not of the picture.
    kept = (runs & ((1 << 8 * bits.size) - 1)).to_bytes(bits.size)
    return -np.unpackbits(np.frombuffer(kept, dtype=np.uint8), count=same.size).reshape(same.shape)
