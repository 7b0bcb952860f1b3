"""What sessions send: the page, which is one HTML document with its style and script; and JSON texts and frames."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from functools import cache
from html import escape
from typing import Any

import numpy as np

from pymunk_dragon import player
from pymunk_dragon._arguments import Array
from pymunk_dragon._html import asset, embedded_json
from pymunk_dragon.player.page import catalogue, document

# Parts of the script: those of the player, and those of this page; each uses only those before it.
_PLAYER_SCRIPTS = ("common", "texts", "geometry", "pane", "view", "format", "marks", "paint", "pointer", "stage")
_SCRIPTS = (
    *("connection", "model", "force_scale", "shapes", "overlays", "live_paint", "parameters", "live_charts"),
    *("tools", "recorder", "live_show", "live", "live_controls"),
)


@cache
def live_page(title: str, language: str) -> tuple[str, str]:
    """The page, which opens in a language, and its content security policy."""
    scripts = [(player.__name__, name) for name in _PLAYER_SCRIPTS] + [(__package__, name) for name in _SCRIPTS]
    return document(
        asset(__package__, "assets/live.html"),
        asset(__package__, "assets/live.css"),
        "".join(asset(package, f"assets/{name}.js") for package, name in scripts),
        "; connect-src 'self'",
        language=language,
        title=escape(title),
        texts=embedded_json({"zh": catalogue(player.__name__, __package__)}),
    )


def in_binary(header: Mapping[str, Any], arrays: Mapping[str, Array]) -> bytes:
    """Return a frame: a JSON header with sizes, preceded by its length, and arrays of 32-bit numbers."""
    sizes = {name: array.size for name, array in arrays.items()}
    text = json.dumps(without_nan({**header, "sizes": sizes}), allow_nan=False).encode()
    # The arrays begin at a multiple of four bytes.
    text += b" " * (-len(text) % 4)
    with np.errstate(over="ignore"):
        numbers = [array.astype("<f4").tobytes() for array in arrays.values()]
    return b"".join([struct.pack("<I", len(text)), text, *numbers])


def without_nan(value: Any) -> Any:
    """Return JSON values with None in place of numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {name: without_nan(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
