"""The texts of a lesson's figure in the present language. The programs have them in English."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from pymunk_dragon._language import font, in_language, text
from pymunk_dragon.errors import MissingExtraError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER = re.compile(r"\d+(?:\.\d+)?")


def has_font(language: str) -> bool:
    """Whether a font with the characters of a language is installed."""
    with in_language(language):
        try:
            font()
        except MissingExtraError:
            return False
        return True


def translate(figure: Figure) -> None:
    """Translate the texts of a figure from English into the present language, with a font that has its characters."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.text import Text

    face = font()
    artists: list[Any] = [] if face is None else figure.findobj(Text)
    for artist in artists:
        english = artist.get_text()
        if (found := _translated(english)) != english:
            artist.set_text(found)
            artist.set_fontproperties(FontProperties(fname=face, size=artist.get_size()))


def _translated(english: str) -> str:
    """The translation of a text; numbers in it are {} in the table, and spaces around it stay."""
    words = english.strip()
    template = NUMBER.sub("{}", words)
    return english.replace(words, text(template).format(*NUMBER.findall(words))) if words else english
