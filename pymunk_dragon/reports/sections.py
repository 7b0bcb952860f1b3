"""Text of a report, independent of the format: headline, subtitle, key figures and sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pymunk_dragon.reports import tables
from pymunk_dragon.reports.tables import MISSING, Table, format_number, format_pair, format_vector

__all__ = ["Section", "headline", "key_figures", "sections", "subtitle"]

Contents = Mapping[str, Any]
# Pairs of a name and a value.
Facts = list[tuple[str, str]]

# Label and unit of each key of a scenario.
SCENARIO_LABELS = {
    "benches": ("Benches", ""),
    "head_spacing": ("Head bench, hole to hole", "m"),
    "body_spacing": ("Other benches, hole to hole", "m"),
    "overhang": ("Hole to the end of a bench", "m"),
    "width": ("Width of a bench", "m"),
    "curve": ("Curve", ""),
    "pitch": ("Pitch", "m"),
    "turns": ("Start on turn", ""),
    "speed": ("Speed of the head", "m/s"),
    "radius": ("Radius of the turning circle", "m"),
    "ratio": ("First arc's radius over the second's", ""),
    "length": ("Length of the curve", "m"),
    "start_s": ("Start of the head, along the curve", "m"),
}
# Names of curve classes in sentences; other classes appear under the class name.
CURVE_NAMES = {
    "UTurn": "U-turn",
    "Sampled": "smooth path",
    "Composite": "path of several pieces",
    "Line": "straight line",
    "Arc": "circular arc",
}


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of a report.

    Attributes
    ----------
    key : str
        Identifier in links.
    title : str
        Heading.
    notes : tuple of str
        Sentences below the heading.
    facts : mapping of str to list of (str, str)
        Names and values by subheading; a subheading may be empty.
    tables : mapping of str to Table
        Tables by subheading; a subheading may be empty.
    """

    key: str
    title: str
    notes: tuple[str, ...] = ()
    facts: Mapping[str, Facts] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)


def headline(contents: Contents) -> str:
    """Result of the run in one line."""
    first, outcome, exact = contents["first_contact"], contents["outcome"], contents["exact"]
    if first is not None:
        return f"Benches {format_pair(first['benches'])} touch at {format_number(first['time'], 6)} s"
    begin, end = (f"{format_number(outcome[name], 3)} s" for name in ("start", "until"))
    if outcome["status"] == "unreachable":
        return f"No contact until {end}, where the curve leaves the head no place"
    if contents["player"] == "exact" and (exact is None or exact["status"] != "clear"):
        # The exact player does not detect contacts, and the exact model does not exclude one.
        return f"The dragon at {end}" if begin == end else f"The dragon from {begin} to {end}"
    return f"No contact from {begin} to {end}"


def subtitle(contents: Contents) -> str:
    """Dragon, speed, curve and player of the run in one line."""
    scenario, player = contents["scenario"], contents["player"]
    curve = CURVE_NAMES.get(scenario["curve"], scenario["curve"].lower())
    if scenario["pitch"] is not None:
        curve += f", pitch {scenario['pitch']:g} m"
    if "radius" in scenario:
        curve += f", in a circle of {scenario['radius']:g} m"
    if "length" in scenario:
        curve += f" of {scenario['length']:.4g} m"
    known = {"pymunk": "played by Pymunk", "exact": "placed by the exact model", None: "of an unknown player"}
    player_text = known.get(player, f"played by {player}")
    return f"A dragon of {scenario['benches']} benches at {_speed_text(scenario['speed'])} on a {curve}, {player_text}"


def key_figures(contents: Contents) -> Facts:
    """The most important numbers of the run."""
    outcome, drift = contents["outcome"], contents["drift"]
    figures = [("simulated", f"{format_number(outcome['start'], 2)} to {format_number(outcome['until'], 2)} s")]
    time_error = _time_error_text(contents)
    if time_error is not None:
        figures.append(("against the exact first contact", time_error))
    near_misses = [item for item in contents["near_misses"] or () if item["gap"] is not None]
    if near_misses:
        closest = min(near_misses, key=lambda item: float(item["gap"]))
        figures.append((f"nearest miss, benches {format_pair(closest['benches'])}", _length_text(closest["gap"])))
    if contents["player"] != "exact":
        figures += [
            (f"largest drift, first {drift['head_benches']} benches", _length_text(drift["head"])),
            ("largest drift, any bench", _length_text(drift["max"])),
        ]
    return figures


