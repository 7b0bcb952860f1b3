"""The turn of the contest's question 4, and the shortest turn that was found inside its circle.

Two arcs. Entry and exit are opposite to each other, 2 R apart, and their tangents are parallel, at an angle a to the
diameter between them. Any two arcs tangent to both and to each other turn by 2 a each. Their chords, 2 r sin a each,
lie on the diameter, one after the other, so (r1 + r2) sin a = R, and the length is 2 a (r1 + r2) = 2 a R / sin a. It
does not depend on the ratio of the radii.

More arcs allow shorter turns. The diameter, 2 R, is the only geometric limit, but the handles behind the head become
faster as the turn becomes shorter. So the search is for the shortest turn on five arcs on which no handle exceeds a
given multiple of the head's speed: by default the largest ratio on the contest's own turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite
from pymunk_dragon._extras import library
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.curves import Composite, UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._shortest import MIN_RADIUS, shortest_turn
from pymunk_dragon.studies._speed_ratio import SpeedRatio, largest_ratio
from pymunk_dragon.studies._study import Option, Progress, Result, Study, labelled, silent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# m travelled by the head after it enters the circle: at 1 m/s, the times in s that the contest's table requires.
DISTANCES = tuple(float(distance) for distance in range(-100, 101))
# Ratios of the first arc's radius to the second's for which the length is reported.
_RATIOS = (0.25, 0.5, 1.0, 2.0, 4.0)
# Limits of the speed ratio: with a smaller one no chain can follow a curve, and next to configurations in which the
# dragon gets stuck, the search takes long.
_MIN_FASTEST, _MAX_FASTEST = 1.01, 5.0
# Of the figure: m of ground around the circle, of the head's way from the turn to its position, and of its way before
# and after it enters the circle for which speeds are drawn.
BORDER, _EXIT_DISTANCE, SPEEDS = 1.5, 3.0, (-5.0, 20.0)


@dataclass(frozen=True, kw_only=True)
class MarchedTurn:
    """A turn, its first contact and its speeds.

    Attributes
    ----------
    path, march : Composite, March
        The path between both spirals, and the march on it; handle 0 enters the circle at t = 0.
    contact : FirstContact
        Certified first contact while the head travels from 100 m before the entry of the circle to 100 m after it.
    ratio : SpeedRatio
        Largest ratio of a handle's speed to the head's, enclosed by branch and bound.
    """

    path: Composite
    march: March
    contact: FirstContact
    ratio: SpeedRatio

    @property
    def length(self) -> float:
        """Length from the entry of the circle to its exit, m."""
        return self.path.joints[-1] - self.path.joints[0]

    @property
    def arcs(self) -> int:
        """Number of arcs."""
        return len(self.path.pieces) - 2

    def to_dict(self) -> dict[str, Any]:
        """First contact, and largest ratio of speeds."""
        return {"contact": self.contact.to_dict(), "peak_speed_ratio": self.ratio.to_dict()}

    def lines(self, start: float, end: float) -> list[str]:
        """Lines about the contact from `start` to `end` s, and about the fastest handle."""
        found = self.contact
        if found.status != "clear":
            contact = text("none, but the dragon gets stuck at t = {time:.6f} s").format(time=found.time)
            if found.benches is not None:
                i, j = found.benches
                contact = text("benches {i} and {j} touch at t = {time:.6f} s").format(i=i, j=j, time=found.time)
        elif found.near_misses == ():
            contact = text("none from {start:g} to {end:g} s,\nnor a gap below a thirtieth of the width: certified")
        else:
            contact = text("none from {start:g} to {end:g} s: certified")
        fastest = labelled(text("fastest:"), str(self.ratio))
        return [*labelled(text("contact:"), contact.format(start=start, end=end)), *fastest]


@dataclass(frozen=True, kw_only=True, repr=False)
class TurnResult(Result):
    """The contest's turn and the shortest turn that was found.

    Attributes
    ----------
    turn : UTurn
        The contest's turn.
    times : tuple of float
        The 201 times of the contest's table, result4.xlsx, s: from -100 to 100 s at a head speed of 1 m/s. At other
        speeds the head travels the same distances, from 100 m before the entry of the circle to 100 m after it.
    contests, shortest : MarchedTurn
        The contest's turn and the shortest one that was found, which is None without the search.
    lengths : tuple of tuple of float
        Ratios of the radii, and the length of the turn with each ratio, m.
    max_ratio : float
        Largest ratio of a handle's speed to the head's that the search allows.
    """

    turn: UTurn
    times: tuple[float, ...]
    contests: MarchedTurn
    lengths: tuple[tuple[float, float], ...]
    max_ratio: float
    shortest: MarchedTurn | None = None

    @property
    def march(self) -> March:
        """The march on the contest's turn."""
        return self.contests.march

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study u-turn --json` prints them."""
        turn, shortest = self.turn, None
        if self.shortest is not None:
            path = self.shortest.path
            arcs = [{"curvature": float(arc.curvature(0.0)), "length": arc.end_s} for arc in path.pieces[1:-1]]
            shortest = {
                "length": self.shortest.length,
                "proven": False,
                "arcs": arcs,
                "joints": path.point(path.joints).tolist(),
                "max_ratio": self.max_ratio,
                **self.shortest.to_dict(),
            }
        return {
            "length": turn.length,
            **{name: getattr(turn, name).tolist() for name in ("radii", "centres", "sweeps", "tangent_points")},
            "lengths": [{"ratio": ratio, "length": length} for ratio, length in self.lengths],
            **self.contests.to_dict(),
            "shortest": shortest,
        }

    def _lines(self) -> list[str]:
        turn, span = self.turn, (self.times[0], self.times[-1])
        first, second = turn.radii.tolist()
        ratios, lengths = zip(*self.lengths, strict=True)
        arcs = text(
            "{length:.6f} m on arcs of {first:.6f} and {second:.6f} m,\n"
            "each of {angle:.6f} degrees,\nabout {centres} m,\nwhich touch at\n{points} m"
        ).format(
            length=turn.length,
            first=first,
            second=second,
            angle=math.degrees(abs(turn.sweeps[0])),
            centres=_points(turn.centres),
            points=_points(turn.tangent_points),
        )
        always = text(
            "always as long: {shortest:.12f} to {longest:.12f} m\n"
            "where the radii are as {least:g} to 1 up to {most:g} to 1.\n"
            "Both turn by the same angle, and their chords make up\nthe circle's diameter"
        ).format(shortest=min(lengths), longest=max(lengths), least=min(ratios), most=max(ratios))
        lines = [
            *labelled(text("the turn:"), arcs),
            *self.contests.lines(*span),
            *labelled(text("two arcs:"), always),
        ]
        if self.shortest is None:
            return lines
        best = text("{length:.4f} m on {arcs} arcs: best found, not proven to be the shortest")
        searched = text(
            "turns on {arcs} circular arcs, tangent to each other and to both spirals\n"
            "where these meet the circle, inside the circle, with radii of at least\n"
            "{radius:g} m, on which every handle goes forward and none more than\n"
            "{ratio:.6f} times as fast as the head"
        )
        count = self.shortest.arcs
        return [
            *lines,
            *labelled(text("shorter:"), best.format(length=self.shortest.length, arcs=count)),
            *labelled(text("searched:"), searched.format(arcs=count, radius=MIN_RADIUS, ratio=self.max_ratio)),
            *self.shortest.lines(*span),
        ]

    def _draw(self) -> Figure:
        """Both paths with the dragon, and the speed of the fastest handle."""
        from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS
        from pymunk_dragon.studies._figures import POINTS, heading, panels

        title = text("The turn is {:.4f} m long on any two arcs").format(self.turn.length)
        note = text("no handle goes more than {:.4g} times as fast as the head")
        views = [("two", text("two arcs, {:.4f} m").format(self.turn.length), self.contests, BLUE)]
        if (short := self.shortest) is not None:
            views.append(("more", text("{} arcs, {:.4f} m").format(short.arcs, short.length), short, AMBER))
            title = text("The turn is {:.4f} m long on any two arcs; {} arcs save {:.0f} %")
            title = title.format(self.turn.length, short.arcs, 100 * (1 - short.length / self.turn.length))
            note = text("the best found on which no handle goes more than {:.4g} times as fast as the head")
        mosaic = [[*(view[0] for view in views), "speeds"]]
        figure, axes = panels(title, note.format(self.max_ratio), mosaic, width_ratios=[1.0] * len(views) + [0.9])
        heading(axes["speeds"], text("fastest handle,\ntimes the head's speed"))
        distances = np.linspace(*SPEEDS, POINTS)
        for key, name, turn, colour in views:
            heading(axes[key], name, colour)
            _draw_turn(axes[key], turn, colour, self.turn.radius)
            speeds = turn.march.at(turn.march.time(distances)).speeds
            fastest = (speeds / speeds[:, :1]).max(axis=1)
            axes["speeds"].plot(distances, fastest, color=colour, lw=1.8, gid="speeds", label=name)
        limit = f"{self.max_ratio:.4g}"
        axes["speeds"].axhline(self.max_ratio, color=COLOURS.contact, lw=1.0, ls=(0, (5, 3)), label=limit)
        axes["speeds"].set(xlim=SPEEDS, ylim=(0.98, 1.4 * self.max_ratio), xlabel=text("distance of the head (m)"))
        axes["speeds"].legend(loc="upper left", frameon=False, borderpad=0.0)
        return figure


def u_turn(
    dragon: Dragon | None = None,
    *,
    pitch: float = 1.7,
    radius: float = 4.5,
    ratio: float = 2.0,
    speed: float = 1.0,
    fastest: float | None = None,
    search: bool = True,
    progress: Progress = silent,
) -> TurnResult:
    """The turn of question 4, its first contact, and the shortest turn on five arcs that is found.

    Parameters
    ----------
    dragon : Dragon, optional
        The dragon; by default the contest's.
    pitch, radius, ratio, speed
        As in `UTurn` and `March`.
    fastest : float, optional
        Largest ratio of a handle's speed to the head's on the shortest turn, from 1.01 to 5; by default the largest
        ratio on the contest's turn.
    search : bool
        Whether to search for the shortest turn; this needs SciPy. No proof shows that there is no shorter one.
    progress : callable, optional
        Called with the part of the search that is done and the whole.

    Raises
    ------
    ParameterError
        If a value is out of range, if the dragon does not get round the contest's turn, or if no turn inside the
        circle is found on which every handle keeps to the limit.
    MissingExtraError
        If the search needs SciPy and it is not installed.

    Examples
    --------
    >>> found = u_turn(Dragon(benches=12), search=False)
    >>> print(f"{found.turn.length:.6f} m")
    13.621245 m
    """
    dragon = dragon or Dragon()
    if fastest is not None:
        fastest = finite("fastest", fastest, _MIN_FASTEST, _MAX_FASTEST, "times the head's speed")
    if not isinstance(search, bool):
        raise ParameterError("search", search, "True or False")
    if search:
        library("scipy.optimize")
    turn = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    times = tuple(March(dragon, turn, speed=speed).time(DISTANCES).tolist())
    try:
        peak = largest_ratio(dragon, turn)
    except (ParameterError, UnreachableError) as error:
        raise ParameterError("radius", radius, "large enough for the dragon to get round the turn") from error

    def marched(path: Composite, found: SpeedRatio) -> MarchedTurn:
        march = March(dragon, path, speed=speed)
        contact = first_contact(march, start=times[0], until=times[-1])
        return MarchedTurn(path=path, march=march, contact=contact, ratio=found)

    turns = [replace(turn, ratio=each) for each in _RATIOS]
    limit = peak.ratio if fastest is None else fastest
    try:
        found = shortest_turn(turn, dragon, limit, progress) if search else None
    except ParameterError:
        if limit < peak.ratio:
            raise
        # The contest's turn keeps to the limit.
        found = turn, peak
    return TurnResult(
        turn=turn,
        times=times,
        contests=marched(turn, peak),
        lengths=tuple((each.ratio, each.joints[-1] - each.joints[0]) for each in turns),
        max_ratio=limit,
        shortest=None if found is None else marched(*found),
    )


def _points(points: Array) -> str:
    return ", ".join(f"({x:.6f}, {y:.6f})" for x, y in points.tolist())


def _draw_turn(axes: Axes, turn: MarchedTurn, colour: str, radius: float) -> None:
    """Draw a turn between both spirals, and the dragon as it leaves the turn."""
    from pymunk_dragon.drawing.figures.style import PALE
    from pymunk_dragon.studies._figures import POINTS, plan_view

    end = turn.path.joints[-1]
    plan_view(axes, turn.march, float(turn.march.time(end + _EXIT_DISTANCE)), radius, radius + BORDER)
    for since, until, line in ((-60.0, 0.0, PALE), (end, end + 60.0, PALE), (0.0, end, colour)):
        path = turn.path.point(np.linspace(since, until, POINTS))
        axes.plot(*path.T, color=line, lw=2.4 if line == colour else 1.2, zorder=4 if line == colour else 1)
    axes.plot(*turn.path.point(turn.path.joints).T, "o", color=colour, ms=5, zorder=4, gid="joints")


STUDY = Study(
    name="u-turn",
    summary="turn inside the circle, and the shortest one found (question 4)",
    run=u_turn,
    options={
        "fastest": Option(kind=float, metavar="X", text="largest speed of a handle over that of the head."),
        "search": Option(kind=bool, text="search for a shorter turn on five arcs.  [search]"),
    },
    formats=(".json", ".png", ".svg", ".pdf", ".xlsx"),
)
