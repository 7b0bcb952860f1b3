"""The state of a dragon at one time, as pictures need it."""

from __future__ import annotations

from dataclasses import dataclass

from pymunk_dragon._arrays import Array

Vector = tuple[float, float]


@dataclass(frozen=True)
class Touch:
    """Contact of two benches: points in m, and the unit normal from the first bench to the second."""

    points: tuple[Vector, ...]
    normal: Vector


@dataclass(frozen=True)
class Snapshot:
    """State of a dragon of N benches at one time.

    Attributes
    ----------
    time : float
        Simulated time, s.
    poses : ndarray, shape (N, 3)
        Centres in m and angles in rad.
    velocities : ndarray, shape (N + 1, 2), or None
        Velocities of the handles, m/s, if an overlay needs them.
    impulses : ndarray, shape (N - 1,), or None
        Impulses in the joints, N s, if an overlay needs them.
    touches : tuple of Touch
        Contacts of benches, if an overlay needs them.
    displaced : ndarray, shape (N, 3), or None
        In the exact model beside a run: poses with the run's position errors, magnified.
    error : float or None
        Largest position error there, m, of the benches that decide the magnification.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> from pymunk_dragon.drawing import Snapshot
    >>> march = March()
    >>> Snapshot(time=60.0, poses=march.at(60.0).poses[0]).poses.shape
    (223, 3)
    """

    time: float
    poses: Array
    velocities: Array | None = None
    impulses: Array | None = None
    touches: tuple[Touch, ...] = ()
    displaced: Array | None = None
    error: float | None = None
