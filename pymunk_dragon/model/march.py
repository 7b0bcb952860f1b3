"""Exact kinematics of a dragon on a curve: its handles' motion (paper, eq. 1-15)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, ArrayRecord, as_complex, as_vectors, read_only
from pymunk_dragon._checks import finite, instance, numbers, positive, whole
from pymunk_dragon._language import text
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.model._display import table
from pymunk_dragon.model.chain import ChainMotion
from pymunk_dragon.model.continuation import Continuation
from pymunk_dragon.model.curves import Curve, Reversed, Spiral
from pymunk_dragon.model.curves.base import required_curve
from pymunk_dragon.model.dragon import Dragon, bench_poses
from pymunk_dragon.model.speed import MAX_SPEED, MAX_TIME, MIN_SPEED, SpeedTable

# m before the start. At this distance a double still resolves 0.1 nm.
_MAX_RETREAT = 1e5
# m from a curve's begin to the last handle of a dragon that starts there: 1000 rounding errors.
_CLEAR_OF_BEGIN = 1e-9
# Points per pass in the search for the last time at which a chain has a state.
_LAST_POINTS = 33
# Share of a time, and s: sums of steps may be later than the end of the curve by some thousand
# rounding errors.
_SAME_TIME = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class States(ArrayRecord):
    """States of a dragon at T times: H handles, N = H - 1 benches.

    Attributes
    ----------
    times : ndarray, shape (T,), s
    handles_s : ndarray, shape (T, H), m
        Arc-length coordinates of the handles.
    positions : ndarray, shape (T, H, 2), m
    velocities : ndarray, shape (T, H, 2), m/s
    speeds : ndarray, shape (T, H), m/s
        Magnitudes of the velocities.

    Examples
    --------
    >>> states = March().at([0.0, 60.0], handles=3)
    >>> states.positions.shape, states.poses.shape
    ((2, 3, 2), (2, 2, 3))
    """

    times: Array
    handles_s: Array
    positions: Array
    velocities: Array
    speeds: Array

    def __post_init__(self) -> None:
        for array in vars(self).values():
            read_only(array)

    def __repr__(self) -> str:
        return f"States({self.handles_s.shape[1]} handles at {self.times.size} times)"

    def to_dict(self, handles: Sequence[int] | None = None) -> dict[str, Any]:
        """Times, numbers of the `handles` (all by default), positions and speeds as lists."""
        known = range(self.handles_s.shape[1])
        given = numbers("handles", known if handles is None else handles, kind=int)
        chosen = [whole("handles", handle, 0, known[-1]) for handle in given.ravel().tolist()]
        return {
            "times": self.times.tolist(),
            "handles": chosen,
            "positions": self.positions[:, chosen].tolist(),
            "speeds": self.speeds[:, chosen].tolist(),
        }

    def rows(
        self, handles: Sequence[int] | None = None
    ) -> list[tuple[float, int, float, float, float]]:
        """Time, handle, position and speed for every time and each of the `handles`."""
        times, chosen, positions, speeds = self.to_dict(handles).values()
        rows = []
        for time, *states in zip(times, positions, speeds, strict=True):
            for handle, (x, y), speed in zip(chosen, *states, strict=True):
                rows.append((time, handle, x, y, speed))
        return rows

    def text(self, handles: Sequence[int] | None = None) -> str:
        """Table of `rows`, as `positions` prints it."""
        heads = ("t (s)", text("handle"), "x (m)", "y (m)", text("speed (m/s)"))
        formats = ("10.6g", "6d", "10.6f", "10.6f", "11.6f")
        rows = []
        for time, handle, *values in self.rows(handles):
            # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
            rows.append((time, handle, *(round(value, 6) + 0.0 for value in values)))
        return "\n".join(table(heads, formats, rows))

    def __str__(self) -> str:
        return self.text()

    @cached_property
    def poses(self) -> Array:
        """Pose of every bench, (T, N, 3): centre in m, angle in rad."""
        return read_only(bench_poses(self.positions))

    @cached_property
    def pose_velocities(self) -> Array:
        """Rate of change of `poses`, (T, N, 3): m/s, m/s, rad/s."""
        along = np.diff(as_complex(self.positions))
        spin = (np.diff(as_complex(self.velocities)) / along).imag
        centres = (self.velocities[:, :-1] + self.velocities[:, 1:]) / 2
        return read_only(np.concatenate([centres, spin[..., None]], axis=-1))


@dataclass(frozen=True)
class March:
    """Motion of a dragon along a curve at a given speed; by default the march of the paper.

    Parameters
    ----------
    dragon : Dragon
        The chain of benches. All of it must fit on the curve at t = 0.
    curve : Curve
        The path of the handles. A spiral's pitch must be larger than the benches' width.
    turns : float, optional
        Turn of a spiral at which handle 0 is at t = 0, by default 16.
    start_s : float, optional
        Coordinate in m at which handle 0 is at t = 0, in place of `turns`. By default, on another
        curve than a spiral, the first one at which the whole dragon is on the curve, or 0 if the
        curve comes from infinity.
    speed : float or SpeedTable
        Speed of handle 0, m/s, from 1e-6 to 20. `SpeedTable.of` makes a table of a function.

    Examples
    --------
    >>> states = March().at([0, 60])
    >>> states.positions[:, 0].round(6).tolist()
    [[8.8, -0.0], [5.799209, -5.771092]]
    """

    dragon: Dragon = field(default_factory=Dragon)
    curve: Curve = field(default_factory=Spiral)
    turns: float | None = field(default=None, kw_only=True)
    start_s: float | None = field(default=None, kw_only=True)
    speed: float | SpeedTable = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        instance("dragon", self.dragon, Dragon, "a Dragon")
        required_curve(self.curve)
        if not isinstance(self.speed, SpeedTable):
            vars(self)["speed"] = self.speed_profile.speeds[0]
        widest = float(self.dragon.widths.max())
        turn_width = self.curve.turn_width
        if turn_width is not None and turn_width <= widest:
            raise ParameterError("pitch", turn_width, f"more than the width, {widest:g} m")

        self._check_start()
        if np.isnan(start := self.continuation.start).any():
            raise self._misfit(int(np.isnan(start).argmax()))

    def _check_start(self) -> None:
        """Check `turns` and `start_s`, of which a march has one or none."""
        turns = self.curve.default_turns if self.turns is None else self.turns
        if self.start_s is not None:
            if self.turns is not None:
                raise ParameterError("turns", self.turns, "absent where start_s is given")
            ends = self.curve.begin_s, self.curve.end_s
            vars(self)["start_s"] = finite("start_s", self.start_s, *ends, "m")
        elif turns is not None:
            self.curve.at_turn(turns)
            vars(self)["turns"] = float(turns)

    def _misfit(self, handle: int) -> ParameterError:
        """Error for a march in which a handle has no coordinate at t = 0."""
        if self.turns is None:
            room = "a coordinate with room for the whole dragon behind it"
            bound = f"{room}: handle {handle} has none"
            return ParameterError("start_s", self.head_start, bound)
        name = "head_spacing" if handle == 1 else "body_spacing"
        limit = f"short enough for the curve at turn {self.turns:g}"
        bound = f"{limit}: handle {handle} has no coordinate there"
        return ParameterError(name, getattr(self.dragon, name), bound)

    @cached_property
    def head_start(self) -> float:
        """Coordinate of handle 0 at t = 0, m; an error if the curve has no room for the dragon."""
        if self.start_s is not None:
            return self.start_s
        if self.turns is not None:
            return self.curve.at_turn(self.turns)
        if self.curve.begin_s == -np.inf:
            return min(0.0, self.curve.end_s)

        # The dragon from its tail on: its handles follow each other back along the reversed curve.
        tail = self.curve.begin_s + _CLEAR_OF_BEGIN
        handles_s = Reversed(self.curve).chain([-tail], self.dragon.spacings[::-1])
        head = -float(handles_s[0, -1])
        if np.isnan(head):
            lack = f"{self.curve.end_s - self.curve.begin_s:g} m of it do not"
            bound = f"one that takes the whole dragon: {lack}, or it turns back within a bench"
            raise ParameterError("curve", type(self.curve).__name__, bound)
        return head

    @property
    def end(self) -> float:
        """Time at which handle 0 reaches the end of the curve, s; inf if the curve has no end."""
        return float(self.time(self.curve.end_s - self.head_start))

    def span(self, start: float, until: float) -> tuple[float, float]:
        """Range of coordinates that a picture of the curve shows, m.

        It goes from the begin of the curve to its end, if it has these. Else it begins with the
        last handle at `start` s, or at 0 s if that has none, and ends with handle 0 at `until`.
        """
        start = finite("start", start, -np.inf, np.inf, "s")
        until = finite("until", until, -np.inf, np.inf, "s")
        first, last = self.curve.begin_s, self.curve.end_s
        if first == -np.inf:
            tails = self.motion_or_nan([start, 0.0]).handles_s[:, -1]
            first = float(tails[1] if np.isnan(tails[0]) else tails[0])
        if last == np.inf:
            last = self.head_start + float(self.distance(until))
        return first, last

    @cached_property
    def speed_profile(self) -> SpeedTable:
        """The speed as a table, which converts between times and distances."""
        speed: Any = self.speed
        if isinstance(speed, SpeedTable):
            return speed
        if callable(speed):
            bound = "a number or a table: SpeedTable.of(function, start, until) makes one"
            raise ParameterError("speed", speed, bound)
        return SpeedTable([0.0], [finite("speed", speed, MIN_SPEED, MAX_SPEED, "m/s")])

    @cached_property
    def continuation(self) -> Continuation:
        """The states that continuous motion from t = 0 reaches."""
        return Continuation(self.curve, self.head_start, self.dragon.spacings)

    def at_unit_speed(self) -> March:
        """The march at 1 m/s, not for use in another thread: its times are distances, m."""
        march = March(self.dragon, self.curve, start_s=self.head_start)
        # One continuation for both: no part of the curve is followed twice.
        vars(march)["continuation"] = self.continuation
        return march

    def distance(self, times: ArrayLike) -> Array:
        """Distance (T,) in m that handle 0 has travelled since t = 0; negative before."""
        return self.speed_profile.distance(times)

    def time(self, distances: ArrayLike) -> Array:
        """Times (T,) in s at which handle 0 has travelled the `distances` (T,) in m since t = 0."""
        return self.speed_profile.time(distances)

    def at(self, times: ArrayLike, handles: int | None = None) -> States:
        """Exact states of the first `handles` (all by default) at `times` (T,) in s.

        Earlier calls change nothing. The other times of a call, and the number of handles, may
        change the last digits: positions by some 1e-13 m.

        A time may be so early that the head is 100 km before its start. Where continuous motion has
        ended for a handle, an UnreachableError has the first such time, and the first such handle
        then.
        """
        handles_s, points, tangents, speeds = self.motion(times, handles)
        t = numbers("times", times).flatten()
        # Signed along the path: a head at more than a right angle to its bench pushes the rear
        # handle back.
        speeds *= self.speed_profile.at(t)[:, None]
        tangents.real *= speeds
        tangents.imag *= speeds
        np.abs(speeds, out=speeds)
        return States(t, handles_s, as_vectors(points), as_vectors(tangents), speeds)

    def handles_s(self, times: ArrayLike, handles: int | None = None) -> Array:
        """Arc-length coordinates (T, H) of the handles, m: arguments and errors as for `at`."""
        return self.motion(times, handles).handles_s

    def motion(self, times: ArrayLike, handles: int | None = None) -> ChainMotion:
        """Coordinates, points, tangents and velocity ratios: arguments and errors as for `at`."""
        motion = self.motion_or_nan(times, handles)
        if np.isnan(motion.handles_s[:, -1]).any():
            raise self._unreachable(numbers("times", times).ravel(), motion.handles_s)
        return motion

    def motion_or_nan(self, times: ArrayLike, handles: int | None = None) -> ChainMotion:
        """What `motion` returns, but nan for handles without a coordinate and all behind them."""
        t = numbers("times", times).flatten()
        travelled = self.distance(t)
        bad = ~(np.isfinite(t) & (travelled >= -_MAX_RETREAT))
        if bad.any():
            earliest = float(self.time(-_MAX_RETREAT))
            bound = f"finite numbers, at least {earliest:g} s"
            raise ParameterError("times", t[bad][0].item(), bound)

        most = self.dragon.handles
        number = most if handles is None else whole("handles", handles, 1, most)
        heads = self.head_start + travelled
        beyond = heads > self.curve.end_s
        if beyond.any():
            # Rounding may put a head past the end.
            heads[beyond] = np.where(t[beyond] <= self.end, self.curve.end_s, np.nan)
        return self.continuation.motion(heads, number)

    def speeds_by_difference(self, times: ArrayLike, step: float) -> Array:
        """Speeds (T, H), m/s, on a spiral by a forward difference over `step` s (paper, eq. 15)."""
        positive("step", step, np.inf, "s")
        t = numbers("times", times).ravel()
        curve = self.curve
        if not isinstance(curve, Spiral):
            raise ParameterError("curve", type(curve).__name__, "a Spiral, which has polar angles")
        now = curve.angle(self.handles_s(t))
        later = curve.angle(self.handles_s(t + step))
        return np.asarray(curve.k * np.hypot(now, 1) * np.abs(later - now) / step)

    def _unreachable(self, times: Array, handles_s: Array) -> UnreachableError:
        """Error for the first time at which a handle has no coordinate, and the first such one."""
        lost = np.isnan(handles_s)
        affected = np.flatnonzero(lost[:, -1])
        row = affected[times[affected].argmin()]

        handle = int(lost[row].argmax())
        if handle == 0:
            verb, limit = "ends", self.curve.end_s
            if self.distance(times[row]) < 0:
                verb, limit = "begins", self.curve.begin_s
            then = float(self.time(limit - self.head_start))
            reason = f"the curve {verb} at t = {then:.6g} s"
        else:
            spacing = self.dragon.spacings[handle - 1]
            reason = f"the curve bends too tightly for a spacing of {spacing:g} m"
            if handles_s[row, handle - 1] - self.curve.begin_s < spacing:
                near = f"less than a spacing of {spacing:g} m"
                reason = f"the curve begins {near} behind handle {handle - 1}"

        return UnreachableError(float(times[row]), handle, reason)


def check_march(value: object) -> None:
    """Raise a ParameterError if `value` is no march."""
    instance("march", value, March, "a March")


def states_while_reachable(
    march: March, batches: Iterable[Array], handles: int | None = None
) -> Iterator[States]:
    """States at rising times, which come in batches, until the chain has none."""
    for times in batches:
        try:
            yield march.at(times, handles)
        except UnreachableError as error:
            yield march.at(times[times < error.time], handles)
            return


def last_reachable(march: March, begin: float, later: float, handles: int, nearest: float) -> float:
    """Last time of a state of the first `handles`, s, to `nearest`: there is one at `begin`."""
    while later - begin > nearest and begin < (begin + later) / 2 < later:
        times = np.linspace(begin, later, _LAST_POINTS)
        # If a handle has no coordinate, the last one has none.
        lost = np.isnan(march.motion_or_nan(times, handles).handles_s[:, -1])
        if not lost[-1]:
            return later
        first = max(1, int(lost.argmax()))
        begin, later = times[first - 1 : first + 1].tolist()
    return begin


def checked_times(march: March, start: float, until: float | None) -> tuple[float, float]:
    """`start` and `until` as floats; a `ParameterError` if `until` is not after `start`.

    By default, and where `until` is later than the end of the curve by rounding only, it is the
    end.
    """
    check_march(march)
    start = finite("start", start, -MAX_TIME, MAX_TIME, "s")
    if until is None:
        if march.end == np.inf:
            raise ParameterError("until", None, "a time, s, on a curve without end")
        if start >= march.end:
            bound = f"earlier than the end of the curve, {march.end:g} s"
            raise ParameterError("start", start, bound)
        return start, march.end

    until = finite("until", until, -MAX_TIME, MAX_TIME, "s")
    if until <= start:
        raise ParameterError("until", until, f"later than the start, {start:g} s")
    same = math.isclose(until, march.end, rel_tol=_SAME_TIME, abs_tol=_SAME_TIME)
    return start, min(until, march.end) if same else until
