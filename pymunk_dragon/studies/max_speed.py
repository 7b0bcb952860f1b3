"""The largest speed of the head in the turn at which no handle exceeds a speed limit.

This is the contest's question 5.

The speed of each handle is proportional to the head's, so the largest speed is the limit over the
largest ratio of a handle's speed to the head's. The ratio depends only on the distance travelled by
the head, and its maximum is enclosed by branch and bound. Over an interval the ratio is at most its
value at the midpoint plus half the interval's length times a bound on its derivative, from interval
arithmetic on the equations of a rigid bench in `model/chain.py`. Intervals whose bound is below the
largest value found are discarded, the others are halved.

Three facts limit the search:

- On the inward spiral no handle is faster than the one before it: at the end of a spiral's arc with
  the larger curvature, the angle to the chord is larger (W. Vogt, "Über monotongekrümmte Kurven",
  1914).
- On the outward spiral each handle is faster than the one before it, but all of them together by no
  more than a bound that depends only on the curvature kappa at the exit. The angle to a chord lies
  between those on the circles with the largest and the smallest curvature of the arc (A. Schur,
  1921), so both cosines of a bench lie between c(L, kappa at its front hole) and c(L, kappa at its
  rear hole), where c(L, k) = sqrt(1 - (k L / 2)^2). At a hole between benches of the spacings L and
  M the product has the factor cos alpha / cos beta, which is at most max(1, c(M, kappa) / c(L,
  kappa)). The remaining factor is at most 1 / c(L, kappa) of the last bench.
- Benches but the head are alike, so once the head has left the turn, the motion in the turn is
  periodic with the period of one bench.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array, as_vectors
from pymunk_dragon._checks import finite, function, silent
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model import chain
from pymunk_dragon.model.curves import Composite, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.speed import MAX_SPEED, MIN_SPEED
from pymunk_dragon.studies._study import Progress, Result, checked_dragon, labelled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Length of the initial intervals, in spacings.
_INTERVAL = 1 / 16
# m of the head's distance: shorter intervals are not halved, because of rounding.
_MIN_INTERVAL = 1e-12
# Initial intervals times benches up to which a whole dragon is followed through the turn: some
# seconds of work.
_WORK = 100_000
# Relative width of the enclosure: the search takes longer below it.
_RELATIVE_TOLERANCE = 1e-11
# Relative difference up to which the speeds of two handles count as equal: several widths of the
# enclosure.
_EQUAL = 1e-10
# Relative bound on the rounding error of a ratio of given angles.
_ROUNDING = 1e-13
# Last digits of the largest coordinate by which the equation of a bench is off, besides what is
# measured.
_ROUNDED = 2
# rad.
_RIGHT_ANGLE = np.pi / 2
# Least cosine in a quotient: a smaller one belongs to an angle that may reach a right angle.
_MIN_COSINE = 1e-12
# m that the head travels in the figure before the limit is reached.
_BEFORE = 9.0
# m that the head travels in the figure after that.
_AFTER = 12.0
# Samples of the speeds in the figure.
_SAMPLES = 1600
# Foremost handles in the figure; more if the fastest one is behind them.
_DRAWN_HANDLES = 12


@dataclass(frozen=True, kw_only=True, repr=False)
class MaxSpeed(Result):
    """The largest speed of the head for a speed limit of all handles.

    Attributes
    ----------
    speed : float
        Largest speed of the head, m/s: `limit` over `ratio`.
    limit : float
        Speed that no handle may exceed, m/s.
    ratio : float
        Largest ratio of a handle's speed to the head's.
    excess : float
        Relative amount by which the true ratio may be larger.
    handles : tuple of int
        All handles with that speed; `handle` is the foremost one.
    time : float
        Time from the entry of the circle to the maximum, s.
    distance : float
        Distance travelled by the head from the entry of the circle to the maximum, m.
    curve : UTurn
        The path.
    dragon : Dragon
        The dragon.
    """

    speed: float
    limit: float
    ratio: float
    excess: float
    handles: tuple[int, ...]
    time: float
    distance: float
    curve: UTurn
    dragon: Dragon

    @property
    def handle(self) -> int:
        """The foremost of the fastest handles."""
        return self.handles[0]

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study max-speed --json` prints them."""
        names = ("speed", "handle", "time", "limit", "ratio", "excess", "handles", "distance")
        return {name: getattr(self, name) for name in names}

    def _lines(self) -> list[str]:
        subject = text("handle {first} goes")
        if len(self.handles) > 1:
            subject = text("handles {first} to {last} go")
        subject = subject.format(first=self.handles[0], last=self.handles[-1])

        first = text("largest speed of the head {speed:.10f} m/s: no handle exceeds {limit:g} m/s")
        limit = text(
            "{subject} {ratio:.10f} times as fast as the head\n"
            "{time:.4f} s after it entered the circle, {distance:.4f} m into it"
        )
        limit = limit.format(
            subject=subject, ratio=self.ratio, time=self.time, distance=self.distance
        )
        excess = text("no handle exceeds that by more than {excess:.2g} of it")
        return [
            first.format(speed=self.speed, limit=self.limit),
            labelled(text("limit:"), limit),
            labelled(text("certified:"), excess.format(excess=self.excess)),
        ]

    def _draw(self) -> Figure:
        """Speeds of the foremost handles over time."""
        from pymunk_dragon.drawing.figures import style

        title = text("At {:.6f} m/s of the head no handle exceeds {:g} m/s")
        aim = text("speeds of the foremost handles, m/s")
        figure, axes = style.slide(title.format(self.speed, self.limit), aim)

        # The samples include the maximum itself.
        offsets = np.unique([*np.linspace(-_BEFORE, _AFTER, _SAMPLES), 0.0])
        distances = self.distance + offsets
        handles = min(max(_DRAWN_HANDLES, self.handle + 1), self.dragon.handles)
        states = March(self.dragon, self.curve).at(distances, handles)
        speeds = self.speed * states.speeds
        times = distances / self.speed
        axes.plot(times, speeds, color=style.PALE, lw=0.9)

        name = text("handle {}", self.handle)
        fastest = speeds[:, self.handle]
        axes.plot(times, fastest, color=style.BLUE, lw=2.2, gid="fastest", label=name)
        note = text("{:g} m/s at {:.3f} s", self.limit, self.time)
        (mark,) = axes.plot(self.time, self.limit, "o", gid="limit", label=note)
        mark.set(color=style.COLOURS.contact, markersize=7, zorder=4)

        axes.set(xlabel=text("time since the head entered the circle (s)"))
        axes.set(xlim=(times[0], times[-1]))
        axes.legend(loc="upper right", frameon=False)
        return figure


