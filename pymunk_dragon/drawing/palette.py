"""Colours, and the mapping of their anti-aliased mixtures to palette indices without a quantiser.

A picture is drawn at twice its size on a greyscale image with one grey level (code) for each of seven colours, and
reduced by averaging blocks of four pixels. The codes are chosen so that the average identifies the four pixels: the
average is the palette index, and the palette holds the mixture's colour. Seven codes have 210 mixtures of four, too
many to distinguish in 256 rounded averages, but not all of them occur. Every bench has an outline, so two bench colours
are adjacent only with ink between them. The 89 mixtures of one colour, of no bench colour, or of ink and at most two
bench colours are exact. If another mixture shares its index with an exact mixture, the index has the exact mixture's
colour; if several other mixtures share an index, it has their mean colour.

Marks over a finished picture (arrows, discs, the grid) are drawn in accents. Each accent has a few strengths over each
colour, and every such blend has one of the indices that the mixtures leave free.
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

# Drawn pixels per pixel of the picture along each axis: blocks of four give sufficiently smooth edges.
BLOCK = 2
# Grey level (code) of every colour. A random search found 149 sets of codes that keep the 89 mixtures distinct. This
# set has the fewest collisions among the remaining mixtures, and leaves 89 indices free.
CODES = {"background": 55, "curve": 164, "ink": 47, "body": 221, "head": 241, "tail": 2, "contact": 255}
# Colours that occur on benches only, and hence next to ink.
BENCH_COLOURS = frozenset({"body", "head", "tail", "contact"})
# Opacities of each accent: the coverages of a block of four pixels; for the grid, which only tints the ground, those of
# an occupied cell and of a line.
STRENGTHS = {"motion": (0.25, 0.5, 0.75, 1.0), "force": (0.25, 0.5, 0.75, 1.0), "grid": (0.1, 0.28)}
# Colours that the grid tints.
GROUND = ("background", "curve")
# Names of the accents.
Accent = Literal["motion", "force", "grid"]
# Shades of text between background and ink: more than 16 make no visible difference at this size.
TYPE_SHADES = 16

# Format of a colour: "#rrggbb".
COLOUR_FORMAT = re.compile(r"#[0-9a-fA-F]{6}")


@dataclass(frozen=True, kw_only=True)
class Palette:
    """Colours of a film, each as "#rrggbb".

    Parameters
    ----------
    background, curve : str
        Ground and path of the dragon.
    head, body, tail, contact : str
        Benches; `contact` is the colour of benches in contact. The head keeps its own, with a border of this colour.
    ink : str
        Outlines, holes and text.
    motion, force, grid : str
        Velocities; impulses, contact points and normals; cells of the broad phase.

    Raises
    ------
    ParameterError
        If a colour is not "#" and six hexadecimal digits.

    Notes
    -----
    The default colours are distinguishable with red-green colour blindness and in greyscale: the lightnesses of the
    bench colours differ by at least a seventh of the scale.

    Examples
    --------
    >>> from pymunk_dragon import Palette
    >>> Palette(head="#d94801").rgb("head")
    array([217.,  72.,   1.])
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
            if not (isinstance(value, str) and COLOUR_FORMAT.fullmatch(value)):
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
        """Return red, green and blue of a colour, (3,), 0 to 255."""
        return np.array(list(bytes.fromhex(getattr(self, name)[1:])), dtype=float)


def index_of(mixture: tuple[str, ...]) -> int:
    """Return the index of a block of four pixels of these colours: the mean code, halves rounded up as in Pillow."""
    return (sum(CODES[name] for name in mixture) + BLOCK**2 // 2) // BLOCK**2


def occurs(mixture: tuple[str, ...]) -> bool:
    """Return whether a mixture occurs in pictures, and is therefore exact."""
    colours = set(mixture)
    benches = colours & BENCH_COLOURS
    return len(colours) == 1 or not benches or ("ink" in colours and len(benches) <= 2)


def blends(accent: Accent) -> NDArray[np.uint8]:
    """Return the index (S + 1, 256) of each index after blending: first unchanged, then for the accent's S strengths.

    A mixture is blended as its most frequent colour. The grid changes only mixtures of ground colours.
    """
    table = np.tile(np.arange(256, dtype=np.uint8), (len(STRENGTHS[accent]) + 1, 1))
    # Mixtures that occur are last, so that they overwrite others with the same index, as in the table of colours.
    for mixture in sorted(MIXTURES, key=occurs):
        if accent != "grid" or set(mixture) <= set(GROUND):
            name = max(reversed(mixture), key=mixture.count)
            for level, strength in enumerate(STRENGTHS[accent], start=1):
                table[level, index_of(mixture)] = BLENDS[accent, name, strength]
    if accent != "grid":
        # Full strength replaces every index, including those of other accents.
        table[-1] = BLENDS[accent, "background", 1.0]
    return table


def _blends() -> dict[tuple[str, str, float], int]:
    """Assign an index to every accent, colour and strength; full strength has one index for all colours."""
    free = iter(_FREE_INDICES[TYPE_SHADES + 1 :])
    indices: dict[tuple[str, str, float], int] = {}
    for accent, strengths in STRENGTHS.items():
        for strength in strengths:
            full = next(free) if strength == 1.0 else None
            for name in GROUND if accent == "grid" else CODES:
                indices[accent, name, strength] = next(free) if full is None else full
    return indices


# All mixtures of the pixels of a block.
MIXTURES = list(combinations_with_replacement(CODES, BLOCK**2))
# Indices that no mixture has.
_FREE_INDICES = sorted(set(range(256)) - {index_of(mixture) for mixture in MIXTURES})
# Indices of the shades of text, from background to ink.
TYPE_RAMP = tuple(_FREE_INDICES[:TYPE_SHADES])
# Index of an unchanged pixel in a film; no picture uses it.
TRANSPARENT = _FREE_INDICES[TYPE_SHADES]
# Index of every accent, colour and strength.
BLENDS = _blends()
