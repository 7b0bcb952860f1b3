"""Text of a report, the same in Markdown and HTML: headline, subtitle, and sections with tables."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pymunk_dragon._language import text
from pymunk_dragon.collision import NearMiss
from pymunk_dragon.model.contact import ContactLog, ContactWindow, contact_text
from pymunk_dragon.reports.summary import VERSION, Summary, json_values

# Text of a missing value.
_MISSING = "\u2013"
# Rows of a table: more would not be read, and 1000 rows already are half a megabyte of HTML.
_MAX_ROWS = 1000
# Names of curves in sentences; others appear under their kind, or the name of their class.
_CURVES = {
    "UTurn": "U-turn",
    "Sampled": "smooth path",
    "Composite": "path of several pieces",
    "Line": "straight line",
    "Arc": "circular arc",
}
# Sizes of a curve in sentences.
_SIZES = {
    "pitch": ", pitch {size} m",
    "radius": ", in a circle of {size} m",
    "length": " of {size} m",
}
# Players in sentences.
_PLAYERS = {
    "pymunk": "played by Pymunk",
    "exact": "played by the exact model",
    None: "of an unknown player",
}
# Columns of the table of events.
_EVENT_HEADS = (
    "time (s)",
    "phase",
    "benches",
    "points (m)",
    "normal",
    "depth (mm)",
    "relative velocity (m/s)",
    "impulse (N s)",
)
# Text below the tables of a report.
NOTE = (
    "Metres, seconds and radians; x to the right, y up. "
    "A normal points from the first bench to the second; "
    "relative velocities and impulses are those of the second bench."
)
# Units of parameters and settings, where they have one.
_UNITS = dict.fromkeys(
    ("head_spacing", "body_spacing", "overhang", "width", "pitch", "radius", "length"), " m"
)
_UNITS |= dict.fromkeys(("start", "until", "substep", "frame_interval"), " s")
_UNITS |= {"start_s": " m", "drag": " 1/m", "ground_drag": " 1/m", "head_force": " N"}

_Row = Sequence[str]


class Table(NamedTuple):
    """A table of text, by default of names and values.

    Columns in `left` are aligned to the left.
    """

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
    run = summary.run
    contact = run.first_contact
    if contact is not None:
        i, j = contact.benches
        time = _number(contact.time, 6, " s")
        return text("Benches {i} and {j} touch at {time}", i=i, j=j, time=time)

    exact = summary.exact
    if run.outcome == "unreachable":
        template = text("No contact until {end}, where the head reaches the end of the curve")
    elif run.is_exact_march and (exact is None or exact.status != "clear"):
        # The exact player does not detect contacts, and the exact model does not exclude one.
        template = text("The dragon from {begin} to {end}")
    else:
        template = text("No contact from {begin} to {end}")
    begin, end = (_number(time, 3, " s") for time in run.interval)
    return template.format(begin=begin, end=end)


def subtitle(summary: Summary) -> str:
    """Dragon, speed, curve and player of the run in one line."""
    scenario = summary.scenario
    name = scenario["curve"]
    kind = summary.run.march.curve.kind or name.lower()
    own_name = kind.replace("-", " ")
    curve = text(_CURVES.get(name, own_name))
    for size, template in _SIZES.items():
        if scenario.get(size) is not None:
            curve += text(template, size=f"{scenario[size]:g}")

    player = json_values(summary.run.player)
    played = text(_PLAYERS.get(player, "played by {player}"), player=player)
    if summary.run.is_pulled:
        played = text("pulled without a guide, by the exact model")
    speed = _speed(scenario["speed"])
    line = text(
        "A dragon of {benches} benches at {speed} on a {curve}, {player}",
        benches=scenario["benches"],
        speed=speed,
        curve=curve,
        player=played,
    )
    if times := _contact_times(summary):
        engine = _number(times[0], 6, " s")
        exact = _number(times[1], 9, " s")
        line += text(
            "; {engine} is the engine's time of contact, {exact} the exact one",
            engine=engine,
            exact=exact,
        )
    return line


def _contact_times(summary: Summary) -> tuple[float, float] | None:
    """Times of the first contact in the engine and in the exact model, s.

    None unless all benches were guided to the same contact: the difference is then an error.
    """
    run = summary.run
    contact = run.first_contact
    exact = summary.exact_contact
    if not (run.guide and run.free_from is None and contact and exact):
        return None
    if contact.benches != exact.benches:
        return None
    return contact.time, exact.time


def sections(summary: Summary) -> list[Section]:
    """Sections of a report, in order."""
    log = summary.run.events
    return [
        _first_contact(summary),
        *([] if summary.run.is_pulled else [_near_misses(summary.near_misses or ())]),
        _windows(log.windows()),
        _position_errors(summary),
        _events(log),
        provenance(summary),
    ]


def provenance(summary: Summary) -> Section:
    """Scenario, settings and versions of the run, by their names in Python, with all digits."""
    scenario = dict(summary.scenario)
    scenario["speed"] = _speed(scenario["speed"])
    versions = json_values(summary.run.versions)
    versions[text("report format")] = VERSION
    groups = {"Scenario": scenario, "Settings": summary.settings, "Versions": versions}

    tables = {}
    for title, group in groups.items():
        rows = []
        for name, value in group.items():
            rows.append((name, _value(value) + _UNITS.get(name, "")))
        if rows:
            tables[text(title)] = Table(rows)
    return Section("provenance", text("Provenance"), "", tables)


def _first_contact(summary: Summary) -> Section:
    """First contact of the run, and its comparison with the exact model."""
    contact = summary.run.first_contact
    tables = {}
    exact_time = []
    if times := _contact_times(summary):
        exact_time.append((text("Time in the exact model"), _number(times[1], 9, " s")))
    if contact is not None:
        rows = [
            (text("Benches that touch"), _pair(contact.benches)),
            (text("Time"), _number(contact.time, 6, " s")),
            *exact_time,
            (text("Point"), f"{_vector(contact.point, 6)} m"),
            (text("Normal, from the first to the second"), _vector(contact.normal, 6)),
        ]
        # Only the engine detects contacts by an overlap.
        if contact.depth and summary.run.player != "exact":
            detected = _number(contact.raw_time, 6, " s")
            rows.append((text("Detected at the end of a substep"), detected))
            rows.append((text("Depth when detected"), _size(contact.depth)))
        tables[""] = Table(rows)
    return Section("first-contact", text("First contact"), _comparison(summary), tables)


def _near_misses(misses: Sequence[NearMiss]) -> Section:
    """Near misses of the exact model."""
    note = text(
        "Small local minima of the distance between benches that are not neighbours, "
        "in the exact model."
    )
    return Section("near-misses", text("Near misses"), note, {"": near_miss_table(misses)})


def near_miss_table(misses: Sequence[NearMiss]) -> Table:
    """Table of near misses."""
    rows = []
    for miss in misses[:_MAX_ROWS]:
        gap = _number(miss.gap, 3, scale=1e3)
        rows.append([_number(miss.time, 4), _pair(miss.benches), gap])
    heads = ("time (s)", "benches", "gap (mm)")
    return _cut(heads, rows, len(misses), left=(1,))[""]


def _windows(windows: Sequence[ContactWindow]) -> Section:
    """Time intervals in which pairs of benches touch in the engine."""
    note = text(
        "Pairs of benches in contact in the engine, at ends of substeps; "
        "without an end: to the last one."
    )
    rows = []
    for window in windows[:_MAX_ROWS]:
        duration = None if window.end is None else window.end - window.begin
        row = [_pair(window.benches)]
        for time in (window.begin, window.end, duration):
            row.append(_number(time, 4))
        rows.append(row)
    heads = ("benches", "from (s)", "to (s)", "for (s)")
    tables = _cut(heads, rows, len(windows), left=(0,))
    return Section("windows", text("Contact windows"), note, tables)


def _events(log: ContactLog) -> Section:
    """Collision callbacks of the engine."""
    note = text(
        "Collision callbacks of the engine, in the order in which they came: {count}.",
        count=len(log),
    )
    rows = []
    for event in log[:_MAX_ROWS]:
        points = " ".join(_vector(point, 3) for point in event.points)
        row = [_number(event.time, 4), event.phase, _pair(event.benches)]
        row += [points or _MISSING, _vector(event.normal, 3)]
        row.append(_number(event.depth, 3, scale=1e3))
        row += [_vector(event.relative_velocity, 3), _vector(event.impulse, 4)]
        rows.append(row)
    tables = _cut(_EVENT_HEADS, rows, len(log), left=(1, 2))
    return Section("events", text("Events"), note, tables)


def _pair(benches: Sequence[int]) -> str:
    """Two benches as `0 and 8`."""
    return text("{i} and {j}", i=benches[0], j=benches[1])


def _comparison(summary: Summary) -> str:
    """Comparison of the run's first contact, or its absence, with the exact model."""
    run = summary.run
    exact = summary.exact
    contact = run.first_contact
    notes = [] if contact else [text("None in this run.")]
    if run.free_from == 1:
        notes.append(text("No guide kept this dragon on its path."))
    elif run.free_from is not None:
        free = text(
            "No guide kept the benches from {bench} to the tail on the path.", bench=run.free_from
        )
        notes.append(free)
    elif times := _contact_times(summary):
        late = 1e3 * (times[0] - times[1])
        error = text(
            "{error} ms early" if late < 0 else "{error} ms late", error=_number(abs(late), 3)
        )
        same = text(
            "The same benches touch in the exact model; the contact of the run is {error}.",
            error=error,
        )
        notes.append(same)

    if exact is not None and not (run.is_exact_march and contact):
        result = contact_text(exact.status, exact.benches, exact.point, exact.time, 9)
        if summary.run.is_pulled:
            notes.append(text("With all benches on the path: {result}.", result=result))
        else:
            notes.append(text("The exact model: {result}.", result=result))
    return " ".join(notes)


