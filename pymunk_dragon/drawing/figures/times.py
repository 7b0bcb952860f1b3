"""Times that figures show: the first contact, the end of a march, and the closing of a full loop."""

from __future__ import annotations

import numpy as np

from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.drawing.snapshots import Source
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Begin and end of a time interval, s; None is the end of the curve.
TimeInterval = tuple[float, float | None]

# Bisection steps for the time at which a loop closes: they reduce an hour to a microsecond.
BISECTIONS = 32
# Fraction of a march without contact after which its last speeds are drawn: at the very end of a spiral a bench is
# perpendicular to it, and speeds are unbounded.
REGULAR_FRACTION = 0.95


def model() -> March:
    """Return the paper's small model: 16 benches, which close a full loop before the first contact (section 2.2)."""
    return March(Dragon(benches=16))


def spirals_in(march: March) -> bool:
    """Return whether a march goes inward around the origin, as on the paper's spiral."""
    return march.curve.inward


def time_interval(source: Source) -> TimeInterval:
    """Return the time interval that figures of a march show, s: to the end of its curve, or the times of a run.

    Raises
    ------
    ParameterError
        If the curve has no end and `source` is not a run.
    """
    march = source.march if isinstance(source, Run) else source
    if np.isfinite(march.end):
        return 0.0, None
    if not isinstance(source, Run):
        raise ParameterError("march", "one on a curve without end", "a run, which defines the time interval")
    return float(source.times[0]), float(source.times[-1])


def contact_or_end(march: March, interval: TimeInterval, *, touching: bool = False) -> FirstContact:
    """Return the exact first contact, or the end of the interval if there is no contact.

    Raises
    ------
    ParameterError
        If benches overlap at the start, or if `touching` is true and there is no contact.
    """
    hit = first_contact(march, start=interval[0], until=interval[1])
    if hit.status == "overlapping":
        pair = "{} and {}".format(*(hit.benches or ()))
        raise ParameterError("march", f"one whose benches {pair} overlap at the start", "one whose benches are apart")
    if touching and hit.status != "contact":
        raise ParameterError("march", f"clear until {hit.time:g} s", "one that runs into itself")
    return hit


def last_regular_time(hit: FirstContact, since: float) -> tuple[float, bool]:
    """Return the time of the contact, s, or a time shortly before the end without contact, and whether it is one."""
    if hit.status == "contact":
        return hit.time, True
    return since + REGULAR_FRACTION * (hit.time - since), False


def closing_time(march: March, begin: float, end: float) -> float:
    """Return the time, s, at which the dragon closes a full loop: the path turns by 2 pi between tail and head.

    If the loop is closed at `begin` or still open at `end`, the result is the midpoint of the two.
    """
    if _turn_angle(march, begin) >= 2 * np.pi or _turn_angle(march, end) < 2 * np.pi:
        return (begin + end) / 2
    before, after = begin, end
    for _ in range(BISECTIONS):
        middle = (before + after) / 2
        if _turn_angle(march, middle) < 2 * np.pi:
            before = middle
        else:
            after = middle
    return after


def _turn_angle(march: March, time: float) -> float:
    """Return the angle, rad, by which the path turns between the tail and the head."""
    tangents = march.curve.tangent(march.handles_s(time)[0])
    angles = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
    return float(abs(angles[0] - angles[-1]))
