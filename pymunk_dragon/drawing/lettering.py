"""Lines of text as images, in the font of the present language.

The Chinese font is used if a text needs it.
"""

import textwrap
from functools import cache, lru_cache
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon._extras import FEATURES
from pymunk_dragon._language import chinese_font
from pymunk_dragon._language import font as language_font
from pymunk_dragon.drawing.palette import COLOURS
from pymunk_dragon.errors import MissingExtraError, ParameterError

# Margin beside a line, as a fraction of the text height.
_SIDE_MARGIN = 0.6
# Margin above a line, as a fraction of the text height.
_TOP_MARGIN = 0.3
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
    """Render one line of a text height in pixels, in ink with margins.

    All lines of a font have one image height.
    """
    return _line(text, height, _font_file(text))


def wrapped(text: str, height: int, width: int) -> list[Image.Image]:
    """Render `text` in lines of at most `width` pixels; a wider word is split.

    Of all numbers of characters in a line, the largest one is chosen with which every line is
    narrow enough.
    """
    file = _font_file(text)
    # Two lines that follow each other have more characters together than fit into one.
    columns = 1 + min(len(text), 2 * len(text) * width // _width(text, height, file))
    parts = textwrap.wrap(text, columns)
    while columns > 1 and any(_width(part, height, file) > width for part in parts):
        columns -= 1
        parts = textwrap.wrap(text, columns)
    return [_line(part, height, file) for part in parts]


def _font_file(text: str) -> Path | None:
    """File of the font of the present language or, if it lacks a character, of the Chinese font."""
    own = language_font()
    return own if own is not None or _missing(text, own) is None else chinese_font()


def _missing(text: str, file: Path | None) -> str | None:
    """First character that a font lacks, but for white space; None if it has all."""
    lacking = (each for each in "".join(text.split()) if not _is_in_font(each, file))
    return next(lacking, None)


@cache
def _is_in_font(character: str, file: Path | None) -> bool:
    font = _font(_CHECKED_HEIGHT, file)
    return bytes(font.getmask(character)) != bytes(font.getmask(_UNASSIGNED_CHARACTER))


@lru_cache(maxsize=8)
def _font(size: float, file: Path | None) -> _Font:
    return ImageFont.load_default(size) if file is None else ImageFont.truetype(file, size)


def _width(text: str, height: int, file: Path | None) -> int:
    """Width of a line with its margins, pixels."""
    return round(_font(height, file).getbbox(text)[2]) + 2 * round(_SIDE_MARGIN * height)


@lru_cache(maxsize=32)
def _line(text: str, height: int, file: Path | None) -> Image.Image:
    font = _font(height, file)
    # No digit or Latin letter extends below these characters.
    bottom = round(font.getbbox("gjpqy,()[]|")[3])
    margin = round(_SIDE_MARGIN * height)
    size = _width(text, height, file), bottom + margin
    image = Image.new("RGB", size, COLOURS.background)
    top = round(_TOP_MARGIN * height)
    ImageDraw.Draw(image).text((margin, top), text, fill=COLOURS.ink, font=font)
    return image
