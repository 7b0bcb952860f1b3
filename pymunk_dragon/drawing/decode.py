"""Reads pictures and films from the content of their files."""

from __future__ import annotations

import io

from PIL import Image, ImageSequence

__all__ = ["last_frame", "picture_size"]


def picture_size(content: bytes) -> tuple[int, int]:
    """Return width and height, pixels, of a picture or film from the content of its file."""
    with Image.open(io.BytesIO(content)) as opened:
        return opened.size


def last_frame(content: bytes) -> bytes:
    """Return the last frame of a film as PNG, from the content of the film's file."""
    still = io.BytesIO()
    with Image.open(io.BytesIO(content)) as film:
        *_, last = (frame.convert("RGB") for frame in ImageSequence.Iterator(film))
        last.save(still, format="PNG", optimize=True)
    return still.getvalue()
