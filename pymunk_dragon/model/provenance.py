"""Provenance of a run: what produced it, with which settings and versions."""

from __future__ import annotations

import math
import platform
import sys
from collections.abc import Mapping
from dataclasses import fields
from importlib.metadata import version
from typing import Any

from pymunk_dragon._checks import finite, whole
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.settings import EngineSettings

# Settings that `provenance` holds only where they are not their defaults, for files as they have always been.
OPTIONAL_SETTINGS = ("head_force", "drag", "frame_interval")


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