def max_speed(
    dragon: Dragon | None = None,
    *,
    limit: float = 2.0,
    pitch: float = 1.7,
    radius: float = 4.5,
    ratio: float = 2.0,
    progress: Progress = silent,
) -> MaxSpeed:
    """The largest constant speed of the head at which no handle exceeds a limit in the U-turn.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's. Its benches but the head must be alike.
    limit : float
        Speed that no handle may exceed, m/s.
    pitch : float
        Radial distance between turns of the spirals, m, as in `UTurn`.
    radius : float
        Radius of the circle, m, as in `UTurn`.
    ratio : float
        Ratio of the radii of the arcs, as in `UTurn`.
    progress : callable, optional
        Called with the work that is done and the whole.

    Returns
    -------
    MaxSpeed
        The relative error of the speed is at most `excess`: the largest ratio is enclosed for all
        times and handles. `excess` is 1e-11, or more where ratios magnify rounding: 8e-4 for the
        contest's dragon in a circle of 4.27 m, which is hardly large enough. It is also more on a
        turn whose curvature is no larger than that of the outward spiral, and for a dragon of more
        than some 80 benches whose last ones may be the fastest, because the head bench is hardly
        longer than the others. There it is at most 1 / sqrt(1 - (kappa L / 2)^2) - 1 for benches of
        the spacing L, where kappa is the curvature of the path at the exit: 0.018 for the contest's
        spacing and circle.

    Raises
    ------
    ParameterError
        If a number is out of range, the benches behind the head differ, or the circle is so small
        that the dragon has no initial position or a bench is pushed back.
    UnreachableError
        If the dragon does not fit round the turn.

    Examples
    --------
    >>> found = max_speed(limit=2.0)
    >>> print(f"{found.speed:.6f} m/s, handle {found.handle}")
    1.246266 m/s, handle 3
    """
    dragon = checked_dragon(dragon)
    function("progress", progress)
    limit = finite("limit", limit, MIN_SPEED, MAX_SPEED, "m/s")
    if not dragon.has_equal_benches:
        raise ParameterError("dragon", dragon, "one whose benches but the head are alike")
    curve = UTurn(pitch=pitch, radius=radius, ratio=ratio)

    search, excess = largest_ratio(dragon, curve, curve.radius)
    progress(1, 1)
    speeds = search.march.at(search.travelled, search.handles).speeds[0]
    fastest = np.flatnonzero(speeds > search.ratio * (1 - _EQUAL))
    return MaxSpeed(
        speed=limit / search.ratio,
        limit=limit,
        ratio=search.ratio,
        excess=excess,
        handles=tuple(fastest.tolist()),
        time=search.travelled * search.ratio / limit,
        distance=search.travelled,
        curve=curve,
        dragon=dragon,
    )


