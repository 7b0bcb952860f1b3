"""Settings of the Pymunk engine, and the provenance of a run: what produced it, with which settings and versions."""

from __future__ import annotations

import math
import platform
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from importlib.metadata import version
from typing import Any, Literal, get_args

from pymunk_dragon._checks import finite, positive, whole, word
from pymunk_dragon.errors import ParameterError

# Response to contacts: end the run, go on and record them, or let the engine push the benches apart.
Contacts = Literal["stop", "report", "resolve"]

# Metres that the head travels in one substep. The docstring of `physics` has the drift and time error of other values.
STRIDE = 1 / 50
# Solver iterations per substep, chosen with `STRIDE`.
ITERATIONS = 10
# The same where contacts are resolved. The docstring of `physics` has the joint gaps and depths.
RESOLVE_STRIDE = 1 / 200
# The same: contact forces load the joints, and with 10 iterations gaps are five times as wide.
RESOLVE_ITERATIONS = 60
# The same for a drift below a micrometre on the reference march.
FINE_STRIDE = 1 / 400
FINE_ITERATIONS = 60
# Longer substeps skip over a bench, m.
MAX_STRIDE = 0.1
# Shorter substeps take days for a march, m.
MIN_STRIDE = 1e-5
# Metres that the head travels between recorded frames; between them poses are interpolated to a micrometre.
FRAME_STRIDE = 0.1
# Ground drag, per metre marched (per second at 1 m/s). Pymunk corrects joint errors at a rate of 6.3 per second
# (its error_bias, 0.9 ** 60), as ordinary velocity; a chain whose solver has not converged turns that into growing
# oscillations unless the drag is faster than the correction. Where dancers balance it, the drift changes by a
# third with any drag from 5 to 20 (tests/bench/bench_drift.py).
DRAG = 11.5
# Largest force of the head's motor, in units of the ground drag on what the head has to pull.
HEAD_FORCE = 2.0
# Per metre marched: at 1e4 a body keeps nothing of its velocity in a substep of 10 mm.
MAX_DRAG = 1e4
# More sweeps per substep than any chain needs to converge.
MAX_ITERATIONS = 100_000
# N: the weight of a hundred thousand tonnes, which no head needs.
MAX_FORCE = 1e9
# s: no substep and no frame interval is longer.
MAX_INTERVAL = 1e9
# Settings that `provenance` holds only where they are not their defaults, for files as they have always been.
OPTIONAL_SETTINGS = ("head_force", "drag", "frame_interval")


