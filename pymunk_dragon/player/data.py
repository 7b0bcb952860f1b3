"""Data of the player page: sizes, positions and velocities over time, and events.

Positions and velocities are packed as short texts, which decode.js unpacks. Components are counted
in steps from an origin. The text has the fourth differences of the counts over time, which are near
zero where the motion is smooth. Counts fit into 32 bits and differences are taken modulo 2^32, so
that any jump is restored exactly. Signed numbers are folded (0, -1, 1, -2 become 0, 1, 2, 3) and
split into planes of bytes, the lowest first: the high bytes of small numbers are runs of zeros,
which compress well.
"""

import zlib
from base64 import b64encode
from dataclasses import asdict
from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.collision import Grid
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.contact import ContactWindow
from pymunk_dragon.model.dragon import hole_diameter
from pymunk_dragon.model.run import Run, position_errors
from pymunk_dragon.reports.summary import Summary
from pymunk_dragon.web.curve import CURVE_ERROR, curve_points

# Step of positions as a fraction of a bench's width: 0.2 micrometres at the contest's 0.3 m, so
# that a gap between two benches is known to a thousandth of a millimetre.
STEP = 1 / 1_500_000
# Step of the exact model's offsets as a fraction of a bench's width: 0.5 micrometres at the
# contest's 0.3 m.
_EXACT_STEP = 1 / 600_000
# Least step of the exact model's offsets as a fraction of the largest offset, so that the offsets
# of a run that is far off take few bytes.
_EXACT_SHARE = 1e-5
# Step of velocities times the frame interval, in steps of positions: both change interpolated
# positions equally.
_VELOCITY_STEP = 4
# Differences between the offsets' lengths and the position errors of a run, m, that come from
# rounding.
_ROUNDING = 1e-9
# Order of the differences. The paper's run takes 2.7 MB at order 2, 1.8 MB at order 3 and 1.1 MB at
# order 4.
_ORDER = 4
# Steps from the origin in either direction: the range of 32 bits, less one for rounding.
_MAX_COUNT = 2**31 - 2
# Shape and scale of packed vectors as JSON values, and their text.
_Packed = tuple[dict[str, Any], str]


def player_data(summary: Summary) -> tuple[dict[str, Any], dict[str, str]]:
    """Payload of the page as JSON values in m and s, and the texts of its packed vectors."""
    run = summary.run
    dragon = run.march.dragon
    narrowest = float(dragon.widths.min())
    begin, end = run.interval

    positions, position_error = _pack_handles(dragon.holes(run.poses), STEP * narrowest)
    interval = 1.0
    # A run of one frame has no interval.
    if len(run.times) > 1:
        interval = float(np.median(np.diff(run.times)))
    step = positions[0]["step"] * _VELOCITY_STEP / interval
    hole_velocities = dragon.hole_velocities(run.poses, run.pose_velocities)
    velocities, velocity_error = _pack_handles(hole_velocities, step)
    curve = curve_points(run.march, begin, end)

    packed: dict[str, _Packed] = {
        "handles": positions,
        "velocities": velocities,
        "exact": _pack_exact(run, narrowest),
        "curve": pack(curve[:, None], STEP * narrowest),
    }
    payload: dict[str, Any] = {}
    texts = {}
    for name, (shape, text) in packed.items():
        payload[name] = shape or None
        texts[name] = text

    # The exact model's near misses do not apply to benches that nothing holds on the path.
    near_misses = summary.near_misses or () if run.free_from is None else ()
    shown = [asdict(miss) for miss in near_misses if begin <= miss.time <= end]
    payload["dragon"] = asdict(dragon) | {"hole": hole_diameter(dragon)}
    payload["grid"] = asdict(Grid.of(run.march))
    payload["times"] = run.times.tolist()
    payload["near_misses"] = shown
    payload["windows"] = _contact_windows(run)
    payload["errors"] = [position_error, velocity_error]
    payload["curve_error"] = CURVE_ERROR * narrowest
    return payload, texts


