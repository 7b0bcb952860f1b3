"""What pages and sessions send each other: messages of a page, and frames for it.

A message is a JSON object: `do` names the action, other members are its arguments. Nothing else is accepted. A frame
is a JSON header and arrays of numbers.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pymunk.space_debug_draw_options import SpaceDebugColor

from pymunk_dragon._arrays import Array
from pymunk_dragon.drawing.debug_draw import DrawCall
from pymunk_dragon.errors import ParameterError

# Characters of a message.
MAX_MESSAGE = 4096
# Arguments of each action, and their types; `float` takes whole numbers too.
ACTIONS: Mapping[str, Mapping[str, type]] = {
    "play": {},
    "pause": {},
    "step": {"count": int},
    "speed": {"value": float},
    "reset": {},
    "scene": {"name": str},
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
    "until_contact": {},
    "ping": {"id": int},
}
# Numbers of the kinds of drawn calls in a frame.
_KINDS = {"circle": 0, "segment": 1, "polygon": 2, "line": 3, "dot": 4}
# Numbers of a call before its points.
_HEAD = 7
# Actions that change the motion: they are logged with the number of the step before which they act.
INPUTS = ("set", "contacts", "grab", "drag", "drop", "release", "hold", "cut", "obstacle", "remove", "press", "pointer")


def parsed(text: str) -> dict[str, Any]:
    """The message in a text."""
    if len(text) > MAX_MESSAGE:
        raise ParameterError("message", f"{len(text)} characters", f"at most {MAX_MESSAGE}")
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    return checked(found)


def checked(found: object) -> dict[str, Any]:
    """A message that was read, if it has an action, all its arguments, and nothing else."""
    if not isinstance(found, dict) or not isinstance(found.get("do"), str) or found["do"] not in ACTIONS:
        raise ParameterError("message", found, "an object with an action: do is one of " + ", ".join(ACTIONS))
    arguments = ACTIONS[found["do"]]
    if set(found) != {"do", *arguments}:
        raise ParameterError("message", found, f"{found['do']} with {', '.join(arguments) or 'nothing else'}")
    return {"do": found["do"]} | {name: _value(name, found[name], kind) for name, kind in arguments.items()}


def _value(name: str, value: object, kind: type) -> Any:
    if kind is float and type(value) is int:
        try:
            return float(value)
        except OverflowError:
            raise ParameterError(name, value, "a smaller number") from None
    if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
        raise ParameterError(name, value, f"a {_NAMES[kind]}")
    return value


_NAMES = {int: "whole number", float: "finite number", str: "text", bool: "truth value"}


def in_binary(header: Mapping[str, Any], arrays: Mapping[str, Array], kind: str) -> bytes:
    """Return a JSON header with sizes, preceded by its length, and arrays of numbers of a kind: "<f4" or "<f8"."""
    sizes = {name: array.size for name, array in arrays.items()}
    text = json.dumps(without_nan({**header, "sizes": sizes}), allow_nan=False).encode()
    # The arrays begin at a multiple of eight bytes.
    text += b" " * (-(4 + len(text)) % 8)
    with np.errstate(over="ignore"):
        return struct.pack("<I", len(text)) + text + b"".join(array.astype(kind).tobytes() for array in arrays.values())


def from_binary(content: bytes, kind: str) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return header and arrays of what `in_binary` made."""
    [length] = struct.unpack_from("<I", content)
    header = json.loads(content[4 : 4 + length])
    sizes = header["sizes"]
    parts = np.split(np.frombuffer(content, kind, offset=4 + length), np.cumsum(list(sizes.values()))[:-1])
    return header, dict(zip(sizes, parts, strict=True))


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


def unpacked(numbers: Array, colours: Sequence[Sequence[float]]) -> list[DrawCall]:
    """Return the calls that `packed` took, at the precision of the numbers."""
    kinds, table, calls, begin = list(_KINDS), [SpaceDebugColor(*colour) for colour in colours], [], 0
    while begin < len(numbers):
        kind, count, radius, angle, fill, outline, moves = (float(each) for each in numbers[begin : begin + _HEAD])
        end = begin + _HEAD + 2 * int(count)
        points = tuple((x, y) for x, y in np.reshape(numbers[begin + _HEAD : end], (-1, 2)).tolist())
        rim = None if outline < 0 else table[int(outline)]
        calls.append(DrawCall(kinds[int(kind)], points, radius, table[int(fill)], rim, angle, bool(moves)))
        begin = end
    return calls


def without_nan(value: Any) -> Any:
    """Return JSON values with None in place of numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {name: without_nan(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
