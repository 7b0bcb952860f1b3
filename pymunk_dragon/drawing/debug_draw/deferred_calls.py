"""Records the calls of a C library to a Python object, to be replayed later from Python."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Sequence
from typing import Any

# Type of `sys.unraisablehook`.
Hook = Callable[[Any], Any]

# Return value of every recorded call: a colour where the C library needs one. Its value is not used.
NO_COLOUR = (0, 0, 0, 0)


class DeferredCalls:
    """Record of the calls to some methods of an object from `begin` to `end`; the methods themselves do not run.

    Instance attributes with the methods' names replace the methods. If an interrupt arrives during `begin` or `end`,
    these attributes may remain until the next recording removes them.

    Parameters
    ----------
    target : object
        Object whose method calls are recorded.
    names : sequence of str
        Names of the methods.
    """

    def __init__(self, target: object, names: Sequence[str]) -> None:
        self._attributes = vars(target)
        self._calls: list[tuple[str, tuple[Any, ...]]] = []
        self._recorders = {name: _CallRecorder(name, self._calls, self._attributes.get(name)) for name in names}
        self._unraisable = _UnraisableHook()

    def begin(self) -> None:
        """Start recording."""
        try:
            self._unraisable.begin()
            self._attributes.update(self._recorders)
        except BaseException:
            self.end()
            raise

    def end(self) -> list[tuple[str, tuple[Any, ...]]]:
        """Stop recording. Return the calls in order (name, arguments), or raise the exception that C code discarded."""
        try:
            for name, recorder in self._recorders.items():
                if recorder.original is None:
                    self._attributes.pop(name, None)
                else:
                    self._attributes[name] = recorder.original
        finally:
            self._unraisable.end()
        return self._calls


class _CallRecorder:
    """Replacement of a method, or of the instance attribute by which a user replaced it."""

    def __init__(self, name: str, calls: list[tuple[str, tuple[Any, ...]]], original: Any) -> None:
        self.original: Any = original.original if isinstance(original, _CallRecorder) else original
        self._name = name
        self._calls = calls

    def __call__(self, *arguments: Any) -> tuple[int, int, int, int]:
        """Record a call."""
        self._calls.append((self._name, arguments))
        return NO_COLOUR


class _UnraisableHook:
    """Hook that keeps the first exception of this thread in a function called from C, and raises it in `end`.

    Python passes such exceptions to `sys.unraisablehook`. All threads share this hook; each may install its own over
    that of another thread, and remove it in any order.
    """

    def __init__(self) -> None:
        self._thread: int | None = None
        self._error: BaseException | None = None
        self._next: Hook = sys.unraisablehook

    def begin(self) -> None:
        """Install this hook."""
        self._next = _active_hook(sys.unraisablehook)
        self._thread = threading.get_ident()
        sys.unraisablehook = self

    def __call__(self, unraisable: sys.UnraisableHookArgs) -> None:
        """Handle an exception as `sys.unraisablehook`."""
        if threading.get_ident() != self._thread or "cffi" not in (unraisable.err_msg or ""):
            self._next(unraisable)
        elif self._error is None:
            self._error = unraisable.exc_value

    def end(self) -> None:
        """Remove this hook, and raise the exception it kept."""
        self._thread = None
        if sys.unraisablehook is self:
            sys.unraisablehook = _active_hook(self)
        error, self._error = self._error, None
        if error is not None:
            raise error


def _active_hook(hook: Hook) -> Hook:
    """Return the hook, or the first one below it that has not ended and does not belong to this thread."""
    while isinstance(hook, _UnraisableHook) and hook._thread in (None, threading.get_ident()):
        hook = hook._next
    return hook