def pack(vectors: Array, step: float, *, from_zero: bool = False) -> _Packed:
    """Pack `vectors` (F, H, 2) in steps of `step`, or of what the range of 32 bits needs.

    Steps are counted from zero, which is then exact, or from the middle of the vectors' range. A
    component is off by at most half a step.
    """
    low = vectors.min(axis=(0, 1))
    high = vectors.max(axis=(0, 1))
    origin = np.zeros(2) if from_zero else (low + high) / 2
    reach = np.maximum(high - origin, origin - low)
    step = max(step, float(reach.max()) / _MAX_COUNT)

    # By point, coordinate and time, so that the differences of one track are adjacent.
    counts = np.rint((vectors - origin) / step).astype(np.int64)
    counts = counts.transpose(1, 2, 0)
    for _ in range(_ORDER):
        counts = np.diff(counts, axis=-1, prepend=0)
    # Modulo 2^32.
    wrapped = counts.astype(np.int32)
    folded = ((wrapped << 1) ^ (wrapped >> 31)).astype("<u4")
    planes = np.ascontiguousarray(folded).view(np.uint8).reshape(-1, 4).T
    text = b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    frames, points, _ = vectors.shape
    shape = {"frames": frames, "points": points, "order": _ORDER}
    scale = {"origin": origin.tolist(), "step": step}
    return shape | scale, text


def _handle_vectors(front: Array, rear: Array) -> Array:
    """Vectors (F, H, 2) of the handles from those of all front and rear holes.

    Where two benches share a handle, it is the mean of their holes.
    """
    shared = (rear[:, :-1] + front[:, 1:]) / 2
    return np.hstack([front[:, :1], shared, rear[:, -1:]])


def _contact_windows(run: Run) -> list[dict[str, Any]]:
    """Contact windows of pairs by beginning; `end` is None if the benches touch until the run ends.

    The log begins a window at the end of a substep. The window of the first contact begins at the
    contact's time, and exists even if no event was logged.
    """
    windows = run.events.windows()
    first = run.first_contact
    if first is not None:
        # Its window takes the place of the one that the engine logged, if there is one.
        end = None
        for window in windows:
            if window.benches == first.benches and window.begin >= first.time:
                windows.remove(window)
                end = window.end
                break
        windows.append(ContactWindow(benches=first.benches, begin=first.time, end=end))
    windows.sort(key=lambda window: (window.begin, window.benches))
    return [asdict(window) for window in windows]


def _exact_offsets(run: Run) -> Array | None:
    """Vectors (K, H, 2) in m from the handles to the exact model's.

    There are those of the first K frames, in which the model has a state. None in a run of the
    exact model, whose benches have no error on the path and off it, and if the run's position
    errors are unknown or refer to other times, as after a change of the speed in a live session.
    """
    if run.player == "exact":
        return None
    has_state = np.isfinite(run.drift).all(axis=1)
    known = int(has_state.cumprod().sum())
    try:
        exact = run.march.at(run.times[:known]).positions
    except UnreachableError:
        return None

    dragon = run.march.dragon
    poses = run.poses[:known]
    errors = position_errors(dragon, poses, exact)
    same = np.allclose(errors, run.drift[:known], rtol=1e-6, atol=_ROUNDING)
    return exact - _handle_vectors(*dragon.holes(poses)) if same and known else None


def _pack_exact(run: Run, narrowest: float) -> _Packed:
    """Packed offsets of the exact model's handles; if they are unknown, no shape and no text."""
    offsets = _exact_offsets(run)
    if offsets is None:
        return {}, ""
    largest = float(np.abs(offsets).max())
    step = max(_EXACT_STEP * narrowest, _EXACT_SHARE * largest)
    return pack(offsets, step, from_zero=True)


def _pack_handles(holes: tuple[Array, Array], step: float) -> tuple[_Packed, float]:
    """Packed vectors of the handles, and their largest distance from the vectors of the holes."""
    front, rear = holes
    shared = _handle_vectors(front, rear)
    packed = pack(shared, step)
    front_openings = shared[:, :-1] - front
    rear_openings = shared[:, 1:] - rear
    openings = np.stack([front_openings, rear_openings])
    opening = np.linalg.norm(openings, axis=-1).max()
    # In both coordinates a packed vector is off by at most half a step.
    return packed, float(opening + packed[0]["step"] / np.sqrt(2))
