"""The smallest pitch at which the head reaches the turning circle (the contest's question 3).

A smaller pitch brings the turns closer together, so the head touches a bench that it passes before it reaches the
circle. The result consists of three parts:

- The limit. The smallest gap on the whole inward spiral, as a function of the pitch, has a zero. Newton's method finds
  the zero from the exact derivative (`gaps.py`).
- Its certificate. `first_contact` certifies that the march is free of contacts a nanometre above the limit, and finds a
  contact a nanometre below.
- Its uniqueness: no free pitches below and no collisions above. Dragons are compared with their heads at the same
  distance from the centre. At every sampled pitch and position, every gap close to zero grows with the pitch. So a
  position that is free at one pitch is free at all larger pitches. Marches at larger pitches start further out, and
  the additional part of their spirals is sampled as well. So the free pitches are a half line that begins at the limit.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import finite, positive
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.curves.spiral import MAX_PITCH
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies.gaps import PITCH, Gaps, gaps_of
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.sampled_gaps import SampledGaps

__all__ = ["MinPitch", "PitchMap", "distance_to_circle", "min_pitch"]

Array = NDArray[np.float64]
Limit = Literal["passing", "arrival", "start", "circle"]

# m. Radius of the contest's turning circle.
RADIUS = 4.5
# m. Largest radius: with a wider circle the inward spiral is kilometres long, and the search takes minutes.
MAX_RADIUS = 100.0
# Largest turn of the start. Samples begin further out, and a spiral has at most a thousand turns.
MAX_TURNS = 900.0
# m. Distance from the limit at which pitches are certified: a thousand times the error of the limit.
CERTIFIED = 1e-9
# Ratio of successive pitches of the map.
PITCH_RATIO = 1.04
# Smallest gap at which the map ends, as a share of the width, or of the smallest gap at wide pitches if that is less:
# beyond it no gap is close to zero.
MAP_END = 0.5
# Size up to which a gap counts as close to zero, as a share of the width: 1 cm at the contest's 0.3 m.
CLOSE_TO_ZERO = 1 / 30
# Least pitch of the map over the width: no march has a pitch that is not larger than the width.
MIN_PITCH_RATIO = 1 + 1e-6
# m. Distance of the result from the zero of the smallest gap: rounding, of a few 1e-15 m, shows no overlap there.
TANGENCY_MARGIN = 1e-13
# Newton steps, at most; three suffice.
MAX_NEWTON_STEPS = 60
# m. Newton step below which only rounding is left.
STEP_TOLERANCE = 1e-12
# Share of the distance to the circle within which a minimum of a gap lies at an end of the spiral.
AT_END = 1e-9


@dataclass(frozen=True)
class PitchMap:
    """Smallest gaps on the inward spiral at K pitches.

    Attributes
    ----------
    pitches, gaps : ndarray, shape (K,)
        m; a gap is negative where benches overlap.
    further_out : ndarray, shape (K,)
        Smallest gaps on a spiral that begins as far out as that of the next pitch, m.
    growth : tuple of float or None
        Least and largest derivative, by the pitch, of gaps close to zero at a fixed distance of handle 0 from the
        centre, m per m. None where no gap is close to zero.
    near : float
        Largest size of a gap that counts as close to zero, m.
    compared : int
        Number of gaps close to zero whose derivatives were computed.
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
    """The smallest pitch at which handle 0 reaches the turning circle without a collision.

    Attributes
    ----------
    pitch : float
        The smallest pitch, m. If a gap limits it, two benches touch there without overlapping.
    radius : float
        Radius of the turning circle, m.
    march : March
        March on the spiral of that pitch.
    limit : {"passing", "arrival", "start", "circle"}
        Cause of the limit: the head touches a bench while passing it; two benches touch as the head arrives; two
        benches touch at the start; or only the circle, on which the head then starts.
    benches : tuple of int or None
        The two benches that touch, the smaller number first; None where no benches touch.
    point : tuple of float or None
        Contact point, m.
    way, way_in : float
        Distances travelled by handle 0 at the contact and at the circle, m; `march.time` gives the times.
    gap : float or None
        Gap of the two benches at the contact, m; zero but for rounding.
    slope : float or None
        Derivative of the smallest gap by the pitch, m per m.
    half_line : bool
        Whether the map shows that all larger pitches are free, and all smaller ones are not.
    free_at, blocked_at : float
        Pitches, m, at which `first_contact` certifies a march without a contact, and finds a contact. The latter is
        None where only the circle is the limit: at a smaller pitch the head would start inside it.
    map : PitchMap
        Smallest gaps at other pitches.
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


def distance_to_circle(march: March, radius: float) -> float:
    """Distance that handle 0 travels inward on a `Spiral` from its start to `radius` m from the centre, m."""
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
    """The smallest pitch at which handle 0 reaches a circle about the centre without a collision.

    All larger pitches are free as well, and no smaller one is.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's.
    turns, speed
        As in `March`.
    radius : float
        Radius of the circle, m.
    progress : callable, optional
        Called with the smallest gap at the last pitch of the map, and the gap at which the map ends, m.

    Returns
    -------
    MinPitch
        The pitch is accurate to 1e-12 m, and certified to 1e-9 m.

    Raises
    ------
    ParameterError
        If the radius is no number, is less than the longest spacing (further in, a handle may have no position), or is
        larger than any start; or if the dragon is too short to pass itself, so that nothing limits the pitch.
    DragonError
        If the limit cannot be certified.
    """
    dragon = dragon or Dragon()
    turns = positive("turns", turns, MAX_TURNS, "")
    # Inside the longest spacing a handle may have no position, and beyond the largest start there is no spiral.
    radius = finite("radius", radius, float(dragon.spacings.max()), min(MAX_RADIUS, MAX_PITCH * turns), "m")
    return _Search(dragon, turns, speed, radius, progress).run()


class _Search:
    """Search for the smallest pitch of a dragon."""

    def __init__(self, dragon: Dragon, turns: float, speed: float, radius: float, progress: Progress) -> None:
        self._progress = progress
        self._dragon, self._turns, self._speed, self._radius = dragon, turns, speed, radius

    def run(self) -> MinPitch:
        """The smallest pitch with its certificate and map."""
        pitch_map = self._map()
        if pitch_map.gaps[0] > 0:
            return self._limited_by_circle(pitch_map)
        last = int(np.flatnonzero(pitch_map.gaps <= 0)[-1])
        blocked, free = pitch_map.pitches[last : last + 2].tolist()
        pitch = self._zero(blocked, free) + TANGENCY_MARGIN
        hit = self._first_contact(pitch - CERTIFIED)
        if hit.benches is None or self._first_contact(pitch + CERTIFIED).status != "clear":
            pitch, hit = self._bisected(blocked, pitch_map.pitches[last + 1 :].tolist())
        march = self._march(pitch)
        end = distance_to_circle(march, self._radius)
        contact = self._sampled(pitch).minimum()
        if contact is None or abs(contact.gaps[0]) > CERTIFIED:
            assert hit.benches is not None
            contact = gaps_of(march, hit.time, hit.benches)
        travelled, (first, second) = float(contact.travelled[0]), contact.pairs[0].tolist()
        x, y = contact.points[0].tolist()
        limit: Limit = "passing"
        if travelled <= AT_END * end:
            limit = "start"
        elif travelled >= (1 - AT_END) * end:
            limit = "arrival"
        return self._result(
            pitch,
            pitch_map,
            limit=limit,
            benches=(first, second),
            point=(x, y),
            way=travelled,
            gap=float(contact.gaps[0]),
            slope=_slope(contact),
            blocked_at=pitch - CERTIFIED,
        )

    def _limited_by_circle(self, pitch_map: PitchMap) -> MinPitch:
        """The result where the march is free of contacts even at the least pitch."""
        least = float(pitch_map.pitches[0])
        if least > self._radius / self._turns or self._first_contact(least + CERTIFIED).status != "clear":
            short = "so many, and so long, that the dragon can run into itself outside the circle"
            raise ParameterError("benches", self._dragon.benches, short)
        return self._result(
            least, pitch_map, limit="circle", benches=None, point=None, way=0.0, gap=None, slope=None, blocked_at=None
        )

    def _result(self, pitch: float, pitch_map: PitchMap, **others: Any) -> MinPitch:
        """The result at a pitch, with the test of the half line."""
        march = self._march(pitch)
        below = pitch_map.pitches < pitch
        separated = [
            # Where benches differ, the samples do not include the gaps of all of them.
            self._dragon.alike,
            pitch_map.growth is None or pitch_map.growth[0] > 0,
            np.all(pitch_map.gaps[below] < 0),
            np.all(pitch_map.further_out[~below] > 0),
            _smallest_gaps(self._sampled(pitch, PITCH_RATIO))[1] > -CERTIFIED,
        ]
        return MinPitch(
            pitch=pitch,
            radius=self._radius,
            march=replace(march, speed=self._speed),
            # Rounding may give a negative distance where the start is on the circle.
            way_in=max(0.0, distance_to_circle(march, self._radius)),
            half_line=all(separated),
            free_at=pitch + CERTIFIED,
            map=pitch_map,
            **others,
        )

    def _march(self, pitch: float) -> March:
        """The march at 1 m/s: the limit does not depend on the speed."""
        return March(self._dragon, Spiral(pitch=pitch), turns=self._turns)

    def _sampled(self, pitch: float, further: float = 1.0) -> SampledGaps:
        """Gaps on the inward spiral from `further` times the turn of the start."""
        return SampledGaps(self._dragon, Spiral(pitch=pitch), self._turns, self._radius, further)

    def _map(self) -> PitchMap:
        """Smallest gaps from the least pitch to a pitch at which all gaps are wide."""
        widest, close = float(self._dragon.widths.max()), CLOSE_TO_ZERO * float(self._dragon.widths.min())
        least, wide = (
            max(widest * MIN_PITCH_RATIO, self._radius / self._turns),
            MAP_END * self._gap_between_turns_apart(),
        )
        pitches, rows, slopes = [least], [], [np.empty(0)]
        while True:
            sampled = self._sampled(pitches[-1], PITCH_RATIO)
            rows.append(_smallest_gaps(sampled))
            if (found := sampled.close_to_zero(close)) is not None:
                slopes.append(found.slopes_at_radius)
            self._progress(min(max(0.0, *rows[-1]), wide), wide)
            if min(rows[-1]) >= wide:
                break
            pitches.append(PITCH_RATIO * pitches[-1])
        growth = np.concatenate(slopes)
        bounds = (float(growth.min()), float(growth.max())) if growth.size else None
        gaps, further_out = np.array(rows).T
        return PitchMap(np.array(pitches), gaps, further_out, bounds, close, growth.size)

    def _gap_between_turns_apart(self) -> float:
        """The largest width or, if smaller, the smallest gap of the dragon where adjacent turns are out of reach, m.

        Raises
        ------
        ParameterError
            If benches touch there, which they then do at any pitch.
        """
        dragon, widest = self._dragon, float(self._dragon.widths.max())
        straight = dragon.spacings[1:-1] - dragon.overhangs[:-2] - dragon.overhangs[2:]
        if straight.min(initial=np.inf) >= 2 * widest:
            return widest
        gap = min(_smallest_gaps(self._sampled(2 * float(dragon.lengths.max()) + widest)))
        if gap <= 0:
            raise ParameterError(
                "body_spacing", dragon.body_spacing, "long enough for benches not to touch on the circle"
            )
        return min(widest, gap)

    def _zero(self, blocked: float, free: float) -> float:
        """Zero of the smallest gap between two pitches, by Newton's method within the bracket."""
        pitch = free
        for _ in range(MAX_NEWTON_STEPS):
            gap, slope = self._smallest_gap(pitch)
            if gap > 0:
                free = pitch
            else:
                blocked = pitch
            better = pitch - gap / slope if slope > 0 else blocked
            if abs(better - pitch) <= STEP_TOLERANCE:
                return better
            pitch = better if blocked < better < free else (blocked + free) / 2
        return free

    def _smallest_gap(self, pitch: float) -> tuple[float, float]:
        """The smallest gap on the inward spiral, m, and its derivative by the pitch."""
        found = self._sampled(pitch).minimum()
        return (np.inf, 0.0) if found is None else (float(found.gaps[0]), _slope(found))

    def _first_contact(self, pitch: float) -> FirstContact:
        """Certified first contact before the circle."""
        march = self._march(pitch)
        return first_contact(march, until=distance_to_circle(march, self._radius))

    def _bisected(self, blocked: float, larger: list[float]) -> tuple[float, FirstContact]:
        """The limit between the pitch `blocked` and one of the `larger` pitches, and the contact below the limit.

        Bisection by certificates alone: slow, and always correct.
        """
        free = next((pitch for pitch in larger if self._first_contact(pitch).status == "clear"), np.inf)
        hit = self._first_contact(blocked)
        while CERTIFIED < free - blocked < np.inf:
            middle = (blocked + free) / 2
            between = self._first_contact(middle)
            if between.status == "clear":
                free = middle
            else:
                blocked, hit = middle, between
        if hit.benches is None or free == np.inf:
            raise DragonError(f"no limit of the pitch can be certified above {blocked:.9g} m")
        return free, hit


def _smallest_gaps(sampled: SampledGaps) -> tuple[float, float]:
    """The smallest sampled gap from the start on, and that of all samples, m."""
    return float(sampled.gaps[sampled.travelled >= 0].min()), float(sampled.gaps.min())


def _slope(smallest: Gaps) -> float:
    """Derivative of a minimal gap by the pitch: at the start for a fixed turn, elsewhere for a fixed radius."""
    slope = smallest.slopes[0, PITCH] if smallest.travelled[0] == 0 else smallest.slopes_at_radius[0]
    return float(slope)
