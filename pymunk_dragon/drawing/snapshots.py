"""States of a run or march at the times of a film, as pictures need them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.model.contact import ContactEvent
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# What a picture or film is drawn from.
Source = Run | March

# Frames whose poses are computed at once: enough to amortise the cost of a call, few enough to limit memory.
_CHUNK_FRAMES = 32
# s: margin by which the search for a contact at the end of a film extends beyond the end.
_CONTACT_MARGIN = 1e-6
# Times at which the extent of a dragon, and the position errors of a run, are sampled.
_SAMPLES = 64
# Substeps: a contact callback is shown if it is at most this much older than the frame. The last substep, and a margin
# for rounding.
_RECENT_SUBSTEPS = 1.5


@dataclass(frozen=True)
class Snapshot:
    """State of a dragon of N benches at one time.

    `poses` (N, 3) are in m and rad. If an overlay needs them there are `velocities` (N + 1, 2) of the handles, m/s,
    `impulses` (N - 1,) in the joints, N s, and `touches`, with points and normals. In the exact model beside a run,
    `displaced` poses (N, 3) have the run's position errors, magnified, and `error` is the largest one, m, of those that
    decide the factor.
    """

    time: float
    poses: Array
    velocities: Array | None = None
    impulses: Array | None = None
    touches: tuple[ContactEvent, ...] = ()
    displaced: Array | None = None
    error: float | None = None


def march_of(source: Source) -> March:
    """Return the march of a run, or a march itself."""
    return source.march if isinstance(source, Run) else source


def first_contact_until(march: March, start: float, until: float) -> FirstContact:
    """Search for the first contact of the exact model from `start` to `until`, s, including a contact at `until`."""
    found = first_contact(march, start=start, until=min(until + _CONTACT_MARGIN, march.end))
    return replace(found, time=min(found.time, until))


def snapshots(source: Source, times: Array, needs: Collection[str] = ()) -> Iterator[Snapshot]:
    """Yield the snapshots at `times` (F,), s; before and after a run, those of its first and last time.

    `needs` has the fields that are filled beside the poses.
    """
    for chunk in np.split(times, range(_CHUNK_FRAMES, len(times), _CHUNK_FRAMES)):
        if isinstance(source, Run):
            yield from _of_run(source, np.clip(chunk, source.times[0], source.times[-1]), needs)
        else:
            states = source.at(chunk)
            yield from map(Snapshot, chunk.tolist(), states.poses, states.velocities)


def _of_run(run: Run, times: Array, needs: Collection[str]) -> Iterator[Snapshot]:
    """Yield the snapshots of a run at `times` (T,), which are within the run."""
    poses = run.poses_at(times)
    fields = [_FIELDS[need](run, times, poses) for need in needs]
    for time, pose, *values in zip(times.tolist(), poses, *fields, strict=True):
        yield Snapshot(time, pose, **dict(zip(needs, values, strict=True)))


def _velocities(run: Run, times: Array, poses: Array) -> Array:
    front, rear = run.march.dragon.hole_velocities(poses, run.pose_velocities_at(times))
    return np.concatenate([front, rear[:, -1:]], axis=1)


def _impulses(run: Run, times: Array, _: Array) -> Array:
    """Return the impulses of the frames before, which are not interpolated."""
    assert run.joint_impulses is not None  # Other runs are refused.
    return run.joint_impulses[np.searchsorted(run.times, times, side="right") - 1]


def _touches(run: Run, times: Array, _: Array) -> Iterator[tuple[ContactEvent, ...]]:
    """Yield the last callback of each contact in the last substep; before all callbacks, the refined first contact."""
    for time in times.tolist():
        since = time - _RECENT_SUBSTEPS * (run.substep or 0.0)
        begin, end = (bisect_right(run.events, t, key=lambda event: event.time) for t in (since, time))
        last = {event.benches: event for event in run.events[begin:end] if event.normal}
        yield tuple(last.values()) if end > 0 else _refined(run, time)


def _refined(run: Run, time: float) -> tuple[ContactEvent, ...]:
    first = run.first_contact
    if first is None or time < first.time:
        return ()
    points, normal = (first.point,), first.normal
    return (ContactEvent(time=time, phase="begin", benches=first.benches, points=points, normal=normal),)


# Functions of a run, T times and the poses then, which return a field of each snapshot.
_FIELDS: Mapping[str, Callable[[Run, Array, Array], Iterable[Any]]] = {
    "velocities": _velocities,
    "impulses": _impulses,
    "touches": _touches,
}


def largest_impulse(source: Source, times: Array) -> float:
    """Return the largest joint impulse, N s, of a run of the engine during the film; 0 of another source."""
    if isinstance(source, March) or source.joint_impulses is None:
        return 0.0
    first, last = np.searchsorted(source.times, times[[0, -1]], side="right")
    return float(source.joint_impulses[max(first - 1, 0) : last].max())


def extent(source: Source, times: Array) -> tuple[Array, Array]:
    """Return the lower left and upper right corner (2,), m, of the dragon's bounding box over `times` (F,)."""
    states = snapshots(source, np.linspace(times[0], times[-1], min(_SAMPLES, len(times))))
    corners = np.concatenate([march_of(source).dragon.outlines(state.poses).reshape(-1, 2) for state in states])
    return corners.min(axis=0), corners.max(axis=0)


def with_errors(
    states: Iterator[Snapshot], run: Run, times: Array, reach: float
) -> tuple[Iterator[Snapshot], float | None]:
    """Return the states of the march of `run` at `times` (F,) with the run's magnified errors, and their factor.

    The largest error of the benches within `reach` m of the head is drawn as long as the width of a bench, or with an
    infinite reach as a bench. The factor is 1 for larger errors, and there is none if no bench has an error.
    """
    dragon, (begin, end) = run.march.dragon, run.times[[0, -1]].tolist()
    first, last = np.clip(times[[0, -1]], begin, end).tolist()
    samples = np.linspace(first, last, min(_SAMPLES, len(times)))
    exact = run.march.at(samples).poses
    near = np.linalg.norm(exact[-1, :, :2] - exact[-1, 0, :2], axis=-1) <= reach
    largest = float(np.linalg.norm((run.poses_at(samples) - exact)[:, near, :2], axis=-1).max())
    if largest == 0:
        return states, None
    length = float(dragon.spacings.min() if reach == math.inf else dragon.widths.min())
    factor = max(1.0, float(f"{length / largest:.0e}"))

    def displaced(state: Snapshot) -> Snapshot:
        if not begin <= state.time <= end:
            return state
        errors = run.poses_at(state.time)[0] - state.poses
        errors[:, 2] = np.angle(np.exp(1j * errors[:, 2]))
        error = float(np.linalg.norm(errors[near, :2], axis=-1).max())
        return replace(state, displaced=state.poses + factor * errors, error=error)

    return map(displaced, states), factor
