"""Quantities for the tests of sweeps. Worker processes import them by their names."""

from __future__ import annotations

import os
from fractions import Fraction
from threading import Event

import numpy as np

from pymunk_dragon import March

FLAGS = ("--benches", "4", "--turns", "5")
SMALL = {"benches": 4, "turns": 5}


def total(march: March, *, x: float = 0.0, y: float = 0.0, z: float = 0.0, n: int = 0):
    return {"total": x + y + z + n, "benches_of_march": march.dragon.benches}


def logged(march: March, *, x: float, log: str = ""):
    """A square, from a line in a file on; from x = 4 on, once there is a file .go."""
    log = log or os.environ["SWEEP_LOG"]
    with open(log, "a") as file:
        file.write(f"{x}\n")
    while x >= 4 and not os.path.exists(f"{log}.go"):
        Event().wait(0.02)
    return {"square": x * x, "side": "left" if x < 3 else "right"}


def sides(march: March, *, x: float = 0.0, y: float = 0.0):
    """Two sides."""
    if x > 0.5:
        return {"gap": None, "bench_a": None, "bench_b": None, "status": "clear"}
    return {"gap": x * y, "bench_a": 0, "bench_b": 8 if x * y < 0.5 else 9, "status": "contact"}


def banded(march: March, *, x: float = 0.0, y: float = 0.0):
    """A number whose kind is another one in a narrow band."""
    return {"sum": x + y, "kind": int(x + y > 1.03) + int(x + y > 1.05)}


class UnpicklableError(BaseException):
    def __init__(self, first, second):
        super().__init__(f"{first} and {second}")


VALUES = [
    7,
    0.1,
    -0.0,
    float("-inf"),
    'a,"b"',
    "龙\n\ud800",
    np.int64(3),
    np.float32(1.5),
    np.bool_(True),
    2**62,
    None,
]
# What no cell or no column can hold, or what is no result.
UNFIT = [
    *({"v": value} for value in (Fraction(1, 2), [1.0], np.ones(1), 1j, 2**63, 10**5000)),
    *({name: 1} for name in ("k", "error", "", "\ud800", "two\nlines", 5)),
    *(3, None),
]
RAISED = [ValueError("two\nlines\x1b[1m\ud800"), UnpicklableError("this", "that"), SystemExit(3)]


def value(march: March, *, k: int):
    return {"v": VALUES[k]} if k else {"w": 7}


def raising(march: March, *, k: int):
    if k < len(RAISED):
        raise RAISED[k]
    return UNFIT[k - len(RAISED)]


def printing(march: March, *, x: float = 0.0):
    print("printed by the quantity", flush=True)
    os.system("echo printed by a program")
    return {"v": x, "sizes": f"{march.curve.pitch} {march.dragon.head_spacing}"}
