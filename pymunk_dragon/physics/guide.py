"""The base class of guides, which hold benches on the path, and the guide "none"."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.march import March, States


class GuidedWorld(Protocol):
    """What a guide reads of the `World` to which it is attached; `World` explains it."""

    march: March
    masses: Array
    moments: Array
    substep: float
    drag_rate: float


class PathGuide:
    """Base class of guides, which hold benches on the path by joints, by forces, or by both.

    A subclass overrides what it needs; an instance of it is given to `simulate(guide=...)`.
    `GUIDES` in `assembly.py` holds those that have a name.

    Attributes
    ----------
    anchors : sequence of pymunk.Body
        Kinematic bodies at the other ends of the guide's joints; the world moves them, and keeps
        them in a space of their own, which is never stepped.
    balances_drag : bool
        Whether the guide's forces balance the ground drag, so that the head has to pull itself
        only.
    free_from : int, optional
        The first bench, from 1 on, that the guide does not hold on the path; it holds none of those
        behind either. By default it holds all benches. The run has this number too: reports, films
        and players compare a run with the exact model only where all benches are held.

    Examples
    --------
    Springs of 2 kN/m that pull the centre of each bench to a circle of 5 m radius about the origin;
    without them the chain is pulled straight:

    >>> import numpy as np
    >>> from pymunk_dragon import Arc, Dragon, March, simulate
    >>> class Springs(PathGuide):
    ...     def update(self, poses, hinge_velocity, anchors, forces):
    ...         distance = np.hypot(poses[:, 0], poses[:, 1])
    ...         forces[:, :2] = 2000 * (5 / distance - 1)[:, None] * poses[:, :2]
    >>> march = March(Dragon(benches=8), Arc(centre=(0, 0), radius=5, begin_angle=0, sweep=6))
    >>> runs = [simulate(march, guide=guide, until=10) for guide in (Springs(), "none")]
    >>> [round(run.max_drift, 1) for run in runs]
    [0.1, 6.4]
    """

    anchors: Sequence[pymunk.Body] = ()
    balances_drag = False
    free_from: int | None = None

    def attach(self, world: GuidedWorld) -> None:
        """Prepare for a run; called once, before everything else.

        The `march`, `masses` and `moments` of `world` stay; `substep` and `drag_rate` may change
        from step to step.
        """

    def joints(self, bench: int, body: pymunk.Body) -> Sequence[pymunk.Constraint]:
        """Joints between the body of `bench`, from 1 on, and the anchors; none by default.

        The world raises their `error_bias` to the power of the head's top speed, as that of its own
        joints.
        """
        return ()

    def relocate(self, states: States) -> None:
        """Take the exact `states`, of one time, from which the run begins or goes on.

        Called after `attach`.
        """

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """Write the anchors' positions and the forces for the next step; called before each.

        Parameters
        ----------
        poses : ndarray, shape (N, 3)
            Poses of the benches at which the joints are solved in this step: m, m, rad.
        hinge_velocity : ndarray, shape (2,)
            Velocity of the head's rear hole, m/s.
        anchors : ndarray, shape (A, 2)
            Output: positions of the anchors, m.
        forces : ndarray, shape (N, 3)
            Output: forces in N and torques in N m on the benches.
        """

    def joint_forces(self, poses: Array, velocities: Array, accelerations: Array) -> Array | None:
        """Forces (N - 1,) in the joints between the benches, N; None if only impulses tell them.

        `World.joint_forces` calls this method while the guide holds all benches, and no contact
        acts on them.

        Parameters
        ----------
        poses, velocities, accelerations : ndarray, shape (N, 3)
            Motion of the benches at the end of a step: m, m, rad, and per s and s^2.
        """
        return None


class NoGuide(PathGuide):
    """The guide "none": the head pulls, and the other benches have only their joints."""

    free_from = 1
