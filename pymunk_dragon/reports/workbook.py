"""Report as an XLSX workbook: a summary on the first worksheet, tables on the others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymunk_dragon.reports import sections, tables
from pymunk_dragon.reports.picture import SIZE, Picture
from pymunk_dragon.reports.tables import Column, Table
from pymunk_dragon.reports.xlsx import MAX_ROWS, MAX_TEXT, workbook

if TYPE_CHECKING:
    from xlsxwriter.format import Format
    from xlsxwriter.workbook import Workbook
    from xlsxwriter.worksheet import Worksheet

__all__ = ["write_workbook"]

Contents = Mapping[str, Any]

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


def write_workbook(contents: Contents, pictures: Iterable[Picture], path: Path) -> None:
    """Write the worksheets Summary, Near misses, Events, Windows, Handles and Drift.

    Raises
    ------
    MissingExtraError
        If XlsxWriter is not installed.
    OutputError
        If writing fails.
    """
    with workbook(path) as book:
        _add_summary(book, contents, pictures)
        _add_table(book, "Near misses", tables.near_misses(contents))
        _add_table(book, "Events", tables.events(contents))
        _add_table(book, "Windows", tables.windows(contents))
        _add_table(book, "Handles", tables.handles(contents))
        drift = tables.drift(contents)
        _add_drift_chart(book, _add_table(book, "Drift", drift), drift)


def _add_summary(book: Workbook, contents: Contents, pictures: Iterable[Picture]) -> None:
    """Add the headline, notes, facts and pictures."""
    worksheet = book.add_worksheet("Summary")
    worksheet.set_column(0, 0, NAME_WIDTH)
    worksheet.set_column(1, 1, FACT_WIDTH)
    title, heading = book.add_format({"bold": True, "font_size": 16}), book.add_format({"bold": True})
    wrapped = book.add_format({"text_wrap": True, "valign": "top"})
    worksheet.write_string(0, 0, sections.headline(contents), title)
    worksheet.write_string(1, 0, sections.subtitle(contents))
    row = 3
    for section in sections.sections(contents):
        worksheet.write_string(row, 0, section.title, heading)
        for note in section.notes:
            row += 1
            worksheet.merge_range(row, 0, row, 1, "", wrapped)
            worksheet.write_string(row, 0, note, wrapped)
            worksheet.set_row(row, LINE_HEIGHT * (1 + len(note) // (NAME_WIDTH + FACT_WIDTH)))
        for name, facts in section.facts.items():
            if name:
                row += 1
                worksheet.write_string(row, 0, name)
            for fact in facts:
                row += 1
                for column, text in enumerate(fact):
                    worksheet.write_string(row, column, text[:MAX_TEXT])
        row += 2
    scale = PICTURE_SIZE / SIZE
    for index, picture in enumerate(pictures):
        worksheet.insert_image(
            PICTURE_ROW + index * PICTURE_ROWS,
            PICTURE_COLUMN,
            f"{picture.name}.png",
            {"image_data": BytesIO(picture.png), "x_scale": scale, "y_scale": scale, "description": picture.caption},
        )


def _add_table(book: Workbook, name: str, table: Table) -> Worksheet:
    """Add a worksheet with a table in display units."""
    worksheet = book.add_worksheet(name)
    header = book.add_format({"bold": True, "text_wrap": True, "bottom": 1})
    formats = [_format(book, column) for column in table.columns]
    worksheet.set_column(0, len(table.columns) - 1, VALUE_WIDTH)
    worksheet.freeze_panes(1, 0)
    for index, column in enumerate(table.columns):
        worksheet.write_string(0, index, column.label, header)
    if len(table.rows) >= MAX_ROWS:
        note = f"the first {MAX_ROWS - 1} of {len(table.rows)} rows; all are in the JSON report"
        worksheet.write_string(0, len(table.columns), note, header)
    for row, values in enumerate(table.rows[: MAX_ROWS - 1], start=1):
        for index, (column, value, cell_format) in enumerate(zip(table.columns, values, formats, strict=True)):
            if isinstance(value, str):
                worksheet.write_string(row, index, value)
            elif value is not None:
                scale = 1 if column.decimals is None else column.scale
                worksheet.write_number(row, index, value * scale, cell_format)
    return worksheet


def _format(book: Workbook, column: Column) -> Format | None:
    """Number format of a column; None for text and integers."""
    if column.decimals is None:
        return None
    cell_format: Format = book.add_format({"num_format": "0." + "0" * column.decimals})
    return cell_format


def _add_drift_chart(book: Workbook, worksheet: Worksheet, table: Table) -> None:
    """Add a chart beside the table of drift, if any drift is known."""
    last = len(table.rows)
    known = any(value for _, *drifts in table.rows for value in drifts)
    if last < 2 or not known:
        return
    chart = book.add_chart({"type": "scatter", "subtype": "straight"})
    for index in range(1, len(table.columns)):
        chart.add_series(
            {
                "name": [worksheet.name, 0, index],
                "categories": [worksheet.name, 1, 0, last, 0],
                "values": [worksheet.name, 1, index, last, index],
            }
        )
    times = [row[0] for row in table.rows]
    chart.set_x_axis({"name": table.columns[0].label, "min": times[0], "max": times[-1]})
    chart.set_y_axis({"name": "drift (mm)", "min": 0})
    chart.set_legend({"position": "bottom"})
    chart.set_size(CHART_SIZE)
    worksheet.insert_chart(1, len(table.columns) + 1, chart)
