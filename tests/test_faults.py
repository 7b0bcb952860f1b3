"""What a user's machine can do to the program.

Files are whole or not there, whatever interrupts their writing.
"""

import errno
import os
import pty
import signal
import stat
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import imageio_ffmpeg
import psutil
import pytest
from conftest import (
    LIMIT,
    assert_one_line,
    assert_says,
    not_under_coverage,
    read_until,
    refusal,
    wait_until,
)

import pymunk_dragon
from pymunk_dragon import OutputError
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.drawing import FILM_ENDINGS


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
    assert_says(refusal(write, "/dev/full", "new", error=OutputError), "No space left on device")
    fifo = tmp_path / "p.csv"
    os.mkfifo(fifo)
    with subprocess.Popen(
        ["timeout", "300", "cat", str(fifo)], stdout=subprocess.PIPE, text=True
    ) as reader:
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
        error = refusal(check_destination, tmp_path / name, [".npz", ".json"])
        assert (error.name, words in str(error)) == ("output", True), name
    assert_says(refusal(write, tmp_path / "none" / "run.npz", "new", error=OutputError), "No such")
    assert names(tmp_path) == ["circle.npz", "file", "folder.npz"]
    long = tmp_path / ("x" * 251 + ".npz")
    for path in (tmp_path / "run.NPZ", tmp_path / "a.b.npz", long):
        assert check_destination(str(path), [".npz"]) == path
    assert not long.exists()


def test_package_says_that_it_is_typed_and_which_version_it_is():
    assert (Path(pymunk_dragon.__file__).parent / "py.typed").is_file()
    assert pymunk_dragon.__version__ == version("pymunk-dragon")


# Signals, full disks, closed streams: a documented exit code, at most one line, and whole files
# only

PROGRAM = [sys.executable, "-m", "pymunk_dragon"]


def program(*arguments, before="", after="", folder=None, **environment):
    """Exit code, stdout and stderr of the program in a shell, between `before` and `after`."""
    command = ["bash", "-c", f'{before} "$@" {after}', "-", *PROGRAM, *map(str, arguments)]
    options = {"timeout": LIMIT, "cwd": folder, "env": os.environ | environment}
    ended = subprocess.run(command, capture_output=True, text=True, **options)
    return ended.returncode, ended.stdout, ended.stderr


def quick_and_all(quick, more):
    """Two cases: the quick one, and all the others in the thorough suite."""
    cases = [
        pytest.param(quick, id="quick"),
        pytest.param(more, id="others", marks=pytest.mark.thorough),
    ]
    return pytest.mark.parametrize("commands", cases)


# Standard streams


@quick_and_all(
    ["--help", "positions --json"],
    ["--version", "demo sat", "simulate --until 0.1 --benches 9", "contact --until 1 --benches 9"],
)
def test_output_that_cannot_be_written_is_one_line_and_exit_code_1(commands):
    for command in commands:
        for after, words in ((">/dev/full", "No space left on device"), (">&-", "not writable")):
            code, _, err = program(*command.split(), after=after)
            assert code == 1, command
            assert_one_line(err, words)


def test_streams_that_are_closed_early_are_no_error_message(tmp_path):
    code, _, err = program("positions", "--times", "0:300:0.1", after="| head -1")
    assert (code, err) == (0, "")
    assert program("positions", "--pitch", "-1", after="2>&-")[0] == 2
    picture = tmp_path / "march.png"
    assert (
        program("render", "-o", picture, "--until", "1", "--size", "64", after="<&- >&- 2>&-")[0]
        == 0
    )
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


# Signals


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ([signal.SIGINT], 130),
        pytest.param([signal.SIGTERM], 143, marks=pytest.mark.thorough),
        pytest.param([signal.SIGHUP], 129, marks=pytest.mark.thorough),
        # Started by nohup, which has programs ignore SIGHUP.
        pytest.param([signal.SIGHUP, signal.SIGINT], 130, marks=pytest.mark.thorough),
    ],
    ids=["ctrl-c", "term", "hup", "nohup"],
)
def test_signal_ends_a_simulation_with_one_line_and_leaves_the_old_file(
    tmp_path, numbers, expected
):
    path = tmp_path / "run.npz"
    path.write_bytes(b"old")
    mine, theirs = pty.openpty()
    # Tests that nohup started ignore SIGHUP.
    hup = f"--{'ignore' if len(numbers) > 1 else 'default'}-signal=HUP"
    # A march that takes a quarter of an hour to play.
    command = ["env", hup, *PROGRAM, "simulate", "--pitch", "5", "--turns", "60", "-o", path]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, text=True) as process:
        os.close(theirs)
        # The terminal shows the time left.
        assert b"simulate" in read_until(mine, rb"simulate .*%.*\d\d:\d\d:\d\d")
        for number in numbers:
            process.send_signal(number)
        try:
            said = read_until(mine, None)
            out, _ = process.communicate(timeout=LIMIT)
        finally:
            process.kill()
    os.close(mine)
    assert (process.returncode, out) == (expected, "")
    assert said.rstrip().endswith(b"\npymunk-dragon: interrupted")
    assert names(tmp_path) == ["run.npz"]
    assert path.read_bytes() == b"old"


# Full disks


