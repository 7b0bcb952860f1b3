"""XLSX files written with XlsxWriter: atomically, with reproducible bytes, and without text becoming formulas."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from pymunk_dragon._extras import library
from pymunk_dragon._files import written_in_place

if TYPE_CHECKING:
    from xlsxwriter.workbook import Workbook

__all__ = ["MAX_COLUMNS", "MAX_ROWS", "MAX_TEXT", "workbook"]

# Rows of a worksheet: limit of the format.
MAX_ROWS = 1_048_576
# Columns of a worksheet: limit of the format.
MAX_COLUMNS = 16_384
# Characters of a cell: limit of the format.
MAX_TEXT = 32_767
# Creation date in the file's properties: constant, in the year of the contest, so that equal contents give equal bytes.
CREATED = datetime(2024, 9, 5)


@contextmanager
def workbook(path: Path, *, constant_memory: bool = False) -> Iterator[Workbook]:
    """Context manager of a workbook that is saved as `path` on exit, and discarded on an error.

    Parameters
    ----------
    path : Path
        File to write.
    constant_memory : bool
        Whether rows are flushed to a temporary file. Each row then has to be complete before the next row begins.

    Raises
    ------
    MissingExtraError
        If XlsxWriter is not installed.
    OutputError
        If writing fails.
    """
    xlsxwriter = library("xlsxwriter")
    with written_in_place(path) as draft, tempfile.TemporaryDirectory(prefix="pymunk-dragon-") as folder:
        options = {
            "constant_memory": constant_memory,
            "tmpdir": folder,
            "strings_to_formulas": False,
            "strings_to_numbers": False,
            "strings_to_urls": False,
            "nan_inf_to_errors": False,
        }
        book = xlsxwriter.Workbook(str(draft), options)
        book.set_properties({"created": CREATED, "author": "pymunk_dragon"})
        try:
            yield book
        finally:
            try:
                # Also after an error, to close the worksheets' temporary files; the draft is then discarded.
                book.close()
            except xlsxwriter.exceptions.FileCreateError as error:
                raise error.args[0] from error
