"""Lines of text as images, in the font of the present language."""

from __future__ import annotations

import textwrap
from functools import lru_cache
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon._language import font as language_font
from pymunk_dragon.drawing.palette import COLOURS
from pymunk_dragon.errors import ParameterError

# Margins beside and above a line, as fractions of the text height.
_SIDE_MARGIN, _TOP_MARGIN = 0.6, 0.3
# A Unicode code point that will never be assigned.
_UNASSIGNED_CHARACTER = "\U0010ffff"

_Font = ImageFont.FreeTypeFont | ImageFont.ImageFont


def check(name: str, text: str) -> None:
    """Raise a `ParameterError` if the font lacks a character of the parameter `name`."""
    font = _font(16, language_font())
    missing = bytes(font.getmask(_UNASSIGNED_CHARACTER))
    for character in "".join(text.split()):
        if bytes(font.getmask(character)) == missing:
            bound = f"of characters that the type has; it lacks {character!r}, which another font may have"
            raise ParameterError(name, text, bound)


def line(text: str, height: int) -> Image.Image:
    """Render one line of a text height in pixels, in ink with margins. The image's height does not depend on `text`."""
    return _line(text, height, language_font())


def wrapped(text: str, height: int, width: int) -> list[Image.Image]:
    """Render `text` in lines of at most `width` pixels; a wider word is split."""
    for columns in range(max(1, len(text)), 0, -1):
        lines = [line(part, height) for part in textwrap.wrap(text, columns)]
        if all(each.width <= width for each in lines):
            break
    return lines


@lru_cache(maxsize=8)
def _font(size: float, file: Path | None) -> _Font:
    return ImageFont.load_default(size) if file is None else ImageFont.truetype(file, size)


@lru_cache(maxsize=32)
def _line(text: str, height: int, file: Path | None) -> Image.Image:
    font, margin = _font(height, file), round(_SIDE_MARGIN * height)
    # No digit or Latin letter extends below these characters.
    bottom = round(font.getbbox("gjpqy,()[]|")[3])
    size = round(font.getbbox(text)[2]) + 2 * margin, bottom + margin
    image = Image.new("RGB", size, COLOURS.background)
    ImageDraw.Draw(image).text((margin, round(_TOP_MARGIN * height)), text, fill=COLOURS.ink, font=font)
    return image
