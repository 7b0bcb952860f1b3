"""Checks of outlines, shared by the broad and the narrow phase."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.errors import ParameterError

# Metres. A thousand times the rim of the largest spiral; the bound keeps products of coordinates far from the ends of a
# double.
MAX_COORDINATE = 1e9


def numbers(name: str, value: ArrayLike, bound: str) -> NDArray[np.float64]:
    """`value` as a contiguous array of floats, if it is one of real numbers; else an error with `bound`."""
    try:
        array = np.asarray(value)
    except ValueError as error:  # of ragged lists
        raise ParameterError(name, value, bound) from error
    if array.dtype.kind not in "iuf":
        raise ParameterError(name, value, bound)
    return np.ascontiguousarray(array, dtype=float)


def checked_outlines(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """`value` as a contiguous array (..., 4, 2) of corners in m, if it has that shape and its numbers are usable."""
    bound = f"corners (..., 4, 2) in m, finite and within {MAX_COORDINATE:g} m"
    corners = numbers(name, value, bound)
    if corners.shape[-2:] != (4, 2):
        raise ParameterError(name, f"of shape {corners.shape}", bound)
    inside = np.abs(corners) <= MAX_COORDINATE
    if not inside.all():
        raise ParameterError(name, corners[~inside][0].item(), bound)
    return corners
