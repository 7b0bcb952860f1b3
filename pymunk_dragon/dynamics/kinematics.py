"""Accelerations of handles on the path, and times at which they jump."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon._extras import library
from pymunk_dragon.model.march import March

# Shortest spacings that the head travels between samples in which a handle's passage of a
# coordinate is found: two passages within one, there and back, would be missed.
_SAMPLE_STRIDE = 0.25
# m of the head's travel. Cuts that are no further apart are one; rounding errors of coordinates
# are far smaller, and what the jump changes in between is far below any tolerance.
_CUT_WIDTH = 1e-9
# Last digits of a time: at least so many.
_CUT_DIGITS = 4096


class HandleMotion(NamedTuple):
    """Positions, velocities and accelerations (T, H) of handles: m, m/s, m/s^2.

    The unit tangents (T, H) are those of the path.
    """

    points: Complex
    tangents: Complex
    velocities: Complex
    accelerations: Complex


def handle_motion(march: March, times: Array, handles: int) -> HandleMotion:
    """Motion (T, H) of the first `handles` at times (T,), s.

    Where an acceleration jumps, it is the one after the jump. With A the acceleration of a front
    handle, e the vector from the rear handle to it, D their difference of velocities, and T and N
    tangent and normal of the path at the rear handle, whose speed v changes at the rate a, the
    length of e stays if e . (A - a T - k v^2 N) + D^2 = 0.
    """
    path = march.motion(times, handles)
    table = march.speed_profile
    speeds = path.ratios * table.at(times)[:, None]
    velocities = path.tangents * speeds
    curvature = march.curve.curvature(path.handles_s)
    accelerations = curvature * speeds**2 * (1j * path.tangents)
    accelerations[:, 0] += table.acceleration(times) * path.tangents[:, 0]

    benches = path.points[:, :-1] - path.points[:, 1:]
    spread = np.abs(np.diff(velocities, axis=1)) ** 2
    behind = dot(benches, path.tangents[:, 1:])
    for j in range(handles - 1):
        ahead = accelerations[:, j] - accelerations[:, j + 1]
        change = (dot(benches[:, j], ahead) + spread[:, j]) / behind[:, j]
        accelerations[:, j + 1] += change * path.tangents[:, j + 1]
    return HandleMotion(path.points, path.tangents, velocities, accelerations)


def dot(one: Complex, two: Complex) -> Array:
    """Scalar products of vectors that are complex numbers."""
    return (one.conj() * two).real


def cuts(march: March, start: float, until: float, handles: int) -> list[float]:
    """Times from `start` to `until`, s, between which the motion of `handles` is smooth.

    They are those at which one of the handles passes a jump of the curvature, and the entries of
    the table of speeds.
    """
    table = march.speed_profile
    found = [start, until, *table.times]
    stride = _SAMPLE_STRIDE * float(march.dragon.spacings.min())
    times = even_times(march, start, until, stride)
    coordinates = march.handles_s(times, handles)
    for jump in march.curve.curvature_jumps:
        passed = coordinates >= jump
        for row, handle in np.argwhere(passed[1:] != passed[:-1]).tolist():
            found.append(_passage(march, jump, handle, times[row], times[row + 1]))

    width = cut_width(march, start, until)
    kept = [start]
    for time in sorted(found):
        if kept[-1] + width < time < until - width:
            kept.append(time)
    return [*kept, until]


def cut_width(march: March, start: float, until: float) -> float:
    """Shortest duration, s, of an interval between cuts from `start` to `until`, s."""
    digits = _CUT_DIGITS * float(np.spacing(max(abs(start), abs(until))))
    return max(_CUT_WIDTH / march.speed_profile.fastest(start, until), digits)


def even_times(march: March, start: float, until: float, stride: float) -> Array:
    """Times from `start` to `until`, s, in which the head travels at most `stride`, m."""
    begin, end = march.distance([start, until]).tolist()
    travelled = np.linspace(begin, end, 2 + int((end - begin) / stride))
    times = np.clip(march.time(travelled), start, until)
    times[[0, -1]] = start, until
    return times


def _passage(march: March, s: float, handle: int, low: float, high: float) -> float:
    """Time between two, s, at which a handle has the coordinate `s`, m."""

    def ahead(time: float) -> float:
        return float(march.handles_s(time, handle + 1)[0, -1]) - s

    root = library("scipy.optimize").brentq
    return float(root(ahead, low, high, xtol=np.spacing(max(abs(low), abs(high)))))
