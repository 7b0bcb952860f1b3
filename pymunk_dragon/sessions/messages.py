"""What pages and sessions send each other: messages of a page, and frames for it.

A message is a JSON object: `do` names the action, other members are its arguments. A frame is a JSON header and arrays
of numbers.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pymunk_dragon._arguments import MAX_COORDINATE, Array, finite
from pymunk_dragon.drawing.debug_draw import DrawCall
from pymunk_dragon.errors import ParameterError

# Characters of a message; and inputs that are kept: two hours of a mouse that never rests.
MAX_MESSAGE, MAX_INPUTS = 4096, 500_000
# Actions on a scene, each with its arguments: they are logged with the number of the step before which they act.
INPUTS: Mapping[str, Mapping[str, type]] = {
    "set": {"name": str, "value": float},
    "contacts": {"value": str},
    "grab": {"x": float, "y": float, "slip": float},
    "drag": {"x": float, "y": float},
    "drop": {},
    "release": {"bench": int},
    "hold": {},
    "cut": {"x": float, "y": float, "slip": float},
    "obstacle": {"shape": str, "x": float, "y": float, "size": float},
    "remove": {"obstacle": int},
    "press": {"name": str, "down": bool},
    "pointer": {"x": float, "y": float, "kind": str},
}
# All actions: those on the session change no motion.
ACTIONS: Mapping[str, Mapping[str, type]] = {
    **INPUTS,
    "play": {},
    "pause": {},
    "step": {"count": int},
    "speed": {"value": float},
    "reset": {},
    "scene": {"name": str},
    "until_contact": {},
    "ping": {"id": int},
}
# Numbers of the kinds of drawn calls in a frame.
_KINDS = {"circle": 0, "segment": 1, "polygon": 2, "line": 3, "dot": 4}


def parsed(text: str) -> dict[str, Any]:
    """Return the message in a text."""
    if len(text) > MAX_MESSAGE:
        raise ParameterError("message", f"{len(text)} characters", f"at most {MAX_MESSAGE}")
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    return checked(found)


def checked(found: Any) -> dict[str, Any]:
    """Return a message that was read, if it has an action, all its arguments, and nothing else."""
    action = found.get("do") if isinstance(found, dict) else None
    if not isinstance(action, str) or action not in ACTIONS or set(found) != {"do", *ACTIONS[action]}:
        raise ParameterError("message", found, "an action with all its arguments: do is one of " + ", ".join(ACTIONS))
    message: dict[str, Any] = {"do": action}
    for name, kind in ACTIONS[action].items():
        # Values of sliders have bounds of their own.
        value, most = found[name], math.inf if name == "value" else MAX_COORDINATE
        message[name] = finite(name, value, -most, most, "") if kind is float else value
        if type(message[name]) is not kind:
            raise ParameterError(name, value, f"a value of the type {kind.__name__}")
    return message


def in_binary(header: Mapping[str, Any], arrays: Mapping[str, Array]) -> bytes:
    """Return a JSON header with sizes, preceded by its length, and arrays of 32-bit numbers."""
    sizes = {name: array.size for name, array in arrays.items()}
    text = json.dumps(without_nan({**header, "sizes": sizes}), allow_nan=False).encode()
    # The arrays begin at a multiple of four bytes.
    text += b" " * (-len(text) % 4)
    with np.errstate(over="ignore"):
        numbers = [array.astype("<f4").tobytes() for array in arrays.values()]
    return b"".join([struct.pack("<I", len(text)), text, *numbers])


def packed(calls: Sequence[DrawCall]) -> tuple[Array, list[list[float]]]:
    """Return calls as numbers, and their colours: kind, points, radius, angle, fill, outline, moves, and the points."""
    colours: dict[Any, int] = {}
    numbers: list[float] = []
    for call in calls:
        fill = colours.setdefault(call.fill, len(colours))
        outline = -1 if call.outline is None else colours.setdefault(call.outline, len(colours))
        numbers += [_KINDS[call.name], len(call.points), call.radius, call.angle, fill, outline, call.moves]
        for point in call.points:
            numbers.extend(point)
    return np.array(numbers, dtype=float), [[*map(float, colour)] for colour in colours]


def without_nan(value: Any) -> Any:
    """Return JSON values with None in place of numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {name: without_nan(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
