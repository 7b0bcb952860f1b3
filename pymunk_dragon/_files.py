"""Writing files atomically, and reading text and tables of numbers.

A file is written as a draft in the folder of its destination and renamed at the end, so that an interrupted program
leaves the old file or none.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError

try:
    import fcntl
except ImportError:  # Windows has no such locks; drafts of killed processes are not removed there.
    fcntl = None  # type: ignore[assignment]  # None if there is no such module.

# Bytes of a text file: 50,000 points with all their digits have 2.2 MB.
MAX_TEXT = 4_000_000
# Name of a draft: number of the process, a random number, ending of the destination. It is short, because the name of
# the destination may be as long as the file system allows.
DRAFT_NAME = re.compile(r"\.pymunk-dragon-\d+-[0-9a-f]{8}(\.[^.]*)?")


def check_destination(path: str | Path, endings: Iterable[str]) -> Path:
    """`path`, if it has one of the endings and can be written, which is tried.

    A device or a FIFO needs no ending if there is only one to choose from.

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
    """Yield the name of a draft to write to, which replaces `path` at the end, or is removed after an exception.

    The file keeps its mode, and symbolic links to it stay. Devices, FIFOs and the files behind stdout and stderr are
    not replaced but written to. Drafts of killed processes in the same folder are removed.

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
            import shutil
            import tempfile

            with tempfile.TemporaryDirectory(prefix="pymunk-dragon-") as folder:
                draft = Path(folder, f"draft{destination.suffix}")
                yield draft
                # Appended, because stdout may be a file that others write to as well.
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
    """Text of the UTF-8 file that the parameter `name` gives, without a byte order mark.

    Raises
    ------
    ParameterError
        If the file cannot be read.
    FileFormatError
        If the file is larger than 4 MB, or not UTF-8.
    """
    try:
        with Path(path).open("rb") as file:
            # Not the size of the file: devices have none, and may be endless.
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
    """Line numbers and rows of a CSV file of numbers. Its first line may hold names; empty lines are skipped.

    Parameters
    ----------
    path : str or Path
        The file.
    name : str
        The parameter that gives the file.
    columns : sequence of str
        Content of each column, for messages.

    Raises
    ------
    ParameterError
        If the file cannot be read.
    FileFormatError
        If a line has another content, which names the first such line; if there is no row; as in `read_text`.
    """
    import csv

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
    """The number in a cell; None if it has another content."""
    try:
        return float(cell)
    except ValueError:
        return None


def _status(path: Path) -> os.stat_result | None:
    """Status of the file that `path` leads to; None if there is none yet."""
    try:
        return os.stat(path)
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
def _draft(destination: Path, status: os.stat_result | None) -> Iterator[Path]:
    """A new file in the folder of `destination`, no more readable than the file it replaces; removed at the end."""
    folder = Path(os.path.realpath(destination)).parent
    mode = 0o666 if status is None else stat.S_IMODE(status.st_mode) & 0o777 | stat.S_IRUSR | stat.S_IWUSR
    _remove_old_drafts(folder)
    while True:
        # Chosen before the file is made, so that an interruption in between leaves nothing.
        draft = folder / f".pymunk-dragon-{os.getpid()}-{os.urandom(4).hex()}{destination.suffix}"
        try:
            try:
                descriptor = os.open(draft, os.O_RDWR | os.O_CREAT | os.O_EXCL, mode)
            except OSError as error:
                bound = f"in a folder that can be written ({_reason(error)})"
                raise ParameterError("output", str(destination), bound) from error
            with _locked(descriptor):
                # Before the lock, another process may have removed the file as an old draft.
                if draft.exists():
                    yield draft
                    return
        finally:
            with suppress(OSError):
                os.unlink(draft)


@contextmanager
def _locked(descriptor: int) -> Iterator[None]:
    """Hold a lock on an open file, which the system releases if the process is killed; close the file at the end."""
    if fcntl is None:
        os.close(descriptor)
        yield
        return
    try:
        with suppress(OSError):  # Some file systems have no locks; no draft is removed there.
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _remove_old_drafts(folder: Path) -> None:
    """Remove the drafts in `folder` that no process has locked: their processes were killed."""
    if fcntl is None:
        return
    with suppress(OSError):
        for name in filter(DRAFT_NAME.fullmatch, os.listdir(folder)):
            # Drafts in use cannot be locked, and those of other users not be opened: they stay.
            with suppress(OSError):
                descriptor = os.open(folder / name, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
                try:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(folder / name)
                finally:
                    os.close(descriptor)


def _reason(error: Exception) -> object:
    """The system's text of an OSError; any other error itself."""
    return (isinstance(error, OSError) and error.strerror) or error
