"""Speed profile given by a table over time, linear between its entries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._checks import finite
from pymunk_dragon._files import number_rows
from pymunk_dragon.errors import FileFormatError, ParameterError
from pymunk_dragon.model.speed.base import MAX_SPEED, MIN_SPEED, Array, largest_between

__all__ = ["SpeedTable"]

# s, thirty years. At this time a double still resolves microseconds.
MAX_TIME = 1e9
# s. Smallest time between entries; faster changes of speed are jumps.
MIN_STEP = 1e-6


@dataclass(frozen=True)
class SpeedTable:
    """The speed of handle 0 at some times: linear between them, constant before the first and after the last.

    Parameters
    ----------
    times : sequence of float
        Times in s, each later than the one before.
    speeds : sequence of float
        Speed at each of them, m/s.

    Raises
    ------
    ParameterError
        If there is no entry, not one speed to each time, a time that is not a microsecond later than the one before or
        no number from -1e9 to 1e9 s, or a speed that is not a number from 1e-6 to 20 m/s.

    Examples
    --------
    >>> SpeedTable([0, 10], [1, 3]).at([-5.0, 5.0, 50.0]).tolist()
    [1.0, 2.0, 3.0]
    """

    times: Sequence[float]
    speeds: Sequence[float]

    def __post_init__(self) -> None:
        for name in ("times", "speeds"):
            object.__setattr__(self, name, _entries(name, getattr(self, name)))
        if len(self.times) != len(self.speeds):
            raise ParameterError("speeds", self.speeds, f"as many as the times, {len(self.times)}")
        for i, (before, after) in enumerate(pairwise(self.times)):
            if after - before < MIN_STEP:
                # The same time twice would be a jump.
                bound = f"later than the time before it, {before:g} s, by {MIN_STEP:g} s or more"
                raise ParameterError(f"times[{i + 1}]", after, bound)

    @classmethod
    def read(cls, path: str | Path) -> SpeedTable:
        """Table from a CSV file: a time in s and a speed in m/s on each line, after a line of names or none.

        Raises
        ------
        ParameterError
            If the file cannot be read.
        FileFormatError
            If it is no such table: the first line that is wrong, and what should stand there.
        """
        lines, rows = number_rows(path, "speed", ("a time in s", "a speed in m/s"))
        try:
            return cls(*zip(*rows, strict=True))
        except ParameterError as error:
            entry = error.name.partition("[")[2].rstrip("]")
            raise FileFormatError(path, f"line {lines[int(entry)]}: {error}") from error

    def at(self, t: ArrayLike) -> Array:
        """As in `Speed`."""
        return np.asarray(np.interp(np.asarray(t, dtype=float), self.times, self.speeds))

    def distance(self, t: ArrayLike) -> Array:
        """As in `Speed`: exact, a quadratic between two entries."""
        t = np.asarray(t, dtype=float)
        times, speeds, growths, distances = self._knots
        i = np.maximum(np.searchsorted(times, t, side="right") - 1, 0)
        gone = np.where(np.isfinite(t), t - times[i], 0.0)
        growth = np.where(gone < 0, 0.0, growths[i])
        return np.where(np.isfinite(t), distances[i] + gone * (speeds[i] + growth * gone / 2), t)

    def time(self, distance: ArrayLike) -> Array:
        """As in `Speed`."""
        distance = np.asarray(distance, dtype=float)
        times, speeds, growths, distances = self._knots
        i = np.maximum(np.searchsorted(distances, distance, side="right") - 1, 0)
        gone = np.where(np.isfinite(distance), distance - distances[i], 0.0)
        # The root of the quadratic, in the form without cancellation.
        growth = np.where(gone < 0, 0.0, growths[i])
        then = np.sqrt(np.maximum(speeds[i] ** 2 + 2 * growth * gone, MIN_SPEED**2))
        return np.where(np.isfinite(distance), times[i] + 2 * gone / (speeds[i] + then), distance)

    def fastest(self, t0: ArrayLike, t1: ArrayLike) -> Array:
        """As in `Speed`: the largest speed itself."""
        t0, t1 = np.broadcast_arrays(np.asarray(t0, dtype=float), np.asarray(t1, dtype=float))
        first, last = np.searchsorted(self.times, t0), np.searchsorted(self.times, t1)
        between = largest_between(np.asarray(self.speeds), first.ravel(), last.ravel()).reshape(t0.shape)
        return np.maximum(np.maximum(self.at(t0), self.at(t1)), between)

    @cached_property
    def _knots(self) -> tuple[Array, Array, Array, Array]:
        """Times, speeds, accelerations after each (m/s^2) and distances, (K,) each: of the entries and of time 0."""
        times = np.unique([*self.times, 0.0])
        speeds = self.at(times)
        # Between entries, which are no less than a microsecond apart; the time 0 may be next to one.
        slopes = np.concatenate([[0.0], np.diff(self.speeds) / np.diff(self.times), [0.0]])
        growths = slopes[np.searchsorted(self.times, times, side="right")]
        steps = np.diff(times) * (speeds[:-1] + speeds[1:]) / 2
        # From time 0 in both directions: a table that begins long before must not add rounding errors near 0.
        zero = int(np.searchsorted(times, 0.0))
        distances = np.concatenate([-np.cumsum(steps[:zero][::-1])[::-1], [0.0], np.cumsum(steps[zero:])])
        return times, speeds, growths, distances


def _entries(name: str, values: object) -> tuple[float, ...]:
    """`values` as a tuple of floats, all within their bounds."""
    bounds = (-MAX_TIME, MAX_TIME, "s") if name == "times" else (MIN_SPEED, MAX_SPEED, "m/s")
    if isinstance(values, str | bytes) or not isinstance(values, Sequence | np.ndarray) or not len(values):
        raise ParameterError(name, values, "a sequence of at least one number")
    return tuple(finite(f"{name}[{i}]", value, *bounds) for i, value in enumerate(values))
