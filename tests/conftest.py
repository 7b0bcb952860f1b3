"""What several test files share."""

import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import hypothesis
import numpy as np
import pytest
import sharing
from browser import chromium
from gallery import share_off
from PIL import Image
from sharing import shared_run

from pymunk_dragon import Dragon, March, ParameterError, simulate
from pymunk_dragon.cli import status

# Examples share the machine with whatever else runs there, so none has a time limit of its own.
# They are the same every time, so that a failure comes from a change;
# `--hypothesis-profile=explore` draws new ones. A failure is not explained: that traces every line.
# A worker on Python 3.11 once stood still, probably in it.
PHASES = set(hypothesis.Phase) - {hypothesis.Phase.explain}
hypothesis.settings.register_profile("explore", deadline=None, print_blob=True)
SAME = {"deadline": None, "derandomize": True, "phases": PHASES}
hypothesis.settings.register_profile("house", **SAME, max_examples=30)
hypothesis.settings.register_profile("quick", **SAME, max_examples=15)
hypothesis.settings.load_profile("house")

# A shell that starts the tests in the background has them ignore Ctrl-C, and with them every
# program that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Coverage measures child processes too, writes a file in each, and locks what its tracer shares.
not_under_coverage = pytest.mark.skipif(
    "COVERAGE_PROCESS_CONFIG" in os.environ,
    reason="coverage writes files and takes locks of its own",
)
# What needs Linux: devices such as /dev/full, process groups, limits of the shell, GNU make.
linux_only = pytest.mark.skipif(sys.platform != "linux", reason="needs devices or signals of Linux")
# Whole files of tests that need Linux.
collect_ignore = (
    []
    if sys.platform == "linux"
    else ["fuzz", "test_documentation.py", "test_faults.py", "test_sweeps.py"]
)
DATA = Path(__file__).parent / "data"
# s: only a program that does not end reaches this.
LIMIT = 300
# Share of the pixels of a golden picture that another machine's rounding may change.
SHARE = 0.002


def pytest_configure(config):
    """Let all test processes share files, and take fewer examples for `make test`."""
    if sharing.FOLDER not in os.environ:
        folder = tempfile.TemporaryDirectory(prefix="pymunk-dragon-tests-")
        config.add_cleanup(folder.cleanup)
        os.environ[sharing.FOLDER] = folder.name
    if config.option.markexpr == "not thorough" and not config.getoption("--hypothesis-profile"):
        hypothesis.settings.load_profile("quick")


def examples(count):
    """Settings for `count` examples where a test of hypothesis usually has 100."""
    return hypothesis.settings(max_examples=count * hypothesis.settings.default.max_examples // 100)


def pytest_addoption(parser):
    """Add the flag that writes golden pictures."""
    about = "write tests/data/*/*.png; look at them afterwards"
    parser.addoption("--regenerate-golden", action="store_true", help=about)


@pytest.fixture
def golden(request):
    """Comparison with tests/data/<name>.png, as in `golden(image, "debug_draw/cradle")`.

    A full path does as well as a name. `share` is the share of pixels that may differ.
    """

    def compare(image, name, share=SHARE):
        path = DATA / f"{name}.png"
        if request.config.getoption("--regenerate-golden"):
            path.parent.mkdir(parents=True, exist_ok=True)
            image.save(path, optimize=True)
        with Image.open(path) as expected:
            assert (image.mode, image.size) == (expected.mode, expected.size)
            found = share_off(image, expected)
        assert found <= share, (
            f"{found:.2%} of the pixels are not those of {path}; see pytest --regenerate-golden"
        )

    return compare


@pytest.fixture(scope="session")
def seed_march():
    """The march of the paper."""
    return March()


@pytest.fixture(scope="session")
def late_run():
    """The paper's dragon in the engine, from 400 s past both near misses to its first contact."""
    return shared_run("late", lambda: simulate(March(), start=400.0))


@pytest.fixture(scope="session")
def small_run():
    """16 benches as the engine plays them past their first contacts, which are only reported."""
    march = March(Dragon(benches=16), turns=8)
    return shared_run("small", lambda: simulate(march, start=77.5, until=84.5, contacts="report"))


@pytest.fixture(scope="session")
def browser():
    """Chromium, started once for all the tests that need it."""
    with chromium() as started:
        yield started


@pytest.fixture
def call(capsys):
    """Call the program within this process: exit code, stdout, stderr."""

    def called(*arguments):
        code = status([str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return called


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def wait_until(process, state):
    """Wait until `state()` is true; the process must not end before."""
    end = time.monotonic() + LIMIT
    while not state():
        assert time.monotonic() < end
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.02)


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


@pytest.fixture
def terminal():
    """Call the program in a terminal: what the terminal shows, with exit code 0."""
    pty = pytest.importorskip("pty", reason="needs a terminal of Linux or macOS")

    def called(*arguments):
        mine, theirs = pty.openpty()
        command = [sys.executable, "-m", "pymunk_dragon", *map(str, arguments)]
        with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs) as process:
            os.close(theirs)
            shown = read_until(mine, None)
        os.close(mine)
        assert process.returncode == 0, shown
        return shown.decode().replace("\r\n", "\n")

    return called


# What no length, speed or count can be, whatever its range.
NO_NUMBERS = [
    float("nan"),
    float("inf"),
    float("-inf"),
    0,
    -1,
    10**400,
    "1",
    "",
    True,
    None,
    1 + 0j,
    [1.0],
    np.eye(30),
]


def assert_says(error, *words):
    """The message is one line that holds `words`."""
    message = str(error)
    assert message == " ".join(message.split())
    for word in words:
        assert word in message


def assert_one_line(err, *words):
    """`err` is one line of the program that holds `words`."""
    assert err[-1:] == "\n", err
    assert_says(Exception(err[:-1]), "pymunk-dragon: ", *words)


def refusal(call, *arguments, error=ParameterError, **settings):
    """The error with which a call is refused; its message is one line."""
    try:
        call(*arguments, **settings)
    except error as refused:
        assert_says(refused)
        return refused
    return pytest.fail(f"accepted: {arguments} {settings}")
