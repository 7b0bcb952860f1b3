"""Compare pictures with a tolerance: `python tests/pictures.py OLD NEW...`.

As a program, replace the picture OLD by the first of the files NEW, unless both show the same. The other files NEW, the
same picture in other formats, replace the files of their names beside OLD, or go with the first. So committed pictures
do not change where only rounding or a library's compression has.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
from PIL import Image

# Levels of 255 by which a colour channel may differ: rounding on other machines changes the edges of smooth lines.
LEVELS = 12
# Share of the pixels that may differ by more than LEVELS. A film whose benches lie a micrometre elsewhere has about
# 4e-6 of them, a film with another digit in its caption 5e-5 and more.
SHARE = 2e-5


def share_off(one: Image.Image, other: Image.Image) -> float:
    """Share of the pixels of two frames of the same size that differ by more than LEVELS."""
    first, second = (np.asarray(image.convert("RGBA"), dtype=np.int16) for image in (one, other))
    return float(np.mean((np.abs(first - second) > LEVELS).any(axis=-1)))


def show_the_same(one: Path, other: Path) -> bool:
    """Whether two files have frames of one size and as many, each as long, with at most SHARE of the pixels off."""
    if one.read_bytes() == other.read_bytes():
        return True
    with Image.open(one) as first, Image.open(other) as second:
        count = getattr(first, "n_frames", 1)
        if first.size != second.size or count != getattr(second, "n_frames", 1):
            return False
        off = 0.0
        for frame in range(count):
            first.seek(frame)
            second.seek(frame)
            if first.info.get("duration") != second.info.get("duration"):
                return False
            off += share_off(first, second)
    return off / count <= SHARE


def replace(old: Path, new: list[Path]) -> None:
    """Put the new files in the old one's folder, or remove them where the first shows the same as `old`."""
    same = old.exists() and show_the_same(old, new[0])
    for path in new:
        kept = old.parent / path.name
        if same and kept.exists():
            path.unlink()
            # For make, which compares times.
            os.utime(kept)
        else:
            os.replace(path, kept)


if __name__ == "__main__":
    replace(Path(sys.argv[1]), [Path(argument) for argument in sys.argv[2:]])
