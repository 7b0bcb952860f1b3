"""How the first contact and the smallest pitch move with every size of the benches.

The slopes are exact (`slopes.py`): a contact is where a gap g is zero, so its place w moves by -(dg/dq) / (dg/dw) with
a size q, and its time by as much over the speed; the smallest pitch p is where a smallest gap is zero, and moves by
-(dg/dq) / (dg/dp). They hold as long as the same two benches touch in the same way. How far each size may change until
others do is found along the branch (`branches.py`), and what was not followed is looked for just before its end: for
the contact by `first_contact`, which certifies that none is earlier, for the pitch along the whole way.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pymunk_dragon.collision import first_contact
from pymunk_dragon.curves import Spiral
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.studies.branches import ASIDE, Branch, Grazing, Meeting, Misses, Stand, changed
from pymunk_dragon.studies.min_pitch import RADIUS, MinPitch, min_pitch
from pymunk_dragon.studies.passing import Passing
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.slopes import QUANTITIES, SIZES, gaps_of

__all__ = ["Reach", "Sensitivity", "Slope", "sensitivity"]

Change = Literal["another pair", "another corner", "no contact", "nothing"]
Pair = tuple[int, int]
Beyond = Callable[[Stand, float, str], Pair | None]

# Share of a size by which it is changed at most, and the least number of steps to there.
LIMIT, FOLLOWED = 0.1, 5
# Share of a change by which it is told on both sides where other benches take over.
BRACKET = 1e-3
# Share of the width that a gap may be wide to be followed as a near miss. One that closes from further away is found,
# too, but by looking at everything.
NEAR = 0.05
# m: gaps that are none, and ways between contacts that are one.
NO_GAP, SAME_WAY = 1e-10, 1e-6
# Steps along a branch, at most: with more than that it leads nowhere.
STEPS = 60


# First contact, smallest pitch, and the slopes of both.
PARTS = 4


@dataclass(frozen=True, kw_only=True)
class Reach:
    """How far a size may change in one direction until other benches touch, or in another way.

    Attributes
    ----------
    unchanged : float
        The change, m and with its sign, up to which the same two touch; looked at there, and on the way to there.
    changed : float or None
        A change, m, at which others do, or in another way; None where none was found up to a tenth of the size.
    by : {"another pair", "another corner", "no contact", "nothing"}
        What changes: another pair touches first; the same two touch elsewhere; they miss each other, and others meet
        later; or nothing does.
    benches : tuple of int or None
        Which pair touches first beyond, if it is another one.
    """

    unchanged: float
    changed: float | None
    by: Change
    benches: tuple[int, int] | None


@dataclass(frozen=True, kw_only=True)
class Slope:
    """What one size does.

    Attributes
    ----------
    size : str
        Its name.
    value : float
        What it is, m; the least where the benches differ.
    slope : float
        How the answer moves with it: s for each m of the time, m for each m of the pitch.
    less, more : Reach or None
        How far it may change either way; None where that is not followed: for a pitch that is not limited by benches
        passing each other.
    """

    size: str
    value: float
    slope: float
    less: Reach | None
    more: Reach | None


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """What every size does to the time of the first contact, and to the smallest pitch.

    Attributes
    ----------
    march : March
        The march of which the first contact is asked.
    time : float
        Of its first contact, s.
    benches : tuple of int
        The two that touch then.
    times : tuple of Slope
        What each size does to that time, the pitch being one of them.
    smallest : MinPitch
        The smallest pitch of the same dragon.
    pitches : tuple of Slope
        What each size of the benches does to that pitch; none of them where the pitch is limited by the circle.
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
    """How the time of the first contact and the smallest pitch move with the sizes, by exact derivatives.

    Parameters
    ----------
    dragon : Dragon, optional
        Who marches; by default the contest's.
    pitch
        As in `Spiral`, of the first contact; the smallest pitch does not depend on it.
    turns, speed
        As in `March`.
    radius
        As in `min_pitch`.
    progress : callable, optional
        Called with the number of parts that are done, and of all.

    Raises
    ------
    ParameterError
        If the dragon never meets itself, or as `March` and `min_pitch` do.
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
    times = _of_contact(march, hit.benches, float(march.distance(hit.time)))
    progress(3, PARTS)
    return Sensitivity(
        march=march,
        time=hit.time,
        benches=hit.benches,
        times=times,
        smallest=smallest,
        pitches=_of_pitch(smallest),
    )


def _of_contact(march: March, pair: tuple[int, int], way: float) -> tuple[Slope, ...]:
    """What each size does to the time of a first contact of `pair` after `way` m."""
    steady = replace(march, speed=1.0)
    assert isinstance(march.curve, Spiral)
    assert march.turns is not None
    radius = float(np.hypot(*march.curve.point(march.head_start + way)))
    passing = Passing(march.dragon, march.curve, march.turns, radius)
    rate = float(march.speed_profile.at(march.time(way)))

    def beyond(stand: Stand, change: float, name: str) -> Pair | None:
        found = first_contact(changed(steady, name, change))
        here = found.benches == pair and abs(found.time - float(stand.touch.ways[0])) <= SAME_WAY
        return None if here else found.benches

    def slope(name: str) -> Slope:
        return _slope(Meeting(passing.march, way, pair, name), passing, name, beyond, 1 / rate)

    return tuple(slope(name) for name in SIZES)


def _of_pitch(smallest: MinPitch) -> tuple[Slope, ...]:
    """What each size of the benches does to a smallest pitch."""
    pair, march, radius = smallest.benches, replace(smallest.march, speed=1.0), smallest.radius
    if pair is None:
        return ()
    assert isinstance(march.curve, Spiral)
    assert march.turns is not None
    sizes, turns = [name for name in SIZES if name != "pitch"], march.turns
    if smallest.limit != "passing":
        touch = gaps_of(march, smallest.way, pair)
        by_pitch = touch.slopes_on_circle if smallest.limit == "arrival" else touch.slopes[:, QUANTITIES.index("pitch")]
        by_size = (-touch.slopes[0] / by_pitch[0]).tolist()
        return tuple(
            Slope(size=name, value=_size(march, name), slope=by_size[QUANTITIES.index(name)], less=None, more=None)
            for name in sizes
        )
    passing = Passing(march.dragon, march.curve, turns, radius)

    def beyond(stand: Stand, change: float, name: str) -> Pair | None:
        assert isinstance(stand.march.curve, Spiral)
        found = Passing(changed(march, name, change).dragon, stand.march.curve, turns, radius).lowest()
        if found is None or found.gaps[0] > -NO_GAP:
            return None
        first, second = found.pairs[0].tolist()
        return first, second

    def slope(name: str) -> Slope:
        return _slope(Grazing(passing.march, smallest.way, pair, radius, name), passing, name, beyond, 1.0)

    return tuple(slope(name) for name in sizes)


def _slope(branch: Branch, passing: Passing, name: str, beyond: Beyond, factor: float) -> Slope:
    """What the size `name` does to what lies on the branch, `factor` times as much as to its place."""
    stand, dragon = branch.stand(0.0), passing.march.dragon
    value, near = _size(passing.march, name), passing.smallest(NEAR * float(dragon.widths.min()))

    def misses() -> Misses | None:
        if near is None:
            return None
        touch = np.all(near.pairs == stand.touch.pairs, axis=1) & (np.abs(near.ways - stand.touch.ways) < ASIDE)
        return None if touch.all() else Misses(near.pairs[~touch], near.ways[~touch] - stand.anchor)

    def reach(sign: int) -> Reach:
        return _reach(branch, misses(), sign * LIMIT * value, lambda there, change: beyond(there, change, name))

    return Slope(size=name, value=value, slope=stand.moves * factor, less=reach(-1), more=reach(1))


def _size(march: March, name: str) -> float:
    """One of the sizes, m; the least where the benches differ."""
    assert isinstance(march.curve, Spiral)
    return march.curve.pitch if name == "pitch" else float(np.min(getattr(march.dragon, name)))


def _reach(branch: Branch, misses: Misses | None, limit: float, beyond: Callable[[Stand, float], Pair | None]) -> Reach:
    """How far a size may change towards `limit`: as far as its branch goes, if everything else stays away."""
    edge, by, pair = _followed(branch, misses, limit)
    unchanged, other = (limit, None) if by == "nothing" else (edge * (1 - BRACKET), edge * (1 + BRACKET))
    met = beyond(branch.stand(unchanged), unchanged)
    if met is not None:
        # Something that nobody followed is nearer.
        pair, by, other, unchanged = met, "another pair", unchanged, 0.0
        while abs(other - unchanged) > BRACKET * abs(other):
            middle = (unchanged + other) / 2
            met = beyond(branch.stand(middle), middle)
            unchanged, other, pair = (middle, other, pair) if met is None else (unchanged, middle, met)
    return Reach(unchanged=unchanged, changed=other, by=by, benches=pair)


def _followed(branch: Branch, misses: Misses | None, limit: float) -> tuple[float, Change, Pair | None]:
    """The change at which the branch ends or a near miss closes, which of them, and the pair that comes in between."""
    sign, wall = math.copysign(1.0, limit), abs(limit)
    by: Change = "nothing"
    change, stand = 0.0, branch.stand(0.0)
    features = stand.touch.features

    def kept(change: float) -> Change:
        try:
            here = branch.stand(sign * change).touch.features
        except DragonError:
            return "no contact"
        return "nothing" if np.all(here == features) else "another corner"

    for _ in range(STEPS):
        step = abs(limit) / FOLLOWED
        if misses is not None:
            gaps = misses.at(stand)
            growth = sign * branch.total(gaps, stand)
            steps = np.where(growth < 0, -gaps.gaps / np.where(growth < 0, growth, -1.0), np.inf)
            first = int(steps.argmin())
            if abs(gaps.gaps[first]) <= NO_GAP and np.isfinite(steps[first]):
                one, other = gaps.pairs[first].tolist()
                return sign * change, "another pair", (one, other)
            step = min(step, float(steps[first]))
        if step > 0 and change >= wall:
            return sign * wall, by, None
        target = min(change + step, wall)
        if kept(target) != "nothing":
            low, high = change, target
            while high - low > BRACKET / 10 * high:
                middle = (low + high) / 2
                low, high = (middle, high) if kept(middle) == "nothing" else (low, middle)
            target = low
            # From so near it may turn out that only the step was too long.
            if (end := kept(high)) != "nothing":
                wall, by = low, end
        change, stand = target, branch.stand(sign * target)
    raise DragonError(f"no end of the branch was found after {change:g} m")
