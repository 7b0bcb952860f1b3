"""The smallest pitch at which the head reaches the turning circle (the contest's question 3).

With a smaller pitch the head touches a bench that it passes before it reaches the circle. The result has two parts:

- A map: the smallest gap of the whole inward march at pitches 4 % apart, from the width of a bench to a pitch at which
  turns are too far apart for benches to touch. The last pitch with an overlap, and the next one, bracket the limit.
- The limit: the zero of the smallest gap in this bracket. `first_contact` certifies that the march is free of contacts
  a nanometre above the limit; a nanometre below, two benches overlap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pymunk_dragon._checks import finite, positive
from pymunk_dragon._language import text
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves.spiral import MAX_PITCH
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._gaps import Gap, InwardMarch
from pymunk_dragon.studies._study import Progress, Result, Study, labelled, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_Limit = Literal["passing", "arrival", "start", "circle"]

# m. Radius of the contest's turning circle, and the largest one: with a wider circle the inward spiral is kilometres
# long, and the search takes minutes.
RADIUS, _MAX_RADIUS = 4.5, 100.0
# Largest turn of the start: a spiral has at most a thousand turns.
MAX_TURNS = 900.0
# m. Distance from the limit at which pitches are certified: a thousand times the error of the limit.
_CERTIFIED = 1e-9
# m. Distance of the result from the zero of the smallest gap: rounding, of a few 1e-15 m, shows no overlap there.
_TANGENCY_MARGIN = 1e-13
# Steps to the zero, at most (some eight suffice), and the gap in m below which only rounding is left.
MAX_STEPS, _GAP_ROUNDING = 60, 1e-14
# Share of the distance to the circle within which the smallest gap lies at an end of the march.
_AT_END = 1e-9
# Least pitch of the map over the width, which no march's pitch may equal, and ratio of successive pitches.
_MIN_PITCH_RATIO, _PITCH_RATIO = 1 + 1e-6, 1.04
# Text of each cause of a smallest pitch.
_LIMITS = {"passing": "as the head passes", "arrival": "as the head arrives", "start": "as the dragon starts"}


@dataclass(frozen=True, kw_only=True, repr=False)
class MinPitch(Result):
    """The smallest pitch at which handle 0 reaches the turning circle without a collision.

    Attributes
    ----------
    pitch, turns, radius, march : float, float, float, March
        The smallest pitch, m, the turn on which handle 0 starts, radius of the circle, m, and the march at that pitch.
    limit : {"passing", "arrival", "start", "circle"}
        Cause of the limit: two benches touch without overlapping as the head passes, as it arrives or at the start; or
        the head starts on the circle.
    benches, point, gap : tuple, tuple, float, or None
        The two benches that touch, the smaller number first, the contact point, m, and their gap, zero but for
        rounding, m; None where no benches touch.
    distance, arrival_distance : float
        Distances travelled by handle 0 at the contact and at the circle, m; `march.time` gives the times.
    clear_pitch, contact_pitch : float
        Pitches, m, at which `first_contact` certifies a march without a contact, and at which two benches overlap; the
        latter is None where the circle is the limit.
    pitches, gaps : tuple of float
        The map: pitches, and the smallest gap before the circle at each, m; negative where benches overlap.
    """

    pitch: float
    turns: float
    radius: float
    march: March
    limit: _Limit = "circle"
    benches: tuple[int, int] | None = None
    point: tuple[float, float] | None = None
    distance: float
    arrival_distance: float
    gap: float | None = None
    clear_pitch: float
    contact_pitch: float | None = None
    pitches: tuple[float, ...]
    gaps: tuple[float, ...]

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study min-pitch --json` prints them."""
        names = ("pitch", "radius", "turns", "limit", "benches", "point", "gap", "clear_pitch", "contact_pitch")
        time, arrival = self.march.time([self.distance, self.arrival_distance]).tolist()
        # JSON has no infinity.
        gaps = [gap if math.isfinite(gap) else None for gap in self.gaps]
        known = {"time": time, "arrival": arrival, "map": {"pitches": self.pitches, "gaps": gaps}}
        return {name: getattr(self, name) for name in names} | known

    def _lines(self) -> list[str]:
        first = text("smallest pitch {pitch:.12f} m: handle 0 reaches the circle of {radius:g} m")
        arrival = text("after {time:.3f} s")
        limit = text("the circle, on which it starts;\nwith a smaller pitch it would start inside")
        certified = text("no contact at {clear:.12f} m")
        if self.benches is not None and self.point is not None:
            (i, j), (x, y), time = self.benches, self.point, self.march.time(self.distance)
            limit = text(
                "benches {i} and {j} touch without overlapping {cause},\nt = {time:.6f} s at ({x:.6f}, {y:.6f}) m"
            ).format(i=i, j=j, cause=text(_LIMITS[self.limit]), time=time, x=x, y=y)
            certified = text("no contact at {clear:.12f} m, but one at {contact:.12f} m")
        known = text("{count} pitches from {first:.4g} to {last:.4g} m;")
        known = known.format(count=len(self.pitches), first=self.pitches[0], last=self.pitches[-1])
        trend = text("the smallest gap falls between some of them")
        if all(less < more or math.isinf(more) for less, more in pairwise(self.gaps)):
            trend = text("the smallest gap grows from each to the next")
        return [
            first.format(pitch=self.pitch, radius=self.radius),
            *labelled("", arrival.format(time=self.march.time(self.arrival_distance))),
            *labelled(text("limit:"), limit),
            *labelled(text("certified:"), certified.format(clear=self.clear_pitch, contact=self.contact_pitch)),
            *labelled(text("map:"), f"{known}\n{trend}"),
        ]

    def _draw(self) -> Figure:
        """The smallest gap over the pitch, and the contact."""
        from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, QUIET
        from pymunk_dragon.studies._figures import heading, panels, plan_view

        title = text("At a pitch of {:.6f} m the head starts on the circle itself").format(self.pitch)
        if self.benches is not None:
            title = text("At a pitch of {:.6f} m benches {} and {} just touch").format(self.pitch, *self.benches)
        aim = text("the smallest pitch at which handle 0 reaches the circle of {:g} m from turn {:g} without a contact")
        figure, axes = panels(title, aim.format(self.radius, self.turns), [["pitches", "contact"]])
        heading(axes["pitches"], text("smallest gap before the circle, mm"))
        axes["pitches"].axhline(0.0, color=QUIET, lw=0.8)
        axes["pitches"].plot(self.pitches, 1e3 * np.array(self.gaps), "o-", color=BLUE, ms=3, gid="gap-over-pitch")
        answer, gap = f"{self.pitch:.9f} m", 1e3 * self.gaps[0] if self.benches is None else 0.0
        axes["pitches"].plot(self.pitch, gap, "o", color=COLOURS.contact, ms=7, gid="answer", label=answer)
        axes["pitches"].set_xlabel(text("pitch (m)"))
        axes["pitches"].legend(loc="upper left", frameon=False, borderpad=0.0)
        heading(axes["contact"], text("ring: the contact"))
        time = float(self.march.time(self.distance))
        plan_view(axes["contact"], self.march, time, self.radius, self.radius + 5 * self.pitch)
        x, y = self.point or self.march.at(time).positions[0, 0].tolist()
        axes["contact"].plot(x, y, "o", mec=COLOURS.contact, mfc="none", mew=2.0, ms=16, zorder=4, gid="contact")
        half = 0.7 * float(self.march.dragon.lengths[0])
        axes["contact"].set(xlim=(x - half, x + half), ylim=(y - half, y + half))
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

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's.
    turns, speed
        As in `March`.
    radius : float
        Radius of the circle, m.
    progress : callable, optional
        Called with the number of pitches of the map that are done, and that of all.

    Returns
    -------
    MinPitch
        The pitch is accurate to 1e-12 m, and certified to 1e-9 m. No larger pitch of the map has an overlap.

    Raises
    ------
    ParameterError
        If the radius is less than the longest spacing (further in, a handle may have no position) or larger than any
        start, benches touch however far apart the turns are, or the dragon is too short to pass itself.
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
    radius = finite("radius", radius, float(dragon.spacings.max()), min(_MAX_RADIUS, MAX_PITCH * turns), "m")
    # Turns are not closer than the width, and the start is not inside the circle.
    narrowest = max(float(dragon.widths.max()) * _MIN_PITCH_RATIO, radius / turns)
    least = InwardMarch(dragon, narrowest, turns, radius)
    pitches, gaps = _map(least, progress)
    inward, contact = least, None
    blocked = [row for row, gap in enumerate(gaps) if gap <= 0]
    if blocked:
        around = slice(blocked[-1], blocked[-1] + 2)
        inward = replace(least, pitch=_zero(least, pitches[around], gaps[around]) + _TANGENCY_MARGIN)
        contact = inward.smallest_gap()
    above, below = (replace(inward, pitch=inward.pitch + side) for side in (_CERTIFIED, -_CERTIFIED))
    # Two benches that overlap are a contact, whatever else the march contains.
    if above.first_contact.status != "clear" or (contact is not None and below.smallest_gap().size >= 0):
        inward, contact = _bisected(least, pitches)
    elif contact is None and inward.pitch > radius / turns:
        short = "so many, and so long, that the dragon can run into itself outside the circle"
        raise ParameterError("benches", dragon.benches, short)
    touching: dict[str, Any] = {}
    if contact is not None:
        share = contact.travelled / inward.length
        at_end: _Limit = "arrival" if share >= 1 - _AT_END else "passing"
        touching = {"limit": "start" if share <= _AT_END else at_end, "contact_pitch": inward.pitch - _CERTIFIED}
        touching |= {"gap": contact.size, "benches": contact.benches, "point": contact.point}
    return MinPitch(
        pitch=inward.pitch,
        turns=turns,
        radius=radius,
        march=replace(inward.march, speed=speed),
        distance=contact.travelled if contact else 0.0,
        arrival_distance=inward.length,
        clear_pitch=inward.pitch + _CERTIFIED,
        pitches=pitches,
        gaps=gaps,
        **touching,
    )


