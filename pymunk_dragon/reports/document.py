"""Text of a report, the same in all document formats: headline, subtitle, key figures and sections."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.reports import tables
from pymunk_dragon.reports.summary import VERSION, Peak, Summary
from pymunk_dragon.reports.tables import MISSING, Table, format_length, format_number, format_pair, format_vector

# Pairs of a name and a value.
Facts = list[tuple[str, str]]

# Significant digits of the parameters of a scenario.
SCENARIO_DIGITS = 6
# Significant digits of settings, whose precision is unknown.
SETTING_DIGITS = 10


@dataclass(frozen=True)
class Section:
    """A section of a report: notes are sentences; the keys of facts and tables are subheadings, which may be empty."""

    key: str
    title: str
    notes: Sequence[str] = ()
    facts: Mapping[str, Facts] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)


def headline(summary: Summary) -> str:
    """Result of the run in one line."""
    run, exact = summary.run, summary.exact
    if run.first_contact is not None:
        (i, j), time = run.first_contact.benches, _time_text(run.first_contact.time, 6)
        return text("Benches {i} and {j} touch at {time}").format(i=i, j=j, time=time)
    begin, end = (_time_text(float(time), 3) for time in run.times[[0, -1]])
    if run.outcome == "unreachable":
        return text("No contact until {end}, where the head reaches the end of the curve").format(end=end)
    if summary.player == "exact" and (exact is None or exact.status != "clear"):
        # The exact player does not detect contacts, and the exact model does not exclude one.
        if begin == end:
            return text("The dragon at {time}").format(time=end)
        return text("The dragon from {begin} to {end}").format(begin=begin, end=end)
    return text("No contact from {begin} to {end}").format(begin=begin, end=end)


def subtitle(summary: Summary) -> str:
    """Dragon, speed, curve and player of the run in one line."""
    scenario = summary.scenario
    curve = _curve_name(scenario["curve"])
    if scenario["pitch"] is not None:
        curve += text(", pitch {pitch} m").format(pitch=f"{scenario['pitch']:g}")
    if "radius" in scenario:
        curve += text(", in a circle of {radius} m").format(radius=f"{scenario['radius']:g}")
    if "length" in scenario:
        curve += text(" of {length} m").format(length=f"{scenario['length']:.4g}")
    known = {
        "pymunk": text("played by Pymunk"),
        "exact": text("played by the exact model"),
        None: text("of an unknown player"),
    }
    player = known.get(summary.player) or text("played by {player}").format(player=summary.player)
    return text("A dragon of {benches} benches at {speed} on a {curve}, {player}").format(
        benches=scenario["benches"], speed=_speed_text(scenario["speed"]), curve=curve, player=player
    )


def _curve_name(kind: str) -> str:
    """Name of a curve class in sentences; other classes appear under the class name."""
    known = {
        "Spiral": text("spiral"),
        "UTurn": text("U-turn"),
        "Sampled": text("smooth path"),
        "Composite": text("path of several pieces"),
        "Line": text("straight line"),
        "Arc": text("circular arc"),
    }
    return known.get(kind, kind.lower())


def key_figures(summary: Summary) -> Facts:
    """The most important numbers of the run."""
    begin, end = summary.run.times[[0, -1]].tolist()
    figures = [
        (text("simulated"), text("{begin} to {end}").format(begin=format_number(begin, 2), end=_time_text(end, 2)))
    ]
    if time_error := _time_error_text(summary):
        figures.append((text("against the exact first contact"), time_error))
    if summary.near_misses:
        closest = min(summary.near_misses, key=lambda miss: miss.gap)
        name = text("closest near miss, benches {pair}").format(pair=format_pair(closest.benches))
        figures.append((name, format_length(closest.gap)))
    if summary.player != "exact":
        drift = summary.drift
        figures += [
            (
                text("largest position error, first {count} benches").format(count=drift.head_benches),
                format_length(drift.head),
            ),
            (text("largest position error, any bench"), format_length(drift.max)),
        ]
    return figures


def sections(summary: Summary) -> list[Section]:
    """Sections of a report, in order."""
    return [
        Section("first-contact", text("First contact"), _comparison(summary), facts=_contacts(summary)),
        Section(
            "near-misses", text("Near misses"), [_near_miss_note(summary)], tables={"": tables.near_misses(summary)}
        ),
        Section("windows", text("Contact windows"), [_window_note(summary)], tables={"": tables.windows(summary)}),
        _drift(summary),
        Section("handles", text("Handles"), _handle_notes(summary), tables=tables.handles_by_time(summary)),
        Section("events", text("Events"), [_event_note(summary)], tables={"": tables.events_as_text(summary)}),
        provenance(summary),
    ]


def provenance(summary: Summary) -> Section:
    """Scenario, settings and versions of the run."""
    flags = {name: (text.rstrip("."), "") for name, (_, text) in summary.run.march.curve.flags.items()}
    labels = flags | _scenario_labels()
    scenario = []
    for name, value in summary.scenario.items():
        label, unit = labels[name]
        if value is not None:
            size = _speed_text(value) if name == "speed" else f"{_value_text(value, SCENARIO_DIGITS)} {unit}".rstrip()
            scenario.append((label, size))
    versions = [*_settings(summary.versions), (text("report format"), str(VERSION))]
    facts = {
        text("Scenario"): scenario,
        text("Settings"): _settings(summary.settings),
        text("Versions"): versions,
    }
    given = {heading: pairs for heading, pairs in facts.items() if pairs}
    return Section("provenance", text("Provenance"), facts=given)


def _scenario_labels() -> dict[str, tuple[str, str]]:
    """Label and unit of each key of a scenario."""
    return {
        "benches": (text("Benches"), ""),
        "head_spacing": (text("Head bench, hole to hole"), "m"),
        "body_spacing": (text("Other benches, hole to hole"), "m"),
        "overhang": (text("Hole to the end of a bench"), "m"),
        "width": (text("Width of a bench"), "m"),
        "curve": (text("Curve"), ""),
        "pitch": (text("Pitch"), "m"),
        "turns": (text("Start on turn"), ""),
        "speed": (text("Speed of the head"), "m/s"),
        "radius": (text("Radius of the turning circle"), "m"),
        "ratio": (text("First arc's radius over the second's"), ""),
        "length": (text("Length of the curve"), "m"),
        "start_s": (text("Start of the head, along the curve"), "m"),
    }


def _contacts(summary: Summary) -> dict[str, Facts]:
    """First contacts of the run and of the exact model."""
    first, exact, facts = summary.run.first_contact, summary.exact, {}
    if first is not None:
        here = text("In this run")
        facts[here] = _contact_facts(first, 6)
        if summary.player != "exact":
            facts[here] += [
                (text("Detected at the end of a substep"), _time_text(first.raw_time, 6)),
                (text("Depth when detected"), format_length(first.depth)),
            ]
    if summary.player != "exact" and exact is not None and exact.status == "contact":
        facts[text("In the exact model")] = _contact_facts(exact, 9)
    return facts


def _contact_facts(contact: Contact | FirstContact, decimals: int) -> Facts:
    """A contact as facts; `decimals` are those of its time."""
    return [
        (text("Benches that touch"), format_pair(contact.benches)),
        (text("Time"), _time_text(contact.time, decimals)),
        (text("Point"), f"{format_vector(contact.point, 6)} m"),
        (text("Normal, from the first to the second"), format_vector(contact.normal, 6)),
    ]


def _comparison(summary: Summary) -> list[str]:
    """Comparison of the run's first contact, or its absence, with the exact model."""
    first, exact = summary.run.first_contact, summary.exact
    notes = [text("None in this run.")] if first is None else []
    if exact is None:
        notes.append(
            text("No result of the exact model: the run has no time interval in which the dragon is on the curve.")
        )
    elif not summary.guided:
        notes.append(
            text("No guide kept this dragon on its path. On the path: {result}").format(result=_exact_text(exact))
        )
    elif first is None or exact.status != "contact":
        notes.append(text("The exact model: {result}").format(result=_exact_text(exact)))
    elif first.benches != exact.benches:
        notes.append(text("The exact model has another first contact: {result}").format(result=_exact_text(exact)))
    elif summary.player != "exact":
        error = _time_error_text(summary) or text("of unknown time")
        same = text("The same benches touch in the exact model; the contact of the run is {error}.")
        notes.append(same.format(error=error))
    return notes


