"""Text of a report, the same in Markdown and HTML: headline, subtitle, and sections with tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from pymunk_dragon._language import text
from pymunk_dragon.collision import NearMiss
from pymunk_dragon.model.contact import Contact, ContactEvent, ContactWindow, contact_text
from pymunk_dragon.reports.summary import VERSION, Summary, json_values

# Text of a missing value.
_MISSING = "\u2013"
# Rows of a table: more would not be read, and 1000 rows already are half a megabyte of HTML.
_MAX_ROWS = 1000
# Names of curves in sentences; others appear under their kind, or the name of their class.
_CURVES = {
    "Spiral": "spiral",
    "UTurn": "U-turn",
    "Sampled": "smooth path",
    "Composite": "path of several pieces",
}
_CURVES |= {"Line": "straight line", "Arc": "circular arc"}
# The sizes of a curve in sentences, and the players.
_SIZES = {
    "pitch": ", pitch {size} m",
    "radius": ", in a circle of {size} m",
    "length": " of {size} m",
}
_PLAYERS = {
    "pymunk": "played by Pymunk",
    "exact": "played by the exact model",
    None: "of an unknown player",
}
# Below the tables of a report.
NOTE = (
    "Metres, seconds and radians; x to the right, y up. A normal points from the first bench to the second; "
    "relative velocities and impulses are those of the second bench."
)
# Units of parameters and settings, where they have one.
_UNITS = dict.fromkeys(
    ("head_spacing", "body_spacing", "overhang", "width", "pitch", "radius", "length"), " m"
)
_UNITS |= dict.fromkeys(("start", "until", "substep", "frame_interval"), " s")
_UNITS |= {"start_s": " m", "drag": " 1/m", "head_force": " N"}

_Row = Sequence[str]
_Entry = TypeVar("_Entry")
# Headings of a table's columns, and the text of an entry in each.
_Cells = Mapping[str, Callable[[_Entry], str]]


class Table(NamedTuple):
    """A table of text, by default of names and values. Columns in `left` are aligned to the left."""

    rows: Sequence[_Row]
    heads: _Row = ("", "")
    left: Sequence[int] = (0, 1)
    note: str = ""


class Section(NamedTuple):
    """A section of a report: the keys of tables are subheadings, which may be empty."""

    key: str
    title: str
    note: str
    tables: Mapping[str, Table]


def headline(summary: Summary) -> str:
    """Result of the run in one line."""
    run, exact = summary.run, summary.exact
    if run.first_contact is not None:
        (i, j), time = run.first_contact.benches, _number(run.first_contact.time, 6, " s")
        return text("Benches {i} and {j} touch at {time}").format(i=i, j=j, time=time)
    begin, end = (_number(time, 3, " s") for time in run.times[[0, -1]].tolist())
    template = text("No contact from {begin} to {end}")
    if run.outcome == "unreachable":
        template = text("No contact until {end}, where the head reaches the end of the curve")
    elif run.player == "exact" and getattr(exact, "status", None) != "clear":
        # The exact player does not detect contacts, and the exact model does not exclude one.
        template = text("The dragon from {begin} to {end}")
    return template.format(begin=begin, end=end)


def subtitle(summary: Summary) -> str:
    """Dragon, speed, curve and player of the run in one line."""
    scenario, player = summary.scenario, json_values(summary.run.player)
    name = scenario["curve"]
    kind = summary.run.march.curve.kind or name.lower()
    own_name = kind.replace("-", " ")
    curve = text(_CURVES.get(name, own_name))
    for size, template in _SIZES.items():
        if scenario.get(size) is not None:
            curve += text(template).format(size=f"{scenario[size]:g}")
    return text("A dragon of {benches} benches at {speed} on a {curve}, {player}").format(
        benches=scenario["benches"],
        speed=_speed(scenario["speed"]),
        curve=curve,
        player=text(_PLAYERS.get(player, "played by {player}")).format(player=player),
    )


def sections(summary: Summary) -> list[Section]:
    """Sections of a report, in order."""
    near_misses: _Cells[NearMiss] = {
        text("time (s)"): lambda miss: _number(miss.time, 4),
        text("benches"): lambda miss: _pair(miss.benches),
        text("gap (mm)"): lambda miss: _number(miss.gap, 3, scale=1e3),
    }
    windows: _Cells[ContactWindow] = {
        text("benches"): lambda window: _pair(window.benches),
        text("from (s)"): lambda window: _number(window.begin, 4),
        text("to (s)"): lambda window: _number(window.end, 4),
        text("for (s)"): lambda window: _number(
            None if window.end is None else window.end - window.begin, 4
        ),
    }
    events: _Cells[ContactEvent] = {
        text("time (s)"): lambda event: _number(event.time, 4),
        text("phase"): lambda event: event.phase,
        text("benches"): lambda event: _pair(event.benches),
        text("points (m)"): lambda event: (
            " ".join(_vector(point, 3) for point in event.points) or _MISSING
        ),
        text("normal"): lambda event: _vector(event.normal, 3),
        text("depth (mm)"): lambda event: _number(event.depth, 3, scale=1e3),
        text("relative velocity (m/s)"): lambda event: _vector(event.relative_velocity, 3),
        text("impulse (N s)"): lambda event: _vector(event.impulse, 4),
    }
    near = text(
        "Small local minima of the distance between benches that are not neighbours, in the exact model."
    )
    times = text(
        "Pairs of benches in contact in the engine, at ends of substeps; without an end: to the last one."
    )
    error = text(
        "Distance of a bench's hole from the exact model's position, for the hole with the larger distance."
    )
    calls = text("Collision callbacks of the engine, in the order in which they came: {count}.")
    log = summary.run.events
    return [
        Section(
            "first-contact",
            text("First contact"),
            _comparison(summary),
            _contact(summary.run.first_contact),
        ),
        Section(
            "near-misses",
            text("Near misses"),
            near,
            _table(summary.near_misses or (), near_misses, left=(1,)),
        ),
        Section(
            "windows", text("Contact windows"), times, _table(log.windows(), windows, left=(0,))
        ),
        Section("drift", text("Position error"), error, {"": Table(_drift(summary))}),
        Section(
            "events", text("Events"), calls.format(count=len(log)), _table(log, events, left=(1, 2))
        ),
        provenance(summary),
    ]


def provenance(summary: Summary) -> Section:
    """Scenario, settings and versions of the run, under their names in Python and with all digits."""
    scenario = summary.scenario | {"speed": _speed(summary.scenario["speed"])}
    versions = json_values(summary.run.versions) | {text("report format"): VERSION}
    groups = {
        text("Scenario"): scenario,
        text("Settings"): summary.settings,
        text("Versions"): versions,
    }
    tables = {
        title: Table(
            [(name, _value(value) + _UNITS.get(name, "")) for name, value in group.items()]
        )
        for title, group in groups.items()
        if group
    }
    return Section("provenance", text("Provenance"), "", tables)


def _pair(benches: Sequence[int]) -> str:
    """Two benches as `0 and 8`."""
    return text("{i} and {j}").format(i=benches[0], j=benches[1])


def _comparison(summary: Summary) -> str:
    """Comparison of the run's first contact, or its absence, with the exact model."""
    run, exact = summary.run, summary.exact
    notes = [] if run.first_contact else [text("None in this run.")]
    if run.free_from == 1:
        notes.append(text("No guide kept this dragon on its path."))
    elif run.free_from is not None:
        free = text("No guide kept the benches from {bench} to the tail on the path.")
        notes.append(free.format(bench=run.free_from))
    if error := _time_error(summary):
        same = text("The same benches touch in the exact model; the contact of the run is {error}.")
        notes.append(same.format(error=error))
    if exact is not None and (run.player != "exact" or not run.first_contact):
        result = contact_text(exact.status, exact.benches, exact.point, exact.time, 9)
        notes.append(text("The exact model: {result}.").format(result=result))
    return " ".join(notes)


