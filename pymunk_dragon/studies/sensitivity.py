"""Derivatives of the first contact's time and of the smallest pitch by every size of the benches.

The method is central differences of the exact answers, accurate to 1e-7 s or mm for each
millimetre. Where other benches touch within a step, there is no derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from pymunk_dragon._checks import function, silent
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model._display import table
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._study import Progress, Result, checked_dragon
from pymunk_dragon.studies.min_pitch import RADIUS, MinPitch, min_pitch

# Sizes of the benches by which both answers are differentiated.
_SIZES = ("width", "overhang", "head_spacing", "body_spacing")
# m. Step of the differences: the rounding of the answers over the step, and the step's square times
# a third derivative, are below the last digit printed.
_STEP = 1e-5


@dataclass(frozen=True, kw_only=True, repr=False)
class Sensitivity(Result):
    """Derivatives of the first contact's time and of the smallest pitch by every size.

    Attributes
    ----------
    contact : FirstContact
        The first contact.
    smallest : MinPitch
        The smallest pitch.
    times : dict
        Derivatives of the first contact's time, s per m, by each of the `_SIZES`; None where other
        benches touch, or none, within a hundredth of a millimetre. Where the benches differ, all
        change by the same amount.
    pitches : dict
        Derivatives of the smallest pitch, m per m, in the same form.
    """

    contact: FirstContact
    smallest: MinPitch
    times: Mapping[str, float | None]
    pitches: Mapping[str, float | None]

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study sensitivity --json` prints them."""
        contact = self.contact
        smallest = self.smallest
        return {
            "contact": {"time": contact.time, "benches": contact.benches, "slopes": self.times},
            "smallest_pitch": {
                "pitch": smallest.pitch,
                "benches": smallest.benches,
                "slopes": self.pitches,
            },
        }

    def _lines(self) -> list[str]:
        time = text("first contact at t = {time:.9f} s", time=self.contact.time)
        pitch = text("smallest pitch {pitch:.12f} m", pitch=self.smallest.pitch)
        heads = (text("size"), text("s per mm"), text("mm per mm"))
        labels = [name.replace("_", "-") for name in self.times]
        per_mm = [None if slope is None else slope / 1e3 for slope in self.times.values()]
        rows = zip(map(text, labels), per_mm, self.pitches.values(), strict=True)
        return [time, pitch, *table(heads, ("<13", "+10.7f", "+10.7f"), rows)]


def slopes(
    dragon: Dragon,
    answers: Callable[[Dragon], Sequence[tuple[float, Any]]],
    progress: Progress = silent,
) -> list[dict[str, Any]]:
    """Derivatives of each answer by the sizes of the benches, per m, from central differences.

    Answers come with the benches that touch: where others do within a step, the value is None.
    """
    known = answers(dragon)
    found: list[dict[str, Any]] = [{} for _ in known]
    for done, name in enumerate(_SIZES, 1):
        size = np.array(getattr(dragon, name))
        changed = (replace(dragon, **{name: (size + side).tolist()}) for side in (-_STEP, _STEP))
        rows = zip(found, known, *map(answers, changed), strict=True)
        for each, (_, benches), (before, one), (after, other) in rows:
            same = benches == one == other
            each[name] = (after - before) / (2 * _STEP) if same else None
        progress(done, len(_SIZES))
    return found


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
    pitch : float
        Pitch of the spiral for the first contact, m; a `ParameterError` if there is no contact.
    turns : float
        Turn of the spiral from which the head starts, as in `min_pitch`.
    speed : float
        Speed of the head, m/s, as in `min_pitch`.
    radius : float
        Radius of the circle, m, as in `min_pitch`.
    progress : callable, optional
        Called with the number of sizes that are done and the number of all.

    Examples
    --------
    >>> found = sensitivity(Dragon(benches=25))
    >>> round(found.times["width"] / 1e3, 4)  # s for each mm
    -0.032
    """
    dragon = checked_dragon(dragon)
    function("progress", progress)

    @cache
    def results(dragon: Dragon) -> tuple[FirstContact, MinPitch]:
        march = March(dragon, Spiral(pitch=pitch), turns=turns, speed=speed)
        return first_contact(march), min_pitch(dragon, turns=turns, speed=speed, radius=radius)

    contact, smallest = results(dragon)
    if contact.status != "contact":
        raise ParameterError("pitch", pitch, "one at which the dragon runs into itself")

    def answers(dragon: Dragon) -> list[tuple[float, Any]]:
        contact, smallest = results(dragon)
        return [(contact.time, contact.benches), (smallest.pitch, smallest.benches)]

    times, pitches = slopes(dragon, answers, progress)
    return Sensitivity(contact=contact, smallest=smallest, times=times, pitches=pitches)
