"""Quantities and executors for the tests of sweeps. Worker processes import the quantities by their names."""

from __future__ import annotations

import contextlib
import math
import os
import random
import threading
import time
from concurrent.futures import Executor, Future
from enum import IntEnum
from fractions import Fraction

import numpy as np

from pymunk_dragon.model.march import March

# A dragon that is quickly made; as flags and as values.
FLAGS = ("--benches", "4", "--turns", "5")
SMALL = {"benches": 4, "turns": 5}


def total(march: March, *, x: float = 0.0, y: float = 0.0, n: int = 0):
    return {"total": x + y + n, "benches_of_march": march.dragon.benches}


def logged(march: March, *, x: float = 0.0, pause: float = 0.0, log: str = ""):
    """A square, after a line was appended to a file."""
    with open(log or os.environ["SWEEP_LOG"], "a") as file:
        file.write(f"{x}\n")
    time.sleep(pause)
    return {"square": x * x, "side": "left" if x < 4 else "right"}


# Regions with a known boundary.


def below_diagonal(march: March, *, x: float, y: float):
    return {"status": "below" if y < x + 0.1 else "above"}


def in_circle(march: March, *, x: float, y: float):
    return {"distance": math.hypot(x, y), "status": "in" if math.hypot(x, y) < 0.7 else "out"}


def in_ball(march: March, *, x: float, y: float, z: float):
    return {"status": "in" if math.hypot(x, y, z) < 0.7 else "out"}


def beyond(march: March, *, x: float):
    return {"status": "beyond" if x > math.sqrt(2) else "before"}


def many(march: March, *, n: int, x: float = 0.0):
    return {"status": "many" if n + x > 37 else "few"}


# Results of any kind.


class Colour(IntEnum):
    RED = 1


class SilentError(Exception):
    def __str__(self):
        raise RuntimeError


class Stop(BaseException):
    pass


VALUES = {
    "whole": 7,
    "float": 0.1,
    "negative zero": -0.0,
    "infinite": float("-inf"),
    "text": "two words",
    "quotes and commas": 'a,"b"',
    "lines": "a\nb\rc",
    "surrogate": "\udc80",
    "letters": "Größe 龙",
    "NumPy whole": np.int64(3),
    "NumPy float": np.float32(1.5),
    "NumPy bool": np.bool_(True),
    "NumPy text": np.str_("text"),
    "enumerated": Colour.RED,
    "bool": False,
    "largest": 2**63 - 1,
}
UNFIT = {
    "fraction": {"v": Fraction(1, 2)},
    "list": {"v": [1.0]},
    "array": {"v": np.ones(1)},
    "complex": {"v": 1j},
    "65 bits": {"v": 2**63},
    "5000 digits": {"v": 10**5000},
    "axis": {"k": 1},
    "error": {"error": 1},
    "number": 3,
    "nothing": None,
}
RAISED = (ValueError("two\nlines\x1b[1m"), SilentError(), Stop("now"), SystemExit(3), GeneratorExit(), MemoryError())


def value(march: March, *, k: int):
    return {"v": list(VALUES.values())[k]}


def unfit(march: March, *, k: int):
    return list(UNFIT.values())[k] if k < len(UNFIT) else {"v": 1}


def raising(march: March, *, k: int):
    if k < len(RAISED):
        raise RAISED[k]
    return {"v": 1}


def columns_that_differ(march: March, *, k: int):
    return {"even": k} if k % 2 == 0 else {"odd": k}


def undefined(march: March, *, k: int):
    return {"v": [1.5, None, float("nan")][k]}


def mixed(march: March, *, k: int):
    return {"v": [2**62 + 1, 0.5, None][k], "w": [1, "text", True][k]}


# `Pointer` is defined nowhere, like a type that is imported for type checkers only.
def annotated(march: March, *, gain: float = 1, points: Pointer = 0.5, count: int | None = None, wide: float | int = 1):  # noqa: F821
    return {"gained": gain + points + wide}


def printing(march: March, *, k: int = 0):
    print("printed by the quantity", flush=True)
    os.system("echo printed by a program")
    return {"v": k}


# Points that never end, or end their worker.


def sleeping(march: March, *, x: float, s: float = 600.0):
    if x == 3:
        time.sleep(s)
    return {"v": x}


def spinning(march: March, *, x: float):
    while x == 3:
        pass
    return {"v": x}


def ignoring(march: March, *, x: float):
    while x == 3:
        with contextlib.suppress(Exception):
            time.sleep(0.01)
    return {"v": x}


def stubborn(march: March, *, x: float):
    while x == 3:
        with contextlib.suppress(BaseException):
            time.sleep(0.01)
    return {"v": x}


def ending(march: March, *, x: float):
    if x == 3:
        os._exit(1)
    time.sleep(0.01)
    return {"v": x}


def slow_at_the_end(march: March, *, x: float, pause: float = 0.03):
    if x >= 40:
        time.sleep(pause)
    return {"v": x}


class Immediate(Executor):
    """Evaluates a function when it is submitted, and stops at a number of points like a sweep that is interrupted."""

    _max_workers = 1

    def __init__(self, points: float = math.inf) -> None:
        self._left = points
        self.sizes: list[int] = []

    def submit(self, function, /, *arguments):
        self.sizes.append(len(arguments[1]))
        self._left -= self.sizes[-1]
        if self._left < 0:
            raise KeyboardInterrupt
        future: Future = Future()
        future.set_result(function(*arguments))
        return future


class Shuffled(Executor):
    """Evaluates functions in a random order, one at a time."""

    _max_workers = 3

    def __init__(self, seed: int = 1) -> None:
        self._random = random.Random(seed)
        self._waiting: list[tuple] = []
        self._condition = threading.Condition()
        self._ended = False
        self.most_waiting = 0
        self.order: list[tuple[float, ...]] = []
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def submit(self, function, /, *arguments):
        future: Future = Future()
        with self._condition:
            self._waiting.append((future, function, arguments))
            self.most_waiting = max(self.most_waiting, len(self._waiting))
            self._condition.notify()
        return future

    def _work(self):
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._waiting or self._ended)
                if not self._waiting:
                    return
            # Until others have arrived.
            time.sleep(0.002)
            with self._condition:
                future, function, arguments = self._waiting.pop(self._random.randrange(len(self._waiting)))
            self.order += arguments[1]
            future.set_result(function(*arguments))

    def shutdown(self, wait=True, *, cancel_futures=False):
        with self._condition:
            self._ended = True
            self._condition.notify()
        self._thread.join()
