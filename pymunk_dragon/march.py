"""Exact kinematics: where every handle of a dragon on a curve is, and how fast (paper, eq. 1-15)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymunk_dragon.checks import finite, positive, whole
from pymunk_dragon.curves import Curve, Spiral
from pymunk_dragon.display import Displayed
from pymunk_dragon.dragon import Dragon, bench_poses
from pymunk_dragon.errors import ParameterError, UnreachableError
from pymunk_dragon.speed import MAX_SPEED, MIN_SPEED

__all__ = ["March", "States"]

Array = NDArray[np.float64]

# A thousand turns of the contest's pitch are a dance floor of a kilometre; more is a slip of the finger.
MAX_TURNS = 1000.0
# Metres before the start, a day's march. So far out a double still tells places 0.1 nm apart.
MAX_RETREAT = 1e5


@dataclass(frozen=True)
class States:
    """A dragon at T times: H handles, N = H - 1 benches.

    Attributes
    ----------
    times : ndarray, shape (T,)
        s.
    parameters : ndarray, shape (T, H)
        The handles' places on the curve, in the curve's own parameter.
    positions, velocities : ndarray, shape (T, H, 2)
        m and m/s.
    speeds : ndarray, shape (T, H)
        Lengths of the velocities, m/s.
    """

    times: Array
    parameters: Array
    positions: Array
    velocities: Array
    speeds: Array

    def __post_init__(self) -> None:
        for array in (self.times, self.parameters, self.positions, self.velocities, self.speeds):
            array.flags.writeable = False

    @cached_property
    def poses(self) -> Array:
        """Pose of every bench, (T, N, 3): centre in m, angle in rad."""
        return bench_poses(self.positions)

    @cached_property
    def pose_velocities(self) -> Array:
        """Rate of change of `poses`, (T, N, 3): m/s, m/s, rad/s."""
        front, rear = self.velocities[:, :-1], self.velocities[:, 1:]
        along = self.positions[:, :-1] - self.positions[:, 1:]
        turning = front - rear
        spin = along[..., 0] * turning[..., 1] - along[..., 1] * turning[..., 0]
        spin /= np.sum(along**2, axis=-1)
        return np.concatenate([(front + rear) / 2, spin[..., None]], axis=-1)


@dataclass(frozen=True)
class March(Displayed):
    """A dragon on a curve at a speed; by default the march of the paper.

    Parameters
    ----------
    dragon : Dragon
        What marches.
    curve : Curve
        What it marches on.
    turns : float
        Turn of the curve on which handle 0 stands at t = 0; 16 is the contest's (8.8, 0) m.
    speed : float
        Speed of handle 0, m/s.

    Raises
    ------
    ParameterError
        If `dragon` is no `Dragon` or `curve` no `Curve`, if `turns` is not a number above 0 and at most 1000 or
        `speed` not one from 1e-6 to 20 m/s, if the curve's turns are no further apart than the benches are
        wide, or if the curve cannot take the dragon at t = 0.
    """

    dragon: Dragon = field(default_factory=Dragon)
    curve: Curve = field(default_factory=Spiral)
    turns: float = field(default=16.0, kw_only=True)
    speed: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        if not isinstance(self.dragon, Dragon):
            raise ParameterError("dragon", self.dragon, "a Dragon")
        if not isinstance(self.curve, Curve):
            raise ParameterError("curve", self.curve, "a Curve")
        object.__setattr__(self, "turns", positive("turns", self.turns, MAX_TURNS, ""))
        object.__setattr__(self, "speed", finite("speed", self.speed, MIN_SPEED, MAX_SPEED, "m/s"))
        widest = float(self.dragon.widths.max())
        if self.curve.turn_distance <= widest:
            raise ParameterError("pitch", self.curve.turn_distance, f"more than the width, {widest:g} m")
        try:
            self.parameters(0.0)
        except UnreachableError as error:
            name = "head_spacing" if error.handle == 1 else "body_spacing"
            bound = f"short enough for the curve at turn {self.turns:g}: handle {error.handle} has no place there"
            raise ParameterError(name, getattr(self.dragon, name), bound) from error

    @property
    def end(self) -> float:
        """Time at which handle 0 reaches the end of the curve, s."""
        return float(self.curve.remaining(self.curve.start(self.turns))) / self.speed

    def parameters(self, times: ArrayLike, handles: int | None = None) -> Array:
        """Places (T, H) of the first `handles` (all by default) at `times` (T,), in the curve's own parameter.

        Raises
        ------
        ParameterError
            If a time is no finite number, or so early that the head would stand more than 100 km before its start.
        UnreachableError
            If a handle has no place on the curve: the first such time, and the first such handle then.
        """
        t = self._checked(times)
        places = self.places(t, handles)
        lost = np.isnan(places)
        if lost.any():
            self._raise_unreachable(t, lost)
        return places

    def places(self, times: ArrayLike, handles: int | None = None) -> Array:
        """What `parameters` gives, with nan for handles that have no place on the curve, and for all behind them.

        Raises
        ------
        ParameterError
            As `parameters` does.
        """
        t = self._checked(times)
        spacings = self.dragon.spacings
        if handles is not None:
            spacings = spacings[: whole("handles", handles, 1, self.dragon.handles) - 1]
        places = np.empty((t.size, spacings.size + 1))
        begin, end = self.curve.start(self.turns), self.end
        # No time after the end makes a difference, and a distance of 1e308 m does not fit into a double; nor does
        # rounding carry the head past the end before its time.
        gone = self.speed * np.minimum(t, 2 * end)
        gone = np.where(t <= end, np.minimum(gone, self.curve.remaining(begin)), gone)
        places[:, 0] = self.curve.advance(begin, gone)
        for i, spacing in enumerate(spacings):
            places[:, i + 1] = self.curve.behind(places[:, i], spacing)
        return places

    def _checked(self, times: ArrayLike) -> Array:
        """A copy of `times` as an array (T,) in s."""
        try:
            t = np.array(times, dtype=float).ravel()
        except (TypeError, ValueError, OverflowError) as error:
            raise ParameterError("times", times, "finite numbers, s") from error
        earliest = -MAX_RETREAT / self.speed
        bad = ~(np.isfinite(t) & (t >= earliest))
        if bad.any():
            raise ParameterError("times", t[bad][0].item(), f"finite numbers, at least {earliest:g} s")
        return t

    def _raise_unreachable(self, times: Array, lost: NDArray[np.bool_]) -> None:
        affected = np.flatnonzero(lost.any(axis=1))
        row = affected[np.argmin(times[affected])]
        handle = int(np.argmax(lost[row]))
        if handle == 0:
            reason = f"the curve ends at t = {self.end:.6g} s"
        else:
            spacing = self.dragon.spacings[handle - 1]
            reason = f"the curve bends too tightly for a spacing of {spacing:g} m"
        raise UnreachableError(float(times[row]), handle, reason)

    def at(self, times: ArrayLike, handles: int | None = None) -> States:
        """Exact states of the first `handles` (all by default) at `times` (T,) in s.

        Velocities follow from the rigid bench: both its holes have the same velocity component along it (the exact
        form of eq. 14).

        Raises
        ------
        ParameterError, UnreachableError
            As `parameters` does.
        """
        t = self._checked(times)
        places = self.parameters(t, handles)
        positions, tangents = self.curve.point(places), self.curve.tangent(places)
        along = positions[:, :-1] - positions[:, 1:]
        front = np.sum(tangents[:, :-1] * along, axis=-1)
        rear = np.sum(tangents[:, 1:] * along, axis=-1)
        # Signed along the path: a head that has come more than square across its bench pushes it back out.
        rates = np.empty(places.shape)
        rates[:, 0] = self.speed
        rates[:, 1:] = self.speed * np.cumprod(front / rear, axis=1)
        return States(t, places, positions, rates[..., None] * tangents, np.abs(rates))

    def speeds_by_difference(self, times: ArrayLike, step: float) -> Array:
        """Speeds (T, H) in m/s by the paper's forward difference over `step` s (eq. 15), for comparison.

        The curve parameter's rate of change is approximated by (u(t + step) - u(t)) / step, and the speed is that
        rate times the arc length per unit of u. The error falls in proportion to `step`.
        """
        positive("step", step, np.inf, "s")
        t = self._checked(times)
        now, later = self.parameters(t), self.parameters(t + step)
        return self.curve.stretch(now) * np.abs(later - now) / step
