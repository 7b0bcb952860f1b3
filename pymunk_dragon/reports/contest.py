"""Tables of the contest in the layout of its templates: result1.xlsx, result2.xlsx and result4.xlsx."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon._files import check_destination
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.reports.xlsx import MAX_COLUMNS, workbook

if TYPE_CHECKING:
    from xlsxwriter.workbook import Workbook

__all__ = ["TABLE_ENDINGS", "handle_names", "write_contact_table", "write_tables"]

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

TABLE_ENDINGS = (".xlsx",)
# Digits after the decimal point, as the contest requires.
DECIMALS = 6
# XLSX number format of the values.
NUMBER_FORMAT = "0." + "0" * DECIMALS

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
# Characters: width of the column of names, enough for the longest name.
NAME_WIDTH = 18
# Characters: width of a column of values with six decimals.
VALUE_WIDTH = 11


def handle_names(handles: int) -> list[str]:
    """Names of the handles in the templates: head, n-th body bench, tail, rear of the tail."""
    return [HEAD, *(BODY.format(i) for i in range(1, handles - 2)), TAIL, LAST]


def write_tables(march: March, times: ArrayLike, path: str | Path, progress: Progress | None = None) -> None:
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
    """
    destination = check_destination(path, TABLE_ENDINGS)
    t = np.array(times, dtype=float).ravel()
    if not 1 <= t.size < MAX_COLUMNS:
        raise ParameterError("times", t.size, f"1 to {MAX_COLUMNS - 1} of them, as many as a sheet has columns")
    states = march.at(t)
    names = handle_names(march.dragon.handles)
    labels = [f"{time + 0.0:.12g} s" for time in t.tolist()]
    position_names = [f"{name}{axis} (m)" for name in names for axis in "xy"]
    # Positions (T, H, 2) as rows x, y of each handle, (2 H, T).
    positions = states.positions.reshape(t.size, -1).T
    done, total = itertools.count(1), len(position_names) + len(names)

    def notify() -> None:
        if progress is not None:
            progress(next(done), total)

    with workbook(destination, constant_memory=True) as book:
        _add_worksheet(book, POSITIONS, labels, position_names, positions, notify)
        _add_worksheet(book, SPEEDS, labels, _speed_names(names), states.speeds.T, notify)


def write_contact_table(march: March, impact_time: float, path: str | Path) -> None:
    """Write positions and speeds of every handle at one time as the contest's result2.xlsx.

    Parameters
    ----------
    march : March
        March with the handles.
    impact_time : float
        Time of the first contact, s.
    path : path
        File to write, ending in .xlsx.

    Raises
    ------
    ParameterError, UnreachableError, MissingExtraError, OutputError
        As in `write_tables`.
    """
    destination = check_destination(path, TABLE_ENDINGS)
    states = march.at([impact_time])
    values = np.column_stack([states.positions[0], states.speeds[0]])
    names = handle_names(march.dragon.handles)
    with workbook(destination, constant_memory=True) as book:
        _add_worksheet(book, CONTACT, CONTACT_LABELS, names, values)


def _speed_names(names: Sequence[str]) -> list[str]:
    """Row labels of the speeds; in the templates two spaces precede the unit in all but the first and the last."""
    first, *between, last = names
    return [f"{first} (m/s)", *(f"{name}  (m/s)" for name in between), f"{last} (m/s)"]


def _add_worksheet(
    book: Workbook,
    title: str,
    labels: Sequence[str],
    names: Iterable[str],
    values: Array,
    after_row: Callable[[], None] = lambda: None,
) -> None:
    """Add a worksheet with `labels` in the first row, `names` in the first column and `values` of shape (R, C)."""
    worksheet = book.add_worksheet(title)
    number = book.add_format({"num_format": NUMBER_FORMAT})
    worksheet.set_column(0, 0, NAME_WIDTH)
    worksheet.set_column(1, len(labels), VALUE_WIDTH)
    worksheet.freeze_panes(1, 1)
    for column, label in enumerate(labels, start=1):
        worksheet.write_string(0, column, label)
    # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
    rounded = np.round(values, DECIMALS) + 0.0
    for row, (name, cells) in enumerate(zip(names, rounded, strict=True), start=1):
        worksheet.write_string(row, 0, name)
        for column, value in enumerate(cells.tolist(), start=1):
            worksheet.write_number(row, column, value, number)
        after_row()
