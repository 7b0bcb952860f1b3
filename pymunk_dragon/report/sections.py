"""A report as people read it, whatever the format: a headline, the key figures, and one section after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pymunk_dragon.report import tables
from pymunk_dragon.report.tables import MISSING, Table, format_number, format_pair, format_vector

__all__ = ["Section", "headline", "key_figures", "sections", "subtitle"]

Contents = Mapping[str, Any]
# Names and values.
Facts = list[tuple[str, str]]

# Name and unit of what a scenario is made of.
SCENARIO_WORDS = {
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
    "start": ("Start of the head, along the curve", "m"),
}
# The package's curves as people call them; others are called by the name of their class.
CURVE_WORDS = {
    "UTurn": "U-turn",
    "Sampled": "smooth path",
    "Composite": "path of several pieces",
    "Line": "straight line",
    "Arc": "circular arc",
}


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of a report.

    Attributes
    ----------
    key : str
        Its name in links.
    title : str
        Its heading.
    notes : tuple of str
        Sentences.
    facts : mapping of str to list of (str, str)
        Names and values under their headings; a heading may be empty.
    tables : mapping of str to Table
        Tables under their headings.
    """

    key: str
    title: str
    notes: tuple[str, ...] = ()
    facts: Mapping[str, Facts] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)


def headline(contents: Contents) -> str:
    """What happened, in one line."""
    first, outcome, exact = contents["first_contact"], contents["outcome"], contents["exact"]
    if first is not None:
        return f"Benches {format_pair(first['benches'])} touch at {format_number(first['time'], 6)} s"
    begin, end = (f"{format_number(outcome[name], 3)} s" for name in ("from", "until"))
    if outcome["status"] == "unreachable":
        return f"No contact until {end}, where the curve leaves the head no place"
    if contents["player"] == "exact" and (exact is None or exact["status"] != "clear"):
        # Its player looks for no contacts, and nobody else could.
        return f"The dragon at {end}" if begin == end else f"The dragon from {begin} to {end}"
    return f"No contact from {begin} to {end}"


def subtitle(contents: Contents) -> str:
    """Who played what."""
    scenario, player = contents["scenario"], contents["player"]
    curve = CURVE_WORDS.get(scenario["curve"], scenario["curve"].lower())
    if scenario["pitch"] is not None:
        curve += f", pitch {scenario['pitch']:g} m"
    if "radius" in scenario:
        curve += f", in a circle of {scenario['radius']:g} m"
    if "length" in scenario:
        curve += f" of {scenario['length']:.4g} m"
    known = {"pymunk": "played by Pymunk", "exact": "placed by the exact model", None: "of an unknown player"}
    who = known.get(player, f"played by {player}")
    return f"A dragon of {scenario['benches']} benches at {_pace(scenario['speed'])} on a {curve}, {who}"


def key_figures(contents: Contents) -> Facts:
    """The few numbers to see first."""
    outcome, drift = contents["outcome"], contents["drift"]
    figures = [("simulated", f"{format_number(outcome['from'], 2)} to {format_number(outcome['until'], 2)} s")]
    late = _lateness(contents)
    if late is not None:
        figures.append(("against the exact first contact", late))
    gaps = [near for near in contents["near_misses"] or () if near["gap"] is not None]
    if gaps:
        nearest = min(gaps, key=lambda near: float(near["gap"]))
        figures.append((f"nearest miss, benches {format_pair(nearest['benches'])}", _length(nearest["gap"])))
    if contents["player"] != "exact":
        figures += [
            (f"largest drift, first {drift['head_benches']} benches", _length(drift["head"])),
            ("largest drift, any bench", _length(drift["max"])),
        ]
    return figures


def sections(contents: Contents) -> list[Section]:
    """All that a report says below its key figures."""
    return [
        _first_contact(contents),
        _near_misses(contents),
        _windows(contents),
        _drift(contents),
        _handles(contents),
        _events(contents),
        _origin(contents),
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
                ("Depth when noticed", _length(first["depth"])),
            ]
    if player != "exact" and exact is not None and exact["status"] == "contact":
        facts["In the exact model"] = [
            ("Benches", format_pair(exact["benches"])),
            ("Time", f"{format_number(exact['time'], 9)} s"),
            ("Point", f"{format_vector(exact['point'], 6)} m"),
            ("Normal, from the first to the second", format_vector(exact["normal"], 6)),
        ]
    return Section(key="first-contact", title="First contact", notes=_verdict(contents), facts=facts)