def largest_ratio(dragon: Dragon, curve: Composite, radius: float) -> tuple[_Search, float]:
    """The search for the largest ratio of a handle's speed to the head's, and its excess.

    The excess is the relative amount by which the true ratio may be larger than the one found.

    The dragon's benches but the head are alike, and the path is a turn on arcs between the spirals
    of a `UTurn` with this radius, m. Raises `ParameterError` if the dragon has no position with its
    head at the entry of the circle, or if a bench becomes perpendicular to the path at its front
    handle, where its rear handle begins to move back; and `UnreachableError` if the dragon does not
    fit round the turn.
    """
    search = _Search(dragon, curve, radius)
    bound = _searched(search)
    return search, max(_RELATIVE_TOLERANCE, bound / search.ratio - 1, search.rounding())


def _searched(search: _Search) -> float:
    """Search for the largest ratio; a bound on all ratios that the search does not enclose."""
    dragon = search.march.dragon
    curve = search.curve
    head = float(dragon.spacings[0])
    body = float(dragon.spacings[-1])
    whole = float(dragon.spacings.sum())
    # The bound on the ratios of the outward spiral.
    outward = curve.pieces[-1]
    sines = outward.curvature(outward.begin_s) * dragon.spacings / 2
    cosines = np.sqrt(1 - sines**2)
    gains = np.maximum(1.0, cosines[1:] / cosines[:-1])
    gain = float(np.prod(gains) / cosines[-1])

    first = search.exit_distance(1, head)
    search.run(0.0, first)
    # The head has left the turn, so the benches behind it move as a chain of equal benches:
    # periodically.
    equal = replace(dragon, head_spacing=body)
    lower = search.ratio / gain
    followers = _Search(equal, curve, search.radius, start_s=curve.joints[-1], lower=lower)
    followers.run(0.0, followers.exit_distance(1, body))
    if followers.ratio == lower:
        # No handle behind the head bench is faster.
        return gain

    if whole / (_INTERVAL * body) * dragon.benches > _WORK:
        # A period of the followers behind one bench on the outward spiral; behind more they gain
        # little.
        search.run(first, search.exit_distance(2, head + body))
        return followers.ratio * gain
    search.run(first, search.exit_distance(dragon.benches, whole))
    return gain


def _too_narrow(radius: float) -> ParameterError:
    forward = "large enough for the dragon to go round with every hole moving forward at all times"
    return ParameterError("radius", radius, forward)


