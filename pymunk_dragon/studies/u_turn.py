"""The turn of the contest's question 4, and the shortest one that was found inside its circle.

Two arcs. Entry and exit lie opposite to each other, 2 R apart, and the directions there are the same, at an angle a to
the straight way across. Any two arcs that touch both and each other turn by 2 a each. Their chords, 2 r sin a each, lie
on the straight way, one behind the other, so (r1 + r2) sin a = R, and the length is 2 a (r1 + r2) = 2 a R / sin a:
changing the arcs does not make the turn shorter.

Three and more arcs do. The way straight across, 2 R, is the only geometric limit, but the handles behind the head
become ever faster. So the shortest turn is sought on which no handle exceeds a given multiple of the head's speed: by
default the largest one on the contest's own turn.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite, whole
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.curves import UTurn
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.extras import library
from pymunk_dragon.march import March
from pymunk_dragon.studies.max_speed import SpeedRatio, largest_ratio
from pymunk_dragon.studies.progress import Progress, silent
from pymunk_dragon.studies.shortest import Shortest, shortest_turn

__all__ = ["TIMES", "TurnAnswer", "u_turn"]

Array = NDArray[np.float64]

# s at the contest's 1 m/s: the times of its sheet, and m of the head's way otherwise.
TIMES = np.arange(-100.0, 101.0)
# Radii of the first arc over the second for which the length is told.
RATIOS = (0.25, 0.5, 1.0, 2.0, 4.0)
# Times the head's speed. Below it no chain goes round a bend; above it nobody runs, and next to where the dragon gets
# stuck the search takes long.
MIN_FASTEST, MAX_FASTEST = 1.01, 5.0
# Largest number of arcs in the search: by default, and at most.
ARCS, MAX_ARCS = 7, 15
# m. Least radius of an arc in the search. Smaller ones save centimetres and make the certificate of a contact slow.
MIN_RADIUS = 0.5
# m. Least value of that.
SMALLEST = 0.05


@dataclass(frozen=True, kw_only=True)
class TurnAnswer:
    """The contest's turn and the shortest one.

    Attributes
    ----------
    turn : UTurn
        The contest's, with its radii, centres, sweeps, tangent points and length.
    march : March
        On it; handle 0 enters the circle at t = 0.
    times : ndarray, shape (201,)
        Those of the contest's sheet, result4.xlsx: from -100 to 100 s where the head goes at 1 m/s, and while it goes
        from 100 m before the circle to 100 m after entering it otherwise, s.
    impact : FirstContact
        First contact between the first and the last of these, certified.
    hurry : SpeedRatio
        Largest speed of a handle over the head's on it, at any time.
    lengths : tuple of tuple of float
        Ratios of the radii, and the length of the turn with each, m.
    allowed : float
        Multiple of the head's speed that no handle may exceed on the shortest turn.
    shortest : Shortest or None
        The shortest turn that was found; None without the search.
    short_march : March or None
        On that.
    short_impact : FirstContact or None
        First contact there.
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
        By default the contest's.
    pitch, radius, ratio
        As in `UTurn`.
    speed
        As in `March`.
    fastest : float, optional
        Multiple of the head's speed that no handle may exceed on the shortest turn, from 1.01 to 5; by default the
        largest on the contest's.
    search : bool
        Whether to search for the shortest turn; this needs SciPy.
    arcs : int
        Largest number of arcs of the turns that are searched: an odd number from 3 to 15.
    min_radius : float
        Least radius of an arc in the search, from 0.05 m to the circle's radius.
    progress : callable, optional
        Called with how much of the search is done, and how much there is.

    Returns
    -------
    TurnAnswer
        The search finds good turns; no proof shows that there are no shorter ones.

    Raises
    ------
    ParameterError
        If a value cannot be used, if the dragon does not get round the contest's turn, or if no turn inside the
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
        lengths=tuple((each, _measured(replace(turn, ratio=each))) for each in RATIOS),
        allowed=allowed,
        shortest=shortest,
        short_march=short_march,
        short_impact=None if short_march is None else _impact(short_march, times),
    )


def _measured(turn: UTurn) -> float:
    """Length of a turn by the pieces that it is joined of, m."""
    return turn.joints[-1] - turn.joints[0]


def _impact(march: March, times: Array) -> FirstContact:
    return first_contact(march, start=float(times[0]), until=float(times[-1]))
