"""What becomes of a contact, and of a smallest pitch, while one size of the benches changes.

Two benches touch where one gap is zero, and it stays zero along a branch of places of the head, or of pitches, that has
the slope of the implicit function theorem. The branch ends where a corner slides off the edge that it touches, or where
another gap, one of the near misses, closes first. Both are found by Newton's method along the branch.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.curves import Spiral
from pymunk_dragon.curves.spiral import MIN_PITCH
from pymunk_dragon.errors import DragonError
from pymunk_dragon.march import March
from pymunk_dragon.studies.min_pitch import way_to
from pymunk_dragon.studies.passing import smallest_between
from pymunk_dragon.studies.slopes import QUANTITIES, WAY, Gaps, gaps_of

__all__ = ["ASIDE", "Branch", "Grazing", "Meeting", "Misses", "Stand", "changed"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Newton's steps, of which it needs four; m, the gap and the way that are none.
STEPS, NO_GAP, NO_WAY = 40, 1e-13, 1e-7
# m: between places of the head at which it is seen how a smallest gap bends.
APART = 1e-3
# m: as far to either side of where a contact or a near miss is expected it is looked for.
ASIDE = 0.5


@dataclass(frozen=True)
class Stand:
    """A place on a branch.

    Attributes
    ----------
    march : March
        With the size changed, at 1 m/s.
    anchor : float
        Way of the head, m, from which those to near misses are counted, because they stay about the same.
    last : float
        Way of the head, m, as far as which near misses count.
    touch : Gaps
        The two benches that touch.
    moves : float
        How the branch's place moves with the size: m of way, or of pitch, for each m.
    """

    march: March
    anchor: float
    last: float
    touch: Gaps
    moves: float


class Branch(Protocol):
    """A contact, or a grazing, as one size changes."""

    def stand(self, change: float) -> Stand:
        """Where it is once the size has changed by so many m; a `DragonError` where it has come to an end."""
        ...

    def total(self, gaps: Gaps, stand: Stand) -> Array:
        """Slopes (P,) of other gaps by the size, along the branch, m for each m."""
        ...


class Meeting:
    """The place of the head at a first contact."""

    def __init__(self, march: March, way: float, pair: tuple[int, int], name: str) -> None:
        self._march, self._pair, self._name = march, pair, name
        self._column = QUANTITIES.index(name)
        self._known: dict[float, Stand] = {}
        self._begin = way

    def stand(self, change: float) -> Stand:
        """As in `Branch`, from the nearest place that is known."""
        if change not in self._known:
            march, begin, ahead = changed(self._march, self._name, change), self._begin, 0.0
            if self._known:
                near = min(self._known, key=lambda known: abs(known - change))
                begin, ahead = self._known[near].anchor, self._known[near].moves * (change - near)
            # Close to its end a branch turns away from its tangent, and a step along it leads beyond.
            touch = self._met(march, begin + ahead) or self._met(march, begin)
            if touch is None:
                raise DragonError(f"benches {self._pair} do not meet any more")
            way, moves = float(touch.ways[0]), -float(touch.slopes[0, self._column] / touch.slopes[0, WAY])
            self._known[change] = Stand(march, way, way, touch, moves)
        return self._known[change]

    def _met(self, march: March, way: float) -> Gaps | None:
        """Where the gap closes near `way`, by Newton's method; None where it does not."""
        begin = way
        for _ in range(STEPS):
            touch = gaps_of(march, way, self._pair)
            gap, slope = float(touch.gaps[0]), float(touch.slopes[0, WAY])
            if abs(gap) <= NO_GAP:
                return touch if slope < 0 else None
            if abs(gap) > ASIDE * abs(slope):
                break
            way -= gap / slope
            if abs(way - begin) > ASIDE:
                break
        return None

    def total(self, gaps: Gaps, stand: Stand) -> Array:
        """As in `Branch`: one that is smallest only because the head stops there changes as it stops elsewhere."""
        total: Array = gaps.slopes[:, self._column] + gaps.slopes[:, WAY] * stand.moves
        return total


class Grazing:
    """The pitch at which two benches just graze each other on the way to a circle."""

    def __init__(self, march: March, way: float, pair: tuple[int, int], radius: float, name: str) -> None:
        self._march, self._pair, self._radius, self._name = march, pair, radius, name
        self._column = QUANTITIES.index(name)
        assert isinstance(march.curve, Spiral)
        self._known: dict[float, Stand] = {}
        self._begin = march.curve.pitch, way_to(march, radius) - way

    def stand(self, change: float) -> Stand:
        """As in `Branch`, from the nearest place that is known."""
        if change not in self._known:
            pitch, left = self._begin
            if self._known:
                near = min(self._known, key=lambda known: abs(known - change))
                known = self._known[near]
                assert isinstance(known.march.curve, Spiral)
                pitch = known.march.curve.pitch + known.moves * (change - near)
                left = known.anchor - float(known.touch.ways[0])
            self._known[change] = self._grazed(changed(self._march, self._name, change), pitch, left)
        return self._known[change]

    def _grazed(self, other: March, pitch: float, left: float) -> Stand:
        """Newton's method for the pitch, and for the way that is left to the circle, m."""
        for _ in range(STEPS):
            march = replace(other, curve=Spiral(pitch=pitch))
            end = way_to(march, self._radius)
            touch = gaps_of(march, end - left + APART * np.array([-1, 0, 1]), [self._pair] * 3)
            before, fall, after = touch.slopes[:, WAY].tolist()
            if before >= after:
                break
            gap, forward = float(touch.gaps[1]), 2 * APART * fall / (after - before)
            if abs(gap) <= NO_GAP and abs(forward) <= NO_WAY:
                touch = gaps_of(march, end - left, self._pair)
                moves = -float(touch.slopes[0, self._column] / touch.slopes_on_circle[0])
                return Stand(march, end, end, touch, moves)
            left, pitch = left + forward, pitch - gap / float(touch.slopes_on_circle[1])
            if not (0 <= left < end and pitch > MIN_PITCH):
                break
        raise DragonError(f"benches {self._pair} do not graze each other any more")

    def total(self, gaps: Gaps, stand: Stand) -> Array:
        """As in `Branch`, the head being on the same circle."""
        total: Array = gaps.slopes[:, self._column] + gaps.slopes_on_circle * stand.moves
        return total


def changed(march: March, name: str, change: float) -> March:
    """The march with one of its sizes changed by so many m, that of all benches where each has its own."""
    if name == "pitch":
        assert isinstance(march.curve, Spiral)
        return replace(march, curve=Spiral(pitch=march.curve.pitch + change))
    value = getattr(march.dragon, name)
    more: Any = value + change if isinstance(value, float) else tuple(each + change for each in value)
    return replace(march, dragon=replace(march.dragon, **{name: more}))


class Misses:
    """Near misses on the way of a branch.

    Parameters
    ----------
    pairs : ndarray, shape (K, 2)
        Of benches.
    offsets : ndarray, shape (K,)
        Ways from the branch's anchor to where their gaps are smallest, m.
    """

    def __init__(self, pairs: Indices, offsets: Array) -> None:
        self._pairs, self._offsets = pairs, offsets

    def at(self, stand: Stand) -> Gaps:
        """Their smallest gaps, about where they were last."""
        about = np.minimum(stand.anchor + self._offsets, stand.last)
        gaps = smallest_between(stand.march, self._pairs, about - ASIDE, np.minimum(about + ASIDE, stand.last))
        self._offsets = gaps.ways - stand.anchor
        return gaps