def _time_error(summary: Summary) -> str | None:
    """Time of the run's first contact relative to the exact one; None if the benches differ or are not all guided."""
    run = summary.run
    first = run.first_contact
    exact = summary.exact_contact
    guided = run.guide is not None and run.free_from is None
    if first is None or exact is None or first.benches != exact.benches or not guided:
        return None
    error = 1e3 * (first.time - exact.time)
    template = text("{error} ms early") if error < 0 else text("{error} ms late")
    return template.format(error=_number(abs(error), 3))


def _contact(contact: Contact | None) -> dict[str, Table]:
    """Table on the first contact of the run."""
    if contact is None:
        return {}
    rows = [
        (text("Benches that touch"), _pair(contact.benches)),
        (text("Time"), _number(contact.time, 6, " s")),
        (text("Point"), f"{_vector(contact.point, 6)} m"),
        (text("Normal, from the first to the second"), _vector(contact.normal, 6)),
        (text("Detected at the end of a substep"), _number(contact.raw_time, 6, " s")),
        (text("Depth when detected"), _size(contact.depth)),
    ]
    # Only the engine detects contacts by an overlap.
    return {"": Table(rows if contact.depth else rows[:4])}


def _table(
    entries: Sequence[_Entry], cells: _Cells[_Entry], left: Sequence[int]
) -> dict[str, Table]:
    """Table with a row for each entry, up to `_MAX_ROWS`, and a column for each of `cells`."""
    rows, note = [[cell(entry) for cell in cells.values()] for entry in entries[:_MAX_ROWS]], ""
    if len(entries) > _MAX_ROWS:
        template = text("These are the first {shown} of {count} rows; all are in the JSON report.")
        note = template.format(shown=_MAX_ROWS, count=len(entries))
    return {"": Table(rows, [*cells], left, note)}


