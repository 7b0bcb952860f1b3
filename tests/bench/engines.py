"""The dragon as a benchmark of physics engines: `python tests/bench/engines.py [DRIVE ...]`.

Each engine plays the reference march with the same driver, and an exact answer stands beside it. A
drive says what moves the benches:

- `head`: the head pulls all others over ground with viscous drag, from 0 s on; the exact answer is
  that of `pull`.
- `rails`: a joint of 1 m keeps each rear hole at this distance from an anchor, which moves beside
  the path, from 400 s on; the exact answer is the march.
- `pinned`: each rear hole is joined to its exact place: the engine gets the answer.

The engines in Python are in `adapters`, those in JavaScript in `node`, where `npm install` puts
them. One that is not installed is left out.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

import measure
import numpy as np
from adapters import Scene
from measure import sized

from pymunk_dragon import Grid, March, first_contact, pull, separation
from pymunk_dragon._arrays import Array
from pymunk_dragon.model.run import position_errors

NODE = Path(__file__).parent / "node"

# Modules of the engines.
PYTHON = ("pymunk_world", "pymunk_plain", "box2d", "box2d_3", "mujoco_hinges", "exudyn_joints")

# 1/s: the ground's drag where only the head pulls, as in `EngineSettings`.
DRAG = 11.5

# Their folders in `node_modules`.
PACKAGES = {
    "planck": "planck",
    "rapier": "@dimforge/rapier2d-compat",
    "matter": "matter-js",
    "p2": "p2-es",
}

# m: a bench so far from its exact place is no longer in the chain.
FLOWN = 10.0

# mm: smaller errors are not told apart.
ROUNDING = 1e-6

# m: distance of a rear hole from its anchor on rails.
RAIL = 1.0

# s: start and end of each drive. The first contacts are at 10.892 s and at 412.474 s.
SPANS = {
    "head": sized((0.0, 11.5), (0.0, 0.5)),
    "rails": sized((400.0, 413.0), (412.0, 412.5)),
    "pinned": sized((400.0, 413.0), (412.0, 412.5)),
}


# Steps a second, and iterations (substeps in Box2D 3) in a step, for the table of speeds.
SPEEDS: dict[str, tuple[tuple[int, int], ...]] = {
    "pymunk_world": ((15, 10), (25, 10), (50, 10), (50, 40), (100, 20), (200, 20), (400, 20)),
    "box2d_3": ((30, 2), (30, 4), (60, 2), (60, 4), (60, 8), (60, 16), (120, 4), (240, 4)),
    "planck": ((60, 5), (60, 20), (120, 10)),
    "matter": ((60, 15), (60, 30), (60, 60)),
    "p2": ((60, 25), (120, 25), (240, 25), (240, 50)),
}


@dataclass(frozen=True)
class Played:
    """A run of an engine.

    Attributes
    ----------
    name, settings : str
        The engine and its version, and its settings.
    times : ndarray, shape (T,)
        Times of the states, s, from the start on.
    poses : ndarray, shape (T, N, 3)
        Poses of the benches: m, m, rad.
    reported : list
        Number of the step, and the two benches, of each contact that the engine reported.
    bare, whole : float
        Processor time of the steps alone, and with moving and reading bodies, s.
    """

    name: str
    settings: str
    times: Array
    poses: Array
    reported: list[tuple[int, int, int]]
    bare: float
    whole: float


@cache
def exact_poses(drive: str, substep: float) -> tuple[Array, Array]:
    """Times (T,) of the states at the start and after each step, s, and exact poses (T, N, 3)."""
    start, until = SPANS[drive]
    count = round((until - start) / substep) + 1
    times: Array = start + substep * np.arange(count, dtype=np.float64)
    if drive == "head":
        run = pull(March(), until=until + 2 * substep, drag=DRAG)
        return times, run.poses_at(times)
    return times, np.concatenate([March().at(part).poses for part in np.array_split(times, 40)])


def scene_of(drive: str, substep: float, **changes: Any) -> Scene:
    """What an engine is given for a drive and a length of its steps, s, with `changes`."""
    march = March()
    times, poses = exact_poses(drive, substep)
    states = march.at(times[0])
    holes = march.dragon.holes(poses)[1][:, 1:]
    anchors = holes if drive == "pinned" else holes[:, :0]
    if drive == "rails":
        parts = [march.at(part) for part in np.array_split(times, 40)]
        coordinates = np.concatenate([part.handles_s[:, 2:] for part in parts])
        tangents = march.curve.tangent(coordinates)
        normals = np.stack([-tangents[..., 1], tangents[..., 0]], axis=-1)
        anchors = holes + RAIL * normals
    head = poses[:, 0].copy()
    head[:, 2] = np.unwrap(head[:, 2])
    scene = Scene(
        dragon=march.dragon,
        begin=times[0],
        step=substep,
        drag=DRAG if drive == "head" else 0.0,
        rail=RAIL if drive == "rails" else 0.0,
        start=np.stack([poses[0], states.pose_velocities[0]]),
        head=head,
        anchors=anchors,
    )
    return replace(scene, **changes)


def play_python(module: str, drive: str, substep: float = 0.0, **changes: Any) -> Played:
    """Play a drive in an engine with bindings for Python, at its own settings or at others."""
    kind = import_module(f"adapters.{module}").Engine
    scene = scene_of(drive, substep or kind.substeps[drive], **changes)
    engine = kind(scene)
    poses = [scene.start[0]]
    reported: list[tuple[int, int, int]] = []
    bare = 0.0
    begin = time.process_time()
    for number in range(1, scene.steps + 1):
        engine.move(number)
        before = time.process_time()
        engine.step()
        bare += time.process_time() - before
        poses.append(engine.poses())
        reported += ((number, *pair) for pair in engine.touched)
    whole = time.process_time() - begin
    times, _ = exact_poses(drive, scene.step)
    return Played(kind.name, kind.settings, times, np.array(poses), reported, bare, whole)


def node(*arguments: str | Path) -> dict[str, Any]:
    """What a process of `run.mjs` prints."""
    command = ["node", "run.mjs", *map(str, arguments)]
    done = subprocess.run(command, cwd=NODE, check=True, stdout=subprocess.PIPE)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@cache
def about(module: str) -> dict[str, Any]:
    """Length of the steps of an engine for JavaScript, s, and the drives that it has joints for."""
    return node(module)


def play_javascript(module: str, drive: str, substep: float = 0.0, **changes: Any) -> Played:
    """Play a drive in an engine for JavaScript, in a process of node; as `play_python`."""
    scene = scene_of(drive, substep or about(module)["substep"], **changes)
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "scene"), Path(folder, "poses")
        scene.write(given)
        result = node(module, given, found)
        poses = np.fromfile(found, "<f8").reshape(scene.steps + 1, -1, 3)
    times, _ = exact_poses(drive, scene.step)
    return Played(times=times, poses=poses, **result)


def first_overlap(played: Played) -> tuple[int, int, int] | None:
    """Number of the first step after which two benches overlap, and these; None if none do."""
    march = March()
    grid = Grid.of(march)
    for number, outlines in enumerate(march.dragon.outlines(played.poses)):
        pairs = grid.pairs(outlines)
        first, second = pairs.T
        distances = separation(outlines[first], outlines[second]).distance
        if distances.size and distances.min() < 0:
            return number, *pairs[distances.argmin()].tolist()
    return None


def errors(poses: Array, exact: Array) -> Array:
    """Distances (T, N), m, of the worse hole of benches at poses (T, N, 3) from the exact hole."""
    dragon = March().dragon
    front, rear = dragon.holes(exact)
    return position_errors(dragon, poses, np.concatenate([front, rear[:, -1:]], axis=1))


def shown_contact(played: Played, contact: tuple[int, int, int] | None) -> str:
    """The benches and the time of a contact."""
    if contact is None:
        return "none"
    number, first, second = contact
    return f"({first}, {second}) {played.times[number]:.3f}"


def shown(value: float) -> str:
    """A value with two digits, and none where it is rounding."""
    return f"{float(f'{value:.2g}'):g}" if value > ROUNDING else f"< {ROUNDING:g}"


def row(played: Played, drive: str, contact: float) -> str:
    """The row of a run in the table; errors are those before the exact `contact`, s."""
    step = played.times[1] - played.times[0]
    label = f"| {played.name} | 1/{1 / step:.0f} s, {played.settings} | "
    _, exact = exact_poses(drive, step)
    seen = played.times <= contact
    front, rear = March().dragon.holes(played.poses[seen])
    gap = np.linalg.norm(front[:, 1:] - rear[:, :-1], axis=-1).max()
    off = errors(played.poses[seen], exact[seen]).max()
    if not off < FLOWN:
        return f"{label}flies apart | | | | | |"
    span = played.times[-1] - played.times[0]
    # Some engines report neighbours too, which always overlap.
    apart = (found for found in played.reported if found[2] > found[1] + 1)
    cells = [
        shown(1e3 * gap),
        shown(1e3 * off),
        shown_contact(played, next(apart, None)),
        shown_contact(played, first_overlap(played)),
        shown(span / played.bare),
        shown(span / played.whole),
    ]
    return f"{label}{' | '.join(cells)} |"


def players(drive: str) -> list[partial[Played]]:
    """A function for each installed engine that has this drive; prints a line for the others."""
    found: list[partial[Played]] = []
    for module in PYTHON:
        try:
            kind = import_module(f"adapters.{module}").Engine
        except ImportError as error:
            print(f"left out: {error.name} is not installed")
            continue
        if drive in kind.substeps:
            found.append(partial(play_python, module, drive))
    for module, package in PACKAGES.items():
        if not (shutil.which("node") and (NODE / "node_modules" / package).exists()):
            print(f"left out: {package} is not installed")
        elif drive in about(module)["drives"]:
            found.append(partial(play_javascript, module, drive))
    return found


def compare(drive: str, **changes: Any) -> None:
    """Print the table of a drive, whose scenes have `changes`."""
    pulled = pull(March(), until=11.0).first_contact if drive == "head" else None
    contact = pulled.time if pulled else first_contact(March()).time
    assert contact is not None
    print(f"The exact first contact is at {contact:.6f} s.\n")
    installed = players(drive)
    columns = "widest hinge, mm | position error, mm | contact reported, s | contact by poses, s"
    print(f"| engine | settings | {columns} | times real time, steps | with the driver |")
    print("| --- " * 8 + "|")
    for play in installed:
        print(row(play(**changes), drive, contact), flush=True)


def head() -> None:
    """The head pulls all others over ground with drag; exact is what `pull` finds."""
    compare("head")


def rails() -> None:
    """Joints of 1 m keep the rear holes on the path; exact is the march."""
    compare("rails")


def drag() -> None:
    """The rails again, with ground drag on all benches and nothing that makes up for it."""
    compare("rails", drag=DRAG)


def pinned() -> None:
    """Each rear hole is joined to its exact place."""
    compare("pinned")


def speed() -> None:
    """Position error on rails and speed of engines, at several settings each."""
    installed = [play.args[0] for play in players("rails")]
    contact = first_contact(March()).time
    print("| engine | step | iterations | position error, mm | times real time, steps | driver |")
    print("| --- " * 6 + "|")
    small: dict[str, tuple[tuple[int, int], ...]] = {"pymunk_world": ((25, 10),)}
    for module, pairs in sized(SPEEDS, small).items():
        if module not in installed:
            continue
        play = play_javascript if module in PACKAGES else play_python
        for rate, iterations in pairs:
            played = play(module, "rails", 1 / rate, iterations=iterations)
            _, exact = exact_poses("rails", 1 / rate)
            seen = played.times <= contact
            off = errors(played.poses[seen], exact[seen]).max()
            span = played.times[-1] - played.times[0]
            cells = [played.name, f"1/{rate} s", str(iterations)]
            cells += [shown(each) for each in (1e3 * off, span / played.bare, span / played.whole)]
            print(f"| {' | '.join(cells)} |", flush=True)


BENCHMARKS = {"head": head, "rails": rails, "drag": drag, "pinned": pinned, "speed": speed}

if __name__ == "__main__":
    measure.run(BENCHMARKS)