def sections(contents: Contents) -> list[Section]:
    """Sections of a report, in order."""
    return [
        _first_contact(contents),
        _near_misses(contents),
        _windows(contents),
        _drift(contents),
        _handles(contents),
        _events(contents),
        _provenance(contents),
    ]


def _first_contact(contents: Contents) -> Section:
    first, exact, player = contents["first_contact"], contents["exact"], contents["player"]
    facts: dict[str, Facts] = {}
    if first is not None:
        facts["In this run"] = [
            ("Benches", format_pair(first["benches"])),
            ("Time", f"{format_number(first['time'], 6)} s"),
            ("Point", f"{format_vector(first['point'], 6)} m"),
            ("Normal, from the first to the second", format_vector(first["normal"], 6)),
        ]
        if player != "exact":
            facts["In this run"] += [
                ("Noticed at the end of a substep", f"{format_number(first['raw_time'], 6)} s"),
                ("Depth when noticed", _length_text(first["depth"])),
            ]
    if player != "exact" and exact is not None and exact["status"] == "contact":
        facts["In the exact model"] = [
            ("Benches", format_pair(exact["benches"])),
            ("Time", f"{format_number(exact['time'], 9)} s"),
            ("Point", f"{format_vector(exact['point'], 6)} m"),
            ("Normal, from the first to the second", format_vector(exact["normal"], 6)),
        ]
    return Section(key="first-contact", title="First contact", notes=_comparison(contents), facts=facts)


def _comparison(contents: Contents) -> tuple[str, ...]:
    """Comparison of the run's first contact, or its absence, with the exact model."""
    first, exact = contents["first_contact"], contents["exact"]
    result = "None in this run." if first is None else ""
    if exact is None:
        text = "The exact model was not asked: the run has no stretch of time over which the dragon has its place."
    elif contents["player"] == "exact":
        text = "" if first is not None else _exact_text(exact)
    elif contents["settings"].get("guide") == "none":
        text = f"Nobody kept this dragon on its path. On the path: {_exact_text(exact)}"
    elif first is None or exact["status"] != "contact":
        text = f"The exact model: {_exact_text(exact)}"
    elif first["benches"] != exact["benches"]:
        text = f"The exact model has another first contact: {_exact_text(exact)}"
    else:
        text = (
            f"The exact model has the same benches touch; the run is {_time_error_text(contents) or 'of unknown time'}."
        )
    return tuple(note for note in (result, text) if note)


def _exact_text(exact: Mapping[str, Any]) -> str:
    """Result of the exact model as a sentence."""
    time, benches = f"{format_number(exact['time'], 6)} s", format_pair(exact["benches"])
    return {
        "contact": f"benches {benches} touch at {time}.",
        "clear": f"no bench touches another one until {time}.",
        "overlapping": f"benches {benches} overlap from the start on, at {time}.",
        "unreachable": f"no bench touches another one until {time}, where the curve leaves the dragon no place.",
    }[exact["status"]]


def _time_error_text(contents: Contents) -> str | None:
    """Time of the run's first contact relative to the exact one; None if the benches differ or a time is unknown."""
    first, exact = contents["first_contact"], contents["exact"]
    if contents["player"] == "exact" or contents["settings"].get("guide") == "none":
        return None
    if first is None or exact is None or exact["status"] != "contact" or first["benches"] != exact["benches"]:
        return None
    if first["time"] is None:
        return None
    error_ms = 1e3 * (first["time"] - exact["time"])
    return f"{format_number(abs(error_ms), 3)} ms {'early' if error_ms < 0 else 'late'}"


