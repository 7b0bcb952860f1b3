"""Exceptions in functions of the user's, also in those that Pymunk calls from C."""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pymunk

from pymunk_dragon.errors import DragonError

# Lines of a traceback that the page shows.
_TRACE_LINES = 8
# Files that are not the user's.
_LIBRARIES = str(Path(__file__).parents[1]), str(Path(pymunk.__file__).parent)
# Exceptions in callbacks of the present thread, while they are collected; and the hook that was there before.
_CAUGHT, _BEFORE = threading.local(), [sys.__unraisablehook__]


def _unraisable(raised: Any) -> None:
    """Collect an exception in a callback, which C calls, so that Python would only print it."""
    errors = getattr(_CAUGHT, "errors", None)
    if errors is not None and isinstance(raised.exc_value, Exception):
        errors.append(raised.exc_value)
    else:
        _BEFORE[0](raised)


@contextmanager
def callbacks_raise() -> Iterator[None]:
    """Context that raises the first exception of a callback in this thread at its end."""
    if sys.unraisablehook is not _unraisable:
        # It stays, as other threads may be in this context too.
        _BEFORE[0], sys.unraisablehook = sys.unraisablehook, _unraisable
    _CAUGHT.errors = []
    try:
        yield
        if _CAUGHT.errors:
            raise _CAUGHT.errors[0]
    finally:
        _CAUGHT.errors = None


def described(error: Exception) -> dict[str, Any]:
    """Return an exception as a message: of one in the user's functions also the end of the traceback, and the line."""
    if isinstance(error, DragonError):
        return {"kind": "error", "text": str(error)}
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith(_LIBRARIES)] or frames
    lines = "".join(traceback.format_list(own)).splitlines()
    place = f"{Path(own[-1].filename).name}, line {own[-1].lineno}: {own[-1].line}"
    text = f"{type(error).__name__}: {error}"
    return {"kind": "error", "text": text, "place": place, "trace": "\n".join(lines[-_TRACE_LINES:])}