def _cut(heads: _Row, rows: Sequence[_Row], count: int, left: Sequence[int]) -> dict[str, Table]:
    """Table of the first rows of `count`, whose headings are translated here."""
    note = ""
    if count > len(rows):
        note = text(
            "These are the first {shown} of {count} rows; all are in the JSON report.",
            shown=len(rows),
            count=count,
        )
    return {"": Table(rows, [text(head) for head in heads], left, note)}


def _position_errors(summary: Summary) -> Section:
    """Largest position errors with bench and time; a run of the exact model has none.

    Benches that are pulled exactly have distances from the path, which are no errors.
    """
    title = text("Position error")
    note = text(
        "Distance of a bench's hole from the exact model's position at the same time, "
        "for the hole with the larger distance."
    )
    if summary.run.is_pulled:
        title = text("Distance from the march")
        note = text(
            "Distance of a bench's hole from its position with all benches on the path, "
            "for the hole with the larger distance."
        )
    drift = summary.drift
    first = text("Largest of the first {count} benches", count=drift["head_benches"])
    labels = {"head": first, "max": text("Largest of any bench")}

    rows = []
    for name, label in labels.items() if not summary.run.is_exact_march else ():
        error = _size(drift[name])
        peak = drift[f"{name}_at"]
        if peak is not None:
            time = _number(peak["time"], 3, " s")
            bench = peak["bench"]
            error = text("{error} (bench {bench} at {time})", error=error, bench=bench, time=time)
        rows.append((label, error))
    return Section("drift", title, note, {"": Table(rows)})


