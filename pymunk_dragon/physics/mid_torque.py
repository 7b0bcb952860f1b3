"""Torques that give the forces of joints the lever arms that benches have during a step."""

from __future__ import annotations

import math

import numpy as np

from pymunk_dragon._arrays import Array, as_complex
from pymunk_dragon.model.dragon import Dragon, headings

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
    two torques, for the forces of the step before, is of first order in the step. Given as a torque
    from outside, it leaves an error of second order.

    Parameters
    ----------
    dragon : Dragon
        The dragon, for the distances between the holes.
    masses : ndarray, shape (N,)
        Masses of the benches, kg.
    """

    def __init__(self, dragon: Dragon, masses: Array) -> None:
        self._half = dragon.spacings / 2
        self._masses = masses
        # N: force in the joint before each bench in the last step; none is behind the last bench.
        self._forces = np.zeros(len(masses) + 1, dtype=complex)

    def after_step(self, gains: Array, pushes: Array) -> None:
        """Take the forces in the joints from a step.

        Parameters
        ----------
        gains : ndarray, shape (N, 2)
            Velocities of the centres after the step, less what the drag has left of those before,
            over its length, m/s^2.
        pushes : ndarray, shape (N, 2)
            Forces from outside in the step, N.
        """
        changes = self._masses * as_complex(gains) - as_complex(pushes)
        self._forces[:-1] = changes[::-1].cumsum()[::-1]

    def torques(self, first: int, poses: Array, coming: Array, decay: float) -> Array:
        """Torques on the benches from number `first` on for the next step, N m.

        Parameters
        ----------
        first : int
            Number of the first bench.
        poses, coming : ndarray, shape (N, 3)
            Poses of the benches before and after the step, m, m, rad.
        decay : float
            Drag times the length of the step.
        """
        turns = coming[first:, 2] - poses[first:, 2]
        both = self._forces[first:-1] + self._forces[first + 1 :]
        tensions = (headings(coming[first:]).conj() * both).real
        torques: Array = mean_age(decay) * self._half[first:] * turns * tensions
        return torques
