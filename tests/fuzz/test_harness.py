"""The harness finds each kind of fault in a program that has it, and none in one that has none."""

from __future__ import annotations

import faulty
import pytest
from harness import Case, Worker, faults

FILES = {"old.json": b"old", "s.toml": b"benches = 4"}


@pytest.fixture(scope="module")
def worker():
    with Worker((faulty.__name__, "main"), patience=3.0) as one:
        yield one


def found(worker, *arguments):
    case = Case(arguments, FILES)
    return faults(case, worker.run(case))


@pytest.mark.parametrize("behaviour", ["good", "bad input", "good --json"])
def test_program_without_a_fault_has_none(worker, behaviour):
    assert found(worker, *behaviour.split(" --json"), *["--json"] * behaviour.count("--json"), "-o", "old.json") == []


@pytest.mark.parametrize(
    ("behaviour", "words"),
    [
        ("raise", "escaped: Traceback"),
        ("code 3", "exit code 3"),
        ("two lines", "exit code 2 and 2 lines on stderr"),
        ("silent", "exit code 2 and 0 lines on stderr"),
        ("warn", "done, but says on stderr"),
        ("traceback", "stderr is for the developer"),
        ("print", "bad input, but something on stdout"),
        ("no json --json", "--json gave no JSON"),
        ("draft", "left behind a file: .draft"),
        ("good draft", "left behind a file: .draft"),
        ("up", "left behind a file: ../new.json"),
        ("change", "changed a file: old.json"),
        ("change another", "changed a file: s.toml"),
        ("lose", "lost a file: old.json"),
        ("exit", "escaped: the process ended"),
        ("hang", "escaped: the process ended"),
    ],
)
def test_fault_is_found(worker, behaviour, words):
    arguments = [behaviour.removesuffix(" --json"), *["--json"] * behaviour.endswith("--json"), "-o", "old.json"]
    [one] = found(worker, *arguments)
    assert one.startswith(words)
    # The next case has a fresh process, if it needs one.
    assert found(worker, "good", "-o", "old.json") == []


@pytest.mark.parametrize(
    ("behaviour", "limit", "words"), [("work", "SECONDS", "took 0 s"), ("memory", "MEMORY", "took 0.3")]
)
def test_large_work_is_found(worker, monkeypatch, behaviour, limit, words):
    assert found(worker, behaviour) == []
    monkeypatch.setattr(f"harness.MAX_{limit}", {"SECONDS": 0.05, "MEMORY": 250_000_000}[limit])
    [one] = found(worker, behaviour)
    assert one.startswith(words)
