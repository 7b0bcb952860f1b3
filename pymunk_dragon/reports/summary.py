"""Summary of a run: the data that all report formats and the player page are made from.

`schema.json` in this directory describes each JSON key.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields, is_dataclass, replace
from functools import cached_property
from numbers import Integral, Real
from typing import Any, Literal

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._html import asset
from pymunk_dragon.collision import FirstContact, NearMiss, first_contact
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.contact import ContactWindow
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import HEAD_BENCHES, Run
from pymunk_dragon.model.speed import ConstantSpeed, SpeedTable

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
# Levels of nesting of provenance: runs have two; deeper values, as in a malicious file, are replaced.
MAX_DEPTH = 16
# Replacement text for values nested more deeply than `MAX_DEPTH`.
TOO_DEEP = "(nested too deeply)"
# Characters that some format cannot represent: controls except tab and newline, surrogates, noncharacters.
UNPRINTABLE = {
    code: "\ufffd"
    for code in (*range(0x20), *range(0x7F, 0xA0), *range(0xD800, 0xE000), 0xFFFE, 0xFFFF)
    if chr(code) not in "\t\n"
}


@dataclass(frozen=True, kw_only=True)
class Handles:
    """States of the handles `numbers` in the exact model: positions (T, H, 2) in m and speeds (T, H) in m/s.

    If the last time is that of a first contact, `contact` tells whether of the exact model or of the run.
    """

    numbers: list[int]
    times: list[float]
    contact: Literal["exact", "run"] | None
    positions: Array
    speeds: Array


@dataclass(frozen=True, kw_only=True)
class Peak:
    """Time (s) and bench of the largest position error."""

    time: float
    bench: int


@dataclass(frozen=True, kw_only=True)
class Drift:
    """Position error against the exact model, m, of the first `head_benches` benches and of all; nan where unknown."""

    head_benches: int
    head: float
    max: float
    head_at: Peak | None
    max_at: Peak | None
    times: Array
    head_over_time: Array
    max_over_time: Array


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Summary of a run.

    Attributes
    ----------
    run : Run
        The run. A run of the exact model includes a frame at the exact first contact.
    exact : FirstContact or None
        First contact and near misses of the exact model; None if the search is not possible.
    player : str or None
        "pymunk" or "exact"; None if unknown.
    guided : bool
        Whether a guide keeps the dragon on its path.
    scenario, settings, versions : dict
        Parameters of the march, settings of the player and versions of the programs, as JSON values.

    Examples
    --------
    >>> summarize(Run.exact(March(), [412, 413])).run.first_contact.benches
    (0, 8)
    """

    run: Run
    exact: FirstContact | None
    player: str | None
    guided: bool
    scenario: dict[str, Any]
    settings: dict[str, Any]
    versions: dict[str, Any]

    @property
    def near_misses(self) -> tuple[NearMiss, ...] | None:
        """Near misses of the exact model, by time; None if unknown."""
        return None if self.exact is None else self.exact.near_misses

    @cached_property
    def windows(self) -> list[ContactWindow]:
        """Contact windows of the run, by beginning."""
        return self.run.events.windows()

    @cached_property
    def handles(self) -> Handles:
        """States of the handles in the paper's tables.

        On a spiral the times are those of the paper; on other curves they are evenly spaced over the run.
        """
        march = self.run.march
        chosen = march.dragon.representatives
        times = TABLE_TIMES
        if march.curve.default_turns is None:
            times = tuple(np.unique(np.linspace(self.run.times[0], self.run.times[-1], OTHER_TIMES)).tolist())
        entries: list[tuple[float, Literal["exact", "run"] | None]] = [(time, None) for time in times]
        if self.exact is not None and self.exact.status == "contact":
            entries.append((self.exact.time, "exact"))
        elif self.run.first_contact is not None:
            entries.append((self.run.first_contact.time, "run"))
        reached = []
        for time, contact in entries:
            with suppress(UnreachableError):
                reached.append((time, contact, march.at([time])))
        return Handles(
            numbers=chosen,
            times=[time for time, *_ in reached],
            contact=reached[-1][1],
            positions=np.array([states.positions[0, chosen] for *_, states in reached]),
            speeds=np.array([states.speeds[0, chosen] for *_, states in reached]),
        )

    @cached_property
    def drift(self) -> Drift:
        """Position error of the run against the exact model."""
        run = self.run
        head = run.drift[:, :HEAD_BENCHES]
        return Drift(
            head_benches=head.shape[1],
            head=run.head_drift,
            max=run.max_drift,
            head_at=_peak(run.times, head),
            max_at=_peak(run.times, run.drift),
            times=run.times,
            head_over_time=_largest_by_frame(head),
            max_over_time=_largest_by_frame(run.drift),
        )

    def to_dict(self) -> dict[str, Any]:
        """Summary as JSON values.

        Returns
        -------
        dict
            Values that `json_schema` describes. None stands for unknown values and nan. They are deterministic: they
            include neither the date nor wall-clock times.

        Examples
        --------
        >>> summarize(Run.exact(March(), [0, 1])).to_dict()["outcome"]
        {'status': 'clear', 'start': 0.0, 'until': 1.0, 'frames': 2, 'events': 0}
        """
        run, exact = self.run, self.exact
        values: dict[str, Any] = {
            "schema": SCHEMA,
            "version": VERSION,
            "scenario": self.scenario,
            "player": self.player,
            "settings": self.settings,
            "versions": self.versions,
            "outcome": {
                "status": run.outcome,
                "start": run.times[0],
                "until": run.times[-1],
                "frames": len(run.times),
                "events": len(run.events),
            },
            "first_contact": run.first_contact,
            "exact": exact and {name: getattr(exact, name) for name in EXACT_FIELDS},
            "near_misses": self.near_misses,
            "events": list(run.events),
            "windows": self.windows,
            "handles": self.handles,
            "drift": self.drift,
        }
        found: dict[str, Any] = _json(values)
        return found


