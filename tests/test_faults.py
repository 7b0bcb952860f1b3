"""What a user's machine can do to the program: signals, full disks, closed streams.

Whatever happens, the program ends with a documented exit code and at most one line, and leaves whole files only.
"""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from functools import partial

import psutil
import pytest
from conftest import assert_says, not_under_coverage

PROGRAM = [sys.executable, "-m", "pymunk_dragon"]
# s: only a program that does not end reaches this.
LIMIT = 300


def program(*arguments, before="", after="", folder=None, **environment):
    """Run the program in a shell, with shell commands before it and redirections after it: code, stdout, stderr."""
    command = ["bash", "-c", f'{before} "$@" {after}', "-", *PROGRAM, *map(str, arguments)]
    ended = subprocess.run(
        command, capture_output=True, text=True, timeout=LIMIT, cwd=folder, env=os.environ | environment
    )
    return ended.returncode, ended.stdout, ended.stderr


def assert_one_line(err, *words):
    """`err` is one line of the program that holds `words`."""
    assert err.endswith("\n")
    assert_says(Exception(err[:-1]), "pymunk-dragon: ", *words)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def quick_and_all(quick, more):
    """Two cases: the quick one, and all the others in the thorough suite."""
    cases = [pytest.param(quick, id="quick"), pytest.param(more, id="others", marks=pytest.mark.thorough)]
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
    assert program("render", "-o", picture, "--until", "1", "--size", "64", after="<&- >&- 2>&-")[0] == 0
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


# Signals


def read_until(stream, pattern):
    """What comes from a terminal until it matches `pattern`, or until its other side is closed."""
    seen = b""
    while not (pattern and re.search(pattern, seen)):
        assert select.select([stream], [], [], LIMIT)[0]
        try:
            seen += os.read(stream, 4096)
        except OSError:  # Linux raises one when the other side is closed.
            break
    return seen


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
def test_signal_ends_a_simulation_with_one_line_and_leaves_the_old_file(tmp_path, numbers, expected):
    path = tmp_path / "run.npz"
    path.write_bytes(b"old")
    mine, theirs = pty.openpty()
    # A march that takes a quarter of an hour to play.
    command = [*PROGRAM, "simulate", "--pitch", "5", "--turns", "60", "-o", str(path)]
    if len(numbers) > 1:
        command = ["bash", "-c", 'trap "" HUP; exec "$@"', "-", *command]
    # Tests that nohup started ignore SIGHUP.
    with_hup = partial(signal.signal, signal.SIGHUP, signal.SIG_DFL)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, text=True, preexec_fn=with_hup) as process:
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
        ("simulate --until 1", "run.npz"),
        ("render --until 6", "film.gif"),
        ("render --until 6", "film.mp4"),
        ("render RUN.npz", "page.html"),
        ("figure spiral", "figure.svg"),
        ("demo pitch", "lesson.html"),
    ],
)
def test_full_disk_is_one_line_and_leaves_the_old_file(tmp_path, tmp_path_factory, small_run, commands):
    run = tmp_path_factory.mktemp("run") / "run.npz"
    small_run.save(run)
    for arguments, file in commands:
        (tmp_path / file).write_bytes(b"old")
        # FFmpeg writes all of a short film at its end.
        limit = f"ulimit -f {30 if file.endswith('mp4') else 4};"
        # Matplotlib cannot be imported with an unknown backend in the environment; the program chooses its own.
        words = arguments.replace("RUN.npz", str(run)).split()
        code, out, err = program(*words, "-o", file, before=limit, folder=tmp_path, MPLBACKEND="bogus")
        assert (code, out) == (1, ""), file
        assert_one_line(err, "cannot write ")
        assert names(tmp_path) == [file]
        assert (tmp_path / file).read_bytes() == b"old"
        (tmp_path / file).unlink()


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
        "simulate --until 0.01": DRAWING | {"scipy", "matplotlib", "pymunk_dragon.studies"},
    },
)
def test_command_imports_only_what_it_uses(commands):
    for arguments, absent in commands.items():
        command = [sys.executable, "-X", "importtime", *PROGRAM[1:], *arguments.split()]
        told = subprocess.run(command, capture_output=True, text=True, check=True).stderr
        imported = {line.rpartition("|")[2].strip() for line in told.splitlines() if line.startswith("import time:")}
        assert "pymunk_dragon.cli" in imported
        assert imported.isdisjoint(absent), arguments


# Films by several processes


def wait_for(condition, process):
    """What `condition()` returns, as soon as it is true; a process must not end before."""
    end = time.monotonic() + LIMIT
    while not (found := condition()):
        assert time.monotonic() < end
        with pytest.raises((subprocess.TimeoutExpired, psutil.TimeoutExpired)):
            process.wait(0.05)
    return found


@pytest.mark.thorough
def test_film_that_is_interrupted_leaves_no_file_and_no_process(tmp_path):
    for name in ("film.gif", "film.mp4"):
        options = ["--until", "400", "--speedup", "0.5", "--size", "96", "-o", tmp_path / name]
        pipe = subprocess.PIPE
        with subprocess.Popen(
            [*PROGRAM, "render", *options], stdout=pipe, stderr=pipe, text=True, start_new_session=True
        ) as process:
            wait_for(lambda: names(tmp_path), process)
            children = psutil.Process(process.pid).children(recursive=True)
            os.killpg(process.pid, signal.SIGINT)  # A terminal sends it to all of them.
            _, err = process.communicate(timeout=LIMIT)
        assert process.returncode == 130
        assert_one_line(err, "interrupted")
        assert psutil.wait_procs(children, timeout=LIMIT)[1] == []
        assert names(tmp_path) == []
