"""Frames of a film: the input of all film writers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames of a film, which can be read once.

    Attributes
    ----------
    pictures : iterator of Image
        F pictures of palette indices (mode L), drawn while they are read. They must not be modified.
    ends : sequence of float
        Film times (F,), s, until which the frames are shown.
    size : tuple of int
        Width and height, pixels.
    colours : ndarray of uint8, shape (256, 3)
        Red, green and blue of every palette index.
    fps : int
        Frames per second.
    """

    pictures: Iterator[Image.Image]
    ends: Sequence[float]
    size: tuple[int, int]
    colours: NDArray[np.uint8]
    fps: int

    def durations(self, ticks: int) -> list[int]:
        """Return how long each frame is shown, in units of 1 / `ticks` s.

        Times are rounded, not durations, so that rounding errors do not accumulate.
        """
        ends = [round(end * ticks) for end in self.ends]
        return [end - start for start, end in zip([0, *ends], ends, strict=False)]

    def coloured(self) -> Iterator[Image.Image]:
        """Yield the pictures with their colours (mode P)."""
        palette = self.colours.tobytes()
        for picture in self.pictures:
            coloured = Image.frombytes("P", picture.size, picture.tobytes())
            coloured.putpalette(palette)
            yield coloured
