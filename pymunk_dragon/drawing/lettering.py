"""Lines of text as images."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from pymunk_dragon._language import font as language_font
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.errors import ParameterError

# Text height as a fraction of the picture's shorter side: readable, and small beside the dragon.
_RELATIVE_HEIGHT = 0.036
# Pixels: digits of a smaller text are not readable.
_MIN_HEIGHT = 15
# Margins beside and above a line, as fractions of the text height.
_SIDE_MARGIN, _TOP_MARGIN = 0.6, 0.3
# A Unicode code point that will never be assigned.
_UNASSIGNED_CHARACTER = "\U0010ffff"

_Font = ImageFont.FreeTypeFont | ImageFont.ImageFont


class Lettering:
    """Renderer of lines of text in ink on a plain background, with a height that suits a picture's size, pixels.

    `scale` is a factor on the standard height, `font` a font file; by default the font included in Pillow.
    """

    def __init__(
        self, size: tuple[int, int], palette: Palette, scale: float = 1.0, *, font: str | Path | None = None
    ) -> None:
        self.height = round(scale * max(_MIN_HEIGHT, round(_RELATIVE_HEIGHT * min(size))))
        self.margin = round(_SIDE_MARGIN * self.height)
        self._style = self.height, font, palette

    def check(self, name: str, text: str) -> None:
        """Raise a `ParameterError` if the font lacks a character of the parameter `name`, or cannot be read."""
        font = _font(*self._style[:2])
        missing = font.getmask(_UNASSIGNED_CHARACTER)
        for character in "".join(text.split()):
            drawn = font.getmask(character)
            if drawn.size == missing.size and bytes(drawn) == bytes(missing):
                bound = f"of characters that the type has; it lacks {character!r}, which another font may have"
                raise ParameterError(name, text, bound)

    def line(self, text: str) -> Image.Image:
        """Render one line with margins. The height does not depend on the text."""
        return _line_image(text, *self._style)

    def put(self, picture: Image.Image, left: str, right: str, *, bottom: bool = False) -> None:
        """Write text into both upper (or lower) corners of `picture`; `right` is omitted if it would overlap `left`."""
        first, second = self.line(left), self.line(right)
        top = picture.height - first.height if bottom else 0
        if right and first.width * bool(left) + second.width <= picture.width:
            picture.paste(second, (picture.width - second.width, top))
        if left:
            picture.paste(first, (0, top))

    def wrapped(self, text: str, width: int) -> list[str]:
        """Wrap `text` into lines of at most `width` pixels; a wider word is split."""
        lines = [""]
        for word in text.split():
            longer = f"{lines[-1]} {word}".strip()
            if self.line(longer).width <= width:
                lines[-1] = longer
            else:
                lines += self._parts(word, width)
        return [line for line in lines if line]

    def _parts(self, word: str, width: int) -> list[str]:
        parts = [word[0]]
        for character in word[1:]:
            if self.line(parts[-1] + character).width > width:
                parts.append("")
            parts[-1] += character
        return parts


def pillow_font(size: float) -> _Font:
    """Font of Pillow, `size` pixels high, with the characters of the present language."""
    return _font(size, language_font())


@lru_cache(maxsize=8)
def _font(size: float, file: str | Path | None) -> _Font:
    try:
        return ImageFont.load_default(size) if file is None else ImageFont.truetype(file, size)
    except OSError as error:
        raise ParameterError("font", str(file), "a file of a TrueType or OpenType face that can be read") from error


@lru_cache(maxsize=32)
def _line_image(text: str, size: int, file: str | Path | None, palette: Palette) -> Image.Image:
    font, margin = _font(size, file), round(_SIDE_MARGIN * size)
    # No digit or Latin letter extends below these characters.
    height = round(font.getbbox("gjpqy,()[]|")[3])
    image = Image.new("RGB", (round(font.getbbox(text)[2]) + 2 * margin, height + margin), palette.rgb("background"))
    ImageDraw.Draw(image).text((margin, round(_TOP_MARGIN * size)), text, fill=palette.rgb("ink"), font=font)
    return image
