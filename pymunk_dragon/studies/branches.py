"""Continuation of a first contact, and of a smallest pitch, while one size of the benches changes.

Two benches touch where their gap is zero. The gap stays zero along a branch of head positions, or of pitches, whose
slope follows from the implicit function theorem. The branch ends where a corner slides off the edge that it touches, or
where one of the near misses closes first. Points of the branch and near misses are computed by Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.errors import DragonError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.curves.spiral import MIN_PITCH
from pymunk_dragon.model.march import March
from pymunk_dragon.studies.gaps import QUANTITIES, TRAVELLED, Gaps, gaps_of
from pymunk_dragon.studies.min_pitch import distance_to_circle
from pymunk_dragon.studies.sampled_gaps import minimal_gaps

__all__ = ["BRACKET", "Branch", "ContactBranch", "ContinuationPoint", "NearMisses", "TangencyBranch", "perturbed"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Newton steps, at most; four suffice.
MAX_NEWTON_STEPS = 40
# m. Largest gap that counts as zero: tens of times its rounding error.
GAP_TOLERANCE = 1e-13
# m. Largest Newton step along the spiral that counts as zero; its effect on a minimal gap is of second order.
STEP_TOLERANCE = 1e-7
# m travelled by the head. Difference step for the second derivative of a gap at its minimum.
DIFFERENCE_STEP = 1e-3
# m travelled by the head. A contact or a near miss is searched within this distance of its predicted position: a
# fraction of a bench, within which a gap has a single minimum.
BRACKET = 0.5


@dataclass(frozen=True)
class ContinuationPoint:
    """A point of a branch.

    Attributes
    ----------
    march : March
        The march with the changed size, at 1 m/s.
    reference : float
        Distance travelled, m, from which positions of near misses are measured. Their offsets from it hardly change.
    end : float
        Distance travelled, m, up to which near misses count.
    contact : Gaps
        Gap of the two benches that touch.
    rate : float
        Derivative of the branch by the size: m travelled, or m of pitch, per m.
    """

    march: March
    reference: float
    end: float
    contact: Gaps
    rate: float


class Branch(Protocol):
    """A contact or a tangency as a function of one size."""

    def at(self, change: float) -> ContinuationPoint:
        """The point where the size has changed by `change` m; raises `DragonError` beyond the end of the branch."""
        ...

    def total_slopes(self, gaps: Gaps, point: ContinuationPoint) -> Array:
        """Total derivatives (P,) of other gaps by the size along the branch, m per m."""
        ...


class ContactBranch:
    """Distance travelled by the head at a first contact, as a function of one size."""

    def __init__(self, march: March, travelled: float, pair: tuple[int, int], size: str) -> None:
        self._march, self._pair, self._size = march, pair, size
        self._column = QUANTITIES.index(size)
        self._points: dict[float, ContinuationPoint] = {}
        self._begin = travelled

    def at(self, change: float) -> ContinuationPoint:
        """As in `Branch`, by continuation from the closest point that has been computed."""
        if change not in self._points:
            march, begin, predicted = perturbed(self._march, self._size, change), self._begin, 0.0
            if self._points:
                closest = min(self._points, key=lambda known: abs(known - change))
                begin = self._points[closest].reference
                predicted = self._points[closest].rate * (change - closest)
            # Close to the end of a branch the tangent may lead beyond it, so the second attempt omits the predictor.
            contact = self._contact(march, begin + predicted) or self._contact(march, begin)
            if contact is None:
                raise DragonError(f"benches {self._pair} do not touch at this size")
            travelled = float(contact.travelled[0])
            rate = -float(contact.slopes[0, self._column] / contact.slopes[0, TRAVELLED])
            self._points[change] = ContinuationPoint(march, travelled, travelled, contact, rate)
        return self._points[change]

    def _contact(self, march: March, travelled: float) -> Gaps | None:
        """Zero of the gap close to `travelled` m, by Newton's method; None if the method does not converge."""
        begin = travelled
        for _ in range(MAX_NEWTON_STEPS):
            contact = gaps_of(march, travelled, self._pair)
            gap, slope = float(contact.gaps[0]), float(contact.slopes[0, TRAVELLED])
            if abs(gap) <= GAP_TOLERANCE:
                return contact if slope < 0 else None
            if abs(gap) > BRACKET * abs(slope):
                break
            travelled -= gap / slope
            if abs(travelled - begin) > BRACKET:
                break
        return None

    def total_slopes(self, gaps: Gaps, point: ContinuationPoint) -> Array:
        """As in `Branch`, including the motion of the head's last position, where a gap may have its minimum."""
        total: Array = gaps.slopes[:, self._column] + gaps.slopes[:, TRAVELLED] * point.rate
        return total


