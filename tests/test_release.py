"""What a release consists of: both archives are complete, and work where nothing else is installed."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

import pymunk_dragon

ROOT = Path(__file__).parent.parent
VERSION = pymunk_dragon.__version__
# s: most of it is pip's, which takes the libraries from its cache the second time.
PATIENCE = 300

pytestmark = pytest.mark.thorough


def run(*command, cwd=None):
    return subprocess.run(
        [str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False, timeout=PATIENCE
    )


def succeeded(*command, cwd=None):
    done = run(*command, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """The folder of programs of an empty environment."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    found = folder / ("Scripts" if os.name == "nt" else "bin")
    reached = run(found / "pip", "download", "--quiet", "--no-deps", "--dest", folder / "downloads", "hatchling")
    if reached.returncode != 0:
        pytest.skip("no package index can be reached, from which pip takes hatchling and the libraries")
    return found


@pytest.fixture(scope="module")
def archives(scripts, tmp_path_factory):
    """The wheel and the source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    succeeded(sys.executable, "-m", "build", "--outdir", folder, ROOT)
    return folder / f"pymunk_dragon-{VERSION}-py3-none-any.whl", folder / f"pymunk_dragon-{VERSION}.tar.gz"


def test_index_would_accept_both_archives(archives):
    assert succeeded(sys.executable, "-m", "twine", "check", "--strict", *archives).count("PASSED") == 2


def test_wheel_has_every_file_of_the_package_and_nothing_else(archives):
    package = ROOT / "pymunk_dragon"
    files = {
        path.relative_to(ROOT).as_posix()
        for path in package.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    packed = {name for name in zipfile.ZipFile(archives[0]).namelist() if ".dist-info/" not in name}
    assert packed == files


def test_source_has_the_tests_and_what_they_read(archives):
    with tarfile.open(archives[1]) as archive:
        packed = {name.partition("/")[2] for name in archive.getnames()}
    assert {
        "README.md",
        "README.zh.md",
        "LICENSE",
        "Makefile",
        "renders/documentation.py",
        "tests/conftest.py",
    } <= packed
    assert not any(name.startswith(("renders/docs", ".venv", "renders/march")) for name in packed)


def test_installed_wheel_runs_the_program_and_a_lesson(archives, scripts, tmp_path):
    wheel = f"{archives[0]}[demos]"
    succeeded(scripts / "pip", "install", "--quiet", "--no-compile", "--only-binary", ":all:", wheel)
    assert "benches 0 and 8" in succeeded(scripts / "pymunk-dragon", "contact", cwd=tmp_path)
    assert succeeded(scripts / "pymunk-dragon", "demo", "sat", "--save", tmp_path, cwd=tmp_path)
    assert list(tmp_path.iterdir())
    # The source distribution installs the same program.
    succeeded(scripts / "pip", "install", "--quiet", "--no-compile", "--no-deps", "--force-reinstall", archives[1])
    assert "benches 0 and 8" in succeeded(scripts / "pymunk-dragon", "contact", cwd=tmp_path)


def test_metadata_names_what_users_look_for():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {"authors", "classifiers", "description", "keywords", "license", "readme", "urls"} <= set(project)
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {VERSION}" in citation
    assert "Study On The Bench Dragon Problem" in citation
