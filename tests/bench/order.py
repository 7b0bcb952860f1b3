"""Order of the engine where only the head pulls: `python tests/bench/order.py`.

Errors of the first contact and of the holes of the reference march without a guide, for both values
of `EngineSettings.order`, over substeps and iterations, and the processor time of a run in turns.
The exact contact comes from an integration of the exact dynamics in minimal coordinates. The exact
holes are extrapolated from two runs with substeps of 2 and 1 ms, whose contact, extrapolated in the
same way, is printed beside the exact one.
"""

from __future__ import annotations

import time
from statistics import median

import measure
import numpy as np
from measure import sized

from pymunk_dragon import March, Run, simulate
from pymunk_dragon._arrays import Array

# s: first contact of the pulled chain, between benches 1 and 28, in the exact dynamics.
EXACT_CONTACT = 10.892178138

# s: end of the runs, which stop at the contact, and time between two frames.
UNTIL, INTERVAL = sized((11.2, 0.1), (0.4, 0.1))

# Substeps, s, and iterations of the table.
SUBSTEPS = sized((0.05, 0.04, 0.025, 0.02, 0.01, 0.005), (0.02,))
ITERATIONS = sized((5, 10, 15, 20, 30, 100), (10,))

# Substeps, s, and iterations of the runs from which the exact holes are extrapolated.
FINE = sized(((0.002, 100), (0.001, 150)), ((0.02, 10), (0.01, 10)))

# Runs of which the median time is taken.
REPEATS = sized(3, 1)


def play(order: int, substep: float, iterations: int) -> Run:
    """Run of the reference march without a guide, to its first contact."""
    return simulate(
        March(),
        guide="none",
        until=UNTIL,
        order=order,
        substep=substep,
        iterations=iterations,
        frame_interval=INTERVAL,
    )


def contact_error(run: Run) -> float:
    """Error of the time of the first contact, s."""
    return run.first_contact.time - EXACT_CONTACT if run.first_contact else np.nan


def holes(run: Run) -> tuple[Array, Array]:
    """Numbers (F,) of the times that are multiples of the interval, and the holes then, m."""
    numbers = np.round(run.times / INTERVAL)
    regular = np.abs(run.times - numbers * INTERVAL) < 1e-9
    front, rear = run.march.dragon.holes(run.poses[regular])
    return numbers[regular], np.stack([front, rear], axis=-2)


def furthest(run: Run, exact: tuple[Array, Array]) -> float:
    """Largest distance of a hole from its exact position in a frame, m."""
    numbers, found = holes(run)
    _, ours, theirs = np.intersect1d(numbers, exact[0], return_indices=True)
    return float(np.linalg.norm(found[ours] - exact[1][theirs], axis=-1).max())


def exact_holes() -> tuple[Array, Array]:
    """Numbers of the times, and the holes then, m, extrapolated from two runs of second order."""
    coarse, fine = (play(2, *settings) for settings in FINE)
    numbers, positions = holes(fine)
    late = (4 * contact_error(fine) - contact_error(coarse)) / 3
    print(f"extrapolated contact: {1e6 * late:+.3f} us from the exact one\n")
    return numbers, (4 * positions - holes(coarse)[1]) / 3


def pulled() -> None:
    """Error of the contact, worst hole and processor time where only the head pulls."""
    exact = exact_holes()
    columns = " | ".join(f"{iterations} iterations" for iterations in ITERATIONS)
    print(f"| order | substep, ms | {columns} |")
    print("| --- " * (2 + len(ITERATIONS)) + "|")
    for substep in SUBSTEPS:
        seconds: dict[tuple[int, int], list[float]] = {}
        runs: dict[tuple[int, int], Run] = {}
        for _ in range(REPEATS):
            for iterations in ITERATIONS:
                for order in (1, 2):
                    begin = time.process_time()
                    runs[order, iterations] = play(order, substep, iterations)
                    taken = time.process_time() - begin
                    seconds.setdefault((order, iterations), []).append(taken)

        for order in (1, 2):
            row = [f"{order}", f"{1e3 * substep:g}"]
            for iterations in ITERATIONS:
                run = runs[order, iterations]
                late = 1e3 * contact_error(run)
                off = 1e3 * furthest(run, exact)
                taken = median(seconds[order, iterations])
                row.append(f"{late:+.3f} ms, {off:.3f} mm, {taken:.3f} s")
            print(f"| {' | '.join(row)} |", flush=True)


BENCHMARKS = {"pulled": pulled}

if __name__ == "__main__":
    measure.run(BENCHMARKS)
