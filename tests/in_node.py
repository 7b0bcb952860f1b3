"""Python in node, by Pyodide: its runtime, its libraries, and a script that runs there."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from importlib.metadata import distribution, version
from pathlib import Path
from zipfile import ZipFile

NODE = Path(__file__).parent / "node"
# The npm package, where npm has put it or a variable says that it is.
RUNTIME = Path(os.environ.get("PYODIDE_RUNTIME") or NODE / "node_modules" / "pyodide")
# The folder with NumPy, cffi and Pillow for Pyodide.
WHEELS = os.environ.get("PYODIDE_WHEELS")

# Files of it that a page loads, beside its wheels.
FILES = (
    "pyodide-lock.json",
    "pyodide.asm.mjs",
    "pyodide.asm.wasm",
    "pyodide.mjs",
    "python_stdlib.zip",
)
# Installed libraries that are the same on all platforms, for tests.
PURE = (
    "click",
    "filelock",
    "iniconfig",
    "mpmath",
    "packaging",
    "pluggy",
    "pygments",
    "pytest",
    "sortedcontainers",
)
# How pip finds wheels for Pyodide.
PLATFORM = (
    "--only-binary=:all:",
    "--python-version=3.14",
    "--implementation=cp",
    "--abi=cp314",
    "--platform=pyemscripten_2026_0_wasm32",
)
# Downloads are kept: the next run needs no network.
KEPT = Path(tempfile.gettempdir()) / "pymunk-dragon-pyodide"


class CannotRunError(Exception):
    """Why no script can run here."""


def missing() -> str | None:
    """What is not at hand to run scripts."""
    if shutil.which("node") is None:
        return "no node"
    if not (RUNTIME / "pyodide.mjs").is_file():
        return "no runtime: npm install --prefix tests/node"
    if not WHEELS:
        return "no wheels: PYODIDE_WHEELS names their folder"
    return None


def wheels_of_page() -> list[Path]:
    """The wheels of the libraries of a page."""
    if reason := missing():
        raise CannotRunError(reason)
    return [*Path(WHEELS or "").glob("*.whl"), downloaded("pymunk")]


def copy_for_pages(folder: Path) -> Path:
    """A folder with a copy of Pyodide and the wheels of the libraries of a page."""
    for file in (*wheels_of_page(), *(RUNTIME / name for name in FILES)):
        shutil.copy(file, folder)
    return folder


def libraries(folder: Path, *, tests: bool) -> list[Path]:
    """Archives with the libraries of a page and of tests, of which one is written to `folder`."""
    wheels = wheels_of_page()
    if tests:
        wheels.append(downloaded("hypothesis"))
    pure = folder / "pure.zip"
    with ZipFile(pure, "w") as archive:
        # The package itself is in the repository, but for its version.
        for name in ("pymunk-dragon", *(PURE if tests else ())):
            for file in distribution(name).files or ():
                # Without programs and compiled files.
                if ".." not in file.parts and file.suffix != ".pyc":
                    archive.write(str(file.locate()), file)
    return [*wheels, pure]


def downloaded(name: str) -> Path:
    """The wheel for Pyodide of an installed library, from the index of pip."""
    requirement = f"{name}=={version(name)}"
    kept = KEPT / requirement
    if not any(kept.glob("*.whl")):
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", *PLATFORM]
        done = subprocess.run(
            [*command, f"--dest={kept}", requirement], capture_output=True, text=True, check=False
        )
        if done.returncode:
            raise CannotRunError(f"pip finds no {requirement} for Pyodide: {done.stderr}")
    return next(kept.glob("*.whl"))


def run(script: str, results: Path, archives: list[Path]) -> str:
    """Run a script of `tests` in Pyodide, where `results` is /results: what it prints."""
    command = ["node", NODE / "pyodide.mjs", NODE.parent / script, results, *archives]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    output = done.stdout.decode()
    assert done.returncode == 0, output[-10_000:]
    return output
