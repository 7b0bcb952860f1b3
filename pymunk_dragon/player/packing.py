"""Places over time as a short text, which the page's decode.js turns into numbers again.

Places are counted in steps of `Packed.step` from an origin. What is kept is the third difference of the counts over
time, which is next to nothing where things move smoothly: half of what second differences take. Every count fits into
32 bits, and differences are taken modulo 2^32, so that any jump comes back exactly. Numbers of either sign are folded
(0, -1, 1, -2 become 0, 1, 2, 3), their lowest bytes put first, then the next ones, and everything is deflated: the
high bytes of small numbers are zeros in a row.
"""

from __future__ import annotations

import zlib
from base64 import b64encode
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Packed", "packed"]

Array = NDArray[np.float64]

# How often differences are taken. Of the seed's run, 2 make 1.9 MB and 3 make 0.9 MB; rounding makes 4 larger again.
ORDER = 3
# Steps from the origin, either way: what 32 bits hold, and one to spare for rounding.
MAX_COUNT = 2**31 - 2


@dataclass(frozen=True, kw_only=True)
class Packed:
    """Places of H points at F times.

    Attributes
    ----------
    frames, points : int
        F and H.
    origin : tuple of float
        Where counting begins, m.
    step : float
        What one count is, m. A coordinate is off by at most half of it.
    text : str
        The differences, deflated, in base64.
    """

    frames: int
    points: int
    origin: tuple[float, float]
    step: float
    text: str


def packed(places: Array, step: float) -> Packed:
    """Pack `places` (F, H, 2) in m in steps of `step` m, or larger ones where they reach further than 32 bits count."""
    low, high = places.min(axis=(0, 1)), places.max(axis=(0, 1))
    # Halved first: the sum of two large numbers may not be a number.
    origin = low / 2 + high / 2
    step = max(step, float((high / 2 - low / 2).max()) / MAX_COUNT)
    # By point, coordinate and time, so that one track's differences stand side by side.
    counts = np.rint((places - origin) / step).astype(np.int64).transpose(1, 2, 0)
    for _ in range(ORDER):
        counts = np.diff(counts, axis=-1, prepend=0)
    wrapped = counts.astype(np.int32).astype(np.int64)
    folded = ((wrapped << 1) ^ (wrapped >> 63)).astype("<u4")
    planes = np.ascontiguousarray(folded).view(np.uint8).reshape(-1, 4).T
    text = b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    frames, points = places.shape[:2]
    return Packed(frames=frames, points=points, origin=(float(origin[0]), float(origin[1])), step=step, text=text)
