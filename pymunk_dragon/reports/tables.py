"""Tables of a report: SI values for data files, formatted text for documents."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._language import text
from pymunk_dragon.model.contact import ContactEvent
from pymunk_dragon.reports.summary import Summary

# Text of a missing value.
MISSING = "\u2013"
# Magnitude from which numbers are written with an exponent: beyond any simulated run, but possible in a damaged file.
EXPONENT_THRESHOLD = 1e9
# Least number of contact points with columns of their own: the engine reports at most two for a pair of benches.
MIN_POINTS = 2
# Rows of a table in a document: more would not be read, and 1000 rows already are half a megabyte of HTML.
MAX_SHOWN_ROWS = 1000


class Column(NamedTuple):
    """Column of a table.

    Attributes
    ----------
    label : str
        Heading in documents, with the unit after scaling.
    key : str
        Name in data files; ends in the SI unit.
    decimals : int or None
        Digits after the decimal point in documents; None for text and integers.
    scale : float
        Factor from the SI value to the displayed value: 1000 for mm.
    is_text : bool
        Whether the column holds text, which is aligned to the left.
    """

    label: str
    key: str = ""
    decimals: int | None = None
    scale: float = 1.0
    is_text: bool = False


NO_VECTOR = (None, None)


@dataclass(frozen=True)
class Table:
    """Rows of SI values; None for a missing value."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Any]]

    @classmethod
    def of(cls, columns: Sequence[Column], rows: Iterable[Iterable[Any]]) -> Table:
        """Table of `rows`, in which nan and infinity count as missing."""
        return cls(columns, [[value if _is_known(value) else None for value in row] for row in rows])

    @property
    def text_rows(self) -> list[list[str]]:
        """The first `MAX_SHOWN_ROWS` rows, formatted for documents."""
        return [
            [_cell_text(column, value) for column, value in zip(self.columns, row, strict=True)]
            for row in self.rows[:MAX_SHOWN_ROWS]
        ]

    @property
    def truncation_note(self) -> str:
        """A sentence on the rows that `text_rows` omits; empty if all rows are shown."""
        if len(self.rows) <= MAX_SHOWN_ROWS:
            return ""
        note = text("These are the first {shown} of {count} rows; all are in the JSON and XLSX reports.")
        return note.format(shown=MAX_SHOWN_ROWS, count=len(self.rows))


def format_number(value: float | None, decimals: int, scale: float = 1.0) -> str:
    """`value * scale` with `decimals` digits after the decimal point; never `-0`."""
    if value is None or not math.isfinite(value):
        return MISSING
    value *= scale
    if abs(value) >= EXPONENT_THRESHOLD:
        return f"{value:.{decimals}e}"
    # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


def format_length(value: float) -> str:
    """A length in m, or in mm below 1 m."""
    if not math.isfinite(value):
        return MISSING
    return f"{format_number(value, 3)} m" if abs(value) >= 1 else f"{format_number(value, 3, 1e3)} mm"


def format_vector(value: Sequence[float] | None, decimals: int) -> str:
    """A point or a direction as `(x, y)`."""
    return MISSING if value is None else "(" + ", ".join(format_number(part, decimals) for part in value) + ")"


def format_pair(benches: Sequence[int] | None) -> str:
    """Two benches as `0 and 8`."""
    return MISSING if benches is None else text("{i} and {j}").format(i=benches[0], j=benches[1])


def near_misses(summary: Summary) -> Table:
    """Near misses of the exact model, sorted by time."""
    rows = ((miss.time, *miss.benches, miss.gap) for miss in summary.near_misses or ())
    return Table.of((Column(text("time (s)"), "time_s", 4), *_bench_columns(), _gap_column()), rows)


def events(summary: Summary) -> Table:
    """Collision callbacks, a row each, with a column for each coordinate."""
    return _event_table(
        [(event.phase, event) for event in summary.run.events], Column(text("phase"), "phase", is_text=True)
    )


def all_events(summary: Summary) -> Table:
    """Near misses, first contacts (exact model and run) and callbacks, by time; `what` is their type."""
    found: list[tuple[str, Any]] = [("near_miss", near_miss) for near_miss in summary.near_misses or ()]
    if summary.exact is not None and summary.exact.status == "contact":
        found.append(("exact_contact", summary.exact))
    if summary.run.first_contact is not None:
        found.append(("first_contact", summary.run.first_contact))
    found += ((event.phase, event) for event in summary.run.events)
    # Events without a time, as in a damaged file, come last.
    found.sort(key=lambda item: item[1].time if math.isfinite(item[1].time) else math.inf)
    table = _event_table(found, Column(text("what"), "what", is_text=True))
    gaps = (getattr(event, "gap", None) for _, event in found)
    return Table.of((*table.columns, _gap_column()), ((*row, gap) for row, gap in zip(table.rows, gaps, strict=True)))


def events_as_text(summary: Summary) -> Table:
    """Collision callbacks as text, with points, vectors and pairs in one column each."""
    cells: dict[str, Callable[[ContactEvent], str]] = {
        text("time (s)"): lambda event: format_number(event.time, 4),
        text("phase"): lambda event: event.phase,
        text("benches"): lambda event: format_pair(event.benches),
        text("points (m)"): lambda event: " ".join(format_vector(point, 3) for point in event.points) or MISSING,
        text("normal"): lambda event: format_vector(event.normal, 3),
        text("depth (mm)"): lambda event: format_number(event.depth, 3, 1e3),
        text("relative velocity (m/s)"): lambda event: format_vector(event.relative_velocity, 3),
        text("impulse (N s)"): lambda event: format_vector(event.impulse, 4),
    }
    columns = [Column(label, is_text=label in (text("phase"), text("benches"))) for label in cells]
    return Table(columns, [[cell(event) for cell in cells.values()] for event in summary.run.events])


