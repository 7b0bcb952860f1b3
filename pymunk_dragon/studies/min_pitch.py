"""The smallest pitch at which the head reaches the turning circle (the contest's question 3).

With a smaller pitch the head touches a bench that it passes before it reaches the circle.
`first_contact` decides for each pitch whether it does: from one at which turns are out of each
other's reach down to the first with a contact, and then closer to the limit. There the near miss of
a march without a contact has the gap of the benches that touch at the limit. The pitch is the zero
of this gap over the pitch, and marches a nanometre above and below are certified.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import as_vectors
from pymunk_dragon._checks import finite, function, positive, silent
from pymunk_dragon._language import text
from pymunk_dragon.collision import Separation, first_contact, separation
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.curves.spiral import MAX_PITCH
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.speed import MAX_SPEED, MIN_SPEED
from pymunk_dragon.studies._study import Progress, Result, checked_dragon, labelled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# m. Radius of the contest's turning circle.
RADIUS = 4.5
# m. Largest radius: with a wider circle the inward spiral is kilometres long, and the search takes
# minutes.
_MAX_RADIUS = 100.0
# Largest turn of the start: a spiral has at most a thousand turns.
_MAX_TURNS = 900.0
# m. Distance from the limit at which pitches are certified: a thousand times the error of the
# limit.
_CERTIFIED = 1e-9
# Least pitch over the width, which no march's pitch may equal.
_MIN_PITCH_RATIO = 1 + 1e-6
# Ratio of successive pitches, from one at which turns are out of each other's reach down.
_PITCH_RATIO = 1.06
# Share of a step of the secant method by which it stays above the limit.
_MARGIN = 0.01
# Marches near the limit, at most: some seven suffice, and bisection alone takes 25.
_MAX_STEPS = 60


@dataclass(frozen=True, kw_only=True, repr=False)
class MinPitch(Result):
    """The smallest pitch at which handle 0 reaches the turning circle without a collision.

    Attributes
    ----------
    pitch : float
        The smallest pitch, m.
    radius : float
        Radius of the circle, m.
    march : March
        The march at the smallest pitch.
    benches : tuple or None
        The two benches that touch, the smaller number first; None where the pitch is limited by the
        circle, on which the head starts.
    point : tuple or None
        The contact point, m; None where no benches touch.
    distance : float
        Distance travelled by handle 0 at the contact, m, to some micrometres; `march.time` gives
        the time.
    arrival_distance : float
        Distance travelled by handle 0 at the circle, m.
    clear_pitch : float
        Pitch certified by `first_contact` to be without a contact, m.
    contact_pitch : float or None
        Pitch certified to have a contact, m; None where no benches touch.
    larger_pitches : tuple of float
        Larger pitches certified to be without a contact, m.
    """

    pitch: float
    radius: float
    march: March
    benches: tuple[int, int] | None = None
    point: tuple[float, float] | None = None
    distance: float = 0.0
    arrival_distance: float
    clear_pitch: float
    contact_pitch: float | None = None
    larger_pitches: tuple[float, ...]

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study min-pitch --json` prints them."""
        names = (
            "pitch",
            "radius",
            "benches",
            "point",
            "clear_pitch",
            "contact_pitch",
            "larger_pitches",
        )
        time, arrival = self.march.time([self.distance, self.arrival_distance]).tolist()
        return {name: getattr(self, name) for name in names} | {"time": time, "arrival": arrival}

    def _lines(self) -> list[str]:
        time, arrival = self.march.time([self.distance, self.arrival_distance]).tolist()
        first = text("smallest pitch {pitch:.12f} m: handle 0 reaches the circle of {radius:g} m")
        limit = text("the circle, on which it starts;\nwith a smaller pitch it would start inside")
        certified = text("no contact at {clear:.12f} m")
        if self.benches is not None and self.point is not None:
            (i, j), (x, y) = self.benches, self.point
            limit = text("benches {i} and {j} touch at t = {time:.4f} s at ({x:.4f}, {y:.4f}) m")
            limit = limit.format(i=i, j=j, time=time, x=x, y=y)
            certified = text("no contact at {clear:.12f} m, but one at {contact:.12f} m")

        certified = certified.format(clear=self.clear_pitch, contact=self.contact_pitch)
        larger = text("none at {count} larger pitches up to {largest:.4f} m")
        larger = larger.format(count=len(self.larger_pitches), largest=self.larger_pitches[0])
        return [
            first.format(pitch=self.pitch, radius=self.radius),
            labelled("", text("after {time:.3f} s", time=arrival)),
            labelled(text("limit:"), limit),
            labelled(text("certified:"), f"{certified}\n{larger}"),
        ]

    def _draw(self) -> Figure:
        """The head and the benches around it at the contact, or at the start on the circle."""
        from pymunk_dragon.drawing.figures import style

        title = text("At a pitch of {:.6f} m the head starts on the circle itself")
        if self.benches is not None:
            title = text("At a pitch of {:.6f} m benches {} and {} just touch")
        title = title.format(self.pitch, *(self.benches or ()))
        aim = text(
            "the smallest pitch at which handle 0 reaches the circle of {:g} m without a contact"
        )
        figure, axes = style.slide(title, aim.format(self.radius))

        states = self.march.at(self.march.time(self.distance))
        outlines = self.march.dragon.outlines(states.poses[0])
        for bench, outline in enumerate(outlines):
            face = style.COLOURS.head if bench == 0 else style.SHARED
            axes.fill(*outline.T, fc=face, ec=style.QUIET, lw=0.8, gid=f"bench-{bench}")

        x, y = self.point or states.positions[0, 0].tolist()
        axes.plot(x, y, "o", mec=style.COLOURS.contact, mfc="none", mew=2.0, ms=16, gid="contact")
        half = 0.7 * float(self.march.dragon.lengths[0])
        axes.set(xlim=(x - 2 * half, x + 2 * half), ylim=(y - half, y + half), aspect="equal")
        axes.set(xlabel="x (m)", ylabel="y (m)")
        return figure


