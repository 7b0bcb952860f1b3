"""Contacts between benches, from the engine or the exact model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args, overload

__all__ = ["PHASES", "Contact", "ContactEvent", "ContactLog", "ContactWindow", "Phase"]

Phase = Literal["begin", "pre_solve", "post_solve", "separate"]
PHASES: tuple[Phase, ...] = get_args(Phase)

Vector = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Contact:
    """Two benches that are not neighbours touch.

    Attributes
    ----------
    time : float
        When they touch, s.
    raw_time : float
        End of the substep in which the engine noticed, s.
    benches : tuple of int
        Their numbers, the smaller one first.
    point : tuple of float
        Where they touch, m.
    normal : tuple of float
        Unit vector from the first bench towards the second.
    depth : float
        How deep they overlap at `raw_time`, m.
    """

    time: float
    raw_time: float
    benches: tuple[int, int]
    point: Vector
    normal: Vector
    depth: float


@dataclass(frozen=True, kw_only=True)
class ContactEvent:
    """One collision callback of the engine.

    Attributes
    ----------
    time : float
        End of the substep, s.
    phase : {"begin", "pre_solve", "post_solve", "separate"}
        Which callback. `post_solve` comes only where the engine solves the contact.
    benches : tuple of int
        The smaller number first.
    points : tuple of tuple of float
        One or two contact points, m; none in `separate`.
    normal : tuple of float or None
        Unit vector from the first bench towards the second; None in `separate`.
    depth : float or None
        Deepest overlap of the two, m, positive where they overlap; None in `separate`.
    relative_velocity : tuple of float or None
        Velocity of the second bench relative to the first, at the middle of the points, m/s; None in `separate`.
    impulse : tuple of float or None
        Impulse on the second bench, N s; only in `post_solve`, None elsewhere.
    """

    time: float
    phase: Phase
    benches: tuple[int, int]
    points: tuple[Vector, ...] = ()
    normal: Vector | None = None
    depth: float | None = None
    relative_velocity: Vector | None = None
    impulse: Vector | None = None


@dataclass(frozen=True, kw_only=True)
class ContactWindow:
    """A time interval in which two benches touch; `end` is None if they still touched when the run ended."""

    benches: tuple[int, int]
    begin: float
    end: float | None


@dataclass(frozen=True)
class ContactLog(Sequence[ContactEvent]):
    """All callback events of a run, in the order in which they came."""

    events: tuple[ContactEvent, ...] = ()

    def __len__(self) -> int:
        return len(self.events)

    @overload
    def __getitem__(self, index: int) -> ContactEvent: ...
    @overload
    def __getitem__(self, index: slice) -> ContactLog: ...
    def __getitem__(self, index: int | slice) -> ContactEvent | ContactLog:
        if isinstance(index, slice):
            return ContactLog(self.events[index])
        return self.events[index]

    def __iter__(self) -> Iterator[ContactEvent]:
        return iter(self.events)

    def of(self, phase: Phase) -> ContactLog:
        """The events of one phase."""
        return ContactLog(tuple(event for event in self.events if event.phase == phase))

    def windows(self) -> list[ContactWindow]:
        """When each pair touched, ordered by the beginning."""
        open_since: dict[tuple[int, int], float] = {}
        windows = []
        for event in self.events:
            if event.phase == "begin":
                open_since[event.benches] = event.time
            elif event.phase == "separate" and event.benches in open_since:
                begin = open_since.pop(event.benches)
                windows.append(ContactWindow(benches=event.benches, begin=begin, end=event.time))
        still = [ContactWindow(benches=pair, begin=begin, end=None) for pair, begin in open_since.items()]
        return sorted(windows + still, key=lambda window: (window.begin, window.benches))
