"""Tables of a report: SI values for data files, formatted text for documents."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

__all__ = [
    "MISSING",
    "Column",
    "Table",
    "all_events",
    "drift",
    "events",
    "events_as_text",
    "format_number",
    "format_pair",
    "format_vector",
    "handles",
    "near_misses",
    "positions_by_time",
    "settings",
    "speeds_by_time",
    "windows",
]

Contents = Mapping[str, Any]

# Text of a missing value.
MISSING = "\N{EN DASH}"
# Magnitude from which numbers are written with an exponent: beyond any simulated run, but possible in a damaged file.
EXPONENT_THRESHOLD = 1e9
# Least number of contact points with columns of their own: the engine reports at most two for a pair of benches.
MIN_POINTS = 2
# Rows of a table in a document: more would not be read, and 1000 rows already are half a megabyte of HTML.
MAX_SHOWN_ROWS = 1000


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    key : str
        Name of the column in data files; ends in the SI unit.
    label : str
        Heading of the column in documents, with the unit after scaling.
    decimals : int or None
        Digits after the decimal point in documents; None for text and integers.
    scale : float
        Factor from the SI value to the displayed value: 1000 for mm.
    text : bool
        Whether the column holds text, which is aligned to the left.
    """

    key: str
    label: str
    decimals: int | None = None
    scale: float = 1.0
    text: bool = False


@dataclass(frozen=True)
class Table:
    """Rows of SI values; None for a missing value."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Any, ...], ...]

    @property
    def text_rows(self) -> list[list[str]]:
        """The first `MAX_SHOWN_ROWS` rows, formatted for documents."""
        return [
            [_cell_text(column, value) for column, value in zip(self.columns, row, strict=True)]
            for row in self.rows[:MAX_SHOWN_ROWS]
        ]

    @property
    def truncation_note(self) -> str:
        """A sentence on the rows that `text_rows` omits; empty if all rows are shown."""
        if len(self.rows) <= MAX_SHOWN_ROWS:
            return ""
        return f"These are the first {MAX_SHOWN_ROWS} of {len(self.rows)} rows; all are in the JSON and XLSX reports."


def format_number(value: float | None, decimals: int) -> str:
    """`value` with `decimals` digits after the decimal point; never `-0`."""
    if value is None:
        return MISSING
    if abs(value) >= EXPONENT_THRESHOLD:
        return f"{value:.{decimals}e}"
    # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


def format_vector(value: Sequence[float | None] | None, decimals: int) -> str:
    """A point or a direction as `(x, y)`."""
    return MISSING if value is None else "(" + ", ".join(format_number(part, decimals) for part in value) + ")"


def format_pair(benches: Sequence[int] | None) -> str:
    """Two benches as `0 and 8`."""
    return MISSING if benches is None else " and ".join(str(bench) for bench in benches)


def settings(values: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Names and values as text; nested names are joined by dots."""
    entries: list[tuple[str, str]] = []
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            entries += settings(value, f"{prefix}{name}.")
        else:
            entries.append((prefix + name, _setting_text(value)))
    return entries


def near_misses(contents: Contents) -> Table:
    """Near misses of the exact model, sorted by time."""
    columns = (
        Column(key="time_s", label="time (s)", decimals=4),
        *_BENCHES,
        Column(key="gap_m", label="gap (mm)", decimals=3, scale=1e3),
    )
    found = contents["near_misses"] or ()
    return Table(columns, tuple((near_miss["time"], *near_miss["benches"], near_miss["gap"]) for near_miss in found))


def events(contents: Contents) -> Table:
    """Collision callbacks, a row each, with a column for each coordinate."""
    return _event_table(contents["events"], Column(key="phase", label="phase", text=True))


def all_events(contents: Contents) -> Table:
    """Near misses, first contacts (exact model and run) and callbacks, by time; `what` is their type."""
    found = [{"phase": "near_miss", **near_miss} for near_miss in contents["near_misses"] or ()]
    exact, first = contents["exact"], contents["first_contact"]
    if exact is not None and exact["status"] == "contact":
        found.append({"phase": "exact_contact", **exact, "points": [exact["point"]]})
    if first is not None:
        found.append({"phase": "first_contact", **first, "points": [first["point"]]})
    found += contents["events"]
    # Events without a time, as in a damaged file, come last.
    found.sort(key=lambda event: math.inf if event["time"] is None else event["time"])
    table = _event_table(found, Column(key="what", label="what", text=True))
    rows = ((*row, event.get("gap")) for row, event in zip(table.rows, found, strict=True))
    return Table((*table.columns, Column(key="gap_m", label="gap (mm)", decimals=3, scale=1e3)), tuple(rows))


def events_as_text(contents: Contents) -> Table:
    """Collision callbacks as text, with points, vectors and pairs in one column each."""
    columns = (
        Column(key="time", label="time (s)"),
        Column(key="phase", label="phase", text=True),
        Column(key="benches", label="benches", text=True),
        Column(key="points", label="points (m)"),
        Column(key="normal", label="normal"),
        Column(key="depth", label="depth (mm)"),
        Column(key="relative_velocity", label="relative velocity (m/s)"),
        Column(key="impulse", label="impulse (N s)"),
    )
    rows = tuple(
        (
            format_number(event["time"], 4),
            event["phase"],
            format_pair(event["benches"]),
            " ".join(format_vector(point, 3) for point in event["points"]) or MISSING,
            format_vector(event["normal"], 3),
            format_number(_scaled(event["depth"], 1e3), 3),
            format_vector(event["relative_velocity"], 3),
            format_vector(event["impulse"], 4),
        )
        for event in contents["events"]
    )
    return Table(columns, rows)


