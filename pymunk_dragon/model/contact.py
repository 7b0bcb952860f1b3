"""Contacts between benches, from the engine or the exact model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar, get_args

import numpy as np

from pymunk_dragon._checks import MAX_COORDINATE, finite, numbers, whole, word
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model._display import table

Phase = Literal["begin", "pre_solve", "post_solve", "separate"]

_Vector = tuple[float, float]

_Kind = TypeVar("_Kind")

# Largest number in a file, by entry: as for a run's poses, m, where pictures draw it.
_LIMITS = {
    "point": MAX_COORDINATE,
    "points": MAX_COORDINATE,
    "normal": 2.0,
    "depth": MAX_COORDINATE,
}
# Largest number of the other entries: runs store such values in single precision.
_MAX_VALUE = float(np.finfo(np.float32).max)


@dataclass(frozen=True, kw_only=True)
class Contact:
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
        Overlap at `raw_time`, m.

    Examples
    --------
    >>> where = {"point": (2.0, 3.0), "normal": (1.0, 0.0), "depth": 1e-4}
    >>> Contact(time=1.0, raw_time=1.01, benches=(0, 8), **where).benches
    (0, 8)
    """

    time: float
    raw_time: float
    benches: tuple[int, int]
    point: _Vector
    normal: _Vector
    depth: float


@dataclass(frozen=True, kw_only=True)
class ContactEvent:
    """One collision callback of the engine; `separate` has no more than time and benches.

    Attributes
    ----------
    time : float
        End of the substep, s.
    phase : {"begin", "pre_solve", "post_solve", "separate"}
        Kind of callback. `post_solve` comes only where the engine solves the contact.
    benches : tuple of int
        The smaller number first.
    points : tuple of tuple of float
        One or two contact points, m.
    normal : tuple of float or None
        Unit vector from the first bench towards the second.
    depth : float or None
        Overlap, m.
    relative_velocity : tuple of float or None
        Velocity of the second bench relative to the first, at the middle of the points, m/s.
    impulse : tuple of float or None
        Impulse on the second bench, N s; only in `post_solve`.

    Examples
    --------
    >>> ContactEvent(time=1.0, phase="separate", benches=(0, 8)).points
    ()
    """

    time: float
    phase: Phase
    benches: tuple[int, int]
    points: tuple[_Vector, ...] = ()
    normal: _Vector | None = None
    depth: float | None = None
    relative_velocity: _Vector | None = None
    impulse: _Vector | None = None


@dataclass(frozen=True, kw_only=True)
class ContactWindow:
    """Time interval in which two benches touch, as ends of substeps, s.

    `end` is None if it lasts beyond the run.
    """

    benches: tuple[int, int]
    begin: float
    end: float | None


class ContactLog(tuple[ContactEvent, ...]):
    """All callback events of a run, in the order in which they came.

    It is a tuple whose text is the table of `windows`.

    Examples
    --------
    >>> log = ContactLog((
    ...     ContactEvent(time=1.0, phase="begin", benches=(0, 8)),
    ...     ContactEvent(time=2.5, phase="separate", benches=(0, 8)),
    ... ))
    >>> log
    ContactLog(2 events)
    >>> print(log)
    benches  touch from (s)  to (s)
      0   8           1.000  2.500
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return f"ContactLog({len(self)} events)"

    def __str__(self) -> str:
        rows = []
        for window in self.windows():
            end = text("the end") if window.end is None else f"{window.end:.3f}"
            rows.append(("{:3d} {:3d}".format(*window.benches), window.begin, end))
        heads = (text("benches"), text("touch from (s)"), text("to (s)"))
        return "\n".join(table(heads, ("<7", "14.3f", ""), rows))

    def windows(self) -> list[ContactWindow]:
        """Time intervals in which each pair touched, ordered by the beginning."""
        open_since: dict[tuple[int, int], float] = {}
        windows = []
        for event in self:
            pair = event.benches
            if event.phase == "begin":
                open_since[pair] = event.time
            elif event.phase == "separate" and pair in open_since:
                begin = open_since.pop(pair)
                windows.append(ContactWindow(benches=pair, begin=begin, end=event.time))

        for pair, begin in open_since.items():
            windows.append(ContactWindow(benches=pair, begin=begin, end=None))
        return sorted(windows, key=lambda window: (window.begin, window.benches))


def contact_text(
    status: str,
    benches: tuple[int, int] | None,
    point: _Vector | None,
    time: float,
    decimals: int = 6,
) -> str:
    """When and where two benches first touch, or until which time none do.

    A time of contact has so many `decimals`.
    """
    if benches is None or point is None:
        if status != "unreachable":
            return text("no contact until t = {t:.6g} s", t=time)
        lost = text(
            "no contact until t = {t:.6g} s, after which a handle has no position on the curve"
        )
        return lost.format(t=time)

    values = {"i": benches[0], "j": benches[1], "t": f"{time:.{decimals}f}"}
    if status == "overlapping":
        return text("benches {i} and {j} overlap at the start, t = {t} s", **values)
    x, y = point
    first = text("first contact at t = {t} s: benches {i} and {j} at ({x:.6f}, {y:.6f}) m")
    return first.format(**values, x=x, y=y)


def read_contact(kind: type[_Kind], values: Mapping[str, Any], benches: int) -> _Kind:
    """Record of a contact among `benches`, from JSON of its `asdict`; an error if it is none."""
    first, second = values["benches"]
    whole("benches", first, 0, benches - 2)
    whole("benches", second, first + 1, benches - 1)
    read: dict[str, Any] = {"benches": (first, second)}
    for name, value in values.items():
        # What may be absent has None as its default.
        absent = value is None and getattr(kind, name, 0) is None
        if name != "benches":
            read[name] = None if absent else _read(name, value)
    return kind(**read)


def _read(name: str, value: Any) -> Any:
    """An entry of a record, checked; JSON has lists for tuples."""
    if name == "phase":
        return word(name, value, get_args(Phase))
    limit = _LIMITS.get(name, _MAX_VALUE)
    if name in ("time", "raw_time", "depth"):
        return finite(name, value, -limit, limit, "")

    vectors = numbers(name, value or np.empty((0, 2)), 2)
    axes = 2 if name == "points" else 1
    if vectors.ndim != axes or not (np.abs(vectors) <= limit).all():
        raise ParameterError(name, value, f"numbers x, y within {limit:g}")
    rows = vectors.tolist()
    return tuple(map(tuple, rows)) if axes == 2 else tuple(rows)
