"""The contest's own sheets, result1.xlsx and result2.xlsx, as in its templates."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.files import check_destination
from pymunk_dragon.march import March
from pymunk_dragon.report.xlsx import MAX_COLUMNS, workbook

if TYPE_CHECKING:
    from xlsxwriter.workbook import Workbook

__all__ = ["TABLE_ENDINGS", "handle_names", "write_contact_table", "write_tables"]

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

TABLE_ENDINGS = (".xlsx",)
# Digits after the point, as the contest wants them.
DECIMALS = 6
NUMBER_FORMAT = "0." + "0" * DECIMALS

POSITIONS, SPEEDS, CONTACT = "位置", "速度", "Sheet1"
HEAD, BODY, TAIL, LAST = "龙头", "第{}节龙身", "龙尾", "龙尾（后）"  # noqa: RUF001  # The template's own brackets.
CONTACT_HEADS = ("横坐标x (m)", "纵坐标y (m)", "速度 (m/s)")
# Width of the column of names and of the others, in characters.
NAME_WIDTH, VALUE_WIDTH = 18, 11


def handle_names(handles: int) -> list[str]:
    """What the templates call the handles: head, so-many-th body bench, tail, rear of the tail."""
    return [HEAD, *(BODY.format(i) for i in range(1, handles - 2)), TAIL, LAST]


def write_tables(march: March, times: ArrayLike, path: str | Path, progress: Progress | None = None) -> None:
    """Write positions and speeds of every handle as the contest's result1.xlsx and result4.xlsx.

    Parameters
    ----------
    march : March
        Whose handles.
    times : array_like, shape (T,)
        s, a column each.
    path : path
        File to write, ending in .xlsx. An interrupted table leaves the old file or none.
    progress : callable, optional
        Told the number of rows done, and of all rows, after each one.

    Raises
    ------
    ParameterError
        If there is no time or too many for a sheet, or the file cannot be made.
    UnreachableError
        If a handle has no place on the curve.
    MissingExtraError
        If XlsxWriter is not installed.
    OutputError
        If writing fails.

    Notes
    -----
    Values are rounded to six decimals. The paper cuts its tables instead; here the last digit is the nearest.
    """
    destination = check_destination(path, TABLE_ENDINGS)
    t = np.array(times, dtype=float).ravel()
    if not 1 <= t.size < MAX_COLUMNS:
        raise ParameterError("times", t.size, f"1 to {MAX_COLUMNS - 1} of them, as many as a sheet has columns")
    states = march.at(t)
    names = handle_names(march.dragon.handles)
    heads = [f"{time + 0.0:.12g} s" for time in t.tolist()]
    place_names = [f"{name}{axis} (m)" for name in names for axis in "xy"]
    # Positions (T, H, 2) as rows: x and y of a handle below each other, a column for each time.
    places = states.positions.reshape(t.size, -1).T
    done, total = itertools.count(1), len(place_names) + len(names)

    def tell() -> None:
        if progress is not None:
            progress(next(done), total)

    with workbook(destination, constant_memory=True) as book:
        _write_sheet(book, POSITIONS, heads, place_names, places, tell)
        _write_sheet(book, SPEEDS, heads, _speed_names(names), states.speeds.T, tell)


def write_contact_table(march: March, impact_time: float, path: str | Path) -> None:
    """Write positions and speeds of every handle at one time as the contest's result2.xlsx.

    Parameters
    ----------
    march : March
        Whose handles.
    impact_time : float
        s.
    path : path
        File to write, ending in .xlsx.

    Raises
    ------
    ParameterError, UnreachableError, MissingExtraError, OutputError
        As `write_tables` does.
    """
    destination = check_destination(path, TABLE_ENDINGS)
    states = march.at([impact_time])
    values = np.column_stack([states.positions[0], states.speeds[0]])
    names = handle_names(march.dragon.handles)
    with workbook(destination, constant_memory=True) as book:
        _write_sheet(book, CONTACT, CONTACT_HEADS, names, values)


def _speed_names(names: Sequence[str]) -> list[str]:
    """Row heads of the speeds: the templates put two spaces before the unit in all but the first and the last."""
    first, *between, last = names
    return [f"{first} (m/s)", *(f"{name}  (m/s)" for name in between), f"{last} (m/s)"]


def _write_sheet(
    book: Workbook,
    title: str,
    heads: Sequence[str],
    names: Iterable[str],
    values: Array,
    row_is_done: Callable[[], None] = lambda: None,
) -> None:
    """One sheet: `heads` in the first row from the second column on, and below them `names` and `values` (R, C)."""
    sheet = book.add_worksheet(title)
    number = book.add_format({"num_format": NUMBER_FORMAT})
    sheet.set_column(0, 0, NAME_WIDTH)
    sheet.set_column(1, len(heads), VALUE_WIDTH)
    sheet.freeze_panes(1, 1)
    for column, head in enumerate(heads, start=1):
        sheet.write_string(0, column, head)
    # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
    rounded = np.round(values, DECIMALS) + 0.0
    for row, (name, cells) in enumerate(zip(names, rounded, strict=True), start=1):
        sheet.write_string(row, 0, name)
        for column, value in enumerate(cells.tolist(), start=1):
            sheet.write_number(row, column, value, number)
        row_is_done()
