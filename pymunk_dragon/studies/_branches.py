"""Continuation of a first contact, and of a smallest pitch, while one size of the benches changes.

Two benches touch where their gap is zero. The gap stays zero along a branch of head positions, or of pitches, whose
slope follows from the implicit function theorem. The branch ends where a corner slides off the edge that it touches, or
where one of the near misses closes first. Points of the branch and near misses are computed by Newton's method.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._arrays import Array
from pymunk_dragon.errors import DragonError
from pymunk_dragon.model.curves.spiral import MIN_PITCH
from pymunk_dragon.studies._gaps import QUANTITIES, TRAVELLED, Gaps, InwardMarch, gaps_of, minimal_gaps
from pymunk_dragon.studies._study import bracketed

Change = Literal["another pair", "another corner", "no contact", "nothing"]
Pair = tuple[int, int]

# Newton steps, at most; four suffice.
MAX_NEWTON_STEPS = 40
# m. Largest gap that counts as zero in Newton's method: tens of times its rounding error.
NEWTON_TOLERANCE = 1e-13
# m. Largest Newton step along the spiral that counts as zero; its effect on a minimal gap is of second order.
STEP_TOLERANCE = 1e-7
# m travelled by the head. Difference step for the second derivative of a gap at its minimum.
DIFFERENCE_STEP = 1e-3
# m travelled by the head. A contact or a near miss is searched within this distance of its predicted position: a
# fraction of a bench, within which a gap has a single minimum.
BRACKET = 0.5
# m. Largest gap of a near miss that counts as zero.
GAP_TOLERANCE = 1e-10
# Least number of continuation steps up to the largest change.
MIN_STEPS = 5
# Largest number of continuation steps; a branch that needs more has not converged.
MAX_STEPS = 60
# Relative width of the bracket of a change at which other benches touch first, as it is reported.
RELATIVE_BRACKET = 1e-3


@dataclass(frozen=True, kw_only=True)
class Reach:
    """Range of a size, in one direction, in which the same benches touch at the same features.

    Attributes
    ----------
    unchanged : float
        Signed change, m, up to which the same two benches touch. The contact is checked there and along the branch.
    changed : float or None
        Signed change, m, at which the contact is another one; None if there is none up to a tenth of the size.
    by : {"another pair", "another corner", "no contact", "nothing"}
        What ends the range: another pair touches first; the same pair touches at other features; the pair no longer
        touches; or nothing.
    benches : tuple of int or None
        The pair that touches first beyond the range, if it is another one.
    """

    unchanged: float
    changed: float | None
    by: Change
    benches: Pair | None


@dataclass(frozen=True)
class ContinuationPoint:
    """A point of a branch."""

    # The march with the changed size.
    inward: InwardMarch
    # Distance travelled, m, from which positions of near misses are measured. Their offsets from it hardly change.
    reference: float
    # Distance travelled, m, up to which near misses count.
    end: float
    # Gap of the two benches that touch.
    contact: Gaps
    # Derivative of the branch by the size: m travelled, or m of pitch, per m.
    rate: float


class Branch(ABC):
    """A contact or a tangency of the benches `pair` as a function of one size, from `travelled` m on."""

    def __init__(self, inward: InwardMarch, travelled: float, pair: Pair, size: str) -> None:
        self.inward, self.size = inward, size
        self._travelled, self._pair, self._column = travelled, pair, QUANTITIES.index(size)
        self._points: dict[float, ContinuationPoint] = {}

    def at(self, change: float) -> ContinuationPoint:
        """The point where the size has changed by `change` m, by continuation from the closest point known so far.

        Raises `DragonError` beyond the end of the branch.
        """
        if change not in self._points:
            closest = min(self._points, key=lambda known: abs(known - change), default=0.0)
            inward = self.inward.changed(self.size, change)
            self._points[change] = self._point(inward, self._points.get(closest), change - closest)
        return self._points[change]

    @abstractmethod
    def _point(self, inward: InwardMarch, known: ContinuationPoint | None, step: float) -> ContinuationPoint:
        """The point for a changed march, from a known point at which the size is smaller by `step` m."""

    @abstractmethod
    def total_slopes(self, gaps: Gaps, point: ContinuationPoint) -> Array:
        """Total derivatives (P,) of other gaps by the size along the branch, m per m."""

    def near_misses(self, minima: Gaps | None) -> NearMisses | None:
        """Those of the local minima of gaps at no change that are not the contact itself; None if there are none."""
        if minima is None:
            return None
        point = self.at(0.0)
        contact = np.all(minima.pairs == point.contact.pairs, axis=1)
        contact &= np.abs(minima.travelled - point.contact.travelled) < BRACKET
        if contact.all():
            return None
        return NearMisses(minima.pairs[~contact], minima.travelled[~contact] - point.reference)


class ContactBranch(Branch):
    """Distance travelled by the head at a first contact, as a function of one size."""

    def _point(self, inward: InwardMarch, known: ContinuationPoint | None, step: float) -> ContinuationPoint:
        begin, predicted = (known.reference, known.rate * step) if known else (self._travelled, 0.0)
        # Close to the end of a branch the tangent may lead beyond it, so the second attempt omits the predictor.
        contact = self._contact(inward, begin + predicted) or self._contact(inward, begin)
        if contact is None:
            raise DragonError(f"benches {self._pair} do not touch at this size")
        travelled = float(contact.travelled[0])
        rate = -float(contact.slopes[0, self._column] / contact.slopes[0, TRAVELLED])
        return ContinuationPoint(inward, travelled, travelled, contact, rate)

    def _contact(self, inward: InwardMarch, travelled: float) -> Gaps | None:
        """Zero of the gap close to `travelled` m, by Newton's method; None if the method does not converge."""
        begin = travelled
        for _ in range(MAX_NEWTON_STEPS):
            contact = gaps_of(inward, travelled, self._pair)
            gap, slope = float(contact.gaps[0]), float(contact.slopes[0, TRAVELLED])
            if abs(gap) <= NEWTON_TOLERANCE:
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


