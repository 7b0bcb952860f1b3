"""Derivatives of the first contact's time and of the smallest pitch by every size of the benches.

They are central differences of the exact answers, accurate to 1e-7 s or mm for each millimetre. Where other benches
touch within a step, there is no derivative. The answers a millimetre to either side show how far a derivative holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from pymunk_dragon._display import table
from pymunk_dragon._language import text
from pymunk_dragon.collision import first_contact
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._study import Progress, Result, Study, silent
from pymunk_dragon.studies.min_pitch import RADIUS, MinPitch, min_pitch

# Sizes of the benches by which both answers are differentiated.
SIZES = ("width", "overhang", "head_spacing", "body_spacing")
# m. Step of the differences: the rounding of the answers over the step, and the step's square times a third derivative,
# are below the last digit printed. And the change of a size of which the answer is reported as well.
STEP, _MILLIMETRE = 1e-5, 1e-3

# Time of a first contact, s, or smallest pitch, m, and the two benches that touch; None without a contact.
_Known = tuple[float, tuple[int, int]]
Answer = _Known | None


@dataclass(frozen=True, kw_only=True)
class Slope:
    """Derivative of a result by one size.

    Attributes
    ----------
    size, value : str, float
        Name of the size, and the size, m; the least one where the benches differ, which all change by the same amount.
    slope : float or None
        Derivative, s per m or m per m; None where other benches touch, or none, within a hundredth of a millimetre.
    less, more : tuple or None
        Results, s or m, and benches for a size that is a millimetre smaller, and larger; None without a contact.
    """

    size: str
    value: float
    slope: float | None
    less: Answer
    more: Answer


@dataclass(frozen=True, kw_only=True, repr=False)
class Sensitivity(Result):
    """Derivatives of the first contact's time and of the smallest pitch by every size.

    Attributes
    ----------
    time, benches, times : float, tuple of int, tuple of Slope
        Time of the first contact, s, the two benches that touch, and derivatives by each size, and by the pitch.
    smallest, pitches : MinPitch, tuple of Slope
        The smallest pitch, and its derivatives by each size; none where the circle limits the pitch.
    """

    time: float
    benches: tuple[int, int]
    times: tuple[Slope, ...]
    smallest: MinPitch
    pitches: tuple[Slope, ...]

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study sensitivity --json` prints them."""
        times, pitches = ({row.size: asdict(row) for row in slopes} for slopes in (self.times, self.pitches))
        smallest = {"pitch": self.smallest.pitch, "benches": self.smallest.benches, "slopes": pitches}
        return {"contact": {"time": self.time, "benches": self.benches, "slopes": times}, "smallest_pitch": smallest}

    def _lines(self) -> list[str]:
        first = text("first contact at t = {time:.9f} s: benches {i} and {j}")
        first = first.format(time=self.time, i=self.benches[0], j=self.benches[1])
        lines = [first, *_table(text("s per mm"), 1e3, self.times, (self.time, self.benches))]
        pitch, benches = self.smallest.pitch, self.smallest.benches
        if benches is None:
            limited = text("smallest pitch {pitch:.12f} m: limited by the circle, whatever the benches")
            return [*lines, limited.format(pitch=pitch)]
        smallest = text("smallest pitch {pitch:.12f} m: benches {i} and {j}")
        smallest = smallest.format(pitch=pitch, i=benches[0], j=benches[1])
        return [*lines, smallest, *_table(text("mm per mm"), 1.0, self.pitches, (pitch, benches))]


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
    >>> width = sensitivity(Dragon(benches=25)).times[0]
    >>> width.size, round(width.slope / 1e3, 4)  # s for each mm
    ('width', -0.032)
    """
    dragon = dragon or Dragon()

    def contact(name: str, change: float) -> _Known:
        spiral = Spiral(pitch=pitch + change * (name == "pitch"))
        hit = first_contact(March(_changed(dragon, name, change), spiral, turns=turns, speed=speed))
        if hit.status != "contact" or hit.benches is None:
            raise ParameterError("pitch", pitch, "one at which the dragon runs into itself")
        return hit.time, hit.benches

    def limit(name: str, change: float) -> Answer:
        found = min_pitch(_changed(dragon, name, change), turns=turns, radius=radius)
        return None if found.benches is None else (found.pitch, found.benches)

    time, benches = contact("", 0.0)
    smallest = min_pitch(dragon, turns=turns, speed=speed, radius=radius)
    times, pitches = [], []
    for done, name in enumerate((*SIZES, "pitch"), 1):
        value = pitch if name == "pitch" else float(np.min(getattr(dragon, name)))
        times.append(_slope(name, value, benches, contact))
        if smallest.benches is not None and name != "pitch":
            pitches.append(_slope(name, value, smallest.benches, limit))
        progress(done, len(SIZES) + 1)
    return Sensitivity(time=time, benches=benches, times=tuple(times), smallest=smallest, pitches=tuple(pitches))


def _changed(dragon: Dragon, name: str, change: float) -> Dragon:
    """A dragon with one of the `SIZES` changed by `change` m, on all benches that have the size."""
    if name not in SIZES:
        return dragon
    changed: Any = (np.array(getattr(dragon, name)) + change).tolist()
    return replace(dragon, **{name: changed})


def _slope(name: str, value: float, benches: tuple[int, int], answer: Callable[[str, float], Answer]) -> Slope:
    """Derivative by a size of the answers to changes of this size, as long as these benches touch."""

    def changed(change: float) -> Answer:
        try:
            return answer(name, change)
        except DragonError:  # No such dragon, march or contact.
            return None

    less, more, slope = changed(-STEP), changed(STEP), None
    if less is not None and more is not None and less[1] == more[1] == benches:
        slope = (more[0] - less[0]) / (2 * STEP)
    return Slope(size=name, value=value, slope=slope, less=changed(-_MILLIMETRE), more=changed(_MILLIMETRE))


def _table(unit: str, per: float, slopes: Sequence[Slope], base: _Known) -> list[str]:
    """Lines of a table of derivatives per mm, with their unit, and of changes; `per` converts them from SI units."""

    def change(answer: Answer) -> str | None:
        if answer is None:
            return None
        shown = f"{1e3 / per * (answer[0] - base[0]):+.6f}"
        return shown if answer[1] == base[1] else shown + " " + text("({} and {})").format(*answer[1])

    heads = (" " + text("size"), text("now (mm)"), unit, text("1 mm less"), text("1 mm more"))
    rows = []
    for row in slopes:
        name, slope = row.size.replace("_", "-"), None if row.slope is None else row.slope / per
        rows.append((" " + text(name), 1e3 * row.value, slope, change(row.less), change(row.more)))
    return table(heads, ("<13", "8.2f", "+10.7f", "<20", ""), rows)


_SUMMARY = "effect of each size of the benches on first contact and that pitch"
STUDY = Study(name="sensitivity", summary=_SUMMARY, run=sensitivity, formats=(".json",))
