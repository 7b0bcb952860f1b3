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
from pymunk_dragon._checks import finite, function, positive
from pymunk_dragon._language import text
from pymunk_dragon.collision import Separation, first_contact, separation
from pymunk_dragon.errors import DragonError, ParameterError
from pymunk_dragon.model.curves import Spiral
from pymunk_dragon.model.curves.spiral import MAX_PITCH
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.speed import MAX_SPEED, MIN_SPEED
from pymunk_dragon.studies._study import Progress, Result, checked_dragon, labelled, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# m. Radius of the contest's turning circle, and the largest one: with a wider circle the inward
# spiral is kilometres long, and the search takes minutes.
RADIUS, _MAX_RADIUS = 4.5, 100.0
# Largest turn of the start: a spiral has at most a thousand turns.
_MAX_TURNS = 900.0
# m. Distance from the limit at which pitches are certified: a thousand times the error of the
# limit.
_CERTIFIED = 1e-9
# Least pitch over the width, which no march's pitch may equal; ratio of successive pitches from out
# of reach down.
_MIN_PITCH_RATIO, _PITCH_RATIO = 1 + 1e-6, 1.06
# Share of a step of the secant method by which it stays above the limit.
_MARGIN = 0.01
# Marches near the limit, at most: some seven suffice, and bisection alone takes 25.
_MAX_STEPS = 60


@dataclass(frozen=True, kw_only=True, repr=False)
class MinPitch(Result):
    """The smallest pitch at which handle 0 reaches the turning circle without a collision.

    Attributes
    ----------
    pitch, radius, march : float, float, March
        The smallest pitch and radius of the circle, m, and the march at that pitch.
    benches, point : tuple or None
        The two benches that touch, the smaller number first, and the contact point, m; None where
        the pitch is limited by the circle, on which the head starts.
    distance, arrival_distance : float
        Distances travelled by handle 0 at the contact, to some micrometres, and at the circle, m;
        `march.time` gives the times.
    clear_pitch, contact_pitch, larger_pitches : float, float or None, tuple of float
        Pitches, m, certified by `first_contact`: without a contact, with one, and larger ones
        without a contact.
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
            *labelled("", text("after {time:.3f} s").format(time=arrival)),
            *labelled(text("limit:"), limit),
            *labelled(text("certified:"), f"{certified}\n{larger}"),
        ]

    def _draw(self) -> Figure:
        """The head and the benches around it at the contact, or at the start on the circle."""
        from pymunk_dragon.drawing.figures import style

        title = text("At a pitch of {:.6f} m the head starts on the circle itself").format(
            self.pitch
        )
        if self.benches is not None:
            title = text("At a pitch of {:.6f} m benches {} and {} just touch").format(
                self.pitch, *self.benches
            )
        aim = text(
            "the smallest pitch at which handle 0 reaches the circle of {:g} m without a contact"
        )
        figure = style.slide(title, aim.format(self.radius))
        axes = style.panels(figure)
        states = self.march.at(self.march.time(self.distance))
        for bench, outline in enumerate(self.march.dragon.outlines(states.poses[0])):
            face = style.COLOURS.head if bench == 0 else style.SHARED
            axes.fill(*outline.T, fc=face, ec=style.QUIET, lw=0.8, gid=f"bench-{bench}")
        x, y = self.point or states.positions[0, 0].tolist()
        axes.plot(x, y, "o", mec=style.COLOURS.contact, mfc="none", mew=2.0, ms=16, gid="contact")
        half = 0.7 * float(self.march.dragon.lengths[0])
        axes.set(xlim=(x - 2 * half, x + 2 * half), ylim=(y - half, y + half), aspect="equal")
        axes.set(xlabel="x (m)", ylabel="y (m)")
        return figure


class _InwardMarch:
    """March at 1 m/s from a turn of a spiral inward to a circle, and its certified first contact before the circle."""

    def __init__(self, dragon: Dragon, pitch: float, turns: float, radius: float) -> None:
        self.pitch, spiral = pitch, Spiral(pitch=pitch)
        self.march = March(dragon, spiral, turns=turns)
        self.length = _length(spiral, turns, radius)
        self.found = first_contact(self.march, until=self.length)
        self.clear = self.found.status == "clear"
        touching = () if self.found.benches is None else (self.found.benches,)
        # Benches that touch or have a near miss.
        self.near = {*touching, *(miss.benches for miss in self.found.near_misses or ())}

    def separations(self, benches: tuple[int, int], travelled: list[float]) -> Separation:
        """Separations (T,) of two benches at distances (T,) of the head, m."""
        outlines = as_vectors(
            self.march.dragon.outlines_between(
                self.march.motion(travelled, max(benches) + 2).points
            )
        )
        return separation(*(outlines[:, bench] for bench in benches))

    def gap(self, benches: tuple[int, int]) -> tuple[float, float]:
        """The smallest gap of two benches among near misses and both ends, m, and the head's distance there, m."""
        ends = [0.0, self.length]
        misses = [
            (miss.gap, miss.time)
            for miss in self.found.near_misses or ()
            if miss.benches == benches
        ]
        return min(
            *misses, *zip(self.separations(benches, ends).distance.tolist(), ends, strict=True)
        )


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
    radius = finite(
        "radius", radius, float(dragon.spacings.max()), min(_MAX_RADIUS, MAX_PITCH * turns), "m"
    )
    # Turns are not closer than the width, and the start is not inside the circle.
    narrowest = max(float(dragon.widths.max()) * _MIN_PITCH_RATIO, radius / turns)

    def inward(pitch: float) -> _InwardMarch:
        return _InwardMarch(dragon, pitch, turns, radius)

    pitches, blocked = _pitches(dragon, radius, narrowest), None
    clear: list[_InwardMarch] = []
    for done, pitch in enumerate(pitches, 1):
        march = inward(pitch + _CERTIFIED)
        progress(done, len(pitches) + 1)
        if not march.clear:
            blocked = march
            break
        clear.append(march)
    if not clear:
        raise ParameterError(
            "body_spacing",
            dragon.body_spacing,
            "long enough for benches not to touch on the circle",
        )
    if blocked is None and narrowest > radius / turns:
        short = "so many, and so long, that the dragon can run into itself outside the circle"
        raise ParameterError("benches", dragon.benches, short)
    limit, free = narrowest, clear[-1]
    touching: dict[str, Any] = {}
    if blocked is not None:
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
    """Pitches in m from one at which turns are out of each other's reach down to the narrowest one."""
    half = dragon.spacings / 2
    # How far benches with handles on the circle reach beyond it, and into it.
    middle = np.sqrt(radius**2 - half**2)
    beyond = np.hypot(half + dragon.overhangs, middle + dragon.widths / 2) - radius
    into = radius - middle + dragon.widths / 2
    widest = max(_PITCH_RATIO * narrowest, float(beyond.max() + into.max()))
    count = math.ceil(math.log(widest / narrowest) / math.log(_PITCH_RATIO)) + 1
    return [*np.geomspace(widest, narrowest, count).tolist()]


