"""The smallest pitch at which the head reaches the turning circle (the contest's question 3).

A smaller pitch brings the turns closer together, so the head touches a bench that it passes before it reaches the
circle. The result consists of three parts:

- The limit. The smallest gap on the whole inward spiral, as a function of the pitch, has a zero. Newton's method finds
  the zero from the exact derivative (`_gaps.py`).
- Its certificate. `first_contact` certifies that the march is free of contacts a nanometre above the limit, and finds a
  contact a nanometre below.
- Its uniqueness: no free pitches below and no collisions above. Dragons are compared with their heads at the same
  distance from the centre. At every sampled pitch and position, every gap close to zero grows with the pitch. So a
  position that is free at one pitch is free at all larger pitches. Marches at larger pitches start further out, and the
  additional part of their spirals is sampled as well. So the free pitches are a half line that begins at the limit.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, replace
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
from pymunk_dragon.studies._study import Progress, Result, Study, labelled, silent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Limit = Literal["passing", "arrival", "start", "circle"]

# m. Radius of the contest's turning circle, and the largest one: with a wider circle the inward spiral is kilometres
# long, and the search takes minutes.
RADIUS, MAX_RADIUS = 4.5, 100.0
# Largest turn of the start. Samples begin further out, and a spiral has at most a thousand turns.
MAX_TURNS = 900.0
# m. Distance from the limit at which pitches are certified: a thousand times the error of the limit.
CERTIFIED = 1e-9
# m. Distance of the result from the zero of the smallest gap: rounding, of a few 1e-15 m, shows no overlap there.
TANGENCY_MARGIN = 1e-13
# Newton steps, at most (three suffice), and the step in m below which only rounding is left.
MAX_NEWTON_STEPS, STEP_TOLERANCE = 60, 1e-12
# Share of the distance to the circle within which a minimum of a gap lies at an end of the spiral.
AT_END = 1e-9
# Least pitch of the map over the width, which no march's pitch may equal, and ratio of successive pitches.
MIN_PITCH_RATIO, PITCH_RATIO = 1 + 1e-6, 1.04
# Shares of the width: smallest gap at which the map ends, because beyond it no gap is close to zero, and size up to
# which a gap counts as close to zero, 1 cm at the contest's 0.3 m.
MAP_END, CLOSE_TO_ZERO = 0.5, 1 / 30
# Text of each cause of a smallest pitch.
LIMITS = {"passing": "as the head passes", "arrival": "as the head arrives", "start": "as the dragon starts"}


@dataclass(frozen=True)
class PitchMap:
    """Smallest gaps on the inward spiral at several pitches, m; negative where benches overlap.

    `further_out` has those on a spiral that begins as far out as that of the next pitch, and `growth` the least and the
    largest derivative, by the pitch, of the `samples` gaps within `threshold` of zero, with handle 0 at the same
    distance from the centre; None without such gaps.
    """

    pitches: tuple[float, ...]
    gaps: tuple[float, ...]
    further_out: tuple[float, ...]
    growth: tuple[float, float] | None
    threshold: float
    samples: int


@dataclass(frozen=True, kw_only=True, repr=False)
class MinPitch(Result):
    """The smallest pitch at which handle 0 reaches the turning circle without a collision.

    Attributes
    ----------
    pitch : float
        The smallest pitch, m. If a gap limits it, two benches touch there without overlapping.
    turns, radius, march : float, float, March
        Turn of the spiral on which handle 0 starts, radius of the turning circle, m, and the march at that pitch.
    limit : {"passing", "arrival", "start", "circle"}
        Cause of the limit: the head touches a bench while passing it; two benches touch as the head arrives; two
        benches touch at the start; or only the circle, on which the head then starts.
    benches, point : tuple or None
        The two benches that touch, the smaller number first, and the contact point, m; None where no benches touch.
    distance, arrival_distance : float
        Distances travelled by handle 0 at the contact and at the circle, m; `march.time` gives the times.
    gap, slope : float or None
        Gap of the two benches at the contact, m, zero but for rounding; and its derivative by the pitch, m per m.
    half_line : bool
        Whether the map shows that all larger pitches are free, and all smaller ones are not.
    clear_pitch, contact_pitch : float
        Pitches, m, at which `first_contact` certifies a march without a contact, and finds a contact. The latter is
        None where only the circle is the limit: at a smaller pitch the head would start inside it.
    map : PitchMap
        Smallest gaps at other pitches.
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
        names = ("pitch", "radius", "turns", "limit", "benches", "point")
        evidence = ("gap", "slope", "clear_pitch", "contact_pitch", "half_line")
        known = asdict(self.map)
        del known["further_out"]
        # JSON has no infinity.
        known["gaps"] = [gap if math.isfinite(gap) else None for gap in self.map.gaps]
        return {
            **{name: getattr(self, name) for name in names},
            "time": float(self.march.time(self.distance)),
            "arrival": float(self.march.time(self.arrival_distance)),
            **{name: getattr(self, name) for name in evidence},
            "map": known,
        }

    def _lines(self) -> list[str]:
        first = text("smallest pitch {pitch:.12f} m: handle 0 reaches the circle of {radius:g} m")
        arrival = text("after {time:.3f} s").format(time=self.march.time(self.arrival_distance))
        if self.benches is None or self.point is None:
            limit = text("the circle, on which it starts;\nwith a smaller pitch it would start inside")
            certified = text("no contact at {clear:.12f} m").format(clear=self.clear_pitch)
        else:
            (i, j), (x, y) = self.benches, self.point
            limit = text(
                "benches {i} and {j} touch without overlapping {cause},\nt = {time:.6f} s at ({x:.6f}, {y:.6f}) m"
            ).format(i=i, j=j, cause=text(LIMITS[self.limit]), time=self.march.time(self.distance), x=x, y=y)
            certified = text("no contact at {clear:.12f} m, but one at {contact:.12f} m")
            certified = certified.format(clear=self.clear_pitch, contact=self.contact_pitch)
        return [
            first.format(pitch=self.pitch, radius=self.radius),
            *labelled("", arrival),
            *labelled(text("limit:"), limit),
            *labelled(text("certified:"), certified),
            *labelled(text("map:"), self._map_text()),
        ]

    def _map_text(self) -> str:
        """What is known of other pitches."""
        known = self.map
        first, last = known.pitches[0], known.pitches[-1]
        pitches = text("{count} pitches from {first:.4g} to {last:.4g} m;")
        pitches, near = pitches.format(count=len(known.pitches), first=first, last=last), 1e3 * known.threshold
        gaps = text("no gap comes within {near:.3g} mm of zero;").format(near=near)
        if known.growth is not None:
            gaps = text(
                "all {samples} gaps sampled within {near:.3g} mm of zero change with the pitch,\n"
                "the head being on the same circle, by {least:.2f} to {most:.2f} mm for each mm;"
            ).format(samples=known.samples, near=near, least=known.growth[0], most=known.growth[1])
        end = text("which does not show that all larger pitches are free, and all smaller ones are not")
        if self.half_line:
            end = text("so all larger pitches are free, and all smaller ones are not")
        return "\n".join((pitches, gaps, end))

    def _draw(self) -> Figure:
        """The smallest gap over the pitch, and the contact."""
        from pymunk_dragon.studies._figures import heading, panels, plan_view

        title = text("At a pitch of {:.6f} m the head starts on the circle itself").format(self.pitch)
        if self.benches is not None:
            title = text("At a pitch of {:.6f} m benches {} and {} just touch").format(self.pitch, *self.benches)
        aim = text("the smallest pitch at which handle 0 reaches the circle of {:g} m from turn {:g} without a contact")
        figure, axes = panels(title, aim.format(self.radius, self.turns), [["pitches", "contact"]])
        _draw_gap_over_pitch(axes["pitches"], self)
        heading(axes["contact"], text("dashed: the circle"))
        half = 0.7 * float(self.march.dragon.lengths[0])
        time = float(self.march.time(self.distance))
        plan_view(axes["contact"], self.march, time, self.radius, half, about=0, touching=self.benches or ())
        return figure


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
    # Turns are not closer than the width, and the start is not inside the circle.
    narrowest = max(float(dragon.widths.max()) * MIN_PITCH_RATIO, radius / turns)
    least = InwardMarch(dragon=dragon, pitch=narrowest, turns=turns, radius=radius)
    known = _pitch_map(least, progress)
    if known.gaps[0] > 0:
        # No gap is a limit.
        if least.pitch > radius / turns or _first_contact(least, least.pitch + CERTIFIED).status != "clear":
            short = "so many, and so long, that the dragon can run into itself outside the circle"
            raise ParameterError("benches", dragon.benches, short)
        return _result(least, speed, known, None)
    last = max(row for row, gap in enumerate(known.gaps) if gap <= 0)
    blocked, free = known.pitches[last : last + 2]
    pitch = zero_gap(replace(least, pitch=free), blocked, free) + TANGENCY_MARGIN
    inward = replace(least, pitch=pitch)
    contact = SampledGaps(inward).minimum()
    certified = contact is not None and _first_contact(least, pitch + CERTIFIED).status == "clear"
    if contact is not None and certified:
        # The same benches overlap at the same distance for a smaller pitch.
        below = replace(least, pitch=pitch - CERTIFIED)
        travelled = min(float(contact.travelled[0]), below.length)
        certified = bool(gaps_of(below, travelled, contact.pairs).gaps[0] < 0)
    if not certified:
        pitch, hit = _bisected(least, known.pitches[last:])
        inward = replace(least, pitch=pitch)
        contact = SampledGaps(inward).minimum()
        if contact is None or abs(contact.gaps[0]) > CERTIFIED:
            contact = gaps_of(inward, hit.time, [hit.benches or ()])
    return _result(inward, speed, known, contact)


