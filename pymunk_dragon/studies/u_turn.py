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

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon._checks import finite, whole
from pymunk_dragon._extras import library
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model.curves import UTurn
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.studies.max_speed import SpeedRatio, largest_ratio
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.shortest import Shortest, shortest_turn

__all__ = ["TIMES", "TurnAnswer", "u_turn"]

Array = NDArray[np.float64]

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


@dataclass(frozen=True, kw_only=True)
class TurnAnswer:
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
    impact : FirstContact
        Certified first contact between the first and the last of these times.
    hurry : SpeedRatio
        Largest ratio of a handle's speed to the head's on the contest's turn.
    lengths : tuple of tuple of float
        Ratios of the radii, and the length of the turn with each ratio, m.
    allowed : float
        Largest ratio of a handle's speed to the head's that the search allows.
    shortest : Shortest or None
        The shortest turn that was found; None without the search.
    short_march : March or None
        March on the shortest turn.
    short_impact : FirstContact or None
        Certified first contact on the shortest turn.
    """

    turn: UTurn
    march: March
    times: Array = field(repr=False)
    impact: FirstContact
    hurry: SpeedRatio
    lengths: tuple[tuple[float, float], ...]
    allowed: float
    shortest: Shortest | None
    short_march: March | None
    short_impact: FirstContact | None


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
) -> TurnAnswer:
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
    TurnAnswer
        Both turns with their evidence. The search does not prove that there is no shorter turn.

    Raises
    ------
    ParameterError
        If a value is out of range, if the dragon does not get round the contest's turn, or if no turn inside the
        circle is found on which every handle keeps to the limit.
    MissingExtraError
        If the search needs SciPy and it is not installed.
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
    times = march.time(TIMES)
    times.flags.writeable = False
    try:
        most = largest_ratio(March(dragon, turn))
    except (ParameterError, UnreachableError) as error:
        raise ParameterError("radius", radius, "large enough for the dragon to get round the turn") from error
    allowed = most.ratio if fastest is None else fastest
    shortest = shortest_turn(turn, dragon, allowed, arcs, min_radius, progress) if search else None
    short_march = None if shortest is None else March(dragon, shortest.turn.path, speed=speed)
    return TurnAnswer(
        turn=turn,
        march=march,
        times=times,
        impact=_impact(march, times),
        hurry=most,
        lengths=tuple((each, _joint_length(replace(turn, ratio=each))) for each in RATIOS),
        allowed=allowed,
        shortest=shortest,
        short_march=short_march,
        short_impact=None if short_march is None else _impact(short_march, times),
    )


def _joint_length(turn: UTurn) -> float:
    """Distance between the first and the last joint of a turn, m."""
    return turn.joints[-1] - turn.joints[0]


def _impact(march: March, times: Array) -> FirstContact:
    """Certified first contact from the first of `times` to the last."""
    return first_contact(march, start=float(times[0]), until=float(times[-1]))
