"""Pictures and films that were written, read again."""

from __future__ import annotations

import io

from PIL import Image, ImageSequence

__all__ = ["last_frame", "picture_size"]


def picture_size(content: bytes) -> tuple[int, int]:
    """Width and height in pixels of a picture or film, given as the content of its file."""
    with Image.open(io.BytesIO(content)) as opened:
        return opened.size


def last_frame(content: bytes) -> bytes:
    """The last frame of a film, given as the content of its file, as the bytes of a PNG."""
    still = io.BytesIO()
    with Image.open(io.BytesIO(content)) as film:
        *_, last = (frame.convert("RGB") for frame in ImageSequence.Iterator(film))
        last.save(still, format="PNG", optimize=True)
    return still.getvalue()
