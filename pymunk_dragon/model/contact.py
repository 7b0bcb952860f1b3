"""Contacts between benches, from the engine or the exact model."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, Self, get_args, overload

from pymunk_dragon._display import table
from pymunk_dragon._language import text
from pymunk_dragon.errors import DragonError

Phase = Literal["begin", "pre_solve", "post_solve", "separate"]
PHASES: tuple[Phase, ...] = get_args(Phase)

Vector = tuple[float, float]


class _Record:
    """Base class of records that are read back from JSON."""

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """The record that `dataclasses.asdict` and JSON, which has lists for tuples, made `values` of.

        Raises
        ------
        DragonError
            If a value is impossible. Values of another structure raise a TypeError, a KeyError or a ValueError.
        """
        # Only dataclasses derive from this class.
        absent = {f.name for f in fields(cls) if f.default is None}  # type: ignore[arg-type]
        read: dict[str, Any] = {
            name: None if value is None and name in absent else _read(KINDS[name], value)
            for name, value in values.items()
        }
        first, second = read["benches"]
        if not 0 <= first < second:
            raise DragonError(f"{values['benches']!r} are no two benches")
        return cls(**read)


@dataclass(frozen=True, kw_only=True)
class Contact(_Record):
    """Contact of two benches that are not neighbours.

    Attributes
    ----------
    time : float
        Time of the contact, s.
    raw_time : float
        End of the substep in which the engine noticed, s.
    benches : tuple of int
        Their numbers, the smaller one first.
    point : tuple of float
        Point of the contact, m.
    normal : tuple of float
        Unit vector from the first bench towards the second.
    depth : float
        How deep they overlap at `raw_time`, m.

    Examples
    --------
    >>> contact = Contact(time=1.0, raw_time=1.01, benches=(0, 8), point=(2.0, 3.0), normal=(1.0, 0.0), depth=1e-4)
    >>> contact.benches
    (0, 8)
    """

    time: float
    raw_time: float
    benches: tuple[int, int]
    point: Vector
    normal: Vector
    depth: float


@dataclass(frozen=True, kw_only=True)
class ContactEvent(_Record):
    """One collision callback of the engine.

    Attributes
    ----------
    time : float
        End of the substep, s.
    phase : {"begin", "pre_solve", "post_solve", "separate"}
        Kind of callback. `post_solve` comes only where the engine solves the contact.
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

    Examples
    --------
    >>> ContactEvent(time=1.0, phase="separate", benches=(0, 8)).points
    ()
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
    """A time interval in which two benches touch.

    Attributes
    ----------
    benches : tuple of int
        Their numbers, the smaller one first.
    begin : float
        End of the substep in which they began to touch, s.
    end : float or None
        End of the substep in which they parted, s; None if they still touched when the run ended.
    """

    benches: tuple[int, int]
    begin: float
    end: float | None


@dataclass(frozen=True)
class ContactLog(Sequence[ContactEvent]):
    """All callback events of a run, in the order in which they came; a sequence of `ContactEvent`.

    Its text is the table of `windows`.

    Examples
    --------
    >>> log = ContactLog((
    ...     ContactEvent(time=1.0, phase="begin", benches=(0, 8)),
    ...     ContactEvent(time=2.5, phase="separate", benches=(0, 8)),
    ... ))
    >>> log
    ContactLog(2 events)
    >>> len(log.of("begin"))
    1
    >>> print(log)
    benches  touch from (s)  to (s)
      0   8           1.000  2.500
    """

    events: tuple[ContactEvent, ...] = ()

    def __repr__(self) -> str:
        return f"ContactLog({len(self.events)} events)"

    def __str__(self) -> str:
        rows = (
            ("{:3d} {:3d}".format(*one.benches), one.begin, text("the end") if one.end is None else f"{one.end:.3f}")
            for one in self.windows()
        )
        heads = (text("benches"), text("touch from (s)"), text("to (s)"))
        return "\n".join(table(heads, ("<7", "14.3f", ""), rows))

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
        """Time intervals in which each pair touched, ordered by the beginning."""
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


# Kind of each entry of a contact or an event: a type, the names that it may be, a tuple of kinds, or a list of one
# kind for any number of values.
KINDS: Mapping[str, Any] = {
    "time": float,
    "raw_time": float,
    "phase": frozenset(PHASES),
    "benches": (int, int),
    "point": (float, float),
    "points": [(float, float)],
    "normal": (float, float),
    "depth": float,
    "relative_velocity": (float, float),
    "impulse": (float, float),
}


def _read(kind: Any, value: Any) -> Any:
    """`value` from JSON, with tuples for lists, if it is of a kind of `KINDS`."""
    if isinstance(kind, list):
        return tuple(_read(kind[0], item) for item in value)
    if isinstance(kind, tuple):
        return tuple(_read(*pair) for pair in zip(kind, value, strict=True))
    if not (value in kind if isinstance(kind, frozenset) else type(value) in (int, kind) and math.isfinite(value)):
        raise DragonError(f"{value!r} is none of the values of a contact")
    return value


def contact_text(
    status: str, benches: tuple[int, int] | None, point: Vector | None, time: float, decimals: int = 6
) -> str:
    """When and where two benches first touch, in one line, or until which time none do.

    `decimals` is the number of decimals of the time of a contact that are certain.
    """
    if benches is None or point is None:
        if status == "unreachable":
            return text("no contact until t = {t:.6g} s, after which a handle has no position on the curve").format(
                t=time
            )
        return text("no contact until t = {t:.6g} s").format(t=time)
    values = {"i": benches[0], "j": benches[1], "t": f"{time:.{decimals}f}"}
    if status == "overlapping":
        return text("benches {i} and {j} overlap at the start, t = {t} s").format(**values)
    x, y = point
    return text("first contact at t = {t} s: benches {i} and {j} at ({x:.6f}, {y:.6f}) m").format(**values, x=x, y=y)