class TangencyBranch(Branch):
    """Pitch at which the minimal gap of two benches on the inward spiral is zero, as a function of one size."""

    def _point(self, inward: InwardMarch, known: ContinuationPoint | None, step: float) -> ContinuationPoint:
        """Newton's method for the pitch and for the distance that remains to the circle, m."""
        pitch, remaining = inward.pitch, self.inward.length - self._travelled
        if known is not None:
            pitch, remaining = (
                known.inward.pitch + known.rate * step,
                known.reference - float(known.contact.travelled[0]),
            )
        for _ in range(MAX_NEWTON_STEPS):
            inward = replace(inward, pitch=pitch)
            end = inward.length
            contact = gaps_of(inward, end - remaining + DIFFERENCE_STEP * np.array([-1, 0, 1]), [self._pair] * 3)
            before, slope, after = contact.slopes[:, TRAVELLED].tolist()
            if before >= after:
                break
            gap, change = float(contact.gaps[1]), 2 * DIFFERENCE_STEP * slope / (after - before)
            if abs(gap) <= NEWTON_TOLERANCE and abs(change) <= STEP_TOLERANCE:
                contact = gaps_of(inward, end - remaining, self._pair)
                rate = -float(contact.slopes[0, self._column] / contact.slopes_at_radius[0])
                return ContinuationPoint(inward, end, end, contact, rate)
            remaining, pitch = remaining + change, pitch - gap / float(contact.slopes_at_radius[1])
            if not (0 <= remaining < end and pitch > MIN_PITCH):
                break
        raise DragonError(f"benches {self._pair} are not tangent at this size")

    def total_slopes(self, gaps: Gaps, point: ContinuationPoint) -> Array:
        """As in `Branch`, at a fixed distance of the head from the centre."""
        total: Array = gaps.slopes[:, self._column] + gaps.slopes_at_radius * point.rate
        return total


class NearMisses:
    """Near misses of K `pairs` along a branch, at `offsets` (K,) in m travelled from the branch's reference."""

    def __init__(self, pairs: NDArray[np.intp], offsets: Array) -> None:
        self._pairs, self._offsets = pairs, offsets

    def at(self, point: ContinuationPoint) -> Gaps:
        """Minimal gaps at a point of the branch, searched about the positions of the last call."""
        about = np.minimum(point.reference + self._offsets, point.end)
        gaps = minimal_gaps(point.inward, self._pairs, about - BRACKET, np.minimum(about + BRACKET, point.end))
        self._offsets = gaps.travelled - point.reference
        return gaps


def find_reach(
    branch: Branch, minima: Gaps | None, limit: float, other_pair: Callable[[ContinuationPoint, float], Pair | None]
) -> Reach:
    """Range of a size towards the change `limit`, m: up to the end of the branch, if no other pair touches before it.

    `minima` are local minima of gaps at no change. `other_pair` returns the pair, if any, that touches first at a point
    and a change of the size.
    """
    edge, by, pair = _end_of_branch(branch, branch.near_misses(minima), limit)
    unchanged, changed = (
        (limit, None) if by == "nothing" else (edge * (1 - RELATIVE_BRACKET), edge * (1 + RELATIVE_BRACKET))
    )
    found = other_pair(branch.at(unchanged), unchanged)
    if found is not None:
        # A pair that is not among the near misses touches first.
        by = "another pair"
        unchanged, changed, pair = bracketed(
            lambda change: other_pair(branch.at(change), change), 0.0, unchanged, found, relative=RELATIVE_BRACKET
        )
    return Reach(unchanged=unchanged, changed=changed, by=by, benches=pair)


def _end_of_branch(branch: Branch, near_misses: NearMisses | None, limit: float) -> tuple[float, Change, Pair | None]:
    """The change at which the branch ends or a near miss closes, the kind of the end, and the pair that closes."""
    sign, end = math.copysign(1.0, limit), abs(limit)
    by: Change = "nothing"
    change, point = 0.0, branch.at(0.0)
    for _ in range(MAX_STEPS):
        step = abs(limit) / MIN_STEPS
        if near_misses is not None:
            gaps = near_misses.at(point)
            growth = sign * branch.total_slopes(gaps, point)
            steps = np.where(growth < 0, -gaps.gaps / np.where(growth < 0, growth, -1.0), np.inf)
            first = int(steps.argmin())
            if abs(gaps.gaps[first]) <= GAP_TOLERANCE and np.isfinite(steps[first]):
                one, other = gaps.pairs[first].tolist()
                return sign * change, "another pair", (one, other)
            step = min(step, float(steps[first]))
        if step > 0 and change >= end:
            return sign * end, by, None
        target = min(change + step, end)
        if (state := _end_at(branch, sign * target)) is not None:
            target, high, _ = bracketed(
                lambda size: _end_at(branch, sign * size), change, target, state, relative=RELATIVE_BRACKET / 10
            )
            # Continuation from `target` succeeds at `high` where only the step was too long.
            if (state := _end_at(branch, sign * high)) is not None:
                end, by = target, state
        change, point = target, branch.at(sign * target)
    raise DragonError(f"no end of the branch was found after {change:g} m")


def _end_at(branch: Branch, change: float) -> Change | None:
    """What has ended the branch at a change; None if it exists with the features of its contact at no change."""
    try:
        features = branch.at(change).contact.features
    except DragonError:
        return "no contact"
    return None if np.all(features == branch.at(0.0).contact.features) else "another corner"
