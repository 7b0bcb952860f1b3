"""What several test files share."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import hypothesis
import numpy as np
import pytest
import sharing
from browser import chromium
from gallery import share_off
from PIL import Image
from playwright.sync_api import Browser
from sharing import shared_run

from pymunk_dragon import Dragon, March, ParameterError, Run, simulate
from pymunk_dragon.cli import main

# Examples share the machine with whatever else runs there, so none has a time limit of its own. They are the same every
# time, so that a failure comes from a change; `--hypothesis-profile=explore` throws the dice.
# A failure is not explained: that traces every line. A worker on Python 3.11 once stood still, probably in it.
PHASES = set(hypothesis.Phase) - {hypothesis.Phase.explain}
hypothesis.settings.register_profile("explore", deadline=None, print_blob=True)
hypothesis.settings.register_profile("house", deadline=None, derandomize=True, phases=PHASES)
hypothesis.settings.register_profile("quick", deadline=None, derandomize=True, phases=PHASES, max_examples=15)
hypothesis.settings.load_profile("house")

# A shell that starts the tests in the background has them ignore Ctrl-C, and with them every program that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Coverage measures child processes too, writes a file in each, and locks what its tracer shares.
not_under_coverage = pytest.mark.skipif(
    "COVERAGE_PROCESS_CONFIG" in os.environ, reason="coverage writes files and takes locks of its own"
)
DATA = Path(__file__).parent / "data"
# Share of the pixels of a golden picture that another machine's rounding may change.
SHARE = 0.002


def pytest_configure(config: pytest.Config) -> None:
    """Let all test processes share files, and take a seventh of the examples for `make test`."""
    if sharing.FOLDER not in os.environ:
        folder = tempfile.TemporaryDirectory(prefix="pymunk-dragon-tests-")
        config.add_cleanup(folder.cleanup)
        os.environ[sharing.FOLDER] = folder.name
    if config.option.markexpr == "not thorough" and not config.getoption("--hypothesis-profile"):
        hypothesis.settings.load_profile("quick")


def examples(count: int) -> hypothesis.settings:
    """Settings for `count` examples where a test of hypothesis usually has 100."""
    return hypothesis.settings(max_examples=count * hypothesis.settings.default.max_examples // 100)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the flag that writes golden pictures."""
    parser.addoption(
        "--regenerate-golden", action="store_true", help="write tests/data/*/*.png; look at them afterwards"
    )


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[..., None]:
    """A function that compares a picture with tests/data/<name>.png, as in `golden(image, "debug_draw/cradle")`.

    A full path does as well as a name. `share` is the share of pixels that may differ.
    """

    def compare(image: Image.Image, name: str, share: float = SHARE) -> None:
        path = DATA / f"{name}.png"
        if request.config.getoption("--regenerate-golden"):
            path.parent.mkdir(parents=True, exist_ok=True)
            image.save(path, optimize=True)
        with Image.open(path) as expected:
            assert (image.mode, image.size) == (expected.mode, expected.size)
            found = share_off(image, expected)
        assert found <= share, f"{found:.2%} of the pixels are not those of {path}; see pytest --regenerate-golden"

    return compare


@pytest.fixture(scope="session")
def seed_march() -> March:
    """The march of the paper."""
    return March()


@pytest.fixture(scope="session")
def late_run() -> Run:
    """The paper's dragon as the engine plays it from 400 s, before both near misses, to its first contact."""
    return shared_run("late", lambda: simulate(March(), start=400.0))


@pytest.fixture(scope="session")
def small_run() -> Run:
    """16 benches as the engine plays them past their first contacts, which are only reported."""
    march = March(Dragon(benches=16), turns=8)
    return shared_run("small", lambda: simulate(march, start=77.5, until=84.5, contacts="report"))


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium, started once for all the tests that need it."""
    with chromium() as started:
        yield started


@pytest.fixture
def call(capsys):
    """Call the program within this process: exit code, stdout, stderr."""

    def called(*arguments):
        with pytest.raises(SystemExit) as stopped:
            main([str(argument) for argument in arguments])
        return stopped.value.code, *capsys.readouterr()

    return called


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def read_until(stream, pattern):
    """What comes from a terminal until it matches `pattern`, or until its other side is closed."""
    seen = b""
    while not (pattern and re.search(pattern, seen)):
        assert select.select([stream], [], [], 300)[0]
        try:
            seen += os.read(stream, 4096)
        except OSError:  # Linux raises one when the other side is closed.
            break
    return seen


@pytest.fixture
def terminal():
    """Call the program in a terminal: what the terminal shows, with exit code 0."""

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
NO_NUMBERS = [float("nan"), float("inf"), float("-inf"), 0, -1, 10**400, "1", "", True, None, 1 + 0j, [1.0], np.eye(30)]


def assert_says(error: Exception, *words: str) -> None:
    """The message is one line of a bearable length and holds `words`."""
    message = str(error)
    assert message == " ".join(message.split())
    assert len(message) < 250
    for word in words:
        assert word in message


def refusal(call, *arguments, error=ParameterError, **settings):
    """The error with which a call is refused; its message is one line."""
    try:
        call(*arguments, **settings)
    except error as refused:
        assert_says(refused)
        return refused
    return pytest.fail(f"accepted: {arguments} {settings}")
