"""What a report says, as plain JSON values; every format is made from it.

`schema.json` beside this file describes it key by key.
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
from pymunk_dragon.curves import Spiral, UTurn
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.march import March
from pymunk_dragon.report.exact import exact_impact, with_exact_contact
from pymunk_dragon.run import HEAD_BENCHES, Run
from pymunk_dragon.speed import ConstantSpeed, SpeedTable

__all__ = ["SCHEMA", "VERSION", "contents", "json_schema", "told"]

Array = NDArray[np.float64]
Contents = dict[str, Any]

SCHEMA, VERSION = "pymunk_dragon report", 1

# What the paper's tables 1 and 2 show, beside the last handle: handles, and times in s.
TABLE_TIMES = (0.0, 60.0, 120.0, 180.0, 240.0, 300.0)
# Times of a table on a curve that the paper does not have: as the contest asks for, from -100 s to 100 s.
OTHER_TIMES = 5

# What of an `FirstContact` is reported as the exact model's answer; its near misses stand on their own.
EXACT = ("status", "time", "benches", "point", "normal")

# How deep provenance may be nested. What the players write is two deep; a file made to harm is not followed further.
MAX_DEPTH = 16
TOO_DEEP = "(nested too deeply)"
# Characters that some format cannot hold: controls but tab and line end, halves of surrogate pairs, non-characters.
UNPRINTABLE = {
    code: "\N{REPLACEMENT CHARACTER}"
    for code in (*range(0x20), *range(0x7F, 0xA0), *range(0xD800, 0xE000), 0xFFFE, 0xFFFF)
    if chr(code) not in "\t\n"
}


def contents(run: Run) -> Contents:
    """Everything that a report on `run` says, as JSON values without nan: None stands for what is not known.

    The same run gives the same contents: there is no time of day in them, and no time that anything took.
    """
    impact = exact_impact(run)
    return told(with_exact_contact(run, impact), impact)


def told(run: Run, impact: FirstContact | None) -> Contents:
    """The contents of a report on `run`, of which the exact model says `impact`."""
    provenance = dict(run.provenance)
    player, found_versions = provenance.pop("player", None), provenance.pop("versions", {})
    first = run.first_contact
    near = None if impact is None else impact.near_misses
    whole: Contents = {
        "schema": SCHEMA,
        "version": VERSION,
        "scenario": _scenario(run.march),
        "player": player if player is None else str(player),
        "settings": provenance,
        "versions": found_versions if isinstance(found_versions, Mapping) else {"versions": found_versions},
        "outcome": {
            "status": run.outcome,
            "from": run.times[0],
            "until": run.times[-1],
            "frames": len(run.times),
            "events": len(run.events),
        },
        "first_contact": None if first is None else asdict(first),
        "exact": None if impact is None else {name: getattr(impact, name) for name in EXACT},
        "near_misses": None if near is None else [asdict(miss) for miss in near],
        "events": [asdict(event) for event in run.events],
        "windows": [asdict(window) for window in run.events.windows()],
        "handles": _handles(run, impact),
        "drift": _drift(run),
    }
    plain: Contents = _plain(whole)
    return plain


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) that `contents` and the JSON report keep to."""
    schema: dict[str, Any] = json.loads(files(__package__).joinpath("schema.json").read_text(encoding="utf-8"))
    return schema


def _scenario(march: March) -> dict[str, Any]:
    """The march as plain values. Not a `Scenario`, which does not know every curve; a report takes any."""
    curve = march.curve
    told = asdict(march.dragon) | {
        "curve": type(curve).__name__,
        "pitch": curve.pitch if isinstance(curve, Spiral | UTurn) else None,
        "turns": march.turns,
        "speed": _speed(march),
    }
    if isinstance(curve, UTurn):
        told |= {"radius": curve.radius, "ratio": curve.ratio}
    if math.isfinite(length := curve.end - curve.begin):
        told["length"] = length
    if march.start is not None:
        told["start"] = march.start
    return told


def _speed(march: March) -> float | list[tuple[float, float]] | None:
    """A number, or entries of a table; None for a function."""
    pace = march.speed_profile
    if isinstance(pace, SpeedTable):
        return list(zip(pace.times, pace.speeds, strict=True))
    return pace.value if isinstance(pace, ConstantSpeed) else None


def _handles(run: Run, impact: FirstContact | None) -> dict[str, Any]:
    """Where the tables' handles are, and how fast, in the exact model, as far as it has a place for them.

    On a spiral the times are the paper's, whatever the run's; on other curves they are spread over the run.
    """
    chosen = run.march.dragon.representatives
    times = TABLE_TIMES
    if not isinstance(run.march.curve, Spiral):
        times = tuple(np.unique(np.linspace(run.times[0], run.times[-1], OTHER_TIMES)).tolist())
    moments: list[tuple[float, str | None]] = [(time, None) for time in times]
    if impact is not None and impact.status == "contact":
        moments.append((impact.time, "exact"))
    elif run.first_contact is not None:
        moments.append((run.first_contact.time, "run"))
    placed = []
    for time, contact in moments:
        try:
            states = run.march.at([time])
        except UnreachableError:
            continue
        placed.append((time, contact, states.positions[0, chosen], states.speeds[0, chosen]))
    return {
        "numbers": chosen,
        "times": [time for time, *_ in placed],
        "contact": placed[-1][1],
        "positions": [positions for *_, positions, _ in placed],
        "speeds": [speeds for *_, speeds in placed],
    }


def _drift(run: Run) -> dict[str, Any]:
    """How far the run is from the exact model: its extremes, and the worst bench of every frame."""
    head = run.drift[:, :HEAD_BENCHES]
    return {
        "head_benches": head.shape[1],
        "head": run.head_drift,
        "max": run.max_drift,
        "head_at": _worst(run.times, head),
        "max_at": _worst(run.times, run.drift),
        "times": run.times,
        "head_over_time": _over_time(head),
        "max_over_time": _over_time(run.drift),
    }


def _worst(times: Array, drift: Array) -> dict[str, Any] | None:
    """When and where the largest drift was; None where no drift is known."""
    known = np.where(np.isfinite(drift), drift, -np.inf)
    frame, bench = np.unravel_index(int(np.argmax(known)), known.shape)
    if known[frame, bench] == -np.inf:
        return None
    return {"time": times[frame], "bench": bench}


def _over_time(drift: Array) -> Array:
    """Largest known drift of every frame, (F,), m; nan where none is known."""
    known = np.where(np.isfinite(drift), drift, -np.inf).max(axis=1)
    return np.where(np.isfinite(known), known, np.nan)


def _plain(value: Any, depth: int = 0) -> Any:
    """`value` as JSON has it: NumPy's scalars and arrays as Python's, nan and infinity as None, no unprintable text."""
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