@not_under_coverage
@quick_and_all(
    [("positions --times 0:300:1", "p.csv")],
    [
        ("positions --times 0:300:1", "p.xlsx"),
        ("contact --from 412", "c.xlsx"),
        ("simulate --until 1", "run.npz"),
        ("render --until 6", "film.gif"),
        *(("report RUN.npz", f"report{ending}") for ending in (".html", ".md", ".csv", ".json")),
        ("render --until 6", "film.mp4"),
        ("render --until 6", "film.webp"),
        ("render RUN.npz", "page.html"),
        ("figure spiral", "figure.svg"),
        ("demo pitch", "lesson.html"),
    ],
)
def test_full_disk_is_one_line_and_leaves_the_old_file(
    tmp_path, tmp_path_factory, small_run, commands
):
    run = tmp_path_factory.mktemp("run") / "run.npz"
    small_run.save(run)
    for arguments, file in commands:
        (tmp_path / file).write_bytes(b"old")
        # FFmpeg writes all of a short film at its end. Nothing at all can be written by the
        # finalizers of archives and programs either.
        limits = [30 if file.endswith("mp4") else 4]
        if file.endswith(("csv", "xlsx", "npz", "mp4")):
            limits.append(0)
        for limit in limits:
            # Matplotlib cannot be imported with an unknown backend in the environment; the program
            # chooses its own.
            words, before = arguments.replace("RUN.npz", str(run)).split(), f"ulimit -f {limit};"
            code, out, err = program(
                *words, "-o", file, before=before, folder=tmp_path, MPLBACKEND="bogus"
            )
            assert (code, out) == (1, ""), file
            assert_one_line(err, "cannot write ")
            assert names(tmp_path) == [file]
            assert (tmp_path / file).read_bytes() == b"old"
        (tmp_path / file).unlink()


# What FFmpeg may do instead of writing a film, as programs of bash that get its arguments.
FFMPEGS = {
    "full disk": 'ulimit -f 4; exec {ffmpeg} "$@"',
    "encoder is missing": 'exec {ffmpeg} "${{@/libx264/absent}}"',
    "killed at a frame": "head -c 50000 >/dev/null; kill -KILL $$",
    "killed before the index": 'cat >"${{!#}}"; kill -KILL $$',
    "killed before the last data": '{ffmpeg} "$@"; truncate -s -1 "${{!#}}"; kill -KILL $$',
}


@not_under_coverage
@pytest.mark.parametrize("code", FFMPEGS.values(), ids=FFMPEGS)
def test_film_that_ffmpeg_does_not_write_is_one_line_and_leaves_the_old_file(tmp_path, code):
    ffmpeg, film = tmp_path / "ffmpeg", tmp_path / "film.mp4"
    ffmpeg.write_text("#!/bin/bash\n" + code.format(ffmpeg=imageio_ffmpeg.get_ffmpeg_exe()))
    ffmpeg.chmod(0o755)
    film.write_bytes(b"old")
    arguments = ["render", "--until", "6", "--size", "96", "-o", film]
    code, out, err = program(*arguments, IMAGEIO_FFMPEG_EXE=str(ffmpeg))
    assert (code, out) == (1, "")
    assert_one_line(err, "cannot write ")
    assert names(tmp_path) == ["ffmpeg", "film.mp4"]
    assert film.read_bytes() == b"old"


# Imports, which make up most of the time of short commands

DRAWING = {"PIL", "imageio", "matplotlib", "multiprocessing", "pymunk_dragon.drawing"}
HEAVY = DRAWING | {"pymunk", "scipy", "tomllib", "numpy.polynomial", "pymunk_dragon.reports"}
NO_NUMBERS = HEAVY | {"numpy", "email", "importlib.metadata", "pymunk_dragon.model"}


@not_under_coverage  # It imports some of these itself.
@quick_and_all(
    {"--help": NO_NUMBERS, "positions --times 0": HEAVY | {"pymunk_dragon.collision"}},
    {
        "contact --help": HEAVY,
        "contact --until 1": HEAVY | {"pymunk_dragon.studies"},
        "study min-pitch --benches 30": HEAVY,
        "figure speeds -o speeds.png": {"matplotlib.pyplot", "pymunk"},
        "simulate --until 0.01": DRAWING | {"scipy", "matplotlib", "pymunk_dragon.studies"},
    },
)
def test_command_imports_only_what_it_uses(commands, tmp_path):
    for arguments, absent in commands.items():
        command = [sys.executable, "-X", "importtime", *PROGRAM[1:], *arguments.split()]
        told = subprocess.run(
            command, capture_output=True, text=True, check=True, cwd=tmp_path
        ).stderr
        imported = {
            line.rpartition("|")[2].strip()
            for line in told.splitlines()
            if line.startswith("import time:")
        }
        assert "pymunk_dragon.cli" in imported
        assert imported.isdisjoint(absent), arguments


# Films by several processes


@pytest.mark.thorough
def test_film_that_is_interrupted_leaves_no_file_and_no_process(tmp_path):
    for name in [f"film{ending}" for ending in FILM_ENDINGS]:
        command = [
            *PROGRAM,
            "render",
            "--until",
            "400",
            "--speedup",
            "0.5",
            "--size",
            "96",
            "-o",
            tmp_path / name,
        ]
        with subprocess.Popen(
            command, stderr=subprocess.PIPE, text=True, start_new_session=True
        ) as process:
            wait_until(process, lambda: names(tmp_path))
            children = psutil.Process(process.pid).children(recursive=True)
            os.killpg(process.pid, signal.SIGINT)  # A terminal sends it to all of them.
            _, err = process.communicate(timeout=LIMIT)
        assert process.returncode == 130
        assert_one_line(err, "interrupted")
        assert psutil.wait_procs(children, timeout=LIMIT)[1] == []
        assert names(tmp_path) == []
