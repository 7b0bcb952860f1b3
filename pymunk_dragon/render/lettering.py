"""Lines of type as patches of palette indices."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.render.palette import TYPE_RAMP

__all__ = ["Lettering"]

# Type height as a share of the picture's shorter side, and the pixels below which figures run together.
RELATIVE_HEIGHT, MIN_HEIGHT = 0.036, 15
# Shares of the type's height: the margin at its sides, and the one above.
SIDE, ABOVE = 0.6, 0.3
# A place in Unicode that will never be given a character.
NO_CHARACTER = "\U0010ffff"
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
    font : str or Path, optional
        File of the face; by default the one that Pillow brings.
    """

    def __init__(self, size: tuple[int, int], scale: float = 1.0, *, font: str | Path | None = None) -> None:
        self.height = round(scale * max(MIN_HEIGHT, round(RELATIVE_HEIGHT * min(size))))
        self._face = None if font is None else str(font)

    def check(self, name: str, text: str) -> None:
        """Make sure that the face has every character of `text`, which is that of a parameter.

        Raises
        ------
        ParameterError
            If it lacks one, or its file cannot be read.
        """
        font, _ = _font(self.height, self._face)
        missing = [character for character in text if not character.isspace() and _lacks(font, character)]
        if missing:
            bound = f"of characters that the type has; it lacks {missing[0]!r}, which another font may have"
            raise ParameterError(name, text, bound)

    def line(self, text: str) -> Image.Image:
        """One line with margins; all lines are equally high, whatever they say."""
        return _patch(text, self.height, self._face)

    def put(self, picture: Image.Image, left: str, right: str, *, bottom: bool = False) -> None:
        """Set lines into both upper corners of `picture`, or both lower ones; the right one only if there is room."""
        width, height = picture.size
        first, second = self.line(left), self.line(right)
        # Flush with the edge: a patch brings its own margin.
        top = height - first.height if bottom else 0
        room = width - second.width
        if right and (not left or first.width <= room):
            picture.paste(second, (room, top))
        if left:
            picture.paste(first, (0, top))

    def wrapped(self, text: str, width: int) -> list[str]:
        """`text` in lines that are at most `width` pixels wide; a word that is wider is broken."""
        lines: list[str] = []
        for word in text.split():
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self.line(longer).width <= width:
                lines[-1] = longer
            else:
                lines += self._broken(word, width)
        return lines

    def _broken(self, word: str, width: int) -> list[str]:
        parts = [""]
        for character in word:
            if parts[-1] and self.line(parts[-1] + character).width > width:
                parts.append("")
            parts[-1] += character
        return parts


@lru_cache(maxsize=8)
def _font(size: int, face: str | None) -> tuple[ImageFont.FreeTypeFont | ImageFont.ImageFont, int]:
    """The face at a size, and how low its lines reach."""
    try:
        font = ImageFont.load_default(size) if face is None else ImageFont.truetype(face, size)
    except OSError as error:
        raise ParameterError("font", face, "a file of a TrueType or OpenType face that can be read") from error
    # No figure or Latin letter reaches lower.
    return font, round(font.getbbox("gjpqy,()[]|")[3])


def _lacks(font: ImageFont.FreeTypeFont | ImageFont.ImageFont, character: str) -> bool:
    """Whether a character is drawn as the box that stands for any that is not there."""
    seen, nothing = (font.getmask(text) for text in (character, NO_CHARACTER))
    return seen.size == nothing.size and bytes(seen) == bytes(nothing)


@lru_cache(maxsize=32)
def _patch(text: str, size: int, face: str | None) -> Image.Image:
    font, height = _font(size, face)
    margin = round(SIDE * size)
    width = round(font.getbbox(text)[2])
    patch = Image.new("L", (width + 2 * margin, height + margin))
    ImageDraw.Draw(patch).text((margin, round(ABOVE * size)), text, fill=255, font=font)
    return patch.point(SHADES)
