"""The smallest pitch at which the head reaches the turning circle (the contest's question 3).

A smaller pitch brings the turns closer together, so the head touches a bench that it passes before it reaches the
circle. The result consists of three parts:

- The limit. The smallest gap on the whole inward spiral, as a function of the pitch, has a zero. Newton's method finds
  the zero from the exact derivative (`_gaps.py`).
- Its certificate. `first_contact` certifies that the march is free of contacts a nanometre above the limit, and finds a
  contact a nanometre below.
- Its uniqueness: no free pitches below and no collisions above (`_pitch_map.py`). Dragons are compared with their heads
  at the same distance from the centre. At every sampled pitch and position, every gap close to zero grows with the
  pitch. So a position that is free at one pitch is free at all larger pitches. Marches at larger pitches start further
  out, and the additional part of their spirals is sampled as well. So the free pitches are a half line that begins at
  the limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pymunk_dragon._checks import finite, positive
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves.spiral import MAX_PITCH
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._gaps import PITCH, Gaps, InwardMarch, SampledGaps, gaps_of
from pymunk_dragon.studies._pitch_map import PITCH_RATIO, PitchMap, at_least_pitch, pitch_map, smallest_gaps
from pymunk_dragon.studies._study import Progress, Result, Study, bracketed, labelled, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Limit = Literal["passing", "arrival", "start", "circle"]

# m. Radius of the contest's turning circle.
RADIUS = 4.5
# m. Largest radius: with a wider circle the inward spiral is kilometres long, and the search takes minutes.
MAX_RADIUS = 100.0
# Largest turn of the start. Samples begin further out, and a spiral has at most a thousand turns.
MAX_TURNS = 900.0
# m. Distance from the limit at which pitches are certified: a thousand times the error of the limit.
CERTIFIED = 1e-9
# m. Distance of the result from the zero of the smallest gap: rounding, of a few 1e-15 m, shows no overlap there.
TANGENCY_MARGIN = 1e-13
# Newton steps, at most; three suffice.
MAX_NEWTON_STEPS = 60
# m. Newton step below which only rounding is left.
STEP_TOLERANCE = 1e-12
# Share of the distance to the circle within which a minimum of a gap lies at an end of the spiral.
AT_END = 1e-9
# Text of each cause of a smallest pitch.
LIMITS = {"passing": "as the head passes", "arrival": "as the head arrives", "start": "as the dragon starts"}


@dataclass(frozen=True, kw_only=True, repr=False)
class MinPitch(Result):
    """The smallest pitch at which handle 0 reaches the turning circle without a collision.

    Attributes
    ----------
    pitch : float
        The smallest pitch, m. If a gap limits it, two benches touch there without overlapping.
    turns, radius : float
        Turn of the spiral on which handle 0 starts, and radius of the turning circle, m.
    march : March
        March on the spiral of that pitch.
    limit : {"passing", "arrival", "start", "circle"}
        Cause of the limit: the head touches a bench while passing it; two benches touch as the head arrives; two
        benches touch at the start; or only the circle, on which the head then starts.
    benches : tuple of int or None
        The two benches that touch, the smaller number first; None where no benches touch.
    point : tuple of float or None
        Contact point, m.
    distance, arrival_distance : float
        Distances travelled by handle 0 at the contact and at the circle, m; `march.time` gives the times.
    gap : float or None
        Gap of the two benches at the contact, m; zero but for rounding.
    slope : float or None
        Derivative of the smallest gap by the pitch, m per m.
    half_line : bool
        Whether the map shows that all larger pitches are free, and all smaller ones are not.
    clear_pitch, contact_pitch : float
        Pitches, m, at which `first_contact` certifies a march without a contact, and finds a contact. The latter is
        None where only the circle is the limit: at a smaller pitch the head would start inside it.
    map : PitchMap
        Smallest gaps at other pitches.

    Examples
    --------
    >>> found = min_pitch(Dragon(benches=25))
    >>> found
    <MinPitch: smallest pitch 0.450337393027 m: handle 0 reaches the circle of 4.5 m>
    >>> found.benches, found.half_line
    ((0, 19), True)
    """

    pitch: float
    turns: float
    radius: float
    march: March
    limit: Limit
    benches: tuple[int, int] | None
    point: tuple[float, float] | None
    distance: float
    arrival_distance: float
    gap: float | None
    slope: float | None
    half_line: bool
    clear_pitch: float
    contact_pitch: float | None
    map: PitchMap = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study min-pitch --json` prints them."""
        return {
            "pitch": self.pitch,
            "radius": self.radius,
            "turns": self.turns,
            "limit": self.limit,
            "benches": self.benches,
            "point": self.point,
            "time": float(self.march.time(self.distance)),
            "arrival": float(self.march.time(self.arrival_distance)),
            "gap": self.gap,
            "slope": self.slope,
            "clear_pitch": self.clear_pitch,
            "contact_pitch": self.contact_pitch,
            "half_line": self.half_line,
            "map": {
                "pitches": self.map.pitches.tolist(),
                # JSON has no infinity: a pitch at which the head passes no bench has no gap.
                "gaps": [gap if math.isfinite(gap) else None for gap in self.map.gaps.tolist()],
                "growth": self.map.growth,
                "threshold": self.map.threshold,
                "samples": self.map.samples,
            },
        }

    def _lines(self) -> list[str]:
        arrival = self.march.time(self.arrival_distance)
        lines = [
            text("smallest pitch {pitch:.12f} m: handle 0 reaches the circle of {radius:g} m").format(
                pitch=self.pitch, radius=self.radius
            ),
            *labelled("", text("after {time:.3f} s").format(time=arrival)),
        ]
        if self.benches is None or self.point is None:
            limit = text("the circle, on which it starts;\nwith a smaller pitch it would start inside")
            certified = text("no contact at {clear:.12f} m").format(clear=self.clear_pitch)
        else:
            (i, j), (x, y) = self.benches, self.point
            limit = text(
                "benches {i} and {j} touch without overlapping {cause},\nt = {time:.6f} s at ({x:.6f}, {y:.6f}) m"
            ).format(i=i, j=j, cause=text(LIMITS[self.limit]), time=self.march.time(self.distance), x=x, y=y)
            certified = text("no contact at {clear:.12f} m, but one at {contact:.12f} m").format(
                clear=self.clear_pitch, contact=self.contact_pitch
            )
        return [
            *lines,
            *labelled(text("limit:"), limit),
            *labelled(text("certified:"), certified),
            *labelled(text("map:"), self._map_text()),
        ]

    def _map_text(self) -> str:
        """What is known of other pitches."""
        known = self.map
        pitches = text("{count} pitches from {first:.4g} to {last:.4g} m;").format(
            count=len(known.pitches), first=known.pitches[0], last=known.pitches[-1]
        )
        near = 1e3 * known.threshold
        if known.growth is None:
            gaps = text("no gap comes within {near:.3g} mm of zero;").format(near=near)
        else:
            gaps = text(
                "all {samples} gaps sampled within {near:.3g} mm of zero change with the pitch,\n"
                "the head being on the same circle, by {least:.2f} to {most:.2f} mm for each mm;"
            ).format(samples=known.samples, near=near, least=known.growth[0], most=known.growth[1])
        if self.half_line:
            end = text("so all larger pitches are free, and all smaller ones are not")
        else:
            end = text("which does not show that all larger pitches are free, and all smaller ones are not")
        return "\n".join((pitches, gaps, end))

    def _draw(self) -> Figure:
        from pymunk_dragon.studies._min_pitch_figure import draw

        return draw(self)


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

    Examples
    --------
    >>> print(min_pitch(Dragon(benches=25)))  # doctest: +ELLIPSIS
    smallest pitch 0.450337393027 m: handle 0 reaches the circle of 4.5 m
               after 220.934 s
    limit:     benches 0 and 19 touch without overlapping as the head passes,
    ...
    """
    dragon = dragon or Dragon()
    turns = positive("turns", turns, MAX_TURNS, "")
    # Inside the longest spacing a handle may have no position, and beyond the largest start there is no spiral.
    radius = finite("radius", radius, float(dragon.spacings.max()), min(MAX_RADIUS, MAX_PITCH * turns), "m")
    least = at_least_pitch(dragon, turns, radius)
    known = pitch_map(least, progress)
    if known.gaps[0] > 0:
        # No gap is a limit.
        if least.pitch > radius / turns or _first_contact(least, least.pitch + CERTIFIED).status != "clear":
            short = "so many, and so long, that the dragon can run into itself outside the circle"
            raise ParameterError("benches", dragon.benches, short)
        return _result(least, speed, known, "circle", None)
    last = int(np.flatnonzero(known.gaps <= 0)[-1])
    contact_pitch, clear_pitch = known.pitches[last : last + 2].tolist()
    pitch = _zero(least, contact_pitch, clear_pitch) + TANGENCY_MARGIN
    inward = replace(least, pitch=pitch)
    contact = SampledGaps(inward).minimum()
    touches = contact is not None and _overlap(replace(least, pitch=pitch - CERTIFIED), contact)
    if contact is None or not touches or _first_contact(least, pitch + CERTIFIED).status != "clear":
        pitch, hit = _bisected(least, contact_pitch, known.pitches[last + 1 :].tolist())
        inward = replace(least, pitch=pitch)
        contact = SampledGaps(inward).minimum()
        if contact is None or abs(contact.gaps[0]) > CERTIFIED:
            assert hit.benches is not None  # A contact is between two benches.
            contact = gaps_of(inward, hit.time, hit.benches)
    travelled = float(contact.travelled[0])
    limit: Limit = "passing"
    if travelled <= AT_END * inward.length:
        limit = "start"
    elif travelled >= (1 - AT_END) * inward.length:
        limit = "arrival"
    return _result(inward, speed, known, limit, contact)


def _result(inward: InwardMarch, speed: float, known: PitchMap, limit: Limit, contact: Gaps | None) -> MinPitch:
    """The result at a pitch with the contact that limits the pitch, and the test of the half line."""
    below = known.pitches < inward.pitch
    separated = [
        # Where benches differ, the samples do not include the gaps of all of them.
        inward.dragon.alike,
        known.growth is None or known.growth[0] > 0,
        np.all(known.gaps[below] < 0),
        np.all(known.further_out[~below] > 0),
        smallest_gaps(SampledGaps(inward, PITCH_RATIO))[1] > -CERTIFIED,
    ]
    benches = point = None
    if contact is not None:
        (i, j), (x, y) = contact.pairs[0].tolist(), contact.points[0].tolist()
        benches, point = (i, j), (x, y)
    return MinPitch(
        pitch=inward.pitch,
        turns=inward.turns,
        radius=inward.radius,
        march=replace(inward.march, speed=speed),
        limit=limit,
        benches=benches,
        point=point,
        distance=0.0 if contact is None else float(contact.travelled[0]),
        # Rounding may give a negative distance where the start is on the circle.
        arrival_distance=max(0.0, inward.length),
        gap=None if contact is None else float(contact.gaps[0]),
        slope=None if contact is None else _slope(contact),
        half_line=all(separated),
        clear_pitch=inward.pitch + CERTIFIED,
        contact_pitch=None if contact is None else inward.pitch - CERTIFIED,
        map=known,
    )


def _zero(inward: InwardMarch, blocked: float, free: float) -> float:
    """Zero of the smallest gap between two pitches, by Newton's method within the bracket.

    SciPy's bracketing methods use no derivative and sample the spiral twice as often; importing them takes as long.
    """
    pitch = free
    for _ in range(MAX_NEWTON_STEPS):
        found = SampledGaps(replace(inward, pitch=pitch)).minimum()
        gap, slope = (np.inf, 0.0) if found is None else (float(found.gaps[0]), _slope(found))
        if gap > 0:
            free = pitch
        else:
            blocked = pitch
        better = pitch - gap / slope if slope > 0 else blocked
        if abs(better - pitch) <= STEP_TOLERANCE:
            return better
        pitch = better if blocked < better < free else (blocked + free) / 2
    return free


def _slope(smallest: Gaps) -> float:
    """Derivative of a minimal gap by the pitch: at the start for a fixed turn, elsewhere for a fixed radius."""
    slope = smallest.slopes[0, PITCH] if smallest.travelled[0] == 0 else smallest.slopes_at_radius[0]
    return float(slope)


def _overlap(inward: InwardMarch, contact: Gaps) -> bool:
    """Whether the benches of a contact at another pitch overlap where the head has travelled as far."""
    travelled = min(float(contact.travelled[0]), inward.length)
    return bool(gaps_of(inward, travelled, contact.pairs).gaps[0] < 0)


def _first_contact(inward: InwardMarch, pitch: float) -> FirstContact:
    """Certified first contact before the circle at a pitch."""
    changed = replace(inward, pitch=pitch)
    return first_contact(changed.march, until=changed.length)


def _bisected(inward: InwardMarch, blocked: float, larger: list[float]) -> tuple[float, FirstContact]:
    """The limit between the pitch `blocked` and one of the `larger` pitches, and the contact below the limit.

    Bisection by certificates alone: slow, and always correct.
    """

    def contact(pitch: float) -> FirstContact | None:
        found = _first_contact(inward, pitch)
        return None if found.status == "clear" else found

    free, hit = next((pitch for pitch in larger if contact(pitch) is None), None), _first_contact(inward, blocked)
    if free is not None:
        free, blocked, hit = bracketed(contact, free, blocked, hit, width=CERTIFIED)
    if free is None or hit.benches is None:
        raise DragonError(f"no limit of the pitch can be certified above {blocked:.9g} m")
    return free, hit


STUDY = Study(
    name="min-pitch",
    summary="smallest pitch at which the head reaches the circle (question 3)",
    run=min_pitch,
)