def zero_gap(inward: InwardMarch, blocked: float, free: float) -> float:
    """Zero of the smallest sampled gap between two pitches, m, by Newton's method from the pitch of `inward`.

    SciPy's bracketing methods use no derivative and sample the spiral twice as often; importing them takes as long.
    """
    pitch = inward.pitch
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


def _pitch_map(least: InwardMarch, progress: Progress) -> PitchMap:
    """Smallest gaps from the march at the least pitch to a pitch at which all gaps are wide."""
    close = CLOSE_TO_ZERO * float(least.dragon.widths.min())
    dragon, gap = least.dragon, float(least.dragon.widths.max())
    straight = dragon.spacings[1:-1] - dragon.overhangs[:-2] - dragon.overhangs[2:]
    if straight.min(initial=np.inf) < 2 * gap:
        # The smallest gap where adjacent turns are out of reach.
        gap = min(gap, *SampledGaps(replace(least, pitch=2 * float(dragon.lengths.max()) + gap)).smallest())
    if gap <= 0:
        raise ParameterError("body_spacing", dragon.body_spacing, "long enough for benches not to touch on the circle")
    wide = MAP_END * gap
    pitches: list[float] = []
    rows: list[tuple[float, float]] = []
    slopes: list[float] = []
    while not rows or min(rows[-1]) < wide:
        pitches.append(PITCH_RATIO * pitches[-1] if pitches else least.pitch)
        sampled = SampledGaps(replace(least, pitch=pitches[-1]), PITCH_RATIO)
        rows.append(sampled.smallest())
        slopes += sampled.growth(close).tolist()
        progress(min(max(0.0, *rows[-1]), wide), wide)
    bounds = (min(slopes), max(slopes)) if slopes else None
    gaps, further_out = zip(*rows, strict=True)
    return PitchMap(tuple(pitches), gaps, further_out, bounds, close, len(slopes))


