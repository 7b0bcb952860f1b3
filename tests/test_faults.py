"""What a user's machine can do to the program: signals, full disks, closed streams, files of any kind.

Whatever happens, the program ends within seconds with a documented exit code and at most one line, and leaves whole
files only. `FUZZ_CASES=400 pytest tests/test_faults.py -k any_moment` sends 400 signals, at other moments each time;
the suite sends a few, always at the same ones.
"""

from __future__ import annotations

import io
import os
import re
import signal
import stat
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
from conftest import assert_says, not_under_coverage
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import pymunk_dragon
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

PROGRAM = [sys.executable, "-m", "pymunk_dragon"]
SMALL = ["--benches", "4", "--turns", "8"]
# s: no command of this file works for longer, whatever happens to it.
LIMIT = 120
CASES = int(os.environ.get("FUZZ_CASES", "0"))


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
    return sorted(path.name for path in Path(folder).iterdir())


@pytest.fixture(scope="session")
def run_of_one_frame(tmp_path_factory):
    path = tmp_path_factory.mktemp("one") / "one.npz"
    march = March(Dragon(benches=4))
    run = Run.exact(march, [0.0])
    provenance = {"player": "pymunk", "substep": 0.01}
    Run(march=march, times=run.times, poses=run.poses, drift=run.drift + 1e-3, provenance=provenance).save(path)
    return path


# Standard streams


@pytest.mark.parametrize(
    "arguments",
    [
        ["positions"],
        ["positions", "--json"],
        ["--help"],
        ["positions", "--help"],
        ["--version"],
        ["study"],
        ["demo"],
        ["figure", "--json"],
        pytest.param(["demo", "near-miss"], marks=pytest.mark.thorough),
        pytest.param(["simulate", "--until", "0.1"], marks=pytest.mark.thorough),
        pytest.param(["contact", "--until", "1"], marks=pytest.mark.thorough),
        pytest.param(["contact", "--until", "1", "--compare"], marks=pytest.mark.thorough),
        pytest.param(["study", "min-pitch", "--json"], marks=pytest.mark.thorough),
    ],
    ids=" ".join,
)
def test_output_that_cannot_be_written_is_one_line_and_exit_code_1(arguments):
    code, _, err = program(*arguments, after=">/dev/full")
    assert code == 1
    assert_one_line(err, "No space left on device")
    code, _, err = program(*arguments, after=">&-")
    assert code == 1
    assert_one_line(err, "not writable")


def test_closed_streams_that_are_not_needed_do_no_harm(tmp_path):
    picture = tmp_path / "march.png"
    code, _, _ = program("render", "-o", picture, "--until", "1", "--size", "64", after="<&- >&- 2>&-")
    assert code == 0
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_error_that_cannot_be_told_still_has_its_exit_code():
    for after in ("2>/dev/full", "2>&-"):
        assert program("positions", "--pitch", "-1", after=after)[0] == 2


def test_reader_that_has_seen_enough_is_no_error_message():
    code, _, err = program("positions", "--times", "0:300:0.1", after="| head -1")
    assert (code, err) == (0, "")


@pytest.mark.thorough
def test_folder_that_the_output_has_no_letters_for_is_printed_escaped(tmp_path):
    code, out, err = program("demo", "near-miss", "--save", "d\xfcne", folder=tmp_path, PYTHONIOENCODING="ascii")
    assert (code, err) == (0, "")
    assert r"d\xfcne" in out
    assert names(tmp_path) == ["d\xfcne"]


# Signals

SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}


