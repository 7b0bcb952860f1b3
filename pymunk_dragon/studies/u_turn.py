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

from pymunk_dragon._arrays import Array, ArrayRecord, read_only
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
TIMES = np.arange(-100.0, 101.0)
# Ratios of the first arc's radius to the second's for which the length is reported.
RATIOS = (0.25, 0.5, 1.0, 2.0, 4.0)
# Least limit of the speed ratio: with a smaller one no chain can follow a curve.
MIN_FASTEST = 1.01
# Largest limit of the speed ratio: next to configurations in which the dragon gets stuck, the search takes long.
MAX_FASTEST = 5.0
# Largest number of arcs in the search, by default.
ARCS = 7
# Largest number of arcs in the search.
MAX_ARCS = 15
# m. Least radius of an arc in the search, by default. Smaller radii save centimetres, and slow down the certificate of
# the first contact.
MIN_RADIUS = 0.5
# m. Least value of the least radius.
SMALLEST = 0.05

# Of the figure: m from the end of the turn to the head, at the time that is drawn.
EXIT_DISTANCE = 3.0
# Of the figure: m of ground shown around the circle.
BORDER = 1.5
# Of the figure: m of head travel before it enters the circle for which speeds are drawn.
DISTANCE_BEFORE = 5.0
# Of the figure: m of head travel after it enters the circle for which speeds are drawn.
DISTANCE_AFTER = 20.0
# Of the figure: points of a line.
LINE_POINTS = 1200


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class TurnResult(Result, ArrayRecord):
    """The contest's turn and the shortest turn that was found.

    Attributes
    ----------
    turn : UTurn
        The contest's turn, with its radii, centres, sweeps, tangent points and length.
    march : March
        March on the contest's turn; handle 0 enters the circle at t = 0.
    times : ndarray, shape (201,)
        Times of the contest's table, result4.xlsx, s: from -100 to 100 s at a head speed of 1 m/s. At other speeds the
        head travels the same distances, from 100 m before the entry of the circle to 100 m after it.
    contact : FirstContact
        Certified first contact between the first and the last of these times.
    peak_speed_ratio : SpeedRatio
        Largest ratio of a handle's speed to the head's on the contest's turn.
    lengths : tuple of tuple of float
        Ratios of the radii, and the length of the turn with each ratio, m.
    max_ratio : float
        Largest ratio of a handle's speed to the head's that the search allows.
    shortest : Shortest or None
        The shortest turn that was found; None without the search.
    shortest_march : March or None
        March on the shortest turn.
    shortest_contact : FirstContact or None
        Certified first contact on the shortest turn.

    Examples
    --------
    >>> found = u_turn(Dragon(benches=12), search=False)
    >>> found.contact.status, round(found.peak_speed_ratio.ratio, 3)
    ('clear', 1.605)
    """

    turn: UTurn
    march: March
    times: Array
    contact: FirstContact
    peak_speed_ratio: SpeedRatio
    lengths: tuple[tuple[float, float], ...]
    max_ratio: float
    shortest: Shortest | None
    shortest_march: March | None
    shortest_contact: FirstContact | None

    def to_dict(self) -> dict[str, Any]:
        """Values in SI units, as `study u-turn --json` prints them."""
        turn, shortest = self.turn, None
        if self.shortest is not None and self.shortest_contact is not None:
            shortest = {
                **self.shortest.to_dict(),
                "max_ratio": self.max_ratio,
                "contact": self.shortest_contact.to_dict(),
            }
        return {
            "length": turn.length,
            "radii": turn.radii.tolist(),
            "centres": turn.centres.tolist(),
            "sweeps": turn.sweeps.tolist(),
            "tangent_points": turn.tangent_points.tolist(),
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
        shortest = self.shortest
        if shortest is None or self.shortest_contact is None:
            return []
        short = shortest.turn
        best = text("{length:.4f} m on {arcs} arcs: best found, not proven to be the shortest")
        searched = text(
            "turns on n circular arcs, tangent to each other and to both spirals\n"
            "where these meet the circle, inside the circle, with radii of at least\n"
            "{radius:g} m, on which every handle goes forward and none more than\n"
            "{ratio:.6f} times as fast as the head"
        )
        lengths = [text("{length:.4f} m on {arcs}").format(length=long, arcs=arcs) for arcs, long in shortest.lengths]
        arcs = [_arc_text(i, *arc) for i, arc in enumerate(zip(short.curvatures, short.lengths, strict=True), start=1)]
        limit = text("handles at the limit: {handles}").format(handles=", ".join(map(str, shortest.binding)))
        return [
            *labelled(text("shorter:"), best.format(length=short.length, arcs=len(short.lengths))),
            *labelled(text("searched:"), searched.format(radius=shortest.min_radius, ratio=self.max_ratio)),
            *labelled(text("by n:"), "\n".join((", ".join(lengths), *arcs))),
            *labelled(text("contact:"), self._contact_text(self.shortest_contact)),
            *labelled(text("fastest:"), f"{shortest.ratio};\n{limit}"),
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
        from pymunk_dragon.drawing.figures.style import AMBER, BLUE, panel, slide

        name = text("two arcs, {:.4f} m").format(self.turn.length)
        panels = [(0.3, self.march, self.turn.joints, name, BLUE)]
        title = text("The turn is {:.4f} m long on any two arcs").format(self.turn.length)
        note = text("no handle goes more than {:.4g} times as fast as the head")
        side, left = 2.9, 4.1
        if self.shortest is not None and self.shortest_march is not None:
            short, side, left = self.shortest.turn, 2.4, 5.75
            arcs, saved = len(short.lengths), 100 * (1 - short.length / self.turn.length)
            name = text("{} arcs, {:.4f} m").format(arcs, short.length)
            panels.append((2.8, self.shortest_march, short.path.joints, name, AMBER))
            title = text("The turn is {:.4f} m long on any two arcs; {} arcs save {:.0f} %")
            title = title.format(self.turn.length, arcs, saved)
            note = text("the best found on which no handle goes more than {:.4g} times as fast as the head")
        figure = slide(title, note.format(self.max_ratio))
        for start, march, joints, name, colour in panels:
            axes = panel(figure, start, 3.35 - side, side, side)
            axes.set_title(name, loc="left", size=11.5, color=colour, pad=6)
            _draw_plan_view(axes, self.turn.radius, march, joints, colour)
        _draw_speeds(panel(figure, left, 0.7, 7.75 - left, 2.2), self)
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
    pitch, radius, ratio
        As in `UTurn`.
    speed
        As in `March`.
    fastest : float, optional
        Largest ratio of a handle's speed to the head's on the shortest turn, from 1.01 to 5; by default the largest
        ratio on the contest's turn.
    search : bool
        Whether to search for the shortest turn; this needs SciPy.
    arcs : int
        Largest number of arcs of the turns that are searched: an odd number from 3 to 15.
    min_radius : float
        Least radius of an arc in the search, from 0.05 m to the circle's radius.
    progress : callable, optional
        Called with the part of the search that is done and the whole.

    Returns
    -------
    TurnResult
        Both turns with their evidence. The search does not prove that there is no shorter turn.

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
    times = read_only(march.time(TIMES))
    try:
        peak = largest_ratio(dragon, turn)
    except (ParameterError, UnreachableError) as error:
        raise ParameterError("radius", radius, "large enough for the dragon to get round the turn") from error
    max_ratio = peak.ratio if fastest is None else fastest
    shortest = shortest_turn(turn, dragon, max_ratio, arcs, min_radius, progress) if search else None
    shortest_march = None if shortest is None else March(dragon, shortest.turn.path, speed=speed)
    return TurnResult(
        turn=turn,
        march=march,
        times=times,
        contact=_contact(march, times),
        peak_speed_ratio=peak,
        lengths=tuple((each, _joint_length(replace(turn, ratio=each))) for each in RATIOS),
        max_ratio=max_ratio,
        shortest=shortest,
        shortest_march=shortest_march,
        shortest_contact=None if shortest_march is None else _contact(shortest_march, times),
    )


def _joint_length(turn: UTurn) -> float:
    """Distance between the first and the last joint of a turn, m."""
    return turn.joints[-1] - turn.joints[0]


def _contact(march: March, times: Array) -> FirstContact:
    """Certified first contact from the first of `times` to the last."""
    return first_contact(march, start=float(times[0]), until=float(times[-1]))


def _arc_text(number: int, curvature: float, length: float) -> str:
    if curvature == 0:
        return text("arc {i}: {length:.4f} m, straight").format(i=number, length=length)
    if curvature > 0:
        line = text("arc {i}: {length:.4f} m, to the left with a radius of {radius:.4f} m")
    else:
        line = text("arc {i}: {length:.4f} m, to the right with a radius of {radius:.4f} m")
    return line.format(i=number, length=length, radius=1 / abs(curvature))


def _points(points: Array) -> str:
    return ", ".join(f"({x:.6f}, {y:.6f})" for x, y in points.tolist())


def _draw_plan_view(axes: Axes, radius: float, march: March, joints: tuple[float, ...], colour: str) -> None:
    """Draw a turn between both spirals, and the dragon as it leaves the turn."""
    from pymunk_dragon.drawing.figures.lines import label
    from pymunk_dragon.drawing.figures.style import COLOURS, PALE, QUIET, SHARED
    from pymunk_dragon.studies._figures import circle, square

    half = radius + BORDER
    square(axes, half)
    circle(axes, radius)
    dragon, head = march.dragon, joints[-1] + EXIT_DISTANCE
    for bench, outline in enumerate(dragon.outlines(march.at(march.time(head)).poses[0])):
        if np.abs(outline).max(axis=1).min() < half:
            fill = COLOURS.head if bench == 0 else SHARED
            axes.fill(*outline.T, fc=fill, ec=QUIET, lw=0.8, zorder=2, gid=f"bench-{bench}")
    for since, until, line in ((-60.0, 0.0, PALE), (joints[-1], joints[-1] + 60.0, PALE), (0.0, joints[-1], colour)):
        path = march.curve.point(np.linspace(since, until, LINE_POINTS))
        axes.plot(*path.T, color=line, lw=2.4 if line == colour else 1.2, zorder=3 if line == colour else 1)
    axes.plot(*march.curve.point(joints).T, "o", color=colour, ms=5, zorder=4, gid="joints")
    # Labels of entry and exit are on the side without benches.
    for name, joint, side in ((text("enters"), 0, 1), (text("leaves"), -1, -1)):
        point = march.curve.point(joints[joint])
        note: dict[str, Any] = {"ha": "left" if side > 0 else "right", "va": "center", "color": QUIET}
        label(axes, point[0], point[1], name, (13 * side, 12 * side), zorder=5, **note)


def _draw_speeds(axes: Axes, found: TurnResult) -> None:
    """Draw the largest ratio of handle speed to head speed over the head's distance travelled."""
    from pymunk_dragon.drawing.figures.lines import label
    from pymunk_dragon.drawing.figures.style import AMBER, BLUE, COLOURS
    from pymunk_dragon.studies._figures import heading

    heading(axes, text("fastest handle,\ntimes the head's speed"), 16)
    distances = np.linspace(-DISTANCE_BEFORE, DISTANCE_AFTER, LINE_POINTS)
    for march, colour, gid in ((found.shortest_march, AMBER, "short-speeds"), (found.march, BLUE, "speeds")):
        if march is None:
            continue
        speeds = march.at(march.time(distances)).speeds
        axes.plot(distances, (speeds / speeds[:, :1]).max(axis=1), color=colour, lw=1.8, gid=gid)
    axes.axhline(found.max_ratio, color=COLOURS.contact, lw=1.0, ls=(0, (5, 3)), gid="allowed")
    label(axes, DISTANCE_AFTER, found.max_ratio, f"{found.max_ratio:.4g}", (0, 4), ha="right", color=COLOURS.contact)
    axes.set_xlim(-DISTANCE_BEFORE, DISTANCE_AFTER)
    axes.set_ylim(0.98, None)
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
    has_sheets=True,
)
