"""What runs a published page: Pyodide, from its CDN or a local copy, and wheels of libraries."""

import subprocess
import sys
from collections.abc import Iterator
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
# What pip does for that platform and its version of Python.
_DOWNLOAD = f"""
    download --no-deps --only-binary=:all: --implementation cp --python-version 3.14 --abi cp314
    --platform {_PLATFORM}
"""
# What a wheel says of itself.
_WHEEL = "Wheel-Version: 1.0\nGenerator: pymunk_dragon\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
# Files of Pyodide, and their names in a published folder: some servers give .mjs a wrong type.
_FILES = {
    "pyodide.mjs": "pyodide.js",
    "pyodide.asm.mjs": "pyodide.asm.js",
    "pyodide.asm.wasm": "pyodide.asm.wasm",
    "python_stdlib.zip": "python_stdlib.zip",
    "pyodide-lock.json": "pyodide-lock.json",
}


def engine_files(runtime: Path | None) -> Iterator[tuple[str, bytes]]:
    """Places in a published folder, and contents, of all that its pages load from there."""
    if runtime is not None:
        for name, published in _FILES.items():
            yield f"pyodide/{published}", _found(runtime, name).read_bytes()
        for name in PACKAGES:
            wheel = _found(runtime, f"{name}-*{_PLATFORM}.whl")
            yield f"wheels/{wheel.name}", wheel.read_bytes()

    pattern = f"pymunk-{version('pymunk')}-*{_PLATFORM}.whl"
    with TemporaryDirectory() as name:
        folder = Path(name)
        if runtime is None or not any(runtime.glob(pattern)):
            _download(folder)
            runtime = folder
        _write_own(folder / f"pymunk_dragon-{__version__}-py3-none-any.whl")
        for wheel in (_found(runtime, pattern), *folder.glob("pymunk_dragon-*")):
            yield f"wheels/{wheel.name}", wheel.read_bytes()


def _found(runtime: Path, pattern: str) -> Path:
    """The file of a local copy that fits a pattern."""
    for path in sorted(runtime.glob(pattern)):
        return path
    bound = f"a folder with a copy of Pyodide, in which {pattern} is"
    raise ParameterError("offline", str(runtime), bound)


def _download(folder: Path) -> None:
    """Download the wheel of Pymunk's present version into a folder, by pip."""
    command = [sys.executable, "-m", "pip", *_DOWNLOAD.split(), "--dest", str(folder)]
    command.append(f"pymunk=={version('pymunk')}")
    done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace")
    if done.returncode:
        reason = done.stderr.strip().splitlines()[-1]
        raise DragonError(f"pip cannot download the wheel of Pymunk for {_PLATFORM}: {reason}")


def _write_own(path: Path) -> None:
    """Write the wheel of this package, from its files and its metadata."""
    package = files("pymunk_dragon")
    assert isinstance(package, Path)  # It is not in an archive.
    about = f"pymunk_dragon-{__version__}.dist-info"
    metadata = distribution("pymunk-dragon").read_text("METADATA") or ""
    contents = {f"{about}/METADATA": metadata, f"{about}/WHEEL": _WHEEL}
    record = ""
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for file in sorted(package.rglob("*")):
            if file.is_file() and "__pycache__" not in file.parts:
                name = file.relative_to(package.parent).as_posix()
                archive.write(file, name)
                record += f"{name},,\n"
        for name, content in contents.items():
            archive.writestr(name, content)
            record += f"{name},,\n"
        archive.writestr(f"{about}/RECORD", f"{record}{about}/RECORD,,\n")
