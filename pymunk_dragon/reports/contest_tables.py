"""Tables of the contest and of the paper, for any march: XLSX files in the contest's layout, and text."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from decimal import ROUND_DOWN, Decimal
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon._display import table, width
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.reports.summary import TABLE_TIMES
from pymunk_dragon.reports.tables import Column
from pymunk_dragon.reports.xlsx_report import MAX_COLUMNS, add_worksheet, open_workbook

Progress = Callable[[int, int], None]

TABLE_ENDINGS = (".xlsx",)
# Digits after the decimal point, as the contest requires.
DECIMALS = 6
# Worksheet names of the templates: positions, speeds, and the only worksheet of result2.xlsx.
POSITIONS = "位置"
SPEEDS = "速度"
CONTACT = "Sheet1"
# Names of handles in the templates: head, n-th body bench, tail, rear of the tail.
HEAD = "龙头"
BODY = "第{}节龙身"
TAIL = "龙尾"
LAST = "龙尾（后）"  # noqa: RUF001  # The template's own brackets.
# Column labels of result2.xlsx.
CONTACT_LABELS = ("横坐标x (m)", "纵坐标y (m)", "速度 (m/s)")
# Characters: widths of the columns of names and values, enough for the longest.
LAYOUT = {"frozen_columns": 1, "name_width": 18, "value_width": 11}
# m or m/s: added to magnitudes before truncation, so that 8.8 m or 1 m/s with a rounding error keep their digits.
ROUNDING_TOLERANCE = 1e-11
# Last decimal of the paper's tables, mm or mm/s.
THOUSANDTH = Decimal("0.001")


def write_tables(march: March, times: ArrayLike, path: str | Path, *, progress: Progress | None = None) -> None:
    """Write positions and speeds of every handle as the contest's result1.xlsx and result4.xlsx.

    Parameters
    ----------
    march : March
        March with the handles.
    times : array_like, shape (T,)
        Times in s; one column each.
    path : path
        File to write, ending in .xlsx. An interruption leaves the old file or none.
    progress : callable, optional
        Called after each row with the number of completed rows and the total number of rows.

    Raises
    ------
    ParameterError
        If there is no time, there are too many for a worksheet, or the file cannot be created.
    UnreachableError
        If a handle would be beyond the end of the curve.
    MissingExtraError
        If XlsxWriter is not installed.
    OutputError
        If writing fails.

    Notes
    -----
    Values are rounded to six decimals, whereas the paper's tables are truncated.

    Examples
    --------
    >>> write_tables(March(), range(301), "result1.xlsx")
    """
    destination = check_destination(path, TABLE_ENDINGS)
    t = np.array(times, dtype=float).ravel()
    if not 1 <= t.size < MAX_COLUMNS:
        raise ParameterError("times", t.size, f"1 to {MAX_COLUMNS - 1} of them, as many as a sheet has columns")
    states = march.at(t)
    names = handle_names(march.dragon.handles)
    columns = _columns(f"{time + 0.0:.12g} s" for time in t.tolist())
    position_names = [f"{name}{axis} (m)" for name in names for axis in "xy"]
    # In the templates two spaces precede the unit of all speeds but the first and the last.
    speed_names = [f"{name} {'' if name in (HEAD, LAST) else ' '}(m/s)" for name in names]
    # Positions (T, H, 2) as rows x, y of each handle, (2 H, T).
    positions = states.positions.reshape(t.size, -1).T
    done, total = itertools.count(1), len(position_names) + len(speed_names)

    def notify() -> None:
        if progress is not None:
            progress(next(done), total)

    with written_in_place(destination) as draft, open_workbook(draft, constant_memory=True) as book:
        add_worksheet(book, POSITIONS, columns, _rows(position_names, positions, notify), **LAYOUT)
        add_worksheet(book, SPEEDS, columns, _rows(speed_names, states.speeds.T, notify), **LAYOUT)


def write_contact_table(march: March, impact_time: float, path: str | Path) -> None:
    """Write positions and speeds of every handle at one time as the contest's result2.xlsx.

    Parameters
    ----------
    march : March
        March with the handles.
    impact_time : float
        Time of the first contact, s.
    path : path
        File to write, ending in .xlsx. An interruption leaves the old file or none.

    Raises
    ------
    ParameterError, UnreachableError, MissingExtraError, OutputError
        As in `write_tables`.

    Examples
    --------
    >>> write_contact_table(March(), 412.473838, "result2.xlsx")
    """
    destination = check_destination(path, TABLE_ENDINGS)
    states = march.at([impact_time])
    rows = _rows(handle_names(march.dragon.handles), np.column_stack([states.positions[0], states.speeds[0]]))
    with written_in_place(destination) as draft, open_workbook(draft, constant_memory=True) as book:
        add_worksheet(book, CONTACT, _columns(CONTACT_LABELS), rows, **LAYOUT)


def paper_tables(march: March, impact_time: float | None) -> str:
    """Tables 1 to 3 of the paper: states of seven handles at six times, and at the first contact if there is one.

    Values are truncated to three decimals, not rounded, as in the paper.

    Parameters
    ----------
    march : March
        March with the handles.
    impact_time : float or None
        Time of the first contact, s; None for no contact.

    Returns
    -------
    str
        The tables in columns of fixed width.

    Raises
    ------
    UnreachableError
        If a handle would be beyond the end of the curve at one of the times.

    Examples
    --------
    >>> print(paper_tables(March(), None).splitlines()[0])
    Table 1: positions, m
    """
    handles = march.dragon.representatives
    states = march.at(TABLE_TIMES)
    times = [f"{time:g} s" for time in TABLE_TIMES]
    coordinates = states.positions[:, handles].reshape(len(times), -1).T
    names = [f"{handle} {axis}" for handle in handles for axis in "xy"]
    lines = _table(text("Table 1: positions, m"), times, names, coordinates)
    lines += _table(text("Table 2: speeds, m/s"), times, handles, states.speeds[:, handles].T)
    if impact_time is not None:
        states = march.at([impact_time])
        values = np.column_stack([states.positions[0, handles], states.speeds[0, handles]])
        title = text("Table 3: at the first contact, {time:.9f} s").format(time=impact_time)
        lines += _table(title, ["x (m)", "y (m)", text("speed (m/s)")], handles, values)
    return "\n".join(lines[:-1])


def handle_names(handles: int) -> list[str]:
    """Names of the handles in the contest's templates."""
    return [HEAD, *(BODY.format(i) for i in range(1, handles - 2)), TAIL, LAST]


