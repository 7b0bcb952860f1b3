"""The contents of a report as tables of bare values, for machines, and of short texts, for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

__all__ = [
    "NOTHING",
    "Column",
    "Table",
    "drift",
    "events",
    "events_in_words",
    "handles",
    "happenings",
    "near_misses",
    "number",
    "pair",
    "positions_by_time",
    "settings",
    "speeds_by_time",
    "vector",
    "windows",
]

Contents = Mapping[str, Any]

# What stands where there is no value.
NOTHING = "\N{EN DASH}"
# From here on a number is written with an exponent: no run is that long or large, but a damaged file can be.
HUGE = 1e9
# The engine reports at most two points for two benches; files of others may hold more.
USUAL_POINTS = 2
# Rows of a table that documents show: more than one looks through, and a page of half a megabyte.
SHOWN_ROWS = 1000


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    key : str
        Its name in a file, with the SI unit at the end.
    head : str
        Its name for people, with the unit of `scale`.
    decimals : int or None
        Digits after the point for people; None for text and whole numbers.
    scale : float
        What people see is the value times this: 1000 for mm.
    text : bool
        Whether it holds words, which start on the left.
    """

    key: str
    head: str
    decimals: int | None = None
    scale: float = 1.0
    text: bool = False


@dataclass(frozen=True)
class Table:
    """Rows of SI values, None where there is none."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Any, ...], ...]

    @property
    def texts(self) -> list[list[str]]:
        """The first `SHOWN_ROWS` rows as people read them."""
        return [
            [_shown(column, value) for column, value in zip(self.columns, row, strict=True)]
            for row in self.rows[:SHOWN_ROWS]
        ]

    @property
    def cut_note(self) -> str:
        """A sentence on the rows that `texts` leaves out; empty where it leaves none."""
        if len(self.rows) <= SHOWN_ROWS:
            return ""
        return f"These are the first {SHOWN_ROWS} of {len(self.rows)} rows; all are in the JSON and XLSX reports."


def number(value: float | None, decimals: int) -> str:
    """A number with so many digits after the point; never `-0`."""
    if value is None:
        return NOTHING
    # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
    return f"{value:.{decimals}e}" if abs(value) >= HUGE else f"{round(value, decimals) + 0.0:.{decimals}f}"


def vector(value: Sequence[float | None] | None, decimals: int) -> str:
    """A point or a direction, `(x, y)`."""
    return NOTHING if value is None else "(" + ", ".join(number(part, decimals) for part in value) + ")"


def pair(benches: Sequence[int] | None) -> str:
    """Two benches, `0 and 8`."""
    return NOTHING if benches is None else " and ".join(str(bench) for bench in benches)


def settings(values: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Names and values as text; names within names are joined by dots."""
    told: list[tuple[str, str]] = []
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            told += settings(value, f"{prefix}{name}.")
        else:
            told.append((prefix + name, _setting(value)))
    return told


def near_misses(contents: Contents) -> Table:
    """The exact model's near misses, in the order of time."""
    columns = (
        Column(key="time_s", head="time (s)", decimals=4),
        *_BENCHES,
        Column(key="gap_m", head="gap (mm)", decimals=3, scale=1e3),
    )
    found = contents["near_misses"] or ()
    return Table(columns, tuple((near["time"], *near["benches"], near["gap"]) for near in found))


def events(contents: Contents) -> Table:
    """Every callback, one row each, every coordinate in a column of its own."""
    return _moments(contents["events"], Column(key="phase", head="phase", text=True))


def happenings(contents: Contents) -> Table:
    """Near misses, the exact contact, the run's first one and every callback, by time; `what` says which it is."""
    found = [{"phase": "near_miss", **near} for near in contents["near_misses"] or ()]
    exact, first = contents["exact"], contents["first_contact"]
    if exact is not None and exact["status"] == "contact":
        found.append({"phase": "exact_contact", **exact, "points": [exact["point"]]})
    if first is not None:
        found.append({"phase": "first_contact", **first, "points": [first["point"]]})
    found += contents["events"]
    # What has no time, as in a damaged file, comes last.
    found.sort(key=lambda moment: math.inf if moment["time"] is None else moment["time"])
    table = _moments(found, Column(key="what", head="what", text=True))
    rows = ((*row, moment.get("gap")) for row, moment in zip(table.rows, found, strict=True))
    return Table((*table.columns, Column(key="gap_m", head="gap (mm)", decimals=3, scale=1e3)), tuple(rows))


def events_in_words(contents: Contents) -> Table:
    """Every callback with a point, a direction or a pair in one column each, as texts."""
    columns = (
        Column(key="time", head="time (s)"),
        Column(key="phase", head="phase", text=True),
        Column(key="benches", head="benches", text=True),
        Column(key="points", head="points (m)"),
        Column(key="normal", head="normal"),
        Column(key="depth", head="depth (mm)"),
        Column(key="relative_velocity", head="relative velocity (m/s)"),
        Column(key="impulse", head="impulse (N s)"),
    )
    rows = tuple(
        (
            number(event["time"], 4),
            event["phase"],
            pair(event["benches"]),
            " ".join(vector(point, 3) for point in event["points"]) or NOTHING,
            vector(event["normal"], 3),
            number(_scaled(event["depth"], 1e3), 3),
            vector(event["relative_velocity"], 3),
            vector(event["impulse"], 4),
        )
        for event in contents["events"]
    )
    return Table(columns, rows)


