"""The answers to the contest's five questions beside those of independent methods in 34 to 50 digits.

Prints a table for the docstring of `studies`: the question, both answers, the decimals that agree, and both times.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import mpmath as mp
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
import exact_curves
import oracle

from pymunk_dragon import Dragon, March, UTurn, first_contact
from pymunk_dragon.studies import max_speed, min_pitch

SIZES = {"width": "0.3", "overhang": "0.275", "head_spacing": "2.86", "body_spacing": "1.65", "pitch": "0.55"}
SHOWN = 12


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    begin = perf_counter()
    answer = work()
    return answer, perf_counter() - begin


def decimals(one: Any, other: Any) -> int:
    """How many decimals of two numbers agree, but for the last one's rounding."""
    off = abs(mp.mpf(one) - other)
    return int(-mp.log10(off)) if off else 16


def row(question: str, ours: tuple[Any, float], theirs: tuple[Any, float], method: str) -> None:
    (one, quick), (other, slow) = ours, theirs
    shown = f"{mp.nstr(mp.mpf(one), SHOWN + 1)} | {mp.nstr(other, SHOWN + 1)} | {decimals(one, other)}"
    print(f"| {question} | {shown} | {quick:.2f} | {method}, {slow:.1f} |", flush=True)


def last_handle() -> Any:
    points, _ = oracle.solve(
        300, benches=223, head_spacing=2.86, body_spacing=1.65, pitch=0.55, turns=16, speed=1, difference=False
    )
    return points[-1][0]


def smallest_pitch() -> Any:
    sizes = {name: mp.mpf(value) for name, value in SIZES.items()} | {"pitch": mp.mpf("0.45034")}
    return oracle.grazing((0, 19), "216.34", sizes)[1]


def largest_speed() -> Any:
    """The ratio at its top, by golden sections of the head's way; two thirds of the digits are lost to that."""
    path, spacings, tiny = exact_curves.u_turn(), Dragon().spacings[:3], mp.mpf("1e-12")

    def ratio(way: Any) -> Any:
        before, after = (exact_curves.walked_chain(path, way + sign * tiny, spacings)[-1] for sign in (-1, 1))
        return (after - before) / (2 * tiny)

    low, high, golden = mp.mpf("14.47"), mp.mpf("14.49"), (mp.sqrt(5) - 1) / 2
    for _ in range(32):
        one, other = high - golden * (high - low), low + golden * (high - low)
        low, high = (low, other) if ratio(one) > ratio(other) else (one, high)
    return 2 / ratio((low + high) / 2)


def main() -> None:
    print("| question | answer | independently | decimals that agree | s | method, s |")
    print("| --- | --- | --- | --- | --- | --- |")
    states, quick = timed(lambda: March().at(np.arange(301.0)))
    theirs = timed(last_handle)
    ours = float(states.positions[300, -1, 0]), quick
    row("1, x of handle 223 at 300 s, m", ours, theirs, "50 digits, one moment of our 301")
    sizes = {name: mp.mpf(value) for name, value in SIZES.items()}
    ours = timed(lambda: first_contact(March()).time)
    row("2, first contact, s", ours, timed(lambda: oracle.touching((0, 8), "412.47", sizes)), "the root in 50 digits")
    ours = timed(lambda: min_pitch().pitch)
    row("3, smallest pitch, m", ours, timed(smallest_pitch), "the grazing moment in 50 digits")
    with mp.workdps(exact_curves.DIGITS):
        ours = timed(lambda: UTurn().length)
        theirs = timed(lambda: exact_curves.s_turn(mp.mpf("1.7"), mp.mpf("4.5"), mp.mpf(2))[-1])
        row("4, length of the turn, m", ours, theirs, "tangency solved in 34 digits")
        row(
            "5, largest speed, m/s",
            timed(lambda: max_speed().speed),
            timed(largest_speed),
            "golden sections in 34 digits",
        )


if __name__ == "__main__":
    main()
