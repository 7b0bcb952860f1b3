"""Colours of pictures, and the table of colours of films.

A picture is drawn at twice its size and reduced, so each pixel is the mean of four drawn pixels. Few mixtures of
colours occur, because every bench has an outline: the table holds all of them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError

# Drawn pixels per pixel of the picture along each axis: blocks of four give sufficiently smooth edges.
BLOCK = 2
# Colours that occur on benches only, and hence next to ink.
BENCH_COLOURS = {"body", "head", "tail", "contact"}
# Colours that overlays may cover.
COVERED = ("background", "curve", "ink", *sorted(BENCH_COLOURS))
# Opacities of the grid, which only tints the ground, of 255: of a cell with a bench, and of a line.
CELL_TINT, LINE_TINT = 26, 71
# Shades of text between background and ink: more than 16 make no visible difference at this size.
TEXT_SHADES = 16
# Format of a colour: "#rrggbb".
COLOUR_FORMAT = re.compile(r"#[0-9a-fA-F]{6}")

Colour = tuple[int, int, int]


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
    (217, 72, 1)
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

    def rgb(self, name: str) -> Colour:
        """Return red, green and blue of a colour, 0 to 255."""
        red, green, blue = bytes.fromhex(getattr(self, name)[1:])
        return red, green, blue

    @cached_property
    def table(self) -> NDArray[np.uint8]:
        """Red, green and blue (C, 3) of the colours of films; C is at most 255."""
        mixtures = [mixture for mixture in combinations_with_replacement(COVERED, BLOCK**2) if _occurs(mixture)]
        colours = [np.mean([self.rgb(name) for name in mixture], axis=0) for mixture in mixtures]
        colours += [self._blend("background", "ink", step / TEXT_SHADES) for step in range(TEXT_SHADES)]
        accents = [("motion", name, share) for name in COVERED for share in range(1, 5)]
        accents += [("force", name, share) for _, name, share in accents]
        colours += [self._blend(name, accent, share / 4) for accent, name, share in accents]
        colours += [self._blend(name, "grid", tint / 255) for name in COVERED[:2] for tint in (CELL_TINT, LINE_TINT)]
        return np.unique(np.rint(colours).astype(np.uint8), axis=0)

    def _blend(self, below: str, above: str, opacity: float) -> NDArray[np.float64]:
        return (1 - opacity) * np.array(self.rgb(below)) + opacity * np.array(self.rgb(above))


def _occurs(mixture: tuple[str, ...]) -> bool:
    """Return whether a mixture occurs in pictures: ink separates bench colours from all others."""
    benches = BENCH_COLOURS & set(mixture)
    return len(set(mixture)) == 1 or not benches or ("ink" in mixture and len(benches) <= 2)
