"""Guides: path constraints for the benches (dancers on rails), or none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pymunk

from pymunk_dragon._arguments import Array, Complex, as_vectors
from pymunk_dragon.model.march import States

if TYPE_CHECKING:
    from pymunk_dragon.physics.world import World

# m, from a hole to the point that its rail is pinned to. Any length does; one metre needs no scaling of the normal.
_PIN_LENGTH = 1.0


class PathGuide:
    """Base class of guides, and the guide "none": without joints and forces.

    A guide constrains the benches to the path by joints, by forces, or by both. A subclass overrides what it needs; an
    instance of it is given to `simulate(guide=...)`. `GUIDES` holds those that have a name.

    Attributes
    ----------
    anchors : sequence of pymunk.Body
        Kinematic bodies at the other ends of the guide's joints; the world moves them, and keeps them in a space of
        their own, which is never stepped.
    balances_drag : bool
        Whether the guide's forces balance the ground drag, so that the head has to pull itself only.

    Examples
    --------
    Springs of 2 kN/m that pull the centre of each bench to a circle of 5 m radius about the origin; without them the
    chain is pulled straight:

    >>> import numpy as np
    >>> from pymunk_dragon import Arc, Dragon, March, simulate
    >>> class Springs(PathGuide):
    ...     def update(self, poses, hinge_velocity, anchors, forces):
    ...         distance = np.hypot(poses[:, 0], poses[:, 1])
    ...         forces[:, :2] = 2000 * (5 / distance - 1)[:, None] * poses[:, :2]
    >>> march = March(Dragon(benches=8), Arc(centre=(0, 0), radius=5, begin_angle=0, sweep=6))
    >>> [round(simulate(march, guide=guide, until=10).max_drift, 1) for guide in (Springs(), "none")]
    [0.1, 6.4]
    """

    anchors: Sequence[pymunk.Body] = ()
    balances_drag = False

    def attach(self, world: World) -> None:
        """Prepare for a run; called once, before everything else.

        The `march`, `masses` and `moments` of `world` stay; `substep` and `drag_rate` may change from step to step.
        """

    def joints(self, bench: int, body: pymunk.Body) -> Sequence[pymunk.Constraint]:
        """Joints between the body of `bench`, from 1 on, and the anchors; none by default.

        The world raises their `error_bias` to the power of the head's top speed, as that of its own joints.
        """
        return ()

    def relocate(self, states: States) -> None:
        """Take the exact `states` (one time) from which the run begins, or goes on; called after `attach`."""

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


class Rails(PathGuide):
    """Path constraints for all rear holes, with forces of dancers that balance the ground drag.

    A rail is a `PinJoint` from a bench's rear hole to an anchor one metre beside the path, on the normal through the
    hole's foot on the curve. So the hole can move only along the path. The anchor moves to the next normal before
    every step. The dancers' force along each bench, and their torque, balance the drag on it at the speed and the
    angular rate that follow from bench to bench, from the head on. The guide uses the path, the head's speed and the
    engine's positions, but no exact positions of the chain: these are for the engine to find.
    """

    balances_drag = True

    def attach(self, world: World) -> None:
        """Create the anchors."""
        self._world, self._curve, spacings = world, world.march.curve, world.march.dragon.spacings[1:]
        self.anchors = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in spacings]
        self._inertia = np.array([world.masses[1:], world.moments[1:]])
        self._over_spacings = 1 / spacings
        # From the rear hole to the centre, along the bench, m; complex, as NumPy converts real factors at every call.
        self._half = (spacings / 2).astype(complex)

    def relocate(self, states: States) -> None:
        """Take coordinates and speeds of the rear holes from `states`."""
        # They only identify the turn of the curve on which each hole is. A jackknifed bench pushes its hole back.
        self._rear_s = states.handles_s[0, 2:]
        self._rear_speeds = np.sum(states.velocities[0, 2:] * self._curve.tangent(self._rear_s), axis=-1)
        # That of the step before.
        self._last_motion: Array | None = None

    def joints(self, bench: int, body: pymunk.Body) -> Sequence[pymunk.Constraint]:
        """Pin from the rear hole to its anchor."""
        pin = pymunk.PinJoint(body, self.anchors[bench - 1], (-float(self._half[bench - 1].real), 0.0), (0.0, 0.0))
        pin.distance = _PIN_LENGTH
        return (pin,)

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """Write the anchors beside the holes, and the dancers' forces and torques."""
        substep = self._world.substep
        headings = np.empty(len(self.anchors), dtype=complex)
        np.cos(poses[1:, 2], out=headings.real)
        np.sin(poses[1:, 2], out=headings.imag)
        holes = _complex(poses[1:, :2]) - headings * self._half
        self._rear_s, feet, directions = self._curve.foot(as_vectors(holes), self._rear_s + self._rear_speeds * substep)
        tangents = _complex(directions)
        np.add(tangents * (_PIN_LENGTH * 1j), _complex(feet), out=_complex(anchors))
        motion = self._motion(complex(*hinge_velocity), headings, tangents)
        # What a bench gains, or loses to the drag, in this substep.
        last = motion if self._last_motion is None else self._last_motion
        change = motion - last * math.exp(-self._world.drag_rate * substep)
        push, torque = change * self._inertia / substep
        np.multiply(headings, push, out=_complex(forces[1:, :2]))
        forces[1:, 2] = torque
        self._last_motion = motion

    def _motion(self, hinge_velocity: complex, headings: Complex, tangents: Complex) -> Array:
        """Speeds of the benches along themselves, m/s, and their angular rates, rad/s, (2, N - 1).

        Each bench's front hole moves with the rear hole of the bench before, the first one's with the head's, and its
        rear hole moves along the path.
        """
        facing = headings.conj()
        front, rear = np.empty_like(facing), tangents * facing
        front[0] = hinge_velocity * facing[0]
        np.multiply(tangents[:-1], facing[1:], out=front[1:])
        # As `velocity_ratios`, times the head's speed.
        self._rear_speeds = np.multiply.accumulate(front.real / rear.real)
        front[1:] *= self._rear_speeds[:-1]
        return np.array([front.real, (front.imag - self._rear_speeds * rear.imag) * self._over_spacings])


# Guides that have a name, as in `simulate(guide=...)`.
GUIDES: dict[str, type[PathGuide]] = {"rails": Rails, "none": PathGuide}


def _complex(vectors: Array) -> Complex:
    """Vectors (N, 2) as complex numbers (N,), in the same memory: NumPy then calls once for both components."""
    return vectors.view(complex)[:, 0]
