"""Frames of a page's canvas: a JSON header, Pymunk's draw calls as numbers, other arrays."""

import json
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.physics.draw_calls import DrawCall

# Numbers of the kinds of calls; contacts are sent apart.
KINDS = {"circle": 0, "segment": 1, "polygon": 2, "line": 3, "dot": 4}


def packed(
    calls: Sequence[DrawCall], grip: Callable[[Any], int], *known: Any
) -> tuple[Array, list[list[float]]]:
    """Calls as numbers, and their colours.

    A call is its kind, number of points, radius, angle, fill, outline and grip, and the points.
    The grip is that of its shape, and 0 without one. `known` colours have the first numbers.
    """
    colours: dict[Any, int] = {each: number for number, each in enumerate(known)}
    numbers: list[float] = []

    for call in calls:
        fill = colours.setdefault(call.fill, len(colours))
        outline = -1
        if call.outline is not None:
            outline = colours.setdefault(call.outline, len(colours))
        held = 0 if call.shape is None else grip(call.shape)
        numbers += [KINDS[call.name], len(call.points)]
        numbers += [call.radius, call.angle, fill, outline, held]
        for point in call.points:
            numbers.extend(point)

    components = [[*map(float, colour)] for colour in colours]
    return np.array(numbers, dtype=float), components


def in_binary(header: Mapping[str, Any], arrays: Mapping[str, Array]) -> bytes:
    """A frame: the length of a JSON header, the header with sizes, and arrays of 64-bit numbers.

    32 bits would move corners by half a metre in coordinates of maps, and be too few wherever a
    page zooms in.
    """
    sizes = {name: array.size for name, array in arrays.items()}
    values = without_nan({**header, "sizes": sizes})
    text = json.dumps(values, allow_nan=False).encode()
    # The arrays begin at a multiple of eight bytes.
    text += b" " * ((4 - len(text)) % 8)
    numbers = [array.astype("<f8").tobytes() for array in arrays.values()]
    return b"".join([struct.pack("<I", len(text)), text, *numbers])


def without_nan(value: Any) -> Any:
    """JSON values with None in place of numbers that JSON does not have."""
    # First what most values are.
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [without_nan(each) for each in value]
    if isinstance(value, Mapping):
        return {name: without_nan(each) for name, each in value.items()}
    return value
