"""Derivatives of the first contact's time and of the smallest pitch by every size of the benches.

They are central differences of the exact answers, accurate to 1e-7 s or mm for each millimetre. Where other benches
touch within a step, there is no derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pymunk_dragon._display import table
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._study import Progress, Result, Study, silent
from pymunk_dragon.studies.min_pitch import RADIUS, MinPitch, min_pitch

# Sizes of the benches by which both answers are differentiated.
SIZES = ("width", "overhang", "head_spacing", "body_spacing")
# m. Step of the differences: the rounding of the answers over the step, and the step's square times a third derivative,
# are below the last digit printed.
STEP = 1e-5

# A time, s, or a pitch, m, and the two benches that touch; None where none touch.
Answer = tuple[float, tuple[int, int] | None]


@dataclass(frozen=True, kw_only=True, repr=False)
class Sensitivity(Result):
    """Derivatives of the first contact's time and of the smallest pitch by every size.

    Attributes
    ----------
    contact, smallest : FirstContact, MinPitch
        The first contact and the smallest pitch.
    times, pitches : dict
        Derivatives of the first contact's time, s per m, by each of the `SIZES` and by the pitch, and of the smallest
        pitch, m per m; None where other benches touch, or none, within a hundredth of a millimetre. Where the benches
        differ, all change by the same amount.
    """

    contact: FirstContact
    smallest: MinPitch
    times: Mapping[str, float | None]
    pitches: Mapping[str, float | None]

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study sensitivity --json` prints them."""
        contact, smallest = self.contact, self.smallest
        return {
            "contact": {"time": contact.time, "benches": contact.benches, "slopes": self.times},
            "smallest_pitch": {"pitch": smallest.pitch, "benches": smallest.benches, "slopes": self.pitches},
        }

    def _lines(self) -> list[str]:
        time = text("first contact at t = {time:.9f} s").format(time=self.contact.time)
        pitch = text("smallest pitch {pitch:.12f} m").format(pitch=self.smallest.pitch)
        heads = (text("size"), text("s per mm"), text("mm per mm"))
        per_mm = {name: None if slope is None else slope / 1e3 for name, slope in self.times.items()}
        flags = {name: name.replace("_", "-") for name in per_mm}
        rows = [(text(flags[name]), slope, self.pitches.get(name)) for name, slope in per_mm.items()]
        return [time, pitch, *table(heads, ("<13", "+10.7f", "+10.7f"), rows)]


def sensitivity(
    dragon: Dragon | None = None,
    *,
    pitch: float = 0.55,
    turns: float = 16.0,
    speed: float = 1.0,
    radius: float = RADIUS,
    progress: Progress = silent,
) -> Sensitivity:
    """Derivatives of the first contact's time and of the smallest pitch by the sizes.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's.
    pitch
        As in `Spiral`, for the first contact, without which a `ParameterError` is raised.
    turns, speed, radius
        As in `min_pitch`.
    progress : callable, optional
        Called with the number of sizes that are done and the number of all.

    Examples
    --------
    >>> found = sensitivity(Dragon(benches=25))
    >>> round(found.times["width"] / 1e3, 4)  # s for each mm
    -0.032
    """
    dragon = dragon or Dragon()

    def contact(name: str, change: float) -> FirstContact:
        spiral = Spiral(pitch=pitch + change * (name == "pitch"))
        return first_contact(March(_changed(dragon, name, change), spiral, turns=turns, speed=speed))

    def time(name: str, change: float) -> Answer:
        found = contact(name, change)
        return found.time, found.benches

    def limit(name: str, change: float) -> Answer:
        found = min_pitch(_changed(dragon, name, change), turns=turns, radius=radius)
        return found.pitch, found.benches

    first = contact("", 0.0)
    if first.status != "contact":
        raise ParameterError("pitch", pitch, "one at which the dragon runs into itself")
    smallest = min_pitch(dragon, turns=turns, speed=speed, radius=radius)
    times, pitches = {"pitch": _slope("pitch", first.benches, time)}, dict[str, float | None]()
    for done, name in enumerate(SIZES, 1):
        times[name] = _slope(name, first.benches, time)
        pitches[name] = _slope(name, smallest.benches, limit)
        progress(done, len(SIZES))
    return Sensitivity(contact=first, smallest=smallest, times=times, pitches=pitches)


def _changed(dragon: Dragon, name: str, change: float) -> Dragon:
    """A dragon with one of the `SIZES` changed by `change` m, on all benches that have the size."""
    if name not in SIZES:
        return dragon
    changed: Any = (np.array(getattr(dragon, name)) + change).tolist()
    return replace(dragon, **{name: changed})


def _slope(name: str, benches: tuple[int, int] | None, answer: Callable[[str, float], Answer]) -> float | None:
    """Derivative by a size of the answers to changes of this size, if the same benches touch on both sides."""
    try:
        (less, before), (more, after) = answer(name, -STEP), answer(name, STEP)
    except DragonError:  # No such dragon, march or contact.
        return None
    return (more - less) / (2 * STEP) if before == after == benches else None


_SUMMARY = "effect of each size of the benches on first contact and that pitch"
STUDY = Study(name="sensitivity", summary=_SUMMARY, run=sensitivity, formats=(".json",))
