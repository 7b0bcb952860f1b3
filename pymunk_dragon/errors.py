"""The exceptions that the package raises on purpose. The message of each is one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = [
    "DragonError",
    "FileFormatError",
    "MissingExtraError",
    "OutputError",
    "ParameterError",
    "UnreachableError",
    "one_line",
]

# Characters of a value in a message. Longer values lose their middle, because a path ends with the name of the file.
MAX_SHOWN = 80


def one_line(text: str) -> str:
    r"""`text` with single spaces, and escape sequences for control characters.

    Examples
    --------
    >>> one_line("two\nlines   and \x1b[1m")
    'two lines and \\x1b[1m'
    """
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in " ".join(text.split())
    )


class DragonError(Exception):
    """Base class of the package's exceptions. They can be pickled.

    Examples
    --------
    >>> from pymunk_dragon import Dragon
    >>> try:
    ...     Dragon(benches=1)
    ... except DragonError as error:
    ...     print(error)
    benches is 1, but must be a whole number from 2 to 10000
    """

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))

    def __reduce__(self) -> tuple[Callable[..., DragonError], tuple[Any, ...]]:
        # By default an exception is unpickled by calling its class with the message, which is not what ours take.
        return _unpickled, (type(self), self.args, self.__dict__)


def _unpickled(kind: type[DragonError], args: tuple[Any, ...], state: dict[str, Any]) -> DragonError:
    """An error of a class with its arguments and attributes, without a call of `__init__`."""
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error


class ParameterError(DragonError, ValueError):
    """A parameter has a value that is not allowed.

    Parameters
    ----------
    name : str
        Name of the parameter.
    value : object
        The value.
    bound : str
        What is allowed, worded to follow "must be".

    Examples
    --------
    >>> print(ParameterError("pitch", -1, "a number above 0"))
    pitch is -1, but must be a number above 0
    """

    def __init__(self, name: str, value: object, bound: str) -> None:
        super().__init__(f"{name} is {_shown(value)}, but must be {bound}")
        self.name = name
        self.value = value
        self.bound = bound


class UnreachableError(DragonError):
    """A handle cannot be placed on the curve.

    Parameters
    ----------
    time : float
        Time of the march, s.
    handle : int
        The first handle without a coordinate.
    reason : str
        The reason.

    Examples
    --------
    >>> print(UnreachableError(443.0, 0, "the curve ends at t = 442.59 s"))
    handle 0 has no position at t = 443 s: the curve ends at t = 442.59 s
    """

    def __init__(self, time: float, handle: int, reason: str) -> None:
        super().__init__(f"handle {handle} has no position at t = {time:.6g} s: {reason}")
        self.time = time
        self.handle = handle
        self.reason = reason


class FileFormatError(DragonError, ValueError):
    """A file that was read is damaged, of another format or of another version.

    Examples
    --------
    >>> print(FileFormatError("run.npz", "not a run"))
    run.npz: not a run
    """

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(f"{path}: {reason}")
        self.path = path
        self.reason = reason


class OutputError(DragonError, OSError):
    """A file could not be written; no part of it is left.

    Examples
    --------
    >>> print(OutputError("march.gif", "No space left on device"))
    cannot write march.gif: No space left on device
    """

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(f"cannot write {path}: {reason}")
        self.path = path
        self.reason = reason


class MissingExtraError(DragonError, ImportError):
    """A feature needs an optional dependency that is not installed.

    Examples
    --------
    >>> print(MissingExtraError("a figure", "figures"))
    a figure needs: pip install 'pymunk-dragon[figures]'
    """

    def __init__(self, feature: str, extra: str) -> None:
        super().__init__(f"{feature} needs: pip install 'pymunk-dragon[{extra}]'")
        self.feature = feature
        self.extra = extra


def _shown(value: object) -> str:
    """`value` in at most MAX_SHOWN characters."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # An integer of more than 4300 digits, or lists nested hundreds deep.
        return f"a {type(value).__name__} that cannot be shown"
    half = (MAX_SHOWN - 3) // 2
    return text if len(text) <= MAX_SHOWN else f"{text[:half]}...{text[-half:]}"
