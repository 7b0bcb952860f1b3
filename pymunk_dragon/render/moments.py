"""What is to be seen at a time: where the benches are, and what acts on them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.run import Run

__all__ = ["Mark", "Moment", "Source", "Touch", "check_marks", "largest_impulse", "moments", "window"]

Array = NDArray[np.float64]
Vector = tuple[float, float]
Source = Run | March
# What may be laid over a picture.
Mark = Literal["contacts", "normals", "impulses", "velocities", "grid"]

# Frames whose poses are worked out at once: enough to make a call per frame cheap, little enough to stay small.
CHUNK = 32
# Substeps before a picture's time in which a callback counts as of that time: the last one, and rounding.
RECENT = 1.5


@dataclass(frozen=True)
class Touch:
    """Where two benches touch: points in m, and the unit normal from the first towards the second."""

    points: tuple[Vector, ...]
    normal: Vector


@dataclass(frozen=True)
class Moment:
    """A dragon of N benches at one time.

    Attributes
    ----------
    time : float
        s.
    poses : ndarray, shape (N, 3)
        Centres in m and angles in rad.
    velocities : ndarray, shape (N + 1, 2), or None
        Of the handles, m/s; where they are asked for.
    impulses : ndarray, shape (N - 1,), or None
        In the pivots, N s; where they are asked for.
    touches : tuple of Touch
        Where benches touch; where that is asked for.
    """

    time: float
    poses: Array
    velocities: Array | None = None
    impulses: Array | None = None
    touches: tuple[Touch, ...] = ()


def window(source: Source) -> tuple[float, float]:
    """First and last time, s, of which there are pictures."""
    if isinstance(source, Run):
        return float(source.times[0]), float(source.times[-1])
    return -np.inf, source.end


def check_marks(source: Source, marks: tuple[Mark, ...]) -> None:
    """Make sure that `source` knows what `marks` ask for.

    Raises
    ------
    ParameterError
        If one is no mark, or of something that only another player knows.
    """
    for mark in marks:
        word("show", mark, get_args(Mark))
        if mark == "impulses" and (isinstance(source, March) or source.joint_impulses is None):
            raise ParameterError("show", mark, "left out: only the engine's runs know their joint impulses")
        if mark in ("contacts", "normals") and isinstance(source, March):
            raise ParameterError("show", mark, "left out: a march knows no contacts, a run does")


def moments(source: Source, times: Array, marks: tuple[Mark, ...] = ()) -> Iterator[Moment]:
    """The moments at `times` (F,) in s, a few at once; outside a run, its first or last one again."""
    times = np.clip(times, *window(source)) if isinstance(source, Run) else times
    touches = _Touches(source) if isinstance(source, Run) and {"contacts", "normals"} & set(marks) else None
    for begin in range(0, len(times), CHUNK):
        for moment in _chunk(source, times[begin : begin + CHUNK], marks):
            yield replace(moment, touches=touches.at(moment.time)) if touches else moment


def _chunk(source: Source, times: Array, marks: tuple[Mark, ...]) -> Iterator[Moment]:
    nothing = [None] * len(times)
    velocities: Iterable[Array | None] = nothing
    impulses: Iterable[Array | None] = nothing
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
    """Velocities (T, N + 1, 2) of the benches' front holes and of the tail's rear hole."""
    front, rear = run.march.dragon.hole_velocities(run.poses_at(times), run.pose_velocities_at(times))
    return np.concatenate([front, rear[:, -1:]], axis=1)


def _impulses(run: Run, times: Array) -> Array:
    """Impulses (T, N - 1) of the frames before `times`, N s; between two frames nothing is known."""
    assert run.joint_impulses is not None
    impulses: Array = run.joint_impulses[_frames_before(run, times)]
    return impulses


def _frames_before(run: Run, times: Array) -> NDArray[np.intp]:
    return np.searchsorted(run.times, times, side="right") - 1


def largest_impulse(sources: Sequence[Source], times: Array) -> float:
    """The largest joint impulse of all in a film with frames at `times` (F,), N s; 0 where none is known."""
    largest = 0.0
    for source in sources:
        if isinstance(source, Run) and source.joint_impulses is not None:
            first, last = _frames_before(source, np.clip(times[[0, -1]], *window(source)))
            largest = max(largest, float(source.joint_impulses[first : last + 1].max()))
    return largest


class _Touches:
    """Where benches of a run touch at any time."""

    def __init__(self, run: Run) -> None:
        self._first = run.first_contact
        self._events = [event for event in run.events if event.points]
        substep = run.provenance.get("substep")
        # What a file that was changed by hand says may be anything.
        self._recent = RECENT * substep if isinstance(substep, int | float) else 0.0
        pair = self._first.benches if self._first else None
        ends = (event.time for event in run.events if event.phase == "separate" and event.benches == pair)
        # Only an engine that played on knows when the first contact ended.
        self._first_end = next(ends, math.inf)

    def at(self, time: float) -> tuple[Touch, ...]:
        """What the callbacks of the last substep told; and the first contact, which was refined, before its own."""
        begin, end = (bisect_right(self._events, t, key=lambda event: event.time) for t in (time - self._recent, time))
        last = {event.benches: event for event in self._events[begin:end]}
        touches = [Touch(event.points, event.normal) for event in last.values() if event.normal is not None]
        first = self._first
        if first is not None and first.benches not in last and first.time <= time < self._first_end:
            touches.append(Touch((first.point,), first.normal))
        return tuple(touches)
