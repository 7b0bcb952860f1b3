"""When figures look: at the first contact, and while the dragon moves in."""

from __future__ import annotations

import numpy as np

from pymunk_dragon.collision import Impact, first_contact
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March

__all__ = ["closing_time", "ending", "in_words", "last_look", "model"]

# Halvings of the time in which a loop closes: down to a microsecond of an hour.
HALVINGS = 32
# Share of the time at which a dragon is looked at that does not touch itself.
SHY = 0.95


def model() -> March:
    """The paper's small model: 16 benches, enough to close a full loop before the first contact (section 2.2)."""
    return March(Dragon(benches=16))


def ending(march: March, *, touching: bool = False) -> Impact:
    """The exact first contact, or where there is none the last moment.

    Raises
    ------
    ParameterError
        If benches overlap at the start already, or `touching` is asked for and none ever touch.
    """
    hit = first_contact(march)
    if hit.status == "overlapping":
        pair = "{} and {}".format(*(hit.benches or ()))
        raise ParameterError("march", f"one whose benches {pair} overlap at the start", "one whose benches are apart")
    if touching and hit.status != "contact":
        raise ParameterError("march", f"clear until {hit.time:g} s", "one that runs into itself")
    return hit


def in_words(hit: Impact) -> str:
    """What happens at the time of `hit`."""
    return "the first contact" if hit.status == "contact" else "the end"


def last_look(hit: Impact) -> tuple[float, str]:
    """Time of `hit`, s, and in words when that is; but where no contact comes, a little before.

    At the very end of the curve some bench stands square across it, and speeds have no bounds.
    """
    if hit.status == "contact":
        return hit.time, "at the first contact"
    return SHY * hit.time, "shortly before the end"


def closing_time(march: March, end: float) -> float:
    """When the dragon closes a full loop, s: its head has turned once more than its tail.

    Half of `end` where it has from the start, or has not by then.
    """
    if _turning(march, 0.0) >= 2 * np.pi or _turning(march, end) < 2 * np.pi:
        return end / 2
    before, after = 0.0, end
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
