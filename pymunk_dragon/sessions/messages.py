"""Messages from a browser: what they may contain.

A message is a JSON object: `do` names the action, other members are its arguments. Nothing else is accepted.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

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
        raise ParameterError(name, value, f"a {NAMES[kind]}")
    return value


NAMES = {int: "whole number", float: "finite number", str: "text", bool: "truth value"}