class _Search:
    """Branch and bound for the largest ratio of a march at 1 m/s above a lower bound.

    `ratio` is the largest one found, after the head has `travelled` a distance, m, among the first
    `handles`.
    """

    def __init__(
        self,
        dragon: Dragon,
        curve: Composite,
        radius: float,
        *,
        start_s: float = 0.0,
        lower: float = 1.0,
    ) -> None:
        self.curve = curve
        self.radius = radius
        self.ratio = lower
        self.travelled = 0.0
        self.handles = 1
        self._spacings = dragon.spacings
        try:
            self.march = March(dragon, curve, start_s=start_s)
        except ParameterError as error:
            raise _too_narrow(radius) from error

    def exit_distance(self, handle: int, step: float) -> float:
        """Distance of the head, m, at which `handle` has passed the turn's exit by up to `step`.

        Raises `ParameterError` if the handle is pushed back.
        """
        exit_s = self.curve.joints[-1]
        travelled = exit_s - self.march.head_start + step
        s = -np.inf
        while True:
            before = s
            s = float(self.march.handles_s(travelled, handle + 1)[0, -1])
            if s >= exit_s:
                return travelled
            if s <= before:
                raise _too_narrow(self.radius)
            travelled += step / 8

    def run(self, begin: float, end: float) -> None:
        """Enclose the largest ratio while the head travels from `begin` to `end`, m."""
        longest = _INTERVAL * self._spacings.min()
        edges = np.linspace(begin, end, int(np.ceil((end - begin) / longest)) + 1)
        middles = (edges[:-1] + edges[1:]) / 2
        halves = np.diff(edges) / 2
        # The handles further back are on the inward spiral, and no faster than the last of these
        # handles.
        ahead = int(np.count_nonzero(self.march.handles_s(end)[0] > 0))
        handles = min(max(2, ahead + 1), self.march.dragon.handles)

        at_edges = self.march.handles_s(edges, handles)
        first = at_edges[:-1]
        last = at_edges[1:]
        middle = self.march.handles_s(middles, handles)
        while middles.size:
            ratios, bounds = self._ratios(first, middle, last)
            largest = ratios.max(axis=1)
            best = int(largest.argmax())
            if largest[best] > self.ratio:
                self.ratio = float(largest[best])
                self.travelled = float(middles[best])
                self.handles = ratios.shape[1] + 1

            # Intervals in which the ratio may still be larger.
            may_exceed = bounds > self.ratio * (1 + _RELATIVE_TOLERANCE)
            left = np.flatnonzero(may_exceed.any(axis=1))
            if not left.size or 2 * halves.max() < _MIN_INTERVAL:
                break
            # Handles up to the last one that may still be faster.
            faster = np.flatnonzero((bounds[left] > self.ratio).any(axis=0))
            handles = int(faster[-1]) + 2

            # Both halves of these intervals.
            first, middle, last = (part[left, :handles] for part in (first, middle, last))
            halves = np.tile(halves[left] / 2, 2)
            sides = np.repeat([-1, 1], left.size)
            middles = np.tile(middles[left], 2) + sides * halves
            first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
            middle = self.march.handles_s(middles, handles)

    def rounding(self) -> float:
        """Relative rounding error of the largest ratio.

        It is that of the coordinates of the handles, which ratios magnify. An error of a coordinate
        changes the cosines of both benches there; `collision/bounds.py` has the equations.
        """
        motion = self.march.motion(self.travelled, self.handles)
        s, points, tangents, ratios = (part[0] for part in motion)
        spacings = self._spacings[: self.handles - 1]
        angles = chain.angles(as_vectors(points), as_vectors(tangents), spacings)
        front, rear = (angle.real for angle in angles)

        largest = np.abs([self.march.head_start, s[-1], *self.curve.inner_ends]).max()
        measured = np.abs(np.abs(np.diff(points)) - spacings).max()
        residual = measured + _ROUNDED * np.spacing(largest)
        errors = ratios * residual
        errors[1:] += ratios[1:] * np.cumsum(residual / (rear * ratios[1:]))

        curvatures = np.abs(self.curve.curvature(s))
        rates = 2 / spacings + np.maximum(curvatures[:-1], curvatures[1:])
        changes = rates * np.maximum(errors[:-1], errors[1:])
        return float(np.sum(changes / front + changes / rear))

    def _ratios(self, first: Array, middle: Array, last: Array) -> tuple[Array, Array]:
        """Ratios (K, H - 1) of handles 1 to H - 1 at midpoints, and bounds on the intervals.

        `first`, `middle` and `last` (K, H) are coordinates of the handles at the beginning,
        midpoint and end of the intervals.
        """
        spacings = self._spacings[: first.shape[1] - 1]
        angles = np.angle(chain.angles(*self.curve.frame(middle), spacings))
        if np.any(np.abs(angles[0]) >= _RIGHT_ANGLE):
            raise _too_narrow(self.radius)

        # While both holes move forward, they remain between their coordinates at the ends of the
        # interval. No bench rotates by more than the sum of the two distances, over its spacing.
        moved = np.maximum(middle - first, last - middle)
        swept = moved * self.curve.max_curvature(first, last)
        rotated = (moved[:, :-1] + moved[:, 1:]) / spacings
        change = np.stack([swept[:, :-1], swept[:, 1:]]) + rotated
        fronts, rears = np.stack([angles - change, angles + change], axis=1)
        curvatures = self._curvatures(first, last)

        # The derivative of a ratio's logarithm is the sum over the benches ahead.
        with np.errstate(over="ignore", invalid="ignore"):
            velocity_ratios, slopes = _velocity_ratio(fronts, rears, curvatures, spacings)
            ahead = chain.velocity_ratios(velocity_ratios[..., :-1], np.ones(1))
            slope = np.cumsum(_product(ahead, slopes), axis=-1)
            steepest = np.abs(slope).max(axis=0)
            ratios = chain.velocity_ratios(*np.cos(angles))[:, 1:]
            bounds = ratios * np.exp(steepest * moved[:, :1]) * (1 + _ROUNDING)

        # Where an angle may reach a right angle, there is no bound for this handle and the handles
        # behind it.
        largest = (np.abs(angles) + change).max(axis=0)
        known = np.logical_and.accumulate(largest < _RIGHT_ANGLE, axis=1)
        return ratios, np.where(known & np.isfinite(bounds), bounds, np.inf)

    def _curvatures(self, first: Array, last: Array) -> Array:
        """Least and largest signed curvature (2, K, H) of the path between coordinates.

        The curvature of an arc is constant, and that of a spiral is monotonic.
        """
        found = np.sort([self.curve.curvature(first), self.curve.curvature(last)], axis=0)
        low, high = found
        pieces = pairwise(self.curve.pieces)
        for joint, (before, after) in zip(self.curve.joints, pieces, strict=True):
            here = (first <= joint + _MIN_INTERVAL) & (last >= joint - _MIN_INTERVAL)
            ends = [before.curvature(before.end_s), after.curvature(after.begin_s)]
            np.minimum(low, min(ends), out=low, where=here)
            np.maximum(high, max(ends), out=high, where=here)
        return found


