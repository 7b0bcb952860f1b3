"""Answers of the studies as the program prints them: in words, and as the values of its JSON.

A study has one function of each kind, which are found by the type of its answer.
"""

from __future__ import annotations

import math
from functools import singledispatch
from typing import Any

from pymunk_dragon.studies import MinPitch

__all__ = ["study_answer", "study_in_words"]

Answer = dict[str, Any]

LIMITS = {
    "passing": "as the head passes it",
    "arrival": "as the head arrives",
    "start": "as the dragon starts",
}


@singledispatch
def study_answer(found: object) -> Answer:
    """What `study --json` prints."""
    raise TypeError(f"no study answers with a {type(found).__name__}")


@singledispatch
def study_in_words(found: object) -> str:
    """The same in a few lines, with the evidence for it."""
    raise TypeError(f"no study answers with a {type(found).__name__}")


@study_answer.register
def _(found: MinPitch) -> Answer:
    return {
        "pitch": found.pitch,
        "radius": found.radius,
        "turns": found.march.turns,
        "limit": found.limit,
        "benches": found.benches,
        "point": found.point,
        "time": found.time,
        "arrival": found.arrival,
        "gap": found.gap,
        "slope": found.slope,
        "free_at": found.free_at,
        "blocked_at": found.blocked_at,
        "half_line": found.half_line,
        "map": {
            "pitches": found.map.pitches.tolist(),
            # JSON has no infinity.
            "gaps": [gap if math.isfinite(gap) else None for gap in found.map.gaps.tolist()],
            "growth": found.map.growth,
            "near": found.map.near,
            "compared": found.map.compared,
        },
    }


@study_in_words.register
def _(found: MinPitch) -> str:
    lines = [f"smallest pitch {found.pitch:.12f} m: handle 0 reaches the circle of {found.radius:g} m after {found.arrival:.3f} s"]
    if found.benches is None or found.point is None:
        lines.append("nothing is in its way: it starts on the circle, and with a smaller pitch it would start inside")
        lines.append(f"certified: no contact on the way at {found.free_at:.12f} m")
    else:
        (i, j), (x, y) = found.benches, found.point
        lines += [
            f"limit:     benches {i} and {j} touch {LIMITS[found.limit]}, t = {found.time:.6f} s at ({x:.6f}, {y:.6f}) m, and do not overlap",
            f"certified: no contact on the way at {found.free_at:.12f} m, but one at {found.blocked_at:.12f} m",
        ]
    return "\n".join([*lines, _map_in_words(found)])


def _map_in_words(found: MinPitch) -> str:
    known = found.map
    looked = f"{len(known.pitches)} pitches from {known.pitches[0]:.4g} to {known.pitches[-1]:.4g} m"
    if known.growth is None:
        told = f"at {looked} no gap comes within {1e3 * known.near:g} mm of zero"
    else:
        least, most = known.growth
        told = (
            f"at {looked} each of the {known.compared} gaps seen within {1e3 * known.near:g} mm of zero grows\n"
            f"           with the pitch, by {least:.2f} to {most:.2f} mm for a mm, the head being on the same circle"
        )
    if found.half_line:
        return f"map:       {told}: larger pitches are\n           free, smaller ones are not"
    return f"map:       {told};\n           that does not show that all larger pitches are free, and all smaller ones are not"
