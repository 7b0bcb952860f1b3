"""Tables of any march: XLSX files in the contest's layout, and the tables of the paper as text."""

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from io import BytesIO
from pathlib import Path
from traceback import clear_frames

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, numbers
from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model._display import table, width
from pymunk_dragon.model.march import March, check_march

# s: times of the paper's tables 1 and 2.
_TABLE_TIMES = (0.0, 60.0, 120.0, 180.0, 240.0, 300.0)
# Columns of a worksheet: limit of the format.
_MAX_COLUMNS = 16_384
# Creation date in the file's properties: constant, in the year of the contest, so that equal
# contents give equal bytes.
_CREATED = datetime(2024, 9, 5)
# Names of handles in the templates: the first one, of the head.
_HEAD = "龙头"
# The front handle of a body bench, by its number from 1.
_BODY = "第{}节龙身"
# The front handle of the tail.
_TAIL = "龙尾"
# The rear handle of the tail, in the brackets of the template.
_LAST = "龙尾（后）"  # noqa: RUF001  # The template's own brackets.
# m or m/s: added to magnitudes before truncation, so that 8.8 m or 1 m/s with a rounding error keep
# their digits.
_ROUNDING_TOLERANCE = 1e-11


def write_tables(march: March, times: ArrayLike, path: str | Path) -> None:
    """Write positions and speeds of every handle at times in s as a workbook.

    The layout is that of the contest's result1.xlsx and result4.xlsx.

    Examples
    --------
    >>> write_tables(March(), range(301), "result1.xlsx")
    """
    destination = check_destination(path, (".xlsx",))
    check_march(march)
    t = numbers("times", times).ravel()
    if not 1 <= t.size < _MAX_COLUMNS:
        bound = f"1 to {_MAX_COLUMNS - 1} of them, as many as a sheet has columns"
        raise ParameterError("times", t.size, bound)

    states = march.at(t)
    labels = [f"{time:z.12g} s" for time in t.tolist()]
    names = _handle_names(march.dragon.handles)
    coordinate_names = [f"{name}{axis} (m)" for name in names for axis in "xy"]
    # In the templates two spaces precede the unit of all speeds but the first and the last.
    body_names = [f"{name}  (m/s)" for name in names[1:-1]]
    speed_names = [f"{_HEAD} (m/s)", *body_names, f"{_LAST} (m/s)"]
    # Positions (T, H, 2) as rows x, y of each handle, (2 H, T).
    positions = states.positions.reshape(t.size, -1).T
    sheets = {
        "位置": (labels, coordinate_names, positions),
        "速度": (labels, speed_names, states.speeds.T),
    }
    _write_sheets(destination, sheets)


def write_contact_table(march: March, impact_time: float, path: str | Path) -> None:
    """Write positions and speeds of every handle at the time of the first contact, s.

    The layout is that of the contest's result2.xlsx.
    """
    destination = check_destination(path, (".xlsx",))
    check_march(march)
    time = finite("impact_time", impact_time, unit="s")
    states = march.at([time])
    values = np.column_stack([states.positions[0], states.speeds[0]])
    labels = ("横坐标x (m)", "纵坐标y (m)", "速度 (m/s)")
    names = _handle_names(march.dragon.handles)
    _write_sheets(destination, {"Sheet1": (labels, names, values)})


def paper_tables(march: March, impact_time: float | None) -> str:
    """Tables 1 to 3 of the paper as text, with three decimals, truncated as in the paper.

    The third table is that of the first contact at `impact_time`, s.
    """
    check_march(march)
    if impact_time is not None:
        impact_time = finite("impact_time", impact_time, unit="s")

    handles = march.dragon.representatives
    states = march.at(_TABLE_TIMES)
    times = [f"{time:g} s" for time in _TABLE_TIMES]
    coordinates = states.positions[:, handles].reshape(len(times), -1).T
    names = [f"{handle} {axis}" for handle in handles for axis in "xy"]
    lines = _text_table(text("Table 1: positions, m"), times, names, coordinates)
    speeds = states.speeds[:, handles].T
    lines += _text_table(text("Table 2: speeds, m/s"), times, handles, speeds)

    if impact_time is not None:
        states = march.at([impact_time])
        values = np.column_stack([states.positions[0], states.speeds[0]])[handles]
        title = text("Table 3: at the first contact, {time:.9f} s", time=impact_time)
        lines += _text_table(title, ["x (m)", "y (m)", text("speed (m/s)")], handles, values)
    return "\n".join(lines[:-1])


def _handle_names(handles: int) -> list[str]:
    """Names of the handles in the contest's templates."""
    body = [_BODY.format(i) for i in range(1, handles - 2)]
    return [_HEAD, *body, _TAIL, _LAST]


def _write_sheets(
    destination: Path, sheets: Mapping[str, tuple[Sequence[str], Sequence[str], Array]]
) -> None:
    """Write worksheets as a workbook with reproducible bytes.

    A sheet has labels of its columns, labels of its rows, and values.
    """
    xlsxwriter = library("xlsxwriter")
    # A `ZipFile` that cannot write its end when it is deleted prints an error; to memory it can.
    content = BytesIO()
    with written_in_place(destination) as draft:
        # Rows are flushed to a temporary file: a table of many times would fill the memory.
        options = {"constant_memory": True, "tmpdir": str(draft.parent)}
        try:
            with xlsxwriter.Workbook(content, options) as book:
                book.set_properties({"created": _CREATED, "author": "pymunk_dragon"})
                number = book.add_format({"num_format": "0.000000"})
                for title, (labels, names, values) in sheets.items():
                    sheet = book.add_worksheet(title)
                    # Characters, enough for the longest name and value.
                    sheet.set_column(0, 0, 18)
                    sheet.set_column(1, len(labels), 11)
                    sheet.freeze_panes(1, 1)
                    sheet.write_row(0, 1, labels)
                    # Six decimals, as the contest requires; adding 0 turns the -0.0 of a tiny
                    # number into 0.0.
                    for row, cells in enumerate(np.round(values, 6) + 0.0, start=1):
                        sheet.write_string(row, 0, names[row - 1])
                        sheet.write_row(row, 1, cells.tolist(), number)
        except xlsxwriter.exceptions.FileCreateError as error:
            # The `ZipFile` is in a frame of the error; it is deleted here, before `content`.
            clear_frames(error.args[0].__traceback__)
            raise error.args[0] from error
        draft.write_bytes(content.getbuffer())


def _truncated(value: float) -> str:
    """`value` truncated to three decimals."""
    value += math.copysign(_ROUNDING_TOLERANCE, value)
    return f"{math.trunc(1000 * value) / 1000:.3f}"


def _text_table(
    title: str, labels: Sequence[str], names: Sequence[object], rows: Array
) -> list[str]:
    """Lines of a text table with truncated values."""
    cells = []
    for name, row in zip(names, rows.tolist(), strict=True):
        cells.append([str(name), *map(_truncated, row)])
    formats = [">8"]
    for label in labels:
        formats.append(f">{max(10, width(label))}")
    return [title, *table((text("handle"), *labels), formats, cells), ""]
