"""Evaluates batches of points, in a worker or anywhere else."""

from __future__ import annotations

import ctypes
import hashlib
import signal
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from types import FrameType
from typing import Any

import numpy as np

from pymunk_dragon.errors import DragonError, one_line
from pymunk_dragon.sweeps.axes import Point
from pymunk_dragon.sweeps.quantities import Quantity, quantity_of

# s. An exception that ends a point is raised again after this time, because code called from C may drop it.
REPEAT = 0.1
# s after which a batch ends early, if its points take longer than those before: its outcomes would wait for it.
LONGEST_BATCH = 10.0
# Characters of an error message in a table.
MAX_MESSAGE = 300
# Whole numbers in a Parquet file are not larger, nor further below 0.
MAX_WHOLE = 2**63 - 1
# Packages whose code determines the values of quantities.
DETERMINING = ("model", "collision", "physics", "studies", "sweeps")
# Values of one point by name, or None and the reason.
Outcome = tuple[Mapping[str, Any] | None, str | None]


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is the same for all points of a sweep: `base` has the values of parameters that are not axes."""

    version: str
    quantity: str
    base: Mapping[str, Any]
    names: tuple[str, ...]
    timeout: float | None


@cache
def program_version() -> str:
    """Version of this program, and a digest of the code that determines the values of quantities."""
    root = Path(__file__).parents[1]
    files = sorted(file for package in DETERMINING for file in (root / package).rglob("*.py"))
    code = b"".join(file.read_bytes() for file in files)
    return f"{version('pymunk-dragon')}+{hashlib.sha256(code).hexdigest()[:8]}"


class _TimeIsUp(BaseException):
    """Ends the evaluation of a point; not an `Exception`, which the evaluated code may handle."""


def evaluate(task: Task, points: Sequence[Point]) -> tuple[list[Outcome], float]:
    """The outcomes at the points, or at the first ones of them if they take long, and the time that all took, s.

    Raises
    ------
    DragonError
        If the quantity cannot be imported here, or the program here has another version.
    """
    if task.version != program_version():
        raise DragonError(f"a worker has version {program_version()} of the program, but the sweep {task.version}")
    quantity = quantity_of(task.quantity)
    begin = perf_counter()
    outcomes = []
    for point in points:
        outcomes.append(_evaluated(task, quantity, point))
        if (seconds := perf_counter() - begin) > LONGEST_BATCH:
            break
    return outcomes, seconds


def _evaluated(task: Task, quantity: Quantity, point: Point) -> Outcome:
    """The outcome at one point."""
    axes = dict(zip(task.names, point, strict=True))
    try:
        with time_limit(task.timeout):
            found = quantity.evaluate({**task.base, **axes})
        if not isinstance(found, Mapping):
            raise DragonError(f"the quantity returned a {type(found).__name__}, not values by name")
        return {str(name): _scalar(name, value, axes) for name, value in found.items()}, None
    except _TimeIsUp:
        return None, too_long(task.timeout)
    except DragonError as error:
        return None, str(error)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return None, _reason(error)


def _reason(error: BaseException) -> str:
    """An exception of any class in one line."""
    try:
        return one_line(f"{type(error).__name__}: {error}")[:MAX_MESSAGE]
    except Exception:  # Of its own text.
        return type(error).__name__


def too_long(timeout: float | None) -> str:
    """Reason of a point that exceeded the time limit."""
    return f"takes longer than the time limit of {timeout:g} s"


def _scalar(name: str, value: object, axes: Mapping[str, float]) -> float | str | None:
    """A value of a quantity as a plain number, a text or None."""
    if name in axes or name == "error":
        raise DragonError(f"the quantity returned a value {name}, which is another column of the table")
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, str):
        # Files of UTF-8 have no surrogates.
        return plain.encode(errors="backslashreplace").decode()
    if isinstance(plain, int) and abs(plain) > MAX_WHOLE:
        raise DragonError(f"the quantity returned a whole number of more than 64 bits as {name}")
    if plain is None or isinstance(plain, int | float):
        return plain
    raise DragonError(f"the quantity returned a {type(value).__name__} as {name}, not a number")


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise an exception in the block after this time: in the main thread by a signal, elsewhere by the interpreter.

    A signal also ends waiting for the system, as `time.sleep`; the interpreter raises exceptions only between two
    instructions of Python.
    """
    if seconds is None:
        yield
    elif threading.current_thread() is threading.main_thread() and hasattr(signal, "setitimer"):
        with _limit_by_signal(seconds):
            yield
    else:
        with _limit_by_interpreter(seconds):
            yield


@contextmanager
def _limit_by_signal(seconds: float) -> Iterator[None]:
    active = True

    def expire(number: int, frame: FrameType | None) -> None:
        if active:
            raise _TimeIsUp

    before = signal.signal(signal.SIGALRM, expire)
    try:
        try:
            signal.setitimer(signal.ITIMER_REAL, seconds, REPEAT)
            yield
        finally:
            active = False
    finally:
        # Again, if the exception came before it could be set there.
        active = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def _limit_by_interpreter(seconds: float) -> Iterator[None]:
    thread = ctypes.c_ulong(threading.get_ident())
    finished, lock = threading.Event(), threading.Lock()

    def expire() -> None:
        wait = seconds
        while not finished.wait(wait):
            with lock:
                if not finished.is_set():
                    ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(_TimeIsUp))
            wait = REPEAT

    def finish() -> None:
        with lock:
            finished.set()
            # An exception that has not been raised yet is dropped.
            ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, None)

    try:
        try:
            threading.Thread(target=expire, daemon=True).start()
            yield
        finally:
            finish()
    finally:
        # Again, if the exception came before it had finished.
        finish()
