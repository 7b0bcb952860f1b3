"""Results as the program prints them: in words, and as the values of its JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from pymunk_dragon.collision import FirstContact
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.run import Run

__all__ = [
    "POSITIONS",
    "answer_in_words",
    "answer_of",
    "comparison_in_words",
    "position_rows",
    "positions_in_words",
    "quality_in_words",
    "summary",
    "windows_in_words",
]

Answer = dict[str, Any]

# m. A certificate that leaves open more than this says so.
COARSE = 1e-8
# Heads of the table of positions in a file.
POSITIONS = ("time_s", "handle", "x_m", "y_m", "speed_m_s")


def position_rows(result: Mapping[str, Any]) -> list[tuple[float, ...]]:
    """What `positions --json` prints, as rows of a table."""
    return [
        (time, handle, *position, speed)
        for time, positions, speeds in zip(result["times"], result["positions"], result["speeds"], strict=True)
        for handle, position, speed in zip(result["handles"], positions, speeds, strict=True)
    ]


def positions_in_words(result: Mapping[str, Any]) -> str:
    """The same as a text."""
    lines = ["     t (s)  handle       x (m)       y (m)  speed (m/s)"]
    for time, handle, *values in position_rows(result):
        # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
        x, y, speed = (round(value, 6) + 0.0 for value in values)
        lines.append(f"{time:10.6g}  {handle:6d}  {x:10.6f}  {y:10.6f}  {speed:11.6f}")
    return "\n".join(lines)


def answer_of(method: str, found: FirstContact | Run) -> Answer:
    """Values that `contact --json` prints, of a first contact or a run."""
    touch: FirstContact | Contact | None
    if isinstance(found, FirstContact):
        misses, until, resolution = found.near_misses, found.time, found.resolution
        touch = found if found.benches is not None else None
        status: str = found.status
    else:
        # The engine reports contacts only, not gaps.
        misses, until, resolution = None, float(found.times[-1]), None
        touch = found.first_contact
        status = found.outcome
    return {
        "status": status,
        "method": method,
        "time": touch.time if touch else None,
        "benches": touch.benches if touch else None,
        "point": touch.point if touch else None,
        "normal": touch.normal if touch else None,
        "near_misses": None if misses is None else [asdict(miss) for miss in misses],
        "until": until,
        "resolution": resolution,
    }


def answer_in_words(answer: Answer) -> str:
    """When and where benches first touch, and the near misses before."""
    if answer["benches"] is None:
        reason = ", where the curve leaves a handle no place" if answer["status"] == "unreachable" else ""
        first = f"no contact until t = {answer['until']:.6g} s{reason}"
    else:
        (i, j), (x, y) = answer["benches"], answer["point"]
        # The exact time is certain to its last decimal here; no other is known that well.
        time = f"{answer['time']:.{9 if answer['method'] == 'exact' else 6}f}"
        if answer["status"] == "overlapping":
            first = f"benches {i} and {j} overlap at the start, t = {time} s"
        else:
            first = f"first contact at t = {time} s: benches {i} and {j} at ({x:.6f}, {y:.6f}) m"
    lines = [first, *(_near_miss_in_words(miss) for miss in answer["near_misses"] or ())]
    if (answer["resolution"] or 0.0) > COARSE:
        lines.append(f"benches that overlap by less than {1e6 * answer['resolution']:.2g} micrometres count as apart")
    return "\n".join(lines)


def _near_miss_in_words(miss: dict[str, Any]) -> str:
    i, j = miss["benches"]
    return f"near miss at t = {miss['time']:.4f} s: benches {i} and {j}, {1e3 * miss['gap']:.3f} mm apart"


def comparison_in_words(answers: Sequence[Answer]) -> str:
    """Table of the methods' results and costs; lateness is relative to the first method."""
    lines = ["method  status       time (s)       benches  late by (ms)  samples  pairs tested  seconds"]
    for answer in answers:
        time, first = answer["time"], answers[0]["time"]
        cells = (
            f"{answer['method']:<6}",
            f"{answer['status']:<11}",
            f"{_or_dash(time, '.9f'):>13}",
            f"{'{} and {}'.format(*answer['benches']) if answer['benches'] else '-':>9}",
            f"{_or_dash(None if None in (time, first) else 1e3 * (time - first), '+.6f'):>12}",
            f"{answer['samples']:>7}",
            f"{_or_dash(answer['tests'], 'd'):>12}",
            f"{answer['wall_seconds']:7.2f}",
        )
        lines.append("  ".join(cells))
    return "\n".join(lines)


def _or_dash(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def summary(run: Run) -> dict[str, Any]:
    """What `simulate --json` prints."""
    return run.to_dict()


def quality_in_words(run: Run) -> str:
    """How far the engine drifted, and how fast it was."""
    return str(run).splitlines()[1]


def windows_in_words(run: Run) -> str:
    """When which benches touched."""
    return str(run.events)