def truncate(value: float) -> str:
    """`value` truncated to three decimals."""
    truncated = Decimal(value + math.copysign(ROUNDING_TOLERANCE, value)).quantize(THOUSANDTH, ROUND_DOWN)
    return str(abs(truncated) if truncated == 0 else truncated)


def _columns(labels: Iterable[str]) -> list[Column]:
    """Columns of a worksheet: names, and a column of values for each label."""
    return [Column(""), *(Column(label, decimals=DECIMALS) for label in labels)]


def _rows(
    names: Iterable[str], values: Array, notify: Callable[[], None] = lambda: None
) -> Iterator[tuple[str | float, ...]]:
    """Rows of names and rounded values (R, C); `notify` is called after each row."""
    # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
    for name, cells in zip(names, np.round(values, DECIMALS) + 0.0, strict=True):
        yield (name, *cells.tolist())
        notify()


def _table(title: str, labels: Sequence[str], names: Sequence[object], rows: Array) -> list[str]:
    """Lines of a text table with truncated values."""
    cells = [[str(name), *map(truncate, row)] for name, row in zip(names, rows.tolist(), strict=True)]
    return [
        title,
        *table((text("handle"), *labels), (">8", *(f">{max(10, width(label))}" for label in labels)), cells),
        "",
    ]
