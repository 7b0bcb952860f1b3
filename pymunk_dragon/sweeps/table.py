"""The table of a sweep, and the partial table: its finished points in a file, so that it can go on after an end.

A partial table is CSV. The last cell of each line is a checksum of the others. The first line describes the sweep in
JSON; each other line has the number of a point, its values by name in JSON, and the reason why there are none. A line
is complete with its end.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from io import StringIO
from itertools import product
from pathlib import Path
from reprlib import repr as shortened
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import word
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._language import text
from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError
from pymunk_dragon.studies import Result
from pymunk_dragon.sweeps.quantities import Outcome, Quantity, Values

# Values of each axis.
Axes = Mapping[str, tuple[float, ...]]

# Endings of tables and pictures.
TABLE = ".csv"
PICTURES = (".png", ".svg", ".pdf")


class Partial:
    """Outcomes of points by their numbers, `rows`, also in a file at `path`; `sweep` has all that determines them."""

    def __init__(self, path: Path | None, sweep: Mapping[str, Any], *, resume: bool) -> None:
        self.path = path
        self.rows: dict[int, Outcome] = {}
        self._first = _sealed(json.dumps(sweep))
        self._begun = False
        if path is not None and path.exists() and (content := path.read_bytes()):
            if not resume:
                table = str(path.with_suffix(""))
                raise ParameterError("output", table, f"another table or one to resume: {path} has points of it")
            self._read(path, content)
        self.resumed = len(self.rows)

    def _read(self, path: Path, content: bytes) -> None:
        """Take the rows from a file, and cut an unfinished last line off."""
        *lines, unfinished = content.split(b"\n")
        if not lines and not self._first.startswith(unfinished):
            raise FileFormatError(path, "not the partial table of a sweep")
        texts = [_opened(path, line, number) for number, line in enumerate(lines, start=1)]
        if lines and lines[0] != self._first[:-1]:
            before, now = json.loads(texts[0]), json.loads(_opened(path, self._first[:-1], 1))
            name = next((name for name in {**before, **now} if before.get(name) != now.get(name)), "sign")
            changed = f"{name} was {shortened(before.get(name))}, but is {shortened(now.get(name))}"
            raise FileFormatError(path, f"of another sweep: {changed}")
        csv.field_size_limit(max(csv.field_size_limit(), len(content)))
        for number, values, error in csv.reader(texts[1:]):
            self.rows[int(number)] = json.loads(values), error or None
        self._begun = bool(lines)
        if unfinished:
            os.truncate(path, len(content) - len(unfinished))

    def append(self, rows: Mapping[int, Outcome]) -> None:
        """Add the outcomes of points; they are on the disk when this returns. May raise an `OutputError`."""
        if self.path is not None and rows:
            cells = ([number, json.dumps(values), error] for number, (values, error) in rows.items())
            lines = [_sealed(_csv_line(each)) for each in cells]
            try:
                with self.path.open("ab") as file:
                    file.write(b"".join(lines if self._begun else [self._first, *lines]))
                    file.flush()
                    os.fsync(file.fileno())
            except OSError as error:
                raise OutputError(self.path, error.strerror or str(error)) from error
            self._begun = True
        self.rows.update(rows)


class Sweep(Result):
    """Result of a sweep: a table with a row for each point.

    Attributes
    ----------
    quantity : str
        Name of the quantity.
    names, columns : tuple of str
        Names of the axes, and of all columns: the axes, the values of the quantity, and `error`.
    points, failed, resumed : int
        Number of all points, of those without values, and of those that were finished before.
    seconds : float
        Wall time, s.
    axes, reference : mapping
        Values of each axis, and the scenario's own value.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> from pymunk_dragon import Scenario, sweep
    >>> found = sweep(Scenario(benches=16, turns=8), {"width": [0.3, 0.4]}, executor=ThreadPoolExecutor(1))
    >>> found.points, found.column("width").tolist()
    (2, [0.3, 0.4])
    """

    def __init__(self, quantity: Quantity, axes: Axes, partial: Partial, reference: Values, seconds: float) -> None:
        self.quantity = quantity.name
        self.summary = quantity.summary
        self.axes = axes
        self.names = tuple(axes)
        self.points = len(partial.rows)
        self._outcomes = [partial.rows[number] for number in range(self.points)]
        self._of_quantity = list(dict.fromkeys(name for values, _ in self._outcomes for name in values or ()))
        self.columns = (*self.names, *self._of_quantity, "error")
        self.failed = sum(error is not None for _, error in self._outcomes)
        self.resumed = partial.resumed
        self.reference = reference
        self.seconds = seconds

    def rows(self) -> Iterator[list[Any]]:
        """The rows of the table in the order of the grid, each with a value or None for each column."""
        for point, (values, error) in zip(product(*self.axes.values()), self._outcomes, strict=True):
            yield [*point, *((values or {}).get(name) for name in self._of_quantity), error]

    def column(self, name: str) -> NDArray[Any]:
        """A column (P,): numbers, with nan where there is none, or objects if it has texts or only whole numbers."""
        position = self.columns.index(word("column", name, self.columns))
        values = [row[position] for row in self.rows()]
        kinds = set(map(type, values))
        return np.array(values, dtype=float if float in kinds and str not in kinds else object)

    def write(self, path: str | Path) -> None:
        """Write the table as CSV, or a picture of it as PNG, SVG or PDF.

        Raises
        ------
        ParameterError
            If the ending is none of these, the file cannot be created, or a picture had more than two axes.
        MissingExtraError, OutputError
            If matplotlib is needed and not installed; if writing fails.
        """
        destination = check_format(path, self.axes)
        if destination.suffix.lower() != TABLE:
            self.write_figure(destination)
            return
        with written_in_place(destination) as draft, draft.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(f"{line}\n" for line in self.csv())

    def csv(self) -> Iterator[str]:
        """Lines of the table as CSV: numbers with all their digits, nothing for None."""
        yield _csv_line(self.columns)
        yield from map(_csv_line, self.rows())

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
    destination = check_destination(path, (TABLE, *PICTURES))
    if destination.suffix.lower() != TABLE:
        library("matplotlib")
        if sum(len(set(values)) > 1 for values in axes.values()) > 2:
            raise ParameterError("output", str(path), "a table, .csv, of more than two axes")
    return destination


def _csv_line(cells: Iterable[Any]) -> str:
    """Cells as a line of CSV without its end: numbers with all their digits, nothing for None."""
    line = StringIO()
    csv.writer(line, lineterminator="").writerow(cells)
    return line.getvalue()


def _sealed(content: str) -> bytes:
    """A line of the partial table with its checksum."""
    return b"%s,%08x\n" % (content.encode(), crc32(content.encode()))


def _opened(path: Path, line: bytes, number: int) -> str:
    """A line without its checksum, which must be right."""
    content, _, checksum = line.rpartition(b",")
    if checksum != b"%08x" % crc32(content):
        raise FileFormatError(path, f"line {number} of this partial table is damaged")
    return content.decode()
