"""Contents of a report as JSON values. All formats are made from these contents.

`schema.json` in this directory describes each key.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.resources import files
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import FirstContact
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.curves import Spiral, UTurn
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import HEAD_BENCHES, Run
from pymunk_dragon.model.speed import ConstantSpeed, SpeedTable
from pymunk_dragon.reports.exact import exact_first_contact, with_exact_contact

__all__ = ["SCHEMA", "VERSION", "contents", "json_schema", "summarize"]

Array = NDArray[np.float64]
Contents = dict[str, Any]

# Name of the JSON format, as in `schema.json`.
SCHEMA = "pymunk_dragon report"
# Version of the JSON format, as in `schema.json`.
VERSION = 1
# s: times of the paper's tables 1 and 2.
TABLE_TIMES = (0.0, 60.0, 120.0, 180.0, 240.0, 300.0)
# Times in the tables of curves other than the spiral: the contest's problem 4 has five, from -100 s to 100 s.
OTHER_TIMES = 5
# Fields of a `FirstContact` under the key `exact`; near misses have a key of their own.
EXACT_FIELDS = ("status", "time", "benches", "point", "normal")
# Levels of nesting of provenance: the players write two; deeper values, as in a malicious file, are replaced.
MAX_DEPTH = 16
# Replacement text for values nested more deeply than `MAX_DEPTH`.
TOO_DEEP = "(nested too deeply)"
# Characters that some format cannot represent: controls except tab and newline, surrogates, noncharacters.
UNPRINTABLE = {
    code: "\N{REPLACEMENT CHARACTER}"
    for code in (*range(0x20), *range(0x7F, 0xA0), *range(0xD800, 0xE000), 0xFFFE, 0xFFFF)
    if chr(code) not in "\t\n"
}


def contents(run: Run) -> Contents:
    """Contents of a report on `run` as JSON values. None stands for unknown values and nan.

    Contents are deterministic: they hold neither the date nor wall-clock times.
    """
    exact = exact_first_contact(run)
    return summarize(with_exact_contact(run, exact), exact)


def summarize(run: Run, exact: FirstContact | None) -> Contents:
    """Contents of a report on `run`, given the result of the exact model."""
    first = run.first_contact
    near_misses = None if exact is None else exact.near_misses
    whole: Contents = {
        "schema": SCHEMA,
        "version": VERSION,
        "scenario": _scenario(run.march),
        "player": run.player,
        "settings": {name: value for name, value in run.provenance.items() if name not in ("player", "versions")},
        "versions": run.versions,
        "outcome": {
            "status": run.outcome,
            "start": run.times[0],
            "until": run.times[-1],
            "frames": len(run.times),
            "events": len(run.events),
        },
        "first_contact": None if first is None else asdict(first),
        "exact": None if exact is None else {name: getattr(exact, name) for name in EXACT_FIELDS},
        "near_misses": None if near_misses is None else [asdict(near_miss) for near_miss in near_misses],
        "events": [asdict(event) for event in run.events],
        "windows": [asdict(window) for window in run.events.windows()],
        "handles": _handles(run, exact),
        "drift": _drift(run),
    }
    plain: Contents = _plain(whole)
    return plain


def json_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of `contents` and of the JSON report."""
    schema: dict[str, Any] = json.loads(files(__package__).joinpath("schema.json").read_text(encoding="utf-8"))
    return schema


def _scenario(march: March) -> dict[str, Any]:
    """Parameters of the march. Unlike a `Scenario`, these may describe any curve."""
    curve = march.curve
    parameters = asdict(march.dragon) | {
        "curve": type(curve).__name__,
        "pitch": curve.pitch if isinstance(curve, Spiral | UTurn) else None,
        "turns": march.turns,
        "speed": _speed(march),
    }
    if isinstance(curve, UTurn):
        parameters |= {"radius": curve.radius, "ratio": curve.ratio}
    if math.isfinite(length := curve.end_s - curve.begin_s):
        parameters["length"] = length
    if march.start_s is not None:
        parameters["start_s"] = march.start_s
    return parameters


def _speed(march: March) -> float | list[tuple[float, float]] | None:
    """A constant speed, or (time, speed) entries of a table; None for any other profile."""
    profile = march.speed_profile
    if isinstance(profile, SpeedTable):
        return list(zip(profile.times, profile.speeds, strict=True))
    return profile.value if isinstance(profile, ConstantSpeed) else None


def _handles(run: Run, exact: FirstContact | None) -> dict[str, Any]:
    """Positions and speeds of the reported handles in the exact model, at all times that are reachable.

    On a spiral the times are those of the paper; on other curves they are evenly spaced over the run.
    """
    chosen = run.march.dragon.representatives
    times = TABLE_TIMES
    if not isinstance(run.march.curve, Spiral):
        times = tuple(np.unique(np.linspace(run.times[0], run.times[-1], OTHER_TIMES)).tolist())
    entries: list[tuple[float, str | None]] = [(time, None) for time in times]
    if exact is not None and exact.status == "contact":
        entries.append((exact.time, "exact"))
    elif run.first_contact is not None:
        entries.append((run.first_contact.time, "run"))
    reached = []
    for time, contact in entries:
        try:
            states = run.march.at([time])
        except UnreachableError:
            continue
        reached.append((time, contact, states.positions[0, chosen], states.speeds[0, chosen]))
    return {
        "numbers": chosen,
        "times": [time for time, *_ in reached],
        "contact": reached[-1][1],
        "positions": [positions for *_, positions, _ in reached],
        "speeds": [speeds for *_, speeds in reached],
    }


def _drift(run: Run) -> dict[str, Any]:
    """Drift of the run from the exact model: its maxima, and the largest drift of each frame."""
    head = run.drift[:, :HEAD_BENCHES]
    return {
        "head_benches": head.shape[1],
        "head": run.head_drift,
        "max": run.max_drift,
        "head_at": _location_of_largest(run.times, head),
        "max_at": _location_of_largest(run.times, run.drift),
        "times": run.times,
        "head_over_time": _largest_by_frame(head),
        "max_over_time": _largest_by_frame(run.drift),
    }


def _location_of_largest(times: Array, drift: Array) -> dict[str, Any] | None:
    """Time and bench of the largest drift; None if no drift is known."""
    known = np.where(np.isfinite(drift), drift, -np.inf)
    frame, bench = np.unravel_index(int(np.argmax(known)), known.shape)
    if known[frame, bench] == -np.inf:
        return None
    return {"time": times[frame], "bench": bench}


def _largest_by_frame(drift: Array) -> Array:
    """Largest known drift of each frame, (F,), m; nan if none is known."""
    known = np.where(np.isfinite(drift), drift, -np.inf).max(axis=1)
    return np.where(np.isfinite(known), known, np.nan)


def _plain(value: Any, depth: int = 0) -> Any:
    """`value` as JSON values: NumPy types as Python types, nan and infinity as None, text without `UNPRINTABLE`."""
    if depth > MAX_DEPTH:
        return TOO_DEEP
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return value.translate(UNPRINTABLE)
    if isinstance(value, Mapping):
        return {_plain(str(key)): _plain(item, depth + 1) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist(), depth)
    if isinstance(value, Sequence):
        return [_plain(item, depth + 1) for item in value]
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        number = float(value)
        return number if math.isfinite(number) else None
    return _plain(str(value))
