"""Files are whole or not there, whatever interrupts their writing."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from conftest import assert_says

import pymunk_dragon
from pymunk_dragon._files import check_destination, number_rows, written_in_place
from pymunk_dragon.errors import FileFormatError, OutputError, ParameterError


@pytest.fixture
def old_file(tmp_path):
    file = tmp_path / "film.gif"
    file.write_text("old")
    return file


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def write_half(path, interruption):
    with written_in_place(path) as draft:
        draft.write_text("half")
        raise interruption


def test_file_is_replaced_only_when_it_is_whole(old_file):
    with written_in_place(old_file) as draft:
        draft.write_text("new")
        assert old_file.read_text() == "old"
        assert draft.parent == old_file.parent
        assert draft.suffix == ".gif"
    assert old_file.read_text() == "new"
    assert names(old_file.parent) == ["film.gif"]


def test_new_file_appears_only_when_it_is_whole(tmp_path):
    with written_in_place(tmp_path / "new.png") as draft:
        draft.write_text("new")
        assert not (tmp_path / "new.png").exists()
    assert names(tmp_path) == ["new.png"]


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit, ValueError, MemoryError])
def test_interruption_leaves_the_old_file_and_no_litter(old_file, interruption):
    with pytest.raises(interruption):
        write_half(old_file, interruption)
    assert old_file.read_text() == "old"
    assert names(old_file.parent) == ["film.gif"]


def test_full_disk_is_an_output_error_of_one_line_and_leaves_the_old_file(old_file):
    with pytest.raises(OutputError) as caught:
        write_half(old_file, OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    assert str(caught.value) == f"cannot write {old_file}: No space left on device"
    assert old_file.read_text() == "old"
    assert names(old_file.parent) == ["film.gif"]


def test_failure_that_is_named_already_is_not_named_twice(old_file):
    with pytest.raises(OutputError, match=r"^cannot write film: no luck$"), written_in_place(old_file):
        raise OutputError("film", "no luck")


def test_ctrl_c_in_a_running_program_leaves_the_old_file_and_no_litter(old_file):
    program = (
        "import sys, time\n"
        "from pymunk_dragon._files import written_in_place\n"
        "with written_in_place(sys.argv[1]) as draft:\n"
        "    draft.write_text('half')\n"
        "    sys.stdout.write('writing\\n')\n"
        "    sys.stdout.flush()\n"
        "    time.sleep(60)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(old_file)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as child:
        assert child.stdout.readline() == b"writing\n"
        assert len(names(old_file.parent)) == 2
        child.send_signal(signal.SIGINT)
        assert child.wait(timeout=30) != 0
    assert old_file.read_text() == "old"
    assert names(old_file.parent) == ["film.gif"]


def test_written_file_has_the_permissions_of_any_other(tmp_path):
    with written_in_place(tmp_path / "ours.txt") as draft:
        draft.write_text("new")
    (tmp_path / "theirs.txt").write_text("new")
    assert (tmp_path / "ours.txt").stat().st_mode == (tmp_path / "theirs.txt").stat().st_mode


def test_name_may_be_as_long_as_the_file_system_allows(tmp_path):
    file = tmp_path / ("x" * 251 + ".gif")
    assert check_destination(file, [".gif"]) == file
    with written_in_place(file) as draft:
        draft.write_text("new")
    assert names(tmp_path) == [file.name]


@pytest.mark.parametrize("name", ["run", "run.txt", "run.npz.txt", ".npz"])
def test_unknown_ending_is_refused_with_the_known_ones(tmp_path, name):
    with pytest.raises(ParameterError) as caught:
        check_destination(tmp_path / name, [".npz", ".json"])
    assert caught.value.name == "output"
    assert str(caught.value).endswith("must be a file name that ends in .npz or .json")
    assert names(tmp_path) == []


@pytest.mark.parametrize("name", ["run.npz", "run.NPZ", "a.b.npz"])
def test_known_ending_is_taken_and_nothing_is_left_behind(tmp_path, name):
    assert check_destination(str(tmp_path / name), [".npz"]) == tmp_path / name
    assert names(tmp_path) == []


def test_folder_in_the_place_of_a_file_is_refused(tmp_path):
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(ParameterError, match="a file, not a folder"):
        check_destination(tmp_path / "folder.npz", [".npz"])


def test_missing_folder_is_refused_and_not_made(tmp_path):
    missing = tmp_path / "none" / "run.npz"
    for attempt in (lambda: check_destination(missing, [".npz"]), lambda: written_in_place(missing).__enter__()):
        with pytest.raises(ParameterError) as caught:
            attempt()
        assert caught.value.name == "output"
        assert str(caught.value).endswith("must be in a folder that can be written (No such file or directory)")
    assert names(tmp_path) == []


def test_file_in_the_place_of_a_folder_is_refused(old_file):
    with pytest.raises(ParameterError, match="Not a directory"):
        check_destination(old_file / "run.npz", [".npz"])


def test_folder_without_permission_is_refused(tmp_path, monkeypatch):
    # The superuser, who runs the tests in a container, may write anywhere: so the refusal is played.
    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(ParameterError) as caught:
        check_destination(tmp_path / "run.npz", [".npz"])
    assert_says(caught.value, "in a folder that can be written (Permission denied)")


def test_replaced_file_keeps_its_mode(old_file):
    for mode in (0o600, 0o640, 0o755, 0o444):
        old_file.chmod(mode)
        with written_in_place(old_file) as draft:
            # What it is to be kept from cannot read the draft either.
            assert draft.stat().st_mode & 0o777 & ~(mode | 0o600) == 0
            draft.write_text("new")
        assert old_file.stat().st_mode & 0o777 == mode


def test_umask_of_the_process_is_never_changed(tmp_path, monkeypatch):
    def refuse(*_):
        raise AssertionError("the umask belongs to all threads")

    monkeypatch.setattr(os, "umask", refuse)
    with written_in_place(tmp_path / "new.txt") as draft:
        draft.write_text("new")
    assert names(tmp_path) == ["new.txt"]


def test_symbolic_link_stays_and_its_file_is_replaced(tmp_path):
    (tmp_path / "folder").mkdir()
    file, link = tmp_path / "folder" / "file.gif", tmp_path / "link.gif"
    link.symlink_to(Path("folder") / "file.gif")
    for text in ("new", "newer"):  # At first it leads nowhere.
        assert check_destination(link, [".gif"]) == link
        with written_in_place(link) as draft:
            draft.write_text(text)
            assert draft.parent == file.parent
        assert link.is_symlink()
        assert file.read_text() == text
    assert names(tmp_path) == ["folder", "link.gif"]
    assert names(tmp_path / "folder") == ["file.gif"]


def test_device_is_written_and_stays():
    before = os.stat(os.devnull)
    with written_in_place(os.devnull) as draft:
        draft.write_text("new")
    assert os.path.samestat(before, os.stat(os.devnull))
    with pytest.raises(OutputError, match="No space left on device"), written_in_place("/dev/full") as draft:
        draft.write_text("new")


def test_device_needs_an_ending_only_where_there_is_a_choice():
    assert check_destination("/dev/null", [".npz"]) == Path("/dev/null")
    with pytest.raises(ParameterError, match=r"ends in \.csv or \.json"):
        check_destination("/dev/null", [".csv", ".json"])


@pytest.mark.parametrize("name", ["nul\0.npz", "x" * 300 + ".npz"])
def test_impossible_name_is_refused(tmp_path, name):
    with pytest.raises(ParameterError, match="a file that can be written"):
        check_destination(tmp_path / name, [".npz"])


def test_links_in_a_circle_are_refused(tmp_path):
    circle = tmp_path / "circle.npz"
    circle.symlink_to(circle)
    with pytest.raises(ParameterError, match="symbolic links"):
        check_destination(circle, [".npz"])
    assert names(tmp_path) == ["circle.npz"]


# Tables


def table(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_text(text)
    return number_rows(path, "points", ("x in m", "y in m"))


def test_first_line_may_hold_names(tmp_path):
    for head in ("x,y", "x", " x , y ,z", "x,", '"x","y"'):
        assert table(tmp_path, f"{head}\n1,2\n") == ([2], [(1.0, 2.0)])


@pytest.mark.parametrize("first", ["x,1", "1,y", "1", "1,2,3", ",1"])
def test_first_line_that_is_half_text_is_an_error(tmp_path, first):
    with pytest.raises(FileFormatError) as caught:
        table(tmp_path, f"{first}\n1,2\n")
    assert_says(caught.value, "line 1 must hold x in m and y in m", repr(first))


def test_cell_that_is_too_long_is_an_error(tmp_path):
    for text in ("1" * 131073, "x" * 131073):
        with pytest.raises(FileFormatError) as caught:
            table(tmp_path, f"1,2\n{text},2\n")
        assert_says(caught.value, "line 2 must hold x in m and y in m")


def test_file_without_end_is_refused_at_once():
    with pytest.raises(FileFormatError, match=r"/dev/zero: larger than 4 MB"):
        number_rows("/dev/zero", "points", ("x in m", "y in m"))


def test_package_says_that_it_is_typed_and_which_version_it_is():
    # What type checkers look for beside the modules.
    assert (Path(pymunk_dragon.__file__).parent / "py.typed").is_file()
    assert pymunk_dragon.__version__ == version("pymunk-dragon")