def _result(inward: InwardMarch, speed: float, known: PitchMap, contact: Gaps | None) -> MinPitch:
    """The result at a pitch with the contact that limits the pitch, and the test of the half line."""
    smaller = np.array(known.pitches) < inward.pitch
    separated = [
        # Where benches differ, the samples do not include the gaps of all of them.
        inward.dragon.alike,
        known.growth is None or known.growth[0] > 0,
        np.all(np.array(known.gaps)[smaller] < 0),
        np.all(np.array(known.further_out)[~smaller] > 0),
        SampledGaps(inward, PITCH_RATIO).smallest()[1] > -CERTIFIED,
    ]
    limit: Limit = "circle"
    benches = point = None
    if contact is not None:
        (x, y), share = contact.points[0].tolist(), contact.travelled[0]
        benches, point = contact.benches, (x, y)
        at_end: Limit = "arrival" if share >= (1 - AT_END) * inward.length else "passing"
        limit = "start" if share <= AT_END * inward.length else at_end
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


def _slope(smallest: Gaps) -> float:
    """Derivative of a minimal gap by the pitch: at the start for a fixed turn, elsewhere for a fixed radius."""
    return float(smallest.slopes[0, PITCH] if smallest.travelled[0] == 0 else smallest.slopes_at_radius[0])