class _InwardMarch:
    """March at 1 m/s inward from a turn of a spiral to a circle, with its first contact."""

    def __init__(self, dragon: Dragon, pitch: float, turns: float, radius: float) -> None:
        self.pitch = pitch
        spiral = Spiral(pitch=pitch)
        self.march = March(dragon, spiral, turns=turns)
        self.length = _length(spiral, turns, radius)
        self.found = first_contact(self.march, until=self.length)
        self.clear = self.found.status == "clear"
        # Benches that touch or have a near miss.
        self.near = {miss.benches for miss in self.found.near_misses or ()}
        if self.found.benches is not None:
            self.near.add(self.found.benches)

    def separations(self, benches: tuple[int, int], travelled: list[float]) -> Separation:
        """Separations (T,) of two benches at distances (T,) of the head, m."""
        motion = self.march.motion(travelled, max(benches) + 2)
        outlines = as_vectors(self.march.dragon.outlines_between(motion.points))
        return separation(*(outlines[:, bench] for bench in benches))

    def gap(self, benches: tuple[int, int]) -> tuple[float, float]:
        """The smallest gap of two benches among near misses and both ends, and its distance, m."""
        ends = [0.0, self.length]
        gaps = self.separations(benches, ends).distance.tolist()
        found = list(zip(gaps, ends, strict=True))
        for miss in self.found.near_misses or ():
            if miss.benches == benches:
                found.append((miss.gap, miss.time))
        return min(found)


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
    turns : float
        Turn of the spiral from which the head starts, as in `March`.
    speed : float
        Speed of the head, m/s, as in `March`.
    radius : float
        Radius of the circle, m.
    progress : callable, optional
        Called with the part of the work that is done and the whole.

    Returns
    -------
    MinPitch
        The pitch is accurate to 1e-12 m, and certified to 1e-9 m.

    Raises
    ------
    ParameterError
        If the radius is less than the longest spacing (further in, a handle may have no position)
        or larger than any start, benches touch however far apart the turns are, or the dragon is
        too short to pass itself.
    DragonError
        If the limit cannot be certified.

    Examples
    --------
    >>> print(min_pitch(Dragon(benches=25)))  # doctest: +ELLIPSIS
    smallest pitch 0.450337393027 m: handle 0 reaches the circle of 4.5 m
               after 220.934 s
    limit:     benches 0 and 19 touch at t = 216.3382 s at (-0.3465, 4.8415) m
    ...
    """
    dragon = checked_dragon(dragon)
    function("progress", progress)
    turns = positive("turns", turns, _MAX_TURNS, "")
    speed = finite("speed", speed, MIN_SPEED, MAX_SPEED, "m/s")
    # Inside the longest spacing a handle may have no position, and beyond the largest start there
    # is no spiral.
    largest = min(_MAX_RADIUS, MAX_PITCH * turns)
    radius = finite("radius", radius, float(dragon.spacings.max()), largest, "m")
    # Turns are not closer than the width, and the start is not inside the circle.
    narrowest = max(float(dragon.widths.max()) * _MIN_PITCH_RATIO, radius / turns)

    def inward(pitch: float) -> _InwardMarch:
        return _InwardMarch(dragon, pitch, turns, radius)

    # Pitches from the widest one down to the first with a contact.
    pitches = _pitches(dragon, radius, narrowest)
    blocked = None
    clear: list[_InwardMarch] = []
    for done, pitch in enumerate(pitches, 1):
        march = inward(pitch + _CERTIFIED)
        progress(done, len(pitches) + 1)
        if not march.clear:
            blocked = march
            break
        clear.append(march)

    if not clear:
        long = "long enough for benches not to touch on the circle"
        raise ParameterError("body_spacing", dragon.body_spacing, long)
    if blocked is None and narrowest > radius / turns:
        short = "so many, and so long, that the dragon can run into itself outside the circle"
        raise ParameterError("benches", dragon.benches, short)

    # Without a contact the circle limits the pitch.
    limit = narrowest
    free = clear[-1]
    touching: dict[str, Any] = {}
    if blocked is not None:
        # Two marches above the limit, of which there may be only one so far, and one below.
        limit, free, blocked = _limit(inward, clear[-2:][0], free, blocked)
        benches = blocked.found.benches or (0, 0)
        distance = free.gap(benches)[1]
        x, y = free.separations(benches, [distance]).point[0].tolist()
        touching = {
            "benches": benches,
            "point": (x, y),
            "distance": distance,
            "contact_pitch": blocked.pitch,
        }

    progress(1, 1)
    spiral = Spiral(pitch=limit)
    return MinPitch(
        pitch=limit,
        radius=radius,
        march=March(dragon, spiral, turns=turns, speed=speed),
        arrival_distance=_length(spiral, turns, radius),
        clear_pitch=free.pitch,
        larger_pitches=tuple(march.pitch for march in clear),
        **touching,
    )


def _length(spiral: Spiral, turns: float, radius: float) -> float:
    """Length of a spiral from a turn to a circle about the centre, m."""
    # Rounding may give a negative length where the turn is on the circle.
    return max(0.0, spiral.at_radius(radius) - spiral.at_turn(turns))


def _pitches(dragon: Dragon, radius: float, narrowest: float) -> list[float]:
    """Pitches, m, from one at which turns are out of each other's reach down to the narrowest."""
    half = dragon.spacings / 2
    # How far benches with handles on the circle reach beyond it, and into it.
    middle = np.sqrt(radius**2 - half**2)
    beyond = np.hypot(half + dragon.overhangs, middle + dragon.widths / 2) - radius
    into = radius - middle + dragon.widths / 2
    widest = max(_PITCH_RATIO * narrowest, float(beyond.max() + into.max()))
    steps = math.ceil(math.log(widest / narrowest, _PITCH_RATIO))
    return [*np.geomspace(widest, narrowest, steps + 1).tolist()]


