"""Runs command lines in a worker process under limits, and tells what is wrong with what they did."""

from __future__ import annotations

import faulthandler
import hashlib
import json
import multiprocessing
import os
import re
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path

__all__ = ["Case", "Outcome", "Worker", "faults"]

# s of processor time that a case may take.
MAX_SECONDS = 20.0
# s after which a case is ended: the machine may be busy with other work.
PATIENCE = 60.0
# Module and function that take a command line.
PROGRAM = ("pymunk_dragon.cli", "main")
# Bytes of memory that a case may take, and bytes of address space after which allocations fail.
MAX_MEMORY, MAX_ADDRESSES = 1_500_000_000, 4_000_000_000
# Exit codes that DESIGN knows: done, failed while running, bad input, interrupted.
CODES = (0, 1, 2, 130)
# Files of a case are only hashed; a file that was not there before is no more than a name.
Files = Mapping[str, bytes]


@dataclass(frozen=True)
class Case:
    """A command line, and the files that lie in its folder."""

    arguments: tuple[str, ...]
    files: Files = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What a case did."""

    code: object
    out: bytes
    err: str
    # What escaped from the program, as Python prints it; why the worker ended, if it did.
    escaped: str
    seconds: float
    memory: int
    # Digest of each file afterwards.
    files: Mapping[str, str]


class Worker:
    """A process that runs cases, one after the other, and is started again after one that ended it."""

    def __init__(self, program: tuple[str, str] = PROGRAM, patience: float = PATIENCE) -> None:
        self._task = program, patience
        self._process: multiprocessing.process.BaseProcess | None = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()

    def run(self, case: Case) -> Outcome:
        """Run a case in a folder of its own."""
        if self._process is None:
            self._start()
        with tempfile.TemporaryDirectory() as base:
            # Names such as "../x" stay within the temporary folder.
            folder = Path(base) / "one" / "two"
            folder.mkdir(parents=True)
            (folder / "folder").mkdir()
            for name, content in case.files.items():
                (folder / name).write_bytes(content)
            begin = time.monotonic()
            self._connection.send((case.arguments, str(folder)))
            try:
                found = self._connection.recv()
            except (EOFError, ConnectionResetError):
                escaped = f"the process ended: {Path(self._log.name).read_text(errors='replace')}"
                self._stop()
                found = (None, b"", "", escaped, time.monotonic() - begin, 0)
            return Outcome(*found, digests(Path(base), folder))

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._log = tempfile.NamedTemporaryFile(mode="w+", suffix=".log")  # noqa: SIM115  # closed by `_stop`
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._log.name, *self._task))
        self._process.start()
        theirs.close()

    def _stop(self) -> None:
        if self._process is not None:
            self._connection.close()
            self._process.kill()
            self._process.join()
            self._process = None
            self._log.close()


def digests(base: Path, folder: Path) -> dict[str, str]:
    """Digest of each file below `base`, by its name seen from `folder`; empty folders are left out."""
    found = {}
    for path in base.rglob("*"):
        if not path.is_dir():
            name = os.path.relpath(path, folder)
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "no file"
    return found


def faults(case: Case, outcome: Outcome) -> list[str]:
    """What is wrong with what a case did, one line each; the first words are the same for the same fault."""
    found = []
    if outcome.escaped:
        found.append(_place(outcome.escaped))
    elif outcome.code not in CODES:
        found.append(f"exit code {outcome.code!r}")
    elif outcome.code == 0 and outcome.err:
        found.append(f"done, but says on stderr: {outcome.err[:300]}")
    elif outcome.code != 0 and len(outcome.err.splitlines()) != 1:
        found.append(
            f"exit code {outcome.code} and {len(outcome.err.splitlines())} lines on stderr: {outcome.err[:300]}"
        )
    if not found and re.search("Traceback|Error:|Warning:", outcome.err):
        found.append(f"stderr is for the developer: {outcome.err[:300]}")
    if outcome.code == 2 and outcome.out:
        found.append("bad input, but something on stdout")
    # After -o it is the name of a file.
    wants_json = any(pair[1] == "--json" and pair[0] != "-o" for pair in pairwise(["", *case.arguments]))
    if outcome.code == 0 and wants_json and not {"-h", "--help", "--version"} & {*case.arguments}:
        try:
            if not isinstance(json.loads(outcome.out), dict):
                found.append("--json gave JSON that is no object")
        except ValueError:
            found.append("--json gave no JSON")
    if outcome.seconds > MAX_SECONDS:
        found.append(f"took {outcome.seconds:.0f} s")
    if outcome.memory > MAX_MEMORY:
        found.append(f"took {outcome.memory / 1e9:.1f} GB")
    return found + _file_faults(case, outcome)


def _file_faults(case: Case, outcome: Outcome) -> list[str]:
    """Files that were lost, changed or left behind."""
    before = {name: hashlib.sha256(content).hexdigest() for name, content in case.files.items()}
    lost = sorted(before.keys() - outcome.files.keys())
    touched = sorted(name for name, digest in outcome.files.items() if before.get(name) != digest)
    # A sweep writes its table even if points failed.
    if outcome.code == 0 or (outcome.code == 1 and "sweep" in case.arguments):
        # What was named to be written, or the folder that it was to be written to.
        named = "\n".join(case.arguments)
        touched = [name for name in touched if name not in named and os.path.dirname(name) not in (*case.arguments,)]
    found = [f"lost a file: {name}" for name in lost]
    return found + [f"{'changed' if name in before else 'left behind'} a file: {name}" for name in touched]


def _place(text: str) -> str:
    """The last place within the package in a traceback, and the error."""
    places = re.findall(r'File ".*?/(pymunk_dragon/[^"]*)", line (\d+),? in (\w+)', text)
    last = text.strip().splitlines()[-1][:300]
    return f"escaped from {':'.join(places[-1])}: {last}" if places else f"escaped: {text[-1500:]}"


# The worker's side


def _serve(connection: Connection, log: str, program: tuple[str, str], patience: float) -> None:
    """Run the cases that come in through `connection`, until it is closed."""
    with suppress(OSError, ValueError):  # Not every system can do that.
        resource.setrlimit(resource.RLIMIT_AS, (MAX_ADDRESSES, MAX_ADDRESSES))
    # Threads of a linear algebra library reserve gigabytes of addresses.
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    # What ends the process while a case runs goes to the log: the traceback of a hang, a library's last words.
    said = os.open(log, os.O_WRONLY | os.O_APPEND)
    main = getattr(import_module(program[0]), program[1])
    with open(log, "a") as hang:
        while True:
            try:
                arguments, folder = connection.recv()
            except EOFError:
                return
            faulthandler.dump_traceback_later(patience, exit=True, file=hang)
            faulthandler.enable(hang)
            connection.send(_run(main, arguments, folder, said))
            faulthandler.cancel_dump_traceback_later()


def _run(main: Callable[[list[str]], None], arguments: tuple[str, ...], folder: str, said: int) -> tuple[object, ...]:
    """Run one command line in `folder`; afterwards both outputs go to the log again."""
    os.chdir(folder)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        with (
            open(1, "w", encoding="utf-8", closefd=False) as sys.stdout,
            open(2, "w", encoding="utf-8", closefd=False, errors="backslashreplace") as sys.stderr,
            warnings.catch_warnings(),
        ):
            # As in a process of its own, which shows each of them; Python hides the deprecations of libraries.
            warnings.simplefilter("always")
            warnings.filterwarnings("ignore", category=DeprecationWarning)
            _reset_peak()
            begin = time.process_time()
            code, escaped = None, ""
            try:
                main(list(arguments))
            except SystemExit as stopped:
                code = stopped.code
            except BaseException:
                escaped = traceback.format_exc()
            seconds, memory = time.process_time() - begin, _peak()
        os.chdir("/")
        os.dup2(said, 1)
        os.dup2(said, 2)
        texts = []
        for output in (out, err):
            output.seek(0)
            texts.append(output.read())
    return code, texts[0], texts[1].decode(errors="replace"), escaped, seconds, memory


def _reset_peak() -> None:
    """Forget the largest memory so far, where the system can do that."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _peak() -> int:
    """Largest memory in bytes since `_reset_peak`."""
    try:
        return 1024 * int(re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[1])
    except OSError:
        return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
