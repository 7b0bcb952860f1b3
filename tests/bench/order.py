"""Order of the engine where only the head pulls: `python tests/bench/order.py [NAME ...]`.

The method of order 2 is Pymunk's own step, which is order 1, with mid torque and with poses by the
Adams-Moulton method. `pull` has the exact motion. Where it does not apply, because settings change
in the run, dancers let benches go, or contacts push, that of fine steps of order 1 is extrapolated.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from statistics import median
from typing import Any, NamedTuple
from unittest import mock

import measure
import numpy as np
from measure import sized

from pymunk_dragon import (
    Dragon,
    EngineSettings,
    March,
    Run,
    SpeedTable,
    UTurn,
    World,
    pull,
    simulate,
)
from pymunk_dragon._arrays import Array
from pymunk_dragon.physics import Rails, world

# s: end of the runs, which stop at the contact, and time between two frames.
UNTIL, INTERVAL = sized((11.2, 0.1), (0.4, 0.1))

# Substeps, s, and iterations of the table.
SUBSTEPS = sized((0.05, 0.04, 0.025, 0.02, 0.01, 0.005), (0.02,))
ITERATIONS = sized((5, 10, 15, 20, 30, 100), (10,))

# Runs of which the median time is taken.
REPEATS = sized(3, 1)

# s: frames whose times differ by less are of the same time.
SAME = 1e-6


class Frames(NamedTuple):
    """Poses (F, N, 3) at times (F,)."""

    times: Array
    poses: Array


def furthest(dragon: Dragon, found: Frames | Run, exact: Frames | Run) -> float:
    """Largest distance of a hole from its exact position in a frame that both have, m."""
    at = np.abs(exact.times[:, None] - found.times).argmin(axis=0)
    both = np.abs(exact.times[at] - found.times) < SAME
    one, two = (dragon.holes(each) for each in (found.poses[both], exact.poses[at[both]]))
    return float(np.linalg.norm(np.subtract(one, two), axis=-1).max())


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


def pulled() -> None:
    """Error of the contact, worst hole and processor time where only the head pulls."""
    exact = pull(March(), until=UNTIL)
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
                one, two = run.first_contact, exact.first_contact
                late = 1e3 * (one.time - two.time) if one and two else np.nan
                off = 1e3 * furthest(run.march.dragon, run, exact)
                taken = median(seconds[order, iterations])
                row.append(f"{late:+.3f} ms, {off:.3f} mm, {taken:.3f} s")
            print(f"| {' | '.join(row)} |", flush=True)


# ---- scenarios

# Values of `EngineSettings.order`, and factors on the corrections of poses: None for those of the
# order, 1 for the trapezoidal rule, which Pymunk's step has.
METHODS = {"order 1": (1, None), "mid torque": (2, 1.0), "order 2": (2, None)}

# m that the head travels in a substep, and iterations.
RULES = sized(((0.025, 20), (0.01, 10), (0.01, 100)), ((0.025, 5),))

# The same where contacts are resolved.
RESOLVED_RULES = sized(((0.01, 60), (0.005, 60)), ((0.02, 5),))

# Substeps, s, and iterations of the two runs from which poses are extrapolated.
FINE, FINE_ITERATIONS = sized(((0.0025, 0.00125), 100), ((0.02, 0.01), 5))

# Share of the durations that is played.
SHARE = sized(1.0, 0.05)


class HeldFront(Rails):
    """Dancers who hold only the first benches."""

    free_from = 20

    def joints(self, bench: int, body: Any) -> Any:
        return super().joints(bench, body) if bench < self.free_from else ()

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        super().update(poses, hinge_velocity, anchors, forces)
        forces[self.free_from :] = 0.0


def unequal(seed: int, benches: int = 60) -> Dragon:
    """A dragon of random benches."""
    random = np.random.default_rng(seed)
    return Dragon(
        head_spacing=float(random.uniform(1.5, 3.0)),
        body_spacing=random.uniform(1.0, 2.5, benches - 1).tolist(),
        overhang=random.uniform(0.1, 0.4, benches).tolist(),
        width=random.uniform(0.1, 0.5, benches).tolist(),
    )


TURN = UTurn(pitch=1.7, ratio=2.0)
SPEEDS = SpeedTable([0, 2, 4, 6, 9], [0.6, 1.0, 1.4, 0.8, 1.0])
STEEP = SpeedTable([0, 1, 1.2, 3, 3.1, 9], [0.2, 0.2, 1.5, 1.5, 0.5, 0.5])
ICE = 1e-6
SIXTY = Dragon(benches=60)
LONG = Dragon(benches=sized(1000, 80))

# Marches, durations, s, and settings of runs that `pull` has too.
PULLED: dict[str, tuple[March, float, dict[str, Any]]] = {
    "reference": (March(), 10.8, {}),
    "from 100 s": (March(), 10.0, {"start": 100.0}),
    "from 300 s": (March(), 6.0, {"start": 300.0}),
    "from 400 s": (March(), 6.0, {"start": 400.0}),
    "2 benches": (March(Dragon(benches=2)), 10.0, {}),
    "8 benches": (March(Dragon(benches=8)), 10.0, {}),
    "60 benches": (March(SIXTY), 10.0, {}),
    "1,000 benches": (March(LONG, turns=30), 10.8, {}),
    "1,000 benches on ice": (March(LONG, turns=30), 10.8, {"drag": ICE}),
    "U-turn, whole": (March(curve=TURN), 50.0, {"start": -20.0}),
    "U-turn, 60 benches": (March(SIXTY, TURN), 10.0, {}),
    "U-turn, 12 benches": (March(Dragon(benches=12), TURN), 20.0, {}),
    "U-turn on ice": (March(SIXTY, TURN), 10.0, {"drag": ICE}),
    "U-turn, unequal": (March(unequal(2), TURN), 10.0, {}),
    "U-turn, speeds": (March(SIXTY, TURN, speed=SPEEDS), 10.0, {}),
    "unequal": (March(unequal(1)), 10.0, {}),
    "unequal, others": (March(unequal(2)), 10.0, {}),
    "unequal, 120 benches": (March(unequal(3, 120)), 10.0, {}),
    "unequal on ice": (March(unequal(4)), 10.0, {"drag": ICE}),
    "0.5 m/s": (March(speed=0.5), 21.6, {}),
    "2 m/s": (March(speed=2.0), 5.4, {}),
    "speeds": (March(speed=SPEEDS), 10.0, {}),
    "steep speeds": (March(SIXTY, speed=STEEP), 8.0, {}),
    "speeds on ice": (March(SIXTY, speed=SPEEDS), 10.0, {"drag": ICE}),
    "ice": (March(), 11.6, {"drag": ICE}),
    "drag 0.25": (March(), 10.8, {"drag": 0.25}),
    "drag 2": (March(), 10.8, {"drag": 2.0}),
    "drag 50": (March(), 10.0, {"drag": 50.0}),
    "drag 200": (March(), 10.0, {"drag": 200.0}),
    "front held": (March(SIXTY), 10.0, {"guide": HeldFront()}),
}

# What happens at the begin of which second of a run.
Changes = Mapping[int, Callable[[World], object]]
LET_GO: Changes = {1: lambda world: world.release(5)}
BACK: Changes = {**LET_GO, 4: lambda world: world.hold()}

# Guides, durations, s, drag, and changes of runs of sixty benches whose contacts are resolved.
RESOLVED: dict[str, tuple[str, int, float, Changes]] = {
    "coarser steps": ("none", 9, 11.5, {2: lambda world: world.change(substep=0.02)}),
    "finer steps": ("none", 9, 11.5, {2: lambda world: world.change(substep=0.0025)}),
    "less drag": ("none", 9, 11.5, {2: lambda world: world.change(drag=2.0)}),
    "let go": ("rails", 9, 11.5, LET_GO),
    "let go, all": ("rails", 9, 11.5, {1: lambda world: world.release(1)}),
    "let go and back": ("rails", 9, 11.5, BACK),
    "let go again": ("rails", 11, 11.5, {**BACK, 9: lambda world: world.release(5)}),
    "joint cut": ("none", 9, 11.5, {2: lambda world: world.cut(20)}),
    "contacts": ("none", 13, 11.5, {}),
    "contacts, less drag": ("none", 13, 1.0, {}),
}


def errors_of(name: str) -> list[str]:
    """Largest errors, mm, of a run that `pull` has, for all rules and methods."""
    march, duration, options = PULLED[name]
    settings: dict[str, Any] = {"guide": "none", "start": 0.0, "drag": EngineSettings.drag}
    settings |= options
    until = settings["start"] + SHARE * duration
    free_from = getattr(settings["guide"], "free_from", 1)
    given = {"start": settings["start"], "until": until, "drag": settings["drag"]}
    exact = pull(march, free_from=free_from, tolerance=1e-8, **given)
    fastest = march.speed_profile.fastest(settings["start"], until)

    found = []
    for stride, iterations in RULES:
        settings |= {"substep": stride / fastest, "iterations": iterations, "until": until}
        for order, factor in METHODS.values():
            rule = world._moulton if factor is None else lambda _, factor=factor: factor
            with mock.patch.object(world, "_moulton", rule):
                run = simulate(march, contacts="report", order=order, **settings)
            found.append(f"{1e3 * furthest(march.dragon, run, exact):.3f}")
    return found


def played(name: str, order: int, substep: float, iterations: int) -> Frames:
    """The poses at the ends of the seconds of a run of `RESOLVED`."""
    guide, duration, drag, changes = RESOLVED[name]
    settings = EngineSettings(
        contacts="resolve", order=order, substep=substep, iterations=iterations, drag=drag
    )
    dragon = World(March(SIXTY), guide, settings, until=float(duration))
    time = 0.0
    times, poses = [], []
    for second in range(duration):
        if second in changes:
            changes[second](dragon)
        while time < SHARE * (second + 1) - SAME:
            time += dragon.substep
            dragon.follow(1 / 300, 20.0)
            dragon.space.step(dragon.substep)
            dragon.read()
        times.append(time)
        poses.append(dragon.poses)
    return Frames(np.array(times), np.array(poses))


def errors_of_resolved(name: str) -> list[str]:
    """Largest errors, mm, of a run of `RESOLVED`, for all rules and orders."""
    runs = [played(name, order, *rule) for rule in RESOLVED_RULES for order in (1, 2)]
    if name.endswith("steps"):
        exacts: list[Frames | Run] = [pull(March(SIXTY), until=run.times[-1]) for run in runs]
    else:
        coarse, fine = (played(name, 1, substep, FINE_ITERATIONS) for substep in FINE)
        exacts = [Frames(fine.times, 2 * fine.poses - coarse.poses)] * len(runs)
    pairs = zip(runs, exacts, strict=True)
    return [f"{1e3 * furthest(SIXTY, run, exact):.3f}" for run, exact in pairs]


def table(methods: list[str], rules: tuple[tuple[float, int], ...]) -> None:
    """Print the head of a table of scenarios."""
    names = [
        f"{1e3 * stride:g} mm, {iterations} it., {method}"
        for stride, iterations in rules
        for method in methods
    ]
    print("| scenario |", " | ".join(names), "|")
    print("| --- " * (1 + len(names)) + "|")


def scenarios() -> None:
    """Largest error of a hole in a frame, mm, in forty runs."""
    table([*METHODS], RULES)
    for name in PULLED:
        print("|", " | ".join([name, *errors_of(name)]), "|", flush=True)
    print("\nContacts resolved, where poses are those that the step has found:\n")
    table(["order 1", "order 2"], RESOLVED_RULES)
    for name in RESOLVED:
        print("|", " | ".join([name, *errors_of_resolved(name)]), "|", flush=True)


BENCHMARKS = {"pulled": pulled, "scenarios": scenarios}

if __name__ == "__main__":
    measure.run(BENCHMARKS)
