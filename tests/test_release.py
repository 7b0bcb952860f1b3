"""What a release consists of: both archives are complete, and work where nothing else is installed."""

import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile

import pytest
from documents import ROOT

import pymunk_dragon

VERSION = pymunk_dragon.__version__

pytestmark = pytest.mark.thorough


def run(*command, **options):
    """The output of a command; most of the time is pip's, which takes the libraries from its cache the second time."""
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False, timeout=300, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The folder of programs of an empty environment."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    try:
        run(folder / "bin" / "pip", "download", "--quiet", "--no-deps", "--dest", folder / "downloads", "hatchling")
    except AssertionError:
        pytest.skip("no package index can be reached, from which pip takes hatchling and the libraries")
    return folder / "bin"


@pytest.fixture(scope="module")
def archives(programs, tmp_path_factory):
    """The wheel and the source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--outdir", folder, ROOT)
    return folder / f"pymunk_dragon-{VERSION}-py3-none-any.whl", folder / f"pymunk_dragon-{VERSION}.tar.gz"


def test_archives_are_complete_and_an_index_would_accept_them(archives):
    assert run(sys.executable, "-m", "twine", "check", "--strict", *archives).count("PASSED") == 2
    package = [path for path in (ROOT / "pymunk_dragon").rglob("*") if path.is_file()]
    files = {path.relative_to(ROOT).as_posix() for path in package if "__pycache__" not in path.parts}
    assert {name for name in zipfile.ZipFile(archives[0]).namelist() if ".dist-info/" not in name} == files
    with tarfile.open(archives[1]) as archive:
        packed = {name.partition("/")[2] for name in archive.getnames()}
    read = ("README.md", "README.zh.md", "LICENSE", "Makefile", "renders/documentation.py", "tests/conftest.py")
    assert packed >= files.union(read)
    assert not any(name.startswith(("renders/docs", ".venv", "renders/march")) for name in packed)


def test_installed_archives_run_the_program_and_a_lesson(archives, programs, tmp_path):
    install = [programs / "pip", "install", "--quiet", "--no-compile"]
    run(*install, "--only-binary", ":all:", f"{archives[0]}[demos]")
    assert "benches 0 and 8" in run(programs / "pymunk-dragon", "contact", cwd=tmp_path)
    assert run(programs / "pymunk-dragon", "demo", "sat", "--save", tmp_path, cwd=tmp_path)
    assert list(tmp_path.iterdir())
    # The source distribution installs the same program.
    run(*install, "--no-deps", "--force-reinstall", archives[1])
    assert "benches 0 and 8" in run(programs / "pymunk-dragon", "simulate", "--from", "412", cwd=tmp_path)


def test_metadata_and_citation_name_what_users_look_for():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {"authors", "classifiers", "description", "keywords", "license", "readme", "urls"} <= set(project)
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {VERSION}\n" in citation
    assert "Study On The Bench Dragon Problem" in citation
