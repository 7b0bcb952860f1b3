"""Renders lines of text as images of palette indices."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon._language import font
from pymunk_dragon.drawing.palette import TYPE_RAMP
from pymunk_dragon.errors import ParameterError

# Text height as a fraction of the picture's shorter side: readable, and small beside the dragon.
RELATIVE_HEIGHT = 0.036
# Pixels: digits of a smaller text are not readable.
MIN_HEIGHT = 15
# Margin on the left and right of a line, as a fraction of the text height.
SIDE_MARGIN = 0.6
# Margin above a line, as a fraction of the text height.
TOP_MARGIN = 0.3
# A Unicode code point that will never be assigned.
UNASSIGNED_CHARACTER = "\U0010ffff"
# Palette index for each of the 256 grey levels of Pillow's text.
SHADES = [TYPE_RAMP[i] for i in np.rint(np.linspace(0, len(TYPE_RAMP) - 1, 256)).astype(int)]


class Lettering:
    """Renderer of text on a plain background, with a text height that suits the picture's size.

    Parameters
    ----------
    size : tuple of int
        Width and height of the picture, pixels.
    scale : float
        Factor on the standard text height.
    font : str or Path, optional
        Font file; by default the font included in Pillow.
    """

    def __init__(self, size: tuple[int, int], scale: float = 1.0, *, font: str | Path | None = None) -> None:
        self.height = round(scale * max(MIN_HEIGHT, round(RELATIVE_HEIGHT * min(size))))
        self.margin = round(SIDE_MARGIN * self.height)
        self._face = None if font is None else str(font)

    def check(self, name: str, text: str) -> None:
        """Check that the font has every character of `text`, the value of the parameter `name`.

        Raises
        ------
        ParameterError
            If the font lacks a character, or its file cannot be read.
        """
        font, _ = _font(self.height, self._face)
        missing = [character for character in text if not character.isspace() and _lacks(font, character)]
        if missing:
            bound = f"of characters that the type has; it lacks {missing[0]!r}, which another font may have"
            raise ParameterError(name, text, bound)

    def line(self, text: str) -> Image.Image:
        """Render one line with margins. The height does not depend on the text."""
        return _line_image(text, self.height, self._face)

    def put(self, picture: Image.Image, left: str, right: str, *, bottom: bool = False) -> None:
        """Write text into both upper (or lower) corners of `picture`; `right` is omitted if it would overlap `left`."""
        width, height = picture.size
        first, second = self.line(left), self.line(right)
        # Flush with the edge: the image of a line includes its margin.
        top = height - first.height if bottom else 0
        room = width - second.width
        if right and (not left or first.width <= room):
            picture.paste(second, (room, top))
        if left:
            picture.paste(first, (0, top))

    def wrapped(self, text: str, width: int) -> list[str]:
        """Wrap `text` into lines of at most `width` pixels; a wider word is split."""
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


def pillow_font(size: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """A font of Pillow, `size` pixels high, with the characters of the present language.

    Raises
    ------
    MissingExtraError
        If the language needs a font that is not installed.
    """
    face = font()
    return ImageFont.load_default(size) if face is None else ImageFont.truetype(face, size)


@lru_cache(maxsize=8)
def _font(size: int, face: str | None) -> tuple[ImageFont.FreeTypeFont | ImageFont.ImageFont, int]:
    """Load a font at a size; return the font and the lower edge of its lines, pixels."""
    try:
        font = ImageFont.load_default(size) if face is None else ImageFont.truetype(face, size)
    except OSError as error:
        raise ParameterError("font", face, "a file of a TrueType or OpenType face that can be read") from error
    # No digit or Latin letter extends below these characters.
    return font, round(font.getbbox("gjpqy,()[]|")[3])


def _lacks(font: ImageFont.FreeTypeFont | ImageFont.ImageFont, character: str) -> bool:
    """Return whether a character is drawn as the font's box for missing characters."""
    drawn, missing = (font.getmask(text) for text in (character, UNASSIGNED_CHARACTER))
    return drawn.size == missing.size and bytes(drawn) == bytes(missing)


@lru_cache(maxsize=32)
def _line_image(text: str, size: int, face: str | None) -> Image.Image:
    font, height = _font(size, face)
    margin = round(SIDE_MARGIN * size)
    width = round(font.getbbox(text)[2])
    image = Image.new("L", (width + 2 * margin, height + margin))
    ImageDraw.Draw(image).text((margin, round(TOP_MARGIN * size)), text, fill=255, font=font)
    return image.point(SHADES)