def _limit(
    inward: Callable[[float], _InwardMarch],
    wider: _InwardMarch,
    free: _InwardMarch,
    blocked: _InwardMarch,
) -> tuple[float, _InwardMarch, _InwardMarch]:
    """The pitch at which two benches touch, m, and marches just above and below it, from two above and one below.

    The secant method on the gap of the benches that touch first as the pitch falls, and bisection
    without such benches.
    """
    for _ in range(_MAX_STEPS):
        zeros = (_zero(wider, free, benches) for benches in {*free.near, *blocked.near})
        middle = (blocked.pitch + free.pitch) / 2
        pitch = max((zero for zero in zeros if blocked.pitch < zero < free.pitch), default=middle)
        if free.pitch - blocked.pitch < 3 * _CERTIFIED:
            return pitch, free, blocked
        # Marches ever closer above the limit, whose gaps are known, and at last one below it.
        above = max(_CERTIFIED, _MARGIN * (free.pitch - pitch))
        march = inward(pitch + (above if free.pitch - pitch > 2 * _CERTIFIED else -_CERTIFIED))
        if march.clear:
            wider, free = free, march
        else:
            blocked = march
    raise DragonError(
        f"no limit of the pitch can be certified from {blocked.pitch:.9g} to {free.pitch:.9g} m"
    )


def _zero(wider: _InwardMarch, free: _InwardMarch, benches: tuple[int, int]) -> float:
    """The pitch at which the gap of two benches is zero, m, by its values at two pitches; nan if these are equal."""
    gap, before = free.gap(benches)[0], wider.gap(benches)[0]
    return free.pitch - gap * (wider.pitch - free.pitch) / (before - gap or math.nan)
