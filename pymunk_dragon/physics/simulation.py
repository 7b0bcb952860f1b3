"""The stepping loop: a march played by Pymunk."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from time import perf_counter
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import finite, positive, whole, word
from pymunk_dragon.errors import DragonError, ParameterError, UnreachableError
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog
from pymunk_dragon.model.dragon import interpolated
from pymunk_dragon.model.march import March, States, check_march, last_time
from pymunk_dragon.model.run import Outcome, Run, versions
from pymunk_dragon.physics.callbacks import Contacts, Recorder
from pymunk_dragon.physics.guides import Guide, make_guide
from pymunk_dragon.physics.refine import refined_contact
from pymunk_dragon.physics.world import DRAG, World, bench_mass

__all__ = ["FINE_ITERATIONS", "FINE_STRIDE", "ITERATIONS", "STRIDE", "simulate", "top_speed"]

Array = NDArray[np.float64]

# Metres that the head goes in one substep, and solver iterations in it. README has the table of drift and time error
# that they were chosen from; the fine ones are for a contact time that is right to a millisecond.
STRIDE, ITERATIONS = 1 / 100, 60
FINE_STRIDE, FINE_ITERATIONS = 1 / 400, 60
# Metres in one substep where contacts are resolved. README has the table of joint gaps and depths.
RESOLVE_STRIDE = 1 / 200
# Largest force of the head's motor, in units of the ground drag on what the head has to pull.
HEAD_FORCE = 2.0
# Where contacts are resolved: the distance from its exact pose at which the head counts as held up, in widths (1 mm for
# the contest's benches), and how much of its speed the march then loses, and regains afterwards, per metre at full
# speed. At 1 m/s the dancers brake at 20 m/s^2, with at most 0.26 kN each.
LAG, BRAKING, RESUMING = 1 / 300, 20.0, 2.0
# Far outside what makes sense: substeps that skip over a bench, and ones that would take days.
MAX_STRIDE, MIN_STRIDE = 0.1, 1e-5
MAX_ITERATIONS = 100_000

# s between recorded frames at 1 m/s; between them poses are interpolated to a micrometre.
FRAME_INTERVAL = 0.1
# Substeps for which the head's exact poses are computed at once.
BLOCK = 2048
# N: the weight of a hundred thousand tonnes, which no head needs.
MAX_FORCE = 1e9
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
    head_force: float | None = None,
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
        let the engine push the benches apart. Resolved, the head is pulled along the march by a motor of finite force,
        and the dancers stop where the head cannot go on.
    start, until : float
        Simulated times, s. Without `until` the run goes on to the end of the curve, if nothing stops it.
    substep : float, optional
        s; by default the time in which the head goes 10 mm, or 5 mm where contacts are resolved.
    iterations : int
        Solver iterations per substep.
    frame_interval : float, optional
        s between recorded frames, rounded to whole substeps; by default the time in which the head goes 0.1 m.
    head_force : float, optional
        Largest force of the head's motor, N, where contacts are resolved. By default twice the ground drag on what the
        head pulls: on itself where dancers walk (0.47 kN for the contest's at 1 m/s), on all benches without a guide.
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
        If the dragon has no state at `start`.
    DragonError
        If the engine's chain flew apart.
    """
    check_march(march)
    if until is None:
        until = last_time(march, finite("start", start, -MAX_TIME, MAX_TIME, "s"))
    _check(contacts, start, until, iterations)
    fastest = top_speed(march, start, until)
    stride = RESOLVE_STRIDE if contacts == "resolve" else STRIDE
    substep = stride / fastest if substep is None else substep
    frame_interval = FRAME_INTERVAL / fastest if frame_interval is None else frame_interval
    finite("substep", substep, MIN_STRIDE / fastest, MAX_STRIDE / fastest, "s")
    positive("frame_interval", frame_interval, MAX_TIME, "s")
    if contacts == "resolve":
        head_force = _head_force(march, guide, fastest, head_force)
    elif head_force is not None:
        raise ParameterError("head_force", head_force, "absent unless contacts are resolved")
    path_guide = make_guide(guide, march, start=start, substep=substep, top_speed=fastest)
    world = World(
        march,
        path_guide,
        start=start,
        substep=substep,
        iterations=iterations,
        top_speed=fastest,
        head_force=head_force,
    )
    recorder = Recorder(world.space, world.bodies, world.shapes, resolve=contacts != "report", on_event=on_event)
    loop = _Loop(world, recorder, contacts, start, fastest, max(1, round(frame_interval / substep)))
    try:
        with recorder.signals_held():
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
    if head_force is not None:
        settings["head_force"] = head_force
    times, poses = np.array(loop.times), np.array(loop.poses)
    return Run(
        march=march,
        times=times,
        poses=poses,
        drift=_drift(march, times, poses),
        pose_velocities=np.array(loop.velocities),
        joint_impulses=np.array(loop.joint_impulses),
        events=ContactLog(tuple(recorder.events)),
        first_contact=loop.first_contact,
        outcome=loop.outcome,
        provenance=settings,
        timing={"wall_seconds": loop.wall_seconds, "step_seconds": loop.step_seconds},
    )


