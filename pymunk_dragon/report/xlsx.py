"""An XLSX file through XlsxWriter: written in place, the same bytes every time, text never a formula."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from pymunk_dragon.extras import library
from pymunk_dragon.files import written_in_place

if TYPE_CHECKING:
    from xlsxwriter.workbook import Workbook

__all__ = ["MAX_COLUMNS", "MAX_ROWS", "MAX_TEXT", "workbook"]

# What a sheet of this format holds, and how many characters a cell.
MAX_ROWS, MAX_COLUMNS, MAX_TEXT = 1_048_576, 16_384, 32_767

# An XLSX file says when it was made. The contest's year stands there, so that the same numbers give the same bytes.
CREATED = datetime(2024, 9, 5)


@contextmanager
def workbook(path: Path, *, constant_memory: bool = False) -> Iterator[Workbook]:
    """Give a workbook that is saved as `path` at the end, and nowhere on an error.

    Parameters
    ----------
    path : Path
        The file.
    constant_memory : bool
        Whether rows go to a file as they come. Then every row has to be finished before the next one begins.

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
                # After an error too: it closes the sheets' temporary files, and the draft is thrown away.
                book.close()
            except xlsxwriter.exceptions.FileCreateError as error:
                raise error.args[0] from error
