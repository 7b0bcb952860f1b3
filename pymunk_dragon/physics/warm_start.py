"""Impulses with which the joints of a chain are in balance before its first step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array

# Of each bench but the first: the pivot to the bench before, and pins to bodies with a position of
# their own.
_Joints = Sequence[tuple[pymunk.PivotJoint, Sequence[pymunk.PinJoint]]]

# kg: the impulse of a joint changes the velocity of such a body by less than the rounding of 1 m/s.
_HEAVY = 1e30

# Added to the diagonal of the equations, in units of its largest number, as joints of a guide may
# repeat each other.
_REGULARISATION = 1e-14


def _balanced_impulses(
    joints: _Joints, poses: Array, velocities: Array, inverse_masses: Array
) -> list[Array]:
    """Impulses that leave no relative velocity at the joints, N s: two at a pivot, one at a pin.

    `poses` (N, 3) and `velocities` (N, 3) without the joints are in m, m, rad and per s.
    `inverse_masses` (N, 3) are one over the mass, twice, and over the moment; zeros where the
    velocity is given. The joints of a bench share a body with those of its two neighbours only. So
    the equations are block-tridiagonal, and elimination takes a time that grows with N; the
    solver's sweeps need a time that grows with the cube of N.
    """
    diagonals = []
    uppers = []
    rights = []
    # The relative velocities at the joints of a bench are `own` times its velocity, plus `front`
    # times that of the bench before.
    own = np.zeros((0, 3))
    for bench, (pivot, pins) in enumerate(joints, start=1):
        pose = poses[bench]
        masses_before = inverse_masses[bench - 1]
        front = np.zeros((2 + len(pins), 3))
        front[:2] = -_anchor_rows(poses[bench - 1], pivot.anchor_a)
        uppers.append(own * masses_before @ front.T)

        pin_rows = [_pin_row(pose, pin) for pin in pins]
        own = np.vstack([_anchor_rows(pose, pivot.anchor_b), *pin_rows])
        diagonal = own * inverse_masses[bench] @ own.T + front * masses_before @ front.T
        regular = _REGULARISATION * diagonal.max() * np.eye(len(diagonal))
        diagonals.append(diagonal + regular)
        rights.append(-(own @ velocities[bench] + front @ velocities[bench - 1]))
    return _solved(diagonals, uppers[1:], rights)


def _solved(diagonals: list[Array], uppers: list[Array], rights: list[Array]) -> list[Array]:
    """Solution of a symmetric block-tridiagonal system."""
    for row, upper in enumerate(uppers):
        factor = np.linalg.solve(diagonals[row], upper).T
        diagonals[row + 1] -= factor @ upper
        rights[row + 1] -= factor @ rights[row]

    found: list[Any] = [np.linalg.solve(diagonals[-1], rights[-1])]
    for row in reversed(range(len(uppers))):
        right = rights[row] - uppers[row] @ found[-1]
        found.append(np.linalg.solve(diagonals[row], right))
    return found[::-1]


def _anchor_rows(pose: Array, anchor: tuple[float, float]) -> Array:
    """Velocity (2, 3) of an anchor of a body by the body's velocity."""
    arm = complex(*anchor) * np.exp(1j * pose[2])
    return np.array([[1.0, 0.0, -arm.imag], [0.0, 1.0, arm.real]])


def _pin_row(pose: Array, pin: pymunk.PinJoint) -> Array:
    """Rate (3,) at which a pin becomes longer, by the velocity of its first body, a bench."""
    rows = _anchor_rows(pose, pin.anchor_a)
    arm = complex(*pin.anchor_a) * np.exp(1j * pose[2])
    x = pin.b.position.x - pose[0] - arm.real
    y = pin.b.position.y - pose[1] - arm.imag
    return np.array([x, y]) / -math.hypot(x, y) @ rows


def set_impulses(
    space: pymunk.Space,
    substep: float,
    joints: _Joints,
    poses: Array,
    velocities: Array,
    inverse_masses: Array,
) -> None:
    """Give the joints the impulses in balance, with which the solver begins the next `substep`, s.

    Pymunk has no setter for them, so a step is made in which each joint may have the size of its
    impulse at most, its bodies have a velocity of 1 m/s in the impulse's direction, and they are so
    heavy that no impulse slows them. Afterwards the benches have their masses and `poses`, but
    still these velocities.
    """
    impulses = _balanced_impulses(joints, poses, velocities, inverse_masses)
    dynamic = [body for body in space.bodies if body.body_type == pymunk.Body.DYNAMIC]
    masses = [(body, body.mass, body.moment) for body in dynamic]
    limits = [(joint, joint.max_force) for joint in space.constraints]
    iterations = space.iterations
    damping = space.damping

    for body in dynamic:
        body.mass = _HEAVY
        body.moment = math.inf
    for joint, _ in limits:
        joint.max_force = 0.0
    _pull(substep, joints, poses, impulses)
    space.iterations = 1
    space.damping = 1.0
    space.step(substep)

    space.iterations = iterations
    space.damping = damping
    for body, mass, moment in masses:
        body.mass = mass
        body.moment = moment
    for joint, limit in limits:
        joint.max_force = limit
    for _, pins in joints:
        for pin in pins:
            pin.b.velocity = 0.0, 0.0


def _pull(substep: float, joints: _Joints, poses: Array, impulses: Sequence[Array]) -> None:
    """Give the bodies the velocities, and the joints the largest forces, that make `impulses`."""
    velocity: Array = np.zeros(2)
    _place(joints[0][0].a, poses[0], velocity, substep)
    for (pivot, pins), pose, given in zip(joints, poses[1:], impulses, strict=True):
        size = math.hypot(*given[:2])
        pivot.max_force = size / substep
        velocity = velocity - given[:2] / (size or 1.0)
        _place(pivot.b, pose, velocity, substep)
        for pin, impulse in zip(pins, given[2:], strict=True):
            pin.max_force = abs(impulse) / substep
            along = _pin_row(pose, pin)[:2] * math.copysign(1.0, impulse)
            pin.b.velocity = pymunk.Vec2d(*(velocity + along))


def _place(body: pymunk.Body, pose: Array, velocity: Array, substep: float) -> None:
    """Let a body arrive at a pose in the next step, without rotation."""
    body.position = pymunk.Vec2d(*(pose[:2] - substep * velocity))
    body.angle = pose[2]
    body.velocity = pymunk.Vec2d(*velocity)
    body.angular_velocity = 0.0
