"""Writes the points of a sweep as a table: CSV or Parquet."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from io import StringIO
from itertools import chain, islice
from pathlib import Path
from typing import Any

from pymunk_dragon._extras import library

# Rows of a part of a Parquet file.
ROW_GROUP = 65536
LINE_END = "\r\n"

Row = Sequence[Any]


def csv_lines(columns: Sequence[str], rows: Iterable[Row]) -> Iterator[str]:
    """Lines of a CSV table, without their ends: numbers with all their digits, empty cells for None."""
    line = StringIO()
    # Cells with parts of this line end are quoted.
    writer = csv.writer(line, lineterminator=LINE_END)
    for row in chain([columns], rows):
        line.seek(0)
        line.truncate()
        writer.writerow(row)
        yield line.getvalue().removesuffix(LINE_END)


def write_csv(path: Path, columns: Sequence[str], rows: Callable[[], Iterable[Row]]) -> None:
    """Write a CSV file."""
    with path.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in csv_lines(columns, rows()))


def write_parquet(path: Path, columns: Sequence[str], rows: Callable[[], Iterable[Row]]) -> None:
    """Write a Parquet file, whose columns have the types of their values."""
    arrow, parquet = library("pyarrow"), library("pyarrow.parquet")
    kinds: list[set[type]] = [set() for _ in columns]
    for row in rows():
        for kind, value in zip(kinds, row, strict=True):
            kind.add(type(value))
    schema = arrow.schema([(name, _arrow_type(arrow, kind)) for name, kind in zip(columns, kinds, strict=True)])
    with parquet.ParquetWriter(path, schema) as writer:
        for part in _parts(rows()):
            values = dict(zip(columns, map(list, zip(*part, strict=True)), strict=True))
            for name in columns:
                convert = {arrow.string(): str, arrow.float64(): float}.get(schema.field(name).type)
                if convert is not None:
                    values[name] = [None if value is None else convert(value) for value in values[name]]
            writer.write_table(arrow.table(values, schema=schema))


def _arrow_type(arrow: Any, kinds: set[type]) -> Any:
    """The type of a column with values of these types."""
    found = kinds - {type(None)}
    if found and found <= {bool}:
        return arrow.bool_()
    if found and found <= {int}:
        return arrow.int64()
    if found and found <= {int, float}:
        return arrow.float64()
    return arrow.string()


def _parts(rows: Iterable[Row]) -> Iterator[list[Row]]:
    iterator = iter(rows)
    return iter(lambda: list(islice(iterator, ROW_GROUP)), [])


# Functions that write each format.
WRITERS: Mapping[str, Callable[[Path, Sequence[str], Callable[[], Iterable[Row]]], None]] = {
    ".csv": write_csv,
    ".parquet": write_parquet,
}
