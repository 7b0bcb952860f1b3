"""The turn of the contest's question 4, and the shortest one that a dragon can make instead.

Two arcs. Entry and exit lie opposite to each other, 2 R apart, and the directions there are the same, at an angle a to
the straight way across. Any two arcs that touch both and each other turn by 2 a each. Their chords, 2 r sin a each, lie
on the straight way, one behind the other, so (r1 + r2) sin a = R, and the length is 2 a (r1 + r2) = 2 a R / sin a:
changing the arcs does not make the turn shorter.

Three arcs, or two and a line between them, do. Nothing but the way straight across, 2 R, is a limit to that: benches do
not touch each other in tight turns. But dancers have to run round them. So the shortest turn is sought on which nobody
comes to be faster, over the head, than is allowed: without any other word, than on the contest's own turn.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pymunk_dragon.checks import finite
from pymunk_dragon.collision import Impact, first_contact
from pymunk_dragon.curves import UTurn
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.march import March
from pymunk_dragon.studies.shortest import LEAD, Shortest, hurry, shortest_turn

__all__ = ["TIMES", "Hurry", "TurnAnswer", "u_turn"]

Array = NDArray[np.float64]

# s at the contest's 1 m/s: the times of its sheet, and m of the head's way otherwise.
TIMES = np.arange(-100.0, 101.0)
# Radii of the first arc over the second for which the length is told.
RATIOS = (0.25, 0.5, 1.0, 2.0, 4.0)
# Times the head's speed. Below it no chain goes round a bend; above it nobody runs, and next to where the dragon gets
# stuck the search takes long.
MIN_FASTEST, MAX_FASTEST = 1.01, 5.0
# Share of a speed that is no difference.
SAME = 1e-9


@dataclass(frozen=True, kw_only=True)
class Hurry:
    """Who has to go fastest.

    Attributes
    ----------
    factor : float
        Speed over that of the head.
    handle : int
        Whose.
    way : float
        Where the head is then, m from where it entered the circle.
    """

    factor: float
    handle: int
    way: float


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
    impact : Impact
        First contact between the first and the last of these, certified.
    hurry : Hurry
        Who goes fastest on it between them.
    lengths : tuple of tuple of float
        Ratios of the radii, and the length of the turn with each, m.
    allowed : float
        How many times as fast as the head anybody may be on the shortest turn.
    shortest : Shortest
        The shortest turn inside the circle on three arcs, the middle one of any bend.
    short_march : March
        On that.
    short_impact : Impact
        First contact there.
    short_hurry : Hurry
        Who goes fastest there.
    """

    turn: UTurn
    march: March
    times: Array = field(repr=False)
    impact: Impact
    hurry: Hurry
    lengths: tuple[tuple[float, float], ...]
    allowed: float
    shortest: Shortest
    short_march: March
    short_impact: Impact
    short_hurry: Hurry


def u_turn(
    dragon: Dragon | None = None,
    *,
    pitch: float = 1.7,
    radius: float = 4.5,
    ratio: float = 2.0,
    speed: float = 1.0,
    fastest: float | None = None,
) -> TurnAnswer:
    """The turn of question 4, whether the dragon gets round it, and the shortest one.

    Parameters
    ----------
    dragon : Dragon, optional
        Who marches; by default the contest's.
    pitch, radius, ratio
        As in `UTurn`.
    speed
        As in `March`.
    fastest : float, optional
        How many times as fast as the head anybody may be on the shortest turn, from 1.01 to 5; by default what
        somebody is on the contest's.

    Returns
    -------
    TurnAnswer
        The shortest turn's length is right to 1e-5 m among the turns that are searched, if the limit is from 1.3 to
        1.7. With others it is that of the shortest turn found, and there may be shorter ones.

    Raises
    ------
    ParameterError
        If one of these is impossible, if the dragon does not get round the contest's turn, or if no turn inside the
        circle is found on which nobody is too fast.
    """
    dragon = dragon or Dragon()
    if fastest is not None:
        fastest = finite("fastest", fastest, MIN_FASTEST, MAX_FASTEST, "times the head's speed")
    turn = UTurn(pitch=pitch, radius=radius, ratio=ratio)
    march = March(dragon, turn, speed=speed)
    times = march.time(TIMES)
    times.flags.writeable = False
    most = _hurry(march, turn.radius)
    allowed = most.factor if fastest is None else fastest
    found = shortest_turn(turn, dragon.spacings, allowed)
    short_march = March(dragon, found.turn.path, speed=speed)
    return TurnAnswer(
        turn=turn,
        march=march,
        times=times,
        impact=_impact(march, times),
        hurry=most,
        lengths=tuple((each, _measured(replace(turn, ratio=each))) for each in RATIOS),
        allowed=allowed,
        shortest=found,
        short_march=short_march,
        short_impact=_impact(short_march, times),
        short_hurry=_hurry(short_march, turn.radius),
    )


def _measured(turn: UTurn) -> float:
    """Length of a turn by the pieces that it is joined of, m."""
    return turn.joints[-1] - turn.joints[0]


def _impact(march: March, times: Array) -> Impact:
    return first_contact(march, start=float(times[0]), until=float(times[-1]))


def _hurry(march: March, radius: float) -> Hurry:
    """Who goes fastest while the head goes through the turn and on.

    Along the inward spiral everybody is slower than the one before, so only those that get beyond it are looked at.
    """
    spacings, until = march.dragon.spacings, float(TIMES[-1])
    reach = 1 + int(np.searchsorted(np.cumsum(spacings), until))
    found = hurry(march.curve, spacings[:reach], -LEAD, until)
    if found is None:
        raise ParameterError("radius", radius, "large enough for the dragon to get round the turn")
    peaks, heads = found
    # On an arc several are as fast, but for rounding: the foremost of them.
    handle = int(np.argmax(peaks >= peaks.max() * (1 - SAME)))
    return Hurry(factor=float(peaks[handle]), handle=handle, way=float(heads[handle]))
