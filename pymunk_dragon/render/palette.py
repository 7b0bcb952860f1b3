"""Colours, and how their anti-aliased mixtures become palette indices without a quantiser.

A picture is drawn at twice its size on a greyscale image in seven codes, one a colour, and shrunk by averaging blocks
of four. The codes are chosen so that the average tells which four pixels went in: the shrunken picture is the palette
index, and the palette holds the mixture's colour. Seven codes have 210 mixtures of four, too many to be told apart
in 256 rounded averages, but not all of them occur. Every bench has an outline, so its colour never meets another one
without ink between: the 89 mixtures in which at most two bench colours meet, and only with ink, are exact. Where a
rarer one shares its index with an exact one, the exact one has it; where rarer ones share, it is their mean.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError

__all__ = ["BLOCK", "CODES", "TRANSPARENT", "TYPE_RAMP", "Palette", "index_of", "occurs"]

# Pixels drawn for every pixel shown, along each side.
BLOCK = 2
# Grey level of every colour. A random search for codes that keep the 89 mixtures apart found these; of 149 finds they
# have the fewest collisions among the remaining mixtures, and leave 89 indices free.
CODES = {"background": 55, "curve": 164, "ink": 47, "body": 221, "head": 241, "tail": 2, "contact": 255}
BENCH_COLOURS = frozenset({"body", "head", "tail", "contact"})
# Shades of type between background and ink; 16 are as smooth as the eye can tell at this size.
TYPE_SHADES = 16

COLOUR = re.compile(r"#[0-9a-fA-F]{6}")


@dataclass(frozen=True, kw_only=True)
class Palette:
    """Colours of a film, each as "#rrggbb".

    Parameters
    ----------
    background, curve : str
        The ground and the line that the dragon follows.
    head, body, tail, contact : str
        The benches; `contact` takes the place of the others on the two that touch.
    ink : str
        Outlines, holes and type.

    Raises
    ------
    ParameterError
        If a colour is not "#" and six hexadecimal digits.

    Notes
    -----
    The defaults stay apart for people who cannot tell red from green (Okabe and Ito's reasoning: they differ in
    lightness or along blue and yellow, not only in hue).
    """

    background: str = "#fbf8f1"
    curve: str = "#c6b99f"
    head: str = "#f0a202"
    body: str = "#8db4d6"
    tail: str = "#00796b"
    contact: str = "#c8102e"
    ink: str = "#27303f"

    def __post_init__(self) -> None:
        for name in (f.name for f in fields(self)):
            value = getattr(self, name)
            if not (isinstance(value, str) and COLOUR.fullmatch(value)):
                raise ParameterError(name, value, "a colour as #rrggbb")

    @cached_property
    def table(self) -> NDArray[np.uint8]:
        """Red, green and blue of every index, (256, 3)."""
        table = np.zeros((256, 3))
        mixtures: dict[int, list[NDArray[np.float64]]] = {}
        exact = {index_of(mixture) for mixture in MIXTURES if occurs(mixture)}
        for mixture in MIXTURES:
            index = index_of(mixture)
            if occurs(mixture) or index not in exact:
                mixtures.setdefault(index, []).append(np.mean([self.rgb(name) for name in mixture], axis=0))
        for index, colours in mixtures.items():
            table[index] = np.mean(colours, axis=0)
        shares = np.linspace(0, 1, TYPE_SHADES)[:, None]
        table[list(TYPE_RAMP)] = (1 - shares) * self.rgb("background") + shares * self.rgb("ink")
        return np.rint(table).astype(np.uint8)

    def rgb(self, name: str) -> NDArray[np.float64]:
        """Red, green and blue of one of the colours, (3,), 0 to 255."""
        return np.array(list(bytes.fromhex(getattr(self, name)[1:])), dtype=float)


def index_of(mixture: tuple[str, ...]) -> int:
    """Index that a block of four pixels of these colours is shrunk to: the mean, halves rounded up as Pillow does."""
    return (sum(CODES[name] for name in mixture) + BLOCK**2 // 2) // BLOCK**2


def occurs(mixture: tuple[str, ...]) -> bool:
    """Whether a mixture is one of those that a picture is made of."""
    colours = set(mixture)
    benches = colours & BENCH_COLOURS
    return len(colours) == 1 or not benches or ("ink" in colours and len(benches) <= 2)


MIXTURES = list(combinations_with_replacement(CODES, BLOCK**2))
_FREE = sorted(set(range(256)) - {index_of(mixture) for mixture in MIXTURES})
TYPE_RAMP = tuple(_FREE[:TYPE_SHADES])
# The index that means "as in the frame before"; no picture uses it.
TRANSPARENT = _FREE[TYPE_SHADES]