def _head_force(march: March, guide: Guide, fastest: float, given: float | None) -> float:
    """Largest force of the head's motor, N: the given one, or what the head needs and as much again."""
    if given is not None:
        return positive("head_force", given, MAX_FORCE, "N")
    dragon = march.dragon
    pulled = slice(1 if guide == "rails" else None)
    sizes = zip(dragon.lengths[pulled].tolist(), dragon.widths[pulled].tolist(), strict=True)
    return HEAD_FORCE * DRAG * fastest**2 * sum(bench_mass(*size) for size in sizes)


def top_speed(march: March, start: float, until: float | None) -> float:
    """The highest speed of the head between two times, or until it comes to the end of the curve, m/s."""
    end = march.end
    return float(march.speed_profile.fastest(start, max(start, end if until is None else min(until, end))))


class _Loop:
    """Steps a world and keeps what a run is made of."""

    def __init__(
        self, world: World, recorder: Recorder, contacts: Contacts, start: float, top_speed: float, stride: int
    ) -> None:
        self._world = world
        self._recorder = recorder
        self._contacts = contacts
        self._start = start
        self._top_speed = top_speed
        self._stride = stride
        self.times = [float(start)]
        self.poses = [world.poses.copy()]
        self.velocities = [world.velocities.copy()]
        self.joint_impulses = [world.joint_impulses]
        self.substeps = 0
        self.first_contact: Contact | None = None
        self.outcome: Outcome = "clear"
        self.wall_seconds = 0.0
        self.step_seconds = 0.0

    def play(self, until: float, progress: Callable[[float, float], None] | None) -> None:
        """Step until the time is over, the curve ends, or the first contact ends the run."""
        # A millionth of a substep more or less is rounding, not another substep; but there is at least one.
        total = max(1, math.ceil((until - self._start) / self._world.substep - 1e-6))
        begin = perf_counter()
        # A chain that flies apart is found by `_keep`, in the next frame; until then NumPy need not warn of it.
        with np.errstate(all="ignore"):
            track = self._waiting_track(total) if self._contacts == "resolve" else self._head_track(total)
            for pose, velocity, hinge_velocity in track:
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
            self._keep(self.first_contact.time, *self._contact_motion)
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

    def _waiting_track(self, total: int) -> Iterator[tuple[Array, Array, Array]]:
        """What `_head_track` yields, but slowing down to a stop while the head cannot follow.

        The dancers follow the speed of this track, so they brake with it.
        """
        world = self._world
        most_lag = LAG * float(world.march.dragon.widths.min())
        marched, share = self._start, 1.0
        for _ in range(total):
            change = -BRAKING if world.head_lag > most_lag else RESUMING
            share = min(max(share + change * self._top_speed * world.substep, 0.0), 1.0)
            marched += share * world.substep
            try:
                head = world.march.at(marched, handles=2)
            except UnreachableError:
                self.outcome = "unreachable"
                return
            [(pose, velocity, hinge_velocity)] = _track(head)
            yield pose, share * velocity, share * hinge_velocity

    def _substep(self, head_pose: Array, head_velocity: Array, hinge_velocity: Array) -> None:
        world, recorder = self._world, self._recorder
        world.prepare(head_pose, head_velocity, hinge_velocity)
        begin_time = self.time
        self.substeps += 1
        recorder.time = self.time
        with recorder.stepping():
            begin = perf_counter()
            world.space.step(world.substep)
            self.step_seconds += perf_counter() - begin
        before = (world.poses.copy(), world.velocities.copy()) if recorder.begun else None
        world.read()
        if before is not None:
            if self.first_contact is None:
                self._meet(*before, (begin_time, self.time))
            recorder.begun.clear()

    def _meet(self, before: Array, velocities: Array, times: tuple[float, float]) -> None:
        """Find the first of the contacts that began in the last substep, and poses and velocities at that moment.

        The velocities after the substep have the blow in them already. Those at the contact come from the velocities
        before the substep and from the change of the poses, which knows nothing of the blow.
        """
        dragon, after = self._world.march.dragon, self._world.poses
        touched = [refined_contact(dragon, pair, before, after, times) for pair in self._recorder.begun]
        self.first_contact = min(touched, key=lambda contact: contact.time)
        share = (self.first_contact.time - times[0]) / (times[1] - times[0])
        poses = interpolated(before, after, share)
        # The mean over the substep is the velocity at its middle.
        mean = (interpolated(before, after, 1.0) - before) / (times[1] - times[0])
        self._contact_motion = poses, velocities + 2 * share * (mean - velocities)

    def _record(self) -> None:
        self._keep(self.time, self._world.poses.copy(), self._world.velocities.copy())

    def _keep(self, time: float, poses: Array, velocities: Array) -> None:
        if not np.all(np.isfinite(poses) & np.isfinite(velocities)):
            raise DragonError(f"the chain flew apart before t = {time:.6g} s; a smaller substep may hold it")
        if time > self.times[-1]:
            self.times.append(time)
            self.poses.append(poses)
            self.velocities.append(velocities)
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
