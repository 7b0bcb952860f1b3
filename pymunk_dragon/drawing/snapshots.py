"""Samples a run or march at the times of a film: poses, velocities, impulses and contacts, as pictures need them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# What a picture or film is drawn from.
Source = Run | March
Vector = tuple[float, float]

# Frames whose poses are computed at once: enough to amortise the cost of a call, few enough to limit memory.
CHUNK_FRAMES = 32
# s: margin by which the search for a contact at the end of a film extends beyond the end.
CONTACT_MARGIN = 1e-6
# Times at which the extent of a dragon is sampled.
EXTENT_SAMPLES = 64
# Substeps: a contact callback is shown if it is at most this much older than the frame. The last substep, and a margin
# for rounding.
RECENT_SUBSTEPS = 1.5


@dataclass(frozen=True)
class Touch:
    """Contact of two benches: points in m, and the unit normal from the first bench to the second."""

    points: tuple[Vector, ...]
    normal: Vector


@dataclass(frozen=True)
class Snapshot:
    """State of a dragon of N benches at one time.

    `poses` (N, 3) are in m and rad. If an overlay needs them there are `velocities` (N + 1, 2) of the handles, m/s,
    `impulses` (N - 1,) in the joints, N s, and `touches`. In the exact model beside a run, `displaced` poses (N, 3)
    have the run's position errors, magnified, and `error` is the largest one, m, of those that decide the factor.
    """

    time: float
    poses: Array
    velocities: Array | None = None
    impulses: Array | None = None
    touches: tuple[Touch, ...] = ()
    displaced: Array | None = None
    error: float | None = None


@dataclass(frozen=True)
class Clip:
    """A run or march sampled at the F times of a film.

    `window` has the first and last time, s, of a run, or of the film of a march; `extent` (2, 2) the lower left and
    upper right corner, m, of the dragon's bounding box, for a fixed camera; `largest_impulse` is in N s;
    `magnification` is the factor of the position errors in the snapshots' `displaced` poses.
    """

    march: March
    model: str
    contact: Contact | None
    window: tuple[float, float]
    extent: Array | None
    largest_impulse: float
    snapshots: Iterator[Snapshot]
    magnification: float | None = None


def march_of(source: Source) -> March:
    """Return the march of a run, or a march itself."""
    return source.march if isinstance(source, Run) else source


def sample(source: Source, times: Array, needs: Collection[str] = (), *, extent: bool = False) -> Clip:
    """Sample `source` at the `times` (F,), s, of a film; `needs` has fields of `Snapshot`, beside the poses."""
    run = source if isinstance(source, Run) else None
    known = times if run is None else run.times
    samples = np.linspace(times[0], times[-1], min(EXTENT_SAMPLES, len(times)))
    return Clip(
        march=march_of(source),
        model=_model(run),
        contact=run.first_contact if run else None,
        window=(float(known[0]), float(known[-1])),
        extent=_extent(source, samples) if extent else None,
        largest_impulse=_largest_impulse(run, times) if run else 0.0,
        snapshots=snapshots(source, times, needs),
    )


def first_contact_until(march: March, start: float, until: float) -> FirstContact:
    """Search for the first contact of the exact model from `start` to `until`, s, including a contact at `until`."""
    found = first_contact(march, start=start, until=min(until + CONTACT_MARGIN, march.end))
    return replace(found, time=min(found.time, until))


def with_errors(clip: Clip, run: Run, times: Array, reach: float, length: float) -> Clip:
    """Return the clip of the march of `run` at `times` (F,), with its contact and the magnified errors of the run.

    The errors of the benches within `reach` m of the head decide the factor: the largest one is drawn about `length` m
    long. The factor is 1 for larger errors, and there is none if no bench has an error.
    """
    march, ends = run.march, run.times[[0, -1]]
    first, last = np.clip(times[[0, -1]], *ends).tolist()
    samples = np.linspace(first, last, min(EXTENT_SAMPLES, len(times)))
    exact = march.at(samples).poses
    near = np.linalg.norm(exact[-1, :, :2] - exact[-1, 0, :2], axis=-1) <= reach
    largest = float(np.linalg.norm((run.poses_at(samples) - exact)[:, near, :2], axis=-1).max())
    if run.first_contact is not None:
        clip = replace(clip, contact=first_contact_until(march, *ends.tolist()).contact)
    if largest == 0:
        return clip
    factor = max(1.0, float(f"{length / largest:.0e}"))

    def displaced(snapshot: Snapshot) -> Snapshot:
        if not ends[0] <= snapshot.time <= ends[1]:
            return snapshot
        errors = run.poses_at(snapshot.time)[0] - snapshot.poses
        errors[:, 2] = np.angle(np.exp(1j * errors[:, 2]))
        error = float(np.linalg.norm(errors[near, :2], axis=-1).max())
        return replace(snapshot, displaced=snapshot.poses + factor * errors, error=error)

    return replace(clip, snapshots=map(displaced, clip.snapshots), magnification=factor)


def snapshots(source: Source, times: Array, needs: Collection[str] = ()) -> Iterator[Snapshot]:
    """Yield the snapshots at `times` (F,), s. Times outside a run are clipped to its first or last time."""
    if isinstance(source, Run):
        times = np.clip(times, source.times[0], source.times[-1])
    contacts = _ContactTimeline(source) if isinstance(source, Run) and "touches" in needs else None
    for begin in range(0, len(times), CHUNK_FRAMES):
        for snapshot in _chunk(source, times[begin : begin + CHUNK_FRAMES], needs):
            yield replace(snapshot, touches=contacts.at(snapshot.time)) if contacts else snapshot


def _chunk(source: Source, times: Array, needs: Collection[str]) -> Iterator[Snapshot]:
    """Yield the snapshots at `times` (T,), without contacts."""
    velocities: Iterable[Array | None] = [None] * len(times)
    impulses: Iterable[Array | None] = [None] * len(times)
    if isinstance(source, March):
        states = source.at(times)
        poses, velocities = states.poses, states.velocities
    else:
        poses = source.poses_at(times)
        if "velocities" in needs:
            front, rear = source.march.dragon.hole_velocities(poses, source.pose_velocities_at(times))
            velocities = np.concatenate([front, rear[:, -1:]], axis=1)
        if "impulses" in needs and source.joint_impulses is not None:
            # Impulses are not interpolated.
            impulses = source.joint_impulses[_frames_before(source, times)]
    yield from map(Snapshot, times.tolist(), poses, velocities, impulses)


def _extent(source: Source, times: Array) -> Array:
    """Return the lower left and upper right corner (2, 2), m, of the dragon's bounding box over `times` (T,)."""
    dragon = march_of(source).dragon
    corners = np.concatenate([dragon.outlines(snapshot.poses).reshape(-1, 2) for snapshot in snapshots(source, times)])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def _model(run: Run | None) -> str:
    """Return the name of the model that computed a run, with its options; None is a march."""
    if run is None or run.player == "exact":
        return text("exact model")
    words = [text("engine")]
    if run.guide is not None:
        # A guide of the user's own has no other name.
        words.append({"none": text("no guide"), "rails": text("rails")}.get(run.guide, run.guide))
    if run.settings is not None and run.settings.contacts == "resolve":
        words.append(text("contacts resolved"))
    return text(", ").join(words)


