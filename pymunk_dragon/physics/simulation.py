"""The stepping loop: a march played by Pymunk."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict
from time import perf_counter
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array, as_vectors
from pymunk_dragon._checks import function, silent
from pymunk_dragon.errors import DragonError
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog
from pymunk_dragon.model.dragon import pose_step
from pymunk_dragon.model.march import March, checked_times, states_while_reachable
from pymunk_dragon.model.run import Outcome, Run, position_errors, versions
from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics.assembly import GUIDES
from pymunk_dragon.physics.contacts import Recorder
from pymunk_dragon.physics.guide import PathGuide
from pymunk_dragon.physics.substep import Motion
from pymunk_dragon.physics.world import World

# m: distance that the head travels between recorded frames. Between them poses are interpolated to
# a micrometre.
_FRAME_STRIDE = 0.1

# Widths: where contacts are resolved, distance of the head from its exact pose at which it counts
# as blocked. It is 1 mm for the contest's benches.
_HEAD_LAG = 1 / 300

# Per metre: share of its speed that a march with a blocked head loses. At 1 m/s dancers brake at
# 20 m/s^2, with at most 0.26 kN.
_BRAKING = 20.0

# Substeps for which the head's exact poses are computed at once.
_BLOCK = 2048

# Share of a substep: a shorter one at the end is due to rounding and left out.
_LAST_SUBSTEP = 1e-6


def simulate(
    march: March,
    *,
    settings: EngineSettings | None = None,
    guide: str | PathGuide = "rails",
    start: float = 0.0,
    until: float | None = None,
    on_event: Callable[[ContactEvent], None] | None = None,
    progress: Callable[[float, float], None] = silent,
    **changes: Any,
) -> Run:
    """Play a march in Pymunk.

    The default settings are right to 0.02 mm; a shorter `substep` is more exact, a longer one is
    faster.

    Parameters
    ----------
    march : March
        The motion to play. The engine takes the state at `start` and the head's poses from it, and
        nothing else.
    settings : EngineSettings, optional
        Settings of the engine.
    **changes
        Other values of settings, as in ``contacts="report"``.
    guide : {"rails", "none"} or PathGuide
        Whether dancers keep every hole on the curve, or the head only pulls; or a guide of your
        own.
    start : float
        Time at which the run begins, s.
    until : float, optional
        Time that the last substep reaches, s. At the latest, and by default, the run ends at the
        time `march.end`, also if contacts have held the head up; on a curve that ends, with the
        last whole substep before its end.
    on_event : callable, optional
        Called with each `ContactEvent`; what it raises is raised from here after the substep.
    progress : callable, optional
        Called with the simulated time and the time at which the run will end at the latest, once
        per frame.

    Returns
    -------
    Run
        With `drift` against the exact model, and every collision callback in `events`.

    Raises
    ------
    UnreachableError
        If the dragon has no state at `start`.
    DragonError
        If the engine's chain flew apart.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, simulate
    >>> march = March(Dragon(benches=16))
    >>> run = simulate(march, start=411, contacts="report", until=412.6)
    >>> run.first_contact.benches, round(run.first_contact.time, 3)
    ((0, 8), 412.474)
    """
    start, until = checked_times(march, start, until)
    world = World(march, guide, settings, start=start, until=until, **changes)
    if on_event is not None:
        function("on_event", on_event)
    function("progress", progress)

    loop = _Loop(world, Recorder(world, on_event))
    loop.play(until, progress)

    times, poses, velocities, forces = map(np.array, zip(*loop.frames, strict=True))
    exact = as_vectors(march.motion_or_nan(times).points)
    return Run(
        march=march,
        times=times,
        poses=poses,
        drift=position_errors(march.dragon, poses, exact),
        pose_velocities=velocities,
        joint_forces=forces,
        events=ContactLog(tuple(loop.recorder.events)),
        first_contact=loop.first_contact,
        outcome=loop.outcome,
        provenance=_provenance(world, until, loop.substeps),
        wall_seconds=loop.wall_seconds,
        step_seconds=loop.step_seconds,
    )


class _Loop:
    """Steps a world to the end of a run, and keeps the frames and the first contact."""

    def __init__(self, world: World, recorder: Recorder) -> None:
        self._world = world
        self.recorder = recorder
        self.frames: list[tuple[float, Array, Array, Array]] = []
        self.substeps = 0
        self.first_contact: Contact | None = None
        self.outcome: Outcome = "clear"
        self.wall_seconds = 0.0
        self.step_seconds = 0.0
        self._record(world.start, world.poses, world.velocities)

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._world.start + self.substeps * self._world.substep

    def play(self, until: float, progress: Callable[[float, float], None]) -> None:
        """Step until `until` s, the end of the march, or the first contact if it ends the run."""
        world = self._world
        settings = world.settings
        interval = settings.frame_interval or _FRAME_STRIDE / world.top_speed
        per_frame = max(1, round(interval / world.substep))
        duration = min(until, world.march.end) - world.start
        total = max(1, math.ceil(duration / world.substep - _LAST_SUBSTEP))
        track = _waiting_head if settings.contacts == "resolve" else _exact_head

        begin = perf_counter()
        # A chain that flies apart is found by `_record`, in the next frame; until then NumPy need
        # not warn of it.
        with np.errstate(all="ignore"):
            for _ in track(world, total):
                self._step()
                if self.first_contact is not None and settings.contacts == "stop":
                    break
                if self.substeps % per_frame == 0:
                    self._record(self.time, world.poses, world.velocities)
                    progress(self.time, until)
            else:
                self._record(self.time, world.poses, world.velocities)
                self.outcome = "unreachable" if self._lost(until) else "clear"

        if self.first_contact is not None:
            self.outcome = "contact"
        self.wall_seconds = perf_counter() - begin

    def _lost(self, time: float) -> bool:
        """Whether the march has no state of the head at a time, s."""
        handles_s = self._world.march.motion_or_nan(time, handles=2).handles_s
        return bool(np.isnan(handles_s).any())

    def _step(self) -> None:
        """Make a substep; the contact that ends the run becomes a frame."""
        world = self._world
        begin = self.time
        before = world.poses
        velocities = world.velocities
        self.substeps += 1
        self.step_seconds += self.recorder.step(self.time)
        world.read()
        if self.recorder.begun and self.first_contact is None:
            self._refine(before, velocities, (begin, self.time))

    def _refine(self, before: Array, velocities: Array, times: tuple[float, float]) -> None:
        """Find the first of the contacts that began in the last substep.

        The velocities after the substep include the collision response already. So the benches'
        motion within it is taken from the `velocities` before the substep and from the change of
        the poses since `before`, on which the impact has no effect yet.
        """
        world = self._world
        begin, end = times
        substep = end - begin
        moved = pose_step(before, world.collided_poses)
        motion = Motion(before, substep * velocities, moved - substep * velocities)

        dragon = world.march.dragon
        begun = [motion.refined(dragon, contact, begin) for contact in self.recorder.begun]
        first = min(begun, key=lambda contact: contact.time)
        self.first_contact = first
        if world.settings.contacts == "stop":
            share = (first.time - begin) / substep
            rates = motion.rates(share) / substep
            self._record(first.time, motion.poses(share), rates, self._forces_at(first.time))

    def _forces_at(self, time: float) -> Array:
        """Forces in the joints at a contact, extrapolated: those of its substep have the impact."""
        *earlier, (end, _, _, forces) = self.frames
        if not earlier:
            return forces
        begin, _, _, before = earlier[-1]
        return np.abs(forces + (time - end) / (end - begin) * (forces - before))

    def _record(
        self, time: float, poses: Array, velocities: Array, forces: Array | None = None
    ) -> None:
        """Keep a frame, if it is not the last one again."""
        if not np.all(np.isfinite(poses) & np.isfinite(velocities)):
            raise DragonError(
                f"the chain flew apart before t = {time:.6g} s; a smaller substep may hold it"
            )
        if not self.frames or time > self.frames[-1][0]:
            forces = self._world.joint_forces if forces is None else forces
            self.frames.append((time, poses, velocities, forces))


def _waiting_head(world: World, total: int) -> Iterator[None]:
    """Prepare up to `total` substeps, as far as the curve goes; a blocked head waits."""
    while total > 0 and world.follow(_HEAD_LAG, _BRAKING):
        yield
        total -= 1


def _exact_head(world: World, total: int) -> Iterator[None]:
    """Prepare up to `total` substeps, as far as the curve goes; the head has its exact states."""
    firsts = range(1, total + 1, _BLOCK)
    numbers = (np.arange(first, min(first + _BLOCK, total + 1)) for first in firsts)
    batches: Any = (world.start + number * world.substep for number in numbers)
    for states in states_while_reachable(world.march, batches, 2):
        for row in range(len(states.times)):
            world.prepare(states, row)
            yield


def _provenance(world: World, until: float, substeps: int) -> dict[str, Any]:
    """Origin of a run of a world to at most `until`, s."""
    values = {
        "player": "pymunk",
        "guide": _guide_name(world.guide),
        "contacts": world.settings.contacts,
        "start": world.start,
        "until": until,
    }
    if world.guide.free_from is not None:
        values["free_from"] = int(world.guide.free_from)
    # Other settings only where they are not their defaults.
    settings = asdict(world.settings).items()
    changed = {name: value for name, value in settings if value != getattr(EngineSettings, name)}
    return {**values, **changed, "substeps": substeps, "versions": versions()}


def _guide_name(guide: PathGuide) -> str:
    """Name under which a guide is registered, otherwise that of its class."""
    kind = type(guide)
    names = {each: name for name, each in GUIDES.items()}
    return names.get(kind, kind.__name__)