def _verdict(contents: Contents) -> tuple[str, ...]:
    """What the exact model makes of the run's first contact, or of there being none."""
    first, exact = contents["first_contact"], contents["exact"]
    found = "None in this run." if first is None else ""
    if exact is None:
        told = "The exact model was not asked: the run has no stretch of time over which the dragon has its place."
    elif contents["player"] == "exact":
        told = "" if first is not None else _exact_in_words(exact)
    elif contents["settings"].get("guide") == "none":
        told = f"Nobody kept this dragon on its path. On the path: {_exact_in_words(exact)}"
    elif first is None or exact["status"] != "contact":
        told = f"The exact model: {_exact_in_words(exact)}"
    elif first["benches"] != exact["benches"]:
        told = f"The exact model has another first contact: {_exact_in_words(exact)}"
    else:
        told = f"The exact model has the same benches touch; the run is {_lateness(contents) or 'of unknown time'}."
    return tuple(note for note in (found, told) if note)


def _exact_in_words(exact: Mapping[str, Any]) -> str:
    time, benches = f"{format_number(exact['time'], 6)} s", format_pair(exact["benches"])
    return {
        "contact": f"benches {benches} touch at {time}.",
        "clear": f"no bench touches another one until {time}.",
        "overlapping": f"benches {benches} overlap from the start on, at {time}.",
        "unreachable": f"no bench touches another one until {time}, where the curve leaves the dragon no place.",
    }[exact["status"]]


def _lateness(contents: Contents) -> str | None:
    """How far the run's first contact is from the exact one, where both are the same event."""
    first, exact = contents["first_contact"], contents["exact"]
    if contents["player"] == "exact" or contents["settings"].get("guide") == "none":
        return None
    if first is None or exact is None or exact["status"] != "contact" or first["benches"] != exact["benches"]:
        return None
    if first["time"] is None:
        return None
    late = 1e3 * (first["time"] - exact["time"])
    return f"{format_number(abs(late), 3)} ms {'early' if late < 0 else 'late'}"


def _near_misses(contents: Contents) -> Section:
    near = contents["near_misses"]
    if near is None:
        notes: tuple[str, ...] = ("Not looked for.",)
    elif not near:
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
        (f"Largest of the first {drift['head_benches']} benches", _placed(drift["head"], drift["head_at"])),
        ("Largest of any bench", _placed(drift["max"], drift["max_at"])),
    ]
    notes = ("How far the worse hole of a bench is from where the exact model has it.",)
    return Section(key="drift", title="Drift from the exact model", notes=notes, facts={"": facts})


def _handles(contents: Contents) -> Section:
    notes = ["Where the exact model has the handles of the paper's tables."]
    contact = contents["handles"]["contact"]
    if contact is not None:
        whose = {"exact": "the exact first contact", "run": "the run's first contact"}[contact]
        notes.append(f"The last column is the moment of {whose}.")
    found = {"Positions": tables.positions_by_time(contents), "Speeds": tables.speeds_by_time(contents)}
    return Section(key="handles", title="Handles", notes=tuple(notes), tables=found)


def _events(contents: Contents) -> Section:
    count = len(contents["events"])
    note = "No collision callback came."
    if count:
        callbacks = "collision callback" if count == 1 else "collision callbacks"
        note = f"{count} {callbacks} of the engine, in the order in which they came."
    return Section(key="events", title="Events", notes=(note,), tables={"": tables.events_as_text(contents)})


def _origin(contents: Contents) -> Section:
    scenario = []
    for name, value in contents["scenario"].items():
        label, unit = SCENARIO_WORDS[name]
        if value is not None:
            scenario.append((label, _pace(value) if name == "speed" else f"{_size(value)} {unit}".rstrip()))
    versions = [*tables.settings(contents["versions"]), ("report format", str(contents["version"]))]
    facts = {"Scenario": scenario, "Settings": tables.settings(contents["settings"]), "Versions": versions}
    told = {heading: found for heading, found in facts.items() if found}
    return Section(key="origin", title="Where it comes from", facts=told)


def _pace(speed: float | Sequence[Sequence[float]] | None) -> str:
    """The head's speed, or between which it is."""
    if speed is None:
        return "a changing speed"
    if isinstance(speed, Sequence):
        least, most = (pick(entry[1] for entry in speed) for pick in (min, max))
        return f"{least:g} to {most:g} m/s" if least < most else f"{most:g} m/s"
    return f"{speed:g} m/s"


def _size(value: Any) -> str:
    """A number, or one for each bench."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(_size, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _placed(drift: float | None, where: Mapping[str, Any] | None) -> str:
    if where is None:
        return MISSING
    return f"{_length(drift)} (bench {where['bench']} at {format_number(where['time'], 3)} s)"


def _length(value: float | None) -> str:
    """A length in m, or in mm where it is less than one."""
    if value is None:
        return MISSING
    return f"{format_number(value, 3)} m" if abs(value) >= 1 else f"{format_number(1e3 * value, 3)} mm"
