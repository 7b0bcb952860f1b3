"""The result of a sweep: a table with a row for each point, as CSV or as a picture."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from io import StringIO
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import word
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.studies import Result
from pymunk_dragon.sweeps.axes import Axes, varied
from pymunk_dragon.sweeps.partial import PartialTable
from pymunk_dragon.sweeps.quantities import Quantity, Values

# Endings of tables and pictures.
_TABLE = ".csv"
_PICTURES = (".png", ".svg", ".pdf")


class Sweep(Result):
    """Result of a sweep: a table with a row for each point.

    Attributes
    ----------
    names : tuple of str
        Names of the axes.
    columns : tuple of str
        Names of all columns: the axes, the values of the quantity, and `error`.
    points : int
        Number of all points.
    failed : int
        Number of points without values.
    resumed : int
        Number of points that were finished before.
    quantity : str
        Name of the quantity.
    seconds : float
        Wall time, s.
    axes : mapping
        Values of each axis.
    reference : mapping
        The scenario's own value of each axis, or nan.
    step : int
        Values of an axis from one line of the grid to the next: more than 1 if it is refined.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> from pymunk_dragon import Scenario, sweep
    >>> scenario, pool = Scenario(benches=16, turns=8), ThreadPoolExecutor(1)
    >>> found = sweep(scenario, {"width": [0.3, 0.4]}, executor=pool)
    >>> found.points, found.column("width").tolist()
    (2, [0.3, 0.4])
    """

    def __init__(
        self,
        quantity: Quantity,
        partial: PartialTable,
        reference: Values,
        seconds: float,
        step: int = 1,
    ) -> None:
        self.quantity = quantity.name
        self.summary = quantity.summary
        self.axes = partial.axes
        self.reference = reference
        self.names = tuple(self.axes)
        self.points = partial.count
        self.resumed = partial.resumed
        self.seconds = seconds
        self.step = step
        rows = sorted(partial.rows.items())
        self._points = [partial.point(number) for number, _ in rows]
        self._outcomes = [outcome for _, outcome in rows]
        self.failed = sum(error is not None for _, error in self._outcomes)

        # The columns in the order in which points have them.
        found = chain.from_iterable(values or () for values, _ in self._outcomes)
        self._of_quantity = list(dict.fromkeys(found))
        self.columns = (*self.names, *self._of_quantity, "error")

    def rows(self) -> Iterator[list[Any]]:
        """The rows of the table in the order of the grid, with a value or None for each column."""
        for point, (values, error) in zip(self._points, self._outcomes, strict=True):
            yield [*point, *map((values or {}).get, self._of_quantity), error]

    def column(self, name: str) -> NDArray[Any]:
        """A column (P,) of numbers, with nan where there is none.

        It has objects if some are texts, or if all numbers are whole.
        """
        position = self.columns.index(word("column", name, self.columns))
        values = [row[position] for row in self.rows()]
        kinds = set(map(type, values))
        return np.array(values, dtype=float if float in kinds and str not in kinds else object)

    def write(self, path: str | Path) -> None:
        """Write the table as CSV, or a picture of it as PNG, SVG or PDF.

        The errors are those of `sweep`.
        """
        destination = check_format(path, self.axes)
        if destination.suffix.lower() != _TABLE:
            self.write_figure(destination)
            return
        write_text(destination, "\n".join([*self.csv(), ""]))

    def csv(self) -> list[str]:
        """Lines of the table as CSV: numbers with all their digits, nothing for None."""
        table = StringIO()
        writer = csv.writer(table, lineterminator="\n")
        writer.writerows([self.columns, *self.rows()])
        return table.getvalue().splitlines()

    def to_dict(self) -> dict[str, Any]:
        """Numbers of points and wall time, as `sweep --json` prints them."""
        return {name: getattr(self, name) for name in ("points", "failed", "resumed", "seconds")}

    def _lines(self) -> list[str]:
        names = text(" and ").join(self.names)
        points = text("{count} points of {quantity} over {names}")
        counts = [points.format(count=self.points, quantity=self.quantity, names=names)]
        if self.resumed:
            counts.append(text("{count} resumed", count=self.resumed))
        if self.failed:
            counts.append(text("{count} failed", count=self.failed))
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