def _map(least: InwardMarch, progress: Progress) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Pitches from that of `least` until turns are out of each other's reach, and the smallest gap at each, m."""
    dragon, half = least.dragon, least.dragon.spacings / 2
    # How far benches with handles on the circle reach beyond it, and into it.
    middle = np.sqrt(least.radius**2 - half**2)
    beyond = np.hypot(half + dragon.overhangs, middle + dragon.widths / 2) - least.radius
    into = least.radius - middle + dragon.widths / 2
    ratio = max(_PITCH_RATIO, float(beyond.max() + into.max()) / least.pitch)
    count = math.ceil(math.log(ratio) / math.log(_PITCH_RATIO)) + 1
    pitches = tuple(least.pitch * _PITCH_RATIO**row for row in range(count))
    gaps = []
    for row, pitch in enumerate(pitches):
        gaps.append(replace(least, pitch=pitch).smallest_gap().size)
        progress(row + 1, count)
    if gaps[-1] <= 0:
        raise ParameterError("body_spacing", dragon.body_spacing, "long enough for benches not to touch on the circle")
    return pitches, tuple(gaps)


def _zero(least: InwardMarch, pitches: tuple[float, ...], gaps: tuple[float, ...]) -> float:
    """Zero of the smallest gap, m, between a pitch with an overlap and one without, by the Illinois method."""
    (blocked, free), (overlap, gap) = pitches, gaps
    size = overlap
    for _ in range(MAX_STEPS):
        pitch = blocked - overlap * (free - blocked) / (gap - overlap)
        before, size = size, replace(least, pitch=pitch).smallest_gap().size
        if abs(size) <= _GAP_ROUNDING:
            return pitch
        # An end that stays for a second time counts half, so that the bracket shrinks from both sides.
        again = 0.5 if (size > 0) == (before > 0) else 1.0
        if size > 0:
            free, gap, overlap = pitch, size, overlap * again
        else:
            blocked, overlap, gap = pitch, size, gap * again
    return free


def _bisected(least: InwardMarch, pitches: tuple[float, ...]) -> tuple[InwardMarch, Gap]:
    """The march at the limit, below the largest of the pitches, by bisection of certificates alone, and its contact."""
    marches = [replace(least, pitch=pitch) for pitch in (pitches[0] + _CERTIFIED, *pitches[1:])]
    row = next((row for row in reversed(range(len(marches))) if marches[row].first_contact.status != "clear"), -1)
    if row in (-1, len(marches) - 1):
        raise DragonError(f"no limit of the pitch can be certified from {pitches[0]:.9g} to {pitches[-1]:.9g} m")
    blocked, free = marches[row : row + 2]
    while free.pitch - blocked.pitch > _CERTIFIED:
        middle = replace(least, pitch=(free.pitch + blocked.pitch) / 2)
        free, blocked = (middle, blocked) if middle.first_contact.status == "clear" else (free, middle)
    hit = blocked.first_contact
    return free, free.gap_about(hit.time, float(least.dragon.spacings.min()), hit.benches or (0, 0))


STUDY = Study(
    name="min-pitch", summary="smallest pitch at which the head reaches the circle (question 3)", run=min_pitch
)