def _first_contact(inward: InwardMarch, pitch: float) -> FirstContact:
    """Certified first contact before the circle at a pitch."""
    changed = replace(inward, pitch=pitch)
    return first_contact(changed.march, until=changed.length)


def _bisected(inward: InwardMarch, pitches: tuple[float, ...]) -> tuple[float, FirstContact]:
    """The limit above the first of the pitches, by bisection of certificates alone, and the contact below the limit."""
    blocked, *larger = pitches
    free = next((pitch for pitch in larger if _first_contact(inward, pitch).status == "clear"), math.inf)
    hit = _first_contact(inward, blocked)
    while CERTIFIED < free - blocked < math.inf:
        middle = (free + blocked) / 2
        if (found := _first_contact(inward, middle)).status == "clear":
            free = middle
        else:
            blocked, hit = middle, found
    if free == math.inf or hit.benches is None:
        raise DragonError(f"no limit of the pitch can be certified above {blocked:.9g} m")
    return free, hit


def _draw_gap_over_pitch(axes: Axes, found: MinPitch) -> None:
    """Draw the smallest gap of a march over the pitch."""
    from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, FAINT, QUIET
    from pymunk_dragon.studies._figures import heading

    heading(axes, text("smallest gap before the circle, mm"))
    gaps = 1e3 * np.array(found.map.gaps)
    axes.axhline(0.0, color=QUIET, lw=0.8)
    axes.plot(found.map.pitches, gaps, "o-", color=BLUE, lw=2.0, ms=3, gid="gap-over-pitch")
    gap, answer = 0.0 if found.benches is not None else float(gaps[0]), f"{found.pitch:.9f} m"
    axes.plot(found.pitch, gap, "o", color=COLOURS.contact, ms=7, zorder=4, gid="answer", label=answer)
    axes.set_ylim(*axes.get_ylim())
    if gaps[0] < 0:
        axes.axhspan(axes.get_ylim()[0], 0.0, color=FAINT, lw=0, zorder=0)
        axes.text(0.97, 0.06, text("benches overlap"), transform=axes.transAxes, ha="right", color=QUIET)
    axes.set_xlabel(text("pitch (m)"))
    axes.legend(loc="upper left", frameon=False, borderpad=0.0)


STUDY = Study(
    name="min-pitch",
    summary="smallest pitch at which the head reaches the circle (question 3)",
    run=min_pitch,
)
