"""The largest speed of the head at which no handle exceeds a speed limit in the turn (the contest's question 5).

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
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array, as_vectors
from pymunk_dragon._checks import finite, function
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model import chain
from pymunk_dragon.model.curves import Composite, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.speed import MAX_SPEED, MIN_SPEED
from pymunk_dragon.studies._study import Progress, Result, checked_dragon, labelled, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Length of the initial intervals in spacings, and m of the head's distance below which they are not
# halved: rounding.
_INTERVAL, _MIN_INTERVAL = 1 / 16, 1e-12
# Initial intervals times benches up to which a whole dragon is followed through the turn: some
# seconds of work.
_WORK = 100_000
# Relative width of the enclosure: the search takes longer below it. Relative difference up to which
# the speeds of two handles count as equal, several of these widths; and relative bound on the
# rounding error of a ratio of given angles.
_RELATIVE_TOLERANCE, _EQUAL, ROUNDING = 1e-11, 1e-10, 1e-13
# Last digits of the largest coordinate by which the equation of a bench is off, besides what is
# measured.
_ROUNDED = 2
_RIGHT_ANGLE = np.pi / 2
# Least cosine in a quotient: a smaller one belongs to an angle that may reach a right angle.
_MIN_COSINE = 1e-12
# Of the figure: m that the head travels before and after the limit, samples in between, and
# foremost handles drawn.
_BEFORE, _AFTER, _SAMPLES, _DRAWN_HANDLES = 9.0, 12.0, 1600, 12


@dataclass(frozen=True, kw_only=True, repr=False)
class MaxSpeed(Result):
    """The largest speed of the head for a speed limit of all handles, and the speed ratio that it follows from.

    Attributes
    ----------
    speed, limit : float
        Largest speed of the head, and speed that no handle may exceed, m/s; `speed` is `limit` over
        `ratio`.
    ratio, excess : float
        Largest ratio of a handle's speed to the head's, and the relative amount by which the true
        one may be larger.
    handles : tuple of int
        All handles with that speed; `handle` is the foremost one.
    time, distance : float
        Time from the entry of the circle to the maximum, s, and distance travelled by the head
        until then, m.
    curve, dragon : UTurn, Dragon
        The path and the dragon.
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
        subject = (
            text("handle {first} goes")
            if len(self.handles) == 1
            else text("handles {first} to {last} go")
        )
        subject = subject.format(first=self.handles[0], last=self.handles[-1])
        limit = text(
            "{subject} {ratio:.10f} times as fast as the head\n"
            "{time:.4f} s after it entered the circle, {distance:.4f} m into it"
        ).format(subject=subject, ratio=self.ratio, time=self.time, distance=self.distance)
        first = text("largest speed of the head {speed:.10f} m/s: no handle exceeds {limit:g} m/s")
        excess = text("no handle exceeds that by more than {excess:.2g} of it").format(
            excess=self.excess
        )
        return [
            first.format(speed=self.speed, limit=self.limit),
            *labelled(text("limit:"), limit),
            *labelled(text("certified:"), excess),
        ]

    def _draw(self) -> Figure:
        """Speeds of the foremost handles over time."""
        from pymunk_dragon.drawing.figures import style

        title = text("At {:.6f} m/s of the head no handle exceeds {:g} m/s").format(
            self.speed, self.limit
        )
        figure = style.slide(title, text("speeds of the foremost handles, m/s"))
        axes = style.panels(figure)
        distances = self.distance + np.unique([*np.linspace(-_BEFORE, _AFTER, _SAMPLES), 0.0])
        handles = min(max(_DRAWN_HANDLES, self.handle + 1), self.dragon.handles)
        speeds = self.speed * March(self.dragon, self.curve).at(distances, handles).speeds
        times = distances / self.speed
        axes.plot(times, speeds, color=style.PALE, lw=0.9)
        name = text("handle {}").format(self.handle)
        axes.plot(
            times, speeds[:, self.handle], color=style.BLUE, lw=2.2, gid="fastest", label=name
        )
        note = text("{:g} m/s at {:.3f} s").format(self.limit, self.time)
        axes.plot(
            self.time,
            self.limit,
            "o",
            color=style.COLOURS.contact,
            ms=7,
            zorder=4,
            gid="limit",
            label=note,
        )
        axes.set(
            xlabel=text("time since the head entered the circle (s)"), xlim=(times[0], times[-1])
        )
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
    """The largest constant speed of the head at which no handle ever exceeds a limit on the path of the U-turn.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's. Its benches but the head must be alike.
    limit : float
        Speed that no handle may exceed, m/s.
    pitch, radius, ratio : float
        As in `UTurn`.
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
    found, excess = _largest_ratio(dragon, curve, curve.radius)
    progress(1, 1)
    speeds = found.march.at(found.travelled, found.handles).speeds[0]
    return MaxSpeed(
        speed=limit / found.ratio,
        limit=limit,
        ratio=found.ratio,
        excess=excess,
        handles=tuple(np.flatnonzero(speeds > found.ratio * (1 - _EQUAL)).tolist()),
        time=found.travelled * found.ratio / limit,
        distance=found.travelled,
        curve=curve,
        dragon=dragon,
    )


def certified_ratio(dragon: Dragon, curve: Composite, radius: float) -> tuple[float, float]:
    """Largest ratio of a handle's speed to the head's, and the relative amount by which the true one may be larger.

    The dragon's benches but the head are alike, and the path is a turn on arcs between the spirals
    of a `UTurn` with this radius, m. Raises `ParameterError` if the dragon has no position with its
    head at the entry of the circle, or if a bench becomes perpendicular to the path at its front
    handle, where its rear handle begins to move back; and `UnreachableError` if the dragon does not
    fit round the turn.
    """
    search, excess = _largest_ratio(dragon, curve, radius)
    return search.ratio, excess


def _largest_ratio(dragon: Dragon, curve: Composite, radius: float) -> tuple[_Search, float]:
    """The search for the ratio of `certified_ratio`, and its relative excess."""
    search, bound = _searched(dragon, curve, radius)
    return search, max(_RELATIVE_TOLERANCE, bound / search.ratio - 1, search.rounding())


def _searched(dragon: Dragon, curve: Composite, radius: float) -> tuple[_Search, float]:
    """Search for the largest ratio, and a bound on all ratios that are not enclosed by it."""
    search = _Search(dragon, curve, radius)
    head, body, whole = (
        float(dragon.spacings[0]),
        float(dragon.spacings[-1]),
        float(dragon.spacings.sum()),
    )
    outward = curve.pieces[-1]
    cosines = np.sqrt(1 - (outward.curvature(outward.begin_s) * dragon.spacings / 2) ** 2)
    gain = float(np.prod(np.maximum(1.0, cosines[1:] / cosines[:-1])) / cosines[-1])
    first = search.exit_distance(1, head)
    search.run(0.0, first)
    # The head has left the turn, so the benches behind it move as a chain of equal benches:
    # periodically.
    equal = replace(dragon, head_spacing=body)
    followers = _Search(equal, curve, radius, start_s=curve.joints[-1], lower=search.ratio / gain)
    followers.run(0.0, followers.exit_distance(1, body))
    if not followers.found:
        return search, gain
    if whole / (_INTERVAL * body) * dragon.benches > _WORK:
        # A period of the followers behind one bench on the outward spiral; behind more they gain
        # little.
        search.run(first, search.exit_distance(2, head + body))
        return search, followers.ratio * gain
    search.run(first, search.exit_distance(dragon.benches, whole))
    return search, gain


def _too_narrow(radius: float) -> ParameterError:
    forward = "large enough for the dragon to go round with every hole moving forward at all times"
    return ParameterError("radius", radius, forward)


class _Search:
    """Branch and bound for the largest ratio of a march at 1 m/s above a lower bound."""

    def __init__(
        self,
        dragon: Dragon,
        curve: Composite,
        radius: float,
        *,
        start_s: float = 0.0,
        lower: float = 1.0,
    ) -> None:
        self.curve, self.spacings = curve, dragon.spacings
        self._radius = radius
        try:
            self.march = March(dragon, curve, start_s=start_s)
        except ParameterError as error:
            raise _too_narrow(radius) from error
        self.ratio, self.found, self.travelled, self.handles = lower, False, 0.0, 1

    def exit_distance(self, handle: int, step: float) -> float:
        """Distance travelled by the head, m, at which `handle` has passed the exit of the turn by up to `step`.

        Raises `ParameterError` if the handle is pushed back.
        """
        exit_s = self.curve.joints[-1]
        travelled, s = exit_s - self.march.head_start + step, -np.inf
        while True:
            before, s = (
                s,
                float(self.march.handles_s(self.march.time(travelled), handle + 1)[0, -1]),
            )
            if s >= exit_s:
                return travelled
            if s <= before:
                raise _too_narrow(self._radius)
            travelled += step / 8

    def run(self, begin: float, end: float) -> None:
        """Enclose the largest ratio while the head travels from `begin` to `end`, m."""
        edges = np.linspace(
            begin, end, int(np.ceil((end - begin) / (_INTERVAL * self.spacings.min()))) + 1
        )
        # The handles further back are on the inward spiral, and no faster than the last of these
        # handles.
        ahead = int(np.count_nonzero(self.march.handles_s(self.march.time(end))[0] > 0))
        handles = min(max(2, ahead + 1), self.march.dragon.handles)
        middles, halves = (edges[:-1] + edges[1:]) / 2, np.diff(edges) / 2
        parts = [
            self.march.handles_s(travelled, handles)
            for travelled in (edges[:-1], middles, edges[1:])
        ]
        while middles.size:
            first, middle, last = parts
            ratios, most = self._ratios(first, middle, last)
            largest = ratios.max(axis=1)
            best = int(largest.argmax())
            if largest[best] > self.ratio:
                self.ratio, self.found, self.travelled = (
                    float(largest[best]),
                    True,
                    float(middles[best]),
                )
                self.handles = ratios.shape[1] + 1
            left = np.flatnonzero((most > self.ratio * (1 + _RELATIVE_TOLERANCE)).any(axis=1))
            if not left.size or 2 * halves.max() < _MIN_INTERVAL:
                break
            handles = int(np.flatnonzero((most[left] > self.ratio).any(axis=0))[-1]) + 2
            first, middle, last = (part[left, :handles] for part in parts)
            halves = np.tile(halves[left] / 2, 2)
            middles = np.tile(middles[left], 2) + np.repeat([-1, 1], left.size) * halves
            joined = np.concatenate([first, middle]), np.concatenate([middle, last])
            parts = [joined[0], self.march.handles_s(middles, handles), joined[1]]

    def rounding(self) -> float:
        """Relative rounding error of the largest ratio: that of the coordinates of the handles, which ratios magnify.

        An error of a coordinate changes the cosines of both benches there; `collision/bounds.py`
        has the equations.
        """
        s, points, tangents, ratios = (
            part[0] for part in self.march.motion(self.travelled, self.handles)
        )
        spacings = self.spacings[: self.handles - 1]
        front, rear = (
            turn.real for turn in chain.angles(as_vectors(points), as_vectors(tangents), spacings)
        )
        largest = np.abs([self.march.head_start, s[-1], *self.curve.inner_ends]).max()
        residual = np.abs(np.abs(np.diff(points)) - spacings).max() + _ROUNDED * np.spacing(largest)
        errors = ratios * residual
        errors[1:] += ratios[1:] * np.cumsum(residual / (rear * ratios[1:]))
        curvatures = np.abs(self.curve.curvature(s))
        changes = (2 / spacings + np.maximum(curvatures[:-1], curvatures[1:])) * np.maximum(
            errors[:-1], errors[1:]
        )
        return float(np.sum(changes / front + changes / rear))

    def _ratios(self, first: Array, middle: Array, last: Array) -> tuple[Array, Array]:
        """Ratios (K, H - 1) of the speeds of handles 1 to H - 1 to the head's, at midpoints, and bounds on intervals.

        `first`, `middle` and `last` (K, H) are coordinates of the handles at the beginning,
        midpoint and end of the intervals.
        """
        spacings = self.spacings[: first.shape[1] - 1]
        angles = np.angle(chain.angles(*self.curve.frame(middle), spacings))
        if np.any(np.abs(angles[0]) >= _RIGHT_ANGLE):
            raise _too_narrow(self._radius)
        # While both holes move forward, they remain between their coordinates at the ends of the
        # interval. No bench rotates by more than the sum of the two distances, over its spacing.
        moved = np.maximum(middle - first, last - middle)
        swept = moved * self.curve.max_curvature(first, last)
        change = np.stack([swept[:, :-1], swept[:, 1:]]) + (moved[:, :-1] + moved[:, 1:]) / spacings
        lows, highs = angles - change, angles + change
        fronts, rears = np.stack([lows, highs], axis=1)
        curvatures = self._curvatures(first, last)
        with np.errstate(over="ignore", invalid="ignore"):
            velocity_ratios, slopes = _velocity_ratio(
                fronts, rears, curvatures[..., :-1], curvatures[..., 1:], spacings
            )
            ahead = chain.velocity_ratios(velocity_ratios[..., :-1], np.ones(1))
            slope = np.abs(np.cumsum(_product(ahead, slopes), axis=-1)).max(axis=0)
            ratios = chain.velocity_ratios(*np.cos(angles))[:, 1:]
            most = ratios * np.exp(slope * moved[:, :1]) * (1 + ROUNDING)
        # Where an angle may reach a right angle, there is no bound for this handle and the handles
        # behind it.
        largest = np.maximum(-lows, highs).max(axis=0)
        known = np.logical_and.accumulate(largest < _RIGHT_ANGLE, axis=1)
        return ratios, np.where(known & np.isfinite(most), most, np.inf)

    def _curvatures(self, first: Array, last: Array) -> Array:
        """Least and largest signed curvature (2, K, H) of the path between coordinates.

        The curvature of an arc is constant, and that of a spiral is monotonic.
        """
        found = np.sort([self.curve.curvature(first), self.curve.curvature(last)], axis=0)
        for joint, before, after in zip(
            self.curve.joints, self.curve.pieces[:-1], self.curve.pieces[1:], strict=True
        ):
            here = (first <= joint + _MIN_INTERVAL) & (last >= joint - _MIN_INTERVAL)
            for end in (
                float(before.curvature(before.end_s)),
                float(after.curvature(after.begin_s)),
            ):
                found[0, here], found[1, here] = (
                    np.minimum(found[0, here], end),
                    np.maximum(found[1, here], end),
                )
        return found


# Interval arithmetic on arrays (2, ...) of lower and upper bounds.


def _velocity_ratio(
    fronts: Array, rears: Array, front_curvatures: Array, rear_curvatures: Array, spacings: Array
) -> tuple[Array, Array]:
    """Velocity ratio rho of benches, and the derivative of its logarithm by the front hole's coordinate."""
    cosines, front_sines, rear_sines = _cosine(fronts), np.sin(fronts), np.sin(rears)
    ratio = _quotient(cosines, _cosine(rears))
    rate = front_sines - _product(ratio, rear_sines)[::-1]
    # A square is not negative.
    square = np.maximum(_product(rate, rate), 0.0) / spacings
    rear = _product(_product(ratio, ratio), _product(rear_curvatures, rear_sines))
    return ratio, _quotient(rear - _product(front_curvatures, front_sines)[::-1] + square, cosines)


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
