"""The exceptions that the package raises on purpose. The message of each is one line."""

from __future__ import annotations

from reprlib import Repr

# Values in messages. A longer one loses its middle, because a path ends with the name of the file.
_SHORT = Repr()
_SHORT.maxother = 80


def one_line(text: str) -> str:
    """`text` with single spaces, and escape sequences for control characters."""
    words = " ".join(text.split())
    return "".join(
        each if each.isprintable() else each.encode("unicode_escape").decode() for each in words
    )


class DragonError(Exception):
    """Base class of the package's exceptions."""

    # The message, with the arguments.
    _form = "{0}"

    def __str__(self) -> str:
        return one_line(self._form.format(*self.args))


class ParameterError(DragonError, ValueError):
    """The parameter `name` has a `value` that is not allowed; `bound` follows the words "must be".

    Examples
    --------
    >>> print(ParameterError("pitch", -1, "a number above 0"))
    pitch is -1, but must be a number above 0
    """

    def __init__(self, name: str, value: object, bound: str) -> None:
        super().__init__(name, value, bound)
        self.name, self.value, self.bound = name, value, bound

    def __str__(self) -> str:
        # Also of a value whose own text cannot be made, as of an integer of 5000 digits.
        return one_line(
            f"{self.name} is {_SHORT.repr_instance(self.value, 1)}, but must be {self.bound}"
        )


class UnreachableError(DragonError):
    """At a `time` in s a `handle`, the first such one, has no position on the curve, for a `reason`."""

    _form = "handle {1} has no position at t = {0:.6g} s: {2}"

    def __init__(self, time: float, handle: int, reason: str) -> None:
        super().__init__(time, handle, reason)
        self.time, self.handle, self.reason = time, handle, reason


class FileFormatError(DragonError, ValueError):
    """A file, of a path, is damaged, of another format or of another version, for a reason."""

    _form = "{0}: {1}"


class OutputError(DragonError, OSError):
    """A file, of a path, could not be written, for a reason; no part of it is left."""

    _form = "cannot write {0}: {1}"


class MissingExtraError(DragonError, ImportError):
    """A feature needs a library that is not installed, of some optional dependencies of the package."""

    _form = "{0} needs: pip install 'pymunk-dragon[{1}]'"
