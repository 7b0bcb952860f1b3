"""Writing files so that an interrupted run leaves the old file or none; reading text and tables of numbers."""

from __future__ import annotations

import csv
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError

try:
    import fcntl
except ImportError:  # Windows has no such locks, and drafts of killed processes stay there.
    fcntl = None  # type: ignore[assignment]  # None if there is no such module.

__all__ = ["check_destination", "number_rows", "read_text", "written_in_place"]

# Bytes of a text file: 50,000 points with all their digits have 2.2 MB.
MAX_TEXT = 4_000_000
# Name of a draft: the process that writes it, a random number, and the ending of the destination. It does not grow
# with the destination's name, which may be as long as the file system allows.
DRAFT_NAME = re.compile(r"\.pymunk-dragon-\d+-[0-9a-f]{8}(\.[^.]*)?")


def check_destination(path: str | Path, endings: Iterable[str]) -> Path:
    """Path to write to, after making sure that its ending is known and its folder can be written.

    A device or a FIFO needs no ending where there is only one to choose from.

    Raises
    ------
    ParameterError
        If the ending is not one of `endings`, or the folder does not exist or cannot be written.
    """
    destination = Path(path)
    known = list(endings)
    status = _status(destination)
    unnamed = len(known) == 1 and status is not None and not stat.S_ISREG(status.st_mode)
    if destination.suffix.lower() not in known and not unnamed:
        raise ParameterError("output", str(path), "a file name that ends in " + " or ".join(known))
    if status is not None and stat.S_ISDIR(status.st_mode):
        raise ParameterError("output", str(path), "a file, not a folder")
    if status is None or not _is_stream(status):
        with _draft(destination, status):
            pass
    elif not os.access(destination, os.W_OK):
        raise ParameterError("output", str(path), "a file that can be written")
    return destination


@contextmanager
def written_in_place(path: str | Path) -> Iterator[Path]:
    """Give the name of a new file to write to, which becomes `path` at the end, or is removed on an error.

    A file is replaced by renaming: it keeps its mode, and symbolic links to it stay. Devices, FIFOs and the standard
    streams are written to. Drafts that killed processes left in the folder are removed.

    Raises
    ------
    ParameterError
        If the folder does not exist or cannot be written.
    OutputError
        If writing fails.
    """
    destination = Path(path)
    status = _status(destination)
    try:
        if status is not None and _is_stream(status):
            with tempfile.TemporaryDirectory(prefix="pymunk-dragon-") as folder:
                draft = Path(folder, f"draft{destination.suffix}")
                yield draft
                # Appended, because the standard output may be a file that others write to as well.
                with draft.open("rb") as content, destination.open("ab") as stream:
                    shutil.copyfileobj(content, stream)
        else:
            with _draft(destination, status) as draft:
                yield draft
                if status is not None:
                    os.chmod(draft, stat.S_IMODE(status.st_mode))
                os.replace(draft, os.path.realpath(destination))
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(destination, error.strerror or str(error)) from error


def read_text(path: str | Path, name: str) -> str:
    """Text of a file that is given for the parameter `name`, without a byte order mark.

    Raises
    ------
    ParameterError
        If the file cannot be read.
    FileFormatError
        If the file is larger than 4 MB, or not UTF-8.
    """
    try:
        with Path(path).open("rb") as file:
            # The size of the file says nothing: a device has none, and never ends.
            content = file.read(MAX_TEXT + 1)
    except (OSError, ValueError) as error:
        raise ParameterError(name, str(path), f"a readable file ({_reason(error)})") from error
    if len(content) > MAX_TEXT:
        raise FileFormatError(path, f"larger than {MAX_TEXT / 1e6:g} MB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(path, "not a text file") from error


def number_rows(path: str | Path, name: str, columns: Sequence[str]) -> tuple[list[int], list[tuple[float, ...]]]:
    """Line numbers and rows of a CSV file of numbers, whose first line may hold names; empty lines are passed over.

    Parameters
    ----------
    path : str or Path
        The file.
    name : str
        The parameter that it is given for.
    columns : sequence of str
        Content of each column, in words.

    Raises
    ------
    ParameterError
        If the file cannot be read.
    FileFormatError
        If a line is anything else, or there is none: the first such line. If the file is larger than 4 MB.
    """
    meant = " and ".join(columns)
    lines, rows = [], []
    for line, content in enumerate(read_text(path, name).splitlines(), start=1):
        try:
            cells = next(csv.reader([content]), [])
        except csv.Error as error:
            raise FileFormatError(path, f"line {line} must hold {meant}, but has a {error}") from error
        if not any(cell.strip() for cell in cells):
            continue
        row = tuple(number for cell in cells if (number := _number(cell)) is not None)
        if line == 1 and not row:
            continue
        if not len(row) == len(cells) == len(columns):
            raise FileFormatError(path, f"line {line} must hold {meant}, not {content.strip()[:40]!r}")
        lines.append(line)
        rows.append(row)
    if not rows:
        raise FileFormatError(path, f"no line holds {meant}")
    return lines, rows


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _status(path: Path) -> os.stat_result | None:
    """Status of the file that `path` leads to; None where there is none yet."""
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise ParameterError("output", str(path), f"a file that can be written ({_reason(error)})") from error


def _is_stream(status: os.stat_result) -> bool:
    """Whether a file cannot be replaced, as a device or a FIFO, or must not be, as the standard output."""
    return not stat.S_ISREG(status.st_mode) or any(_is_open(status, descriptor) for descriptor in (1, 2))


def _is_open(status: os.stat_result, descriptor: int) -> bool:
    try:
        return os.path.samestat(status, os.fstat(descriptor))
    except OSError:
        return False


@contextmanager
def _draft(destination: Path, status: os.stat_result | None) -> Iterator[Path]:
    """New file in the folder of the one that is replaced, as private as that, or as usual; removed at the end."""
    folder = Path(os.path.realpath(destination)).parent
    mode = 0o666 if status is None else stat.S_IMODE(status.st_mode) & 0o777 | stat.S_IRUSR | stat.S_IWUSR
    _clear(folder)
    while True:
        # The name is known before the file is there: an interruption in between leaves nothing.
        draft = folder / f".pymunk-dragon-{os.getpid()}-{os.urandom(4).hex()}{destination.suffix}"
        try:
            try:
                descriptor = os.open(draft, os.O_RDWR | os.O_CREAT | os.O_EXCL, mode)
            except OSError as error:
                bound = f"in a folder that can be written ({_reason(error)})"
                raise ParameterError("output", str(destination), bound) from error
            with _locked(descriptor):
                # Before it was locked, another process may have taken it for an old one, and removed it.
                if draft.exists():
                    yield draft
                    return
        finally:
            with suppress(OSError):
                os.unlink(draft)


@contextmanager
def _locked(descriptor: int) -> Iterator[None]:
    """Hold a lock on an open file, which ends with this process at the latest; close the file at the end."""
    if fcntl is None:
        os.close(descriptor)
        yield
        return
    try:
        with suppress(OSError):  # Some file systems have no locks; there no draft is ever cleared.
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _clear(folder: Path) -> None:
    """Remove the drafts in `folder` that no process holds a lock on: those that wrote them were killed."""
    if fcntl is None:
        return
    with suppress(OSError):
        for name in filter(DRAFT_NAME.fullmatch, os.listdir(folder)):
            # What is in use, or somebody else's, cannot be locked or removed, and stays.
            with suppress(OSError):
                descriptor = os.open(folder / name, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
                try:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(folder / name)
                finally:
                    os.close(descriptor)


def _reason(error: Exception) -> object:
    return (isinstance(error, OSError) and error.strerror) or error
