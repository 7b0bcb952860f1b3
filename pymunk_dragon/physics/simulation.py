"""The stepping loop: a march played by Pymunk."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from time import perf_counter
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite, positive, whole, word
from pymunk_dragon.contact import Contact, ContactEvent, ContactLog
from pymunk_dragon.dragon import interpolated
from pymunk_dragon.errors import DragonError, ParameterError, UnreachableError
from pymunk_dragon.march import March, States, check_march, last_time
from pymunk_dragon.physics.callbacks import Contacts, Recorder
from pymunk_dragon.physics.rails import Guide, make_guide
from pymunk_dragon.physics.refine import refined_contact
from pymunk_dragon.physics.world import World
from pymunk_dragon.run import Outcome, Run, versions

__all__ = ["FINE_ITERATIONS", "FINE_STRIDE", "ITERATIONS", "STRIDE", "simulate", "top_speed"]

Array = NDArray[np.float64]

# Metres that the head goes in one substep, and solver iterations in it. README has the table of drift and time error
# that they were chosen from; the fine ones are for a contact time that is right to a millisecond.
STRIDE, ITERATIONS = 1 / 100, 60
FINE_STRIDE, FINE_ITERATIONS = 1 / 400, 60
# Far outside what makes sense: substeps that skip over a bench, and ones that would take days.
MAX_STRIDE, MIN_STRIDE = 0.1, 1e-5
MAX_ITERATIONS = 100_000

# s between recorded frames at 1 m/s; between them poses are interpolated to half a millimetre.
FRAME_INTERVAL = 0.1
# Substeps for which the head's exact poses are computed at once.
BLOCK = 2048
# Times further than this from any march, s, lose their milliseconds to rounding.
MAX_TIME = 1e9


def simulate(
    march: March,
    *,
    guide: Guide = "rails",
    contacts: Contacts = "stop",
    start: float = 0.0,
    until: float | None = None,
    substep: float | None = None,
    iterations: int = ITERATIONS,
    frame_interval: float | None = None,
    on_event: Callable[[ContactEvent], None] | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> Run:
    """Play a march in Pymunk.

    Parameters
    ----------
    march : March
        What to play. The engine takes the state at `start` and the head's poses from it, and nothing else.
    guide : {"rails", "none"}
        Whether dancers keep every hole on the curve, or the head only pulls.
    contacts : {"stop", "report", "resolve"}
        At the first contact of benches that are not neighbours: end the run, play on and only record, or play on and
        let the engine push the benches apart.
    start, until : float
        Simulated times, s. Without `until` the run goes on to the end of the curve, if nothing stops it.
    substep : float, optional
        s; by default the time in which the head goes 10 mm.
    iterations : int
        Solver iterations per substep.
    frame_interval : float, optional
        s between recorded frames, rounded to whole substeps; by default the time in which the head goes 0.1 m.
    on_event : callable, optional
        Called with each `ContactEvent`; what it raises is raised from here after the substep.
    progress : callable, optional
        Called with the simulated time and the time at which the run will end at the latest, once per frame.

    Returns
    -------
    Run
        With `drift` against the exact model, and every collision callback in `events`.

    Raises
    ------
    ParameterError
        If a setting is unusable.
    UnreachableError
        If the dragon has no place on the curve at `start`.
    DragonError
        If the engine's chain flew apart.
    """
    check_march(march)
    if until is None:
        until = last_time(march, finite("start", start, -MAX_TIME, MAX_TIME, "s"))
    _check(contacts, start, until, iterations)
    fastest = top_speed(march, start, until)
    substep = STRIDE / fastest if substep is None else substep
    frame_interval = FRAME_INTERVAL / fastest if frame_interval is None else frame_interval
    finite("substep", substep, MIN_STRIDE / fastest, MAX_STRIDE / fastest, "s")
    positive("frame_interval", frame_interval, MAX_TIME, "s")
    joiner = make_guide(guide, march, start=start, substep=substep, top_speed=fastest)
    world = World(march, joiner, start=start, substep=substep, iterations=iterations, top_speed=fastest)
    recorder = Recorder(world.space, world.bodies, world.shapes, resolve=contacts != "report", on_event=on_event)
    loop = _Loop(world, recorder, contacts, start, max(1, round(frame_interval / substep)))
    try:
        loop.play(until, progress)
    finally:
        recorder.close()
    settings = {
        "player": "pymunk",
        "guide": guide,
        "contacts": contacts,
        "start": float(start),
        "until": float(until),
        "substep": float(substep),
        "iterations": int(iterations),
        "substeps": loop.substeps,
        "versions": versions(),
    }
    times, poses = np.array(loop.times), np.array(loop.poses)
    return Run(
        march=march,
        times=times,
        poses=poses,
        drift=_drift(march, times, poses),
        joint_impulses=np.array(loop.joint_impulses),
        events=ContactLog(tuple(recorder.events)),
        first_contact=loop.first_contact,
        outcome=loop.outcome,
        provenance=settings,
        timing={"wall_seconds": loop.wall_seconds, "step_seconds": loop.step_seconds},
    )


def top_speed(march: March, start: float, until: float | None) -> float:
    """The highest speed of the head between two times, or until it comes to the end of the curve, m/s."""
    end = march.end
    return float(march.pace.fastest(start, max(start, end if until is None else min(until, end))))


class _Loop:
    """Steps a world and keeps what a run is made of."""

    def __init__(self, world: World, recorder: Recorder, contacts: Contacts, start: float, stride: int) -> None:
        self._world = world
        self._recorder = recorder
        self._contacts = contacts
        self._start = start
        self._stride = stride
        self.times = [float(start)]
        self.poses = [world.poses.copy()]
        self.joint_impulses = [world.joint_impulses]
        self.substeps = 0
        self.first_contact: Contact | None = None
        self.outcome: Outcome = "clear"
        self.wall_seconds = 0.0
        self.step_seconds = 0.0

    def play(self, until: float, progress: Callable[[float, float], None] | None) -> None:
        """Step until the time is over, the curve ends, or the first contact ends the run."""
        # A millionth of a substep more or less is rounding, not another substep.
        total = math.ceil((until - self._start) / self._world.substep - 1e-6)
        begin = perf_counter()
        # A chain that flies apart is found by `_keep`, in the next frame; until then NumPy need not warn of it.
        with np.errstate(all="ignore"):
            for pose, velocity, hinge_velocity in self._head_track(total):
                self._substep(pose, velocity, hinge_velocity)
                if self.first_contact is not None and self._contacts == "stop":
                    break
                if self.substeps % self._stride == 0:
                    self._record()
                    if progress is not None:
                        progress(self.time, until)
        if self.first_contact is not None:
            self.outcome = "contact"
        if self.first_contact is not None and self._contacts == "stop":
            self._keep(self.first_contact.time, self._contact_poses)
        else:
            self._record()
        self.wall_seconds = perf_counter() - begin

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._start + self.substeps * self._world.substep

    def _head_track(self, total: int) -> Iterator[tuple[Array, Array, Array]]:
        """Exact pose and velocity of the head, and velocity of its rear hole, at the end of each substep."""
        march = self._world.march
        for first in range(1, total + 1, BLOCK):
            steps = np.arange(first, min(first + BLOCK, total + 1))
            times = self._start + steps * self._world.substep
            try:
                head = march.at(times, handles=2)
            except UnreachableError as error:
                self.outcome = "unreachable"
                reachable = times[times < error.time]
                if reachable.size:
                    yield from _track(march.at(reachable, handles=2))
                return
            yield from _track(head)

    def _substep(self, head_pose: Array, head_velocity: Array, hinge_velocity: Array) -> None:
        world, recorder = self._world, self._recorder
        world.prepare(head_pose, head_velocity, hinge_velocity)
        begin_time = self.time
        self.substeps += 1
        recorder.time = self.time
        begin = perf_counter()
        world.space.step(world.substep)
        self.step_seconds += perf_counter() - begin
        recorder.check()
        before = world.poses.copy() if recorder.begun else None
        world.read()
        if before is not None:
            if self.first_contact is None:
                self._meet(before, (begin_time, self.time))
            recorder.begun.clear()

    def _meet(self, before: Array, times: tuple[float, float]) -> None:
        """Find the first of the contacts that began in the last substep, and the poses at that moment."""
        dragon, after = self._world.march.dragon, self._world.poses
        touched = [refined_contact(dragon, pair, before, after, times) for pair in self._recorder.begun]
        self.first_contact = min(touched, key=lambda contact: contact.time)
        share = (self.first_contact.time - times[0]) / (times[1] - times[0])
        self._contact_poses = interpolated(before, after, share)

    def _record(self) -> None:
        self._keep(self.time, self._world.poses.copy())

    def _keep(self, time: float, poses: Array) -> None:
        if not np.all(np.isfinite(poses)):
            raise DragonError(f"the chain flew apart before t = {time:.6g} s; a smaller substep may hold it")
        if time > self.times[-1]:
            self.times.append(time)
            self.poses.append(poses)
            self.joint_impulses.append(self._world.joint_impulses)


def _track(head: States) -> Iterator[tuple[Array, Array, Array]]:
    return zip(head.poses[:, 0], head.pose_velocities[:, 0], head.velocities[:, 1], strict=True)


def _check(contacts: str, start: float, until: float, iterations: int) -> None:
    """Raise a ParameterError for settings that no run can be made of."""
    word("contacts", contacts, get_args(Contacts))
    finite("start", start, -MAX_TIME, MAX_TIME, "s")
    finite("until", until, -MAX_TIME, MAX_TIME, "s")
    if until <= start:
        raise ParameterError("until", until, f"later than the start, {start:g} s")
    whole("iterations", iterations, 1, MAX_ITERATIONS)


def _drift(march: March, times: Array, poses: Array) -> Array:
    """How far the worse hole of each bench is from where the exact model has it, (F, N) in m; nan where it has none."""
    drift = np.full(poses.shape[:2], np.nan)
    known = len(times)
    try:
        exact = march.at(times).positions
    except UnreachableError as error:
        known = int(np.searchsorted(times, error.time))
        exact = march.at(times[:known]).positions
    front, rear = march.dragon.holes(poses[:known])
    drift[:known] = np.maximum(
        np.linalg.norm(front - exact[:, :-1], axis=-1),
        np.linalg.norm(rear - exact[:, 1:], axis=-1),
    )
    return drift
