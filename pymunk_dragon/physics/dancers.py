"""Dancers who let benches go and carry them back, and joints between benches that are cut."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import States
from pymunk_dragon.physics.guide import PathGuide

# Speed at which dancers who come back carry a bench, over the head's top speed.
_RETURN_SPEED = 4.0

# Per metre marched: rate at which a bench that is carried approaches its exact position.
_RETURN_RATE = 20.0

# Widths of a bench: the position error at which it is back.
_RETURNED = 0.1

# Largest force of the guide on a bench once dancers have let go, over the ground drag on it at the
# head's top speed, and largest torque over that of this force at 1 m. A bench that is off its path
# would get forces without limit.
_MAX_GUIDE_FORCE = 20.0


class Dancers:
    """Joints and forces of a guide, which hold each bench until its dancers let go.

    Parameters
    ----------
    guide : PathGuide
        The guide whose joints and forces these are.
    space : pymunk.Space
        The space of the benches.
    pivots : list of pymunk.PivotJoint
        The joints between benches, which the world adds later.
    dragon : Dragon
        The dragon, for the sizes and masses of its benches.
    top_speed : float
        Highest speed of the head, m/s.
    """

    def __init__(
        self,
        guide: PathGuide,
        space: pymunk.Space,
        pivots: list[pymunk.PivotJoint],
        dragon: Dragon,
        top_speed: float,
    ) -> None:
        self._guide = guide
        self._space = space
        self._pivots = pivots
        self._dragon = dragon
        self._top_speed = top_speed
        # The guide's joints of each bench, from bench 1 on.
        self.joints: list[Sequence[pymunk.Constraint]] = []
        # First bench whose dancers have let go; the number of benches if none have.
        self._released = dragon.benches
        self._return_joints: list[pymunk.PivotJoint] = []
        # First bench that the guide does not push.
        self._unpushed = dragon.benches
        # Largest forces of the guide on each bench (N, 1), N, and torques, N m; None for no limit.
        self._limits: Array | None = None

    @property
    def free_from(self) -> int | None:
        """First of the benches that nothing holds on the path; None if all are held."""
        first = min(self._released, self._guide.free_from or self._released)
        return first if first < self._dragon.benches else None

    @property
    def returning(self) -> bool:
        """Whether dancers carry benches back."""
        return bool(self._return_joints)

    @property
    def push_all(self) -> bool:
        """Whether the guide's forces act on all benches."""
        return not self.returning and self._unpushed == self._dragon.benches

    def pulled_mass(self) -> float:
        """Mass of the benches on which the head balances the ground drag, kg."""
        if self.returning or not self._guide.balances_drag:
            return math.fsum(self._dragon.masses)
        first = self.free_from or self._dragon.benches
        return math.fsum([self._dragon.masses[0], *self._dragon.masses[first:]])

    def limit(self, forces: Array) -> None:
        """Reduce the guide's `forces` (N, 3) to those that the dancers apply, N and N m."""
        if self._limits is not None:
            forces[self._unpushed :] = 0.0
            np.clip(np.nan_to_num(forces), -self._limits, self._limits, out=forces)

    def release(self, bench: int, drag: float) -> None:
        """Let go of `bench` and of all behind it; `drag` is the ground drag per metre marched."""
        self._stop_carrying()
        # Removed and added again, joints would be solved in another order, which converges more
        # slowly.
        for joint in chain.from_iterable(self.joints[bench - 1 :]):
            joint.max_force = 0.0
        self._released = min(bench, self._released)
        self._stop_pushing(self._released, drag)

    def cut(self, joint: int, drag: float) -> None:
        """Cut the joint behind bench number `joint`; dancers behind it no longer walk."""
        self._pivots[joint].max_force = 0.0
        self._stop_pushing(joint + 1, drag)

    def _stop_pushing(self, first: int, drag: float) -> None:
        """Push no bench from `first` on, and the others with limited forces."""
        self._unpushed = min(self._unpushed, first)
        self._limits = _MAX_GUIDE_FORCE * self._dragon.masses[:, None] * drag * self._top_speed**2

    def hold(self, bodies: Sequence[pymunk.Body]) -> None:
        """Begin to carry the benches that were let go, over all others, to their exact poses."""
        if self.returning or self._limits is None:
            return
        half = self._dragon.spacings / 2
        ground = self._space.static_body
        for bench, body in enumerate(bodies[self._released :], start=self._released):
            joint = pymunk.PivotJoint(ground, body, body.position, (-half[bench], 0.0))
            joint.max_bias = _RETURN_SPEED * self._top_speed
            joint.error_bias = math.exp(-_RETURN_RATE * self._top_speed)
            joint.max_force = float(self._limits[bench, 0])
            self._return_joints.append(joint)
        self._space.add(*self._return_joints)

    def carry(self, states: States, share: float, poses: Array, substep: float) -> bool:
        """Carry benches on to the exact `states`; whether all have arrived, and are held again.

        Parameters
        ----------
        states : States
            Exact states at one time, the end of the next step.
        share : float
            Share of its speed that the march has.
        poses : ndarray, shape (N, 3)
            Poses of the benches at the begin of the next step, m, m, rad.
        substep : float
            Length of the next step, s.
        """
        first = self._released + 1
        # A joint follows a moving target with a delay of this time, so its target is as far ahead:
        # otherwise it would brake the chain, whose tension would tear it apart when these joints
        # are removed.
        delay = substep / (1 - math.exp(-_RETURN_RATE * self._top_speed * substep))
        velocities = states.velocities[0, first:]
        targets = states.positions[0, first:] + delay * share * velocities
        for pivot, (x, y) in zip(self._return_joints, targets.tolist(), strict=True):
            pivot.anchor_a = x, y

        # Exact poses at the begin of the step, in which benches may go further than the bound.
        exact = states.poses[0] - substep * share * states.pose_velocities[0]
        x, y = (poses[:, :2] - exact[:, :2]).T
        arrived = np.hypot(x, y).max() < _RETURNED * self._dragon.widths.min()
        if arrived:
            self._guide_again(states)
        return bool(arrived)

    def _guide_again(self, states: States) -> None:
        """Have the guide hold all benches again from the exact `states` on."""
        self._stop_carrying()
        self._guide.relocate(states)
        for joint in chain.from_iterable(self.joints[self._released - 1 :]):
            joint.max_force = math.inf
        self._released = self._dragon.benches
        cuts = [number for number, pivot in enumerate(self._pivots) if pivot.max_force == 0]
        self._unpushed = cuts[0] + 1 if cuts else self._dragon.benches

    def _stop_carrying(self) -> None:
        self._space.remove(*self._return_joints)
        self._return_joints.clear()
