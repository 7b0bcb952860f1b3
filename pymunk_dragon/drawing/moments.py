"""State of a dragon at one time as a picture needs it: poses, velocities, impulses and contacts."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

__all__ = ["Mark", "Moment", "Source", "Touch", "check_marks", "largest_impulse", "moments", "window"]

Array = NDArray[np.float64]
Vector = tuple[float, float]
# What a picture or film is drawn from.
Source = Run | March
# Names of the marks that can be drawn over a picture.
Mark = Literal["contacts", "normals", "impulses", "velocities", "grid"]

# Frames whose poses are computed at once: enough to amortise the cost of a call, few enough to limit memory.
CHUNK_FRAMES = 32
# Substeps: a contact callback is shown if it is at most this much older than the frame. The last substep, and a margin
# for rounding.
RECENT_SUBSTEPS = 1.5


@dataclass(frozen=True)
class Touch:
    """Contact of two benches: points in m, and the unit normal from the first bench to the second."""

    points: tuple[Vector, ...]
    normal: Vector


@dataclass(frozen=True)
class Moment:
    """State of a dragon of N benches at one time.

    Attributes
    ----------
    time : float
        Simulated time, s.
    poses : ndarray, shape (N, 3)
        Centres in m and angles in rad.
    velocities : ndarray, shape (N + 1, 2), or None
        Velocities of the handles, m/s, if a mark needs them.
    impulses : ndarray, shape (N - 1,), or None
        Impulses in the joints, N s, if a mark needs them.
    touches : tuple of Touch
        Contacts of benches, if a mark needs them.
    """

    time: float
    poses: Array
    velocities: Array | None = None
    impulses: Array | None = None
    touches: tuple[Touch, ...] = ()


def window(source: Source) -> tuple[float, float]:
    """Return the first and last time, s, at which a source can be drawn."""
    if isinstance(source, Run):
        return float(source.times[0]), float(source.times[-1])
    return -np.inf, source.end


def check_marks(source: Source, marks: tuple[Mark, ...]) -> None:
    """Check that `source` has the data that `marks` need.

    Raises
    ------
    ParameterError
        If a mark is unknown, or `source` has no data for it.
    """
    for mark in marks:
        word("show", mark, get_args(Mark))
        if mark == "impulses" and (isinstance(source, March) or source.joint_impulses is None):
            raise ParameterError("show", mark, "left out: only the engine's runs know their joint impulses")
        if mark in ("contacts", "normals") and isinstance(source, March):
            raise ParameterError("show", mark, "left out: a march knows no contacts, a run does")


def moments(source: Source, times: Array, marks: tuple[Mark, ...] = ()) -> Iterator[Moment]:
    """Yield the moments at `times` (F,), s. Times outside a run are clipped to its first or last time."""
    times = np.clip(times, *window(source)) if isinstance(source, Run) else times
    contacts = _ContactTimeline(source) if isinstance(source, Run) and {"contacts", "normals"} & set(marks) else None
    for begin in range(0, len(times), CHUNK_FRAMES):
        for moment in _chunk(source, times[begin : begin + CHUNK_FRAMES], marks):
            yield replace(moment, touches=contacts.at(moment.time)) if contacts else moment


def _chunk(source: Source, times: Array, marks: tuple[Mark, ...]) -> Iterator[Moment]:
    velocities: Iterable[Array | None] = [None] * len(times)
    impulses: Iterable[Array | None] = [None] * len(times)
    if isinstance(source, March):
        states = source.at(times)
        poses, velocities = states.poses, states.velocities
    else:
        poses = source.poses_at(times)
        if "velocities" in marks:
            velocities = _velocities(source, times)
        if "impulses" in marks:
            impulses = _impulses(source, times)
    yield from map(Moment, times.tolist(), poses, velocities, impulses)


def _velocities(run: Run, times: Array) -> Array:
    """Return the velocities (T, N + 1, 2), m/s, of the benches' front holes and of the tail's rear hole."""
    front, rear = run.march.dragon.hole_velocities(run.poses_at(times), run.pose_velocities_at(times))
    return np.concatenate([front, rear[:, -1:]], axis=1)


def _impulses(run: Run, times: Array) -> Array:
    """Return the impulses (T, N - 1), N s, of the last frames before `times`; impulses are not interpolated."""
    assert run.joint_impulses is not None
    impulses: Array = run.joint_impulses[_frames_before(run, times)]
    return impulses


def _frames_before(run: Run, times: Array) -> NDArray[np.intp]:
    return np.searchsorted(run.times, times, side="right") - 1


def largest_impulse(sources: Sequence[Source], times: Array) -> float:
    """Return the largest joint impulse, N s, of a film with frames at `times` (F,); 0 if no source has impulses."""
    largest = 0.0
    for source in sources:
        if isinstance(source, Run) and source.joint_impulses is not None:
            first, last = _frames_before(source, np.clip(times[[0, -1]], *window(source)))
            largest = max(largest, float(source.joint_impulses[first : last + 1].max()))
    return largest


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
