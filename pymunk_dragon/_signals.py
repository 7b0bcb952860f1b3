"""The signals that end a program, and delaying them while code runs that must not be interrupted halfway."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

# Those that the system has.
ENDING = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)


@contextmanager
def signals_held(holds: Callable[[], bool] = lambda: True) -> Iterator[Callable[[], None]]:
    """Delay the handlers of signals while `holds()` is true; yields a function that runs the delayed ones.

    They are also run at the end. Where no handler can be set, outside the main thread or in a
    browser, nothing changes.
    """
    handlers: dict[int, Any] = {
        each: handler for each in ENDING if callable(handler := signal.getsignal(each))
    }
    held: list[int] = []

    def handle(number: int, frame: FrameType | None) -> None:
        held.append(number)
        if not holds():
            release()

    def release() -> None:
        while held:
            number = held.pop()
            handlers[number](number, None)

    try:
        with suppress(OSError, ValueError):
            for number in handlers:
                signal.signal(number, handle)
        yield release
    finally:
        with suppress(OSError, ValueError):
            for number, handler in handlers.items():
                signal.signal(number, handler)
        release()


def interruption_of(error: BaseException | None) -> BaseException | None:
    """The interruption that caused an error: an interrupted import of a module in C raises an `ImportError`."""
    while error and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error
