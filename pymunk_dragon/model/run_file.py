"""Files of runs: NumPy archives (.npz) of arrays and of notes as JSON, read without trust in their contents."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError

RUN_ENDINGS = (".npz",)
# Name and version of the format, the only one that is read.
FORMAT, FORMAT_VERSION = "pymunk_dragon run", 2
# Bytes that a file may unpack to, or this many times its size: positions of moving benches hardly get smaller by
# packing, callbacks to a tenth.
MAX_UNPACKED, MAX_RATIO = 512_000_000, 10


class Archive(NamedTuple):
    """Contents of an open archive: the notes, of any JSON values, and arrays, which are read when they are taken."""

    notes: dict[str, Any]
    arrays: Mapping[str, NDArray[Any]]


def write_archive(path: str | Path | IO[bytes], notes: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays and notes, to a path or an open file; an interrupted write leaves the old file or none."""
    whole = {"format": FORMAT, "format_version": FORMAT_VERSION, **notes}
    contents: dict[str, Any] = {"notes": np.frombuffer(json.dumps(whole).encode(), dtype=np.uint8), **arrays}
    if isinstance(path, str | Path):
        with written_in_place(check_destination(path, RUN_ENDINGS)) as draft, draft.open("wb") as file:
            np.savez_compressed(file, **contents)
    else:
        np.savez_compressed(path, **contents)


@contextmanager
def opened_archive(path: str | Path, name: str = "run") -> Iterator[Archive]:
    """Open a file that `write_archive` wrote; what is raised inside is the fault of its contents.

    `name` is that of the parameter or option that has the path.
    """
    try:
        file = Path(path).open("rb")  # noqa: SIM115 (closed below, where what is wrong is the content)
    except (OSError, ValueError, TypeError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or error
        raise ParameterError(name, str(path), f"a readable file ({reason})") from error
    try:
        # Of a pipe, whose end may never come, no more than a run can hold.
        content = file if file.seekable() else io.BytesIO(file.read(MAX_UNPACKED))
        with file, np.load(content, allow_pickle=False) as archive:
            size = content.seek(0, io.SEEK_END)
            unpacked = sum(member.file_size for member in archive.zip.infolist())
            if unpacked > max(MAX_UNPACKED, MAX_RATIO * size):
                raise DragonError(f"its {size} bytes unpack to {unpacked}, and no run does that")
            notes = json.loads(archive["notes"].tobytes())
            if notes["format"] != FORMAT or notes["format_version"] != FORMAT_VERSION:
                found = f"{notes['format']} {notes['format_version']}"
                raise DragonError(f"its format is {found}, and this version reads {FORMAT} {FORMAT_VERSION}")
            yield Archive(notes, archive)
    except DragonError as error:
        raise FileFormatError(path, f"a damaged run: {error}") from error
    except Exception as error:
        # A damaged archive makes zipfile, its decompressors, NumPy and JSON raise nearly anything; whatever it is,
        # the content is to blame.
        raise FileFormatError(path, "no run of pymunk_dragon, or a damaged one") from error
