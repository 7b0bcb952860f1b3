"""What runs a published page: Pyodide, from its CDN or a local copy, and wheels of libraries."""

from __future__ import annotations

import subprocess
import sys
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from hashlib import sha256
from importlib.metadata import distribution, version
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZIP_DEFLATED, ZipFile

from pymunk_dragon import __version__
from pymunk_dragon.errors import DragonError, ParameterError

# Where pages load Pyodide from.
CDN = "https://cdn.jsdelivr.net/pyodide/v314.0.7/full/"
# Packages of Pyodide that pages load from there.
PACKAGES = ("numpy", "cffi", "pillow")
# Platform of the wheels for this Pyodide, as pip names it.
_PLATFORM = "pyemscripten_2026_0_wasm32"
# Version of Python of this Pyodide.
_PYTHON = "3.14"
# Files of Pyodide, and their names in a published folder: some servers give .mjs a wrong type.
_FILES = {
    "pyodide.mjs": "pyodide.js",
    "pyodide.asm.mjs": "pyodide.asm.js",
    "pyodide.asm.wasm": "pyodide.asm.wasm",
    "python_stdlib.zip": "python_stdlib.zip",
    "pyodide-lock.json": "pyodide-lock.json",
}


def copied_runtime(runtime: Path) -> Iterator[tuple[str, bytes]]:
    """Names and contents of the files of a local copy of Pyodide; an error names one it lacks."""
    for name, published in _FILES.items():
        yield published, _found(runtime, name).read_bytes()
    for name in PACKAGES:
        wheel = _found(runtime, f"{name}-*{_PLATFORM}.whl")
        yield wheel.name, wheel.read_bytes()


def _found(runtime: Path, pattern: str) -> Path:
    """The file of a local copy that fits a pattern."""
    for path in sorted(runtime.glob(pattern)):
        return path
    bound = f"a folder with a copy of Pyodide, in which {pattern} is"
    raise ParameterError("offline", str(runtime), bound)


def wheels(runtime: Path | None) -> Iterator[tuple[str, bytes]]:
    """Names and contents of the wheels of Pymunk, from the local copy or by pip, and of this."""
    pattern = f"pymunk-{version('pymunk')}-*{_PLATFORM}.whl"
    with TemporaryDirectory() as folder:
        known = list(runtime.glob(pattern)) if runtime else []
        wheel = known[0] if known else _downloaded(Path(folder), pattern)
        yield wheel.name, wheel.read_bytes()
        own = Path(folder, f"pymunk_dragon-{__version__}-py3-none-any.whl")
        _write_own(own)
        yield own.name, own.read_bytes()


def _downloaded(folder: Path, pattern: str) -> Path:
    """The wheel of Pymunk's own version, which pip downloads into a folder."""
    options = f"--no-deps --only-binary=:all: --python-version {_PYTHON} --implementation cp"
    abi = f"--abi cp{_PYTHON.replace('.', '')} --platform {_PLATFORM}"
    command = [sys.executable, "-m", "pip", "download", *options.split(), *abi.split()]
    command += ["--dest", str(folder), f"pymunk=={version('pymunk')}"]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace")
    for path in folder.glob(pattern):
        return path
    reason = (done.stderr.strip().splitlines() or ["no reason"])[-1]
    raise DragonError(f"pip cannot download the wheel {pattern}: {reason}")


def _write_own(path: Path) -> None:
    """Write the wheel of this package, from its files and its metadata."""
    package = files("pymunk_dragon")
    assert isinstance(package, Path)  # It is not in an archive.
    about = f"pymunk_dragon-{__version__}.dist-info"
    metadata = distribution("pymunk-dragon").read_text("METADATA") or ""
    contents = {f"{about}/METADATA": metadata.encode()}
    wheel = (
        "Wheel-Version: 1.0\nGenerator: pymunk_dragon\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    )
    contents[f"{about}/WHEEL"] = wheel.encode()
    for file in sorted(package.rglob("*")):
        if file.is_file() and "__pycache__" not in file.parts:
            contents[file.relative_to(package.parent).as_posix()] = file.read_bytes()

    record = f"{about}/RECORD,,\n"
    for name, content in contents.items():
        digest = urlsafe_b64encode(sha256(content).digest()).decode().rstrip("=")
        record += f"{name},sha256={digest},{len(content)}\n"
    contents[f"{about}/RECORD"] = record.encode()
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for name, content in contents.items():
            archive.writestr(name, content)