def _limit(
    inward: Callable[[float], _InwardMarch],
    wider: _InwardMarch,
    free: _InwardMarch,
    blocked: _InwardMarch,
) -> tuple[float, _InwardMarch, _InwardMarch]:
    """The pitch at which two benches touch, m, and marches just above and below it.

    `wider` and `free` are marches above the limit, and `blocked` is one below. The method is the
    secant method on the gap of the benches that touch first as the pitch falls, and bisection
    without such benches.
    """
    for _ in range(_MAX_STEPS):
        zeros = [_zero(wider, free, benches) for benches in free.near | blocked.near]
        inside = [zero for zero in zeros if blocked.pitch < zero < free.pitch]
        # Bisection where no gap has a zero between both marches.
        pitch = max(inside, default=(blocked.pitch + free.pitch) / 2)
        if free.pitch - blocked.pitch < 3 * _CERTIFIED:
            return pitch, free, blocked

        # Marches ever closer above the limit, whose gaps are known, and at last one below it.
        offset = -_CERTIFIED
        if free.pitch - pitch > 2 * _CERTIFIED:
            offset = max(_CERTIFIED, _MARGIN * (free.pitch - pitch))
        march = inward(pitch + offset)
        if march.clear:
            wider = free
            free = march
        else:
            blocked = march
    raise DragonError(
        f"no limit of the pitch can be certified from {blocked.pitch:.9g} to {free.pitch:.9g} m"
    )


def _zero(wider: _InwardMarch, free: _InwardMarch, benches: tuple[int, int]) -> float:
    """The pitch at which a gap is zero, m, by its values at two pitches; nan if these are equal."""
    gap, _ = free.gap(benches)
    before, _ = wider.gap(benches)
    return free.pitch - gap * (wider.pitch - free.pitch) / (before - gap or math.nan)
