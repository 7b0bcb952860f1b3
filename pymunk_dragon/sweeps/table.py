"""The table of a sweep, and the partial table: its finished points in a file, so that it can go on after an end.

Each line of a partial table is JSON and, after a comma, its checksum. The first line describes the sweep; each other
line has the number of a point, its values by name, and the reason why there are none. A line is complete with its end.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from io import StringIO
from itertools import chain, product
from math import prod
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arguments import word
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._language import text
from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError
from pymunk_dragon.studies import Result
from pymunk_dragon.sweeps.axes import Axes, varied
from pymunk_dragon.sweeps.quantities import Outcome, Quantity, Values

# Endings of tables and pictures.
_TABLE = ".csv"
_PICTURES = (".png", ".svg", ".pdf")


class Partial:
    """Outcomes of points by their numbers, `rows`, also in a file beside the first of `files` until this context ends.

    `sweep` has all that determines them. After an exception the file stays.
    """

    def __init__(self, files: Sequence[Path], sweep: dict[str, Any], axes: Axes, *, resume: bool) -> None:
        self.axes = axes
        self.count = prod(map(len, axes.values()))
        self.rows: dict[int, Outcome] = {}
        self.path = Path(f"{files[0]}.partial") if files else None
        # What the file does not have yet.
        self._head = _sealed(sweep)
        if self.path is not None and self.path.exists() and self.path.stat().st_size:
            self._read(self.path, resume)
        self.resumed = len(self.rows)

    def _read(self, path: Path, resume: bool) -> None:
        """Take the rows from a file, and cut an unfinished last line off."""
        if not resume:
            table = str(path.with_suffix(""))
            raise ParameterError("output", table, f"another table or one to resume: {path} has points of it")
        content = path.read_bytes()
        *lines, unfinished = content.split(b"\n")
        if not lines and not self._head.startswith(unfinished):
            raise FileFormatError(path, "not the partial table of a sweep")
        values = [_opened(path, line, number) for number, line in enumerate(lines, start=1)]
        if lines:
            if lines[0] != self._head[:-1]:
                raise FileFormatError(path, "of another sweep: its axes, scenario, quantity, code or version differ")
            self._head = b""
        self.rows = {number: (found, error) for number, found, error in values[1:]}
        os.truncate(path, len(content) - len(unfinished))

    def missing(self) -> Iterator[tuple[int, dict[str, float]]]:
        """Numbers of the points without an outcome, and their values of the axes."""
        for number, point in enumerate(product(*self.axes.values())):
            if number not in self.rows:
                yield number, dict(zip(self.axes, point, strict=True))

    def append(self, rows: Mapping[int, Outcome]) -> None:
        """Add the outcomes of points; they are on the disk when this returns. May raise an `OutputError`."""
        if self.path is not None:
            try:
                with self.path.open("ab") as file:
                    file.write(self._head + b"".join(_sealed([number, *outcome]) for number, outcome in rows.items()))
                    file.flush()
                    os.fsync(file.fileno())
            except OSError as error:
                raise OutputError(self.path, error.strerror) from error
            self._head = b""
        self.rows.update(rows)

    def __enter__(self) -> Partial:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if self.path is None:
            return
        if error is None:
            self.path.unlink(missing_ok=True)
        elif self.rows:
            points = f"{len(self.rows)} of {self.count} points"
            error.add_note(f"{points} are in {self.path}, from where the sweep can be resumed")


class Sweep(Result):
    """Result of a sweep: a table with a row for each point.

    Attributes
    ----------
    names, columns : tuple of str
        Names of the axes, and of all columns: the axes, the values of the quantity, and `error`.
    points, failed, resumed : int
        Number of all points, of those without values, and of those that were finished before.
    quantity, seconds : str and float
        Name of the quantity; wall time, s.
    axes, reference : mapping
        Values of each axis, and the scenario's own value or nan.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> from pymunk_dragon import Scenario, sweep
    >>> found = sweep(Scenario(benches=16, turns=8), {"width": [0.3, 0.4]}, executor=ThreadPoolExecutor(1))
    >>> found.points, found.column("width").tolist()
    (2, [0.3, 0.4])
    """

    def __init__(self, quantity: Quantity, partial: Partial, reference: Values, seconds: float) -> None:
        self.quantity, self.summary = quantity.name, quantity.summary
        self.axes, self.reference = partial.axes, reference
        self.names = tuple(self.axes)
        self.points = partial.count
        self._values, self._errors = zip(*map(partial.rows.__getitem__, range(self.points)), strict=True)
        self._of_quantity = list(dict.fromkeys(chain.from_iterable(filter(None, self._values))))
        self.columns = (*self.names, *self._of_quantity, "error")
        self.failed = self.points - self._errors.count(None)
        self.resumed = partial.resumed
        self.seconds = seconds

    def rows(self) -> Iterator[list[Any]]:
        """The rows of the table in the order of the grid, each with a value or None for each column."""
        for point, values, error in zip(product(*self.axes.values()), self._values, self._errors, strict=True):
            yield [*point, *map((values or {}).get, self._of_quantity), error]

    def column(self, name: str) -> NDArray[Any]:
        """A column (P,): numbers, with nan where there is none, or objects if it has texts or only whole numbers."""
        position = self.columns.index(word("column", name, self.columns))
        values = [row[position] for row in self.rows()]
        kinds = set(map(type, values))
        return np.array(values, dtype=float if float in kinds and str not in kinds else object)

    def write(self, path: str | Path) -> None:
        """Write the table as CSV, or a picture of it as PNG, SVG or PDF; errors are those of `sweep`."""
        destination = check_format(path, self.axes)
        if destination.suffix.lower() != _TABLE:
            self.write_figure(destination)
            return
        with written_in_place(destination) as draft, draft.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(f"{line}\n" for line in self.csv())

    def csv(self) -> list[str]:
        """Lines of the table as CSV: numbers with all their digits, nothing for None."""
        table = StringIO()
        csv.writer(table, lineterminator="\n").writerows([self.columns, *self.rows()])
        return table.getvalue().splitlines()

    def to_dict(self) -> dict[str, Any]:
        """Numbers of points and wall time, as `sweep --json` prints them."""
        return {name: getattr(self, name) for name in ("points", "failed", "resumed", "seconds")}

    def _lines(self) -> list[str]:
        points, names = text("{count} points of {quantity} over {names}"), text(" and ").join(self.names)
        counts = [points.format(count=self.points, quantity=self.quantity, names=names)]
        counts += [text("{count} resumed").format(count=self.resumed)] if self.resumed else []
        counts += [text("{count} failed").format(count=self.failed)] if self.failed else []
        return [", ".join(counts) + f": {self.seconds:.1f} s"]

    def _draw(self) -> Any:
        from pymunk_dragon.sweeps.figure import draw

        return draw(self)


def check_format(path: str | Path, axes: Axes) -> Path:
    """`path`, if a table or a picture over these axes can be written to it."""
    destination = check_destination(path, (_TABLE, *_PICTURES))
    if destination.suffix.lower() != _TABLE:
        library("matplotlib")
        if len(varied(axes)) > 2:
            raise ParameterError("output", str(path), "a table, .csv, of more than two axes")
    return destination


def _sealed(values: Any) -> bytes:
    """A line of the partial table: JSON of values, and its checksum."""
    content = json.dumps(values).encode()
    return b"%s,%08x\n" % (content, crc32(content))


def _opened(path: Path, line: bytes, number: int) -> Any:
    """The values of a line, whose checksum must be right."""
    content, _, checksum = line.rpartition(b",")
    if checksum != b"%08x" % crc32(content):
        raise FileFormatError(path, f"line {number} of this partial table is damaged")
    return json.loads(content)
