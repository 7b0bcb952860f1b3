"""The smallest pitch at which the head reaches the turning circle (the contest's question 3).

A smaller pitch brings the turns closer together, so the head touches a bench that it passes before it is there. Three
things are found out:

- Where the limit is: the smallest gap on the whole way in, over the pitch, has a zero, and Newton's method finds it
  from the exact slope (`slopes.py`).
- That it is a limit: `first_contact` certifies a way in without a contact a nanometre above it, and finds one a
  nanometre below.
- That there is no other one, neither free pitches below nor collisions above. Compare dragons with their heads on the
  same circle about the centre. At every pitch of a map, and all along the way, every gap near zero grows with the
  pitch. So what is free on a circle stays free there at all larger pitches. Their ways begin further out, and are seen
  to be free there. So the free pitches are a half line, and the limit is its end.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite, positive
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.curves import Spiral
from pymunk_dragon.curves.spiral import MAX_PITCH
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.studies.passing import Passing
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.slopes import PITCH, Gaps, gaps_of

__all__ = ["MinPitch", "PitchMap", "min_pitch", "way_to"]

Array = NDArray[np.float64]
Limit = Literal["passing", "arrival", "start", "circle"]

# m. Radius of the contest's turning circle.
RADIUS = 4.5
# m. With a wider circle the way in is kilometres long, and the search takes minutes.
MAX_RADIUS = 100.0
# Turns of the start, at most: some more are looked at, and no spiral has more than a thousand.
MAX_TURNS = 900.0
# m. So far above the answer the way is certified to be free, and so far below it to be blocked.
CERTAIN = 1e-9
# Each pitch of the map over the one before it. It ends where the smallest gap is so large a share of the width: beyond
# that no gap is near zero.
RAISE, WIDE = 1.04, 0.5
# Share of the width within which a gap counts as near zero: 1 cm at the contest's 0.3 m.
NEAR = 1 / 30
# No march has a pitch that is not larger than the width. The map begins so little above it.
LEAST = 1 + 1e-6
# m. So little above the zero of the smallest gap is the answer: rounding, of a few 1e-15 m, shows no overlap there.
TOUCH = 1e-13
# Newton's steps, of which it needs three. After one of so few metres only rounding is left.
STEPS, SETTLED = 60, 1e-12
# Share of the way that is no way: so close to an end of it a smallest gap is one at the end.
AT_END = 1e-9


@dataclass(frozen=True)
class PitchMap:
    """Smallest gaps on the way in at K pitches.

    Attributes
    ----------
    pitches, gaps : ndarray, shape (K,)
        m; a gap is negative where benches overlap.
    further_out : ndarray, shape (K,)
        The same on a way that begins as far out as that of the next pitch, m.
    growth : tuple of float or None
        By how much gaps near zero grow with the pitch, the least and the most, while handle 0 stays on the same circle
        about the centre, m for each m. None where no gap is near zero.
    near : float
        Which gaps those are: at most so far from zero, m.
    compared : int
        How many of them were looked at.
    """

    pitches: Array
    gaps: Array
    further_out: Array
    growth: tuple[float, float] | None
    near: float
    compared: int

    def __post_init__(self) -> None:
        for array in (self.pitches, self.gaps, self.further_out):
            array.flags.writeable = False


@dataclass(frozen=True, kw_only=True)
class MinPitch:
    """The smallest pitch at which handle 0 reaches the turning circle without a collision on the way.

    Attributes
    ----------
    pitch : float
        The answer, m. There two benches touch without overlapping, if a gap is what limits it.
    radius : float
        Of the turning circle, m.
    march : March
        The dragon on the spiral of that pitch.
    limit : {"passing", "arrival", "start", "circle"}
        What sets it: the head passes a bench without a gap; two benches meet as the head arrives; two touch as it
        starts; or nothing but the circle, on which the head then starts.
    benches : tuple of int or None
        The two that touch, the smaller number first; None where nothing does.
    point : tuple of float or None
        Where they do, m.
    way, way_in : float
        How far handle 0 has gone when they touch, and when it reaches the circle, m; `march.time` tells when that is.
    gap : float or None
        Between these two then, m: zero but for rounding.
    slope : float or None
        How the smallest gap on the way grows with the pitch there, m for each m.
    half_line : bool
        Whether the map shows that all larger pitches are free, and all smaller ones are not.
    free_at, blocked_at : float
        Pitches, m, at which `first_contact` certifies a way without a contact, and finds one. The latter is None where
        nothing but the circle is the limit: at a smaller pitch the head would start inside of it.
    map : PitchMap
        What is seen at other pitches.
    """

    pitch: float
    radius: float
    march: March
    limit: Limit
    benches: tuple[int, int] | None
    point: tuple[float, float] | None
    way: float
    way_in: float
    gap: float | None
    slope: float | None
    half_line: bool
    free_at: float
    blocked_at: float | None
    map: PitchMap = field(repr=False)


def way_to(march: March, radius: float) -> float:
    """Way of handle 0 of a march inward on a `Spiral` from its start to where it is `radius` m from the centre, m."""
    assert isinstance(march.curve, Spiral)
    return march.curve.at_radius(radius) - march.head_start


def min_pitch(
    dragon: Dragon | None = None,
    *,
    turns: float = 16.0,
    speed: float = 1.0,
    radius: float = RADIUS,
    progress: Progress = silent,
) -> MinPitch:
    """The smallest pitch at which handle 0 reaches a circle about the centre without a collision on the way.

    It and all larger ones are free, and no smaller one is.

    Parameters
    ----------
    dragon : Dragon, optional
        Who marches; by default the contest's.
    turns, speed
        As in `March`.
    radius : float
        Of the circle, m.
    progress : callable, optional
        Called with the width that the smallest gap has reached on the map, and the one at which the map ends, m.

    Returns
    -------
    MinPitch
        The pitch is right to 1e-12 m, and certified to 1e-9 m.

    Raises
    ------
    ParameterError
        If the radius is no number, is less than the longest spacing (further in a handle may have no place), or is
        larger than any start; or if the dragon is too short to pass itself, so that nothing limits the pitch.
    DragonError
        If the limit cannot be certified.
    """
    dragon = dragon or Dragon()
    turns = positive("turns", turns, MAX_TURNS, "")
    # Further in than the longest spacing a handle may have no place, and a start further out is on no spiral.
    radius = finite("radius", radius, float(dragon.spacings.max()), min(MAX_RADIUS, MAX_PITCH * turns), "m")
    return _Search(dragon, turns, speed, radius, progress).run()


class _Search:
    """Looks at marches that differ in their pitch."""

    def __init__(self, dragon: Dragon, turns: float, speed: float, radius: float, progress: Progress) -> None:
        self._progress = progress
        self._dragon, self._turns, self._speed, self._radius = dragon, turns, speed, radius

    def run(self) -> MinPitch:
        known = self._map()
        if known.gaps[0] > 0:
            return self._unhindered(known)
        last = int(np.flatnonzero(known.gaps <= 0)[-1])
        blocked, free = known.pitches[last : last + 2].tolist()
        pitch = self._zero(blocked, free) + TOUCH
        hit = self._hit(pitch - CERTAIN)
        if hit.benches is None or self._hit(pitch + CERTAIN).status != "clear":
            pitch, hit = self._halved(blocked, known.pitches[last + 1 :].tolist())
        march = self._march(pitch)
        end = way_to(march, self._radius)
        at = self._passing(pitch).lowest()
        if at is None or abs(at.gaps[0]) > CERTAIN:
            assert hit.benches is not None
            at = gaps_of(march, hit.time, hit.benches)
        way, (first, second), (x, y) = float(at.ways[0]), at.pairs[0].tolist(), at.points[0].tolist()
        limit: Limit = "passing"
        if way <= AT_END * end:
            limit = "start"
        elif way >= (1 - AT_END) * end:
            limit = "arrival"
        return self._answer(
            pitch,
            known,
            limit=limit,
            benches=(first, second),
            point=(x, y),
            way=way,
            gap=float(at.gaps[0]),
            slope=_slope(at),
            blocked_at=pitch - CERTAIN,
        )

    def _unhindered(self, known: PitchMap) -> MinPitch:
        """The answer where not even the least pitch has a contact on the way."""
        least = float(known.pitches[0])
        if least > self._radius / self._turns or self._hit(least + CERTAIN).status != "clear":
            short = "so many, and so long, that the dragon can run into itself outside the circle"
            raise ParameterError("benches", self._dragon.benches, short)
        return self._answer(
            least, known, limit="circle", benches=None, point=None, way=0.0, gap=None, slope=None, blocked_at=None
        )

    def _answer(self, pitch: float, known: PitchMap, **others: Any) -> MinPitch:
        march = self._march(pitch)
        below = known.pitches < pitch
        parted = [
            # Of others not all benches are looked at.
            self._dragon.alike,
            known.growth is None or known.growth[0] > 0,
            np.all(known.gaps[below] < 0),
            np.all(known.further_out[~below] > 0),
            _lowest_gaps(self._passing(pitch, RAISE))[1] > -CERTAIN,
        ]
        return MinPitch(
            pitch=pitch,
            radius=self._radius,
            march=replace(march, speed=self._speed),
            # At the very start rounding may put it before.
            way_in=max(0.0, way_to(march, self._radius)),
            half_line=all(parted),
            free_at=pitch + CERTAIN,
            map=known,
            **others,
        )

    def _march(self, pitch: float) -> March:
        """At 1 m/s: how fast the head goes has no part in this."""
        return March(self._dragon, Spiral(pitch=pitch), turns=self._turns)

    def _passing(self, pitch: float, further: float = 1.0) -> Passing:
        """The way in, or one that begins so many times as far out."""
        return Passing(self._dragon, Spiral(pitch=pitch), self._turns, self._radius, further)

    def _map(self) -> PitchMap:
        """What is seen from the least pitch to one at which all gaps are wide."""
        widest, near = float(self._dragon.widths.max()), NEAR * float(self._dragon.widths.min())
        least, wide = max(widest * LEAST, self._radius / self._turns), WIDE * widest
        pitches, rows, slopes = [least], [], [np.empty(0)]
        while True:
            passing = self._passing(pitches[-1], RAISE)
            rows.append(_lowest_gaps(passing))
            if (found := passing.about_to_touch(near)) is not None:
                slopes.append(found.slopes_on_circle)
            self._progress(min(max(0.0, *rows[-1]), wide), wide)
            if min(rows[-1]) >= wide:
                break
            pitches.append(RAISE * pitches[-1])
        growth = np.concatenate(slopes)
        bounds = (float(growth.min()), float(growth.max())) if growth.size else None
        gaps, further_out = np.array(rows).T
        return PitchMap(np.array(pitches), gaps, further_out, bounds, near, growth.size)

    def _zero(self, blocked: float, free: float) -> float:
        """Where between the two the smallest gap is zero, by Newton's method within the bracket."""
        pitch = free
        for _ in range(STEPS):
            gap, slope = self._lowest(pitch)
            if gap > 0:
                free = pitch
            else:
                blocked = pitch
            better = pitch - gap / slope if slope > 0 else blocked
            if abs(better - pitch) <= SETTLED:
                return better
            pitch = better if blocked < better < free else (blocked + free) / 2
        return free

    def _lowest(self, pitch: float) -> tuple[float, float]:
        """The smallest gap on the way, m, and its slope by the pitch."""
        passing = self._passing(pitch)
        found = passing.lowest()
        return (np.inf, 0.0) if found is None else (float(found.gaps[0]), _slope(found))

    def _hit(self, pitch: float) -> FirstContact:
        """What is certified of the way in."""
        march = self._march(pitch)
        return first_contact(march, until=way_to(march, self._radius))

    def _halved(self, blocked: float, larger: list[float]) -> tuple[float, FirstContact]:
        """The limit between the first and some of the `larger` pitches, and the contact below it.

        By nothing but certificates: slow, and always right.
        """
        free = next((pitch for pitch in larger if self._hit(pitch).status == "clear"), np.inf)
        hit = self._hit(blocked)
        while CERTAIN < free - blocked < np.inf:
            middle = (blocked + free) / 2
            between = self._hit(middle)
            if between.status == "clear":
                free = middle
            else:
                blocked, hit = middle, between
        if hit.benches is None or free == np.inf:
            raise DragonError(f"no limit of the pitch can be certified above {blocked:.9g} m")
        return free, hit


def _lowest_gaps(passing: Passing) -> tuple[float, float]:
    """The smallest gap since the start, and since before it, m."""
    return float(passing.gaps[passing.ways >= 0].min()), float(passing.gaps.min())


def _slope(smallest: Gaps) -> float:
    """Slope of a gap that is smallest on the way, by the pitch; the way begins at a turn, and ends at a circle."""
    slope = smallest.slopes[0, PITCH] if smallest.ways[0] == 0 else smallest.slopes_on_circle[0]
    return float(slope)
