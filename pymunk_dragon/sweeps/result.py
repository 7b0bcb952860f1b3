"""Result of a sweep: a table, and pictures of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import word
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._language import text
from pymunk_dragon.studies import Result
from pymunk_dragon.sweeps.evaluation import Outcome
from pymunk_dragon.sweeps.journal import Journal
from pymunk_dragon.sweeps.plan import Plan, Points
from pymunk_dragon.sweeps.quantities import Values
from pymunk_dragon.sweeps.table import WRITERS, Row, csv_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Formats of a picture.
PICTURES = (".png", ".svg", ".pdf")
# All formats.
FORMATS = (*WRITERS, *PICTURES)


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
    reference : mapping
        Values of the scenario's parameters that are axes.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> from pymunk_dragon import Scenario, sweep
    >>> found = sweep(Scenario(benches=16, turns=8), {"pitch": [0.5, 0.55]}, executor=ThreadPoolExecutor(1))
    >>> found.columns
    ('pitch', 'contact_time', 'bench_a', 'bench_b', 'status', 'error')
    >>> found.column("bench_b").tolist()
    [14, 8]
    """

    def __init__(self, plan: Plan, points: Points, journal: Journal, seconds: float) -> None:
        self.quantity = plan.quantity.name
        self.names = plan.axes.names
        self.points = len(points)
        self.resumed = journal.resumed
        self.seconds = seconds
        self.reference = plan.reference
        self._summary = plan.quantity.summary
        self._points = points
        self._journal = journal
        self.failed = 0
        known = dict.fromkeys(plan.quantity.columns)
        for values, error in self._outcomes():
            self.failed += error is not None
            if not plan.quantity.columns and values is not None:
                known |= dict.fromkeys(values)
        self._of_quantity = tuple(known)
        self.columns = (*self.names, *known, "error")

    def _outcomes(self) -> Iterator[Outcome]:
        return map(self._journal.__getitem__, range(self.points))

    def rows(self) -> Iterator[Row]:
        """The rows of the table in the order of the grid, each with a value or None for each column."""
        for index, (values, error) in enumerate(self._outcomes()):
            found = values or {}
            yield [*self._points[index], *(found.get(name) for name in self._of_quantity), error]

    def column(self, name: str) -> NDArray[Any]:
        """A column (P,): numbers, with nan where there is none, or objects if it has texts or only whole numbers."""
        position = self.columns.index(word("column", name, self.columns))
        values = [row[position] for row in self.rows()]
        if any(isinstance(value, float) for value in values) and not any(isinstance(value, str) for value in values):
            return np.array(values, dtype=float)
        return np.array(values, dtype=object)

    def write(self, path: str | Path) -> None:
        """Write the table as CSV or Parquet, or a picture of it as PNG, SVG or PDF.

        Raises
        ------
        ParameterError
            If the ending is none of these, or the file cannot be created.
        MissingExtraError
            If Parquet or pictures are not installed.
        OutputError
            If writing fails.
        """
        destination = check_destination(path, FORMATS)
        if (ending := destination.suffix.lower()) in PICTURES:
            self.write_figure(destination)
            return
        with written_in_place(destination) as draft:
            WRITERS[ending](draft, self.columns, self.rows)

    def csv(self) -> Iterator[str]:
        """Lines of the table as CSV."""
        return csv_lines(self.columns, self.rows())

    def to_dict(self) -> dict[str, Any]:
        """Numbers of points and wall time, as `sweep --json` prints them."""
        return {name: getattr(self, name) for name in ("points", "failed", "resumed", "seconds")}

    def _lines(self) -> list[str]:
        points, names = text("{count} points of {quantity} over {names}"), text(" and ").join(self.names)
        counts = [points.format(count=self.points, quantity=self.quantity, names=names)]
        if self.resumed:
            counts.append(text("{count} resumed").format(count=self.resumed))
        if self.failed:
            counts.append(text("{count} failed").format(count=self.failed))
        return [", ".join(counts) + f": {self.seconds:.1f} s"]

    def _draw(self) -> Figure:
        from pymunk_dragon.sweeps.figure import Map, draw

        rows = list(self.rows())
        width = len(self.names)
        numbers = [row[width] for row in rows]
        status = self._of_quantity.index("status") if "status" in self._of_quantity else None
        subtitle = text("{0} at {1} points, {2} failed") if self.failed else text("{0} at {1} points")
        return draw(
            Map(
                names=self.names,
                points=np.array([row[:width] for row in rows], dtype=float),
                column=self._of_quantity[0] if self._of_quantity else "error",
                values=np.array([number if isinstance(number, int | float) else np.nan for number in numbers]),
                labels=[label(values) for values, _ in self._outcomes()],
                statuses=[
                    "failed" if row[-1] is not None else None if status is None else row[width + status] for row in rows
                ],
                reference=self.reference,
                title=text(self._summary),
                subtitle=subtitle.format(self.quantity, self.points, self.failed),
            )
        )


def label(values: Values | None) -> tuple[Any, ...] | None:
    """What is discrete in the values of a quantity: all but the size of a number; None for a point that failed."""
    if values is None:
        return None
    return tuple("number" if isinstance(value, float) else value for value in values.values())
