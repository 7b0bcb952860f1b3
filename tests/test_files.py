"""Files are whole or not there, whatever interrupts their writing."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import tempfile

import pytest
from conftest import assert_says

from pymunk_dragon.errors import OutputError, ParameterError
from pymunk_dragon.files import check_destination, written_in_place


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
        "from pymunk_dragon.files import written_in_place\n"
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

    monkeypatch.setattr(tempfile, "mkstemp", refuse)
    with pytest.raises(ParameterError) as caught:
        check_destination(tmp_path / "run.npz", [".npz"])
    assert_says(caught.value, "in a folder that can be written (Permission denied)")
