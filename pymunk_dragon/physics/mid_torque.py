"""Torques that give the forces of joints the lever arms that benches have during a step."""

from __future__ import annotations

import math

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.dragon import Dragon

# Largest product of drag and step for which the first terms of the series of `mean_age` are exact:
# those that are left out are a thousandth of its cube. The closed form loses digits there.
_SMALL = 1e-4


def mean_age(decay: float) -> float:
    """Time from the moment at which a step's force acts on average to the step's end, in steps.

    What a force adds to a velocity decays until then, by the factor exp(-`decay`) in a whole step.

    Examples
    --------
    >>> round(mean_age(1e-9), 6), round(mean_age(0.23), 6)
    (0.5, 0.48085)
    """
    if decay < _SMALL:
        return 1 / 2 - decay / 12
    return 1 / decay + math.exp(-decay) / math.expm1(-decay)


class MidTorque:
    """Forces in the joints of a chain, and torques that make them act with their mean lever arms.

    Within a step, the force in a joint adds to the momentum of a bench, and the drag reduces what
    was added, so a step of Pymunk is exact for the momentum: its impulse is a weighted mean of the
    force. But Pymunk takes the lever arm of the impulse from the heading at the step's end. The
    force acts with the heading at its mean time, `mean_age` before the end. The difference of the
    two torques, for the forces of the step before, is of first order in the step: the force along
    the bench times half the distance of the holes times the turn from then on. Given as a torque
    from outside, it leaves an error of second order.

    Parameters
    ----------
    dragon : Dragon
        The dragon, for the distances between the holes and the masses.
    """

    def __init__(self, dragon: Dragon) -> None:
        self._half = dragon.spacings / 2
        self._masses = dragon.masses[:, None]
        # N: force in the joint before each bench in the last step; none is behind the last bench.
        self._forces = np.zeros((dragon.handles, 2))

    def before_step(
        self,
        forces: Array,
        first: int,
        velocities: Array,
        coming: Array,
        turns: Array,
        substep: float,
        decay: float,
    ) -> None:
        """Change the `forces` from outside on the benches from number `first` on for a step.

        Parameters
        ----------
        forces : ndarray, shape (N, 3)
            Forces and torques on the benches, N and N m. They act during the step too, so Pymunk,
            which adds them at its end, gets what the drag leaves of them.
        first : int
            Number of the first bench.
        velocities : ndarray, shape (N, 3)
            Velocities before the step, m/s, m/s, rad/s.
        coming : ndarray, shape (N, 3)
            Poses of the benches after the step, m, m, rad.
        turns : ndarray, shape (N,)
            Change of the angles in the step, rad.
        substep : float
            Length of the step, s.
        decay : float
            Drag times the length of the step.
        """
        forces[first:] *= -math.expm1(-decay) / decay
        self._substep = substep
        self._kept = math.exp(-decay) * velocities[:, :2]

        x, y = (self._forces[first:-1] + self._forces[first + 1 :]).T
        angles = coming[first:, 2]
        tensions = np.cos(angles) * x + np.sin(angles) * y
        forces[first:, 2] += mean_age(decay) * self._half[first:] * turns[first:] * tensions

    def after_step(self, velocities: Array, forces: Array) -> None:
        """Take the forces in the joints from the step.

        Parameters
        ----------
        velocities : ndarray, shape (N, 3)
            Velocities after the step, m/s, m/s, rad/s.
        forces : ndarray, shape (N, 3)
            The forces from outside that `before_step` has left.
        """
        gained = self._masses / self._substep * (velocities[:, :2] - self._kept)
        changes = gained - forces[:, :2]
        np.cumsum(changes[::-1], axis=0, out=self._forces[-2::-1])
