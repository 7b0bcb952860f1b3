"""The guide "rails": dancers keep every hole on the path."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array, Complex, as_complex, as_vectors
from pymunk_dragon.model.dragon import headings
from pymunk_dragon.model.march import States
from pymunk_dragon.physics.guide import GuidedWorld, PathGuide

# m: distance from a hole to the point that its rail is pinned to. Any length does; one metre needs
# no scaling of the normal.
_PIN_LENGTH = 1.0


class Rails(PathGuide):
    """Path constraints for all rear holes, with forces of dancers that balance the ground drag.

    A rail is a `PinJoint` from a bench's rear hole to an anchor one metre beside the path, on the
    normal through the hole's foot on the curve. So the hole can move only along the path. The
    anchor moves to the next normal before every step. The dancers' force along each bench, and
    their torque, balance the drag on it at the speed and the angular rate that follow from bench to
    bench, from the head on. The guide uses the path, the head's speed and the engine's positions,
    but no exact positions of the chain: these are for the engine to find.
    """

    balances_drag = True

    def attach(self, world: GuidedWorld) -> None:
        """Create the anchors."""
        self._world = world
        self._curve = world.march.curve
        spacings = world.march.dragon.spacings[1:]
        self.anchors = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in spacings]
        self._inertia = np.array([world.masses[1:], world.moments[1:]])
        self._over_spacings = 1 / spacings
        # From the rear hole to the centre, along the bench, m.
        self._half = spacings / 2

    def relocate(self, states: States) -> None:
        """Take coordinates and speeds of the rear holes from `states`."""
        # The coordinates only identify the turn of the curve on which each hole is. A jackknifed
        # bench pushes its hole back.
        self._rear_s = states.handles_s[0, 2:]
        tangents = self._curve.tangent(self._rear_s)
        self._rear_speeds = np.sum(states.velocities[0, 2:] * tangents, axis=-1)
        # Motion of the benches in the step before.
        self._last_motion: Array | None = None

    def joints(self, bench: int, body: pymunk.Body) -> Sequence[pymunk.Constraint]:
        """Pin from the rear hole to its anchor."""
        hole = -float(self._half[bench - 1])
        pin = pymunk.PinJoint(body, self.anchors[bench - 1], (hole, 0.0), (0.0, 0.0))
        pin.distance = _PIN_LENGTH
        return (pin,)

    def update(self, poses: Array, hinge_velocity: Array, anchors: Array, forces: Array) -> None:
        """Write the anchors beside the holes, and the dancers' forces and torques."""
        substep = self._world.substep

        along = headings(poses[1:])
        holes = as_complex(poses[1:, :2]) - along * self._half

        expected = self._rear_s + self._rear_speeds * substep
        self._rear_s, feet, directions = self._curve.foot(as_vectors(holes), expected)
        tangents = as_complex(directions)
        self._tangents = tangents
        anchors[:] = as_vectors(as_complex(feet) + tangents * (_PIN_LENGTH * 1j))

        motion = self._motion(complex(*hinge_velocity), along, tangents)
        # What a bench gains, or loses to the drag, in this substep.
        last = motion if self._last_motion is None else self._last_motion
        kept = math.exp(-self._world.drag_rate * substep)
        change = motion - last * kept
        push, torque = change * self._inertia / substep
        forces[1:, :2] = as_vectors(along * push)
        forces[1:, 2] = torque
        self._last_motion = motion

    def joint_forces(self, poses: Array, velocities: Array, accelerations: Array) -> Array:
        """Forces (N - 1,) in the joints that the benches' motion needs, N.

        From the tail to the head, each bench has three equations of motion for three unknowns: the
        force in the joint before it, and the size of the rail's force at its rear hole. Dancers
        change its speed along itself and its angular rate, and make up for the drag on both. The
        other forces change its velocity across itself, and turn that along it.

        Impulses show less. Within a step of Pymunk the drag reduces the velocities of the step
        before, which have another direction than the dancers' push, so joints and rails give
        exp(-x) of the change of direction only, x = drag rate times substep: 20.5 % less at the
        default settings. Rails at their places at the end of the step, and ten iterations, change
        that to 15 to 22 %. These forces are right to 0.01 % of the largest.
        """
        along = headings(poses[1:])
        facing = along.conj()
        drifts = (as_complex(velocities[1:, :2]) * facing).imag
        gains = (as_complex(accelerations[1:, :2]) * facing).imag
        masses = self._inertia[0]
        # What the joints and the rail give to each bench, along it and across it.
        needs = -masses * velocities[1:, 2] * drifts
        across = masses * (gains + self._world.drag_rate * drifts)
        # It has no torque about the centre. So the force in the joint before it has half of that
        # across the bench, and the rail has what the joint behind it leaves of the other half.
        rails = self._tangents * facing
        slopes = -rails.imag / rails.real
        turns = along[1:] * facing[:-1]
        behind = 0.5j * across[1:] * turns
        needs -= slopes * across / 2
        needs[:-1] += behind.real - slopes[:-1] * behind.imag
        kept = turns.real - slopes[:-1] * turns.imag

        # From the tail on: the force along each bench in the joint before it.
        force = 0.0
        found = []
        for need, share in zip(needs[::-1].tolist(), [0.0, *kept[::-1].tolist()], strict=True):
            force = need + share * force
            found.append(force)
        return np.asarray(np.hypot(found[::-1], across / 2))

    def _motion(self, hinge_velocity: complex, along: Complex, tangents: Complex) -> Array:
        """Speeds of the benches along themselves, m/s, and their angular rates, rad/s, (2, N - 1).

        Each bench's front hole moves with the rear hole of the bench before, the first one's with
        the head's, and its rear hole moves along the path.
        """
        facing = along.conj()
        rear = tangents * facing
        front = np.append(hinge_velocity, tangents[:-1]) * facing
        # The `velocity_ratios` of the chain, times the head's speed.
        self._rear_speeds = np.cumprod(front.real / rear.real)
        front[1:] *= self._rear_speeds[:-1]
        across = front.imag - self._rear_speeds * rear.imag
        return np.array([front.real, across * self._over_spacings])