# Where a signal comes while Python runs other code of its own: in a string, as dataclasses are made of, and where an
# object ends, from which no exception leaves.
MOMENTS = {
    "module": "os.kill(os.getpid(), {number})",
    "string": "exec('os.kill(os.getpid(), {number})')",
    "end of an object": "type('Ending', (), {{'__del__': lambda self: os.kill(os.getpid(), {number})}})()",
}


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("module", ["click", "numpy", "pymunk_dragon.cli.positions"])
def test_signal_during_the_imports_is_one_line(tmp_path, module, moment, number):
    (tmp_path / "sitecustomize.py").write_text(
        "import os, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}:\n"
        f"            {MOMENTS[moment].format(number=int(number))}\n"
        "sys.meta_path.insert(0, Finder())\n"
    )
    code, out, err = program("positions", PYTHONPATH=str(tmp_path))
    assert (code, out) == (SIGNALS[number], "")
    assert_one_line(err, "interrupted")


def test_ignored_signal_stays_ignored():
    # As nohup starts programs.
    code = (
        "import os, signal, sys\n"
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        f"os.execv({sys.executable!r}, {[*PROGRAM, 'simulate', '--until', '5']!r})\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        time.sleep(2.0)
        process.send_signal(signal.SIGHUP)
        out, _ = process.communicate(timeout=LIMIT)
    assert process.returncode == 0
    assert "no contact" in out


# Each works for several seconds, and writes the file that is named last.
LONG = {
    "simulate": ["simulate", "--until", "60", "-o", "run.npz"],
    "resolve": ["simulate", "--from", "412.3", "--until", "440", "--contacts", "resolve", "-o", "run.npz"],
    "gif": ["render", "--until", "100", "--speedup", "1", "--workers", "0", "-o", "film.gif"],
    "workers": ["render", "--until", "400", "--speedup", "0.5", "--size", "640", "--workers", "1", "-o", "film.gif"],
    "mp4": ["render", "--until", "100", "--speedup", "1", "--workers", "0", "-o", "film.mp4"],
    "tables": ["positions", "--times", "0:300:0.5", "-o", "tables.xlsx"],
    "page": ["render", "--until", "400", "-o", "page.html"],
}


def is_whole(path):
    """Whether a file has an end."""
    content = path.read_bytes()
    if path.suffix in (".npz", ".xlsx"):
        return zipfile.ZipFile(io.BytesIO(content)).testzip() is None
    if path.suffix == ".mp4":
        return b"moov" in boxes(content)
    return {".gif": b";", ".html": b"</html>"}[path.suffix] in content[-200_000:]


def boxes(content):
    """Return the kinds of an MP4 file's boxes, or none where the file ends inside one of them."""
    kinds, at = [], 0
    while at < len(content):
        kinds.append(content[at + 4 : at + 8])
        at += int.from_bytes(content[at : at + 4]) or len(content)
    return kinds if at == len(content) else []


def interrupted(folder, name, number, delay, old):
    """Send a signal `delay` s after the start, and check what is left."""
    arguments = LONG[name]
    file = folder / arguments[-1]
    if old:
        file.write_bytes(b"old")
    with subprocess.Popen(
        [*PROGRAM, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            process.wait(delay)
        except subprocess.TimeoutExpired:
            process.send_signal(number)
        _, err = process.communicate(timeout=LIMIT)
    # The file as it was, or as it should be: the signal may come when it is finished.
    assert names(folder) in ([], [file.name])
    kept = file.read_bytes() == b"old" if file.exists() else False
    assert kept or (is_whole(file) if file.exists() else not old)
    # Before the program's first line Python answers: it ends by the signal, or tells which of its own lines it was in.
    if process.returncode == -number or (number == signal.SIGINT and "Traceback" in err):
        assert "pymunk_dragon/" not in err
        return
    assert process.returncode in (0, SIGNALS[number])
    if process.returncode == 0:
        assert file.exists()
        assert not kept
        assert err == ""
    else:
        assert_one_line(err, "interrupted")


@pytest.mark.parametrize(
    ("name", "number", "delay"),
    [
        ("simulate", signal.SIGTERM, 2.0),
        ("tables", signal.SIGHUP, 2.0),
        pytest.param("workers", signal.SIGTERM, 3.0, marks=pytest.mark.thorough),
        pytest.param("mp4", signal.SIGHUP, 2.0, marks=pytest.mark.thorough),
    ],
)
def test_signal_leaves_the_old_file_and_no_draft(tmp_path, name, number, delay):
    interrupted(tmp_path, name, number, delay, old=True)


@pytest.mark.thorough
@settings(max_examples=CASES or 20, derandomize=not CASES, database=None, phases=[Phase.generate])
@given(
    name=st.sampled_from(sorted(LONG)),
    number=st.sampled_from(sorted(SIGNALS)),
    delay=st.floats(0.2, 8.0),
    old=st.booleans(),
)
def test_signal_at_any_moment_leaves_whole_files_and_one_line(tmp_path_factory, name, number, delay, old):
    interrupted(tmp_path_factory.mktemp("signal"), name, number, delay, old)


WRITER = (
    "import sys, time\n"
    "from pymunk_dragon._files import written_in_place\n"
    "with written_in_place(sys.argv[1]) as draft:\n"
    "    draft.write_text('half')\n"
    "    print('writing', flush=True)\n"
    "    sys.stdin.read()\n"
)


def writer(path):
    """Another process that is writing `path` until its input ends."""
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "writing\n"
    return process


def test_next_write_clears_the_drafts_of_processes_that_were_killed(tmp_path):
    file = tmp_path / "run.csv"
    with writer(file) as killed, writer(file) as alive:
        killed.kill()
        killed.communicate()
        assert len(names(tmp_path)) == 2
        assert program("positions", "-o", file) == (0, "", "")
        # The draft of the process that still writes stays.
        assert len(names(tmp_path)) == 2
        alive.communicate()
    assert names(tmp_path) == ["run.csv"]
    assert file.read_text() == "half"


def test_only_drafts_are_cleared(tmp_path):
    others = [".pymunk-dragon-notes.txt", ".pymunk-dragon", ".pymunk-dragon-12-0badcafe.csv.bak"]
    for name in others:
        (tmp_path / name).write_text("mine")
    (tmp_path / ".pymunk-dragon-12-0badcafe.csv").symlink_to(tmp_path / others[0])
    assert program("positions", "-o", tmp_path / "p.csv") == (0, "", "")
    for name in others[:2]:
        assert (tmp_path / name).read_text() == "mine"


# Full disks


@not_under_coverage
@pytest.mark.parametrize(
    ("arguments", "file"),
    [
        (["positions", "--times", "0:300:1"], "p.csv"),
        (["positions", "--times", "0:300:1"], "p.json"),
        pytest.param(["positions", "--times", "0:300:1"], "p.xlsx", marks=pytest.mark.thorough),
        pytest.param(["simulate", "--until", "3"], "run.npz", marks=pytest.mark.thorough),
        pytest.param(["render", "--until", "6"], "film.gif", marks=pytest.mark.thorough),
        pytest.param(["render", "--until", "6"], "film.apng", marks=pytest.mark.thorough),
        pytest.param(["render", "--until", "6"], "film.webp", marks=pytest.mark.thorough),
        pytest.param(["render", "--until", "6"], "page.html", marks=pytest.mark.thorough),
        pytest.param(["render", "--until", "6"], "still.png", marks=pytest.mark.thorough),
        pytest.param(["figure", "spiral"], "figure.svg", marks=pytest.mark.thorough),
        pytest.param(["demo", "pitch"], "lesson.html", marks=pytest.mark.thorough),
    ],
)
def test_full_disk_is_one_line_and_leaves_the_old_file(tmp_path, arguments, file):
    (tmp_path / file).write_bytes(b"old")
    code, out, err = program(*arguments, "-o", file, before="ulimit -f 4;", folder=tmp_path)
    assert (code, out) == (1, "")
    assert_one_line(err, "File too large")
    assert names(tmp_path) == [file]
    assert (tmp_path / file).read_bytes() == b"old"


@not_under_coverage
def test_font_cache_that_cannot_be_written_is_one_line(tmp_path):
    cache, folder = tmp_path / "cache", tmp_path / "out"
    folder.mkdir()
    environment = {"MPLCONFIGDIR": str(cache)}
    code, _, err = program("figure", "spiral", "-o", folder / "l.svg", before="ulimit -f 5;", **environment)
    assert code == 1
    assert_one_line(err, "cannot write", "File too large")
    assert names(folder) == []


# Destinations of any kind


def test_fifo_is_written_and_stays(tmp_path):
    fifo = tmp_path / "p.csv"
    os.mkfifo(fifo)
    # The reader gives up where nobody writes.
    command = ["timeout", "60", "cat", str(fifo)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as reader:
        written = program("positions", "--times", "0", "-o", fifo)
        out, _ = reader.communicate()
    assert written == (0, "", "")
    assert out.startswith("time_s,handle,")
    assert stat.S_ISFIFO(fifo.stat().st_mode)
    assert names(tmp_path) == ["p.csv"]


@pytest.mark.parametrize("kept", ["", "kept\n"])
def test_standard_output_is_a_file_to_write_to(tmp_path, kept):
    link, log = tmp_path / "out.csv", tmp_path / "log"
    link.symlink_to("/dev/stdout")
    log.write_text(kept)
    assert program("positions", "--times", "0", "-o", link, after=">> log", folder=tmp_path) == (0, "", "")
    assert log.read_text().startswith(f"{kept}time_s,handle,")
    _, out, _ = program("positions", "--times", "0", "-o", link, after="| cat")
    assert out.startswith("time_s,handle,")
    assert link.is_symlink()
    assert names(tmp_path) == ["log", "out.csv"]


@pytest.mark.thorough
def test_run_goes_to_devices_too():
    assert program("simulate", "--until", "0.1", "-o", "/dev/null")[0] == 0
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    code, _, err = program("simulate", "--until", "0.1", "-o", "/dev/full")
    assert code == 1
    assert_one_line(err, "cannot write /dev/full", "No space left on device")


def test_name_that_is_too_long_is_bad_input(tmp_path):
    for name in ("x" * 252 + ".csv", "x" * 5000 + ".csv"):
        code, out, err = program("positions", "-o", tmp_path / name)
        assert (code, out) == (2, "")
        assert "File name too long" in err
        assert err.count("\n") == 1
    assert names(tmp_path) == []


# The user's surroundings


def test_backend_of_matplotlib_does_not_matter(tmp_path):
    code, out, err = program("figure", "spiral", "-o", tmp_path / "s.svg", MPLBACKEND="bogus")
    assert (code, out, err) == (0, "", "")


# Runs of one frame or one substep


def test_figures_of_a_run_of_one_frame_are_refused(run_of_one_frame, tmp_path):
    for name in ("drift", "impulses"):
        code, _, err = program("figure", name, run_of_one_frame, "-o", tmp_path / "f.svg")
        assert code == 2
        assert_one_line(err, "run is")
    assert names(tmp_path) == []


def test_shortest_run_has_one_substep(call):
    code, out, err = call("simulate", "--until", "1e-8", *SMALL)
    assert (code, err) == (0, "")
    assert re.search(r"\b1 substeps?\b", out) or "no contact" in out


def test_film_of_a_program_from_the_standard_input_is_drawn_without_workers(tmp_path):
    """Worker processes import the main program, which is no file here; the film once waited for them for ever."""
    lines = (
        "from pymunk_dragon import Dragon, March, render",
        "render(March(Dragon(benches=12)), 'film.gif', workers=2, until=40, speedup=4, fps=20, size=64)",
    )
    done = subprocess.run(
        [sys.executable, "-"], input="\n".join(lines), cwd=tmp_path, capture_output=True, text=True, timeout=LIMIT
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert is_whole(tmp_path / "film.gif")


def test_no_module_needs_another_one_to_be_compiled():
    """Python imports `unicodedata` for named characters; a signal in that import would be a SyntaxError."""
    package = Path(pymunk_dragon.__file__).parent
    assert [path.name for path in package.rglob("*.py") if "\\N{" in path.read_text(encoding="utf-8")] == []
