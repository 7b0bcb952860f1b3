"""Data of the player page: sizes, positions and velocities over time, and events."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.collision import FirstContact, Grid
from pymunk_dragon.drawing.scene import hole_diameter
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player.packing import Packed, packed

__all__ = ["PlayerData", "contact_windows", "curve_points", "handles", "player_data"]

Array = NDArray[np.float64]

# Share of a bench's width that one count of a position is: 0.2 micrometres at the contest's 0.3 m. A gap between two
# benches, which are off by up to 0.2 micrometres each, is then known to a thousandth of a millimetre.
STEP = 1 / 1_500_000
# Counts of a position per frame interval that one count of a velocity is. The rounding of velocities then changes
# interpolated positions by no more than the rounding of positions does.
VELOCITY_STEP = 4
# Share of a bench's width that the drawn curve may be off between two of its points: 0.1 mm at the contest's.
CURVE_ERROR = 1 / 3000
# Points of the curve: samples of its curvature, and the largest number in the page.
CURVE_SAMPLES, MAX_CURVE_POINTS = 4000, 20_000


@dataclass(frozen=True, kw_only=True)
class PlayerData:
    """A run as the page holds it.

    Attributes
    ----------
    payload : dict
        Everything else, as JSON values in m and s.
    handles : Packed
        Positions of the handles frame by frame.
    velocities : Packed or None
        Their velocities; None where the run does not know them.
    curve : Packed
        Points along the curve.
    """

    payload: dict[str, Any]
    handles: Packed
    velocities: Packed | None
    curve: Packed


def player_data(run: Run, impact: FirstContact | None) -> PlayerData:
    """Data of the page for `run`, with the exact model's first contact."""
    dragon = run.march.dragon
    narrowest = float(dragon.widths.min())
    begin, end = float(run.times[0]), float(run.times[-1])
    positions, position_error = _handles(dragon.holes(run.poses), STEP * narrowest)
    velocities, velocity_error = _velocities(run, positions.step)
    curve = packed(curve_points(run.march, begin, end)[:, None], STEP * narrowest)
    # The exact model's near misses do not apply to a dragon without a guide.
    on_path = run.guide != "none"
    misses = (impact and on_path and impact.near_misses) or ()
    payload = {
        "dragon": asdict(dragon) | {"hole": hole_diameter(dragon)},
        "grid": asdict(Grid.of(run.march)),
        "times": run.times.tolist(),
        "near": [asdict(miss) for miss in misses if begin <= miss.time <= end],
        "windows": contact_windows(run),
        "handles": _shape(positions),
        "velocities": velocities and _shape(velocities),
        "errors": [position_error, velocity_error],
        "curve": _shape(curve),
        "curve_error": CURVE_ERROR * narrowest,
    }
    return PlayerData(payload=payload, handles=positions, velocities=velocities, curve=curve)


def _velocities(run: Run, step: float) -> tuple[Packed | None, float]:
    """Velocities of the handles for positions that are packed in steps of `step` m, and their error in m/s."""
    intervals = np.diff(run.times)
    apart = intervals[intervals > 0]
    if run.pose_velocities is None and not apart.size:
        return None, 0.0
    step *= VELOCITY_STEP / (float(np.median(apart)) if apart.size else 1.0)
    return _handles(run.march.dragon.hole_velocities(run.poses, run.frame_velocities), step)


def _handles(holes: tuple[Array, Array], step: float) -> tuple[Packed, float]:
    """Vectors of the handles, packed, and how far they are at most from those of the holes."""
    front, rear = holes
    shared = handles(front, rear)
    whole = packed(shared, step)
    openings = (
        np.linalg.norm(own - hole, axis=-1).max() for own, hole in ((shared[:, :-1], front), (shared[:, 1:], rear))
    )
    return whole, float(max(openings) + whole.step / np.sqrt(2))


def handles(front: Array, rear: Array) -> Array:
    """Vectors (F, H, 2) of the handles from those of all front and rear holes; their mean where benches share one."""
    shared = (rear[:, :-1] + front[:, 1:]) / 2
    return np.concatenate([front[:, :1], shared, rear[:, -1:]], axis=1)


def contact_windows(run: Run) -> list[dict[str, Any]]:
    """When which benches touch, by beginning; without an `end` where they still do when the run ends.

    The log begins a window at the end of a substep. The first contact's begins when it truly does, and is there even
    if nothing was logged. What a file that was changed by hand says of benches or times that are none is left out.
    """
    windows = [asdict(window) for window in run.events.windows()]
    first = run.first_contact
    if first is not None:
        its = [window for window in windows if window["benches"] == first.benches and window["begin"] >= first.time]
        if its:
            its[0]["begin"] = first.time
        else:
            windows.append({"benches": first.benches, "begin": first.time, "end": None})
    known = [window for window in windows if _is_possible(window, run.march.dragon.benches)]
    return sorted(known, key=lambda window: (window["begin"], window["benches"]))


def _is_possible(window: dict[str, Any], benches: int) -> bool:
    end = window["begin"] if window["end"] is None else window["end"]
    return bool(window["benches"][1] < benches and np.isfinite(window["begin"]) and np.isfinite(end))


def curve_points(march: March, start: float, end: float) -> Array:
    """Points (P, 2) in m of the curve over `March.span`, closer where the curvature is larger.

    The span begins at the dragon's position at 0 s even if the run from `start` to `end` s is later.
    """
    curve = march.curve
    first, last = march.span(min(start, 0.0), max(end, 0.0))
    positions = np.linspace(first, last, CURVE_SAMPLES)
    # A chord c of a curve with the curvature k has an error of k c^2 / 8; this is the number of chords between samples.
    # On straight parts they are three times as long as the shortest: the page leaves out points when it is far away,
    # and a chord across a joint must not be much further off than others.
    curvature = curve.max_curvature(positions[:-1], positions[1:])
    curvature = np.where(curvature > 0, curvature, curvature.max() / 9)
    chords = np.sqrt(curvature / (8 * CURVE_ERROR * float(march.dragon.widths.min()))) * np.diff(positions)
    passed = np.concatenate([[0.0], np.cumsum(chords)])
    if passed[-1] == 0:
        # A straight one has nothing to go by, and needs nothing but its ends.
        return curve.point(positions[[0, -1]])
    count = int(min(passed[-1] + 2, MAX_CURVE_POINTS))
    return curve.point(np.interp(np.linspace(0.0, passed[-1], count), passed, positions))


def _shape(positions: Packed) -> dict[str, Any]:
    whole = asdict(positions)
    del whole["text"]
    return whole
