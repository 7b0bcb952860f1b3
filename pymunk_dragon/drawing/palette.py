"""Colours of pictures, and the table of colours of films.

A picture is drawn at twice its size and reduced, so each pixel is the mean of four drawn pixels. Few mixtures of
colours occur, because every bench has an outline: the table holds all of them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import combinations_with_replacement, product

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import ParameterError

# Drawn pixels per pixel of the picture along each axis: blocks of four give sufficiently smooth edges.
BLOCK = 2
# Colours that occur on benches only, and hence next to ink.
_BENCH_COLOURS = {"body", "head", "tail", "contact"}
# Colours that overlays may cover.
_COVERED = ("background", "curve", "ink", *sorted(_BENCH_COLOURS))
# Opacities of the grid, which only tints the ground, of 255: of a cell with a bench, and of a line.
CELL_TINT, LINE_TINT = 26, 71
# Shades of text between background and ink: more than 16 make no visible difference at this size.
_TEXT_SHADES = 16
# Format of a colour: "#rrggbb".
_COLOUR_FORMAT = re.compile(r"#[0-9a-fA-F]{6}")

Colour = tuple[int, int, int]


@dataclass(frozen=True, kw_only=True)
class Palette:
    """Colours of a film, each as "#rrggbb". The defaults are distinguishable with colour blindness and in greyscale.

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
            if not (isinstance(value, str) and _COLOUR_FORMAT.fullmatch(value)):
                raise ParameterError(name, value, "a colour as #rrggbb")

    def rgb(self, name: str) -> Colour:
        """Return red, green and blue of a colour, 0 to 255."""
        red, green, blue = bytes.fromhex(getattr(self, name)[1:])
        return red, green, blue

    @cached_property
    def table(self) -> NDArray[np.uint8]:
        """Red, green and blue (C, 3) of the colours of films; C is at most 255."""
        mixtures = filter(_occurs, combinations_with_replacement(_COVERED, BLOCK**2))
        colours = [np.mean([self.rgb(name) for name in mixture], axis=0) for mixture in mixtures]
        # Colours, colours above them, and the opacities of the latter.
        blends = [
            *product(["background"], ["ink"], np.arange(_TEXT_SHADES) / _TEXT_SHADES),
            *product(_COVERED, ["motion", "force"], [0.25, 0.5, 0.75, 1.0]),
            *product(["background", "curve"], ["grid"], [CELL_TINT / 255, LINE_TINT / 255]),
        ]
        for below, above, opacity in blends:
            colours.append((1 - opacity) * np.array(self.rgb(below)) + opacity * np.array(self.rgb(above)))
        return np.unique(np.rint(colours).astype(np.uint8), axis=0)


def _occurs(mixture: tuple[str, ...]) -> bool:
    """Return whether a mixture occurs in pictures: ink separates bench colours from all others."""
    benches = _BENCH_COLOURS & set(mixture)
    return len(set(mixture)) == 1 or not benches or ("ink" in mixture and len(benches) <= 2)
