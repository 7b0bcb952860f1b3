"""What a C library calls on an object, written down to be called later from Python."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Sequence
from typing import Any

__all__ = ["Recording"]

Hook = Callable[[Any], Any]

# What a recorded call returns: a colour, where one is asked for. Nobody looks at it.
NO_COLOUR = (0, 0, 0, 0)


class Recording:
    """Keeps some methods of an object from being called, and writes the calls down, from `begin` to `end`.

    The methods are hidden behind attributes of the object with the same names. Where an interrupt strikes in the
    middle of `begin` or `end`, they may stay there until the next recording, which clears them away.

    Parameters
    ----------
    target : object
        Whose methods are called.
    names : sequence of str
        The methods.
    """

    def __init__(self, target: object, names: Sequence[str]) -> None:
        self._attributes = vars(target)
        self._calls: list[tuple[str, tuple[Any, ...]]] = []
        self._writers = {name: _Writer(name, self._calls, self._attributes.get(name)) for name in names}
        self._lost = _Lost()

    def begin(self) -> None:
        """Write down from now on."""
        try:
            self._lost.begin()
            self._attributes.update(self._writers)
        except BaseException:
            self.end()
            raise

    def end(self) -> list[tuple[str, tuple[Any, ...]]]:
        """Names and arguments of the calls in their order; raises what got lost between them."""
        try:
            for name, writer in self._writers.items():
                if writer.hidden is None:
                    self._attributes.pop(name, None)
                else:
                    self._attributes[name] = writer.hidden
        finally:
            self._lost.end()
        return self._calls


class _Writer:
    """Stands in for a method, and for the attribute that a user may have put over it."""

    def __init__(self, name: str, calls: list[tuple[str, tuple[Any, ...]]], hidden: Any) -> None:
        self.hidden: Any = hidden.hidden if isinstance(hidden, _Writer) else hidden
        self._name = name
        self._calls = calls

    def __call__(self, *arguments: Any) -> tuple[int, int, int, int]:
        """Write down a call."""
        self._calls.append((self._name, arguments))
        return NO_COLOUR


class _Lost:
    """Keeps the first exception that this thread loses in a function called from C, until its end.

    Python hands such exceptions to `sys.unraisablehook`. All threads share it, and each may hang its own hook over
    that of another one, and take it down in any order.
    """

    def __init__(self) -> None:
        self._thread: int | None = None
        self._failure: BaseException | None = None
        self._next: Hook = sys.unraisablehook

    def begin(self) -> None:
        """Take the place of the hook."""
        self._next = _others(sys.unraisablehook)
        self._thread = threading.get_ident()
        sys.unraisablehook = self

    def __call__(self, unraisable: sys.UnraisableHookArgs) -> None:
        """Be `sys.unraisablehook`."""
        if threading.get_ident() != self._thread or "cffi" not in (unraisable.err_msg or ""):
            self._next(unraisable)
        elif self._failure is None:
            self._failure = unraisable.exc_value

    def end(self) -> None:
        """Leave, and raise what was kept."""
        self._thread = None
        if sys.unraisablehook is self:
            sys.unraisablehook = _others(self)
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure


def _others(hook: Hook) -> Hook:
    """The hook, or the first below it that is neither at its end nor left behind by this thread."""
    while isinstance(hook, _Lost) and hook._thread in (None, threading.get_ident()):
        hook = hook._next
    return hook