def _drift(summary: Summary) -> list[_Row]:
    """Largest position errors with bench and time."""
    if summary.run.player == "exact":
        return []
    drift = summary.drift
    first = text("Largest of the first {count} benches").format(count=drift["head_benches"])
    rows: list[_Row] = []
    for label, name in ((first, "head"), (text("Largest of any bench"), "max")):
        value, peak = _size(drift[name]), drift[f"{name}_at"]
        if peak is not None:
            where = {"bench": peak["bench"], "time": _number(peak["time"], 3, " s")}
            value = text("{error} (bench {bench} at {time})").format(error=value, **where)
        rows.append((label, value))
    return rows


def _value(value: Any) -> str:
    """A JSON value as text; numbers have all their digits."""
    if isinstance(value, list):
        return str(value)[1:-1]
    shown = _MISSING if value is None else str(value)
    return shown.removesuffix(".0") if isinstance(value, float) else shown


def _speed(speed: float | list[list[float]]) -> str:
    """Speed of the head, or its range."""
    if not isinstance(speed, list):
        return f"{_value(speed)} m/s"
    least, most = (_value(bound(entry[1] for entry in speed)) for bound in (min, max))
    return text("{least} to {most} m/s").format(least=least, most=most)


def _number(value: float | None, decimals: int, unit: str = "", *, scale: float = 1.0) -> str:
    """`value * scale` with `decimals` digits after the decimal point, never `-0`, and the unit."""
    if value is None or not math.isfinite(value):
        return _MISSING
    # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
    return f"{round(value * scale, decimals) + 0.0:.{decimals}f}{unit}"


def _size(value: float) -> str:
    """A length in m, or in mm below 1 m."""
    return _number(value, 3, " m") if abs(value) >= 1 else _number(value, 3, " mm", scale=1e3)


def _vector(value: Sequence[float] | None, decimals: int) -> str:
    """A point or a direction as `(x, y)`."""
    return (
        _MISSING
        if value is None
        else "(" + ", ".join(_number(part, decimals) for part in value) + ")"
    )