def _value(value: Any) -> str:
    """A JSON value as text; numbers have all their digits."""
    if isinstance(value, list):
        return str(value)[1:-1]
    if value is None:
        return _MISSING
    shown = str(value)
    return shown.removesuffix(".0") if isinstance(value, float) else shown


def _speed(speed: float | list[list[float]]) -> str:
    """Speed of the head, or its range."""
    if not isinstance(speed, list):
        return f"{_value(speed)} m/s"
    speeds = [entry[1] for entry in speed]
    least = _value(min(speeds))
    most = _value(max(speeds))
    return text("{least} to {most} m/s", least=least, most=most)


def _number(value: float | None, decimals: int, unit: str = "", *, scale: float = 1.0) -> str:
    """`value * scale` with `decimals` digits after the decimal point, never `-0`, and the unit."""
    if value is None or not math.isfinite(value):
        return _MISSING
    return f"{value * scale:z.{decimals}f}{unit}"


def _size(value: float) -> str:
    """A length in m, or in mm below 1 m."""
    return _number(value, 3, " m") if abs(value) >= 1 else _number(value, 3, " mm", scale=1e3)


def _vector(value: Sequence[float] | None, decimals: int) -> str:
    """A point or a direction as `(x, y)`."""
    if value is None:
        return _MISSING
    parts = ", ".join(_number(part, decimals) for part in value)
    return f"({parts})"