# Interval arithmetic on arrays (2, ...) of lower and upper bounds.


def _velocity_ratio(
    fronts: Array, rears: Array, curvatures: Array, spacings: Array
) -> tuple[Array, Array]:
    """Velocity ratio rho of benches, and its logarithm's derivative by the front coordinate.

    `fronts` and `rears` are angles at the handles of each bench, and `curvatures` are those at all
    handles.
    """
    cosines = _cosine(fronts)
    front_sines = np.sin(fronts)
    rear_sines = np.sin(rears)
    ratio = _quotient(cosines, _cosine(rears))
    rate = front_sines - _product(ratio, rear_sines)[::-1]
    # A square is not negative.
    square = np.maximum(_product(rate, rate), 0.0) / spacings
    rear = _product(_product(ratio, ratio), _product(curvatures[..., 1:], rear_sines))
    front = _product(curvatures[..., :-1], front_sines)
    return ratio, _quotient(rear - front[::-1] + square, cosines)


def _cosine(angles: Array) -> Array:
    """Cosines of angles up to a right angle, above 0."""
    # At a right angle the cosine is zero. Results for such angles are discarded.
    low, high = np.maximum(np.sort(np.cos(angles), axis=0), _MIN_COSINE)
    return np.stack([low, np.where(angles[0] * angles[1] <= 0, 1.0, high)])


def _product(one: Array, other: Array) -> Array:
    """Product of intervals."""
    ends = one[:, None] * other
    return np.stack([ends.min(axis=(0, 1)), ends.max(axis=(0, 1))])


def _quotient(one: Array, other: Array) -> Array:
    """Quotient by an interval above 0."""
    return _product(one, 1 / other[::-1])
