"""Results of the engine as the program prints them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from pymunk_dragon._text import contact_text, table
from pymunk_dragon.model.run import Run


def contact_in_words(run: Run) -> str:
    """When and where benches first touch."""
    touch = run.first_contact
    if touch is None:
        return contact_text(run.outcome, None, None, float(run.times[-1]))
    return contact_text(run.outcome, touch.benches, touch.point, touch.time)


def summary(run: Run) -> dict[str, Any]:
    """What `simulate --json` prints."""
    wall, stepping = run.timing["wall_seconds"], run.timing["step_seconds"]
    simulated = run.provenance["substeps"] * run.provenance["substep"]
    return {
        "status": run.outcome,
        "first_contact": asdict(run.first_contact) if run.first_contact else None,
        "drift": {"head": _known(run.head_drift), "max": _known(run.max_drift)},
        "start": run.provenance["start"],
        "until": float(run.times[-1]),
        "substep": run.provenance["substep"],
        "substeps": run.provenance["substeps"],
        "iterations": run.provenance["iterations"],
        "events": len(run.events),
        "wall_seconds": wall,
        "realtime_factor": simulated / wall,
        "driver_overhead": wall / stepping - 1,
    }


def _known(value: float) -> float | None:
    """JSON has no nan."""
    return value if value == value else None


def quality_in_words(run: Run) -> str:
    """How far the engine drifted, and how fast it was."""
    speed = summary(run)["realtime_factor"]
    return (
        f"drift {1e3 * run.head_drift:.3f} mm in the first twelve benches, {1e3 * run.max_drift:.3f} mm anywhere; "
        f"{speed:.1f} times as fast as real time"
    )


def windows_in_words(run: Run) -> str:
    """When which benches touched."""
    rows = (
        ("{:3d} {:3d}".format(*window.benches), window.begin, "the end" if window.end is None else f"{window.end:.3f}")
        for window in run.events.windows()
    )
    return "\n".join(table("benches   touch from (s)  to (s)", ("", "14.3f", ""), rows))