class TangencyBranch:
    """Pitch at which the minimal gap of two benches on the inward spiral is zero, as a function of one size."""

    def __init__(self, march: March, travelled: float, pair: tuple[int, int], radius: float, size: str) -> None:
        self._march, self._pair, self._radius, self._size = march, pair, radius, size
        self._column = QUANTITIES.index(size)
        assert isinstance(march.curve, Spiral)
        self._points: dict[float, ContinuationPoint] = {}
        self._begin = march.curve.pitch, distance_to_circle(march, radius) - travelled

    def at(self, change: float) -> ContinuationPoint:
        """As in `Branch`, by continuation from the closest point that has been computed."""
        if change not in self._points:
            pitch, remaining = self._begin
            if self._points:
                closest = min(self._points, key=lambda known: abs(known - change))
                known = self._points[closest]
                assert isinstance(known.march.curve, Spiral)
                pitch = known.march.curve.pitch + known.rate * (change - closest)
                remaining = known.reference - float(known.contact.travelled[0])
            self._points[change] = self._tangency(perturbed(self._march, self._size, change), pitch, remaining)
        return self._points[change]

    def _tangency(self, other: March, pitch: float, remaining: float) -> ContinuationPoint:
        """Newton's method for the pitch and for the distance that remains to the circle, m."""
        for _ in range(MAX_NEWTON_STEPS):
            march = replace(other, curve=Spiral(pitch=pitch))
            end = distance_to_circle(march, self._radius)
            contact = gaps_of(march, end - remaining + DIFFERENCE_STEP * np.array([-1, 0, 1]), [self._pair] * 3)
            before, slope, after = contact.slopes[:, TRAVELLED].tolist()
            if before >= after:
                break
            gap, step = float(contact.gaps[1]), 2 * DIFFERENCE_STEP * slope / (after - before)
            if abs(gap) <= GAP_TOLERANCE and abs(step) <= STEP_TOLERANCE:
                contact = gaps_of(march, end - remaining, self._pair)
                rate = -float(contact.slopes[0, self._column] / contact.slopes_at_radius[0])
                return ContinuationPoint(march, end, end, contact, rate)
            remaining, pitch = remaining + step, pitch - gap / float(contact.slopes_at_radius[1])
            if not (0 <= remaining < end and pitch > MIN_PITCH):
                break
        raise DragonError(f"benches {self._pair} are not tangent at this size")

    def total_slopes(self, gaps: Gaps, point: ContinuationPoint) -> Array:
        """As in `Branch`, at a fixed distance of the head from the centre."""
        total: Array = gaps.slopes[:, self._column] + gaps.slopes_at_radius * point.rate
        return total


def perturbed(march: March, size: str, change: float) -> March:
    """A march with one size changed by `change` m; a size that each bench has of its own changes on all benches."""
    if size == "pitch":
        assert isinstance(march.curve, Spiral)
        return replace(march, curve=Spiral(pitch=march.curve.pitch + change))
    value = getattr(march.dragon, size)
    more: Any = value + change if isinstance(value, float) else tuple(each + change for each in value)
    return replace(march, dragon=replace(march.dragon, **{size: more}))


class NearMisses:
    """Near misses along a branch.

    Parameters
    ----------
    pairs : ndarray, shape (K, 2)
        Numbers of the benches.
    offsets : ndarray, shape (K,)
        Distances travelled from the branch's reference to the minima of the gaps, m.
    """

    def __init__(self, pairs: Indices, offsets: Array) -> None:
        self._pairs, self._offsets = pairs, offsets

    def at(self, point: ContinuationPoint) -> Gaps:
        """Minimal gaps at a point of the branch, searched about the positions of the last call."""
        about = np.minimum(point.reference + self._offsets, point.end)
        gaps = minimal_gaps(point.march, self._pairs, about - BRACKET, np.minimum(about + BRACKET, point.end))
        self._offsets = gaps.travelled - point.reference
        return gaps
