"""The handles that dancers keep on the path, in a time interval in which their motion is smooth."""

from __future__ import annotations

from typing import Any

import numpy as np

from pymunk_dragon._arrays import Array, Complex, as_complex, as_vectors
from pymunk_dragon._extras import library
from pymunk_dragon.dynamics.kinematics import cut_width, even_times, handle_motion
from pymunk_dragon.model.march import March

# Degree of the splines in time.
_DEGREE = 7
# Shortest spacings that the head travels between the first samples of a spline.
_STRIDE = 0.5
# Least number of intervals between samples.
_LEAST_INTERVALS = 16
# Halvings of the intervals until the spline is given up, and every state is computed by itself: on
# a curve of the user's own with a jump of the curvature that it does not declare.
_HALVINGS = 5
# Error of a spline, as a share of the integrator's tolerance and of the largest value.
_SHARE = 1e-2
# Least such error: rounding errors of accelerations, which a spline enlarges at its ends.
_ROUNDING = 2e-12


class Leader:
    """Motion of the first handles of a march from `begin` to `end`, s.

    It is computed for many times at once and interpolated, because the curve takes as long for one
    time as for a hundred.
    """

    def __init__(
        self,
        march: March,
        handles: int,
        drag_rate: float,
        window: tuple[float, float],
        tolerance: float,
    ) -> None:
        self._march = march
        self._handles = handles
        self._drag_rate = drag_rate
        begin, end = window
        # At a jump the samples have the values of this side of it.
        width = min(cut_width(march, begin, end), (end - begin) / 4)
        self._begin = begin + width
        self._end = end - width
        self._points, self._lead = self._splines(max(_SHARE * tolerance, _ROUNDING))
        self._rates: Any = self._points and self._points.derivative()

    def lead(self, time: float) -> complex:
        """V' + c V of the last handle at a time, m/s^2, with the rate c of the drag."""
        if self._lead is None:
            return complex(self._values(np.clip([time], self._begin, self._end))[0, -1])
        x, y = self._lead(time)
        return complex(x, y)

    def handles(self, times: Array) -> tuple[Complex, Complex]:
        """Positions and velocities (T, H) of the handles at times (T,), m and m/s."""
        if self._points is None:
            motion = handle_motion(self._march, times, self._handles)
            return motion.points, motion.velocities
        shape = (times.size, self._handles, 2)
        points = np.reshape(self._points(times), shape)
        return as_complex(points), as_complex(np.reshape(self._rates(times), shape))

    def _values(self, times: Array) -> Complex:
        """Positions of the handles, and what `lead` returns, (T, H + 1)."""
        motion = handle_motion(self._march, times, self._handles)
        lead = motion.accelerations[:, -1] + self._drag_rate * motion.velocities[:, -1]
        return np.column_stack([motion.points, lead])

    def _splines(self, share: float) -> tuple[Any, Any]:
        """Splines of the positions and of `lead`, right to a share of their largest values.

        None and None if so many samples do not suffice.
        """
        interpolate = library("scipy.interpolate").make_interp_spline
        shortest = float(self._march.dragon.spacings.min())
        stride = _STRIDE * shortest
        # m/s^2: a head that turns within its bench has this acceleration.
        least = self._march.speed_profile.fastest(self._begin, self._end) ** 2 / shortest
        count = even_times(self._march, self._begin, self._end, stride).size
        intervals = max(count, _LEAST_INTERVALS)
        for _ in range(_HALVINGS):
            times = np.linspace(self._begin, self._end, 2 * intervals + 1)
            values = as_vectors(self._values(times)).reshape(times.size, -1)
            # Every second sample is left out, and shows the error.
            spline = interpolate(times[::2], values[::2], k=_DEGREE)
            errors = np.abs(spline(times[1::2]) - values[1::2]).max(axis=0)
            sizes = np.abs(values).max(axis=0)
            exact = errors[:-2].max() <= share * sizes[:-2].max()
            if exact and errors[-2:].max() <= share * max(sizes[-2:].max(), least):
                points = interpolate(times, values[:, :-2], k=_DEGREE)
                return points, interpolate(times, values[:, -2:], k=_DEGREE)
            intervals *= 2
        return None, None
