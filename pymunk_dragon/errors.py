"""The exceptions that the package raises on purpose. The message of each is one line."""

from reprlib import Repr

# Values in messages. A longer one loses its middle, because a path ends with the name of the file.
_SHORT = Repr()
_SHORT.maxother = 80


def one_line(text: str) -> str:
    """`text` with single spaces, and escape sequences for control characters."""
    words = " ".join(text.split())
    escaped = [
        each if each.isprintable() else each.encode("unicode_escape").decode() for each in words
    ]
    return "".join(escaped)


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
        self.name = name
        self.value = value
        self.bound = bound

    def __str__(self) -> str:
        # `repr` itself fails for an integer of 5000 digits.
        shown = _SHORT.repr_instance(self.value, 1)
        return one_line(f"{self.name} is {shown}, but must be {self.bound}")


class UnreachableError(DragonError):
    """At a `time`, s, `handle` is the first without a position on the curve, for a `reason`."""

    _form = "handle {1} has no position at t = {0:.6g} s: {2}"

    def __init__(self, time: float, handle: int, reason: str) -> None:
        super().__init__(time, handle, reason)
        self.time = time
        self.handle = handle
        self.reason = reason


class FileFormatError(DragonError, ValueError):
    """A file, of a path, is damaged, of another format or of another version, for a reason."""

    _form = "{0}: {1}"


class OutputError(DragonError, OSError):
    """A file, of a path, could not be written, for a reason; no part of it is left."""

    _form = "cannot write {0}: {1}"


class MissingExtraError(DragonError, ImportError):
    """A feature needs a library that is not installed, of an extra of the package."""

    _form = "{0} needs: pip install 'pymunk-dragon[{1}]'"
