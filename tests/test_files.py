"""Files are whole or not there, whatever interrupts their writing."""

import errno
import os
import stat
import subprocess
from importlib.metadata import version
from pathlib import Path

import pytest
from conftest import assert_says

import pymunk_dragon
from pymunk_dragon import FileFormatError, OutputError, ParameterError
from pymunk_dragon._files import check_destination, number_rows, written_in_place


@pytest.fixture
def old_file(tmp_path):
    file = tmp_path / "film.gif"
    file.write_text("old")
    return file


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def write(path, text, interruption=None):
    with written_in_place(path) as draft:
        draft.write_text(text)
        if interruption:
            raise interruption


def test_interruption_leaves_the_old_file_and_no_draft(old_file):
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    for interruption in (KeyboardInterrupt, SystemExit, ValueError, MemoryError, full):
        expected = OutputError if interruption is full else interruption
        with pytest.raises(expected) as caught:
            write(old_file, "half", interruption)
        if interruption is full:
            assert_says(caught.value, str(old_file), "No space left on device")
        assert old_file.read_text() == "old"
        assert names(old_file.parent) == ["film.gif"]


def test_mode_of_a_file_is_that_of_the_old_one_or_the_usual_one(old_file):
    for mode in (0o600, 0o640, 0o755, 0o444):
        old_file.chmod(mode)
        old_file.write_text("old")
        with written_in_place(old_file) as draft:
            # Nobody else can read the draft.
            assert draft.parent.stat().st_mode & 0o777 == 0o700
            draft.write_text("new")
            assert (old_file.read_text(), draft.suffix) == ("old", ".gif")
        assert (old_file.read_text(), old_file.stat().st_mode & 0o777) == ("new", mode)
    ours, theirs = old_file.parent / "ours.txt", old_file.parent / "theirs.txt"
    write(ours, "new")
    theirs.write_text("new")
    assert ours.stat().st_mode == theirs.stat().st_mode


def test_symbolic_link_stays_and_its_file_is_replaced(tmp_path):
    (tmp_path / "folder").mkdir()
    file, link = tmp_path / "folder" / "file.gif", tmp_path / "link.gif"
    link.symlink_to(Path("folder") / "file.gif")
    for text in ("new", "newer"):  # At first it leads nowhere.
        assert check_destination(link, [".gif"]) == link
        write(link, text)
        assert link.is_symlink()
        assert file.read_text() == text
    assert names(tmp_path) == ["folder", "link.gif"]
    assert names(tmp_path / "folder") == ["file.gif"]


def test_devices_and_fifos_are_written_and_stay(tmp_path):
    before = os.stat(os.devnull)
    write(os.devnull, "new")
    assert os.path.samestat(before, os.stat(os.devnull))
    assert check_destination("/dev/null", [".npz"]) == Path("/dev/null")
    with pytest.raises(OutputError, match="No space left on device"):
        write("/dev/full", "new")
    fifo = tmp_path / "p.csv"
    os.mkfifo(fifo)
    with subprocess.Popen(["timeout", "300", "cat", str(fifo)], stdout=subprocess.PIPE, text=True) as reader:
        write(fifo, "new")
        assert reader.communicate()[0] == "new"
    assert stat.S_ISFIFO(fifo.stat().st_mode)


def test_destination_that_cannot_be_written_is_refused_and_leaves_nothing(tmp_path):
    (tmp_path / "folder.npz").mkdir()
    (tmp_path / "file").write_text("")
    (tmp_path / "circle.npz").symlink_to(tmp_path / "circle.npz")
    cases = {
        "run": "ends in .npz or .json",
        "run.txt": "ends in .npz or .json",
        ".npz": "ends in .npz or .json",
        "folder.npz": "not a folder",
        "none/run.npz": "No such file or directory",
        "file/run.npz": "Not a directory",
        "nul\0.npz": "can be written",
        "x" * 300 + ".npz": "File name too long",
        "circle.npz": "symbolic links",
    }
    for name, words in cases.items():
        with pytest.raises(ParameterError) as caught:
            check_destination(tmp_path / name, [".npz", ".json"])
        assert caught.value.name == "output"
        assert words in str(caught.value), name
    with pytest.raises(ParameterError, match="folder"):
        write(tmp_path / "none" / "run.npz", "new")
    assert names(tmp_path) == ["circle.npz", "file", "folder.npz"]
    long = tmp_path / ("x" * 251 + ".npz")
    for path in (tmp_path / "run.NPZ", tmp_path / "a.b.npz", long):
        assert check_destination(str(path), [".npz"]) == path
    assert not long.exists()


def test_first_line_of_a_table_may_hold_names_but_no_line_anything_else(tmp_path):
    path = tmp_path / "table.csv"

    def read(text):
        path.write_text(text)
        return number_rows(path, "points", ("x in m", "y in m"))

    for head in ("x,y", "x", " x , y ,z", "x,", '"x","y"'):
        assert read(f"{head}\n1,2\n") == ([2], [(1.0, 2.0)])
    for first in ("x,1", "1,y", "1", "1,2,3", ",1"):
        with pytest.raises(FileFormatError) as caught:
            read(f"{first}\n1,2\n")
        assert_says(caught.value, "line 1 ", repr(first))
    with pytest.raises(FileFormatError, match=r"/dev/zero: larger than 4 MB"):
        number_rows("/dev/zero", "points", ("x in m", "y in m"))


def test_package_says_that_it_is_typed_and_which_version_it_is():
    assert (Path(pymunk_dragon.__file__).parent / "py.typed").is_file()
    assert pymunk_dragon.__version__ == version("pymunk-dragon")