def _exact_text(exact: FirstContact) -> str:
    """Result of the exact model as a sentence."""
    template = {
        "contact": text("benches {pair} touch at {time}."),
        "clear": text("no contact until {time}."),
        "overlapping": text("benches {pair} overlap from the start on, at {time}."),
        "unreachable": text("no contact until {time}, where the dragon reaches the end of the curve."),
    }[exact.status]
    return template.format(pair=format_pair(exact.benches), time=_time_text(exact.time, 6))


def _time_error_text(summary: Summary) -> str | None:
    """Time of the run's first contact relative to the exact one; None if the benches differ or a time is unknown."""
    first, exact = summary.run.first_contact, summary.exact
    if summary.player == "exact" or not summary.guided or first is None or exact is None or exact.status != "contact":
        return None
    if first.benches != exact.benches or not math.isfinite(first.time):
        return None
    error_ms = 1e3 * (first.time - exact.time)
    template = text("{error} ms early") if error_ms < 0 else text("{error} ms late")
    return template.format(error=format_number(abs(error_ms), 3))


def _near_miss_note(summary: Summary) -> str:
    if summary.near_misses is None:
        return text("Not searched for.")
    if not summary.near_misses:
        return text("None.")
    return text("Small local minima of the distance between benches that are not neighbours, in the exact model.")


