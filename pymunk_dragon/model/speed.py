"""Speed of the head over time, as a table that is linear between its entries.

A number is a table of one entry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import finite, numbers, positive, within
from pymunk_dragon._files import number_rows
from pymunk_dragon.errors import FileFormatError, ParameterError

# m/s: a thousandth of a snail's speed.
MIN_SPEED = 1e-6
# m/s: more than the 13 m/s of sprinters.
MAX_SPEED = 20.0
# s, thirty years. At this time a double still resolves microseconds.
MAX_TIME = 1e9
# s or m. Larger times and distances count as infinite; at this one a double resolves 0.1 s or m.
_FARTHEST = 1e15
# s. Smallest time between entries; faster changes of speed are jumps.
_MIN_STEP = 1e-6
# Entries of the table of a function, which take some 100 MB.
_MAX_ENTRIES = 1_000_000


@dataclass(frozen=True)
class SpeedTable:
    """Speed of handle 0: linear between some times, constant before the first and after the last.

    Parameters
    ----------
    times : sequence of float
        Times in s, from -1e9 to 1e9, each at least a microsecond later than the one before.
    speeds : sequence of float
        Speed at each of them, m/s, from 1e-6 to 20.

    Examples
    --------
    >>> SpeedTable([0, 10], [1, 3]).at([-5.0, 5.0, 50.0]).tolist()
    [1.0, 2.0, 3.0]
    """

    times: Sequence[float]
    speeds: Sequence[float]

    def __post_init__(self) -> None:
        limits = {"times": (-MAX_TIME, MAX_TIME, "s"), "speeds": (MIN_SPEED, MAX_SPEED, "m/s")}
        for name, bounds in limits.items():
            given = getattr(self, name)
            values = numbers(name, given)
            if values.ndim != 1 or not values.size:
                raise ParameterError(name, given, "a sequence of at least one number")
            entries = enumerate(values.tolist())
            checked = (finite(f"{name}[{i}]", value, *bounds) for i, value in entries)
            vars(self)[name] = tuple(checked)

        if len(self.times) != len(self.speeds):
            raise ParameterError("speeds", self.speeds, f"as many as the times, {len(self.times)}")
        close = np.diff(self.times) < _MIN_STEP
        if close.any():
            i = int(close.argmax())
            before = f"the time before it, {self.times[i]:g} s"
            bound = f"later than {before}, by {_MIN_STEP:g} s or more"
            raise ParameterError(f"times[{i + 1}]", self.times[i + 1], bound)

    @classmethod
    def of(
        cls, function: Callable[[float], float], start: float, until: float, step: float = 0.01
    ) -> SpeedTable:
        """Table of a function from a time in s to a speed in m/s, from `start` to `until`, s.

        It has an entry every `step` s. Choose a step in which the speed changes little: the march
        goes at the speed of the table exactly, which differs from the function by step**2 / 8 times
        the function's second derivative.

        Examples
        --------
        >>> import math
        >>> float(SpeedTable.of(lambda t: 1 + 0.3 * math.sin(t), -10, 450).at(60).round(6))
        0.908557
        """
        begin = finite("start", start, -MAX_TIME, MAX_TIME, "s")
        end = finite("until", until, -MAX_TIME, MAX_TIME, "s")
        length = positive("until", end - begin, np.inf, "s after start")

        shortest = max(_MIN_STEP, length / _MAX_ENTRIES)
        steps = int(np.ceil(length / finite("step", step, shortest, length, "s")))
        times = np.linspace(begin, begin + length, steps + 1)
        try:
            speeds = [float(function(time)) for time in times.tolist()]
        except (TypeError, ValueError, ArithmeticError) as error:
            bound = f"a function from s to m/s ({error})"
            raise ParameterError("function", function, bound) from error
        return cls(times.tolist(), speeds)

    @classmethod
    def read(cls, path: str | Path) -> SpeedTable:
        """Table from a CSV file: a time in s and a speed in m/s on each line.

        A line of names may stand before them.
        """
        lines, rows = number_rows(path, "speed", ("a time in s", "a speed in m/s"))
        try:
            return cls(*zip(*rows, strict=True))
        except ParameterError as error:
            entry = error.name.partition("[")[2].rstrip("]")
            raise FileFormatError(path, f"line {lines[int(entry)]}: {error}") from error

    def at(self, t: ArrayLike) -> Array:
        """Speed (T,), m/s, at times `t` (T,) in s."""
        return np.asarray(np.interp(numbers("t", t), *self._knots[:2]))

    def acceleration(self, t: ArrayLike) -> Array:
        """Rate of change (T,) of the speed, m/s^2, at times `t` (T,) in s; at an entry, after it.

        Examples
        --------
        >>> SpeedTable([0, 10], [1, 3]).acceleration([-1.0, 0.0, 5.0, 10.0]).tolist()
        [0.0, 0.2, 0.2, 0.0]
        """
        times, _, accelerations, _ = self._knots
        known = np.concatenate([[0.0], accelerations])
        return np.asarray(known[np.searchsorted(times, numbers("t", t), side="right")])

    def distance(self, t: ArrayLike) -> Array:
        """Distance (T,), m, travelled from time 0 to `t` (T,) in s; negative before 0."""
        t = _rounded(numbers("t", t))
        # Most tables have one entry; the general way takes twenty times as long.
        if len(self.speeds) == 1:
            return np.asarray(self.speeds[0] * t)
        times, speeds, accelerations, distances = self._knots
        i = np.maximum(np.searchsorted(times, t, side="right") - 1, 0)
        gone = np.where(np.isfinite(t), t - times[i], 0.0)
        # Before the first entry the speed is constant; between two, the distance is a quadratic.
        acceleration = np.where(gone < 0, 0.0, accelerations[i])
        travelled = distances[i] + gone * (speeds[i] + acceleration * gone / 2)
        return np.where(np.isfinite(t), travelled, t)

    def time(self, distance: ArrayLike) -> Array:
        """Times (T,), s, at which a `distance` (T,), m, is reached: the inverse of `distance`."""
        distance = _rounded(numbers("distance", distance))
        times, speeds, accelerations, distances = self._knots
        i = np.maximum(np.searchsorted(distances, distance, side="right") - 1, 0)
        is_finite = np.isfinite(distance)
        gone = np.where(is_finite, distance - distances[i], 0.0)
        # The root of the quadratic, in the form without cancellation.
        acceleration = np.where(gone < 0, 0.0, accelerations[i])
        square = speeds[i] ** 2 + 2 * acceleration * gone
        then = np.sqrt(np.maximum(square, MIN_SPEED**2))
        return np.where(is_finite, times[i] + 2 * gone / (speeds[i] + then), distance)

    def fastest(self, start: float, until: float) -> float:
        """Largest speed, m/s, from `start` to `until`, s."""
        ends = within("start and until", numbers("times", [start, until]), -np.inf, np.inf, "s")
        times, speeds, *_ = self._knots
        between = speeds[(ends[0] < times) & (times < ends[1])]
        return float(np.append(self.at(ends), between).max())

    @cached_property
    def _knots(self) -> tuple[Array, Array, Array, Array]:
        """Times, speeds, accelerations after each (m/s^2) and distances, (K,) each.

        They are those of the entries and of time 0.
        """
        # `np.unique` would import masked arrays, here and in what every march needs.
        times = np.array(sorted({*self.times, 0.0}))
        speeds = np.interp(times, self.times, self.speeds)
        # Between entries, which are no less than a microsecond apart; the time 0 may be next to
        # one.
        slopes = np.diff(self.speeds) / np.diff(self.times)
        slopes = np.concatenate([[0.0], slopes, [0.0]])
        accelerations = slopes[np.searchsorted(self.times, times, side="right")]
        steps = np.diff(times) * (speeds[:-1] + speeds[1:]) / 2

        # From time 0 in both directions: a table that begins long before must not add rounding
        # errors near 0.
        zero = int(np.searchsorted(times, 0.0))
        before = -np.cumsum(steps[:zero][::-1])[::-1]
        distances = np.concatenate([before, [0.0], np.cumsum(steps[zero:])])
        return times, speeds, accelerations, distances


def _rounded(values: Array) -> Array:
    """`values`, of which those that are too large are infinite."""
    return np.where(np.abs(values) > _FARTHEST, np.copysign(np.inf, values), values)
