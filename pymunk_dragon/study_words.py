"""Results of the studies as JSON values and as text.

Each type of result has a pair of functions in `FORMATTERS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import FirstContact
from pymunk_dragon.studies import MaxSpeed, MinPitch, Reach, Sensitivity, Slope, TurnAnswer
from pymunk_dragon.studies.max_speed import SpeedRatio
from pymunk_dragon.studies.shortest import Shortest

__all__ = ["study_answer", "study_in_words"]

Array = NDArray[np.float64]
Values = dict[str, Any]

# Text of each cause of a smallest pitch.
LIMITS = {"passing": "as the head passes", "arrival": "as the head arrives", "start": "as the dragon starts"}


def _pitch_values(found: MinPitch) -> Values:
    return {
        "pitch": found.pitch,
        "radius": found.radius,
        "turns": found.march.turns,
        "limit": found.limit,
        "benches": found.benches,
        "point": found.point,
        "time": float(found.march.time(found.way)),
        "arrival": float(found.march.time(found.way_in)),
        "gap": found.gap,
        "slope": found.slope,
        "free_at": found.free_at,
        "blocked_at": found.blocked_at,
        "half_line": found.half_line,
        "map": {
            "pitches": found.map.pitches.tolist(),
            # JSON has no infinity: a pitch at which the head passes no bench has no gap.
            "gaps": [gap if math.isfinite(gap) else None for gap in found.map.gaps.tolist()],
            "growth": found.map.growth,
            "near": found.map.near,
            "compared": found.map.compared,
        },
    }


def _pitch_text(found: MinPitch) -> str:
    reached = f"handle 0 reaches the circle of {found.radius:g} m after {found.march.time(found.way_in):.3f} s"
    lines = [f"smallest pitch {found.pitch:.12f} m: {reached}"]
    certified = f"certified: no contact on the way at {found.free_at:.12f} m"
    if found.benches is None or found.point is None:
        lines += ["limit:     the circle, on which it starts; with a smaller pitch it would start inside", certified]
    else:
        (i, j), (x, y) = found.benches, found.point
        where = f"t = {found.march.time(found.way):.6f} s at ({x:.6f}, {y:.6f}) m"
        lines += [
            f"limit:     benches {i} and {j} touch without overlapping {LIMITS[found.limit]}, {where}",
            f"{certified}, but one at {found.blocked_at:.12f} m",
        ]
    return "\n".join([*lines, *_map_text(found)])


def _map_text(found: MinPitch) -> list[str]:
    known, indent = found.map, " " * 11
    lines = [f"map:       {len(known.pitches)} pitches from {known.pitches[0]:.4g} to {known.pitches[-1]:.4g} m;"]
    if known.growth is None:
        lines.append(f"{indent}no gap on the way comes within {1e3 * known.near:.3g} mm of zero;")
    else:
        least, most = known.growth
        lines += [
            f"{indent}all {known.compared} gaps seen within {1e3 * known.near:.3g} mm of zero change with the pitch,",
            f"{indent}the head being on the same circle, by {least:.2f} to {most:.2f} mm for each mm;",
        ]
    shown = "so" if found.half_line else "which does not show that"
    return [*lines, f"{indent}{shown} all larger pitches are free, and all smaller ones are not"]


def _sensitivity_values(found: Sensitivity) -> Values:
    return {
        "contact": {"time": found.time, "benches": found.benches, "slopes": _slopes_values(found.times)},
        "smallest_pitch": {
            "pitch": found.smallest.pitch,
            "benches": found.smallest.benches,
            "slopes": _slopes_values(found.pitches),
        },
    }


def _slopes_values(slopes: Sequence[Slope]) -> Values:
    return {slope.size: {name: value for name, value in asdict(slope).items() if name != "size"} for slope in slopes}


def _sensitivity_text(found: Sensitivity) -> str:
    i, j = found.benches
    lines = [f"first contact at t = {found.time:.9f} s: benches {i} and {j}", *_slopes_text("s", 1e3, found.times)]
    smallest = f"smallest pitch {found.smallest.pitch:.12f} m: "
    if found.smallest.benches is None:
        return "\n".join([*lines, smallest + "limited by the circle, whatever the benches"])
    i, j = found.smallest.benches
    return "\n".join([*lines, f"{smallest}benches {i} and {j}", *_slopes_text("mm", 1.0, found.pitches)])


def _slopes_text(unit: str, per: float, slopes: Sequence[Slope]) -> list[str]:
    """Lines of a table of derivatives per mm; `per` converts them from SI units."""
    lines = [f"  size          now (mm)  {f'{unit} for a mm':>11}  holds from (mm)             to (mm)"]
    for slope in slopes:
        name = slope.size.replace("_", "-")
        numbers = f"{1e3 * slope.value:8.2f}  {slope.slope / per:+11.7f}"
        lines.append(f"  {name:<13} {numbers}  {_reach_text(slope.less):<26}  {_reach_text(slope.more)}")
    return lines


def _reach_text(reach: Reach | None) -> str:
    if reach is None:
        return "-"
    endings = {
        "nothing": "and further",
        "no contact": "then no contact there",
        "another corner": "then another corner",
        "another pair": "then " + "{} and {}".format(*reach.benches) if reach.benches else "",
    }
    return f"{1e3 * reach.unchanged:+.4g} {endings[reach.by]}"


def _speed_values(found: MaxSpeed) -> Values:
    names = ("speed", "handle", "time", "limit", "ratio", "excess", "handles", "way", "speeds", "looks")
    return {name: getattr(found, name) for name in names}


def _speed_text(found: MaxSpeed) -> str:
    first, last = found.handles[0], found.handles[-1]
    subject = f"handle {first} goes" if first == last else f"handles {first} to {last} go"
    shown = "  ".join(f"{speed:.3f}" for speed in found.speeds)
    return "\n".join(
        [
            f"largest speed of the head {found.speed:.10f} m/s: no handle exceeds {found.limit:g} m/s",
            f"limit:     {subject} {found.ratio:.10f} times as fast as the head {found.time:.4f} s after it entered",
            f"           the circle, {found.way:.4f} m into it",
            f"then:      handles 0, 1, 2, ... go {shown} m/s",
            f"certified: no handle ever exceeds that by more than {found.excess:.2g} of it ({found.looks} looks)",
        ]
    )


def _turn_values(found: TurnAnswer) -> Values:
    turn = found.turn
    return {
        "length": turn.length,
        "radii": turn.radii.tolist(),
        "centres": turn.centres.tolist(),
        "sweeps": turn.sweeps.tolist(),
        "tangent_points": turn.tangent_points.tolist(),
        "lengths": [{"ratio": ratio, "length": length} for ratio, length in found.lengths],
        "contact": _impact_values(found.impact, found.times[-1]),
        "hurry": _ratio_values(found.hurry),
        "shortest": None if found.shortest is None else _shortest_values(found, found.shortest),
    }


def _shortest_values(found: TurnAnswer, shortest: Shortest) -> Values:
    turn = shortest.turn
    assert found.short_impact is not None
    return {
        "length": turn.length,
        "proven": False,
        "arcs": [
            {"curvature": curvature, "length": length}
            for curvature, length in zip(turn.curvatures, turn.lengths, strict=True)
        ],
        "joints": turn.path.point(turn.path.joints).tolist(),
        "lengths": [{"arcs": arcs, "length": length} for arcs, length in shortest.lengths],
        "min_radius": shortest.min_radius,
        "allowed": found.allowed,
        "binding": shortest.binding,
        "contact": _impact_values(found.short_impact, found.times[-1]),
        "hurry": _ratio_values(shortest.ratio),
    }


def _ratio_values(ratio: SpeedRatio) -> Values:
    return {"factor": ratio.ratio, "excess": ratio.excess, "handle": ratio.handle, "way": ratio.way}


def _impact_values(impact: FirstContact, until: float) -> Values:
    return {"status": impact.status, "time": impact.time, "benches": impact.benches, "until": float(until)}


def _turn_text(found: TurnAnswer) -> str:
    turn, indent = found.turn, " " * 11
    first, second = turn.radii.tolist()
    ratios, lengths = zip(*found.lengths, strict=True)
    lines = [
        f"the turn:  {turn.length:.6f} m on arcs of {first:.6f} and {second:.6f} m,",
        f"{indent}each of {math.degrees(abs(turn.sweeps[0])):.6f} degrees, about {_points(turn.centres)} m,",
        f"{indent}which touch at {_points(turn.tangent_points)} m",
        f"contact:   {_impact_text(found.impact, found.times)}",
        f"fastest:   {_ratio_text(found.hurry)}",
        f"two arcs:  always as long: {min(lengths):.12f} to {max(lengths):.12f} m where the radii are",
        f"{indent}as {min(ratios):g} to 1 up to {max(ratios):g} to 1. Both turn by the same angle, and their chords",
        f"{indent}make up the circle's diameter",
    ]
    if found.shortest is not None:
        lines += _shortest_text(found, found.shortest)
    return "\n".join(lines)


def _shortest_text(found: TurnAnswer, shortest: Shortest) -> list[str]:
    turn, indent = shortest.turn, " " * 11
    assert found.short_impact is not None
    counts = ", ".join(f"{length:.4f} m on {arcs}" for arcs, length in shortest.lengths)
    arcs = zip(turn.curvatures, turn.lengths, strict=True)
    return [
        f"shorter:   {turn.length:.4f} m on {len(turn.lengths)} arcs: best found, not proven to be the shortest",
        "searched:  turns on n circular arcs, tangent to each other and to both spirals where these meet the circle,",
        f"{indent}inside the circle, with radii of at least {shortest.min_radius:g} m, on which",
        f"{indent}every handle goes forward and none more than {found.allowed:.6f} times as fast as the head",
        f"by n:      {counts}",
        *(f"{indent}arc {i}: {_arc_text(*arc)}" for i, arc in enumerate(arcs, start=1)),
        f"contact:   {_impact_text(found.short_impact, found.times)}",
        f"fastest:   {_ratio_text(shortest.ratio)};",
        f"{indent}handles at the limit: {', '.join(map(str, shortest.binding))}",
    ]


def _arc_text(curvature: float, length: float) -> str:
    if curvature == 0:
        return f"{length:.4f} m, straight"
    side = "left" if curvature > 0 else "right"
    return f"{length:.4f} m, to the {side} with a radius of {1 / abs(curvature):.4f} m"


def _points(points: Array) -> str:
    return ", ".join(f"({x:.6f}, {y:.6f})" for x, y in points.tolist())


def _impact_text(impact: FirstContact, times: Array) -> str:
    if impact.status == "clear":
        no_gap = ", nor a gap below a thirtieth of the width" if impact.near_misses == () else ""
        return f"none from {times[0]:g} to {times[-1]:g} s{no_gap}: certified"
    if impact.benches is None:
        return f"none, but the dragon gets stuck at t = {impact.time:.6f} s"
    return f"benches {impact.benches[0]} and {impact.benches[1]} touch at t = {impact.time:.6f} s"


def _ratio_text(ratio: SpeedRatio) -> str:
    where = f"handle {ratio.handle}, {ratio.ratio:.6f} times as fast as the head, as that is {ratio.way:.3f} m in"
    return f"{where}: certified to {ratio.excess:.1g}"


# Functions that return the JSON values and the text of each type of result.
FORMATTERS: Mapping[type, tuple[Callable[[Any], Values], Callable[[Any], str]]] = {
    MaxSpeed: (_speed_values, _speed_text),
    MinPitch: (_pitch_values, _pitch_text),
    Sensitivity: (_sensitivity_values, _sensitivity_text),
    TurnAnswer: (_turn_values, _turn_text),
}


def study_answer(found: object) -> Values:
    """JSON values of a study's result, as `study --json` prints them."""
    return FORMATTERS[type(found)][0](found)


def study_in_words(found: object) -> str:
    """Text of a study's result and its evidence, as `study` prints it."""
    return FORMATTERS[type(found)][1](found)
