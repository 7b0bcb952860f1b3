"""The partial table of a sweep: finished points in a file, from which an interrupted sweep goes on.

Each line is JSON and, after a comma, its checksum. The first line describes the sweep; each other
line has the number of a point, its values by name, and the reason why there are none. A line is
complete with its end.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError
from pymunk_dragon.sweeps.axes import Axes
from pymunk_dragon.sweeps.quantities import Outcome


class PartialTable:
    """Outcomes of points by their numbers, `rows`.

    Until this context ends, they are also in a file beside the first of `files`; after an exception
    the file stays. `description` has all values that determine the outcomes.
    """

    def __init__(
        self,
        files: Sequence[Path],
        description: dict[str, Any],
        axes: Axes,
        *,
        resume: bool,
    ) -> None:
        self.axes = axes
        # Points to evaluate that are known by now.
        self.count = 0
        self.rows: dict[int, Outcome] = {}
        self.path = Path(f"{files[0]}.partial") if files else None
        # Content of the first line, until it is in the file.
        self._description = _encoded(description)
        if self.path and self.path.exists() and self.path.stat().st_size:
            self._read(self.path, resume)
        self.resumed = len(self.rows)

    def _read(self, path: Path, resume: bool) -> None:
        """Take the rows from a file, and cut an unfinished last line off."""
        if not resume:
            table = str(path.with_suffix(""))
            bound = f"another table or one to resume: {path} has points of it"
            raise ParameterError("output", table, bound)
        content = path.read_bytes()
        *lines, unfinished = content.split(b"\n")
        if not lines and not self._description.startswith(unfinished):
            raise FileFormatError(path, "not the partial table of a sweep")
        values = [_decoded(path, line, number) for number, line in enumerate(lines, start=1)]
        if lines:
            if lines[0] != self._description[:-1]:
                reason = "of another sweep: its axes, scenario, quantity, code or version differ"
                raise FileFormatError(path, reason)
            self._description = b""
        self.rows = {number: (outcome, error) for number, outcome, error in values[1:]}
        os.truncate(path, len(content) - len(unfinished))

    def point(self, number: int) -> list[float]:
        """Values of the axes at a point."""
        indices = np.unravel_index(number, [len(values) for values in self.axes.values()])
        return [values[index] for values, index in zip(self.axes.values(), indices, strict=True)]

    def missing(self, numbers: Iterable[int]) -> Iterator[tuple[int, dict[str, float]]]:
        """Those of the points that have no outcome, and their values of the axes."""
        for number in numbers:
            if number not in self.rows:
                yield number, dict(zip(self.axes, self.point(number), strict=True))

    def append(self, rows: Mapping[int, Outcome]) -> None:
        """Add the outcomes of points; they are on the disk when this returns.

        Raises an `OutputError` if they cannot be written.
        """
        if self.path is not None:
            lines = [_encoded([number, *outcome]) for number, outcome in rows.items()]
            try:
                with self.path.open("ab") as file:
                    file.write(self._description + b"".join(lines))
                    file.flush()
                    os.fsync(file.fileno())
            except OSError as error:
                raise OutputError(self.path, error.strerror) from error
            self._description = b""
        self.rows.update(rows)

    def __enter__(self) -> PartialTable:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if self.path is None:
            return
        if error is None:
            self.path.unlink(missing_ok=True)
        elif self.rows:
            points = f"{len(self.rows)} of {self.count} points"
            error.add_note(f"{points} are in {self.path}, from where the sweep can be resumed")


def _encoded(values: Any) -> bytes:
    """A line of the partial table: JSON of values, and its checksum."""
    content = json.dumps(values).encode()
    return b"%s,%08x\n" % (content, crc32(content))


def _decoded(path: Path, line: bytes, number: int) -> Any:
    """The values of a line, whose checksum must be right."""
    content, _, checksum = line.rpartition(b",")
    if checksum != b"%08x" % crc32(content):
        raise FileFormatError(path, f"line {number} of this partial table is damaged")
    return json.loads(content)
