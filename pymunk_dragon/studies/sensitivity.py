"""Derivatives of the first contact's time and of the smallest pitch by every size of the benches.

The derivatives are exact (`gaps.py`). A contact is a zero of a gap g, so its position w changes by -(dg/dq) / (dg/dw)
per unit of a size q, and its time by that over the speed. The smallest pitch p is where a minimal gap is zero, and it
changes by -(dg/dq) / (dg/dp). The derivatives hold as long as the same two benches touch at the same features. The
range of each size in which they do is found by continuation (`branches.py`). Contacts that the continuation does not
follow are searched just before the end of the range: for the first contact by `first_contact`, which certifies that
there is no earlier contact, and for the pitch by sampling the whole inward spiral.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pymunk_dragon.collision import first_contact
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies.branches import (
    BRACKET,
    Branch,
    ContactBranch,
    ContinuationPoint,
    NearMisses,
    TangencyBranch,
    perturbed,
)
from pymunk_dragon.studies.gaps import QUANTITIES, SIZES, gaps_of
from pymunk_dragon.studies.min_pitch import RADIUS, MinPitch, min_pitch
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.sampled_gaps import SampledGaps

__all__ = ["Reach", "Sensitivity", "Slope", "sensitivity"]

Change = Literal["another pair", "another corner", "no contact", "nothing"]
Pair = tuple[int, int]
# The pair, if any, that touches first instead of the branch's pair, at a point of the branch and a change of a size.
OtherPair = Callable[[ContinuationPoint, float, str], Pair | None]

# Largest change of a size that is examined, as a share of the size.
MAX_CHANGE = 0.1
# Least number of continuation steps up to the largest change.
MIN_STEPS = 5
# Largest number of continuation steps; a branch that needs more has not converged.
MAX_STEPS = 60
# Relative width of the bracket of a change at which other benches touch first, as it is reported.
RELATIVE_BRACKET = 1e-3
# Share of the width up to which a gap is followed as a near miss. A wider gap that closes first is found by the check
# at the end of the range, which takes longer.
NEAR_MISS_WIDTH = 0.05
# m. Largest gap that counts as zero.
GAP_TOLERANCE = 1e-10
# m travelled by the head. Contacts of a pair within this distance are the same contact.
SAME_CONTACT = 1e-6
# Parts of which progress is reported: first contact, smallest pitch, and the derivatives of both.
PARTS = 4


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
    benches: tuple[int, int] | None


@dataclass(frozen=True, kw_only=True)
class Slope:
    """Derivative of a result by one size.

    Attributes
    ----------
    size : str
        Name of the size.
    value : float
        The size, m; the least one where the benches differ.
    slope : float
        Derivative of the result: s per m for the time, m per m for the pitch.
    less, more : Reach or None
        Ranges below and above the size in which the derivative holds; None where they are not computed, for a pitch
        that is not limited by benches passing each other.
    """

    size: str
    value: float
    slope: float
    less: Reach | None
    more: Reach | None


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """Derivatives of the first contact's time and of the smallest pitch by every size.

    Attributes
    ----------
    march : March
        The march whose first contact is differentiated.
    time : float
        Time of the first contact, s.
    benches : tuple of int
        The two benches that touch.
    times : tuple of Slope
        Derivatives of that time by each size, including the pitch.
    smallest : MinPitch
        The smallest pitch of the same dragon.
    pitches : tuple of Slope
        Derivatives of the smallest pitch by each size of the benches; empty where the circle limits the pitch.
    """

    march: March
    time: float
    benches: tuple[int, int]
    times: tuple[Slope, ...]
    smallest: MinPitch
    pitches: tuple[Slope, ...]


def sensitivity(
    dragon: Dragon | None = None,
    *,
    pitch: float = 0.55,
    turns: float = 16.0,
    speed: float = 1.0,
    radius: float = RADIUS,
    progress: Progress = silent,
) -> Sensitivity:
    """Exact derivatives of the first contact's time and of the smallest pitch by the sizes.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's.
    pitch
        As in `Spiral`, for the first contact. The smallest pitch does not depend on it.
    turns, speed
        As in `March`.
    radius
        As in `min_pitch`.
    progress : callable, optional
        Called with the number of parts that are done and the number of all parts.

    Raises
    ------
    ParameterError
        If the dragon never touches itself, or as `March` and `min_pitch` do.
    DragonError
        As `min_pitch` does.
    """
    dragon = dragon or Dragon()
    march = March(dragon, Spiral(pitch=pitch), turns=turns, speed=speed)
    hit = first_contact(march)
    if hit.status != "contact" or hit.benches is None:
        raise ParameterError("pitch", pitch, f"one at which the dragon meets itself on the way ({hit.status} here)")
    progress(1, PARTS)
    smallest = min_pitch(dragon, turns=turns, speed=speed, radius=radius)
    progress(2, PARTS)
    times = _contact_slopes(march, hit.benches, float(march.distance(hit.time)))
    progress(3, PARTS)
    return Sensitivity(
        march=march,
        time=hit.time,
        benches=hit.benches,
        times=times,
        smallest=smallest,
        pitches=_pitch_slopes(smallest),
    )


def _contact_slopes(march: March, pair: tuple[int, int], travelled: float) -> tuple[Slope, ...]:
    """Derivatives of the time of a first contact of `pair` after `travelled` m."""
    steady = replace(march, speed=1.0)
    assert isinstance(march.curve, Spiral)
    assert march.turns is not None
    radius = float(np.hypot(*march.curve.point(march.head_start + travelled)))
    sampled = SampledGaps(march.dragon, march.curve, march.turns, radius)
    speed = float(march.speed_profile.at(march.time(travelled)))

    def other_pair(point: ContinuationPoint, change: float, size: str) -> Pair | None:
        found = first_contact(perturbed(steady, size, change))
        same = found.benches == pair and abs(found.time - float(point.contact.travelled[0])) <= SAME_CONTACT
        return None if same else found.benches

    def slope(size: str) -> Slope:
        return _slope(ContactBranch(sampled.march, travelled, pair, size), sampled, size, other_pair, 1 / speed)

    return tuple(slope(size) for size in SIZES)


def _pitch_slopes(smallest: MinPitch) -> tuple[Slope, ...]:
    """Derivatives of a smallest pitch by each size of the benches."""
    pair, march, radius = smallest.benches, replace(smallest.march, speed=1.0), smallest.radius
    if pair is None:
        return ()
    assert isinstance(march.curve, Spiral)
    assert march.turns is not None
    sizes, turns = [size for size in SIZES if size != "pitch"], march.turns
    if smallest.limit != "passing":
        contact = gaps_of(march, smallest.way, pair)
        at_start = contact.slopes[:, QUANTITIES.index("pitch")]
        by_pitch = contact.slopes_at_radius if smallest.limit == "arrival" else at_start
        by_size = (-contact.slopes[0] / by_pitch[0]).tolist()
        return tuple(
            Slope(size=size, value=_size(march, size), slope=by_size[QUANTITIES.index(size)], less=None, more=None)
            for size in sizes
        )
    sampled = SampledGaps(march.dragon, march.curve, turns, radius)

    def other_pair(point: ContinuationPoint, change: float, size: str) -> Pair | None:
        assert isinstance(point.march.curve, Spiral)
        found = SampledGaps(perturbed(march, size, change).dragon, point.march.curve, turns, radius).minimum()
        if found is None or found.gaps[0] > -GAP_TOLERANCE:
            return None
        first, second = found.pairs[0].tolist()
        return first, second

    def slope(size: str) -> Slope:
        return _slope(TangencyBranch(sampled.march, smallest.way, pair, radius, size), sampled, size, other_pair, 1.0)

    return tuple(slope(size) for size in sizes)


def _slope(branch: Branch, sampled: SampledGaps, size: str, other_pair: OtherPair, factor: float) -> Slope:
    """Derivative by `size`: `factor` times the rate of the branch."""
    point, dragon = branch.at(0.0), sampled.march.dragon
    value, minima = _size(sampled.march, size), sampled.local_minima(NEAR_MISS_WIDTH * float(dragon.widths.min()))

    def near_misses() -> NearMisses | None:
        if minima is None:
            return None
        contact = np.all(minima.pairs == point.contact.pairs, axis=1)
        contact &= np.abs(minima.travelled - point.contact.travelled) < BRACKET
        if contact.all():
            return None
        return NearMisses(minima.pairs[~contact], minima.travelled[~contact] - point.reference)

    def reach(sign: int) -> Reach:
        return _reach(branch, near_misses(), sign * MAX_CHANGE * value, lambda at, change: other_pair(at, change, size))

    return Slope(size=size, value=value, slope=point.rate * factor, less=reach(-1), more=reach(1))


def _size(march: March, size: str) -> float:
    """The value of a size, m; the least one where the benches differ."""
    assert isinstance(march.curve, Spiral)
    return march.curve.pitch if size == "pitch" else float(np.min(getattr(march.dragon, size)))


def _reach(
    branch: Branch,
    near_misses: NearMisses | None,
    limit: float,
    other_pair: Callable[[ContinuationPoint, float], Pair | None],
) -> Reach:
    """Range of a size towards the change `limit`: up to the end of the branch, if no other pair touches before it."""
    edge, by, pair = _end_of_branch(branch, near_misses, limit)
    unchanged, changed = (
        (limit, None) if by == "nothing" else (edge * (1 - RELATIVE_BRACKET), edge * (1 + RELATIVE_BRACKET))
    )
    found = other_pair(branch.at(unchanged), unchanged)
    if found is not None:
        # A pair that is not among the near misses touches first.
        pair, by, changed, unchanged = found, "another pair", unchanged, 0.0
        while abs(changed - unchanged) > RELATIVE_BRACKET * abs(changed):
            middle = (unchanged + changed) / 2
            found = other_pair(branch.at(middle), middle)
            unchanged, changed, pair = (middle, changed, pair) if found is None else (unchanged, middle, found)
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
        if _state(branch, sign * target) != "nothing":
            low, high = _bisected(branch, sign, change, target)
            target = low
            # Continuation from `low` succeeds at `high` where only the step was too long.
            if (state := _state(branch, sign * high)) != "nothing":
                end, by = low, state
        change, point = target, branch.at(sign * target)
    raise DragonError(f"no end of the branch was found after {change:g} m")


def _state(branch: Branch, change: float) -> Change:
    """Whether the branch still exists at a change with the features of its contact at no change."""
    try:
        features = branch.at(change).contact.features
    except DragonError:
        return "no contact"
    return "nothing" if np.all(features == branch.at(0.0).contact.features) else "another corner"


def _bisected(branch: Branch, sign: float, low: float, high: float) -> tuple[float, float]:
    """Bracket of the end of a branch between the sizes of two changes."""
    while high - low > RELATIVE_BRACKET / 10 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if _state(branch, sign * middle) == "nothing" else (low, middle)
    return low, high
