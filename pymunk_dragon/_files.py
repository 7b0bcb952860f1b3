"""Files: an interrupted program leaves the old one or none; text and tables of numbers are read."""

import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile, gettempdir
from typing import TypeVar

from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError

# Bytes of a text file: 50,000 points with all their digits have 2.2 MB.
_MAX_TEXT = 4_000_000

T = TypeVar("T")


def check_destination(path: str | Path, endings: Iterable[str]) -> Path:
    """`path`, if it has one of the endings and can be written, which is tried.

    A device or a FIFO needs no ending if there is only one to choose from.
    """
    if not isinstance(path, str | Path):
        raise ParameterError("output", path, "a path")
    destination = Path(path)
    known = list(endings)
    try:
        TemporaryFile(dir=_folder_of(destination)).close()
        unnamed = len(known) == 1 and _is_stream(destination)
    except (OSError, ValueError) as error:
        bound = f"in a folder that can be written ({reason(error)})"
        raise ParameterError("output", str(destination), bound) from error

    if destination.is_dir():
        raise ParameterError("output", str(path), "a file, not a folder")
    if destination.suffix.lower() not in known and not unnamed:
        raise ParameterError("output", str(path), "a file name that ends in " + " or ".join(known))
    return destination


@contextmanager
def written_in_place(path: str | Path) -> Iterator[Path]:
    """Yield the name of a draft, which replaces `path` at the end or is removed after an error.

    The file keeps its mode, and symbolic links to it stay. Devices and FIFOs are written to. An
    OSError becomes an OutputError, except one in `passed_on`.
    """
    destination = Path(path)
    # Named before it is made, so that an interruption at any point removes it.
    folder = Path(_folder_of(destination), f".pymunk-dragon-{os.urandom(8).hex()}")
    draft = folder / f"draft{destination.suffix}"
    try:
        # Nobody else can read the draft.
        folder.mkdir(mode=0o700)
        yield draft
        if _is_stream(destination):
            destination.write_bytes(draft.read_bytes())
        else:
            with suppress(FileNotFoundError):
                draft.chmod(stat.S_IMODE(destination.stat().st_mode))
            draft.replace(os.path.realpath(destination))
    except _PassedOn as passed:
        raise passed.error from passed.error.__cause__
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(destination, reason(error)) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text in UTF-8 with its own line ends, as `written_in_place` does."""
    with written_in_place(path) as draft:
        draft.write_bytes(text.encode("utf-8"))


class _PassedOn(BaseException):
    """An error of code that draws, on its way through code that translates errors of writing."""

    def __init__(self, error: Exception) -> None:
        super().__init__(error)
        self.error = error


def passed_on(drawn: Iterator[T]) -> Iterator[T]:
    """Yield what is drawn inside `written_in_place`, which raises errors of the drawing unchanged.

    Drawing calls functions of the user, whose errors are not those of the file.
    """
    try:
        yield from drawn
    except Exception as error:
        raise _PassedOn(error) from error


def read_text(path: str | Path, name: str, limit: int = _MAX_TEXT) -> str:
    """Text of the UTF-8 file of at most `limit` bytes that the parameter `name` gives."""
    try:
        with Path(path).open("rb") as file:
            # Not the size of the file: devices have none, and may be endless.
            content = file.read(limit + 1)
    except (OSError, ValueError, TypeError) as error:
        raise ParameterError(name, str(path), f"a readable file ({reason(error)})") from error
    if len(content) > limit:
        raise FileFormatError(path, f"larger than {limit / 1e6:g} MB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(path, "not a text file") from error


def number_rows(
    path: str | Path, name: str, columns: Sequence[str]
) -> tuple[list[int], list[tuple[float, ...]]]:
    """Line numbers and rows of the CSV file of numbers that the parameter `name` gives.

    The first line may hold names; empty lines are skipped. `columns` is the content of each column,
    for messages.
    """
    meant = " and ".join(columns)
    rows: dict[int, tuple[float, ...]] = {}

    for line, content in enumerate(read_text(path, name).splitlines(), start=1):
        cells = [cell.strip(' \t"') for cell in content.split(",")]
        row = tuple(_numbers(cells))
        if any(cells) and (row or line > 1):
            if not len(row) == len(cells) == len(columns):
                shown = content.strip()[:40]
                raise FileFormatError(path, f"line {line} must hold {meant}, not {shown!r}")
            rows[line] = row

    if not rows:
        raise FileFormatError(path, f"no line holds {meant}")
    return list(rows), list(rows.values())


def _numbers(cells: Iterable[str]) -> Iterator[float]:
    """The numbers in cells, of which others have another content."""
    for cell in cells:
        with suppress(ValueError):
            yield float(cell)


def _folder_of(destination: Path) -> str:
    """The folder in which a file is replaced; that of temporary files for a device or a FIFO."""
    if _is_stream(destination):
        return gettempdir()
    return os.path.dirname(os.path.realpath(destination))


def _is_stream(path: Path) -> bool:
    """Whether a file is written to instead of replaced: a device or a FIFO."""
    try:
        return not stat.S_ISREG(path.stat().st_mode)
    except FileNotFoundError:
        return False


def reason(error: Exception) -> str:
    """The system's text of an OSError; that of any other error."""
    return (isinstance(error, OSError) and error.strerror) or str(error)
