"""Every exception a user of the package can meet, one line each."""

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

# Characters of a value that a message shows. Longer values lose their middle: the name of a file is at the end.
MAX_SHOWN = 80


def one_line(text: str) -> str:
    """A text with single spaces, and escapes for what a terminal would act upon or could not show."""
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in " ".join(text.split())
    )


class DragonError(Exception):
    """Base of every error that the package raises on purpose; its message is one line, and it can be pickled."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))

    def __reduce__(self) -> tuple[Callable[..., DragonError], tuple[Any, ...]]:
        # An exception's default is to call its class with the message, which breaks a process pool's answer.
        return _rebuilt, (type(self), self.args, self.__dict__)


class ParameterError(DragonError, ValueError):
    """A parameter has a value that cannot be used.

    Parameters
    ----------
    name : str
        The parameter's name.
    value : object
        What was given.
    bound : str
        What is allowed, as words that follow "must be".
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
    """

    def __init__(self, time: float, handle: int, reason: str) -> None:
        super().__init__(f"handle {handle} has no place at t = {time:.6g} s: {reason}")
        self.time = time
        self.handle = handle
        self.reason = reason


class FileFormatError(DragonError, ValueError):
    """A file that was read is damaged, foreign or of another version."""

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(f"{path}: {reason}")
        self.path = path
        self.reason = reason


class OutputError(DragonError, OSError):
    """A file could not be written, and nothing was left behind."""

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(f"cannot write {path}: {reason}")
        self.path = path
        self.reason = reason


class MissingExtraError(DragonError, ImportError):
    """A feature needs an optional dependency that is not installed."""

    def __init__(self, feature: str, extra: str) -> None:
        super().__init__(f"{feature} needs: pip install 'pymunk-dragon[{extra}]'")
        self.feature = feature
        self.extra = extra


def _rebuilt(kind: type[DragonError], args: tuple[Any, ...], state: dict[str, Any]) -> DragonError:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error


def _shown(value: object) -> str:
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # An integer of more than 4300 digits, or lists in hundreds of lists.
        return f"a {type(value).__name__} that cannot be shown"
    half = (MAX_SHOWN - 3) // 2
    return text if len(text) <= MAX_SHOWN else f"{text[:half]}...{text[-half:]}"
