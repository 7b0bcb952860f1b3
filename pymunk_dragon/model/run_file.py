"""Files of runs: NumPy archives (.npz) of arrays and of notes as JSON, read without trust in their contents."""

from __future__ import annotations

import io
import json
import math
import os
import stat
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError

RUN_ENDINGS = (".npz",)
# Name of the format.
FORMAT = "pymunk_dragon run"
# Version of the format, the only one that is read.
FORMAT_VERSION = 1
# Bytes that a file may unpack to.
MAX_UNPACKED = 512_000_000
# Bytes of its notes, which take up to 30 times as much as Python objects.
MAX_NOTES = 32_000_000
# Larger contents are accepted up to this ratio to the size of the file: positions of moving benches hardly get smaller
# by packing, callbacks to a tenth.
MAX_RATIO = 10


def write_archive(path: str | Path | IO[bytes], notes: Mapping[str, Any], arrays: Mapping[str, Array]) -> None:
    """Write arrays and notes, to a path or an open file; an interrupted write leaves the old file or none."""
    whole = {"format": FORMAT, "format_version": FORMAT_VERSION, **notes}
    packed = np.frombuffer(json.dumps(whole).encode(), dtype=np.uint8)
    whole_arrays: dict[str, Any] = {"notes": packed, **arrays}
    if isinstance(path, str | Path):
        with written_in_place(check_destination(path, RUN_ENDINGS)) as draft, draft.open("wb") as file:
            np.savez_compressed(file, **whole_arrays)
    else:
        np.savez_compressed(path, **whole_arrays)


@contextmanager
def opened_archive(path: str | Path, name: str = "run") -> Iterator[Archive]:
    """Open a file that `write_archive` wrote; what is raised inside is the fault of its contents.

    `name` is that of the parameter or option that has the path.

    Raises
    ------
    ParameterError
        If there is no such file, or it cannot be read.
    FileFormatError
        If the file is damaged, cut off, of another program or of a newer format, or anything was raised inside.
    """
    try:
        file = Path(path).open("rb")  # noqa: SIM115 (closed below, where what is wrong is the content)
    except (OSError, ValueError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or error
        raise ParameterError(name, str(path), f"a readable file ({reason})") from error
    try:
        with file:
            # Of a pipe or a device, whose end may never come, no more than a run can hold.
            is_file = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
            with zipfile.ZipFile(file if is_file else io.BytesIO(file.read(MAX_UNPACKED))) as archive:
                yield Archive(archive)
    except DragonError as error:
        raise FileFormatError(path, f"a damaged run: {error}") from error
    except Exception as error:
        # A damaged archive makes zipfile, its decompressors, NumPy and JSON raise nearly anything; whatever it is,
        # the content is to blame.
        raise FileFormatError(path, "no run of pymunk_dragon, or a damaged one") from error


class Archive:
    """Contents of an open archive; nothing is unpacked whose size is not known to be right.

    Attributes
    ----------
    notes : dict
        The notes, of any JSON values.
    """

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        assert archive.fp is not None  # The archive is open.
        size = archive.fp.seek(0, os.SEEK_END)
        for name, most in (("notes.npy", MAX_NOTES), (None, MAX_UNPACKED)):
            unpacked = sum(member.file_size for member in archive.infolist() if name in (None, member.filename))
            if unpacked > max(most, MAX_RATIO * size):
                raise DragonError(f"its {size} bytes unpack to {unpacked}, and no run does that")
        self.notes: dict[str, Any] = json.loads(self._unpacked("notes", np.uint8).tobytes())
        if self.notes["format"] != FORMAT or self.notes["format_version"] != FORMAT_VERSION:
            found = f"{self.notes['format']} {self.notes['format_version']}"
            raise DragonError(f"its format is {found}, and this version reads {FORMAT} {FORMAT_VERSION}")

    def __contains__(self, name: str) -> bool:
        return f"{name}.npy" in self._archive.namelist()

    def array(self, name: str, shape: tuple[int, ...] | None = None) -> Array:
        """An array of doubles of a shape, or of one dimension and any length."""
        return self._unpacked(name, np.float64, shape)

    def _unpacked(self, name: str, kind: type[np.generic], shape: tuple[int, ...] | None = None) -> NDArray[Any]:
        member = self._archive.getinfo(f"{name}.npy")
        with self._archive.open(member) as file:
            np.lib.format.read_magic(file)
            found, _, dtype = np.lib.format.read_array_header_1_0(file)
            if dtype != kind:
                raise TypeError(f"{name} are of the type {dtype}")
            if found != (shape or found[:1]):
                raise DragonError(f"its {name} have the shape {found}, but its scenario and times want {shape}")
            # What is said twice must be the same: memory is taken for the shape.
            if file.tell() + math.prod(found) * dtype.itemsize != member.file_size:
                raise DragonError(f"its {name} are not as long as they say")
        with self._archive.open(member) as file:
            return np.lib.format.read_array(file, allow_pickle=False)


def present_names(values: Any) -> Any:
    """A scenario with the present names of arc lengths, from a file of an older version."""
    if isinstance(values, list):
        return [present_names(value) for value in values]
    if not isinstance(values, dict):
        return values
    kind = values.get("kind")
    names = {"begin": "begin_s", "end": "end_s"} if kind == "section" else {} if kind else {"start": "start_s"}
    return {names.get(name, name): present_names(value) for name, value in values.items()}
