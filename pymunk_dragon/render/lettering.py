"""Lines of type as patches of palette indices."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon.render.palette import TYPE_RAMP

__all__ = ["Lettering"]

# Type height as a share of the picture's shorter side, and the pixels below which figures run together.
RELATIVE_HEIGHT, MIN_HEIGHT = 0.036, 15


class Lettering:
    """Type on a ground of its own, in the corners of a picture of `size` pixels."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.height = max(MIN_HEIGHT, round(RELATIVE_HEIGHT * min(size)))
        self.font = ImageFont.load_default(self.height)
        # The 256 greys of Pillow's type, rounded to the palette's shades.
        shades = np.rint(np.linspace(0, len(TYPE_RAMP) - 1, 256)).astype(int)
        self._shades = [TYPE_RAMP[i] for i in shades]
        self._patch = lru_cache(maxsize=16)(self._draw)

    def put(self, picture: Image.Image, text: str, *, right: bool = False, bottom: bool = False) -> None:
        """Set a line into a corner of `picture`, the upper left one unless told otherwise."""
        patch = self._patch(text)
        width, height = picture.size
        # Flush with the edge: the patch brings its own margin.
        picture.paste(patch, (width - patch.width if right else 0, height - patch.height if bottom else 0))

    def _draw(self, text: str) -> Image.Image:
        margin = round(0.6 * self.height)
        draw = ImageDraw.Draw(Image.new("L", (1, 1)))
        # "g" reaches as low as any figure or letter: all lines are equally high, whatever they say.
        height = draw.textbbox((0, 0), text + "g", font=self.font)[3]
        width = draw.textbbox((0, 0), text, font=self.font)[2]
        patch = Image.new("L", (round(width) + 2 * margin, round(height) + margin))
        ImageDraw.Draw(patch).text((margin, margin // 2), text, fill=255, font=self.font)
        return patch.point(self._shades)