def windows(summary: Summary) -> Table:
    """Contact windows of pairs; a window has no end if the benches were in contact when the run ended."""
    times = (
        Column(text("from (s)"), "begin_s", 4),
        Column(text("to (s)"), "end_s", 4),
        Column(text("for (s)"), "length_s", 4),
    )
    rows = (
        (*window.benches, window.begin, window.end, None if window.end is None else window.end - window.begin)
        for window in summary.windows
    )
    return Table.of((*_bench_columns(), *times), rows)


def handles(summary: Summary) -> Table:
    """Positions and speeds of the reported handles, a row for each handle and time."""
    columns = (
        Column(text("time (s)"), "time_s", 6),
        Column(text("handle"), "handle"),
        Column("x (m)", "x_m", 6),
        Column("y (m)", "y_m", 6),
        Column(text("speed (m/s)"), "speed_m_s", 6),
    )
    found = summary.handles
    rows = [
        (time, handle, *position, speed)
        for time, positions, speeds in zip(found.times, found.positions.tolist(), found.speeds.tolist(), strict=True)
        for handle, position, speed in zip(found.numbers, positions, speeds, strict=True)
    ]
    return Table.of(columns, rows)


def handles_by_time(summary: Summary) -> dict[str, Table]:
    """Tables 1 and 2 of the paper: positions and speeds of handles, a column for each time.

    A contact time is last and has six decimals.
    """
    found = summary.handles
    labels = [f"{time:g} s" for time in found.times]
    if found.contact is not None:
        labels[-1] = f"{format_number(found.times[-1], 6)} s"
    columns = (Column(text("handle"), "handle", is_text=True), *(Column(label, label, 6) for label in labels))

    def table(names: Iterable[str], values: NDArray[np.float64]) -> Table:
        return Table.of(columns, ((name, *row) for name, row in zip(names, values.tolist(), strict=True)))

    # Positions (T, H, 2) as rows x, y of each handle, (2 H, T).
    positions = found.positions.reshape(len(found.times), -1).T
    return {
        text("Positions"): table((f"{handle} {axis} (m)" for handle in found.numbers for axis in "xy"), positions),
        text("Speeds"): table((f"{handle} (m/s)" for handle in found.numbers), found.speeds.T),
    }


def drift(summary: Summary) -> Table:
    """Largest position error of each frame."""
    found = summary.drift
    columns = (
        Column(text("time (s)"), "time_s", 3),
        Column(text("first {count} benches (mm)").format(count=found.head_benches), "head_drift_m", 4, 1e3),
        Column(text("any bench (mm)"), "max_drift_m", 4, 1e3),
    )
    series = (found.times.tolist(), found.head_over_time.tolist(), found.max_over_time.tolist())
    return Table.of(columns, zip(*series, strict=True))


def _bench_columns() -> tuple[Column, Column]:
    """Columns of the numbers of two benches."""
    return Column(text("bench i"), "bench_i"), Column(text("bench j"), "bench_j")


def _gap_column() -> Column:
    return Column(text("gap (mm)"), "gap_m", 3, 1e3)


def _event_table(found: Sequence[tuple[str, Any]], name: Column) -> Table:
    """A row for each (name, event). Events lack some of the attributes; first contacts have a single point."""
    all_points = [[event.point] if hasattr(event, "point") else getattr(event, "points", ()) for _, event in found]
    point_count = max([MIN_POINTS, *map(len, all_points)])
    columns = [Column(text("time (s)"), "time_s", 6), name, *_bench_columns()]
    for number in range(1, point_count + 1):
        columns += _vector_columns(text("point {number}").format(number=number), f"point{number}", "m")
    columns += _vector_columns(text("normal"), "normal", "")
    columns.append(Column(text("depth (mm)"), "depth_m", 4, 1e3))
    columns += _vector_columns(text("relative velocity"), "relative_velocity", "m_s")
    columns += _vector_columns(text("impulse"), "impulse", "N_s")
    rows = []
    for (kind, event), points in zip(found, all_points, strict=True):
        vectors = [getattr(event, vector, None) or NO_VECTOR for vector in ("normal", "relative_velocity", "impulse")]
        normal, velocity, impulse = vectors
        padded = [*points, *[NO_VECTOR] * (point_count - len(points))]
        depth = getattr(event, "depth", None)
        rows.append((event.time, kind, *event.benches, *chain(*padded), *normal, depth, *velocity, *impulse))
    return Table.of(columns, rows)


def _vector_columns(label: str, key: str, unit: str) -> list[Column]:
    """Columns of the x and y coordinates of a vector."""
    suffix = f"_{unit}" if unit else ""
    shown_unit = f" ({unit.replace('m_s', 'm/s').replace('_', ' ')})" if unit else ""
    return [Column(f"{label} {axis}{shown_unit}", f"{key}_{axis}{suffix}", 6) for axis in "xy"]


def _is_known(value: Any) -> bool:
    return not isinstance(value, float) or math.isfinite(value)


def _cell_text(column: Column, value: Any) -> str:
    if value is None:
        return MISSING
    return str(value) if column.decimals is None else format_number(value, column.decimals, column.scale)
