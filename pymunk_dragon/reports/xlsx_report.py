"""XLSX files: a report as a workbook, and what the contest's tables share with it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from pymunk_dragon._display import width
from pymunk_dragon._extras import library
from pymunk_dragon._language import text
from pymunk_dragon.reports import document, tables
from pymunk_dragon.reports.graphics import STILL_SIZE, stills
from pymunk_dragon.reports.summary import Summary
from pymunk_dragon.reports.tables import Column, Table

if TYPE_CHECKING:
    from xlsxwriter.format import Format
    from xlsxwriter.workbook import Workbook
    from xlsxwriter.worksheet import Worksheet

# Rows of a worksheet: limit of the format.
MAX_ROWS = 1_048_576
# Columns of a worksheet: limit of the format.
MAX_COLUMNS = 16_384
# Characters of a cell: limit of the format.
MAX_TEXT = 32_767
# Creation date in the file's properties: constant, in the year of the contest, so that equal contents give equal bytes.
CREATED = datetime(2024, 9, 5)
# Options of XlsxWriter: text stays text, also where it could be read as a formula, a number or an address.
TEXT_OPTIONS = {"strings_to_formulas": False, "strings_to_numbers": False, "strings_to_urls": False}
# Characters: width of a column of values in a table.
VALUE_WIDTH = 14
# Characters: width of the summary's column of names, enough for the longest name.
NAME_WIDTH = 36
# Characters: width of the summary's column of values.
FACT_WIDTH = 46
# Points: height of a line of text. Rows with merged cells need an explicit height.
LINE_HEIGHT = 15
# Zero-based row of the first picture: below the title.
PICTURE_ROW = 3
# Zero-based column of the pictures: beside the text.
PICTURE_COLUMN = 3
# Pixels: displayed width and height of a picture.
PICTURE_SIZE = 440
# Rows from one picture to the next: the height of a picture and a margin.
PICTURE_ROWS = 24
# Pixels: size of the drift chart.
CHART_SIZE = {"width": 760, "height": 380}


@contextmanager
def open_workbook(target: Path | BytesIO, *, constant_memory: bool = False) -> Iterator[Workbook]:
    """Context manager of a workbook with reproducible bytes that is saved as `target` on exit.

    With `constant_memory`, rows are flushed to a temporary file, and have to be written in order.
    """
    xlsxwriter = library("xlsxwriter")
    with tempfile.TemporaryDirectory(prefix="pymunk-dragon-") as folder:
        options = TEXT_OPTIONS | {"constant_memory": constant_memory, "tmpdir": folder, "nan_inf_to_errors": False}
        book = xlsxwriter.Workbook(target if isinstance(target, BytesIO) else str(target), options)
        book.set_properties({"created": CREATED, "author": "pymunk_dragon"})
        try:
            yield book
        finally:
            try:
                # Also after an error, to close the worksheets' temporary files; the file is then discarded.
                book.close()
            except xlsxwriter.exceptions.FileCreateError as error:
                raise error.args[0] from error


def add_worksheet(
    book: Workbook,
    name: str,
    columns: Sequence[Column],
    rows: Iterable[Iterable[str | float | None]],
    *,
    header: Format | None = None,
    frozen_columns: int = 0,
    name_width: int = VALUE_WIDTH,
    value_width: int = VALUE_WIDTH,
) -> Worksheet:
    """Add a worksheet with the labels of `columns` in the first row, and rows of values in display units below."""
    worksheet = book.add_worksheet(name)
    formats = {None: None} | {
        decimals: book.add_format({"num_format": f"{0:.{decimals}f}"})
        for decimals in dict.fromkeys(column.decimals for column in columns)
        if decimals is not None
    }
    worksheet.set_column(0, 0, name_width)
    worksheet.set_column(1, len(columns) - 1, value_width)
    worksheet.freeze_panes(1, frozen_columns)
    for index, column in enumerate(columns):
        if column.label:
            worksheet.write_string(0, index, column.label, header)
    for row, values in enumerate(rows, start=1):
        for index, (column, value) in enumerate(zip(columns, values, strict=True)):
            if isinstance(value, str):
                worksheet.write_string(row, index, value)
            elif value is not None:
                worksheet.write_number(row, index, value * column.scale, formats[column.decimals])
    return worksheet


def xlsx(summary: Summary) -> bytes:
    """Report as a workbook: worksheets Summary, Near misses, Events, Windows, Handles and Drift."""
    content = BytesIO()
    with open_workbook(content) as book:
        _add_summary(book, summary)
        _add_table(book, text("Near misses"), tables.near_misses(summary))
        _add_table(book, text("Events"), tables.events(summary))
        _add_table(book, text("Windows"), tables.windows(summary))
        _add_table(book, text("Handles"), tables.handles(summary))
        drift = tables.drift(summary)
        _add_drift_chart(book, _add_table(book, text("Drift"), drift), drift)
    return content.getvalue()


def _add_summary(book: Workbook, summary: Summary) -> None:
    """Add the headline, notes, facts and pictures."""
    worksheet = book.add_worksheet(text("Summary"))
    worksheet.set_column(0, 0, NAME_WIDTH)
    worksheet.set_column(1, 1, FACT_WIDTH)
    title, heading = book.add_format({"bold": True, "font_size": 16}), book.add_format({"bold": True})
    wrapped = book.add_format({"text_wrap": True, "valign": "top"})
    worksheet.write_string(0, 0, document.headline(summary), title)
    worksheet.write_string(1, 0, document.subtitle(summary))
    row = 3
    for section in document.sections(summary):
        worksheet.write_string(row, 0, section.title, heading)
        for note in section.notes:
            row += 1
            worksheet.merge_range(row, 0, row, 1, "", wrapped)
            worksheet.write_string(row, 0, note, wrapped)
            worksheet.set_row(row, LINE_HEIGHT * (1 + width(note) // (NAME_WIDTH + FACT_WIDTH)))
        for name, facts in section.facts.items():
            for cells in [(name,), *facts] if name else facts:
                row += 1
                for column, cell in enumerate(cells):
                    worksheet.write_string(row, column, cell[:MAX_TEXT])
        row += 2
    scale = PICTURE_SIZE / STILL_SIZE
    for index, (caption, png) in enumerate(stills(summary)):
        options = {"image_data": BytesIO(png), "x_scale": scale, "y_scale": scale, "description": caption}
        worksheet.insert_image(PICTURE_ROW + index * PICTURE_ROWS, PICTURE_COLUMN, "picture.png", options)


def _add_table(book: Workbook, name: str, table: Table) -> Worksheet:
    """Add a worksheet with a table, or as many of its rows as the format allows."""
    header = book.add_format({"bold": True, "text_wrap": True, "bottom": 1})
    worksheet = add_worksheet(book, name, table.columns, table.rows[: MAX_ROWS - 1], header=header)
    if len(table.rows) >= MAX_ROWS:
        template = text("the first {shown} of {count} rows; all are in the JSON report")
        note = template.format(shown=MAX_ROWS - 1, count=len(table.rows))
        worksheet.write_string(0, len(table.columns), note, header)
    return worksheet


def _add_drift_chart(book: Workbook, worksheet: Worksheet, table: Table) -> None:
    """Add a chart beside the table of position errors, if any error is known."""
    last = len(table.rows)
    known = any(value for _, *errors in table.rows for value in errors)
    if last < 2 or not known:
        return
    chart = book.add_chart({"type": "scatter", "subtype": "straight"})
    for index in range(1, len(table.columns)):
        series = {"name": (0, index), "categories": (1, 0, last, 0), "values": (1, index, last, index)}
        chart.add_series({name: [worksheet.name, *cells] for name, cells in series.items()})
    chart.set_x_axis({"name": table.columns[0].label, "min": table.rows[0][0], "max": table.rows[-1][0]})
    chart.set_y_axis({"name": text("position error (mm)"), "min": 0})
    chart.set_legend({"position": "bottom"})
    chart.set_size(CHART_SIZE)
    worksheet.insert_chart(1, len(table.columns) + 1, chart)
