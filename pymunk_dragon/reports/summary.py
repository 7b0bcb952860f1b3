"""Summary of a run: the data that all report formats and the player page are made from."""

import json
import math
from contextlib import suppress
from dataclasses import asdict, dataclass, is_dataclass, replace
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import instance
from pymunk_dragon.collision import FirstContact, NearMiss, first_contact
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.run import HEAD_BENCHES, Run
from pymunk_dragon.model.speed import SpeedTable

# Name of the JSON format.
_SCHEMA = "pymunk_dragon report"
# Version of the JSON format, which changes when a key is added, removed or changes its meaning.
VERSION = 2
# Fields of a `FirstContact` under the key `exact`; near misses have a key of their own.
_EXACT_FIELDS = ("status", "time", "benches", "point", "normal")


@dataclass(frozen=True, kw_only=True)
class Summary:
    """A run, and the first contact and near misses of the exact model.

    `exact` is None if the search is not possible. A run of the exact model includes a frame at its
    first contact.
    """

    run: Run
    exact: FirstContact | None

    @property
    def near_misses(self) -> tuple[NearMiss, ...] | None:
        """Near misses of the exact model, by time; None if unknown, as where benches are pulled."""
        return None if self.exact is None or self.run.is_pulled else self.exact.near_misses

    @property
    def exact_contact(self) -> Contact | None:
        """First contact of the exact model; None if there is none or unknown."""
        return None if self.exact is None else self.exact.contact

    @property
    def scenario(self) -> dict[str, Any]:
        """Parameters of the march as JSON values.

        Unlike a `Scenario`, they may describe any curve.
        """
        march = self.run.march
        curve = march.curve
        speed: Any = march.speed
        if isinstance(speed, SpeedTable):
            speed = list(zip(speed.times, speed.speeds, strict=True))

        parameters = asdict(march.dragon)
        parameters["curve"] = type(curve).__name__
        parameters["pitch"] = curve.turn_width
        parameters["turns"] = march.turns
        parameters["speed"] = speed
        for name in curve.flags:
            parameters.setdefault(name, getattr(curve, name))
        if math.isfinite(length := curve.end_s - curve.begin_s):
            parameters["length"] = length
        if march.start_s is not None:
            parameters["start_s"] = march.start_s
        return dict(json_values(parameters))

    @property
    def settings(self) -> dict[str, Any]:
        """Settings of the player as JSON values."""
        settings = dict(self.run.provenance)
        settings.pop("player", None)
        settings.pop("versions", None)
        return dict(json_values(settings))

    @property
    def drift(self) -> dict[str, Any]:
        """Largest position errors against the exact model, m, with bench and time."""
        run = self.run
        head = run.drift[:, :HEAD_BENCHES]
        return {
            "head_benches": head.shape[1],
            "head": run.head_drift,
            "max": run.max_drift,
            "head_at": _peak(run.times, head),
            "max_at": _peak(run.times, run.drift),
        }

    def to_dict(self) -> dict[str, Any]:
        """Summary as JSON values in SI units; None stands for unknown values and nan.

        `scenario`, `settings` and `versions` describe the run, `outcome` its end, `events` the
        callbacks and `windows` the time intervals of contact; `exact` and `near_misses` come from
        the exact model, and `drift` has the largest position errors. Nothing depends on the time of
        day.
        """
        run = self.run
        exact = self.exact
        outcome = {
            "status": run.outcome,
            "start": run.interval[0],
            "until": run.interval[1],
            "frames": len(run.times),
            "events": len(run.events),
        }
        values = {
            "schema": _SCHEMA,
            "version": VERSION,
            "scenario": self.scenario,
            "player": run.player,
            "settings": self.settings,
            "versions": run.versions,
            "outcome": outcome,
            "first_contact": run.first_contact,
            "exact": exact and {name: getattr(exact, name) for name in _EXACT_FIELDS},
            "near_misses": self.near_misses,
            "events": list(run.events),
            "windows": run.events.windows(),
            "drift": self.drift,
        }
        return dict(json_values(values))


def summarize(run: Run) -> Summary:
    """Compute the summary of a run, the data of the reports.

    Examples
    --------
    >>> from pymunk_dragon import March, Run
    >>> [miss.benches for miss in summarize(Run.exact(March(), [405, 410])).near_misses]
    [(0, 9), (0, 11)]
    """
    instance("run", run, Run, "a Run")
    start, until = run.interval
    # The first contact of a guided run may be slightly before the exact one.
    if run.first_contact and run.free_from is None:
        until = min(run.march.end, 2 * until - start)
    exact = None
    # A run of a single frame, or times beyond the end of the curve, as in an edited file, have no
    # result.
    with suppress(ParameterError, UnreachableError):
        exact = first_contact(run.march, start=start, until=until)

    summary = Summary(run=run, exact=exact)
    contact = summary.exact_contact
    if contact is None or not run.is_exact_march:
        return summary
    # A run of the exact model gets a frame at the contact.
    played = Run.exact(run.march, np.union1d(run.times, contact.time))
    played = replace(played, provenance=run.provenance, first_contact=contact, outcome="contact")
    return Summary(run=played, exact=exact)


def json_values(value: Any) -> Any:
    """`value` as JSON values.

    Arrays and tuples become lists, nan and infinity None, and text such that UTF-8 can represent
    it.
    """
    written = json.dumps(value, default=_plain, ensure_ascii=False).encode("utf-8", "replace")
    return json.loads(written, parse_constant=lambda name: None)


def _plain(value: Any) -> Any:
    """A value of a type that JSON does not have, as one that it has."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return vars(value) if is_dataclass(value) else str(value)


def _peak(times: Array, drift: Array) -> dict[str, Any] | None:
    """Time and bench of the largest known value of `drift`, (F, N); None if none is known."""
    if np.isnan(drift).all():
        return None
    frame, bench = np.unravel_index(np.nanargmax(drift), drift.shape)
    return {"time": times[frame], "bench": bench}