def _window_note(summary: Summary) -> str:
    windows = summary.windows
    if summary.player == "exact":
        return text("The exact model gives the beginning of a contact, not its end.")
    if not windows:
        return text("No contact windows.")
    if len(windows) == 1 and summary.run.first_contact is not None and windows[0].end is None:
        return text("The run ended during its first contact, so the duration of the contact is unknown.")
    return text("Pairs of benches in contact, from the first contact on; times are the ends of substeps.")


def _drift(summary: Summary) -> Section:
    if summary.player == "exact":
        return Section("drift", text("Position error"), [text("None: the run is the exact model's own.")])
    note = text(
        "Distance of a bench's hole from its position in the exact model, for the hole with the larger distance."
    )
    drift = summary.drift
    facts = [
        (
            text("Largest of the first {count} benches").format(count=drift.head_benches),
            _drift_text(drift.head, drift.head_at),
        ),
        (text("Largest of any bench"), _drift_text(drift.max, drift.max_at)),
    ]
    return Section("drift", text("Position error"), [note], facts={"": facts})


def _handle_notes(summary: Summary) -> list[str]:
    notes = [text("Positions and speeds of the handles of the paper's tables, in the exact model.")]
    if summary.handles.contact is not None:
        last = {
            "exact": text("The last column is the time of the exact first contact."),
            "run": text("The last column is the time of the run's first contact."),
        }
        notes.append(last[summary.handles.contact])
    return notes


def _event_note(summary: Summary) -> str:
    if not (count := len(summary.run.events)):
        return text("No collision callbacks.")
    if count == 1:
        return text("One collision callback of the engine.")
    return text("{count} collision callbacks of the engine, in the order in which they came.").format(count=count)


def _settings(values: Mapping[str, Any], prefix: str = "") -> Facts:
    """Names and values as text; nested names are joined by dots."""
    entries: Facts = []
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            entries += _settings(value, f"{prefix}{name}.")
        else:
            entries.append((prefix + name, _value_text(value, SETTING_DIGITS)))
    return entries


def _value_text(value: Any, digits: int) -> str:
    """A JSON value as text; floats with `digits` significant digits."""
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return text("yes") if value else text("no")
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, list):
        return ", ".join(_value_text(item, digits) for item in value) or MISSING
    return text("none") if value == {} else str(value)


def _speed_text(speed: float | Sequence[Sequence[float]] | None) -> str:
    """Speed of the head, or its range."""
    if speed is None:
        return text("a changing speed")
    if isinstance(speed, Sequence):
        least, most = (bound(entry[1] for entry in speed) for bound in (min, max))
        if least < most:
            return text("{least} to {most} m/s").format(least=f"{least:g}", most=f"{most:g}")
        return f"{most:g} m/s"
    return f"{speed:g} m/s"


def _time_text(time: float, decimals: int) -> str:
    return f"{format_number(time, decimals)} s"


def _drift_text(drift: float, peak: Peak | None) -> str:
    """Position error with its bench and time."""
    if peak is None:
        return MISSING
    template = text("{error} (bench {bench} at {time})")
    return template.format(error=format_length(drift), bench=peak.bench, time=_time_text(peak.time, 3))
