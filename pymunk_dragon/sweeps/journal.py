"""The finished points of a sweep in a file, so that a sweep that was ended can go on.

The file has lines of JSON. The first describes the sweep; each other line has the number of a point, its values by name
or null, and the reason why there are none or null. A line is complete when its end is written.
"""

from __future__ import annotations

import json
import os
import tempfile
import weakref
from array import array
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

from pymunk_dragon._signals import signals_held
from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError
from pymunk_dragon.sweeps.axes import MAX_POINTS
from pymunk_dragon.sweeps.evaluation import Outcome

try:
    import fcntl
except ImportError:  # Windows has no such locks.
    fcntl = None  # type: ignore[assignment]  # None if there is no such module.

# Ending of a journal, after the name of the table.
ENDING = ".journal"
# Characters of a value in the message on what has changed.
SHOWN = 60
# Offset of a point that is not in the file.
ABSENT = -1


class Journal:
    """Outcomes of points by their numbers, in a file.

    Only the offset of each line is in memory. Without a path the file has no name and ends with the program.

    Parameters
    ----------
    path : Path or None
        The file.
    sweep : mapping
        Plain values that determine all outcomes.
    resume : bool
        Whether to keep the points that the file has.

    Raises
    ------
    ParameterError
        If the file has points that would be lost, is in use, or cannot be written.
    FileFormatError
        If the file is of another sweep, which names the difference, or no journal.
    """

    def __init__(self, path: Path | None, sweep: Mapping[str, Any], *, resume: bool) -> None:
        self.path = path
        self._offsets = array("q")
        self._count = 0
        try:
            self._open()
        except OSError as error:
            raise ParameterError("output", str(path), f"in a folder that can be written ({error.strerror})") from error
        try:
            self._lock()
            self._begin(sweep, resume)
        except BaseException as error:
            if isinstance(error, OutputError):
                # It has no line yet.
                self.remove()
            self.close()
            raise
        self.resumed = self._count

    def _open(self) -> None:
        if self.path is None:
            descriptor, name = tempfile.mkstemp(prefix="pymunk-dragon-")
        else:
            name = str(self.path)
            descriptor = os.open(name, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        self._descriptor = descriptor
        self._file: BinaryIO = open(name, "rb")  # noqa: SIM115  # Open as long as the journal.
        self.close = weakref.finalize(self, _close, self._file, descriptor)
        if self.path is None:
            os.unlink(name)

    def _lock(self) -> None:
        """Hold a lock on the file, unless another sweep does, or has removed the file since it was opened."""
        if self.path is None:
            return
        try:
            if fcntl is not None:
                fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            is_free = self.path.exists() and os.path.samestat(os.stat(self.path), os.fstat(self._descriptor))
        except BlockingIOError:
            is_free = False
        except OSError:  # Some file systems have no locks.
            is_free = True
        if not is_free:
            raise ParameterError("output", str(self.path).removesuffix(ENDING), "a table of no other running sweep")

    def _begin(self, sweep: Mapping[str, Any], resume: bool) -> None:
        """Read the points of an earlier sweep, or write the first line."""
        first = self._file.readline()
        end = len(first) if first.endswith(b"\n") else 0
        description = _encoded(sweep)
        if first and not first.startswith(b"{"):
            raise FileFormatError(self.path, "not a journal of a sweep")
        if end:
            before = self._line(first, 1)
            last = self._read_offsets(end)
            if resume and first != description:
                raise FileFormatError(self.path, f"of another sweep: {_difference(before, json.loads(description))}")
            if self._count and not resume:
                kept = f"{self.path} has {self._count} finished points of an interrupted sweep"
                raise ParameterError(
                    "output", str(self.path).removesuffix(ENDING), f"one to resume, or another: {kept}"
                )
            end = last
        if not resume:
            end = 0
        os.ftruncate(self._descriptor, end)
        # Bytes that were behind this end stay in no buffer.
        self._file.seek(0, os.SEEK_END)
        self._end = end
        if not end:
            self._write(description)

    def _read_offsets(self, end: int) -> int:
        """Note the offset of each line after the first, which ends at `end`; returns the end of the last whole line."""
        number = 1
        for line in self._file:
            number += 1
            if not line.endswith(b"\n"):
                break
            index, _, _ = self._line(line, number)
            self._note(index, end)
            end += len(line)
        return end

    def _line(self, line: bytes, number: int) -> Any:
        """The content of a line."""
        try:
            content = json.loads(line)
        except (ValueError, RecursionError):
            content = None
        if number == 1 and isinstance(content, dict):
            return content
        if number > 1 and isinstance(content, list) and len(content) == 3:
            index, values, error = content
            known = isinstance(values, dict | None) and isinstance(error, str | None)
            if known and isinstance(index, int) and index in range(2 * MAX_POINTS):
                return content
        raise FileFormatError(self.path, f"not a journal of a sweep: line {number} is damaged")

    def _note(self, index: int, offset: int) -> None:
        missing = index + 1 - len(self._offsets)
        if missing > 0:
            self._offsets.extend([ABSENT] * missing)
        self._count += self._offsets[index] == ABSENT
        self._offsets[index] = offset

    def __len__(self) -> int:
        return self._count

    def __contains__(self, index: int) -> bool:
        return index < len(self._offsets) and self._offsets[index] != ABSENT

    def __getitem__(self, index: int) -> Outcome:
        self._file.seek(self._offsets[index])
        _, values, error = json.loads(self._file.readline())
        return values, error

    def append(self, outcomes: Iterable[tuple[int, Outcome]]) -> None:
        """Write the outcomes of points; they are on the disk when this returns.

        Raises
        ------
        OutputError
            If they cannot be written.
        """
        lines = [(index, _encoded([index, *outcome])) for index, outcome in outcomes]
        offset = self._end
        # Lines in the file are also counted when Ctrl-C comes.
        with signals_held():
            self._write(b"".join(line for _, line in lines))
            for index, line in lines:
                self._note(index, offset)
                offset += len(line)

    def _write(self, content: bytes) -> None:
        """Append whole lines, or nothing."""
        try:
            written = 0
            while written < len(content):
                written += os.write(self._descriptor, content[written:])
            os.fsync(self._descriptor)
        except OSError as error:
            with suppress(OSError):
                os.ftruncate(self._descriptor, self._end)
            raise OutputError(self.path or tempfile.gettempdir(), error.strerror or str(error)) from error
        self._end += len(content)

    def remove(self) -> None:
        """Remove the file's name; what it holds can still be read until `close`."""
        if self.path is not None:
            with suppress(OSError):  # Windows removes no open file.
                os.unlink(self.path)


def _close(file: BinaryIO, descriptor: int) -> None:
    """Close the file of a journal, which is done at the latest when the journal is not used any more."""
    file.close()
    with suppress(OSError):
        os.close(descriptor)


def _encoded(content: Any) -> bytes:
    return json.dumps(content, separators=(",", ":")).encode() + b"\n"


def _difference(before: Mapping[str, Any], now: Mapping[str, Any], prefix: str = "") -> str:
    """The first value in which two descriptions differ."""
    for name in dict.fromkeys([*before, *now]):
        old, new = before.get(name), now.get(name)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            return _difference(old, new, f"{name} ")
        return f"{prefix}{name} was {_shown(old)}, but is {_shown(new)}"
    return "the order of the axes differs"


def _shown(value: object) -> str:
    """A value in a message; a list by its length and ends if it is long."""
    text = json.dumps(value)
    if len(text) > SHOWN and isinstance(value, list):
        return f"{len(value)} values from {json.dumps(value[0])} to {json.dumps(value[-1])}"
    return text if len(text) <= SHOWN else text[: SHOWN - 3] + "..."