@dataclass(frozen=True, kw_only=True)
class EngineSettings:
    """Settings of the engine; the defaults are those of `simulate`.

    Parameters
    ----------
    contacts : {"stop", "report", "resolve"}
        At the first contact of benches that are not neighbours: end the run, go on and only record contacts, or go on
        and let the engine push the benches apart. Resolved, the head is pulled along the march by a motor of finite
        force, and the dancers stop where the head cannot go on.
    substep : float, optional
        Length of a step, s; by default the time in which the head travels 20 mm, or 5 mm where contacts are resolved.
    iterations : int, optional
        Solver iterations per substep; by default 10, or 60 where contacts are resolved.
    drag : float
        Ground drag on the benches, per metre marched: velocities decay at this rate times the head's top speed.
    frame_interval : float, optional
        Time between recorded frames, s, rounded to whole substeps; by default the time in which the head travels 0.1 m.
    head_force : float, optional
        Largest force of the head's motor, N, where contacts are resolved. By default twice the ground drag on what the
        head pulls: on itself where dancers walk (0.47 kN for the contest's at 1 m/s), on all benches without a guide.

    Examples
    --------
    >>> from dataclasses import replace
    >>> coarse = EngineSettings(substep=0.05, iterations=5)
    >>> replace(coarse, contacts="report").iterations
    5
    """

    contacts: Contacts = "stop"
    substep: float | None = None
    iterations: int | None = None
    drag: float = DRAG
    frame_interval: float | None = None
    head_force: float | None = None

    def __post_init__(self) -> None:
        word("contacts", self.contacts, get_args(Contacts))
        checked: dict[str, float] = {"drag": positive("drag", self.drag, MAX_DRAG, "per metre")}
        if self.iterations is not None:
            checked["iterations"] = whole("iterations", self.iterations, 1, MAX_ITERATIONS)
        for name in ("substep", "frame_interval"):
            if (value := getattr(self, name)) is not None:
                checked[name] = positive(name, value, MAX_INTERVAL, "s")
        if self.head_force is not None:
            if self.contacts != "resolve":
                raise ParameterError("head_force", self.head_force, "absent unless contacts are resolved")
            checked["head_force"] = positive("head_force", self.head_force, MAX_FORCE, "N")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def resolved(self, *, top_speed: float, pulled_mass: float) -> EngineSettings:
        """The settings with numbers for `substep`, `iterations` and, where contacts are resolved, for `head_force`.

        `top_speed` is the highest one of the head, m/s, and `pulled_mass` that of the benches on which the head has to
        balance the ground drag, kg. In a substep the head may travel from 0.01 mm to 0.1 m.

        Examples
        --------
        >>> EngineSettings().resolved(top_speed=2.0, pulled_mass=20.0).substep
        0.01
        """
        positive("top_speed", top_speed, math.inf, "m/s")
        resolves = self.contacts == "resolve"
        substep, iterations, force = self.substep, self.iterations, self.head_force
        if substep is None:
            substep = (RESOLVE_STRIDE if resolves else STRIDE) / top_speed
        if iterations is None:
            iterations = RESOLVE_ITERATIONS if resolves else ITERATIONS
        if force is None and resolves:
            force = HEAD_FORCE * self.drag * top_speed**2 * finite("pulled_mass", pulled_mass, 0, math.inf, "kg")
        finite("substep", substep, MIN_STRIDE / top_speed, MAX_STRIDE / top_speed, "s")
        return replace(self, substep=substep, iterations=iterations, head_force=force)


def check_settings(value: object) -> None:
    """Raise a ParameterError if `value` is no `EngineSettings`."""
    if not isinstance(value, EngineSettings):
        raise ParameterError("settings", value, "an EngineSettings")


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that decide a run's numbers."""
    names = ("pymunk-dragon", "pymunk", "numpy")
    return {"python": platform.python_version()} | {name: version(name) for name in names}


def engine_provenance(
    settings: EngineSettings, *, guide: str, start: float, until: float, substeps: int
) -> dict[str, Any]:
    """The `provenance` of a run of the engine from `start` to at most `until`, s."""
    values = {"player": "pymunk", "guide": guide, "contacts": settings.contacts, "start": start, "until": until}
    values |= {"substep": settings.substep, "iterations": settings.iterations, "substeps": substeps}
    given = {name: getattr(settings, name) for name in OPTIONAL_SETTINGS}
    changed = {name: value for name, value in given.items() if value != getattr(EngineSettings, name)}
    return values | {"versions": versions()} | changed


def attributes_of(provenance: Mapping[str, Any], start: float) -> dict[str, Any]:
    """Attributes of a run from its `provenance`; `start` is that of its first frame, s."""
    for name, kind, words in (("player", str, "a text"), ("guide", str, "a text"), ("versions", Mapping, "a mapping")):
        if provenance.get(name) is not None and not isinstance(provenance[name], kind):
            raise ParameterError(name, provenance[name], words)
    settings = {f.name: provenance[f.name] for f in fields(EngineSettings) if f.name in provenance}
    substeps = provenance.get("substeps")
    return {
        "player": provenance.get("player"),
        "guide": provenance.get("guide"),
        "settings": EngineSettings(**settings) if settings else None,
        "start": finite("start", provenance.get("start", start), -math.inf, math.inf, "s"),
        "substeps": None if substeps is None else whole("substeps", substeps, 0, sys.maxsize),
        "versions": provenance.get("versions") or {},
    }
