"""Writing files so that an interrupted program leaves the old file or none, and reading text and tables of numbers."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError

# Bytes of a text file: 50,000 points with all their digits have 2.2 MB.
MAX_TEXT = 4_000_000


def check_destination(path: str | Path, endings: Iterable[str]) -> Path:
    """`path`, if it has one of the endings and can be written, which is tried; a ParameterError if not.

    A device or a FIFO needs no ending if there is only one to choose from.
    """
    destination, known = Path(path), list(endings)
    status = _status(destination)
    unnamed = len(known) == 1 and status is not None and not stat.S_ISREG(status.st_mode)
    if destination.suffix.lower() not in known and not unnamed:
        raise ParameterError("output", str(path), "a file name that ends in " + " or ".join(known))
    if status is not None and stat.S_ISDIR(status.st_mode):
        raise ParameterError("output", str(path), "a file, not a folder")
    with _drafts(destination, status):
        return destination


@contextmanager
def written_in_place(path: str | Path) -> Iterator[Path]:
    """Yield the name of a draft to write to, which replaces `path` at the end, or is removed after an exception.

    The file keeps its mode, and symbolic links to it stay. Devices, FIFOs and the files behind stdout and stderr are
    written to. An OSError becomes an OutputError.
    """
    destination = Path(path)
    status = _status(destination)
    try:
        with _drafts(destination, status) as folder:
            draft = folder / f"draft{destination.suffix}"
            yield draft
            if status is not None and _is_stream(status):
                import shutil

                # Appended, because stdout may be a file that others write to as well.
                with draft.open("rb") as content, destination.open("ab") as stream:
                    shutil.copyfileobj(content, stream)
            else:
                if status is not None:
                    draft.chmod(stat.S_IMODE(status.st_mode))
                draft.replace(os.path.realpath(destination))
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(destination, _reason(error)) from error


def read_text(path: str | Path, name: str) -> str:
    """Text of the UTF-8 file of at most 4 MB that the parameter `name` gives, without a byte order mark."""
    try:
        with Path(path).open("rb") as file:
            # Not the size of the file: devices have none, and may be endless.
            content = file.read(MAX_TEXT + 1)
    except (OSError, ValueError, TypeError) as error:
        raise ParameterError(name, str(path), f"a readable file ({_reason(error)})") from error
    if len(content) > MAX_TEXT:
        raise FileFormatError(path, f"larger than {MAX_TEXT / 1e6:g} MB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(path, "not a text file") from error


def number_rows(path: str | Path, name: str, columns: Sequence[str]) -> tuple[list[int], list[tuple[float, ...]]]:
    """Line numbers and rows of the CSV file of numbers that the parameter `name` gives.

    The first line may hold names; empty lines are skipped. `columns` is the content of each column, for messages.
    """
    meant = " and ".join(columns)
    lines, rows = [], []
    for line, content in enumerate(read_text(path, name).splitlines(), start=1):
        cells = [cell.strip(' \t"') for cell in content.split(",")]
        row = _numbers(cells)
        if not any(cells) or (line == 1 and not row):
            continue
        if not len(row) == len(cells) == len(columns):
            raise FileFormatError(path, f"line {line} must hold {meant}, not {content.strip()[:40]!r}")
        lines.append(line)
        rows.append(row)
    if not rows:
        raise FileFormatError(path, f"no line holds {meant}")
    return lines, rows


def _numbers(cells: Iterable[str]) -> tuple[float, ...]:
    """The numbers in cells, of which others have another content."""
    numbers = []
    for cell in cells:
        with suppress(ValueError):
            numbers.append(float(cell))
    return tuple(numbers)


def _status(path: Path) -> os.stat_result | None:
    """Status of the file that `path` leads to; None if there is none yet."""
    try:
        return path.stat()
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise ParameterError("output", str(path), f"a file that can be written ({_reason(error)})") from error


def _is_stream(status: os.stat_result) -> bool:
    """Whether a file is written to instead of replaced: a device, a FIFO, or the file behind stdout or stderr."""
    for descriptor in (1, 2):
        with suppress(OSError):
            if os.path.samestat(status, os.fstat(descriptor)):
                return True
    return not stat.S_ISREG(status.st_mode)


@contextmanager
def _drafts(destination: Path, status: os.stat_result | None) -> Iterator[Path]:
    """A new folder beside `destination`, or anywhere for what is not replaced; removed at the end."""
    from tempfile import TemporaryDirectory

    beside = None if status is not None and _is_stream(status) else Path(os.path.realpath(destination)).parent
    try:
        drafts = TemporaryDirectory(prefix=".pymunk-dragon-", dir=beside)
    except OSError as error:
        bound = f"in a folder that can be written ({_reason(error)})"
        raise ParameterError("output", str(destination), bound) from error
    with drafts as folder:
        yield Path(folder)


def _reason(error: Exception) -> str:
    """The system's text of an OSError; that of any other error."""
    return (isinstance(error, OSError) and error.strerror) or str(error)
