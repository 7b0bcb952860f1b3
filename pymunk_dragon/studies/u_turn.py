"""The turn of the contest's question 4, and the shortest turn that was found inside its circle.

Two arcs. Entry and exit are opposite to each other, 2 R apart, and their tangents are parallel, at an angle a to the
diameter between them. Any two arcs tangent to both and to each other turn by 2 a each. Their chords, 2 r sin a each,
lie on the diameter, one after the other, so (r1 + r2) sin a = R, and the length is 2 a (r1 + r2) = 2 a R / sin a. It
does not depend on the ratio of the radii.

Three and more arcs allow shorter turns. The diameter, 2 R, is the only geometric limit, but the handles behind
the head become faster as the turn becomes shorter. So the search is for the shortest turn on which no handle exceeds a
given multiple of the head's speed: by default the largest ratio on the contest's own turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, whole
from pymunk_dragon._extras import library
from pymunk_dragon._language import text
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies._shortest import Shortest, shortest_turn
from pymunk_dragon.studies._speed_ratio import SpeedRatio, largest_ratio
from pymunk_dragon.studies._study import Option, Progress, Result, Study, labelled, silent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# m travelled by the head after it enters the circle: at 1 m/s, the times in s that the contest's table requires.
DISTANCES = tuple(float(distance) for distance in range(-100, 101))
# Ratios of the first arc's radius to the second's for which the length is reported.
RATIOS = (0.25, 0.5, 1.0, 2.0, 4.0)
# Limits of the speed ratio: with a smaller one no chain can follow a curve, and next to configurations in which the
# dragon gets stuck, the search takes long.
MIN_FASTEST, MAX_FASTEST = 1.01, 5.0
# Largest number of arcs in the search, by default and at most.
ARCS, MAX_ARCS = 7, 15
# m. Least radius of an arc in the search, by default and at least. Smaller radii save centimetres, and slow down the
# certificate of the first contact.
MIN_RADIUS, SMALLEST = 0.5, 0.05
# Of the figure: m of ground around the circle, of the head's way from the turn to its position, and of its way before
# and after it enters the circle for which speeds are drawn.
BORDER, EXIT_DISTANCE, SPEEDS_FROM, SPEEDS_TO = 1.5, 3.0, -5.0, 20.0


@dataclass(frozen=True, kw_only=True, repr=False)
class TurnResult(Result):
    """The contest's turn and the shortest turn that was found.

    Attributes
    ----------
    turn, march : UTurn, March
        The contest's turn, and the march on it; handle 0 enters the circle at t = 0.
    times : tuple of float
        The 201 times of the contest's table, result4.xlsx, s: from -100 to 100 s at a head speed of 1 m/s. At other
        speeds the head travels the same distances, from 100 m before the entry of the circle to 100 m after it.
    contact : FirstContact
        Certified first contact between the first and the last of these times.
    peak_speed_ratio : SpeedRatio
        Largest ratio of a handle's speed to the head's on the contest's turn.
    lengths : tuple of tuple of float
        Ratios of the radii, and the length of the turn with each ratio, m.
    max_ratio, min_radius : float
        Largest ratio of a handle's speed to the head's that the search allows, and least radius of an arc, m.
    shortest, shortest_march, shortest_contact : Shortest, March and FirstContact, or None
        The shortest turn that was found, the march on it, and its certified first contact; None without the search.
    """

    turn: UTurn
    march: March
    times: tuple[float, ...]
    contact: FirstContact
    peak_speed_ratio: SpeedRatio
    lengths: tuple[tuple[float, float], ...]
    max_ratio: float
    min_radius: float
    shortest: Shortest | None = None
    shortest_march: March | None = None
    shortest_contact: FirstContact | None = None

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study u-turn --json` prints them."""
        turn, shortest = self.turn, None
        if self.shortest is not None and self.shortest_contact is not None:
            limits = {"max_ratio": self.max_ratio, "min_radius": self.min_radius}
            shortest = {**self.shortest.to_dict(), **limits, "contact": self.shortest_contact.to_dict()}
        return {
            "length": turn.length,
            **{name: getattr(turn, name).tolist() for name in ("radii", "centres", "sweeps", "tangent_points")},
            "lengths": [{"ratio": ratio, "length": length} for ratio, length in self.lengths],
            "contact": self.contact.to_dict(),
            "peak_speed_ratio": self.peak_speed_ratio.to_dict(),
            "shortest": shortest,
        }

    def _lines(self) -> list[str]:
        turn = self.turn
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
        return [
            *labelled(text("the turn:"), arcs),
            *labelled(text("contact:"), self._contact_text(self.contact)),
            *labelled(text("fastest:"), str(self.peak_speed_ratio)),
            *labelled(text("two arcs:"), always),
            *self._lines_of_shortest(),
        ]

    def _lines_of_shortest(self) -> list[str]:
        """Lines about the shortest turn that was found."""
        short = self.shortest
        if short is None or self.shortest_contact is None:
            return []
        best = text("{length:.4f} m on {arcs} arcs: best found, not proven to be the shortest")
        searched = text(
            "turns on n circular arcs, tangent to each other and to both spirals\n"
            "where these meet the circle, inside the circle, with radii of at least\n"
            "{radius:g} m, on which every handle goes forward and none more than\n"
            "{ratio:.6f} times as fast as the head"
        )
        lengths = [text("{length:.4f} m on {arcs}").format(length=long, arcs=arcs) for arcs, long in short.by_arcs]
        return [
            *labelled(text("shorter:"), best.format(length=short.length, arcs=len(short.lengths))),
            *labelled(text("searched:"), searched.format(radius=self.min_radius, ratio=self.max_ratio)),
            *labelled(text("by n:"), ", ".join(lengths)),
            *labelled(text("contact:"), self._contact_text(self.shortest_contact)),
            *labelled(text("fastest:"), str(short.ratio)),
        ]

    def _contact_text(self, found: FirstContact) -> str:
        start, end = self.times[0], self.times[-1]
        if found.status == "clear" and found.near_misses == ():
            certified = text("none from {start:g} to {end:g} s,\nnor a gap below a thirtieth of the width: certified")
            return certified.format(start=start, end=end)
        if found.status == "clear":
            return text("none from {start:g} to {end:g} s: certified").format(start=start, end=end)
        if found.benches is None:
            return text("none, but the dragon gets stuck at t = {time:.6f} s").format(time=found.time)
        i, j = found.benches
        return text("benches {i} and {j} touch at t = {time:.6f} s").format(i=i, j=j, time=found.time)

    def _draw(self) -> Figure:
        """Both paths with the dragon, and the speed of the fastest handle."""
        from pymunk_dragon.drawing.figures.style import AMBER, BLUE
        from pymunk_dragon.studies._figures import panels

        title = text("The turn is {:.4f} m long on any two arcs").format(self.turn.length)
        note = text("no handle goes more than {:.4g} times as fast as the head")
        views = [("two", text("two arcs, {:.4f} m").format(self.turn.length), self.march, self.turn.joints, BLUE)]
        if self.shortest is not None and self.shortest_march is not None:
            short = self.shortest
            arcs, saved = len(short.lengths), 100 * (1 - short.length / self.turn.length)
            name = text("{} arcs, {:.4f} m").format(arcs, short.length)
            views.append(("more", name, self.shortest_march, short.path.joints, AMBER))
            title = text("The turn is {:.4f} m long on any two arcs; {} arcs save {:.0f} %")
            title = title.format(self.turn.length, arcs, saved)
            note = text("the best found on which no handle goes more than {:.4g} times as fast as the head")
        mosaic = [[*(view[0] for view in views), "speeds"]]
        figure, axes = panels(title, note.format(self.max_ratio), mosaic, width_ratios=[1.0] * len(views) + [0.9])
        for key, name, march, joints, colour in views:
            _draw_turn(axes[key], name, march, joints, colour, self.turn.radius)
        _draw_speeds(axes["speeds"], self, [view[1:] for view in views])
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
    arcs: int = ARCS,
    min_radius: float = MIN_RADIUS,
    progress: Progress = silent,
) -> TurnResult:
    """The turn of question 4, its first contact, and the shortest turn that is found.

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
    arcs : int
        Largest number of arcs of the turns that are searched: an odd number from 3 to 15.
    min_radius : float
        Least radius of an arc in the search, from 0.05 m to the circle's radius.
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
        fastest = finite("fastest", fastest, MIN_FASTEST, MAX_FASTEST, "times the head's speed")
    if not isinstance(search, bool):
        raise ParameterError("search", search, "True or False")
    if whole("arcs", arcs, 3, MAX_ARCS) % 2 == 0:
        raise ParameterError("arcs", arcs, f"an odd number from 3 to {MAX_ARCS}")
    if search:
        library("scipy.optimize")
    turn = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    min_radius = finite("min_radius", min_radius, SMALLEST, turn.radius, "m")
    march = March(dragon, turn, speed=speed)
    start, *_, end = times = tuple(march.time(DISTANCES).tolist())
    try:
        peak = largest_ratio(dragon, turn)
    except (ParameterError, UnreachableError) as error:
        raise ParameterError("radius", radius, "large enough for the dragon to get round the turn") from error
    turns = [replace(turn, ratio=each) for each in RATIOS]
    found = TurnResult(
        turn=turn,
        march=march,
        times=times,
        contact=first_contact(march, start=start, until=end),
        peak_speed_ratio=peak,
        lengths=tuple((each.ratio, each.joints[-1] - each.joints[0]) for each in turns),
        max_ratio=peak.ratio if fastest is None else fastest,
        min_radius=min_radius,
    )
    if not search:
        return found
    shortest = shortest_turn(turn, dragon, found.max_ratio, arcs, min_radius, progress)
    march = March(dragon, shortest.path, speed=speed)
    contact = first_contact(march, start=start, until=end)
    return replace(found, shortest=shortest, shortest_march=march, shortest_contact=contact)


def _points(points: Array) -> str:
    return ", ".join(f"({x:.6f}, {y:.6f})" for x, y in points.tolist())


def _draw_turn(axes: Axes, name: str, march: March, joints: tuple[float, ...], colour: str, radius: float) -> None:
    """Draw a turn between both spirals, and the dragon as it leaves the turn."""
    from pymunk_dragon.drawing.figures.style import PALE
    from pymunk_dragon.studies._figures import POINTS, heading, plan_view

    heading(axes, name, colour)
    end = joints[-1]
    plan_view(axes, march, float(march.time(end + EXIT_DISTANCE)), radius, radius + BORDER)
    for since, until, line in ((-60.0, 0.0, PALE), (end, end + 60.0, PALE), (0.0, end, colour)):
        path = march.curve.point(np.linspace(since, until, POINTS))
        axes.plot(*path.T, color=line, lw=2.4 if line == colour else 1.2, zorder=4 if line == colour else 1)
    axes.plot(*march.curve.point(joints).T, "o", color=colour, ms=5, zorder=4, gid="joints")


def _draw_speeds(axes: Axes, found: TurnResult, turns: list[tuple[str, March, tuple[float, ...], str]]) -> None:
    """Draw the largest ratio of handle speed to head speed over the head's distance travelled."""
    from pymunk_dragon.drawing.figures.style import COLOURS
    from pymunk_dragon.studies._figures import POINTS, heading

    heading(axes, text("fastest handle,\ntimes the head's speed"))
    distances = np.linspace(SPEEDS_FROM, SPEEDS_TO, POINTS)
    for name, march, _, colour in turns:
        speeds = march.at(march.time(distances)).speeds
        axes.plot(distances, (speeds / speeds[:, :1]).max(axis=1), color=colour, lw=1.8, gid="speeds", label=name)
    axes.axhline(found.max_ratio, color=COLOURS.contact, lw=1.0, ls=(0, (5, 3)), label=f"{found.max_ratio:.4g}")
    axes.set_xlim(SPEEDS_FROM, SPEEDS_TO)
    axes.set_ylim(0.98, 1.4 * found.max_ratio)
    axes.legend(loc="upper left", frameon=False, borderpad=0.0)
    axes.set_xlabel(text("distance of the head (m)"))


STUDY = Study(
    name="u-turn",
    summary="turn inside the circle, and the shortest one found (question 4)",
    run=u_turn,
    options={
        "fastest": Option(kind=float, metavar="X", text="largest speed of a handle over that of the head."),
        "search": Option(kind=bool, text="search for a shorter turn on more arcs.  [search]"),
        "arcs": Option(kind=int, metavar="N", text="largest number of arcs in the search, odd.  [7]"),
        "min_radius": Option(kind=float, metavar="M", text="least radius in the search, m.  [0.5]"),
    },
    formats=(".json", ".png", ".svg", ".pdf", ".xlsx"),
)
