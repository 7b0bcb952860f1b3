"""Quantities and executors for the tests of sweeps. Worker processes import the quantities by their names."""

from __future__ import annotations

import math
import os
import random
import threading
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from fractions import Fraction

import numpy as np

from pymunk_dragon.model.march import March

# s: only a broken program reaches this.
LIMIT = 300
# A dragon that is quickly made; as flags and as values.
FLAGS = ("--benches", "4", "--turns", "5")
SMALL = {"benches": 4, "turns": 5}


def total(march: March, *, x: float = 0.0, y: float = 0.0, n: int = 0):
    return {"total": x + y + n, "benches_of_march": march.dragon.benches}


def logged(march: March, *, x: float = 0.0, pause: float = 0.0, log: str = ""):
    """A square, after a line was appended to a file, and a pause, which for x from 20 on ends only by a file .hurry."""
    log = log or os.environ["SWEEP_LOG"]
    with open(log, "a") as file:
        file.write(f"{x}\n")
    paused = 0.0
    while not os.path.exists(f"{log}.hurry") and (paused < pause or x >= 20):
        time.sleep(0.05)
        paused += 0.05
    return {"square": x * x, "side": "left" if x < 4 else "right"}


def in_circle(march: March, *, x: float, y: float):
    return {"distance": math.hypot(x, y), "status": "in" if math.hypot(x, y) < 0.7 else "out"}


class Stop(BaseException):
    pass


VALUES = [
    7,
    0.1,
    -0.0,
    float("-inf"),
    'a,"b"\nc\rd',
    "Größe 龙",
    np.int64(3),
    np.float32(1.5),
    np.bool_(True),
    2**63 - 1,
]
# What no cell can hold, or what is no result.
UNFIT = [
    {"v": Fraction(1, 2)},
    {"v": [1.0]},
    {"v": np.ones(1)},
    {"v": 1j},
    {"v": 2**63},
    {"k": 1},
    {"error": 1},
    3,
    None,
]
RAISED = [ValueError("two\nlines\x1b[1m"), Stop("now"), SystemExit(3), MemoryError()]


def value(march: March, *, k: int):
    return {"v": VALUES[k]}


def unfit(march: March, *, k: int):
    return [*UNFIT, {"v": 1}][k]


def raising(march: March, *, k: int):
    if k < len(RAISED):
        raise RAISED[k]
    return {"v": 1}


def mixed(march: March, *, k: int):
    return {"v": [1.5, None, float("nan")][k], "w": [1, "text", True][k]} | ({"odd": k} if k % 2 else {})


# `Pointer` is defined nowhere, like a type that is imported for type checkers only: F821 is silenced for it.
def annotated(march: March, *, gain: float = 1, points: Pointer = 0.5, count: int | None = None, wide: float | int = 1):  # noqa: F821
    return {"gained": gain + points + wide}


def printing(march: March, *, x: float = 0.0, n: int = 0):
    print("printed by the quantity", flush=True)
    os.system("echo printed by a program")
    return {"v": x + n}


def ending(march: March, *, x: float):
    if x == 3:
        os._exit(1)
    return {"v": x}


class Immediate(Executor):
    """Evaluates a function when it is submitted, and stops at a number of points like a sweep that is interrupted."""

    _max_workers = 1

    def __init__(self, points: float = math.inf) -> None:
        self._left = points

    def submit(self, function, /, *arguments):
        self._left -= len(arguments[1])
        if self._left < 0:
            raise KeyboardInterrupt
        future: Future = Future()
        future.set_result(function(*arguments))
        return future


class Shuffled(Executor):
    """Completes functions in an order other than that of their submission, when `count` of them are submitted."""

    _max_workers = 3

    def __init__(self, count: int) -> None:
        self._dice, self._waiting, self.order = random.Random(1), [], []
        self._left, self._arrived = count, threading.Condition()
        self._thread = ThreadPoolExecutor(1)

    def submit(self, function, /, *arguments):
        future: Future = Future()
        with self._arrived:
            self._waiting.append((future, function, arguments))
            self._left -= 1
            self._arrived.notify()
        self._thread.submit(self._complete)
        return future

    def _complete(self):
        with self._arrived:
            assert self._arrived.wait_for(lambda: len(self._waiting) >= 2 or self._left == 0, LIMIT)
            future, function, arguments = self._waiting.pop(self._dice.randrange(len(self._waiting)))
        self.order += arguments[1]
        future.set_result(function(*arguments))

    def shutdown(self, wait=True, *, cancel_futures=False):
        self._thread.shutdown()
