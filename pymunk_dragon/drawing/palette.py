"""Colours of pictures, and the table of colours of films."""

from dataclasses import asdict, dataclass
from functools import cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from PIL.ImageColor import getrgb

# Drawn pixels per pixel of the picture along each axis: a picture is drawn at twice its size and
# reduced.
BLOCK = 2
# Shades of text between background and ink: more than 16 make no visible difference at this size.
_TEXT_SHADES = 16


@dataclass(frozen=True, kw_only=True)
class Palette:
    """Colours of pictures, each as "#rrggbb".

    The defaults are distinguishable with colour blindness and in greyscale.

    `background` and `curve` are the ground and the path; `head`, `body` and `tail` the benches,
    `contact` those in contact; `ink` outlines, holes and text; `motion` velocities and position
    errors; `force` forces, contact points and normals; `grid` the cells of the broad phase.
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


# The colours of films and figures.
COLOURS = Palette()


@cache
def colour_table() -> NDArray[np.uint8]:
    """Red, green and blue (C, 3), C < 256, of the colours of films.

    They are the palette and the mixtures of two of its colours in a block of four pixels.
    """
    colours = {name: np.array(getrgb(colour)) for name, colour in asdict(COLOURS).items()}
    steps = np.arange(1, BLOCK**2)[:, None] / BLOCK**2
    pairs = combinations(colours.values(), 2)
    mixtures = [one + steps * (other - one) for one, other in pairs]

    # Text between background and ink has more shades.
    background = colours["background"]
    shades = np.arange(_TEXT_SHADES)[:, None] / _TEXT_SHADES
    mixtures.append(background + shades * (colours["ink"] - background))

    table = np.rint(np.vstack([*colours.values(), *mixtures]))
    return np.unique(table.astype(np.uint8), axis=0)