def summarize(run: Run) -> Summary:
    """Compute the summary of a run.

    Parameters
    ----------
    run : Run
        Run to summarize. If the exact model played it, its exact first contact is added, with a frame at its time.

    Returns
    -------
    Summary
        Data of the reports; `Summary.to_dict` gives them as JSON values.

    Raises
    ------
    ParameterError
        If `run` is not a Run.

    Examples
    --------
    >>> [miss.benches for miss in summarize(Run.exact(March(), [405, 410])).near_misses]
    [(0, 9), (0, 11)]
    """
    if not isinstance(run, Run):
        raise ParameterError("run", run, "a Run")
    settings = {name: value for name, value in run.provenance.items() if name not in ("player", "versions")}
    guided = run.guide != "none"
    exact = _exact_first_contact(run, guided=guided)
    return Summary(
        run=_with_contact(run, exact) if run.player == "exact" else run,
        exact=exact,
        player=run.player,
        guided=guided,
        scenario=_json(_scenario(run.march)),
        settings=_json(settings, 1),
        versions=_json(run.versions, 1),
    )


def json_schema() -> dict[str, Any]:
    """JSON Schema of `Summary.to_dict` and of the JSON report.

    Returns
    -------
    dict
        Schema of the draft 2020-12.

    Examples
    --------
    >>> json_schema()["title"]
    'pymunk_dragon report'
    """
    schema: dict[str, Any] = json.loads(asset(__package__, "schema.json"))
    return schema


def _exact_first_contact(run: Run, *, guided: bool) -> FirstContact | None:
    """First contact and near misses of the exact model over the time of `run`; None if the search is not possible.

    The contact of a guided run may be slightly before or after the exact one. If a guided run has a contact, the search
    continues after its end, for at most the duration of the run. All other searches stop at the end of the run.
    """
    start, until = float(run.times[0]), float(run.times[-1])
    if run.first_contact and guided:
        until = min(run.march.end, max(until, 2 * until - start))
    try:
        return first_contact(run.march, start=start, until=until)
    except (ParameterError, UnreachableError):
        # A run of a single frame, or times beyond the end of the curve, as in an edited file.
        return None


def _with_contact(run: Run, exact: FirstContact | None) -> Run:
    """A run of the exact model with the exact first contact, if any, and a frame at its time."""
    contact = None if exact is None else exact.contact
    if contact is None:
        return run
    index = int(np.searchsorted(run.times, contact.time))
    state = run.march.at([contact.time])
    velocities = run.pose_velocities
    return replace(
        run,
        times=np.insert(run.times, index, contact.time),
        poses=np.insert(run.poses, index, state.poses[0], axis=0),
        pose_velocities=None if velocities is None else np.insert(velocities, index, state.pose_velocities[0], axis=0),
        drift=np.insert(run.drift, index, 0.0, axis=0),
        first_contact=contact,
        outcome="contact",
    )


def _scenario(march: March) -> dict[str, Any]:
    """Parameters of the march. Unlike a `Scenario`, these may describe any curve."""
    curve = march.curve
    parameters = asdict(march.dragon) | {
        "curve": type(curve).__name__,
        "pitch": curve.turn_width,
        "turns": march.turns,
        "speed": _speed(march),
    }
    parameters |= {name: getattr(curve, name) for name in curve.flags if name not in parameters}
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


def _peak(times: Array, drift: Array) -> Peak | None:
    """Time and bench of the largest known value of `drift`, (F, N); None if none is known."""
    known = np.where(np.isfinite(drift), drift, -np.inf)
    frame, bench = np.unravel_index(int(np.argmax(known)), known.shape)
    return None if known[frame, bench] == -np.inf else Peak(time=float(times[frame]), bench=int(bench))


def _largest_by_frame(drift: Array) -> Array:
    """Largest known value of each frame, (F,); nan if none is known."""
    known = np.where(np.isfinite(drift), drift, -np.inf).max(axis=1)
    return np.where(np.isfinite(known), known, np.nan)


def _json(value: Any, depth: int = 0) -> Any:
    """`value` as JSON values: NumPy types as Python types, nan and infinity as None, text without `UNPRINTABLE`."""
    if depth > MAX_DEPTH:
        return TOO_DEEP
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return value.translate(UNPRINTABLE)
    if is_dataclass(value) and not isinstance(value, type | Sequence):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, Mapping):
        return {_json(str(key)): _json(item, depth + 1) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _json(value.tolist(), depth)
    if isinstance(value, Sequence):
        return [_json(item, depth + 1) for item in value]
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        number = float(value)
        return number if math.isfinite(number) else None
    return _json(str(value))