def windows(contents: Contents) -> Table:
    """When each pair touched; without an end where it still did when the run ended."""
    columns = (
        *_BENCHES,
        Column(key="begin_s", head="from (s)", decimals=4),
        Column(key="end_s", head="to (s)", decimals=4),
        Column(key="length_s", head="for (s)", decimals=4),
    )
    rows = []
    for window in contents["windows"]:
        begin, end = window["begin"], window["end"]
        rows.append((*window["benches"], begin, end, None if None in (begin, end) else end - begin))
    return Table(columns, tuple(rows))


def handles(contents: Contents) -> Table:
    """The tables' handles, one row for each at each time."""
    columns = (
        Column(key="time_s", head="time (s)", decimals=6),
        Column(key="handle", head="handle"),
        Column(key="x_m", head="x (m)", decimals=6),
        Column(key="y_m", head="y (m)", decimals=6),
        Column(key="speed_m_s", head="speed (m/s)", decimals=6),
    )
    found = contents["handles"]
    rows = (
        (time, handle, *place, speed)
        for time, places, speeds in zip(found["times"], found["positions"], found["speeds"], strict=True)
        for handle, place, speed in zip(found["numbers"], places, speeds, strict=True)
    )
    return Table(columns, tuple(rows))


def positions_by_time(contents: Contents) -> Table:
    """The paper's table 1: x and y of each handle, a column for each time."""
    found = contents["handles"]
    rows = tuple(
        (f"{handle} {axis}", *(places[row][coordinate] for places in found["positions"]))
        for row, handle in enumerate(found["numbers"])
        for coordinate, axis in enumerate(("x (m)", "y (m)"))
    )
    return Table(_by_time(contents), rows)


def speeds_by_time(contents: Contents) -> Table:
    """The paper's table 2: the speed of each handle, a column for each time."""
    found = contents["handles"]
    rows = tuple(
        (f"{handle} (m/s)", *(speeds[row] for speeds in found["speeds"])) for row, handle in enumerate(found["numbers"])
    )
    return Table(_by_time(contents), rows)


def drift(contents: Contents) -> Table:
    """The worst drift of every frame."""
    found = contents["drift"]
    columns = (
        Column(key="time_s", head="time (s)", decimals=3),
        Column(key="head_drift_m", head=f"first {found['head_benches']} benches (mm)", decimals=4, scale=1e3),
        Column(key="max_drift_m", head="any bench (mm)", decimals=4, scale=1e3),
    )
    return Table(columns, tuple(zip(found["times"], found["head_over_time"], found["max_over_time"], strict=True)))


def _moments(found: Sequence[Mapping[str, Any]], phase: Column) -> Table:
    """A row for each of `found`, whose keys are those of an event as far as they are there."""
    most = max([USUAL_POINTS, *(len(moment.get("points", ())) for moment in found)])
    columns = [Column(key="time_s", head="time (s)", decimals=6), phase, *_BENCHES]
    for which in range(1, most + 1):
        columns += _coordinates(f"point{which}", "m", f"point {which}")
    columns += [
        *_coordinates("normal", "", "normal"),
        Column(key="depth_m", head="depth (mm)", decimals=4, scale=1e3),
        *_coordinates("relative_velocity", "m_s", "relative velocity"),
        *_coordinates("impulse", "N_s", "impulse"),
    ]
    rows = []
    for moment in found:
        points = [*moment.get("points", ()), *[_NOWHERE] * most][:most]
        normal, velocity, impulse = (moment.get(name) or _NOWHERE for name in _VECTORS)
        places = (coordinate for point in points for coordinate in point)
        depth = moment.get("depth")
        rows.append((moment["time"], moment["phase"], *moment["benches"], *places, *normal, depth, *velocity, *impulse))
    return Table(tuple(columns), tuple(rows))


_VECTORS = ("normal", "relative_velocity", "impulse")
_NOWHERE = (None, None)
_BENCHES = (Column(key="bench_i", head="bench i"), Column(key="bench_j", head="bench j"))


def _coordinates(key: str, unit: str, head: str) -> Iterable[Column]:
    ending = f"_{unit}" if unit else ""
    shown = f" ({unit.replace('m_s', 'm/s').replace('_', ' ')})" if unit else ""
    return [Column(key=f"{key}_{axis}{ending}", head=f"{head} {axis}{shown}", decimals=6) for axis in ("x", "y")]


def _by_time(contents: Contents) -> tuple[Column, ...]:
    found = contents["handles"]
    heads = [f"{time:g} s" for time in found["times"]]
    if found["contact"] is not None:
        heads[-1] = f"{number(found['times'][-1], 6)} s"
    return (
        Column(key="handle", head="handle", text=True),
        *(Column(key=head, head=head, decimals=6) for head in heads),
    )


def _shown(column: Column, value: Any) -> str:
    if value is None:
        return NOTHING
    if column.decimals is None:
        return str(value)
    return number(_scaled(value, column.scale), column.decimals)


def _scaled(value: float | None, scale: float) -> float | None:
    return None if value is None else value * scale


def _setting(value: Any) -> str:
    if value is None:
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, list):
        return ", ".join(_setting(item) for item in value) or NOTHING
    return "none" if value == {} else str(value)
