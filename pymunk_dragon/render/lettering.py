"""Lines of type as patches of palette indices."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon.render.palette import TYPE_RAMP

__all__ = ["Lettering"]

# Type height as a share of the picture's shorter side, and the pixels below which figures run together.
RELATIVE_HEIGHT, MIN_HEIGHT = 0.036, 15
# Shares of the type's height: the margin at its sides, and the one above.
SIDE, ABOVE = 0.6, 0.3
# The 256 greys of Pillow's type, rounded to the palette's shades.
SHADES = [TYPE_RAMP[i] for i in np.rint(np.linspace(0, len(TYPE_RAMP) - 1, 256)).astype(int)]


class Lettering:
    """Type on a ground of its own, of a height that fits a picture of `size` pixels.

    Parameters
    ----------
    size : tuple of int
        Width and height of the picture, pixels.
    scale : float
        How much larger than usual the type is.
    """

    def __init__(self, size: tuple[int, int], scale: float = 1.0) -> None:
        self.height = round(scale * max(MIN_HEIGHT, round(RELATIVE_HEIGHT * min(size))))

    def line(self, text: str) -> Image.Image:
        """One line with margins; all lines are equally high, whatever they say."""
        return _patch(text, self.height)

    def put(self, picture: Image.Image, text: str, *, right: bool = False, bottom: bool = False) -> None:
        """Set a line into a corner of `picture`, the upper left one unless told otherwise."""
        patch = self.line(text)
        width, height = picture.size
        # Flush with the edge: the patch brings its own margin.
        picture.paste(patch, (width - patch.width if right else 0, height - patch.height if bottom else 0))

    def wrapped(self, text: str, width: int) -> list[str]:
        """`text` in lines that are at most `width` pixels wide, or a word long."""
        lines: list[str] = []
        for word in text.split():
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self.line(longer).width <= width:
                lines[-1] = longer
            else:
                lines.append(word)
        return lines


@lru_cache(maxsize=8)
def _font(size: int) -> tuple[ImageFont.FreeTypeFont | ImageFont.ImageFont, int]:
    """The face at a size, and how low its lines reach."""
    font = ImageFont.load_default(size)
    # No figure or Latin letter reaches lower.
    return font, round(font.getbbox("gjpqy,()[]|")[3])


@lru_cache(maxsize=32)
def _patch(text: str, size: int) -> Image.Image:
    font, height = _font(size)
    margin = round(SIDE * size)
    width = round(font.getbbox(text)[2])
    patch = Image.new("L", (width + 2 * margin, height + margin))
    ImageDraw.Draw(patch).text((margin, round(ABOVE * size)), text, fill=255, font=font)
    return patch.point(SHADES)