def _frames_before(run: Run, times: Array) -> NDArray[np.intp]:
    """Return the numbers of the last frames of a run at or before `times`."""
    return np.searchsorted(run.times, times, side="right") - 1


def _largest_impulse(run: Run, times: Array) -> float:
    """Return the largest joint impulse, N s, of a run from the first to the last of `times` (F,)."""
    if run.joint_impulses is None:
        return 0.0
    first, last = _frames_before(run, np.clip(times[[0, -1]], run.times[0], run.times[-1]))
    return float(run.joint_impulses[first : last + 1].max())


class _ContactTimeline:
    """Contacts of a run's benches by time."""

    def __init__(self, run: Run) -> None:
        self._first = run.first_contact
        self._events = [event for event in run.events if event.points]
        self._recent = RECENT_SUBSTEPS * (run.substep or 0.0)
        pair = self._first.benches if self._first else None
        ends = (event.time for event in run.events if event.phase == "separate" and event.benches == pair)
        # The end of the first contact is known only if the engine continued after it.
        self._first_end = next(ends, math.inf)

    def at(self, time: float) -> tuple[Touch, ...]:
        """Return the contacts of the last substep's callbacks, and the refined first contact until it has callbacks."""
        begin, end = (bisect_right(self._events, t, key=lambda event: event.time) for t in (time - self._recent, time))
        last = {event.benches: event for event in self._events[begin:end]}
        touches = [Touch(event.points, event.normal) for event in last.values() if event.normal is not None]
        first = self._first
        if first is not None and first.benches not in last and first.time <= time < self._first_end:
            touches.append(Touch((first.point,), first.normal))
        return tuple(touches)
