"""The largest speed of the head at which no handle exceeds a speed limit in the turn (the contest's question 5).

The speed of each handle is proportional to the head's, so the largest speed is the limit over the largest ratio of a
handle's speed to the head's, which `_speed_ratio.py` encloses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._checks import finite
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.speed import MAX_SPEED, MIN_SPEED
from pymunk_dragon.studies._speed_ratio import SpeedRatio, largest_ratio
from pymunk_dragon.studies._study import Option, Progress, Result, Study, labelled, silent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Of the figure: m of head travel before and after the time of the limit, and samples in between.
DISTANCES, SAMPLES = (-9.0, 12.0), 1600
# Of the figure: foremost handles whose speeds are drawn, and those whose largest speed is, all that are in the turn.
_DRAWN_HANDLES, _EVALUATED_HANDLES = 12, 28
# Of the figure: half the width of the plan view, in radii of the circle.
BORDER = 1.16


@dataclass(frozen=True, kw_only=True, repr=False)
class MaxSpeed(Result, SpeedRatio):
    """The largest speed of the head for a speed limit of all handles, and the speed ratio that it follows from.

    Attributes
    ----------
    speed, limit : float
        Largest speed of the head, and speed that no handle may exceed, m/s; `speed` is `limit` over `ratio`.
    time : float
        Time from the entry of the circle to the maximum, s; the other attributes are those of `SpeedRatio`.
    speeds : tuple of float
        Speeds of the foremost handles at the maximum, m/s.
    curve, dragon : UTurn, Dragon
        The path and the dragon.

    Examples
    --------
    >>> max_speed(limit=1.0)
    <MaxSpeed: largest speed of the head 0.6231331791 m/s: no handle exceeds 1 m/s>
    """

    speed: float
    limit: float
    time: float
    speeds: tuple[float, ...]
    curve: UTurn
    dragon: Dragon

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study max-speed --json` prints them."""
        names = ("speed", "handle", "time", "limit", "ratio", "excess", "handles", "distance", "speeds", "evaluations")
        return {name: getattr(self, name) for name in names}

    def _lines(self) -> list[str]:
        first, last = self.handles[0], self.handles[-1]
        if first == last:
            subject = text("handle {first} goes").format(first=first)
        else:
            subject = text("handles {first} to {last} go").format(first=first, last=last)
        limit = text(
            "{subject} {ratio:.10f} times as fast as the head\n"
            "{time:.4f} s after it entered the circle, {distance:.4f} m into it"
        ).format(subject=subject, ratio=self.ratio, time=self.time, distance=self.distance)
        speeds = " ".join(f"{speed:.3f}" for speed in self.speeds)
        excess = text("no handle exceeds that by more than {excess:.2g} of it ({count} evaluations)")
        return [
            text("largest speed of the head {speed:.10f} m/s: no handle exceeds {limit:g} m/s").format(
                speed=self.speed, limit=self.limit
            ),
            *labelled(text("limit:"), limit),
            *labelled(text("then:"), text("handles 0, 1, 2, ... go\n{speeds} m/s").format(speeds=speeds)),
            *labelled(text("certified:"), excess.format(excess=self.excess, count=self.evaluations)),
        ]

    def _draw(self) -> Figure:
        """Speeds of the handles over time, and positions at the time of the limit."""
        from pymunk_dragon.studies._figures import panels

        title = text("At {:.6f} m/s of the head, handles {} to {} are at the limit of {:g} m/s once")
        if self.handles[0] == self.handles[-1]:
            title = text("At {:.6f} m/s of the head, handle {} is at the limit of {:g} m/s once")
        ends = sorted({self.handles[0], self.handles[-1]})
        note = text("head {:.2f} m into the circle, {:.2f} s after it entered; no handle is faster at any time")
        note = note.format(self.distance, self.time)
        figure, axes = panels(title.format(self.speed, *ends, self.limit), note, [["speeds", "positions"]])
        _draw_speeds(axes["speeds"], self)
        _draw_positions(axes["positions"], self)
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
        The relative error of the speed is at most `excess`: the largest ratio is enclosed for all times and handles.
        `excess` is 1e-11 except on a turn whose curvature is no larger than that of the outward spiral, and for a
        dragon of more than some 80 benches whose last ones may be the fastest, because the head bench is hardly
        longer than the others. There it is at most 1 / sqrt(1 - (kappa L / 2)^2) - 1 for benches of the spacing L,
        where kappa is the curvature of the path at the exit: 0.018 for the contest's spacing and circle.

    Raises
    ------
    ParameterError
        If a number is out of range, the benches behind the head differ, or the circle is so small that the dragon
        has no initial position or a bench is pushed back.
    UnreachableError
        If the dragon does not fit round the turn.

    Examples
    --------
    >>> found = max_speed(limit=2.0)
    >>> print(f"{found.speed:.6f} m/s, handle {found.handle}")
    1.246266 m/s, handle 3
    """
    dragon = dragon or Dragon()
    limit = finite("limit", limit, MIN_SPEED, MAX_SPEED, "m/s")
    if not dragon.alike:
        raise ParameterError("dragon", dragon, "one whose benches but the head are alike")
    curve = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    try:
        march = March(dragon, curve)
        found = largest_ratio(dragon, curve)
    except ParameterError as error:
        if error.name not in ("start_s", "curve"):
            raise
        forward = "large enough for the dragon to go round with every hole moving forward at all times"
        raise ParameterError("radius", radius, forward) from error
    progress(1, 1)
    speed = limit / found.ratio
    speeds = speed * march.at(found.distance, min(found.handles[-1] + 3, dragon.handles)).speeds[0]
    return MaxSpeed(
        speed=speed,
        limit=limit,
        time=found.distance / speed,
        speeds=tuple(speeds.tolist()),
        curve=curve,
        dragon=dragon,
        **vars(found),
    )


def _draw_speeds(axes: Axes, found: MaxSpeed) -> None:
    """Draw the speeds of the foremost handles, and the largest speed, over time."""
    from pymunk_dragon.drawing.figures.style import BLUE, COLOURS, PALE
    from pymunk_dragon.studies._figures import heading

    heading(axes, text("speeds of handles, m/s; blue: the fastest"))
    distances = found.distance + np.unique([*np.linspace(*DISTANCES, SAMPLES), 0.0])
    handles = min(_EVALUATED_HANDLES, found.dragon.handles)
    speeds = found.speed * March(found.dragon, found.curve).at(distances, handles).speeds
    times = distances / found.speed
    axes.plot(times, speeds[:, 1:_DRAWN_HANDLES], color=PALE, lw=0.9)
    axes.plot(times, speeds.max(axis=1), color=BLUE, lw=2.2, gid="fastest")
    axes.axhline(found.limit, color=COLOURS.contact, lw=1.2, ls=(0, (4, 3)))
    note = text("{:g} m/s at {:.3f} s").format(found.limit, found.time)
    axes.plot(found.time, found.limit, "o", color=COLOURS.contact, ms=7, zorder=4, gid="limit", label=note)
    axes.set_xlim(times[0], times[-1])
    axes.margins(y=0.2)
    axes.legend(loc="upper right", frameon=False, borderpad=0.0)
    axes.set_xlabel(text("time since the head entered the circle (s)"))


def _draw_positions(axes: Axes, found: MaxSpeed) -> None:
    """Draw the benches in the turn at the time of the limit."""
    from pymunk_dragon.drawing.figures.style import COLOURS, PALE
    from pymunk_dragon.studies._figures import POINTS, heading, plan_view

    heading(axes, text("red: handles at the limit"))
    curve, march, half = found.curve, March(found.dragon, found.curve), BORDER * found.curve.radius
    plan_view(axes, march, found.distance, curve.radius, half)
    path = curve.point(np.linspace(-half, curve.joints[-1] + half, POINTS))
    axes.plot(*path.T, color=PALE, lw=1.2, gid="path", zorder=1)
    positions = march.at(found.distance).positions[0]
    axes.plot(*positions.T, "o", color=COLOURS.ink, ms=4, zorder=4)
    axes.plot(*positions[list(found.handles)].T, "o", color=COLOURS.contact, ms=6, zorder=5, gid="fastest-handles")


STUDY = Study(
    name="max-speed",
    summary="largest speed of the head in the U-turn (question 5)",
    run=max_speed,
    options={"limit": Option(kind=float, metavar="M/S", text="no handle shall be faster, m/s.  [2]")},
)