def _near_misses(contents: Contents) -> Section:
    found = contents["near_misses"]
    if found is None:
        notes: tuple[str, ...] = ("Not looked for.",)
    elif not found:
        notes = ("None on the way.",)
    else:
        notes = ("How near benches that are not neighbours come without touching, in the exact model.",)
    return Section(key="near-misses", title="Near misses", notes=notes, tables={"": tables.near_misses(contents)})


def _windows(contents: Contents) -> Section:
    windows, first = contents["windows"], contents["first_contact"]
    if contents["player"] == "exact":
        note = "The exact model tells when a contact begins, not when it ends."
    elif not windows:
        note = "No bench touched another one."
    elif len(windows) == 1 and first is not None and windows[0]["end"] is None:
        note = "The run ended within its first contact, so nobody knows how long it would have lasted."
    else:
        note = "When which two benches touched, from the first contact on; times are the ends of substeps."
    return Section(key="windows", title="Contact windows", notes=(note,), tables={"": tables.windows(contents)})


def _drift(contents: Contents) -> Section:
    drift = contents["drift"]
    if contents["player"] == "exact":
        return Section(key="drift", title="Drift from the exact model", notes=("The exact model itself was playing.",))
    facts = [
        (f"Largest of the first {drift['head_benches']} benches", _drift_text(drift["head"], drift["head_at"])),
        ("Largest of any bench", _drift_text(drift["max"], drift["max_at"])),
    ]
    notes = ("How far the worse hole of a bench is from where the exact model has it.",)
    return Section(key="drift", title="Drift from the exact model", notes=notes, facts={"": facts})


def _handles(contents: Contents) -> Section:
    notes = ["Where the exact model has the handles of the paper's tables."]
    contact = contents["handles"]["contact"]
    if contact is not None:
        source = {"exact": "the exact first contact", "run": "the run's first contact"}[contact]
        notes.append(f"The last column is the moment of {source}.")
    by_time = {"Positions": tables.positions_by_time(contents), "Speeds": tables.speeds_by_time(contents)}
    return Section(key="handles", title="Handles", notes=tuple(notes), tables=by_time)


def _events(contents: Contents) -> Section:
    count = len(contents["events"])
    note = "No collision callback came."
    if count:
        callbacks = "collision callback" if count == 1 else "collision callbacks"
        note = f"{count} {callbacks} of the engine, in the order in which they came."
    return Section(key="events", title="Events", notes=(note,), tables={"": tables.events_as_text(contents)})


def _provenance(contents: Contents) -> Section:
    scenario = []
    for name, value in contents["scenario"].items():
        label, unit = SCENARIO_LABELS[name]
        if value is not None:
            scenario.append((label, _speed_text(value) if name == "speed" else f"{_value_text(value)} {unit}".rstrip()))
    versions = [*tables.settings(contents["versions"]), ("report format", str(contents["version"]))]
    facts = {"Scenario": scenario, "Settings": tables.settings(contents["settings"]), "Versions": versions}
    given = {heading: pairs for heading, pairs in facts.items() if pairs}
    return Section(key="origin", title="Where it comes from", facts=given)


def _speed_text(speed: float | Sequence[Sequence[float]] | None) -> str:
    """Speed of the head, or its range."""
    if speed is None:
        return "a changing speed"
    if isinstance(speed, Sequence):
        least, most = (bound(entry[1] for entry in speed) for bound in (min, max))
        return f"{least:g} to {most:g} m/s" if least < most else f"{most:g} m/s"
    return f"{speed:g} m/s"


def _value_text(value: Any) -> str:
    """A number, or the numbers of all benches."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(_value_text, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _drift_text(drift: float | None, location: Mapping[str, Any] | None) -> str:
    """Drift with its bench and time."""
    if location is None:
        return MISSING
    return f"{_length_text(drift)} (bench {location['bench']} at {format_number(location['time'], 3)} s)"


def _length_text(value: float | None) -> str:
    """A length in m, or in mm below 1 m."""
    if value is None:
        return MISSING
    return f"{format_number(value, 3)} m" if abs(value) >= 1 else f"{format_number(1e3 * value, 3)} mm"