def windows(contents: Contents) -> Table:
    """Contact windows of pairs; a window has no end if the benches were in contact when the run ended."""
    columns = (
        *_BENCHES,
        Column(key="begin_s", label="from (s)", decimals=4),
        Column(key="end_s", label="to (s)", decimals=4),
        Column(key="length_s", label="for (s)", decimals=4),
    )
    rows = []
    for window in contents["windows"]:
        begin, end = window["begin"], window["end"]
        rows.append((*window["benches"], begin, end, None if None in (begin, end) else end - begin))
    return Table(columns, tuple(rows))


def handles(contents: Contents) -> Table:
    """Positions and speeds of the reported handles, a row for each handle and time."""
    columns = (
        Column(key="time_s", label="time (s)", decimals=6),
        Column(key="handle", label="handle"),
        Column(key="x_m", label="x (m)", decimals=6),
        Column(key="y_m", label="y (m)", decimals=6),
        Column(key="speed_m_s", label="speed (m/s)", decimals=6),
    )
    found = contents["handles"]
    rows = (
        (time, handle, *position, speed)
        for time, positions, speeds in zip(found["times"], found["positions"], found["speeds"], strict=True)
        for handle, position, speed in zip(found["numbers"], positions, speeds, strict=True)
    )
    return Table(columns, tuple(rows))


def positions_by_time(contents: Contents) -> Table:
    """Table 1 of the paper: x and y of each handle, a column for each time."""
    found = contents["handles"]
    rows = tuple(
        (f"{handle} {axis}", *(positions[row][coordinate] for positions in found["positions"]))
        for row, handle in enumerate(found["numbers"])
        for coordinate, axis in enumerate(("x (m)", "y (m)"))
    )
    return Table(_time_columns(contents), rows)


def speeds_by_time(contents: Contents) -> Table:
    """Table 2 of the paper: the speed of each handle, a column for each time."""
    found = contents["handles"]
    rows = tuple(
        (f"{handle} (m/s)", *(speeds[row] for speeds in found["speeds"])) for row, handle in enumerate(found["numbers"])
    )
    return Table(_time_columns(contents), rows)


def drift(contents: Contents) -> Table:
    """Largest drift of each frame."""
    found = contents["drift"]
    columns = (
        Column(key="time_s", label="time (s)", decimals=3),
        Column(key="head_drift_m", label=f"first {found['head_benches']} benches (mm)", decimals=4, scale=1e3),
        Column(key="max_drift_m", label="any bench (mm)", decimals=4, scale=1e3),
    )
    return Table(columns, tuple(zip(found["times"], found["head_over_time"], found["max_over_time"], strict=True)))


def _event_table(found: Sequence[Mapping[str, Any]], phase: Column) -> Table:
    """A row for each event in `found`; keys of an event may be missing."""
    point_count = max([MIN_POINTS, *(len(event.get("points", ())) for event in found)])
    columns = [Column(key="time_s", label="time (s)", decimals=6), phase, *_BENCHES]
    for number in range(1, point_count + 1):
        columns += _coordinate_columns(f"point{number}", "m", f"point {number}")
    columns += [
        *_coordinate_columns("normal", "", "normal"),
        Column(key="depth_m", label="depth (mm)", decimals=4, scale=1e3),
        *_coordinate_columns("relative_velocity", "m_s", "relative velocity"),
        *_coordinate_columns("impulse", "N_s", "impulse"),
    ]
    rows = []
    for event in found:
        points = [*event.get("points", ()), *[_NO_VECTOR] * point_count][:point_count]
        normal, velocity, impulse = (event.get(name) or _NO_VECTOR for name in _VECTORS)
        coordinates = (coordinate for point in points for coordinate in point)
        depth = event.get("depth")
        common = (event["time"], event["phase"], *event["benches"])
        rows.append((*common, *coordinates, *normal, depth, *velocity, *impulse))
    return Table(tuple(columns), tuple(rows))


_VECTORS = ("normal", "relative_velocity", "impulse")
_NO_VECTOR = (None, None)
_BENCHES = (Column(key="bench_i", label="bench i"), Column(key="bench_j", label="bench j"))


def _coordinate_columns(key: str, unit: str, label: str) -> Iterable[Column]:
    """Columns of the x and y coordinates of a vector."""
    suffix = f"_{unit}" if unit else ""
    shown_unit = f" ({unit.replace('m_s', 'm/s').replace('_', ' ')})" if unit else ""
    return [Column(key=f"{key}_{axis}{suffix}", label=f"{label} {axis}{shown_unit}", decimals=6) for axis in ("x", "y")]


def _time_columns(contents: Contents) -> tuple[Column, ...]:
    """A column of handles and a column for each time; a contact time is last and has six decimals."""
    found = contents["handles"]
    labels = [f"{time:g} s" for time in found["times"]]
    if found["contact"] is not None:
        labels[-1] = f"{format_number(found['times'][-1], 6)} s"
    return (
        Column(key="handle", label="handle", text=True),
        *(Column(key=label, label=label, decimals=6) for label in labels),
    )


def _cell_text(column: Column, value: Any) -> str:
    if value is None:
        return MISSING
    if column.decimals is None:
        return str(value)
    return format_number(_scaled(value, column.scale), column.decimals)


def _scaled(value: float | None, scale: float) -> float | None:
    return None if value is None else value * scale


def _setting_text(value: Any) -> str:
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, list):
        return ", ".join(_setting_text(item) for item in value) or MISSING
    return "none" if value == {} else str(value)
