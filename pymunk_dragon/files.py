"""Writing files so that an interrupted run leaves the old file or none; reading tables of numbers."""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError

__all__ = ["check_destination", "number_rows", "written_in_place"]


def check_destination(path: str | Path, endings: Iterable[str]) -> Path:
    """Path to write to, after making sure that its ending is known and its folder can be written.

    Raises
    ------
    ParameterError
        If the ending is not one of `endings`, or the folder does not exist or cannot be written.
    """
    destination = Path(path)
    known = list(endings)
    if destination.suffix.lower() not in known:
        raise ParameterError("output", str(path), "a file name that ends in " + " or ".join(known))
    if destination.is_dir():
        raise ParameterError("output", str(path), "a file, not a folder")
    os.unlink(_beside(destination))
    return destination


@contextmanager
def written_in_place(path: str | Path) -> Iterator[Path]:
    """Give the name of a new file beside `path` to write to; rename it to `path` at the end, or remove it on an error.

    Raises
    ------
    ParameterError
        If the folder does not exist or cannot be written.
    OutputError
        If writing fails, as on a full disk.
    """
    destination = Path(path)
    draft = _beside(destination)
    try:
        yield draft
        os.replace(draft, destination)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(destination, error.strerror or str(error)) from error
    finally:
        with suppress(FileNotFoundError):
            os.unlink(draft)


def number_rows(path: str | Path, name: str, columns: Sequence[str]) -> tuple[list[int], list[tuple[float, ...]]]:
    """Line numbers and rows of a CSV file of numbers, whose first line may hold names; empty lines are passed over.

    Parameters
    ----------
    path : str or Path
        The file.
    name : str
        The parameter that it is given for.
    columns : sequence of str
        What stands in each column, as words.

    Raises
    ------
    ParameterError
        If the file cannot be read.
    FileFormatError
        If a line is anything else, or there is none: the first such line.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(path, "not a text file") from error
    except (OSError, ValueError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or error
        raise ParameterError(name, str(path), f"a readable file ({reason})") from error
    meant = " and ".join(columns)
    lines, rows = [], []
    for line, content in enumerate(text.splitlines(), start=1):
        cells = next(csv.reader([content]), [])
        if not any(cell.strip() for cell in cells):
            continue
        try:
            row = tuple(float(cell) for cell in cells)
        except ValueError:
            if line == 1:
                continue
            row = ()
        if len(row) != len(columns):
            raise FileFormatError(path, f"line {line} must hold {meant}, not {content.strip()[:40]!r}")
        lines.append(line)
        rows.append(row)
    if not rows:
        raise FileFormatError(path, f"no line holds {meant}")
    return lines, rows


def _beside(destination: Path) -> Path:
    """New empty file in the folder of `destination`, with the same ending and the usual permissions."""
    try:
        # The name does not grow with the destination's, which may be as long as the file system allows.
        handle, name = tempfile.mkstemp(prefix=".pymunk-dragon-", suffix=destination.suffix, dir=destination.parent)
    except OSError as error:
        bound = f"in a folder that can be written ({error.strerror})"
        raise ParameterError("output", str(destination), bound) from error
    # mkstemp makes private files; a film is as public as any file that the user writes.
    mask = os.umask(0)
    os.umask(mask)
    os.fchmod(handle, 0o666 & ~mask)
    os.close(handle)
    return Path(name)
