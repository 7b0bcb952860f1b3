"""Forces in the joints of a dragon that dancers keep on its path."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pymunk_dragon._arrays import Array, Complex
from pymunk_dragon._checks import finite, flag, numbers
from pymunk_dragon.dynamics.equations import DRAG, MAX_DRAG
from pymunk_dragon.dynamics.kinematics import dot, handle_motion
from pymunk_dragon.model.march import March, check_march


def joint_forces(march: March, times: ArrayLike, *, drag: float = DRAG, push: bool = True) -> Array:
    """Forces in the joints of a dragon whose dancers keep every hole on the path.

    A rail holds the rear hole of each bench, as in `simulate`: without it, and with a rail on the
    front hole in its place, the joints would have other forces. At a time at which an acceleration
    jumps, they are those after the jump.

    Parameters
    ----------
    march : March
        The motion.
    times : array_like, shape (T,)
        Times, s.
    drag : float
        Ground drag on the benches, per metre marched, as in `EngineSettings`: velocities decay at
        this rate times the highest speed of the head between the first and the last of the times.
    push : bool
        Whether the dancers give each bench the part of the force that is along it, and the torque;
        otherwise all of it comes through the joints and the rails.

    Returns
    -------
    ndarray, shape (T, N - 1)
        Size of the force between benches i and i + 1, N.

    Raises
    ------
    UnreachableError
        If the dragon has no state at one of the times.

    Examples
    --------
    >>> from pymunk_dragon import March, joint_forces
    >>> joint_forces(March(), [5, 100, 400])[:, 0].round(3).tolist()
    [0.753, 0.851, 2.376]
    >>> joint_forces(March(), [5], push=False)[0, 0].round(-2).item()
    33700.0
    """
    check_march(march)
    t = numbers("times", times).ravel()
    drag = finite("drag", drag, 0.0, MAX_DRAG, "per metre")
    push = flag("push", push)
    # An error names the first time without a state.
    march.motion(t)
    top_speed = march.speed_profile.fastest(t.min(), t.max()) if t.size else 0.0
    load = np.zeros(t.size, dtype=complex)
    return np.abs(guided_forces(march, t, drag * top_speed, load, push=push))


def guided_forces(
    march: March,
    times: Array,
    drag_rate: float,
    load: Complex,
    *,
    benches: int | None = None,
    push: bool = True,
) -> Complex:
    """Forces (T, M - 1) on benches 1 to M - 1 in their front holes, N, of M that are guided.

    `load` is the force (T,) on the next bench, which is free. With B = m C - P + load, where C is
    v' + c v of a centre and P the dancers' push, the force F in the front hole and R along the
    normal of the path in the rear hole have the sum B, and the torque d/2 u x (F + load - R).
    """
    dragon = march.dragon
    benches = dragon.benches if benches is None else benches
    motion = handle_motion(march, times, benches + 1)
    masses = dragon.masses[:benches]
    half = dragon.spacings[:benches] / 2
    along = (motion.points[:, :-1] - motion.points[:, 1:]) / (2 * half)
    # V' + c V of both holes of a bench, whose difference has the angular acceleration.
    holes = motion.accelerations + drag_rate * motion.velocities
    front = holes[:, :-1]
    rear = holes[:, 1:]
    inertia = masses * (front + rear) / 2
    torque = dragon.moments[:benches] * ((front - rear) / (2 * half * along)).imag
    if push:
        inertia -= masses * _pushed(motion.velocities, front, along, half) * along
        torque[:] = 0.0

    forces = np.empty((times.size, benches - 1), dtype=complex)
    normals = 1j * motion.tangents
    for i in range(benches - 1, 0, -1):
        total = inertia[:, i] + load
        lever = 1j * along[:, i]
        rail = dot(lever, total + load) - torque[:, i] / half[i]
        rail /= 2 * dot(lever, normals[:, i + 1])
        load = total - rail * normals[:, i + 1]
        forces[:, i - 1] = load
    return forces


def _pushed(velocities: Complex, front: Complex, along: Complex, half: Array) -> Array:
    """Rate of change (T, M) of the speeds of benches along themselves, with the drag, m/s^2."""
    spread = velocities[:, :-1] - velocities[:, 1:]
    spins = (spread / (2 * half * along)).imag
    return dot(along, front) + spins * dot(1j * along, velocities[:, :-1])
