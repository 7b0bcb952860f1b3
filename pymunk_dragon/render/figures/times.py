"""When figures look: at the first contact, and while the dragon moves in."""

from __future__ import annotations

import numpy as np

from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.curves import Spiral
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.render.moments import Source
from pymunk_dragon.run import Run

__all__ = ["Stretch", "closing_time", "ending", "in_words", "last_look", "model", "spirals_in", "stretch"]

# First and last time, s; None is the end of the curve.
Stretch = tuple[float, float | None]

# Halvings of the time in which a loop closes: down to a microsecond of an hour.
HALVINGS = 32
# Share of the time at which a dragon is looked at that does not touch itself.
SHY = 0.95


def model() -> March:
    """The paper's small model: 16 benches, enough to close a full loop before the first contact (section 2.2)."""
    return March(Dragon(benches=16))


def spirals_in(march: March) -> bool:
    """Whether it is a march like the paper's, which coils ever tighter."""
    return isinstance(march.curve, Spiral) and not march.curve.outward


def stretch(source: Source) -> Stretch:
    """From when to when a figure looks at a march, s, to the end of its curve; on one without end, as long as a run.

    Raises
    ------
    ParameterError
        If the curve has no end, and `source` is no run.
    """
    march = source.march if isinstance(source, Run) else source
    if np.isfinite(march.end):
        return 0.0, None
    if not isinstance(source, Run):
        raise ParameterError("march", "one on a curve without end", "a run, which tells from when to when to look")
    return float(source.times[0]), float(source.times[-1])


def ending(march: March, look: Stretch, *, touching: bool = False) -> FirstContact:
    """The exact first contact, or where there is none the last moment.

    Raises
    ------
    ParameterError
        If benches overlap at the start already, or `touching` is asked for and none ever touch.
    """
    hit = first_contact(march, start=look[0], until=look[1])
    if hit.status == "overlapping":
        pair = "{} and {}".format(*(hit.benches or ()))
        raise ParameterError("march", f"one whose benches {pair} overlap at the start", "one whose benches are apart")
    if touching and hit.status != "contact":
        raise ParameterError("march", f"clear until {hit.time:g} s", "one that runs into itself")
    return hit


def in_words(hit: FirstContact) -> str:
    """What happens at the time of `hit`."""
    return "the first contact" if hit.status == "contact" else "the end"


def last_look(hit: FirstContact, since: float) -> tuple[float, str]:
    """Time of `hit`, s, and in words when that is; but where no contact comes, a little before.

    At the very end of a spiral some bench stands square across it, and speeds have no bounds.
    """
    if hit.status == "contact":
        return hit.time, "at the first contact"
    return since + SHY * (hit.time - since), "shortly before the end"


def closing_time(march: March, begin: float, end: float) -> float:
    """When the dragon closes a full loop, s: its head has turned once more than its tail.

    Midway between `begin` and `end` where it has from the start, or has not by then.
    """
    if _turning(march, begin) >= 2 * np.pi or _turning(march, end) < 2 * np.pi:
        return (begin + end) / 2
    before, after = begin, end
    for _ in range(HALVINGS):
        middle = (before + after) / 2
        if _turning(march, middle) < 2 * np.pi:
            before = middle
        else:
            after = middle
    return after


def _turning(march: March, time: float) -> float:
    """Angle in rad by which the path turns between the tail and the head."""
    tangents = march.curve.tangent(march.parameters(time)[0])
    angles = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
    return float(abs(angles[0] - angles[-1]))
