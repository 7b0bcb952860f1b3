"""A report as an XLSX workbook: what happened on the first sheet, all the numbers on the others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymunk_dragon.report import sections, tables
from pymunk_dragon.report.picture import SIZE, Picture
from pymunk_dragon.report.tables import Column, Table
from pymunk_dragon.report.xlsx import MAX_ROWS, MAX_TEXT, workbook

if TYPE_CHECKING:
    from xlsxwriter.format import Format
    from xlsxwriter.workbook import Workbook
    from xlsxwriter.worksheet import Worksheet

__all__ = ["write_workbook"]

Contents = Mapping[str, Any]

# Width of a column of values and of the summary's two, in characters.
VALUE_WIDTH, NAME_WIDTH, FACT_WIDTH = 14, 36, 46
# Points: the height of a row, which does not grow with a text over two columns.
LINE_HEIGHT = 15
# Where the first picture stands on the summary, and pixels a side and rows from one picture to the next.
PICTURE_ROW, PICTURE_COLUMN = 3, 3
PICTURE_SIZE, PICTURE_ROWS = 440, 24
CHART_SIZE = {"width": 760, "height": 380}


def write_workbook(contents: Contents, pictures: Iterable[Picture], path: Path) -> None:
    """Write the sheets Summary, Near misses, Events, Windows, Handles and Drift.

    Raises
    ------
    MissingExtraError
        If XlsxWriter is not installed.
    OutputError
        If writing fails.
    """
    with workbook(path) as book:
        _write_summary(book, contents, pictures)
        _write_table(book, "Near misses", tables.near_misses(contents))
        _write_table(book, "Events", tables.events(contents))
        _write_table(book, "Windows", tables.windows(contents))
        _write_table(book, "Handles", tables.handles(contents))
        drift = tables.drift(contents)
        _draw_drift(book, _write_table(book, "Drift", drift), drift)


def _write_summary(book: Workbook, contents: Contents, pictures: Iterable[Picture]) -> None:
    """Everything but the long tables, as pairs of a name and a text."""
    sheet = book.add_worksheet("Summary")
    sheet.set_column(0, 0, NAME_WIDTH)
    sheet.set_column(1, 1, FACT_WIDTH)
    title, heading = book.add_format({"bold": True, "font_size": 16}), book.add_format({"bold": True})
    wrapped = book.add_format({"text_wrap": True, "valign": "top"})
    sheet.write_string(0, 0, sections.headline(contents), title)
    sheet.write_string(1, 0, sections.subtitle(contents))
    row = 3
    for section in sections.sections(contents):
        sheet.write_string(row, 0, section.title, heading)
        for note in section.notes:
            row += 1
            sheet.merge_range(row, 0, row, 1, "", wrapped)
            sheet.write_string(row, 0, note, wrapped)
            sheet.set_row(row, LINE_HEIGHT * (1 + len(note) // (NAME_WIDTH + FACT_WIDTH)))
        for name, facts in section.facts.items():
            if name:
                row += 1
                sheet.write_string(row, 0, name)
            for fact in facts:
                row += 1
                for column, text in enumerate(fact):
                    sheet.write_string(row, column, text[:MAX_TEXT])
        row += 2
    scale = PICTURE_SIZE / SIZE
    for which, picture in enumerate(pictures):
        sheet.insert_image(
            PICTURE_ROW + which * PICTURE_ROWS,
            PICTURE_COLUMN,
            f"{picture.name}.png",
            {"image_data": BytesIO(picture.png), "x_scale": scale, "y_scale": scale, "description": picture.caption},
        )


def _write_table(book: Workbook, name: str, table: Table) -> Worksheet:
    """A sheet with a table from its first cell on, in the units that people read."""
    sheet = book.add_worksheet(name)
    head = book.add_format({"bold": True, "text_wrap": True, "bottom": 1})
    formats = [_format(book, column) for column in table.columns]
    sheet.set_column(0, len(table.columns) - 1, VALUE_WIDTH)
    sheet.freeze_panes(1, 0)
    for place, column in enumerate(table.columns):
        sheet.write_string(0, place, column.label, head)
    if len(table.rows) >= MAX_ROWS:
        rest = f"the first {MAX_ROWS - 1} of {len(table.rows)} rows; all are in the JSON report"
        sheet.write_string(0, len(table.columns), rest, head)
    for row, values in enumerate(table.rows[: MAX_ROWS - 1], start=1):
        for place, (column, value, look) in enumerate(zip(table.columns, values, formats, strict=True)):
            if isinstance(value, str):
                sheet.write_string(row, place, value)
            elif value is not None:
                sheet.write_number(row, place, value * column.scale if column.decimals is not None else value, look)
    return sheet


def _format(book: Workbook, column: Column) -> Format | None:
    if column.decimals is None:
        return None
    look: Format = book.add_format({"num_format": "0." + "0" * column.decimals})
    return look


def _draw_drift(book: Workbook, sheet: Worksheet, table: Table) -> None:
    """A chart beside the table of drift, where there is any to draw."""
    last = len(table.rows)
    known = any(value for _, *drifts in table.rows for value in drifts)
    if last < 2 or not known:
        return
    chart = book.add_chart({"type": "scatter", "subtype": "straight"})
    for place in range(1, len(table.columns)):
        chart.add_series(
            {
                "name": [sheet.name, 0, place],
                "categories": [sheet.name, 1, 0, last, 0],
                "values": [sheet.name, 1, place, last, place],
            }
        )
    times = [row[0] for row in table.rows]
    chart.set_x_axis({"name": table.columns[0].label, "min": times[0], "max": times[-1]})
    chart.set_y_axis({"name": "drift (mm)", "min": 0})
    chart.set_legend({"position": "bottom"})
    chart.set_size(CHART_SIZE)
    sheet.insert_chart(1, len(table.columns) + 1, chart)
