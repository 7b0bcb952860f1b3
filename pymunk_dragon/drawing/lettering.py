"""Lines of text as images, in the font of the present language, or in the Chinese font if a text needs it."""

from __future__ import annotations

import textwrap
from bisect import bisect_left
from functools import cache, lru_cache
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon._extras import FEATURES
from pymunk_dragon._language import chinese_font
from pymunk_dragon._language import font as language_font
from pymunk_dragon.drawing.palette import COLOURS
from pymunk_dragon.errors import MissingExtraError, ParameterError

# Margins beside and above a line, as fractions of the text height.
_SIDE_MARGIN, _TOP_MARGIN = 0.6, 0.3
# Text height with which is checked which characters a font has, pixels.
_CHECKED_HEIGHT = 16
# A Unicode code point that will never be assigned.
_UNASSIGNED_CHARACTER = "\U0010ffff"

_Font = ImageFont.FreeTypeFont | ImageFont.ImageFont


def check(name: str, text: str) -> None:
    """Raise a `ParameterError` if no font has all characters of the parameter `name`."""
    missing = _missing(text, _font_file(text))
    if missing is None:
        return
    bound = f"of characters that the font has; it lacks {missing!r}"
    if chinese_font() is None:
        bound += f". {MissingExtraError(*FEATURES['zhplot'])}"
    raise ParameterError(name, text, bound)


def line(text: str, height: int) -> Image.Image:
    """Render one line of a text height in pixels, in ink with margins. All lines of a font have one image height."""
    return _line(text, height, _font_file(text))


def wrapped(text: str, height: int, width: int) -> list[Image.Image]:
    """Render `text` in lines of at most `width` pixels; a wider word is split.

    Of all numbers of characters in a line, the largest one is chosen with which every line is
    narrow enough.
    """
    file = _font_file(text)

    def is_wide(part: str) -> bool:
        return _width(part, height, file) > width

    # The first line grows with the number of characters.
    first_lines = range(1, len(text) + 1)
    columns = bisect_left(
        first_lines, x=True, key=lambda number: is_wide("".join(textwrap.wrap(text, number)[:1]))
    )
    parts = textwrap.wrap(text, max(columns, 1))
    while (
        columns > 1
        and (wide := next((i for i, part in enumerate(parts) if is_wide(part)), None)) is not None
    ):
        # With fewer characters, but enough for all lines so far, these lines are the same.
        columns = max(map(len, parts[: wide + 1])) - 1
        parts = textwrap.wrap(text, columns)
    return [_line(part, height, file) for part in parts]


def _font_file(text: str) -> Path | None:
    """Return the file of the font of the present language or, if this one lacks a character, of the Chinese font."""
    own = language_font()
    return own if own is not None or _missing(text, own) is None else chinese_font()


def _missing(text: str, file: Path | None) -> str | None:
    """Return the first character that a font lacks, but for white space; None if it has all."""
    return next((each for each in text if not (each.isspace() or _is_in_font(each, file))), None)


@cache
def _is_in_font(character: str, file: Path | None) -> bool:
    font = _font(_CHECKED_HEIGHT, file)
    return bytes(font.getmask(character)) != bytes(font.getmask(_UNASSIGNED_CHARACTER))


@lru_cache(maxsize=8)
def _font(size: float, file: Path | None) -> _Font:
    return ImageFont.load_default(size) if file is None else ImageFont.truetype(file, size)


def _width(text: str, height: int, file: Path | None) -> int:
    """Return the width of a line with its margins, pixels."""
    return round(_font(height, file).getbbox(text)[2]) + 2 * round(_SIDE_MARGIN * height)


@lru_cache(maxsize=32)
def _line(text: str, height: int, file: Path | None) -> Image.Image:
    font, margin = _font(height, file), round(_SIDE_MARGIN * height)
    # No digit or Latin letter extends below these characters.
    bottom = round(font.getbbox("gjpqy,()[]|")[3])
    image = Image.new("RGB", (_width(text, height, file), bottom + margin), COLOURS.background)
    ImageDraw.Draw(image).text(
        (margin, round(_TOP_MARGIN * height)), text, fill=COLOURS.ink, font=font
    )
    return image
