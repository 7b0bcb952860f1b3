"""Colours, and how their anti-aliased mixtures become palette indices without a quantiser.

A picture is drawn at twice its size on a greyscale image in seven codes, one a colour, and shrunk by averaging blocks
of four. The codes are chosen so that the average tells which four pixels went in: the shrunken picture is the palette
index, and the palette holds the mixture's colour. Seven codes have 210 mixtures of four, too many to be told apart
in 256 rounded averages, but not all of them occur. Every bench has an outline, so its colour never meets another one
without ink between: the 89 mixtures in which at most two bench colours meet, and only with ink, are exact. Where a
rarer one shares its index with an exact one, the exact one has it; where rarer ones share, it is their mean.

What is laid over a finished picture (arrows, discs, a grid) has accents of its own: each in a few strengths over each
of the colours, with an index for every such blend among those that the mixtures leave free.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError

__all__ = [
    "BLOCK",
    "CODES",
    "STRENGTHS",
    "TRANSPARENT",
    "TYPE_RAMP",
    "Accent",
    "Palette",
    "blends",
    "index_of",
    "occurs",
]

# Pixels drawn for every pixel shown, along each side.
BLOCK = 2
# Grey level of every colour. A random search for codes that keep the 89 mixtures apart found these; of 149 finds they
# have the fewest collisions among the remaining mixtures, and leave 89 indices free.
CODES = {"background": 55, "curve": 164, "ink": 47, "body": 221, "head": 241, "tail": 2, "contact": 255}
BENCH_COLOURS = frozenset({"body", "head", "tail", "contact"})
# How much of an accent is laid over a colour: the coverages of a block of four by an edge; and for the grid, which only
# tints the ground, a filed cell's and a line's.
STRENGTHS = {"motion": (0.25, 0.5, 0.75, 1.0), "force": (0.25, 0.5, 0.75, 1.0), "grid": (0.1, 0.28)}
GROUND = ("background", "curve")
Accent = Literal["motion", "force", "grid"]
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
    motion, force, grid : str
        Velocities; impulses, contact points and normals; and the cells of the broad phase.

    Raises
    ------
    ParameterError
        If a colour is not "#" and six hexadecimal digits.

    Notes
    -----
    The defaults stay apart for people who cannot tell red from green, and printed in grey: the benches' colours differ
    in lightness by a seventh of the scale and more, not only in hue.
    """

    background: str = "#fbf8f1"
    curve: str = "#c6b99f"
    head: str = "#ffbf2e"
    body: str = "#78a6d0"
    tail: str = "#357e74"
    contact: str = "#b00d27"
    ink: str = "#27303f"
    motion: str = "#1b7837"
    force: str = "#2b0f54"
    grid: str = "#27303f"

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
        for (accent, name, strength), index in BLENDS.items():
            table[index] = (1 - strength) * self.rgb(name) + strength * self.rgb(accent)
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


def blends(accent: Accent) -> NDArray[np.uint8]:
    """Which index (S + 1, 256) an index becomes under each of the accent's S strengths, after none at all.

    A mixture counts as the colour that it has most of; the grid leaves all that is not ground as it is.
    """
    table = np.tile(np.arange(256, dtype=np.uint8), (len(STRENGTHS[accent]) + 1, 1))
    # Where mixtures share an index, those that occur have it, as in the table of colours: they come last.
    for mixture in sorted(MIXTURES, key=occurs):
        if accent != "grid" or set(mixture) <= set(GROUND):
            name = max(reversed(mixture), key=mixture.count)
            for level, strength in enumerate(STRENGTHS[accent], start=1):
                table[level, index_of(mixture)] = BLENDS[accent, name, strength]
    if accent != "grid":
        # What covers a pixel does so whatever was there, other accents too.
        table[-1] = BLENDS[accent, "background", 1.0]
    return table


def _blends() -> dict[tuple[str, str, float], int]:
    """An index for every accent, colour under it, and strength; full strength is one index whatever lies under it."""
    free = iter(_FREE[TYPE_SHADES + 1 :])
    indices: dict[tuple[str, str, float], int] = {}
    for accent, strengths in STRENGTHS.items():
        for strength in strengths:
            full = next(free) if strength == 1.0 else None
            for name in GROUND if accent == "grid" else CODES:
                indices[accent, name, strength] = next(free) if full is None else full
    return indices


MIXTURES = list(combinations_with_replacement(CODES, BLOCK**2))
_FREE = sorted(set(range(256)) - {index_of(mixture) for mixture in MIXTURES})
TYPE_RAMP = tuple(_FREE[:TYPE_SHADES])
# The index that means "as in the frame before"; no picture uses it.
TRANSPARENT = _FREE[TYPE_SHADES]
BLENDS = _blends()
